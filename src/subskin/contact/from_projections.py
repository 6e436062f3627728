"""A local contact whose projections are known, and its field as the mean over directions of plane fields.

Each projection is the pressure of a long contact (docs/local_contacts.md). That of a shape f on the direction phi is
P(t); with F = integral of P / (t - Z) dt its Cauchy transform at Z = y cos phi + z sin phi + i x,

    W_m = -(i^m / 4 pi^2) integral over phi of e^{i m phi} F',    and so on, each derivative along x being i d/dZ.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import Field, dataclass
from itertools import pairwise
from typing import Any, Protocol, TypeAlias

import numpy as np
import numpy.typing as npt

from .. import _check
from .._check import ComplexArray, FloatArray
from ..errors import InvalidValueError
from .base import Contact
from .local import RadialTerm
from .shaped import ShapedContact, SignatureOf
from .shifted import ShiftedSource, axial_family, source_at

__all__ = ["FromProjections", "at_the_surface", "mean_over_directions"]

_GENTLE = ((0.6, 32), (0.3, 64))
"""Directions that half a turn needs where the nearest singularity is so far from the real directions."""

# A stretch of directions is mapped to the whole line, as in `quadrature`: a singularity above its end is pi/2 away.
_STEP = 0.27
_V = _STEP * np.arange(-140, 141)
_SHARE, _REST = 1 / (1 + np.exp(-_V)), 1 / (1 + np.exp(_V))
_WEIGHT = _STEP * _SHARE * _REST
_BLOCK = 1 << 17


class Projection(Protocol):
    """F, F' or F'' of the projections on the directions `phi` at `depth`, shape (k, n), of the k points `chosen`."""

    def __call__(self, phi: FloatArray, depth: ComplexArray, chosen: npt.NDArray[np.intp], /) -> ComplexArray:
        """The transform."""
        ...


def at_the_surface(family: Callable[[FloatArray], ComplexArray], room: FloatArray) -> ComplexArray:
    """A family's slope along x at x = 0 from depths that are small beside the `room` [m] in which it is smooth.

    There the mean over directions runs over poles.
    """
    step = 5e-4 * room
    return np.asarray(sum(share * family(k * step) for k, share in ((1, 4.0), (2, -6.0), (3, 4.0), (4, -1.0))))


def mean_over_directions(
    order: int, x: FloatArray, zeta: ComplexArray, cauchy: Projection, singular: ComplexArray
) -> ComplexArray:
    """`ShapedContact.unit_family` of a shape from its projections.

    Parameters
    ----------
    order : int
        As in `unit_family`; `cauchy` gives F, F' and F'' for -1, 0 and 1.
    x, zeta : ndarray, shape (n,)
        Points [m].
    cauchy : callable
        A `Projection`, of unit load [1/m^(2 + order)].
    singular : ndarray, shape (n, k)
        Directions, complex, where it is singular as seen from each point.
    """
    out = np.empty((3 if order == -1 else 4, x.size), dtype=np.complex128)
    turns = np.where(np.isfinite(singular), singular, 1e3j)
    room = np.abs(turns.imag).min(axis=1)
    left = np.ones(x.size, dtype=bool)
    for least, count in _GENTLE:
        chosen = np.flatnonzero(left & (room >= least))
        left[chosen] = False
        phi = np.pi / count * (np.arange(count) + 0.5)
        _add(out, order, x, zeta, cauchy, chosen, lambda at: (phi[None], np.full((1, phi.size), np.pi / phi.size)))  # noqa: B023
    chosen = np.flatnonzero(left)
    ends = np.sort(np.mod(turns.real, np.pi), axis=1)
    ends = np.concatenate([ends, ends[:, :1] + np.pi], axis=1)

    def graded(at: npt.NDArray[np.intp]) -> tuple[FloatArray, FloatArray]:
        low, length = ends[at, :-1, None], np.diff(ends[at], axis=1)[..., None]
        phi = np.where(_SHARE < 0.5, low + length * _SHARE, low + length - length * _REST)
        return phi.reshape(at.size, -1), (length * _WEIGHT).reshape(at.size, -1)

    _add(out, order, x, zeta, cauchy, chosen, graded)
    return out


def _add(
    out: ComplexArray,
    order: int,
    x: FloatArray,
    zeta: ComplexArray,
    cauchy: Projection,
    chosen: npt.NDArray[np.intp],
    nodes: Callable[[npt.NDArray[np.intp]], tuple[Any, Any]],
) -> None:
    """Fill the columns `chosen`: half a turn, for the other half mirrors it."""
    if not chosen.size:
        return
    step = max(1, _BLOCK // nodes(chosen[:1])[0].size)
    factor = {-1: 1j, 0: -1.0, 1: -1j}[order] / (4 * np.pi**2)
    for first in range(0, chosen.size, step):
        at = chosen[first : first + step]
        phi, weight = nodes(at)
        depth = np.empty((at.size, phi.shape[1]), dtype=np.complex128)
        e = np.exp(1j * phi)
        depth.real, depth.imag = (np.conj(zeta[at, None]) * e).real, x[at, None]
        g = cauchy(phi, depth, at)
        for m in range(len(out)):
            # F of the direction on the other side is -F*, F' is F'*
            part = g.real if (m % 2 == 0) == (order == 0) else 1j * g.imag
            term = weight * e**m * part
            out[m, at] = 1j**m * 2 * factor * np.where(np.isfinite(term), term, 0.0).sum(axis=1)


Profiles: TypeAlias = Callable[[FloatArray], Contact]
"""The profile on each direction, as a batch of the shape of the directions."""

_CIRCLE = np.exp(2j * np.pi * np.arange(32) / 32)
_LINES = 1 << 14
_SAMPLES = 256
_MOST = 4  # directions that are looked at for each end or kink of a profile
_RAYS = np.array([0.137, 0.446, 0.731, 0.952])


@dataclass(frozen=True, eq=False, init=False)
class FromProjections(ShapedContact):
    """The local contact whose projections are the pressures of long contacts: W_m is the mean of their plane fields.

    The projection on a direction is the pressure summed across it: of a uniform disc a semi-ellipse (`Hertz`), of a
    round punch a `Strip`, of a cone a triangle, of a polygon under uniform pressure straight lines (`PressureProfile`).
    Source: docs/local_contacts.md, Radon 1917. Where many kinks make it slow, a `PressureGrid` may serve. Parameters
    force, angle, azimuth, position, components and moment as in `ShapedContact`.

    Parameters
    ----------
    profile : Contact or callable
        A single long contact about y = 0, the same on both sides and in all directions; or a function that gives, for
        directions phi [rad] of any shape, from +y towards +z, the contacts on the axes at these angles, as a batch of
        their shape. Its force does not matter.

    Raises
    ------
    InvalidValueError
        What is neither, a profile that is not the same on both sides, one without pressure.

    Examples
    --------
    A disc under uniform pressure.

    >>> import subskin as ss
    >>> disc = FromProjections(ss.Hertz(force=1.0, half_width=1e-3), force=1.0)
    >>> disc.pressure([0.0, 0.5e-3, 2e-3], 0.0).round(3).tolist()
    [318309.886, 318309.886, 0.0]
    """

    profile: Contact | Profiles = None  # type: ignore[assignment]

    __signature__ = SignatureOf("profile")

    def __init__(self, profile: Contact | Profiles, *load: npt.ArrayLike, **more: npt.ArrayLike) -> None:
        fix = "a long contact such as Hertz(force=1.0, half_width=1e-3), or a function of the direction"
        if not isinstance(profile, Contact) and not callable(profile):
            raise InvalidValueError(f"profile = {_check.shown(profile)}", "a long contact or a function is needed", fix)
        self.__dict__["profile"] = profile
        if isinstance(profile, Contact):
            if profile.shape:
                raise InvalidValueError(f"a batch of profiles of shape {profile.shape}", "a single one is needed", fix)
            reach = np.abs(np.stack(profile.support)).max() * _RAYS
            with np.errstate(invalid="ignore"):
                off = np.abs(profile.pressure(reach) - profile.pressure(-reach))
            if not (off <= 1e-9 * np.abs(profile.pressure(reach)).max()).all():
                seen = f"a {type(profile).__name__} that is not the same on both sides of y = 0"
                raise InvalidValueError(seen, "the same in all directions, it has to be", "a function of the direction")
        if not (np.asarray(self._at(np.zeros(())).normal_force) > 0).all():
            raise InvalidValueError("a profile without a pressing force", "a normal force > 0 is needed", fix)
        super().__init__(*load, **more)

    @classmethod
    def _lengths(cls) -> list[Field[Any]]:
        return []

    def _parameters(self) -> dict[str, FloatArray]:
        return {name: value for name, value in super()._parameters().items() if name != "profile"}

    def _at(self, phi: npt.NDArray[np.floating[Any]]) -> Contact:
        """The profile on directions."""
        if isinstance(self.profile, Contact):
            return self.profile
        found = self.profile(np.asarray(phi))
        if not isinstance(found, Contact):
            seen = f"profile(phi) gave {_check.shown(found)}"
            raise InvalidValueError(
                seen, "a long contact is needed", "lambda phi: Hertz(1.0, half_width=1e-3 + 0 * phi)"
            )
        return found

    def unit_family(self, order: int, x: FloatArray, zeta: ComplexArray) -> ComplexArray:  # noqa: D102
        x, zeta = np.broadcast_arrays(x, zeta)
        flat, away = x.reshape(-1), zeta.reshape(-1)
        if not isinstance(self.profile, Contact):
            return self._mean(order, flat, away).reshape(3 if order == -1 else 4, *x.shape)
        rim = float(np.abs(np.stack(self.profile.support)).max())
        outside = (np.abs(away) > rim) | (flat > 2 * rim)
        out = np.empty((3 if order == -1 else 4, flat.size), dtype=np.complex128)
        for chosen, family in ((outside, self._shifted), (~outside, self._mean)):
            if chosen.any():
                out[:, chosen] = family(order, flat[chosen], away[chosen])
        return out.reshape(len(out), *x.shape)

    def unit_core(self, x: FloatArray, zeta: ComplexArray, w: ComplexArray, dw: ComplexArray) -> ComplexArray:  # noqa: D102
        core = super().unit_core(x, zeta, w, dw)
        if not isinstance(self.profile, Contact):
            return core
        x, zeta = np.broadcast_arrays(x, zeta)
        r = np.abs(zeta)
        far = x * x + r * r > 16 * float(np.abs(np.stack(self.profile.support)).max()) ** 2
        if far.any():
            depth, away = x[far], r[far]
            total = np.zeros(depth.shape)
            for t, share in self._sources(depth.size):
                source = source_at(depth, away, t)
                # W_0 + x W_0'/2 of a shifted source; no two terms cancel
                up = away**2 * (source.depth + 0.5 * depth) - 1j * t * source.depth**2
                total += (share * (up / source.distance**5).real).sum(axis=0)
            core[far] = total / (2 * np.pi)
        return core

    def _sources(self, count: int) -> list[tuple[FloatArray, FloatArray]]:
        """Depths of the shifted sources, and their shares, P(t) dt: columns, in blocks that suit `count` points."""
        profile: Any = self.profile
        rows = []
        breaks = np.unique(np.append(np.abs(np.asarray(profile.breaks)), 0.0))
        for low, high in pairwise(breaks):
            t = np.where(_SHARE < 0.5, low + (high - low) * _SHARE, high - (high - low) * _REST)
            t = np.clip(t, np.nextafter(low, high), np.nextafter(high, low))
            share = 2 * (high - low) * _WEIGHT * profile.pressure(t) / profile.normal_force
            rows.append(np.stack([t, np.where(np.isfinite(share), share, 0.0)]))
        each, step = np.concatenate(rows, axis=1)[..., None], max(1, _LINES // max(1, count))
        return [(each[0, k : k + step], each[1, k : k + step]) for k in range(0, each.shape[1], step)]

    def _shifted(self, order: int, x: FloatArray, zeta: ComplexArray) -> ComplexArray:
        """Beyond the disc of the one profile: the sum over sources at the depths x - i t, weighed as it is."""
        r, total = np.abs(zeta), np.zeros((), dtype=np.complex128)
        for t, share in self._sources(x.size):
            source = source_at(x, r, t)

            def row(n: int, m: int, source: ShiftedSource = source, share: FloatArray = share) -> FloatArray:
                return np.asarray((share * source.member(n, m).real).sum(axis=0))

            total = total + axial_family(order, zeta, r, row)
        return np.asarray(total)

    def _mean(self, order: int, flat: FloatArray, away: ComplexArray) -> ComplexArray:
        """The mean over directions."""

        def cauchy(phi: FloatArray, depth: ComplexArray, chosen: npt.NDArray[np.intp]) -> ComplexArray:
            contact = self._at(np.broadcast_to(phi, depth.shape))
            with np.errstate(divide="ignore", invalid="ignore"):
                if order < 1:
                    found = contact.transforms(depth)
                    return np.asarray((found.p if order == -1 else found.dp) / contact.normal_force)
                # F'' from F' on a circle about each point: only x F'' is asked for
                room, total = depth.imag / 3, np.zeros_like(depth)
                for turn in _CIRCLE:
                    total += contact.transforms(depth + room * turn).dp / turn
                return np.asarray(total / (_CIRCLE.size * room * contact.normal_force))

        on = flat == 0
        if order == 1 and on.any():
            out = np.empty((4, flat.size), dtype=np.complex128)
            room = 1e-2 * np.abs(np.stack(self._box())).max() + np.zeros(int(on.sum()))
            if isinstance(self.profile, Contact):
                rings = np.unique(np.abs(np.asarray(self.profile.breaks)))
                room = np.maximum(np.abs(np.abs(away[on])[:, None] - rings).min(axis=1), 1e-9 * room)
            out[:, on] = at_the_surface(lambda depth: self._mean(order, depth, away[on]), room)
            if not on.all():
                out[:, ~on] = self._mean(order, flat[~on], away[~on])
            return out
        turns = self._round_turns(flat, away) if isinstance(self.profile, Contact) else self._turns(flat, away)
        return mean_over_directions(order, flat, away, cauchy, turns)

    def _round_turns(self, x: FloatArray, zeta: ComplexArray) -> ComplexArray:
        """Directions, complex, in which a point lies on an end or a kink of the one profile, Z = t."""
        breaks = np.unique(np.abs(np.asarray(self._at(np.zeros(())).breaks)))
        r = np.abs(zeta)[:, None]
        with np.errstate(divide="ignore", invalid="ignore"):
            away = np.arccos((breaks - 1j * x[:, None]) / r)
        middle = np.angle(zeta)[:, None]
        return np.concatenate([middle + away, middle - away], axis=1)

    def _turns(self, x: FloatArray, zeta: ComplexArray) -> ComplexArray:
        """The same for profiles that change with the direction: where a point lies on them, or how near it comes."""
        step = 2 * np.pi / _SAMPLES
        phi = step * np.arange(_SAMPLES)
        along, turns = np.conj(zeta)[:, None], []
        breaks = np.asarray(self._at(phi).breaks)
        steepest = np.abs(along) + np.abs(breaks).max() + 1e-300
        for k in range(breaks.shape[-1]):

            def off(at: npt.NDArray[np.floating[Any]], k: int = k) -> FloatArray:
                return np.asarray((along * np.exp(1j * at)).real - np.asarray(self._at(at).breaks)[..., k])

            seen = off(phi)
            crossed = np.signbit(seen) != np.signbit(np.roll(seen, -1, axis=1))
            best = np.argsort(~crossed, axis=1, kind="stable")[:, :_MOST]
            low, high = phi[best], phi[best] + step
            falls = ~np.signbit(np.take_along_axis(seen, best, axis=1))
            for _ in range(60):
                middle = 0.5 * (low + high)
                before = np.signbit(off(middle)) != falls
                low, high = np.where(before, middle, low), np.where(before, high, middle)
            real = np.take_along_axis(crossed, best, axis=1)
            turns.append(low + 1j * np.where(real, x[:, None] / steepest, 1e3))
            # where it comes near without a crossing: a bound on how far the singularity is from the real directions
            size = np.abs(seen)
            lowest = (size <= np.roll(size, 1, axis=1)) & (size < np.roll(size, -1, axis=1))
            best = np.argsort(np.where(lowest, size, np.inf), axis=1)[:, :_MOST]
            near = np.take_along_axis(size, best, axis=1) - steepest * step
            turns.append(phi[best] + 1j * np.hypot(np.maximum(near, 0.0), x[:, None]) / steepest)
        return np.concatenate(turns, axis=1)

    def unit_spectrum(self, ky: FloatArray, kz: FloatArray) -> ComplexArray:  # noqa: D102
        ky, kz = np.broadcast_arrays(ky, kz)
        contact = self._at(np.arctan2(kz, ky))
        return np.asarray(contact.spectrum(np.hypot(ky, kz)).p / contact.normal_force)

    @property
    def radial_terms(self) -> tuple[RadialTerm, ...] | None:  # noqa: D102
        if not isinstance(self.profile, Contact):
            return None
        profile = self.profile

        def spectrum(k: FloatArray) -> FloatArray:
            return np.asarray(profile.spectrum(k).p.real / profile.normal_force)

        return (RadialTerm(self.components, self.moment, self.position, spectrum),)

    def unit_pressure(self, y: FloatArray, z: FloatArray) -> FloatArray:  # noqa: D102
        low, high = self._box()
        inside = (low[0] <= y) & (y <= high[0]) & (low[1] <= z) & (z <= high[1])
        if isinstance(self.profile, Contact):
            inside &= y * y + z * z <= high[0] ** 2
        zeta = np.empty(inside.shape, dtype=np.complex128)
        zeta.real, zeta.imag = y, z
        out = np.zeros(inside.shape)
        if inside.any():
            within = zeta[inside]
            out[inside] = self.unit_family(0, np.zeros(within.shape), within)[0].real
        return out

    def _box(self) -> tuple[Any, Any]:
        """Ends of the support along y and along z."""
        ends = [self._at(np.asarray(turn)).support for turn in (0.0, 0.5 * np.pi)]
        return [float(low) for low, _ in ends], [float(high) for _, high in ends]

    @property
    def support(self) -> tuple[FloatArray, FloatArray]:  # noqa: D102
        low, high = self._box()
        return self.position + np.array(low), self.position + np.array(high)
