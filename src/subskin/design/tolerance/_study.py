"""What `locate` makes of a finger that is not as drawn, touch by touch."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import numpy.typing as npt

from ..._check import FloatArray
from ..._frozen import Frozen
from ...array import SensorArray
from ...contact import LineLoad, PointLoad, RoundHertz
from ...errors import GeometryError, InvalidValueError
from ...estimate import Locator, Status
from ...estimate.area import AreaLocator, RoundLocator
from ...finger import Finger
from .._common import locator_for
from ..touches import Touches

_FORCED = 1e-12
_EXPLAINED = 90.0
"""What a load explains of chi-square in a frame that is located whatever its status: well above the least, 55."""

_SINGULAR = 1e-6
"""Ratio of singular values, columns being scaled: with it, first order means nothing."""
_WIDER = 0.02
"""Share by which the half width is changed for the slope of the readings in it."""


@dataclass(frozen=True, eq=False)
class Located(Frozen):
    """Errors (..., p, a, k) in the columns of `Study.told`; which are OK."""

    errors: FloatArray
    ok: npt.NDArray[np.bool_]


class Study:
    """Touches on a grid of positions (p,) or (p, 2) [m] and loads (a, d + 1), and the finger that locates them.

    That is the finger as drawn; `friction` and `search` are those of `locate`. `told` says what is found and which of
    the k columns of an error it has: the d of the position [m], the force relative to the true one, the d of its
    direction [rad], and the radius [m] of touches that have one.
    """

    def __init__(
        self, finger: Finger, touches: Touches, position: FloatArray, load: FloatArray, friction: float, search: Any
    ) -> None:
        self.finger, self.touches, self.position, self.load = finger, touches, position, load
        self.friction, self.search = friction, search
        d = self.dim = load.shape[1] - 1
        self.told = {"position": slice(0, d), "force": slice(d, d + 1), "angle": slice(d + 1, 2 * d + 1)}
        if touches.half_width is not None:
            self.told["radius"] = slice(2 * d + 1, 2 * d + 2)
        needed = d + (1 if friction == 0 else d + 1) + (touches.half_width is not None)
        live = int(finger.array.live.sum())
        if live < needed:
            raise InvalidValueError(f"{live} sensors that respond", f"locate needs at least {needed}", "more sensors")
        self.locator = locator_for(finger, touches, search=search, friction=friction)
        low, high = self._searched()
        if (position < low).any() or (position > high).any():
            seen = f"touches from {_in_m(position.min(axis=0))} to {_in_m(position.max(axis=0))} m"
            rule = f"loads are looked for from {_in_m(low)} to {_in_m(high)} m"
            raise GeometryError(seen, rule, f"a narrower {'span' if d == 1 else 'area'}, or a wider search")
        self._forced = self._like(replace(finger.array, low=-np.inf, high=np.inf), false_alarm=_FORCED)
        self._linear = all(t.linear for t in finger.array.transducers)
        # unit vectors at right angles to each load, by which its direction is off, (a, d, d + 1)
        lean = np.linalg.norm(load[:, 1:], axis=1, keepdims=True)
        along = np.where(lean > 0, load[:, 1:] / np.where(lean > 0, lean, 1.0), np.eye(d)[0])
        across = [np.concatenate([-lean, load[:, :1] * along], axis=1) / touches.force]
        if d == 2:
            across.append(np.stack([0 * along[:, 0], -along[:, 1], along[:, 0]], axis=1))
        self._across = np.stack(across, axis=1)

    def _searched(self) -> tuple[FloatArray, FloatArray]:
        """The lowest and the highest position at which loads are looked for."""
        if isinstance(self.locator, AreaLocator):
            box = np.asarray(self.locator.search)
            return box[:, 0], box[:, 1]
        return np.asarray(self.locator.response.start), np.asarray(self.locator.response.stop)

    def _like(self, array: SensorArray, **options: Any) -> Any:
        """The finger's locator with other noise or ranges, or other options."""
        own = self.locator
        options["friction"] = self.friction
        if isinstance(own, RoundLocator):
            return RoundLocator(own.response, array, own.search, own.half_width, **options)
        if isinstance(own, AreaLocator):
            return AreaLocator(own.response, array, own.search, **options)
        return Locator(own.response, array, **options)

    def of(self, finger: Finger) -> Study:
        """The same touches, located by another finger."""
        return Study(finger, self.touches, self.position, self.load, self.friction, self.search)

    def readings(self, made: Finger) -> FloatArray:
        """What the touches read on a finger, without noise, steps or ends of the range, shape (p, a, n)."""
        if self._linear:
            field = self._field(made, self.position)
            return np.asarray(np.einsum("pnl,al->pan", field, self.load) + np.asarray(made.array.offset))
        return _read_exactly(made, self.touches.contact(self.load, self.position[:, None]))

    def _field(self, made: Finger, position: FloatArray) -> FloatArray:
        """Readings under unit components of the touches, (p, n, d + 1)."""
        half_width = self.touches.half_width
        if half_width is None:
            return made.receptive_field(position, "line" if self.dim == 1 else "point")
        unit = RoundHertz(components=np.eye(3), position=position[:, None], half_width=half_width)
        read = np.asarray(made.array.gain) * made.measure(unit, linear=True)
        return np.swapaxes(read, -1, -2)

    def pressed(self, made: Finger, load: FloatArray, position: FloatArray) -> FloatArray:
        """The same of a stylus, (c, d + 1) at (c,) or (c, 2): a line, or a point on an area; shape (c, n)."""
        if not self._linear:
            return _read_exactly(made, stylus(load, position))
        field = made.receptive_field(position, "line" if self.dim == 1 else "point")
        return np.asarray((field @ load[..., None])[..., 0] + np.asarray(made.array.offset))

    def readings_of(self, made: Sequence[Finger]) -> FloatArray:
        """The same on several fingers, shape (k, p, a, n): at one go where they differ in their sensors alone."""
        skin, n = made[0].skin, len(made[0].array)
        if not self._linear or any(finger.skin is not skin for finger in made):
            return np.stack([self.readings(finger) for finger in made])
        arrays = [finger.array for finger in made]
        names = ("y", "z", "depth", "gain", "offset", "width")
        values = {name: np.concatenate([np.asarray(getattr(a, name)) for a in arrays]) for name in names}
        every = SensorArray(**values, transducer=[kind for a in arrays for kind in a.transducers])
        readings = self.readings(Finger(skin, every))
        return np.moveaxis(readings.reshape(*readings.shape[:2], len(made), n), 2, 0)

    def locate(self, readings: FloatArray) -> Located:
        """Locate readings (..., p, a, n).

        Frames to which `locate` gives no load, since it says that none explains them, are located all the same: in
        units in which noise is large enough, which moves no minimum of chi-square.
        """
        found = self.locator(readings)
        position, parts, width = np.array(found.position), np.array(found.components), np.array(found.half_width)
        none = np.isnan(parts[..., 0]) & (found.status != Status.INCOMPLETE)
        if none.any():
            scale = np.sqrt(np.maximum(self._explained(readings[none]) - found.residual[none], np.finfo(float).tiny))
            again = self._forced(self.scaled(readings[none], scale / np.sqrt(_EXPLAINED)))
            position[none], width[none] = again.position, again.half_width
            parts[none] = again.components * (scale / np.sqrt(_EXPLAINED))[:, None]
        errors = np.empty((*width.shape, list(self.told.values())[-1].stop))
        errors[..., self.told["position"]] = (position - self.position[:, None]).reshape(*width.shape, -1)
        size = np.linalg.norm(parts, axis=-1)
        errors[..., self.told["force"]] = (size / self.touches.force - 1)[..., None]
        errors[..., self.told["angle"]] = self._turned(parts)
        if self.touches.half_width is not None:
            errors[..., self.told["radius"]] = (width - self.touches.half_width)[..., None]
        return Located(errors, np.asarray(found.status == Status.OK))

    def _turned(self, parts: FloatArray) -> FloatArray:
        """By how much directions of loads (..., a, d + 1) are off, to each side, (..., a, d) [rad]."""
        across = np.einsum("adl,...al->...ad", self._across, parts)
        far = np.linalg.norm(across, axis=-1, keepdims=True)
        along = np.einsum("al,...al->...a", self.load / self.touches.force, parts)[..., None]
        return np.asarray(across * np.where(far > 0, np.arctan2(far, along) / np.where(far > 0, far, 1.0), 0.0))

    def _explained(self, readings: FloatArray) -> FloatArray:
        """Chi-square of frames (f, n) if nothing pressed."""
        array = self.finger.array
        noise = np.where(array.live, array.noise, 1.0)
        rise = np.where(array.usable(readings), readings - np.asarray(array.offset), 0.0)
        return np.asarray(((rise / noise) ** 2).sum(axis=-1))

    def scaled(self, readings: FloatArray, factor: FloatArray) -> FloatArray:
        """Frames (f, n) in units in which their noise is `factor` (f,) times as large; NaN what cannot be used."""
        array = self.finger.array
        rise = (readings - np.asarray(array.offset)) / factor[:, None]
        return np.where(array.usable(readings), rise + np.asarray(array.offset), np.nan)

    def ok(self, readings: FloatArray) -> npt.NDArray[np.bool_]:
        """Which frames (..., n) are OK."""
        return np.asarray(self.locator(readings).status == Status.OK)

    def share_ok(self, frames: FloatArray, misfit: FloatArray) -> float:
        """Share of frames (f, n) that are OK by a finger that believes in `misfit` (n,) noises."""
        if np.ptp(misfit) == 0:  # as good as smaller readings
            return float(self.ok(self.scaled(frames, np.full(len(frames), misfit[0]))).mean())
        array = self.finger.array
        found = self._like(replace(array, noise=misfit * np.asarray(array.noise)))(frames)
        return float((found.status == Status.OK).mean())

    def unknown_slopes(self, position: FloatArray, load: FloatArray) -> FloatArray:
        """Readings by position, half width and components of touches (t,) or (t, 2), (t, d + 1), shape (t, n, u)."""
        response = self.locator.response
        if self.dim == 1:
            moved = np.einsum("tnl,tl->tn", response(position, derivative=1), load)
            return np.concatenate([moved[..., None], response(position)], axis=-1)
        half_width, wider = self.touches.half_width, []
        if half_width is not None:
            ends = [response.at(half_width * (1 + s * _WIDER))(position) for s in (1, -1)]
            wider = [np.einsum("tnl,tl->tn", ends[0] - ends[1], load)[..., None] / (2 * _WIDER * half_width)]
            response = response.at(half_width)
        moved = np.einsum("tnld,tl->tnd", response.slopes(position), load)
        return np.concatenate([moved, *wider, response(position)], axis=-1)

    def strokes(self, count: int, rng: np.random.Generator) -> Any:
        """Touches of a blind calibration, drawn at random: as the finger's own, but on an area by a point."""
        return replace(self.touches, half_width=None).sample(count, rng, self.finger)

    def stroke_slopes(self, load: FloatArray, position: FloatArray) -> FloatArray:
        """Readings of these by what is unknown of each, (t, n, u): its position and its components."""
        if self.touches.half_width is None:
            slopes = self.unknown_slopes(position, load)
        else:
            point = self.locator.response.at(0.0)
            moved = np.einsum("tnld,tl->tnd", point.slopes(position), load)
            slopes = np.concatenate([moved, point(position)], axis=-1)
        return slopes if self.friction != 0 else slopes[..., : -self.dim]

    def slope(self) -> tuple[FloatArray, npt.NDArray[np.bool_]]:
        """Errors (p, a, k, n) per change of each reading, to first order, and where (p, a) there is no such thing.

        (J^T W J)^-1 J^T W, J being the readings' derivatives by the unknowns, W the inverse variances of their noise;
        it does not exist where J is singular.
        """
        array, d, force = self.finger.array, self.dim, self.touches.force
        weight = np.where(array.live, 1 / np.where(array.live, array.noise, 1.0), 0.0)
        p, a = len(self.position), len(self.load)
        every = self.unknown_slopes(np.repeat(self.position, a, axis=0), np.tile(self.load, (p, 1)))
        every = every.reshape(p, a, *every.shape[1:])
        jacobian = (every if self.friction != 0 else every[..., : every.shape[-1] - d]) * weight[:, None]
        size = np.linalg.norm(jacobian, axis=-2, keepdims=True)
        u, s, v = np.linalg.svd(jacobian / np.where(size > 0, size, 1.0), full_matrices=False)
        singular = s[..., -1] <= _SINGULAR * s[..., 0]
        turned = np.swapaxes(v, -1, -2) / np.where(s > 0, s, 1.0)[..., None, :] @ np.swapaxes(u, -1, -2)
        by = turned / np.swapaxes(np.where(size > 0, size, 1.0), -1, -2) * weight
        first = every.shape[-1] - d - 1  # of the components
        parts = np.zeros((p, a, d + 1, len(array)))
        parts[:, :, : by.shape[2] - first] = by[..., first:, :]
        out = np.zeros((p, a, list(self.told.values())[-1].stop, len(array)))
        out[..., self.told["position"], :] = by[..., :d, :]
        out[..., self.told["force"], :] = np.einsum("al,paln->pan", self.load / force**2, parts)[..., None, :]
        if self.friction != 0:
            out[..., self.told["angle"], :] = np.einsum("adl,paln->padn", self._across, parts) / force
        if "radius" in self.told:
            out[..., self.told["radius"], :] = by[..., d : d + 1, :]
        out[singular] = 0.0
        return out, singular


def straight(force: float, dim: int, count: int) -> FloatArray:
    """So many loads straight down, (count, d + 1)."""
    return np.tile(force * np.eye(dim + 1)[0], (count, 1))


def stylus(load: FloatArray, position: FloatArray) -> Any:
    """Presses of a calibration with `load` (c, d + 1): lines, or points on an area."""
    if load.shape[-1] == 2:
        return LineLoad.of_components(load, position)
    return PointLoad(components=load, position=position)


def _in_m(value: FloatArray) -> str:
    return f"{value:.6g}" if np.ndim(value) == 0 else f"({', '.join(f'{v:.6g}' for v in value)})"


def _read_exactly(made: Finger, touch: Any) -> FloatArray:
    """Readings without steps or ends of the range."""
    exact = replace(made.array, low=-np.inf, high=np.inf, resolution=0.0)
    return replace(made, array=exact).read(touch)
