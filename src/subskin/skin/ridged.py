"""Ridges on a skin: what touches them reaches the skin through their bases."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Annotated, Self

import numpy as np
import numpy.typing as npt

from .. import _check
from .._check import FloatArray
from .._declared import Extent, Length, Real
from ..contact.base import Contact
from ..contact.line import line_loads
from ..contact.local import LocalContact
from ..contact.profile import PressureProfile
from ..errors import GeometryError, InvalidValueError
from ..material import Material
from ..tensor import State, Strain, Stress, Wave
from ._points import not_local, points
from .base import Materials, Skin

__all__ = ["Ridged"]

_COMPONENTS = ("xx", "yy", "zz", "xy")
_MOST = 4096
"""Ridges under the contacts of a batch."""


@dataclass(frozen=True)
class Ridged(Skin):
    """A skin with ridges along z, the surface at their bases: sensors feel what the bases pass on.

    What touches a ridged skin rests on crests. A line load at y is borne by the four crests nearest, in the shares of a
    cubic B-spline of the pitch: they add to 1, and their moment is that of the load, so force and position are kept;
    it stands for a touch of about a pitch either way. Any other contact is the sum of its line loads. Each ridge
    spreads its pressure and its drag evenly over its base. The drag, a ridge's `height` above it, tilts the ridge: its
    moment presses one side of the base and pulls at the other, in proportion to the distance from the middle
    (docs/ridges.md).

    Parameters
    ----------
    skin : Skin
        What the ridges stand on, solved in a plane: `HalfPlane`, `Layered` or `Round`.
    pitch : float
        Distance from ridge to ridge [m]; round a finger a whole number of ridges.
    height : float
        Of the crests over the bases [m], >= 0.
    width : float, optional
        Width of a base [m], at most the pitch, which it is by default.
    crest : float, optional
        Position y of one of the crests [m].

    Raises
    ------
    InvalidValueError, GeometryError
        A skin that is none or has ridges; a length out of range; ridges that do not go round a whole number of times.

    Examples
    --------
    A drag tilts the ridges, so a smooth skin takes it for a touch about their height times tan(angle) aside.

    >>> import subskin as ss
    >>> smooth = ss.HalfPlane(ss.Material(young=0.4e6))
    >>> array = ss.SensorArray.line(6, pitch=2e-3, depth=2e-3, noise=1e-4)
    >>> ridged, plain = (ss.Finger(skin, array) for skin in (Ridged(smooth, pitch=0.5e-3, height=0.4e-3), smooth))
    >>> readings = ridged.read(ss.LineLoad(40.0, angle=0.3, position=0.8e-3))
    >>> [round(1e3 * float(finger.locate(readings).position), 2) for finger in (ridged, plain)]
    [0.8, 0.93]
    """

    skin: Skin
    pitch: Length
    height: Extent
    width: Length | None = None
    crest: Annotated[float, Real("m")] = 0.0

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.skin.ridges is not None:
            fix = "Ridged(HalfPlane(Material(young=0.4e6)), pitch=1e-3, height=0.4e-3)"
            raise InvalidValueError(f"skin = {self.skin!r}", "ridges stand on a smooth skin", fix)
        if self.width is not None and self.width > self.pitch * (1 + 1e-12):
            seen, rule = f"width = {self.width:.6g} m of a base", f"ridges are {self.pitch:.6g} m apart"
            raise GeometryError(seen, rule, "a width of at most the pitch")
        turns = self.skin.period / self.pitch
        if np.isfinite(turns) and abs(turns - round(turns)) > 1e-6 * turns:
            seen, rule = f"pitch = {self.pitch:.9g} m", f"{turns:.6g} ridges do not close round the finger"
            raise GeometryError(seen, rule, f"pitch = {self.skin.period / max(round(turns), 1):.9g} m")

    @property
    def materials(self) -> tuple[Material, ...]:  # noqa: D102
        return self.skin.materials

    @property
    def interfaces(self) -> tuple[float, ...]:  # noqa: D102
        return self.skin.interfaces

    @property
    def thickness(self) -> float:  # noqa: D102
        return self.skin.thickness

    @property
    def curvature(self) -> float:  # noqa: D102
        return self.skin.curvature

    @property
    def ridges(self) -> tuple[float, float]:  # noqa: D102
        return self.crest, self.pitch

    def with_(  # noqa: D102
        self, *, materials: Materials = None, thickness: float | None = None, radius: float | None = None
    ) -> Self:
        new = self.skin.with_(materials=materials, thickness=thickness, radius=radius)
        wider = new.period / self.skin.period if np.isfinite(new.period) else 1.0  # as many ridges go round
        width = None if self.width is None else wider * self.width
        return replace(self, skin=new, pitch=wider * self.pitch, width=width, crest=wider * self.crest)

    def __str__(self) -> str:
        return f"ridges of {1e3 * self.height:.6g} mm every {1e3 * self.pitch:.6g} mm on {self.skin}"

    @property
    def _half(self) -> float:
        """Half the width of a base [m]."""
        return 0.5 * (self.pitch if self.width is None else self.width)

    def at(  # noqa: D102
        self, x: npt.ArrayLike, y: npt.ArrayLike, z: npt.ArrayLike | None = None
    ) -> Callable[[Contact | LocalContact], State]:
        xs, _ = points(x, y, self.thickness, z=z)
        felt = self.skin.at(x, y) if z is None else self.skin.at(x, y, z)
        known: dict[int, FloatArray] = {}

        def fields(ridges: range) -> None:
            """Make known what presses and drags on each of the ridges bring, (2, components, points)."""
            new = [j for j in ridges if j not in known]
            if not new:
                return
            state = felt(self._bases(np.array(new)).expand(xs.ndim))
            tensors = [getattr(t, c) for t in (state.stress, state.strain) for c in _COMPONENTS]
            values = np.moveaxis(np.array(tensors), 0, 2)
            known.update(zip(new, values, strict=True))

        def state(contact: Contact | LocalContact) -> State:
            if isinstance(contact, LocalContact):
                raise not_local(contact, self)
            shape = _check.broadcast(contact=np.empty(contact.shape), points=xs)
            out = np.zeros((2 * len(_COMPONENTS), *shape))
            if np.prod(shape):
                ridges, loads = self._borne(contact)
                fields(ridges)
                for i, j in enumerate(ridges):
                    share = loads[:, i]
                    if share.any():
                        out += sum(share[k] * _beside(known[j][k], len(contact.shape)) for k in (0, 1))
            stress, strain = out[: len(_COMPONENTS)], out[len(_COMPONENTS) :]
            return State(Stress(*stress), Strain(*strain))

        return state

    def _bases(self, ridges: npt.NDArray[np.intp]) -> PressureProfile:
        """The tractions at the bases under a unit force pressing, and one dragging, on each crest; shape (n, 2)."""
        h = self._half
        ends = (self.crest + self.pitch * ridges)[:, None, None] + np.array([-h, h])
        even, tilt = np.full(2, 0.5 / h), 1.5 / h**2 * np.array([-1.0, 1.0])
        pressure, shear = np.stack([even, self.height * tilt]), np.stack([np.zeros(2), even])
        return PressureProfile(ends, pressure, shear)

    def _borne(self, contact: Contact) -> tuple[range, FloatArray]:
        """The ridges that bear a contact, and the normal and tangential force on each, (2, ridges, *contact's)."""
        low, high = contact.support
        first, last = (int(f) for f in np.floor((np.array([low.min(), high.max()]) - self.crest) / self.pitch))
        if last - first > _MOST:
            seen = f"contacts over {last - first} ridges"
            raise GeometryError(seen, f"at most {_MOST} are handled", "a coarser pitch, or contacts one by one")
        crests = self.crest + self.pitch * np.arange(first, last + 2)
        lines = line_loads(contact, np.broadcast_to(crests, (*contact.shape, crests.size)), self.pitch)
        u = (lines.y - self.crest) / self.pitch
        left = np.floor(u)
        t = u - left
        # the cubic B-spline (de Boor 1978, chapter IX) on the four crests about each line
        shares = np.stack([(1 - t) ** 3, 4 - 3 * t**2 * (2 - t), 4 - 3 * (1 - t) ** 2 * (1 + t), t**3]) / 6
        ridges = range(first - 1, last + 4)
        out = np.zeros((2, len(ridges), *contact.shape))
        which = left.astype(int) - first
        for k, share in enumerate(shares):
            for i in np.unique(which):
                chosen = np.where(which == i, share, 0.0)
                for load, force in zip(out, (lines.normal, lines.tangential), strict=True):
                    load[i + k] += (chosen * force).sum(axis=-1)
        return ridges, out

    def wave(self, k: npt.ArrayLike, x: npt.ArrayLike) -> Wave:
        """As `Skin.wave`, the mean over all positions of the crests: what is left at the traction's own wavenumber."""
        smooth = self.skin.wave(k, x)
        waves = _check.real("k", k, unit="rad/m")[:, None]
        turn = waves * self._half
        passed = np.sinc(0.5 * waves * self.pitch / np.pi) ** 4
        even = passed * np.sinc(turn / np.pi)
        small = turn < 0.05
        safe = np.where(small, 1.0, turn)
        ramp = np.where(small, 1 - turn**2 / 10 + turn**4 / 280, 3 * (np.sin(safe) - safe * np.cos(safe)) / safe**3)
        tilt = -self.height * waves * passed * ramp

        def through(values: FloatArray) -> FloatArray:
            press, drag = np.moveaxis(values, -1, 0)
            return np.stack([even * press, even * drag + tilt * press], axis=-1)

        tensors = [type(t)(*(through(getattr(t, c)) for c in _COMPONENTS)) for t in (smooth.stress, smooth.strain)]
        return Wave(tensors[0], tensors[1], through(smooth.ux), through(smooth.uy))  # type: ignore[arg-type]

    def surface_influence(self, step: float, count: int) -> FloatArray:
        """Refused: how the surface between ridges moves depends on where they stand.

        Parameters
        ----------
        step : float
            Half the width of a hat [m].
        count : int
            Number of distances.

        Raises
        ------
        InvalidValueError
            Always.
        """
        seen, rule = f"a body pressed on {self}", "the crests touch, and the surface is not one"
        raise InvalidValueError(seen, rule, "design.press_ridges, or press the smooth skin")


def _beside(values: FloatArray, axes: int) -> FloatArray:
    """Components of points with room for a contact's axes: nothing to do but where a contact has more of them."""
    missing = axes - (values.ndim - 1)
    return values.reshape(values.shape[0], *(1,) * max(missing, 0), *values.shape[1:])
