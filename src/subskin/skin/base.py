"""What every skin answers: all that is known of a skin outside this folder."""

from __future__ import annotations

from abc import abstractmethod
from bisect import bisect_left
from collections.abc import Callable, Sequence
from typing import Any, ClassVar, Self

import numpy as np
import numpy.typing as npt

from .. import _check, _hooks
from .._check import FloatArray
from .._declared import Noun
from .._shown import Drawing
from ..contact.base import Contact
from ..contact.local import LocalContact
from ..errors import InvalidValueError
from ..material import Material
from ..tensor import Displacements, State, Strain, Stress, Wave
from ._given import MEMBERS
from ._map import state_map
from ._points import not_local
from .surface import PressedSurface

__all__ = ["Materials", "Skin"]

Materials = Sequence[Material] | None


class Skin(Noun, PressedSurface):
    """An elastic medium with a surface at depth x = 0.

    Fingers, estimators, design tools and plots ask a skin for these members and never which skin it is. A new skin
    writes `materials`, `at`, `wave` and `surface_influence`, and overrides `interfaces`, `thickness`, `curvature`,
    `ridges`, `takes_local`, `with_` and `__str__`, a description for people, where those of a flat skin without end,
    solved in a plane, are not its own (CONTRIBUTING.md). What follows from a skin is kept by its hash and its repr: it
    is a frozen dataclass.
    """

    EXAMPLE: ClassVar = "HalfPlane(Material(young=0.4e6))"

    plot = Drawing("field_map")

    def __init_subclass__(cls, **more: Any) -> None:
        super().__init_subclass__(**more)
        _hooks.check_members(cls, MEMBERS)

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
        _check.noun("contact", contact, (Contact, LocalContact), "LineLoad(force=40.0)")
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

    def wave_across(self, k: npt.ArrayLike, x: npt.ArrayLike) -> FloatArray:
        """Antiplane shear at the depths x under a drag of 1 Pa across a wave of it, along t: with l along the wave.

        With `wave`, the drag along, this is all that a three-dimensional flat skin answers to.

        Parameters
        ----------
        k : array_like, shape (m,)
            Wavenumbers [rad/m], > 0.
        x : array_like, shape (d,)
            Depths [m].

        Returns
        -------
        ndarray, shape (2, m, d)
            Stress xt [-] and displacement u_t [m/Pa], both in phase with the drag.

        Raises
        ------
        InvalidValueError
            A skin that is solved in a plane.

        Examples
        --------
        >>> import numpy as np, subskin as ss
        >>> skin = ss.HalfSpace(ss.Material(young=1.5e6))
        >>> bool(np.allclose(skin.wave_across(k=[500.0], x=[2e-3])[0], -np.exp(-1)))
        True
        """
        seen = f"a drag across a wave on {self}"
        raise InvalidValueError(seen, "it is solved in a plane", "a HalfSpace or a Layered")

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
        fix = "materials=[Material(young=0.4e6)]"
        new = self.materials if materials is None else _check.several("materials", materials, Material, fix)
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
