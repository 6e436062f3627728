"""The forward model as a function of a vector of parameters, for `calibrate`: of a row, and of sensors on an area.

An area has a frame of its own, moved and turned; a row is moved. That is all in which the two differ.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from itertools import pairwise
from typing import Any

import numpy as np
import numpy.typing as npt

from .. import _check
from .._axes import turned
from .._check import FloatArray
from ..contact import Hertz, LineLoad, PointLoad, RoundHertz
from ..errors import InvalidValueError
from ..estimate.beside import finger_in_space
from ..finger import Finger

__all__ = ["LINEAR", "TERMS", "Forward", "checked_names", "slices", "terms_of", "touches_at"]

LINEAR = ("gain", "offset", "lift")
"""What readings are linear in, each sensor's own."""
TERMS = ("origin", "turn", "depth", "depths", "position", "poisson", "width", "thickness")
"""Of a row all but the turn, of an area all but the width."""
_PLACES = {1: ("origin",), 2: ("origin_y", "origin_z")}
_UNITS = {"poisson": "", "turn": "rad"}
"""Of what is no length."""
_SIZES = {"poisson": 0.1, "turn": 0.2}
"""What is a typical change of these; of a length it is the mean depth."""
_SLOPE = 1e-4
"""Step of a difference, of a parameter's typical size."""
_MOVE = 1e-3
"""Of a depth, by which a sensor is moved to see the readings change."""
_BLOCK = 4096
"""Touches at a time."""

_ABOVE_BASE = 0.999
"""Deepest that a trial puts a sensor, of the skin's thickness where that is not fitted."""

_ABOVE_CENTRE = 0.9
"""Deepest that a trial puts a sensor in a round finger whose thickness is fitted, of its radius."""

_THICKEST = 0.94
"""Largest thickness of a round finger, of its radius; its core has at least a twentieth of it."""


def terms_of(finger: Finger) -> tuple[str, ...]:
    """The terms that sensors in a row, or on an area, have."""
    without = "width" if finger.array.on_area else "turn"
    return tuple(name for name in TERMS if name != without)


def checked_names(fit: Sequence[str], known: Sequence[str], no_origin: str = "") -> tuple[str, ...]:
    """What to fit, each once, in the order of what is `known`; `no_origin` is what to do where that is not."""
    names = (fit,) if isinstance(fit, str) else _check.several("fit", fit, str, 'fit=["gain", "depth"]')
    for name in names:
        if name not in known:
            fix = no_origin if name == "origin" else ""
            raise InvalidValueError(f'fit = "{name}"', f"has to be among {', '.join(known)}", fix)
    if not names:
        raise InvalidValueError("fit is empty", f"name at least one of {', '.join(known)}", 'fit=["gain", "depth"]')
    if "depth" in names and "depths" in names:
        seen = "fit has both depth and depths"
        raise InvalidValueError(seen, "choose one shift for all, or one depth a sensor", "leave one of them out")
    return tuple(name for name in known if name in names)


def slices(sizes: Mapping[str, int]) -> dict[str, slice]:
    """Where each name stands in a vector, one after the other."""
    ends = np.cumsum([0, *sizes.values()]).tolist()
    return {name: slice(*pair) for name, pair in zip(sizes, pairwise(ends), strict=True)}


def touches_at(components: npt.ArrayLike, positions: FloatArray, half_width: float = 0.0) -> Any:
    """Loads (..., 2) at positions (...), or (..., 3) at (..., 2): lines or points, rollers or balls of a half width."""
    wide = {"half_width": half_width} if half_width else {}
    if np.shape(components)[-1] == 2:
        long: type[LineLoad | Hertz] = Hertz if wide else LineLoad
        return long.of_components(components, positions, **wide)
    local: type[PointLoad | RoundHertz] = RoundHertz if wide else PointLoad
    return local(components=components, position=positions, **wide)


def _with_none(values: FloatArray) -> FloatArray:
    """Numbers (..., k) and a 0 after them."""
    return np.concatenate([values, np.zeros((*values.shape[:-1], 1))], axis=-1)


class Forward:
    """A finger whose geometry and material depend on a vector p: the terms of `names`, in the order of `TERMS`.

    Touches lie at origin + R(turn) (their position on the finger), and drags turn with them; a row knows no turn. Where
    turn is not fitted it is the `fixed` one [rad]. `position` moves each sensor along the row, or in y and z; the mean
    position stays as drawn where the origin is fitted too, and the mean turn where that is. `thickness` is what lies
    beneath the deepest sensor, and without it the depths end at the base: no sensor leaves the skin on the way. A
    finger with a response measured in place reads by that. Touches on a row are lines, or `points` on it.
    """

    def __init__(self, finger: Finger, names: Sequence[str], fixed: float = 0.0, *, points: bool = False) -> None:
        self.finger, self.fixed, self.points = finger, fixed, points
        self.dim = 2 if finger.array.on_area else 1
        self.names = tuple(t for t in terms_of(finger) if t in names)
        material = finger.skin.single_material
        self.poisson = 0.5 if material is None else material.poisson
        for name in ("poisson", "thickness"):
            there = material is not None and (name == "poisson" or np.isfinite(finger.skin.thickness))
            if name in self.names and not there:
                rule = f"a {type(finger.skin).__name__} like this has no single {name}"
                fix = "one layer on a rigid base and a round finger have both; a half plane has poisson"
                raise InvalidValueError(f"fit = {name}", rule, fix)
        n, sites = len(finger.array), finger.array.points[:, : self.dim]
        rigid = [np.tile(unit, (n, 1)) for unit in np.eye(self.dim)] if "origin" in self.names else []
        if "turn" in self.names:
            arm = sites - sites.mean(axis=0)
            rigid.append(np.stack([-arm[:, 1], arm[:, 0]], axis=-1))
        held = np.stack([r.reshape(-1) for r in rigid], axis=-1) if rigid else np.zeros((self.dim * n, 0))
        # moves of the sensors that are no move, and no turn, of the whole
        self._free = np.linalg.qr(held, mode="complete")[0][:, held.shape[1] :]
        counts = {"origin": self.dim, "depths": n, "position": self._free.shape[1]}
        self.slices = slices({name: counts.get(name, 1) for name in self.names})
        self.size = sum(part.stop - part.start for part in self.slices.values())

    @property
    def depth(self) -> slice | None:
        """Where the depths are in p, if they are among the unknowns."""
        return self.slices.get("depths", self.slices.get("depth"))

    def _depths(self) -> FloatArray:
        return np.asarray(self.finger.array.depth)

    @property
    def _radius(self) -> float:
        return self.finger.skin.period / (2 * np.pi)

    def _filled(self, values: Mapping[str, Any], usual: float) -> FloatArray:
        """A vector like p, of the value of each name."""
        out = np.full(self.size, usual)
        for name in self.names:
            out[self.slices[name]] = values.get(name, usual)
        return out

    def start(self, origin: Any, depth_factor: float = 1.0, height: float = 3.0) -> FloatArray:
        """Starting values: the finger as drawn, with the given origin, depths scaled, and `height` of these thick.

        Within the bounds.
        """
        depths = self._depths()
        values = {
            "origin": origin,
            "depth": (depth_factor - 1) * depths.mean(),
            "depths": (depth_factor - 1) * depths,
            # away from the ends of its range, where a step in either direction is possible
            "poisson": min(self.poisson, 0.45),
            "thickness": (height - 1) * depth_factor * float(depths.max()),
            "width": max(float(np.asarray(self.finger.array.width).mean()), 0.2 * float(depths.min())),
        }
        return np.clip(self._filled(values, 0.0), *self.bounds())

    def bounds(self) -> tuple[FloatArray, FloatArray]:
        """Lower and upper bounds of p."""
        depths = self._depths()
        if "thickness" in self.names:
            deepest = _ABOVE_CENTRE * self._radius
        else:
            deepest = _ABOVE_BASE * self.finger.skin.thickness
        room = np.maximum(deepest - depths, 0.0)
        ranges = {
            "depth": (-0.9 * depths.min(), min(4 * depths.max(), room.min())),
            "depths": (-0.9 * depths, np.minimum(4 * depths, room)),
            "position": (-depths.max(), depths.max()),
            "poisson": (0.0, 0.5),
            "width": (0.0, 4 * depths.max()),
            "thickness": (0.0, min(100 * depths.max(), _THICKEST * self._radius)),
        }
        low, high = ({name: ends[side] for name, ends in ranges.items()} for side in (0, 1))
        return self._filled(low, -np.inf), self._filled(high, np.inf)

    def scale(self) -> FloatArray:
        """A typical size of each element of p."""
        return self._filled(_SIZES, float(self._depths().mean()))

    def origin(self, p: FloatArray, fixed: Any) -> Any:
        """The origin in p, or the fixed one: a number, on an area (2,)."""
        at = np.array(p[self.slices["origin"]]) if "origin" in self.names else np.asarray(fixed)
        return at if self.dim == 2 else float(at.reshape(()))

    def turn(self, p: FloatArray) -> float:
        """By how much the finger's y lies turned from the motor's [rad]."""
        return float(p[self.slices["turn"]][0]) if "turn" in self.names else self.fixed

    def placed(self, p: FloatArray, origin: Any, turn: float | None = None) -> FloatArray:
        """The parameters p with another origin and turn, where these are among them."""
        out = p.copy()
        for name, value in (("origin", origin), ("turn", turn)):
            if name in self.names and value is not None:
                out[self.slices[name]] = value
        return out

    def moved(
        self, p: FloatArray, fixed: Any, positions: FloatArray, load: FloatArray
    ) -> tuple[FloatArray, FloatArray]:
        """Touches at `positions` of the motor, (..., m) or (..., m, 2), with `load`, as they lie on the finger.

        load: (N, T) (m, 2), or (N, Ty, Tz) (m, 3).
        """
        away = positions - self.origin(p, fixed)
        if self.dim == 1:
            return away, load
        back = turned(self.turn(p))  # of rows
        return away @ back, np.column_stack([load[:, :1], load[:, 1:] @ back])

    def apply(self, p: FloatArray) -> Finger:
        """The finger with the parameters p."""
        array, skin = self.finger.array, self.finger.skin
        changes: dict[str, Any] = {}
        if self.depth:
            changes["depth"] = self._depths() + p[self.depth]
        if "position" in self.names:
            moves = (self._free @ p[self.slices["position"]]).reshape(len(array), self.dim)
            changes |= {
                axis: np.asarray(getattr(array, axis)) + move for axis, move in zip("yz", moves.T, strict=False)
            }
        if "width" in self.names:
            changes["width"] = np.broadcast_to(p[self.slices["width"]], (len(array),))
        if "poisson" in self.names:
            (material,) = skin.materials
            poisson = float(p[self.slices["poisson"]][0])
            skin = skin.with_(materials=[replace(material, poisson=poisson)])
        if "thickness" in self.names:
            deepest = float(np.max(changes.get("depth", self._depths())))
            thickness = min(deepest + float(p[self.slices["thickness"]][0]), _THICKEST * self._radius)
            skin = skin.with_(thickness=thickness)
        return Finger(skin, replace(array, **changes))

    def pooled(self, noise: FloatArray, gain: FloatArray) -> FloatArray:
        """Each sensor's noise (n,), by its own residuals; on an area in proportion to the gains.

        There touches near a sensor are too few to know its own.
        """
        kinds, size, out = self.finger.array.transducers, np.abs(gain), noise.copy()
        for kind in set(kinds) if self.dim == 2 else ():
            same = np.array([k == kind for k in kinds]) & (size > 0)
            out[same] = size[same] * np.sqrt(np.mean((noise[same] / size[same]) ** 2)) if same.any() else noise[same]
        return out

    def unit(self, p: FloatArray, positions: FloatArray, load: FloatArray) -> FloatArray:
        """What unit gains would read, shape (..., m, n): touches at `positions` of the finger with `load`."""
        known = self.finger.measured
        if known is not None:
            components = np.broadcast_to(load, (*positions.shape[:-1], 3))
            read = (known(positions) * components[..., None, : known.components]).sum(axis=-1)
            return np.asarray(read / np.asarray(self.finger.array.gain))
        if self.dim == 2:
            load = np.broadcast_to(load, (*positions.shape[:-1], 3))
        found = self.apply(p)
        if self.points:
            found = finger_in_space(found)
            load, positions = _with_none(load), _with_none(positions[..., None])
        return found.measure(touches_at(load, positions), linear=True)

    def from_origins(
        self, p: FloatArray, origins: Sequence[Any], positions: FloatArray, load: FloatArray
    ) -> Iterator[FloatArray]:
        """What unit gains would read with each of the origins: the touches move together, and the finger stays."""
        step, at, still = max(1, _BLOCK // len(positions)), np.asarray(origins), self.placed(p, 0.0)
        for i in range(0, len(at), step):
            yield from self.unit(still, *self.moved(still, 0.0, positions - at[i : i + step, None], load))

    def readings(self, p: FloatArray, positions: FloatArray, load: FloatArray) -> FloatArray:
        """Readings with the finger's own gains, lifts and offsets, shape (m, n)."""
        array = self.finger.array
        lifted = np.asarray(array.lift) * load[:, :1] + np.asarray(array.offset)
        return np.asarray(np.asarray(array.gain) * self.unit(p, positions, load) + lifted)

    def jacobian(
        self, p: FloatArray, fixed: Any, touches: tuple[FloatArray, FloatArray], gain: FloatArray, names: Sequence[str]
    ) -> FloatArray:
        """Change of readings with p by differences, then with the gains, offsets and lifts of `names`, (m, n, numbers).

        touches: positions of the motor and loads, as of `moved`.
        """
        columns, n = [], gain.size
        lower, upper = self.bounds()
        for k, h in enumerate(_SLOPE * self.scale()):
            ends = [p.copy(), p.copy()]
            ends[0][k], ends[1][k] = min(p[k] + h, upper[k]), max(p[k] - h, lower[k])
            after, before = (self.unit(end, *self.moved(end, fixed, *touches)) for end in ends)
            columns.append((gain * (after - before) / (ends[0][k] - ends[1][k]))[..., None])
        unit, load = self.unit(p, *self.moved(p, fixed, *touches)), touches[1]
        each = zip(LINEAR, np.broadcast_arrays(unit, 1.0, load[:, :1]), strict=True)
        columns += [values[..., None] * np.eye(n) for name, values in each if name in names]
        return np.concatenate(columns, axis=-1)

    def slopes(self, p: FloatArray, positions: FloatArray, load: FloatArray) -> FloatArray:
        """Change of what unit gains would read with the sensor's y, z and depth [1/depth] and with the load, (m, n, 4).

        Of touches on an area. A response measured in place knows of no position and no depth of a sensor: of these it
        is 0.
        """
        read = self.unit(p, positions, load)
        out = np.zeros((*read.shape, 4))
        out[..., 3] = read
        if self.finger.measured is None:
            found = self.apply(p)
            depths = np.asarray(found.array.depth)
            step = _MOVE * float(depths.mean())
            for k, move in enumerate(np.eye(2)):  # a sensor that moves on is a touch that falls back
                ahead, back = (self.unit(p, positions + side * step * move, load) for side in (1, -1))
                out[..., k] = (back - ahead) / (2 * _MOVE)
            higher = replace(found, array=replace(found.array, depth=depths - step))
            out[..., 2] = (read - higher.measure(touches_at(load, positions), linear=True)) / _MOVE
        return out

    def starts(self, data: FloatArray, positions: FloatArray, fixed: Any) -> list[tuple[Any, float]]:
        """Origins and turns to begin with, all over the touches; on an area first where each sensor reads most."""
        points, out = self.finger.array.points[:, : self.dim], []
        at = positions.reshape(len(positions), self.dim)
        if self.dim == 2:
            weight = np.nan_to_num(data - np.nanmedian(data, axis=0)) ** 2
            weight = weight / np.maximum(weight.sum(axis=0), 1e-300)
            felt, mean = weight.T @ positions, points.mean(axis=0)
            if len(points) > 1 and "turn" in self.names:
                left, _, right = np.linalg.svd((felt - felt.mean(axis=0)).T @ (points - mean))
                rotation = left @ np.diag([1.0, np.sign(np.linalg.det(left @ right))]) @ right
                turn = float(np.arctan2(rotation[1, 0], rotation[0, 0]))
                out.append((felt.mean(axis=0) - rotation @ mean, turn))
            points = points @ turned(self.fixed).T
            out.append((felt.mean(axis=0) - points.mean(axis=0), self.fixed))
        step, least, most = {1: (0.25, 8, None), 2: (0.5, 4, 24)}[self.dim]
        step *= float(np.asarray(self.finger.array.depth).min())
        ends = zip(at.min(axis=0) - points.max(axis=0), at.max(axis=0) - points.min(axis=0), strict=True)
        axes = [np.linspace(low, high, int(np.clip((high - low) / step, least, most))) for low, high in ends]
        grid = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, *positions.shape[1:])
        return out + [(each, self.fixed) for each in grid]

    def expansion(self, p: FloatArray) -> FloatArray:
        """How what is reported follows from p, shape (reported, size).

        Positions of sensors are moves that are free; the thickness goes down from the deepest sensor.
        """
        rows = [np.eye(self.size)[self.slices[name]] for name in self.names]
        if "thickness" in self.names and self.depth:
            deepest = int(np.argmax(self._depths() + p[self.depth])) if "depths" in self.names else 0
            rows[self.names.index("thickness")][0, self.depth.start + deepest] = 1.0
        if "position" in self.names:
            i = self.names.index("position")
            rows[i] = self._free @ rows[i]
        return np.concatenate(rows) if rows else np.zeros((0, 0))

    def parameters(self, p: FloatArray, sensors: npt.NDArray[np.intp]) -> list[tuple[str, int | None, float, str]]:
        """(name, sensor, value, unit) of what is reported, in absolute values."""
        fitted = self.apply(p)
        depths = np.asarray(fitted.array.depth)
        each = {
            "depths": {"depth": depths},
            "position": dict(zip("yz", fitted.array.points[:, : self.dim].T, strict=False)),
        }
        whole = {"depth": depths.mean(), "thickness": fitted.skin.thickness}
        out: list[tuple[str, int | None, float, str]] = []
        for name in self.names:
            if name in each:
                rows = zip(sensors, *each[name].values(), strict=True)
                out += [
                    (label, int(i), float(v), "m") for i, *row in rows for label, v in zip(each[name], row, strict=True)
                ]
            elif name == "origin":
                out += [
                    (label, None, float(v), "m")
                    for label, v in zip(_PLACES[self.dim], p[self.slices[name]], strict=True)
                ]
            else:
                out.append((name, None, float(whole.get(name, p[self.slices[name]][0])), _UNITS.get(name, "m")))
        return out
