"""The skin on a geom of MuJoCo: its contacts become pressures, and its sensors read them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from .. import _check
from .._check import FloatArray
from .._frozen import Frozen
from .._shown import Drawing
from ..contact import PointLoad
from ..errors import GeometryError, InvalidValueError
from ..finger import Finger, finger_needed
from ..prepared import Prepared, prepared
from ._kernel import contacts_of, read_points
from .footing import clipped, footing_of
from .pressed import Outline, PressedFeet, principal
from .surface import GeomSurface, surface_of

if TYPE_CHECKING:
    import mujoco

__all__ = ["Felt", "GeomSkin", "contact_to_skin"]

_SKINS = Prepared()
"""The skins that `contact_to_skin` was asked for last."""
_FACING = 0.25
"""Share of a contact's force along the skin's normal, below which the contact is beside the skin."""
_STILL, _TURNED = 5e-6, 1e-3
"""By how much a body may move [m] and turn [rad] until its footing is asked for again."""
_STEP, _FEWEST, _MOST = 0.25, 4, 40_000
"""Step of the lattice in depths of the shallowest sensor; fewest nodes of a side; most of all."""


@dataclass(frozen=True, eq=False)
class GeomTouch(Frozen):
    """What one geom does to a skin.

    Attributes
    ----------
    geom : int
        Its number.
    force : ndarray, shape (3,)
        N, Ty, Tz on the skin [N].
    moment : ndarray, shape (3,)
        About x, y and z through the origin of the skin's surface [N m].
    points : ndarray, shape (m, 2)
        Points (y, z) of the surface [m].
    forces : ndarray, shape (m, 3)
        Forces there, inwards and along y and z [N].
    """

    geom: int
    force: FloatArray
    moment: FloatArray
    points: FloatArray
    forces: FloatArray


@dataclass(frozen=True, eq=False)
class Felt(Frozen):
    """What a skin feels at one moment.

    Attributes
    ----------
    skin : GeomSkin
        Whose.
    touches : tuple of GeomTouch
        One for each geom that presses.
    beside : ndarray, shape (3,)
        Force of contacts that do not press on the skin, but on a side of its geom, in the skin's axes [N].
    """

    skin: GeomSkin
    touches: tuple[GeomTouch, ...]
    beside: FloatArray

    plot = Drawing("felt_figure")

    @property
    def force(self) -> FloatArray:
        """N, Ty, Tz of all touches [N], shape (3,)."""
        return np.sum([touch.force for touch in self.touches], axis=0) if self.touches else np.zeros(3)

    @property
    def moment(self) -> FloatArray:
        """About x, y and z through the origin of the surface [N m], shape (3,)."""
        return np.sum([touch.moment for touch in self.touches], axis=0) if self.touches else np.zeros(3)

    @property
    def torsion(self) -> float:
        """Moment about the inward normal through the centre of pressure [N m]."""
        (n, along, across), (turning, z, y) = self.force, self.moment
        return float(turning + (y * across + z * along) / n) if n > 0 else 0.0

    @property
    def points(self) -> FloatArray:
        """Points (y, z) of the surface at which forces act [m], shape (m, 2)."""
        return np.concatenate([np.zeros((0, 2)), *(touch.points for touch in self.touches)])

    @property
    def forces(self) -> FloatArray:
        """Forces there, inwards and along y and z [N], shape (m, 3)."""
        return np.concatenate([np.zeros((0, 3)), *(touch.forces for touch in self.touches)])

    def read(self, rng: np.random.Generator | None = None) -> FloatArray:
        """Readings of the finger's sensors, shape (n,).

        Parameters
        ----------
        rng : numpy.random.Generator, optional
            Adds each sensor's noise.
        """
        return self.skin.read(self.points, self.forces, rng)


class GeomSkin:
    """The skin on a face of a geom, prepared once, then called on the state of each step.

    Each geom that touches is a body of its own: what it does in all of MuJoCo's contact points together, force and
    moment, is spread as `press` spreads it beneath the two bodies' shapes (docs/mujoco.md). Drags are spread as the
    pressure, torsion as pressure times the distance.

    Parameters
    ----------
    model : mujoco.MjModel
        The compiled model.
    geom : str or int
        The geom with the skin: a box, a sphere, a capsule or a cylinder. Its surface is that of the skin.
    finger : Finger
        Skin and sensors. A `HalfSpace` or `Layered` skin; y and z count from the middle of the face.
    face : {"+x", "-x", "+y", "-y", "+z", "-z"}, optional
        Where the skin's outward normal points, in the geom's axes. z of the skin is the geom's z (on a face +-z its y).
    edge_radius : float, optional
        Of edges and corners of what touches, which are sharp in MuJoCo [m], > 0.

    Raises
    ------
    InvalidValueError, GeometryError
        No such geom; a type of geom that takes no skin; a finger that is solved in a plane; too large a face.
    ModuleNotFoundError
        MuJoCo is not installed: pip install "subskin[mujoco]".

    Examples
    --------
    >>> import mujoco, numpy as np, subskin as ss
    >>> xml = '''<mujoco><worldbody><geom name="pad" type="box" size=".01 .01 .005"/>
    ... <body pos="0 0 .0249"><freejoint/><geom name="ball" type="sphere" size=".02" mass=".1"/></body>
    ... </worldbody></mujoco>'''
    >>> model = mujoco.MjModel.from_xml_string(xml)
    >>> data = mujoco.MjData(model)
    >>> mujoco.mj_step(model, data, 2000)
    >>> array = ss.SensorArray.grid(shape=(4, 4), pitch=4e-3, depth=2.5e-3, noise=2e-4)
    >>> skin = GeomSkin(model, "pad", ss.Finger(ss.HalfSpace(ss.Material(young=0.4e6)), array), "+z")
    >>> felt = skin.feel(data)
    >>> felt.force.round(3).tolist(), felt.read().shape
    ([0.981, 0.0, 0.0], (16,))
    """

    def __init__(
        self, model: mujoco.MjModel, geom: str | int, finger: Finger, face: str = "+x", *, edge_radius: float = 0.5e-3
    ) -> None:
        finger_needed(finger)
        if not finger.skin.takes_local:
            seen, rule = f"a finger of {finger.skin}", "it is solved in a plane; contacts of MuJoCo end on all sides"
            raise GeometryError(seen, rule, "HalfSpace(material), or Layered(...); a row of sensors may lie in it")
        self.model, self.finger = model, finger
        self._elliptic = int(model.opt.cone) == 1
        self.geom = _number(model, geom)
        self.edge_radius = _check.scalar("edge_radius", edge_radius, unit="m", above=0.0)
        self.surface: GeomSurface = surface_of(model, self.geom, face)
        self._footings: dict[int, tuple[FloatArray, FloatArray, tuple[Any, ...]]] = {}
        half = self.surface.half
        known = prepared(finger)
        self._feet = known.get(("feet",), lambda: PressedFeet(finger.skin, float(np.asarray(finger.array.depth).min())))
        self._lattice = known.get(("lattice", *half), lambda: _lattice(finger, half)) if _is_linear(finger) else None
        nodes = (1, 1) if self._lattice is None else self._lattice[2].shape[:2]
        self._scratch = np.zeros((*nodes, 3)), np.empty((2, 4))

    def feel(self, data: mujoco.MjData, *, pressed: bool = True) -> Felt:
        """What the skin feels in the state `data`, after `mj_step` or `mj_forward`.

        Parameters
        ----------
        data : mujoco.MjData
            The state.
        pressed : bool, optional
            Spread forces as pressures; without it only `force` and `moment` are known, and there are no points.
        """
        contact, beside = data.contact, np.zeros(3)
        centre, turn = data.geom_xpos[self.geom], data.geom_xmat[self.geom]
        others, found = np.empty(data.ncon, np.int64), np.empty((data.ncon + 1, 3, 3))
        parts = contact.geom, contact.pos, contact.frame, contact.dim, contact.efc_address, contact.friction
        count = contacts_of(self.geom, self._elliptic, parts, data.efc_force, (centre, turn), others, found)
        turn, touches = turn.reshape(3, 3), []
        for geom in dict.fromkeys(others[:count].tolist()):
            mine = found[:count][others[:count] == geom]
            force, twist, at = mine[:, 0], mine[:, 1], mine[:, 2]
            weights = np.sqrt((force * force).sum(axis=1))
            total = weights.sum()
            if total == 0.0:
                continue
            origin, axes, position = self.surface.frame(weights @ at / total)
            facing = force @ axes[0] >= _FACING * weights
            if not facing.all():
                beside += axes @ force[~facing].sum(axis=0)
                force, twist, at = force[facing], twist[facing], at[facing]
            summed = axes @ force.sum(axis=0)
            if summed[0] <= 0:
                beside += summed
                continue
            turning = (at - origin).T @ force  # of r by f: its odd part is the moment
            odd = turning - turning.T
            moment = axes @ (np.array([odd[1, 2], odd[2, 0], odd[0, 1]]) + twist.sum(axis=0))
            if not pressed:
                touches.append(
                    GeomTouch(geom, summed, moment + _moved(summed, position), np.zeros((0, 2)), np.zeros((0, 3)))
                )
                continue
            touches.append(self._touch(data, geom, origin, axes, position, summed, moment, turn, centre))
        return Felt(self, tuple(touches), beside)

    def read(self, points: FloatArray, forces: FloatArray, rng: np.random.Generator | None = None) -> FloatArray:
        """Readings under forces at points of the surface, shape (n,).

        Parameters
        ----------
        points : ndarray, shape (m, 2)
            Points (y, z) [m].
        forces : ndarray, shape (m, 3)
            Inwards and along y and z [N].
        rng : numpy.random.Generator, optional
            Adds each sensor's noise.
        """
        array = self.finger.array
        if self._lattice is None:
            if not len(points):
                return array.digitise(np.zeros(len(array)), rng)
            return self.finger.read(PointLoad(components=forces, position=points), rng, sum_over=0)
        measured = np.zeros(len(array))
        read_points(points, forces, *self._lattice, *self._scratch, measured)
        return array.digitise(measured, rng, forces[:, 0].sum())

    def _touch(
        self, data: Any, geom: int, origin: FloatArray, axes: FloatArray, position: FloatArray, force: FloatArray,
        moment: FloatArray, turn: FloatArray, centre: FloatArray,
    ) -> GeomTouch:  # fmt: skip
        """The pressure of one geom, by its wrench about `origin` in local `axes`, the rows."""
        pose = axes @ turn.T @ data.geom_xmat[geom].reshape(3, 3)
        offset = axes @ (turn.T @ (data.geom_xpos[geom] - centre) - origin)
        middle, along, curvature, outline = self._footing(geom, pose, offset, position)
        normal = force[0]
        at = np.array([-moment[2], moment[1]]) / normal
        points, share = self._feet.of(curvature, outline, normal, along @ (at - middle))
        points = middle + points @ along
        forces = share[:, None] * force
        turning = moment[0] - (at[0] * force[2] - at[1] * force[1])
        if turning != 0.0:
            y, z = (points - at).T
            turned = turning / (share @ (y * y + z * z)) * share
            forces[:, 1] -= turned * z
            forces[:, 2] += turned * y
        return GeomTouch(geom, force, moment + _moved(force, position), position + points, forces)

    def _footing(
        self, geom: int, pose: FloatArray, offset: FloatArray, position: FloatArray
    ) -> tuple[FloatArray, FloatArray, FloatArray, Outline]:
        """Middle, principal axes (rows), curvatures and outline of a geom's footing; kept while it hardly moves."""
        kept = self._footings.get(geom)
        if kept is not None and np.abs(kept[0] - pose).max() < _TURNED and np.abs(kept[1] - offset).max() < _STILL:
            return kept[2]
        found = footing_of(self.model, geom, pose, offset, self.edge_radius)
        curvature = found.curvature + self.surface.curvature
        own = self.surface.outline - position
        outline = own if found.outline is None else clipped(found.outline, own)
        if len(outline) < 3:  # a corner of the one on a corner of the other
            outline = 0.1 * self.edge_radius * np.sign(own)
        result = principal(curvature, outline)
        self._footings[geom] = (pose, offset, result)
        return result


def contact_to_skin(
    model: mujoco.MjModel, data: mujoco.MjData, geom: str | int, finger: Finger, face: str = "+x"
) -> Felt:
    """What the skin on a geom feels in the state `data`: pressures, forces, and readings of any finger's sensors.

    The skin is prepared when it is first asked for, and kept; `GeomSkin` is the same without the search for it.

    Parameters
    ----------
    model, data : mujoco.MjModel, mujoco.MjData
        The compiled model, and its state after `mj_step` or `mj_forward`.
    geom, finger, face
        As in `GeomSkin`.

    Returns
    -------
    Felt
        `read(rng)` gives a frame of readings.

    Raises
    ------
    InvalidValueError, GeometryError, ModuleNotFoundError
        As in `GeomSkin`.

    Examples
    --------
    >>> import mujoco, subskin as ss
    >>> xml = '''<mujoco><worldbody><geom name="pad" type="box" size=".01 .01 .005"/>
    ... <body pos="0 0 .0249"><freejoint/><geom type="sphere" size=".02" mass=".1"/></body></worldbody></mujoco>'''
    >>> model = mujoco.MjModel.from_xml_string(xml)
    >>> data = mujoco.MjData(model)
    >>> mujoco.mj_step(model, data, 2000)
    >>> array = ss.SensorArray.grid(shape=(4, 4), pitch=4e-3, depth=2.5e-3)
    >>> finger = ss.Finger(ss.HalfSpace(ss.Material(young=0.4e6)), array)
    >>> contact_to_skin(model, data, "pad", finger, "+z").force.round(3).tolist()
    [0.981, 0.0, 0.0]
    """
    finger_needed(finger)
    # what is kept holds its model and its finger, so their numbers stay theirs
    key = id(model), geom, id(finger), face
    return _SKINS.get(key, lambda: GeomSkin(model, geom, finger, face)).feel(data)


def _moved(force: FloatArray, position: FloatArray) -> FloatArray:
    """Moment about the origin of a force at a position."""
    y, z = position
    return np.array([y * force[2] - z * force[1], z * force[0], -y * force[0]])


def _number(model: Any, geom: str | int) -> int:
    """The number of a geom by its name."""
    if isinstance(geom, str):
        names = [model.geom(i).name for i in range(model.ngeom)]
        if geom not in names:
            known = ", ".join(map(repr, filter(None, names))) or "none has a name"
            raise InvalidValueError(f"geom {geom!r}", f"the model's geoms: {known}", 'name="pad" in the MJCF')
        return names.index(geom)
    return _check.whole("geom", geom, at_least=0, at_most=model.ngeom - 1, fix="geom=0")


def _is_linear(finger: Finger) -> bool:
    return all(kind.linear for kind in finger.array.transducers)


def _lattice(finger: Finger, half: FloatArray) -> tuple[FloatArray, float, FloatArray]:
    """Origin, step, and what sensors measure of unit forces at the nodes, shape (j, k, 3, n), over the whole skin."""
    step = _STEP * float(np.asarray(finger.array.depth).min())
    count = np.maximum(np.ceil(2 * half / step).astype(int) + 3, _FEWEST)
    if count.prod() > _MOST:
        sides = " x ".join(f"{2e3 * each:.4g}" for each in half)
        rule = f"a face of at most {_MOST} steps of {1e3 * step:.3g} mm, {_STEP:g} depths of the shallowest sensor"
        raise GeometryError(f"a face of {sides} mm", rule, "a geom of the size of the skin, or several of them")
    origin = -0.5 * step * (count - 1)
    at = np.stack(
        np.meshgrid(*(o + step * np.arange(n) for o, n in zip(origin, count, strict=True)), indexing="ij"), -1
    )
    if finger.measured is None:
        units = PointLoad(components=np.eye(3), position=at[..., None, :])
        return origin, step, np.ascontiguousarray(finger.measure(units))
    known = np.moveaxis(finger.measured(at), -1, -2) / np.asarray(finger.array.gain)
    response = np.zeros((*count, 3, len(finger.array)))
    response[..., : known.shape[-2], :] = known
    return origin, step, response
