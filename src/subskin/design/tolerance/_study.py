"""What `locate` makes of a finger that is not as drawn, touch by touch."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from ..._check import FloatArray
from ..._frozen import Frozen
from ...array import SensorArray
from ...contact import LineLoad
from ...errors import GeometryError, InvalidValueError
from ...estimate import Locator, Status
from ...estimate.locate import row_locator
from ...finger import Finger
from ..touches import Touches

_FORCED = 1e-12
_EXPLAINED = 90.0
"""What a load explains of chi-square in a frame that is located whatever its status: well above the least, 55."""

_SINGULAR = 1e-6
"""Ratio of singular values, columns being scaled: with it, first order means nothing."""


@dataclass(frozen=True, eq=False)
class Located(Frozen):
    """Errors (..., p, a, 3) of position [m], of force relative to the true one and of angle [rad]; which are OK."""

    errors: FloatArray
    ok: npt.NDArray[np.bool_]


class Study:
    """Touches on a grid of positions (p,) [m] and angles (a,) [rad], and the finger that locates them.

    That is the finger as drawn; `friction` and `search` are those of `locate`.
    """

    def __init__(
        self,
        finger: Finger,
        touches: Touches,
        position: FloatArray,
        angle: FloatArray,
        friction: float,
        search: tuple[float, float] | None,
    ) -> None:
        self.finger, self.touches, self.position, self.angle = finger, touches, position, angle
        self.friction, self.search = friction, search
        needed, live = 2 if friction == 0 else 3, int(finger.array.live.sum())
        if live < needed:
            raise InvalidValueError(f"{live} sensors that respond", f"locate needs at least {needed}", "more sensors")
        self.locator = row_locator(finger, search=search, friction=friction)
        field = self.locator.response
        if position.min() < field.start or position.max() > field.stop:
            raise GeometryError(
                f"touches from {position.min():.6g} to {position.max():.6g} m",
                f"loads are looked for from {field.start:.6g} to {field.stop:.6g} m",
                "a narrower span, or a wider search",
            )
        unbounded = replace(finger.array, low=-np.inf, high=np.inf)
        self._forced = Locator(field, unbounded, friction=friction, false_alarm=_FORCED)
        self._linear = all(t.linear for t in finger.array.transducers)
        self.load = touches.force * np.stack([np.cos(angle), np.sin(angle)], axis=-1)  # (a, 2)

    def of(self, finger: Finger) -> Study:
        """The same touches, located by another finger."""
        return Study(finger, self.touches, self.position, self.angle, self.friction, self.search)

    def readings(self, made: Finger) -> FloatArray:
        """What the touches read on a finger, without noise, steps or ends of the range, shape (p, a, n)."""
        if self._linear:
            field = made.receptive_field(self.position)
            return np.asarray(np.einsum("pnl,al->pan", field, self.load) + np.asarray(made.array.offset))
        return _read_exactly(made, LineLoad(self.touches.force, self.angle, self.position[:, None]))

    def pressed(self, made: Finger, presses: LineLoad) -> FloatArray:
        """The same of other line loads (c,), shape (c, n)."""
        if not self._linear:
            return _read_exactly(made, presses)
        load = presses.force * np.stack(np.broadcast_arrays(np.cos(presses.angle), np.sin(presses.angle)), axis=-1)
        field = made.receptive_field(np.asarray(presses.position))
        return np.asarray((field @ np.asarray(load)[..., None])[..., 0] + np.asarray(made.array.offset))

    def readings_of(self, made: Sequence[Finger]) -> FloatArray:
        """The same on several fingers, shape (k, p, a, n): at one go where they differ in their sensors alone."""
        skin, n = made[0].skin, len(made[0].array)
        if not self._linear or any(finger.skin is not skin for finger in made):
            return np.stack([self.readings(finger) for finger in made])
        arrays = [finger.array for finger in made]
        names = ("y", "depth", "gain", "offset", "width")
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
        position, force, angle = (np.array(getattr(found, name)) for name in ("position", "force", "angle"))
        none = np.isnan(position) & (found.status != Status.INCOMPLETE)
        if none.any():
            array = self.finger.array
            seen = array.usable(readings[none])
            offset, noise = np.asarray(array.offset), np.where(array.live, array.noise, 1.0)
            rise = np.where(seen, readings[none] - offset, 0.0)
            explained = ((rise / noise) ** 2).sum(axis=-1) - found.residual[none]
            scale = np.sqrt(np.maximum(explained, np.finfo(float).tiny) / _EXPLAINED)[:, None]
            again = self._forced(np.where(seen, rise / scale + offset, np.nan))
            position[none], angle[none] = again.position, again.angle
            force[none] = again.force * scale[:, 0]
        errors = np.stack(
            [position - self.position[:, None], force / self.touches.force - 1, angle - self.angle], axis=-1
        )
        return Located(errors, np.asarray(found.status == Status.OK))

    def slope(self) -> tuple[FloatArray, npt.NDArray[np.bool_]]:
        """Errors (p, a, 3, n) per change of each reading, to first order, and where (p, a) there is no such thing.

        (J^T W J)^-1 J^T W, J being the readings' derivatives by position, normal and tangential force, W the inverse
        variances of their noise; it does not exist where J is singular.
        """
        array = self.finger.array
        weight = np.where(array.live, 1 / np.where(array.live, array.noise, 1.0), 0.0)
        table = self.locator.response
        shape = (self.position.size, self.angle.size, len(array))
        moved = np.einsum("pnl,al->pan", table(self.position, derivative=1), self.load)
        field = table(self.position)[:, None]
        columns = [moved, *(np.broadcast_to(field[..., k], shape) for k in range(1 if self.friction == 0 else 2))]
        jacobian = np.stack(columns, axis=-1) * weight[:, None]
        size = np.linalg.norm(jacobian, axis=-2, keepdims=True)
        u, s, v = np.linalg.svd(jacobian / np.where(size > 0, size, 1.0), full_matrices=False)
        singular = s[..., -1] <= _SINGULAR * s[..., 0]
        turned = np.swapaxes(v, -1, -2) / np.where(s > 0, s, 1.0)[..., None, :] @ np.swapaxes(u, -1, -2)
        by = turned / np.swapaxes(np.where(size > 0, size, 1.0), -1, -2) * weight
        out = np.zeros((*shape[:2], 3, shape[2]))
        cos, sin = np.cos(self.angle)[:, None], np.sin(self.angle)[:, None]
        out[..., 0, :] = by[..., 0, :]
        out[..., 1, :] = cos * by[..., 1, :] / self.touches.force
        if self.friction != 0:
            out[..., 1, :] += sin * by[..., 2, :] / self.touches.force
            out[..., 2, :] = (cos * by[..., 2, :] - sin * by[..., 1, :]) / self.touches.force
        out[singular] = 0.0
        return out, singular


def _read_exactly(made: Finger, touch: LineLoad) -> FloatArray:
    """Readings without steps or ends of the range."""
    exact = replace(made.array, low=-np.inf, high=np.inf, resolution=0.0)
    return replace(made, array=exact).read(touch)
