"""What every skin answers: all that is known of a skin outside this folder."""

from __future__ import annotations

from abc import ABC, abstractmethod
from bisect import bisect_left
from collections.abc import Callable, Sequence
from typing import Self

import numpy as np
import numpy.typing as npt

from .. import _check
from .._check import FloatArray
from .._frozen import Frozen
from .._shown import Drawing
from ..contact.base import Contact
from ..contact.local import LocalContact
from ..errors import InvalidValueError
from ..material import Material
from ..tensor import Displacements, State, Strain, Stress, Wave
from ._map import state_map
from ._points import not_local

__all__ = ["Materials", "Skin"]

Materials = Sequence[Material] | None


class Skin(Frozen, ABC):
    """An elastic medium with a surface at depth x = 0.

    Fingers, estimators, design tools and plots ask a skin for these members and never which skin it is. A new skin
    writes `materials`, `at`, `wave` and `surface_influence`, and overrides `interfaces`, `thickness`, `curvature`,
    `ridges`, `takes_local`, `with_` and `__str__`, a description for people, where those of a flat skin without end,
    solved in a plane, are not its own (CONTRIBUTING.md). What follows from a skin is kept by its hash and its repr: it
    is a frozen dataclass.
    """

    plot = Drawing("field_map")

    @property
    @abstractmethod
    def materials(self) -> tuple[Material, ...]:
        """The materials from the surface down; that of a half plane beneath the layers is the last."""

    def state(
        self, contact: Contact | LocalContact, x: npt.ArrayLike, y: npt.ArrayLike, z: npt.ArrayLike | None = None
    ) -> State:
        """Stress [Pa], strain [-], displacement [m] and tilt [rad] beneath `contact`.

        At an interface they are those of the layer above it.

        Parameters
        ----------
        contact : Contact or LocalContact
            What presses; a batch of any shape, which broadcasts against the points. A skin that is solved in a plane
            (`HalfPlane`, `Round`) takes long contacts only.
        x, y, z : array_like
            Depth, from 0 to the `thickness` [m], and position along the surface and across it [m], of shapes that
            broadcast. Left out, z is 0. Under a long contact the state is the same at every z.

        Raises
        ------
        GeometryError
            A point outside the skin, a contact that reaches round a finger, or shapes that do not broadcast.
        InvalidValueError
            A local contact on a skin that is solved in a plane.

        Warns
        -----
        SingularPointWarning
            A point of the surface where the stress is infinite; every component in the plane is NaN there.
        """
        points = (x, y) if z is None else (x, y, z)  # a skin of one's own may know no z
        return self.at(*points)(contact)

    @abstractmethod
    def at(
        self, x: npt.ArrayLike, y: npt.ArrayLike, z: npt.ArrayLike | None = None
    ) -> Callable[[Contact | LocalContact], State]:
        """The `state` at fixed points as a function of the contact, for many contacts one after the other.

        What depends on the points alone is worked out once.

        Parameters
        ----------
        x, y, z : array_like
            As in `state`.

        Examples
        --------
        >>> import subskin as ss
        >>> felt = ss.HalfPlane(ss.Material(young=0.4e6)).at(x=2e-3, y=[0.0, 1e-3])
        >>> felt(ss.LineLoad(force=40.0)).strain.xx.round(6).tolist()
        [-0.023873, -0.011459]
        """

    def stress(
        self, contact: Contact | LocalContact, x: npt.ArrayLike, y: npt.ArrayLike, z: npt.ArrayLike | None = None
    ) -> Stress:
        """Stress [Pa] beneath `contact`; see `state` for parameters, shapes, errors and warnings."""
        return self.state(contact, x, y, z).stress

    def strain(
        self, contact: Contact | LocalContact, x: npt.ArrayLike, y: npt.ArrayLike, z: npt.ArrayLike | None = None
    ) -> Strain:
        """Strain [-] beneath `contact`; see `state` for parameters, shapes, errors and warnings."""
        return self.state(contact, x, y, z).strain

    def displacement(
        self, contact: Contact | LocalContact, x: npt.ArrayLike, y: npt.ArrayLike, z: npt.ArrayLike | None = None
    ) -> Displacements:
        """Displacement [m] beneath `contact`; see `state` for parameters, shapes and warnings.

        It is finite on the surface wherever the pressure is not that of a point.

        Raises
        ------
        InvalidValueError
            A skin that knows no displacement under such a contact: that of a long contact has no end in a half plane.
        """
        seen = f"the displacement under a {type(contact).__name__} in {self}"
        return self.state(contact, x, y, z).moved(seen)

    def map(self, contact: LocalContact, x: float, y: npt.ArrayLike, z: npt.ArrayLike) -> State:
        """The `state` at one depth on a grid of points, by fast Fourier transforms: for large maps and many contacts.

        It is the field of the skin without end: no image of the contact is left, to 1e-10 of the map's largest
        component (tests/verification/test_map.py). The time grows with the area of map and contact in squares of a
        tenth of the depth, and little with the contact's own parts; `state` is quicker at few points
        (docs/local_contacts.md).

        Parameters
        ----------
        contact : LocalContact
            What presses; a batch of any shape, such as the frames of a `PressureGrid`.
        x : float
            Depth, > 0 [m].
        y, z : array_like, shape (n,), (k,)
            Points along the surface and across it [m], each evenly apart.

        Returns
        -------
        State
            Components of shape (..., n, k), the contact's batch first; worked out when asked for.

        Raises
        ------
        InvalidValueError
            A long contact, a skin that is solved in a plane, or a contact of one's own without a `spectrum`.
        GeometryError
            Points outside the skin or not evenly apart, or a map too large for its depth.

        Examples
        --------
        >>> import numpy as np, subskin as ss
        >>> skin = ss.HalfSpace(ss.Material(young=0.4e6))
        >>> y, z = np.linspace(-4e-3, 4e-3, 33), np.linspace(-3e-3, 3e-3, 25)
        >>> seen = skin.map(ss.RoundHertz(force=1.0, angle=0.5, half_width=1e-3), x=1e-3, y=y, z=z)
        >>> seen.stress.xx.shape, round(float(-seen.stress.xx.min()))
        ((33, 25), 213676)
        """
        if not isinstance(contact, LocalContact):
            seen = f"a map beneath a {type(contact).__name__}"
            raise InvalidValueError(seen, "a long contact makes the same at every z", "skin.state(contact, x, y)")
        if not self.takes_local:
            raise not_local(contact, self)
        return state_map(self.state, contact, x, y, z)

    @abstractmethod
    def wave(self, k: npt.ArrayLike, x: npt.ArrayLike) -> Wave:
        """Amplitudes at the depths x under a traction that waves along the surface for ever.

        The last axis is the load: a pressure p = cos(k y) of 1 Pa, and a drag q = sin(k y) of 1 Pa towards +y.
        Under either, what is even goes with cos(k y) and what is odd with sin(k y) (`Wave`). A layer of a
        three-dimensional skin answers the drag along k and the pressure in the same way.

        Parameters
        ----------
        k : array_like, shape (m,)
            Wavenumbers [rad/m], >= 0; whole numbers times the `curvature` on a round finger. k = 0 is the limit of long
            waves, in which a half plane's displacement is infinite.
        x : array_like, shape (d,)
            Depths, from 0 to the `thickness` [m].

        Returns
        -------
        Wave
            Components of shape (m, d, 2): per Pa of traction, stress [-], strain [1/Pa] and displacement [m/Pa].

        Raises
        ------
        InvalidValueError
            k < 0; waves that do not close round a finger; k = 0 where a layer slides, for a drag without end then
            stretches it without bound.
        GeometryError
            A depth outside the skin.

        Examples
        --------
        The strain of normal strain sensors at nu = 1/2: -(3/2E) k x exp(-k x), memo eq. (25).

        >>> import numpy as np, subskin as ss
        >>> skin = ss.HalfPlane(ss.Material(young=1.5e6))
        >>> wave = skin.wave(k=[0.0, 500.0], x=[2e-3])
        >>> ((1e6 * wave.strain.xx[:, 0, 0]).round(6) + 0.0).tolist(), round(float(np.exp(-1)), 6)
        ([0.0, -0.367879], 0.367879)
        """

    @abstractmethod
    def surface_influence(self, step: float, count: int) -> FloatArray:
        """Displacement of the surface at the distances j * step from the centre of a unit hat.

        A hat is a traction that falls linearly from 1 Pa to 0 within one step on either side. Where the skin is not
        `grounded`, u_x of a pressure and u_y of a drag lack a constant.

        Parameters
        ----------
        step : float
            Half the width of the hat, and the step of the distances [m].
        count : int
            Number of distances: j = 0 ... count - 1 towards +y.

        Returns
        -------
        ndarray, shape (2, 2, count)
            Displacement [m/Pa]: first index u_x (into the skin), u_y; second of a pressure, of a drag.

        Raises
        ------
        GeometryError
            Distances that go nearly round a finger.

        Examples
        --------
        >>> import subskin as ss
        >>> skin = ss.HalfPlane(ss.Material(young=1e6, poisson=0.5))
        >>> influence = skin.surface_influence(step=1e-4, count=3)
        >>> (influence[0, 0] * 1e10).round(4).tolist()
        [5.1138, 4.4519, 4.0772]
        """

    def area_influence(self, step: float, shape: tuple[int, int], drag: bool = False) -> FloatArray:
        """Displacement of the surface at (i, j) * step along y and z from a hat: 1 Pa at a node, 0 at the next ones.

        Parameters
        ----------
        step : float
            Step of the grid [m].
        shape : tuple of int
            Numbers of distances (n, k), from 0 on.
        drag : bool
            Also what drags do.

        Returns
        -------
        ndarray, shape (1 or 6, n, k)
            Displacement [m/Pa]: u_x of a pressure; with `drag` then u_y of q_y, u_z of q_z, u_y of q_z (or u_z of q_y),
            u_x of q_y, u_x of q_z. The last two change sign for u_y and u_z of a pressure.

        Raises
        ------
        InvalidValueError, GeometryError
            A skin of a plane; drags on layers of which one slides; a step far wider than the first layer is thick.

        Examples
        --------
        >>> import subskin as ss
        >>> skin = ss.HalfSpace(ss.Material(young=1e6, poisson=0.5))
        >>> (1e12 * skin.area_influence(step=1e-4, shape=(2, 2))).round(3).tolist()
        [[[70.954, 26.079], [26.079, 17.613]]]
        """
        rule = "an area is pressed, and this skin is solved in a plane"
        raise InvalidValueError(f"a {type(self).__name__}", rule, "HalfSpace or Layered, or a long body as Cylinder")

    def surface_compliance(self, k: npt.ArrayLike) -> FloatArray:
        """Displacement of the surface per traction: that of `wave` at x = 0.

        Parameters
        ----------
        k : array_like, shape (...)
            Wavenumbers [rad/m], > 0; on a round finger, whose `curvature` they are multiples of, also 0.

        Returns
        -------
        ndarray, shape (..., 2, 2)
            C [m/Pa]. p = cos(k y) gives u_x = C[0, 0] cos(k y), u_y = C[1, 0] sin(k y); q = sin(k y) gives u_x =
            C[0, 1] cos(k y), u_y = C[1, 1] sin(k y). u_x points into the skin.

        Raises
        ------
        InvalidValueError
            As `wave`; k = 0 on a flat skin.

        Examples
        --------
        >>> import subskin as ss
        >>> skin = ss.HalfPlane(ss.Material(young=1e6, poisson=0.0))
        >>> skin.surface_compliance(1e3).round(11).tolist()
        [[2e-09, -1e-09], [-1e-09, 2e-09]]
        """
        waves = _check.real("k", k, unit="rad/m", at_least=0.0, above=None if self.curvature else 0.0)
        wave = self.wave(waves.reshape(-1), np.zeros(1))
        return np.stack([wave.ux[:, 0], wave.uy[:, 0]], axis=-2).reshape(*waves.shape, 2, 2)

    def with_(
        self, *, materials: Materials = None, thickness: float | None = None, radius: float | None = None
    ) -> Self:
        """The same skin with other numbers, as calibrations, tolerances and searches for a modulus ask for it.

        Parameters
        ----------
        materials : sequence of Material, optional
            Instead of `materials`, as many.
        thickness : float, optional
            Another thickness [m], of one material on a rigid base or core.
        radius : float, optional
            Another radius of a round finger [m]; the thickness stays.

        Raises
        ------
        InvalidValueError
            A number that the skin has not, or not as a single one.
        GeometryError
            A thickness or a radius with which there is no such finger.

        Examples
        --------
        >>> import subskin as ss
        >>> skin = ss.Layered(ss.Layer(ss.Material(young=0.4e6), thickness=4e-3))
        >>> str(skin.with_(materials=[ss.Material(0.6e6, 0.45)], thickness=5e-3))
        '5 mm (0.6 MPa, nu 0.45) on a rigid base'
        """
        given = {"materials": materials, "thickness": thickness, "radius": radius}
        for name, value in given.items():
            if value is not None:
                seen = f"{name} of a {type(self).__name__}"
                raise InvalidValueError(seen, f"it has no single {name} that can be changed", f"leave out {name}")
        return self

    def _one_each(self, materials: Materials) -> tuple[Material, ...]:
        """The materials that `with_` is given, as many as there are; its own where it is given none."""
        new = self.materials if materials is None else tuple(materials)
        if len(new) != len(self.materials):
            seen = f"{len(new)} materials for a {type(self).__name__}"
            raise InvalidValueError(seen, f"it has {len(self.materials)}", "one for each of skin.materials")
        return new

    @property
    def interfaces(self) -> tuple[float, ...]:
        """Depth at which each of the `materials` but the last ends [m]."""
        return ()

    @property
    def thickness(self) -> float:
        """Depth of the rigid base or core [m]; infinite where there is none."""
        return np.inf

    @property
    def curvature(self) -> float:
        """1 over the radius of the surface [1/m]; 0 for a flat skin."""
        return 0.0

    def __str__(self) -> str:
        return f"{type(self).__name__} ({'; '.join(map(str, self.materials))})"

    @property
    def single_material(self) -> Material | None:
        """The one material of which the skin is made; None where there are several."""
        return self.materials[0] if len(self.materials) == 1 else None

    def material_at(self, depth: float) -> Material:
        """The material at `depth` [m]; at an interface that of the layer above."""
        return self.materials[bisect_left(self.interfaces, depth)]

    @property
    def takes_local(self) -> bool:
        """Whether it answers local contacts, and sensors on an area; a skin that is solved in a plane does not."""
        return False

    @property
    def endless(self) -> bool:
        """Whether it is a half plane: one material, flat, with no base."""
        return (
            self.ridges is None and len(self.materials) == 1 and not self.curvature and not np.isfinite(self.thickness)
        )

    @property
    def ridges(self) -> tuple[float, float] | None:
        """Position y of a crest and the pitch [m] of a skin with ridges; None for one that is the same at every y."""
        return None

    @property
    def grounded(self) -> bool:
        """Whether displacements are absolute, for there is a rigid base; else they are known up to a constant."""
        return bool(np.isfinite(self.thickness))

    @property
    def period(self) -> float:
        """Distance along the surface after which it repeats [m]; infinite for a flat skin."""
        return 2 * np.pi / self.curvature if self.curvature else np.inf

    def surface_drop(self, y: npt.ArrayLike) -> FloatArray:
        """How far the undeformed surface lies beneath its tangent at y = 0 [m], at `y` [m]; 0 for a flat skin."""
        ys, c = _check.real("y", y, unit="m"), self.curvature
        return np.asarray(2 / c * np.sin(0.5 * c * ys) ** 2) if c else np.zeros_like(ys)
