"""Stress and strain at points of a skin, and what follows from them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cached_property, partial
from typing import Any, Self

import numpy as np

from ._check import FloatArray
from ._frozen import Frozen
from .errors import InvalidValueError

__all__ = ["Deferred", "Displacements", "State", "Strain", "Stress", "SurfaceGradient", "Tilt", "Wave"]

_ZERO = np.zeros(())


class _OutOfPlane:
    """A shear across the plane: zeros, until a tensor that has one holds its own."""

    def __get__(self, tensor: _Tensor | None, kind: type) -> Self | FloatArray:
        return self if tensor is None else np.broadcast_to(_ZERO, tensor.shape)


@dataclass(frozen=True, eq=False, init=False)
class _Tensor(Frozen):
    """A symmetric tensor: x is depth, y runs along the surface and z across it. In a plane xz and yz are zeros."""

    xx: FloatArray
    yy: FloatArray
    zz: FloatArray
    xy: FloatArray
    xz: FloatArray = _OutOfPlane()  # type: ignore[assignment]
    yz: FloatArray = _OutOfPlane()  # type: ignore[assignment]

    def __init__(
        self,
        xx: FloatArray,
        yy: FloatArray,
        zz: FloatArray,
        xy: FloatArray,
        xz: FloatArray | None = None,
        yz: FloatArray | None = None,
    ) -> None:
        given = {"xx": xx, "yy": yy, "zz": zz, "xy": xy, "xz": xz, "yz": yz}
        for name, values in given.items():
            if values is not None:
                self.__dict__[name] = part = np.asarray(values, dtype=np.float64).view()  # the caller's stays open
                part.flags.writeable = False

    @property
    def shape(self) -> tuple[int, ...]:
        """Shape of each component."""
        return self.xx.shape

    @property
    def is_plane(self) -> bool:
        """Whether it is one of a plane, without shear across it."""
        return "xz" not in self.__dict__ and "yz" not in self.__dict__

    @property
    def matrix(self) -> FloatArray:
        """All components as symmetric matrices in the order x, y, z, shape (..., 3, 3)."""
        rows = [[self.xx, self.xy, self.xz], [self.xy, self.yy, self.yz], [self.xz, self.yz, self.zz]]
        return np.stack([np.stack(np.broadcast_arrays(*row), axis=-1) for row in rows], axis=-2)

    @property
    def principal(self) -> FloatArray:
        """The three principal values, largest (most tensile) first, shape (..., 3)."""
        if not self.is_plane:
            matrices = self.matrix
            known = np.asarray(np.isfinite(matrices).all(axis=(-2, -1), keepdims=True))
            values = np.linalg.eigvalsh(np.where(known, matrices, 0.0))[..., ::-1]
            return np.where(known[..., 0], values, np.nan)
        centre, radius = 0.5 * (self.xx + self.yy), np.hypot(0.5 * (self.xx - self.yy), self.xy)
        values = np.stack([centre + radius, centre - radius, np.broadcast_to(self.zz, centre.shape)], axis=-1)
        return np.sort(values, axis=-1)[..., ::-1]

    @property
    def trace(self) -> FloatArray:
        """Xx + yy + zz."""
        return self.xx + self.yy + self.zz


@dataclass(frozen=True, eq=False, init=False)
class Stress(_Tensor):
    """Stress [Pa], positive in tension: `xx`, `yy`, `zz` and the shears `xy`, `xz`, `yz`, arrays of one shape.

    In a plane `xz` and `yz` need not be given, and read as zeros.

    Examples
    --------
    >>> import numpy as np
    >>> s = Stress(xx=np.array(-3.0), yy=np.array(-1.0), zz=np.array(-2.0), xy=np.array(0.0))
    >>> float(s.mean_pressure)
    2.0
    >>> s.principal.tolist()
    [-1.0, -2.0, -3.0]
    """

    @property
    def mean_pressure(self) -> FloatArray:
        """Hydrostatic pressure -(xx + yy + zz) / 3 [Pa], positive in compression."""
        return -self.trace / 3


@dataclass(frozen=True, eq=False, init=False)
class Strain(_Tensor):
    """Strain [-], positive in extension: `xx`, `yy`, `zz` and `xy`, `xz`, `yz`, half the engineering shears.

    In a plane `xz` and `yz` need not be given, and read as zeros.

    Examples
    --------
    >>> import numpy as np
    >>> e = Strain(xx=np.array(-0.01), yy=np.array(0.01), zz=np.array(0.0), xy=np.array(0.002))
    >>> float(e.gamma_xy), float(e.volume)
    (0.004, 0.0)
    """

    @property
    def gamma_xy(self) -> FloatArray:
        """Engineering shear strain 2 eps_xy [-]."""
        return 2 * self.xy

    @property
    def volume(self) -> FloatArray:
        """Relative change of volume, the trace [-]."""
        return self.trace


@dataclass(frozen=True, eq=False)
class Displacements(Frozen):
    """How far points move [m]: `x` into the skin, `y` and `z` along its surface, arrays of one shape.

    Examples
    --------
    >>> import subskin as ss
    >>> skin = ss.HalfSpace(ss.Material(young=0.4e6))
    >>> moved = skin.displacement(ss.PointLoad(force=1.0), x=2e-3, y=[0.0, 1e-3], z=0.0)
    >>> (1e6 * moved.x).round(2).tolist(), (1e6 * moved.y).round(2).tolist()
    ([596.83, 480.44], [0.0, 106.76])
    """

    x: FloatArray
    y: FloatArray
    z: FloatArray

    @property
    def shape(self) -> tuple[int, ...]:
        """Shape of each component."""
        return self.x.shape


@dataclass(frozen=True, eq=False)
class Tilt(Frozen):
    """How far the material turns [rad] that a line along the depth leans: its deep end to +y (`y`) and to +z (`z`).

    The part of the rotation, half the curl of the displacement, that is seen so: y = (du_y/dx - du_x/dy) / 2, and z
    alike (Love, Mathematical Theory of Elasticity, 1927, section 7). Arrays of one shape.

    Examples
    --------
    >>> import subskin as ss
    >>> skin = ss.HalfSpace(ss.Material(young=0.4e6))
    >>> leans = skin.state(ss.PointLoad(force=1.0), x=2e-3, y=[0.0, 1e-3], z=0.0).tilt
    >>> leans.y.round(4).tolist(), (leans.z + 0.0).tolist()
    ([0.0, 0.0534], [0.0, 0.0])
    """

    y: FloatArray
    z: FloatArray


@dataclass(frozen=True, eq=False)
class State(Frozen):
    """Stress and strain at the same points: `stress` [Pa] and `strain` [-].

    `displacement` [m] and `tilt` [rad] are None where they are not known.
    """

    stress: Stress
    strain: Strain
    displacement: Displacements | None = field(default=None, kw_only=True)
    tilt: Tilt | None = field(default=None, kw_only=True)

    def moved(self, seen: str) -> Displacements:
        """The displacement [m]; an error says of which state, `seen`, it was wanted.

        Raises
        ------
        InvalidValueError
            A state that knows none.
        """
        if self.displacement is None:
            rule = "under a contact without end it is known only up to a constant, which grows with its length"
            fix = "a local contact on a HalfSpace or a Layered, or strain and stress"
            if not self.strain.is_plane:
                rule, fix = "nothing holds a layer that slides against a drag: it moves without end", "bonded layers"
            raise InvalidValueError(seen, rule, fix)
        return self.displacement

    def tilted(self, seen: str) -> Tilt:
        """How far the material turns [rad]; an error says of which state, `seen`, it was wanted.

        Raises
        ------
        InvalidValueError
            A state that does not say it.
        """
        if self.tilt is None:
            rule = "its skin does not say how far the material turns there"
            raise InvalidValueError(seen, rule, "a local contact on a HalfSpace or a Layered")
        return self.tilt

    def summed(self, axis: int) -> State:
        """The state of all that act along an axis of the batch at once, which is counted from the first.

        Parameters
        ----------
        axis : int
            From 0.

        Examples
        --------
        >>> import numpy as np, subskin as ss
        >>> skin = ss.HalfPlane(ss.Material(young=0.4e6))
        >>> two = ss.LineLoad(force=[1.0, 2.0], position=[0.0, 1e-3])
        >>> both = skin.state(two, x=2e-3, y=0.0).summed(0)
        >>> bool(np.isclose(both.strain.xx, skin.strain(two, x=2e-3, y=0.0).xx.sum()))
        True
        """
        return Deferred(*(partial(_summed, self, name, axis) for name in ("stress", "strain", "displacement", "tilt")))

    @property
    def energy_density(self) -> FloatArray:
        """Strain energy per volume, half of stress : strain [J/m^3].

        Examples
        --------
        >>> import numpy as np
        >>> zero = np.array(0.0)
        >>> s, e = Stress(np.array(-2.0), zero, zero, zero), Strain(np.array(-0.5), zero, zero, zero)
        >>> float(State(s, e).energy_density)
        0.5
        """
        s, e = self.stress, self.strain
        energy = 0.5 * (s.xx * e.xx + s.yy * e.yy + s.zz * e.zz) + s.xy * e.xy
        return energy if s.is_plane or e.is_plane else energy + s.xz * e.xz + s.yz * e.yz


def _summed(state: State, name: str, axis: int) -> Any:
    """A part of a state, each of its components summed over an axis."""
    part = getattr(state, name)
    if part is None:
        return None
    names = (name for name in ("xx", "yy", "zz", "xy", "xz", "yz", "x", "y", "z") if hasattr(part, name))
    if isinstance(part, Stress | Strain) and part.is_plane:
        names = (name for name in ("xx", "yy", "zz", "xy"))
    whole = np.broadcast_arrays(*(getattr(part, name) for name in names))
    return _KINDS[name](*(each.sum(axis=axis) for each in whole))


class Deferred(State):
    """A state whose `stress`, `strain`, `displacement` and `tilt` are worked out when asked for, by functions.

    Examples
    --------
    >>> import numpy as np
    >>> stress = Stress(*np.zeros((4, 3)))
    >>> Deferred(lambda: stress, lambda: 1 / 0).stress.shape
    (3,)
    """

    def __init__(
        self,
        stress: Callable[[], Stress],
        strain: Callable[[], Strain],
        displacement: Callable[[], Displacements | None] | None = None,
        tilt: Callable[[], Tilt | None] | None = None,
    ) -> None:
        self.__dict__.update(_stress=stress, _strain=strain, _displacement=displacement, _tilt=tilt)

    def __reduce__(self) -> tuple[Any, ...]:
        """It travels as what it has to say: functions stay behind."""
        return partial(State, displacement=self.displacement, tilt=self.tilt), (self.stress, self.strain)

    @cached_property
    def stress(self) -> Stress:
        """Stress [Pa]."""
        made: Stress = self.__dict__["_stress"]()
        return made

    @cached_property
    def strain(self) -> Strain:
        """Strain [-]."""
        made: Strain = self.__dict__["_strain"]()
        return made

    @cached_property
    def displacement(self) -> Displacements | None:
        """Displacement [m]; None where the skin knows none."""
        found: Callable[[], Displacements | None] | None = self.__dict__["_displacement"]
        return None if found is None else found()

    @cached_property
    def tilt(self) -> Tilt | None:
        """How far the material turns [rad]; None where the skin does not say it."""
        found: Callable[[], Tilt | None] | None = self.__dict__["_tilt"]
        return None if found is None else found()


_KINDS: dict[str, Any] = {"stress": Stress, "strain": Strain, "displacement": Displacements, "tilt": Tilt}


@dataclass(frozen=True, eq=False)
class Wave(State):
    """Amplitudes under a wave of traction, cos(k y) of pressure or sin(k y) of drag; components have any one shape.

    What is even in y goes with cos(k y): `ux`, all strains and stresses but xy. `uy` and xy are odd and go with
    sin(k y).

    Parameters
    ----------
    stress, strain : Stress, Strain
        Per Pa of traction [-], [1/Pa].
    ux, uy : ndarray
        Displacement along the depth and along the surface [m/Pa]; `displacement` and `tilt` are None.
    """

    ux: FloatArray
    uy: FloatArray

    @property
    def halves(self) -> tuple[State, State]:
        """The state that goes with cos(k y), and that which goes with sin(k y)."""
        zero = np.zeros(self.stress.shape)
        s, e = self.stress, self.strain
        even = State(Stress(s.xx, s.yy, s.zz, zero), Strain(e.xx, e.yy, e.zz, zero))
        return even, State(Stress(zero, zero, zero, s.xy), Strain(zero, zero, zero, e.xy))


@dataclass(frozen=True, eq=False)
class SurfaceGradient(Frozen):
    """How the displacement changes along y [-]: `ux` = du_x/dy (the tilt of the surface), `uy` = du_y/dy."""

    ux: FloatArray
    uy: FloatArray
