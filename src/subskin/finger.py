"""The finger: a skin with sensors in it. The only forward model; all estimation and design rides on it."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import TYPE_CHECKING, ClassVar, Literal, NamedTuple

import numpy as np
import numpy.typing as npt

from . import _check
from ._check import FloatArray
from ._declared import Noun
from ._shown import Drawing, Tabled, many_of, span
from ._verb import Verb
from .array import SensorArray
from .contact import Contact, LineLoad, LocalContact, PointLoad
from .errors import GeometryError, InvalidValueError
from .material import Material
from .measured import MeasuredResponse
from .skin.base import Skin
from .spread import Spread
from .tensor import State
from .tolerances import Tolerances
from .transducer import Transducer

if TYPE_CHECKING:
    from .design.blind_spots import blind_spots as _blind_spots
    from .estimate.area.observable import observable as _observable
    from .estimate.locate import fit as _fit
    from .estimate.locate import locate as _locate
    from .estimate.locate import locator as _locator
    from .estimate.resultants.resultant import resultant as _resultant
    from .reader import reader as _reader
    from .response import tabulate as _tabulate

__all__ = ["Finger"]

LARGEST = 0.5  # m, of a skin's depth and of half a row
DEEPEST = 0.1  # m, of sensors in metres for certain
_LONGEST = 1000.0  # depths, half a row that is meant
SOFTEST = 50.0  # Pa, softer than any gel that keeps its shape
_UNIT_LOADS = LineLoad.of_components(np.eye(2)[:, None, None])  # on a sensor and its nodes
_WIDEST = 1e5  # depths, a row that no search could go through
_FAR = 100.0  # depths, from which nothing is felt


@lru_cache(maxsize=64)
def _gauss(count: int) -> tuple[FloatArray, FloatArray]:
    """Nodes and weights on (-1, 1): a calibration makes hundreds of fingers of the same few sensors."""
    return np.polynomial.legendre.leggauss(count)


class _Group(NamedTuple):
    """Sensors of one transducer and one number of averaging nodes, evaluated together."""

    transducer: Transducer
    sensors: list[int] | slice
    felt: Callable[[Contact | LocalContact], State]  # at k sensors and their nodes, (k, nodes)
    weights: FloatArray  # (nodes,)


def _is_foreign(one: object) -> bool:
    """Whether its class is somebody else's, of which what it gives has to be checked."""
    return not type(one).__module__.startswith(f"{__package__}.")


def finger_needed(finger: object) -> None:
    """Refuse what is no finger where one comes first."""
    if not isinstance(finger, Finger):  # asked at every frame of a live loop
        _check.noun("finger", finger, Finger, Finger.EXAMPLE)


@dataclass(frozen=True, eq=False, repr=False)
class Finger(Tabled, Noun):
    """A skin and the sensors in it.

    Parameters
    ----------
    skin : Skin
        The medium, e.g. `HalfPlane`.
    array : SensorArray
        The sensors.
    spread : Spread, optional
        How much larger than those of independent noise the standard errors are of what estimators find, along the row.
        `calibrate` measures it on touches held out; without it they are those of independent noise.
    trusted : bool, optional
        Whether the model is that of the skin. No frame of a finger that is not trusted is OK.
    measured : MeasuredResponse, optional
        On an area, the response in place that touches gave, with its doubt: `locate` goes by it. `calibrate` makes it
        where the skin's own field leaves more than noise.
    relative : bool, optional
        Whether its forces are multiples of the load of the touches it was calibrated on, which nobody measured, and no
        newtons. `calibrate` says so where it is given no force.
    tolerances : Tolerances, optional
        How far the finger may be from its drawing. `locate` and `resultant` count it with the noise
        (docs/real_fingers.md); other estimators do not. Without it the finger is exact.

    Raises
    ------
    InvalidValueError, GeometryError
        A skin that is no Skin, an array that is no SensorArray; a spread that is no Spread; a sensor that lies beneath
        the skin.

    Warns
    -----
    ValidityWarning
        A depth or a position of a sensor of more than 0.5 m, a modulus below 50 Pa: another unit was probably meant.
        Where neither lengths nor moduli are of a finger's size, no warning comes: the units are your own.

    Examples
    --------
    >>> import subskin as ss
    >>> skin = ss.HalfPlane(ss.Material(young=0.4e6))
    >>> finger = ss.Finger(skin, ss.SensorArray.line(count=4, pitch=2e-3, depth=2e-3, noise=1e-4))
    >>> finger.read(ss.LineLoad(force=40.0, position=0.5e-3)).round(4).tolist()
    [0.003, -0.0043, -0.0198, 0.002]
    >>> finger.receptive_field([0.0, 0.5e-3]).shape  # positions, sensors, normal and tangential
    (2, 4, 2)
    """

    EXAMPLE: ClassVar = 'Finger(skin, array), or load("finger.toml").finger'

    skin: Skin
    array: SensorArray
    spread: Spread | None = None
    trusted: bool = True
    measured: MeasuredResponse | None = None
    relative: bool = False
    tolerances: Tolerances | None = None

    if TYPE_CHECKING:
        tabulate, locator, locate, fit, blind_spots = _tabulate, _locator, _locate, _fit, _blind_spots
        observable, resultant, reader = _observable, _resultant, _reader
    else:
        tabulate, locator, locate, fit, blind_spots = Verb(), Verb(), Verb(), Verb(), Verb()
        observable, resultant, reader = Verb(".estimate.area"), Verb(".estimate"), Verb(".reader")

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.measured is not None and self.measured.sensors != len(self.array):
            rule = f"a MeasuredResponse of {len(self.array)} sensors is needed, or none"
            raise InvalidValueError(f"measured = {self.measured!r}", rule, "MeasuredResponse.from_touches(...)")
        if _is_foreign(self.skin):
            who = type(self.skin).__name__
            _check.several(f"{who}.materials", self.skin.materials, Material, "return (Material(young=0.4e6),)")
            _check.scalar(f"{who}.thickness", self.skin.thickness, unit="m", above=0.0, finite=False)
        for kind in filter(_is_foreign, set(self.array.transducers)):
            _check.noun(f"{type(kind).__name__}.unit", kind.unit, str, 'return "Pa", or "" of a strain')
            _check.flag(f"{type(kind).__name__}.linear", kind.linear)
        widest, shallowest = float(np.abs(self.array.points).max()), float(np.asarray(self.array.depth).min())
        if not widest <= _WIDEST * shallowest:
            rule = f"at a depth of {shallowest:.6g} m sensors lie at most {_WIDEST:g} depths from y = 0 and z = 0"
            raise GeometryError(f"a sensor {widest:.6g} m from y = 0 or z = 0", rule, "all lengths are in m: 6e-3")
        deepest = float(np.asarray(self.array.depth).max())
        self._doubt_units(deepest, min(material.young for material in self.skin.materials))
        if deepest > self.skin.thickness * (1 + 1e-12):
            rule = f"the sensors have to lie in the skin, which is {self.skin.thickness:.6g} m thick"
            raise GeometryError(f"depth = {deepest:.6g} m", rule, "a thicker skin or shallower sensors")
        if self.array.on_area and not self.skin.takes_local:
            seen = f"sensors at z = {span(1e3 * np.asarray(self.array.z), 'mm')} in {self.skin}"
            rule = "it is solved in a plane, the same at every z, and takes a row of sensors at z = 0"
            raise GeometryError(seen, rule, "HalfSpace(material) for sensors on an area, or SensorArray.line(...)")

    def _doubt_units(self, deepest: float, softest: float) -> None:
        """Warn where lengths or moduli are not of a finger's size; where neither are, the units are one's own."""
        if softest < SOFTEST:
            if softest != 1.0 and deepest < DEEPEST:
                _check.doubt("young", softest, "Pa", 1e6, "MPa")
            return
        widest = max(LARGEST, _LONGEST * deepest)
        for name, largest in (("depth", DEEPEST), ("y", widest), ("z", widest)):
            value = float(np.abs(getattr(self.array, name)).max())
            if value > largest:
                _check.doubt(f"the largest {name}", value, "m", 1e-3, "mm")

    plot = Drawing("finger_figure")

    def _shown(self) -> list[tuple[str, str]]:
        """What a person sees of it: the skin, and the sensors in the units of people."""
        a = self.array
        kinds = many_of(Counter(type(kind).__name__ for kind in a.transducers).items())
        dead = int((~a.live).sum())
        units = {kind.unit for kind in a.transducers} if np.all(a.gain == 1) else {""}
        return [
            ("skin", str(self.skin)),
            ("sensors", kinds + (f", {dead} dead" if dead else "")),
            ("position", self._where()),
            ("depth", span(1e3 * np.asarray(a.depth), "mm")),
            (
                "noise",
                span(a.noise, units.pop() if len(units) == 1 else "") + f", gain {span(np.asarray(a.gain)[a.live])}",
            ),
            *([("tolerances", str(self.tolerances))] if self.tolerances is not None else []),
            *([("forces", "multiples of the load of the touches it was calibrated on")] if self.relative else []),
        ]

    def _where(self) -> str:
        """The positions as a person reads them."""
        a, positions = self.array, np.unique(self.array.points, axis=0)
        each = f", {len(a) // len(positions)} channels each" if len(positions) < len(a) else ""
        if a.on_area:
            ends = (f"{name} = {span(1e3 * values, 'mm')}" for name, values in zip("yz", positions.T, strict=True))
            return f"{', '.join(filter(None, (a.layout, *ends)))}{each}"
        pitches = np.diff(positions[:, 0])
        apart = f", {span(1e3 * pitches, 'mm')} apart" if pitches.size else ""
        return f"y = {span(1e3 * positions[:, 0], 'mm')}{apart}{each}"

    @cached_property
    def _groups(self) -> tuple[tuple[_Group, ...], tuple[_Group, ...]]:
        """The sensors as they are, and those of their transducers' linear parts."""
        kinds = self.array.transducers
        own, parts = self._grouped(kinds), {kind: kind.linear_part for kind in set(kinds)}
        linear = own if all(parts[kind] == kind for kind in parts) else self._grouped(tuple(parts[k] for k in kinds))
        return own, linear

    def _grouped(self, kinds: tuple[Transducer, ...]) -> tuple[_Group, ...]:
        a = self.array
        ys, zs, depths, widths = map(np.asarray, (a.y, a.z, a.depth, a.width))
        # Gauss-Legendre over the width: the field is analytic within a depth of the sensor, so the error falls
        # geometrically with the number of nodes, at a rate set by width / depth.
        nodes = np.where(widths > 0, np.ceil(8 + 12 * widths / depths), 1).astype(int)
        members: dict[tuple[Transducer, int], list[int]] = {}
        for i, key in enumerate(zip(kinds, nodes.tolist(), strict=True)):
            members.setdefault(key, []).append(i)
        groups = []
        shared: dict[bytes, Callable[[Contact | LocalContact], State]] = {}
        for (kind, count), index in members.items():
            t, w = _gauss(count)
            y = ys[index, None] + 0.5 * widths[index, None] * t
            where = (depths[index, None], y, zs[index, None])
            points = b"".join([values.tobytes() for values in where])
            if points not in shared:  # the channels of one position feel the same state
                felt = self.skin.at(*where if a.on_area else where[:2])  # one's own skin may know no z
                if not callable(felt):
                    seen, rule = f"{type(self.skin).__name__}.at gave {_check.shown(felt)}", "a function is needed"
                    raise InvalidValueError(seen, rule, "return lambda contact: State(stress, strain)")
                shared[points] = felt
            felt = shared[points]
            groups.append(_Group(kind, slice(None) if len(index) == ys.size else index, felt, 0.5 * w))
        return tuple(groups)

    def measure(self, contact: Contact | LocalContact, *, linear: bool = False) -> FloatArray:
        """What the transducers measure under `contact`, before gain and offset.

        Parameters
        ----------
        contact : Contact or LocalContact
            What presses; a batch of shape (...). A local one needs a skin that takes it, such as `HalfSpace`.
        linear : bool, optional
            Use each transducer's linear part (`Transducer.linear_part`).

        Returns
        -------
        ndarray, shape (..., n)
            In the transducers' units.
        """
        _check.noun("contact", contact, (Contact, LocalContact), "LineLoad(force=40.0)")
        shape = contact.shape
        return self._measured(contact.expand(2) if shape else contact, shape, _check.flag("linear", linear))

    def _measured(
        self, wide: Contact | LocalContact, shape: tuple[int, ...], linear: bool, axis: int | None = None
    ) -> FloatArray:
        """As `measure`, of contacts with two axes of length one behind those of their `shape`; summed over an axis."""
        shape = shape if axis is None else shape[:axis] + shape[axis + 1 :]
        out = np.empty((*shape, np.size(self.array.y)))
        states: dict[Callable[[Contact | LocalContact], State], State] = {}
        for kind, sensors, felt, weights in self._groups[linear]:
            if felt not in states:
                states[felt] = felt(wide)
                if not isinstance(states[felt], State):
                    said = f"{type(self.skin).__name__}.at(...)(contact)"
                    _check.noun(said, states[felt], State, "State(stress, ...)")
            if axis is None or kind.linear:
                values = kind.measure(states[felt])
                values = values if axis is None else values.sum(axis)
            else:
                values = kind.measure(states[felt].summed(axis))
            if _is_foreign(kind):
                count = out.shape[-1] if isinstance(sensors, slice) else len(sensors)
                said = f"{type(kind).__name__}.measure"
                values = _check.returned(said, values, (*shape, count, weights.size), exactly=True)
            out[..., sensors] = values[..., 0] if weights.size == 1 else values @ weights
        return out

    def read(
        self, contact: Contact | LocalContact, rng: np.random.Generator | None = None, *, sum_over: int | None = None
    ) -> FloatArray:
        """Readings of the sensors under `contact`.

        Parameters
        ----------
        contact : Contact or LocalContact
            What presses; a batch of shape (...) gives readings of shape (..., n).
        rng : numpy.random.Generator, optional
            Adds each sensor's noise; without it readings are free of noise.
        sum_over : int, optional
            An axis of the batch: contacts along it press at once.

        Returns
        -------
        ndarray, shape (..., n)
            Readings, in each sensor's unit times its gain; without the axis that was summed over.

        Raises
        ------
        InvalidValueError, GeometryError
            No such axis, or no batch.

        Warns
        -----
        ValidityWarning
            The first contact that is read lies 100 depths beyond the row, or is as wide: mm were probably meant.
        """
        if self._unread:
            self._doubt(contact)
        lift = contact.normal_force if self.array.lifted else np.zeros(())
        if sum_over is None:
            return self.array.digitise(self.measure(contact), rng, lift)
        if not (n := len(shape := contact.shape)):
            raise GeometryError("a single contact", "sum_over is an axis of a batch of them", "leave it out")
        axis = _check.whole("sum_over", sum_over, at_least=-n, at_most=n - 1, fix="sum_over=-1") % n
        measured = self._measured(contact.expand(2), shape, False, axis)
        return self.array.digitise(measured, rng, np.sum(np.broadcast_to(lift, shape), axis=axis))

    @cached_property
    def _unread(self) -> list[bool]:
        """Empty when a contact has been read."""
        return [True]

    def _doubt(self, contact: Contact | LocalContact) -> None:
        """Warn of a contact so far away, or so wide, that its unit was probably forgotten; once."""
        self._unread.clear()
        far = _FAR * float(np.asarray(self.array.depth).max())
        limits = {"position": far + float(np.abs(self.array.points).max()), "half_width": far, "half_widths": far}
        for name, limit in limits.items():
            values = np.abs(getattr(contact, name, 0.0))
            if values.size and (worst := float(np.max(values))) > limit:
                _check.doubt(name, worst, "m", 1e-3, "mm")

    def receptive_field(self, position: npt.ArrayLike, load: Literal["line", "point"] | None = None) -> FloatArray:
        """Change of each reading per unit force of a load at `position` [m].

        It contains the gain and the lift, not the offset. Estimators know nothing else of a finger.

        Parameters
        ----------
        position : array_like, shape (...) or (..., 2)
            Positions y of a line load, or (y, z) of a point load [m].
        load : {"line", "point"}, optional
            Which of the two; a point load where the sensors are on an area, a line load where they are in a row.

        Returns
        -------
        ndarray, shape (..., n, 2) or (..., n, 3)
            Reading per N/m of normal ([..., 0]) and of tangential load ([..., 1]); or per N of (N, Ty, Tz).

        Raises
        ------
        NotLinearError
            Where a transducer has no linear part.
        InvalidValueError, GeometryError
            Another load, a point load on a skin solved in a plane, positions of another shape.

        Examples
        --------
        >>> import subskin as ss
        >>> array = ss.SensorArray.grid(shape=(3, 3), pitch=2e-3, depth=2e-3)
        >>> finger = ss.Finger(ss.HalfSpace(ss.Material(young=0.4e6)), array)
        >>> finger.receptive_field([(0.0, 0.0), (1e-3, 0.5e-3)]).shape  # positions, sensors, components
        (2, 9, 3)
        """
        if load is not None:
            _check.choice("load", load, ("line", "point"))
        gain, at = self._linear_gain, _check.real("position", position, unit="m")
        if load == "point" or (load is None and self.array.on_area):
            if not at.ndim or at.shape[-1] != 2:
                rule = "a position (y, z) is needed, shape (..., 2)"
                raise GeometryError(f"position of shape {at.shape}", rule, "(1e-3, 0.5e-3)")
            points = PointLoad(components=np.eye(3), position=at[..., None, :])
            return self._with_lift(gain * np.swapaxes(self.measure(points, linear=True), -1, -2))
        units = _UNIT_LOADS.moved(at[..., None, None, None])
        return self._with_lift(gain * np.swapaxes(self._measured(units, (*at.shape, 2), linear=True), -1, -2))

    def _with_lift(self, fields: FloatArray) -> FloatArray:
        """Readings (..., n, k) under unit forces, those under the normal one with each sensor's lift."""
        if self.array.lifted:
            fields[..., 0] += np.asarray(self.array.lift)
        return fields

    @cached_property
    def _linear_gain(self) -> FloatArray:
        """Gain of each sensor, shape (n, 1), where all are linear, or can be made so."""
        for group in self._groups[False]:
            group.transducer.linearise(np.zeros(0))  # refuses what cannot
        return np.asarray(self.array.gain)[:, None]
