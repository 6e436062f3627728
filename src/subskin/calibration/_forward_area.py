"""The forward model of a finger with sensors on an area, for `calibrate`: a frame of its own, moved and turned."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import numpy.typing as npt

from .._axes import turned
from .._check import FloatArray
from ..contact import PointLoad
from ..finger import Finger
from ._forward import Forward

__all__ = ["AREA_TERMS", "AreaForward", "forward_of", "with_origin"]

AREA_TERMS = ("origin", "turn", "depth", "depths", "position", "poisson", "thickness")
_TURN = 0.2
_STEP = 1e-3
"""Of a depth, by which a sensor is moved to see the readings change."""
_BLOCK = 4096


class AreaForward(Forward):
    """As `Forward`, of point loads at (y, z): touches lie at origin + R(turn) (their position on the finger).

    Drags turn with the positions. `position` moves each sensor in y and z; the mean position stays as drawn where the
    origin is fitted too, and the mean turn where that is. Where turn is not fitted it is the `fixed` one [rad]. A
    finger with a response measured in place reads by that.
    """

    terms = AREA_TERMS

    def __init__(self, finger: Finger, names: Sequence[str], fixed: float = 0.0) -> None:
        super().__init__(finger, names)
        self.tied, self.fixed = False, fixed

    def _counts(self, names: Sequence[str], sensors: int) -> dict[str, int]:
        points = self.finger.array.points
        arm = points - points.mean(axis=0)
        rigid = [np.tile(unit, (sensors, 1)) for unit in np.eye(2)] if "origin" in names else []
        if "turn" in names:
            rigid.append(np.stack([-arm[:, 1], arm[:, 0]], axis=-1))
        held = np.stack([r.reshape(-1) for r in rigid], axis=-1) if rigid else np.zeros((2 * sensors, 0))
        # moves of the sensors that are no move, and no turn, of the whole
        self._free = np.linalg.qr(held, mode="complete")[0][:, held.shape[1] :]
        return {"origin": 2, "depths": sensors, "position": self._free.shape[1]}

    def scale(self) -> FloatArray:
        """A typical size of each element of p."""
        out = super().scale()
        if "turn" in self.names:
            out[self.slices["turn"]] = _TURN
        return out

    def origin(self, p: FloatArray, fixed: Any) -> Any:
        """The origin in p, or the fixed one, (2,)."""
        return np.array(p[self.slices["origin"]]) if "origin" in self.names else np.asarray(fixed)

    def turn(self, p: FloatArray) -> float:
        """By how much the finger's y lies turned from the motor's [rad]."""
        return float(p[self.slices["turn"]][0]) if "turn" in self.names else self.fixed

    def moved(
        self, p: FloatArray, fixed: Any, positions: FloatArray, load: FloatArray
    ) -> tuple[FloatArray, FloatArray]:
        """Touches at `positions` (..., m, 2) of the motor with `load` (m, 3), as they lie on the finger."""
        back = turned(self.turn(p))  # of rows
        leaning = np.column_stack([load[:, :1], load[:, 1:] @ back])
        return (positions - self.origin(p, fixed)) @ back, leaning

    def _moves(self, p: FloatArray) -> dict[str, FloatArray]:
        moves = (self._free @ p[self.slices["position"]]).reshape(-1, 2)
        array = self.finger.array
        return {"y": np.asarray(array.y) + moves[:, 0], "z": np.asarray(array.z) + moves[:, 1]}

    def unit(self, p: FloatArray, positions: FloatArray, load: FloatArray) -> FloatArray:
        """What unit gains would read, shape (..., m, n): touches at (..., m, 2) with loads (N, Ty, Tz) (m, 3)."""
        components, known = np.broadcast_to(load, (*positions.shape[:-1], 3)), self.finger.measured
        if known is not None:
            read = (known(positions) * components[..., None, : known.components]).sum(axis=-1)
            return np.asarray(read / np.asarray(self.finger.array.gain))
        return self.apply(p).measure(PointLoad(components=components, position=positions), linear=True)

    def slopes(self, p: FloatArray, positions: FloatArray, load: FloatArray) -> FloatArray:
        """Change of what unit gains would read with the sensor's y, z and depth [1/depth] and with the load, (m, n, 4).

        A response measured in place knows of no position and no depth of a sensor: of these it is 0.
        """
        read = self.unit(p, positions, load)
        out = np.zeros((*read.shape, 4))
        out[..., 3] = read
        if self.finger.measured is None:
            found = self.apply(p)
            depths = np.asarray(found.array.depth)
            step = _STEP * float(depths.mean())
            for k, move in enumerate(np.eye(2)):  # a sensor that moves on is a touch that falls back
                ahead, back = (self.unit(p, positions + side * step * move, load) for side in (1, -1))
                out[..., k] = (back - ahead) / (2 * _STEP)
            higher = replace(found, array=replace(found.array, depth=depths - step))
            touches = PointLoad(components=load, position=positions)
            out[..., 2] = (read - higher.measure(touches, linear=True)) / _STEP
        return out

    def from_origins(
        self, p: FloatArray, origins: Sequence[Any], positions: FloatArray, load: FloatArray
    ) -> Iterator[FloatArray]:
        """What unit gains would read with each of the origins: the touches move together, and the finger stays."""
        step, at, still = max(1, _BLOCK // len(positions)), np.asarray(origins), with_origin(self, p, 0.0)
        for i in range(0, len(at), step):
            yield from self.unit(still, *self.moved(still, 0.0, positions - at[i : i + step, None], load))

    def pooled(self, noise: FloatArray, gain: FloatArray) -> FloatArray:
        """Noise (n,) in proportion to the gains: touches near a sensor are too few to know its own."""
        kinds, size, out = self.finger.array.transducers, np.abs(gain), noise.copy()
        for kind in set(kinds):
            same = np.array([k == kind for k in kinds]) & (size > 0)
            out[same] = size[same] * np.sqrt(np.mean((noise[same] / size[same]) ** 2)) if same.any() else noise[same]
        return out

    def starts(self, data: FloatArray, positions: FloatArray, fixed: Any) -> list[tuple[FloatArray, float]]:
        """Origins and turns to begin with: where each sensor reads most, and all over the touches, not turned."""
        points = self.finger.array.points
        weight = np.nan_to_num(data - np.nanmedian(data, axis=0)) ** 2
        weight = weight / np.maximum(weight.sum(axis=0), 1e-300)
        felt, mean = weight.T @ positions, points.mean(axis=0)
        out = []
        if len(points) > 1 and "turn" in self.names:
            left, _, right = np.linalg.svd((felt - felt.mean(axis=0)).T @ (points - mean))
            rotation = left @ np.diag([1.0, np.sign(np.linalg.det(left @ right))]) @ right
            turn = float(np.arctan2(rotation[1, 0], rotation[0, 0]))
            out.append((felt.mean(axis=0) - rotation @ mean, turn))
        points = points @ turned(self.fixed).T
        out.append((felt.mean(axis=0) - points.mean(axis=0), self.fixed))
        step = 0.5 * float(np.asarray(self.finger.array.depth).min())
        ends = zip(positions.min(axis=0) - points.max(axis=0), positions.max(axis=0) - points.min(axis=0), strict=True)
        axes = [np.linspace(low, high, int(np.clip((high - low) / step, 4, 24))) for low, high in ends]
        grid = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 2)
        return out + [(at, self.fixed) for at in grid]

    def expansion(self, p: FloatArray) -> FloatArray:
        """How what is reported follows from p, shape (reported, size)."""
        own = super().expansion(p)
        if "position" not in self.names:
            return own
        part = self.slices["position"]
        rows = np.zeros((len(self._free), self.size))
        rows[:, part] = self._free
        return np.concatenate([own[: part.start], rows, own[part.stop :]])

    def parameters(self, p: FloatArray, sensors: npt.NDArray[np.intp]) -> list[tuple[str, int | None, float, str]]:
        """(name, sensor, value, unit) of what is reported, in absolute values."""
        fitted = self.apply(p)
        out: list[tuple[str, int | None, float, str]] = []
        for name, sensor, value, unit in super().parameters(p, sensors):
            if name == "origin":
                y, z = self.origin(p, 0)
                out += [("origin_y", None, float(y), "m"), ("origin_z", None, float(z), "m")]
            elif name == "turn":
                out.append((name, sensor, value, "rad"))
            elif name == "y":
                index = int(np.flatnonzero(sensors == sensor)[0])
                out += [("y", sensor, value, unit), ("z", sensor, float(np.asarray(fitted.array.z)[index]), unit)]
            else:
                out.append((name, sensor, value, unit))
        return out


def forward_of(finger: Finger, names: Sequence[str], turn: float = 0.0) -> Forward:
    """The forward model of a finger with sensors in a row, or on an area, there turned by `turn` [rad]."""
    return AreaForward(finger, names, turn) if finger.array.on_area else Forward(finger, names)


def with_origin(forward: Forward, p: FloatArray, origin: Any, turn: float | None = None) -> FloatArray:
    """The parameters p with another origin and turn, where these are among them."""
    out = p.copy()
    for name, value in (("origin", origin), ("turn", turn)):
        if name in forward.names and value is not None:
            out[forward.slices[name]] = value
    return out
