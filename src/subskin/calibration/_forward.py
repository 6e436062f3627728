"""The forward model as a function of a vector of parameters, for `calibrate`."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import numpy.typing as npt

from .._check import FloatArray
from ..contact import LineLoad
from ..errors import InvalidValueError
from ..finger import Finger

__all__ = ["TERMS", "Forward"]

TERMS = ("origin", "depth", "depths", "position", "poisson", "width", "thickness")
_UNITS = {
    "origin": "m", "depth": "m", "depths": "m", "position": "m", "poisson": "", "width": "m", "thickness": "m",
}  # fmt: skip
_ABOVE_BASE = 0.999
"""Deepest that a trial puts a sensor, of the skin's thickness where that is not fitted."""

_ABOVE_CENTRE = 0.9
"""Deepest that a trial puts a sensor in a round finger whose thickness is fitted, of its radius."""

_THICKEST = 0.94
"""Largest thickness of a round finger, of its radius; its core has at least a twentieth of it."""


class Forward:
    """A finger whose geometry and material depend on a vector p: the terms of `names`, in the order of `TERMS`.

    `position` moves each sensor along the row; where the origin is fitted too, the mean place stays as drawn.
    `thickness` is what lies beneath the deepest sensor, and without it the depths end at the
    base: no sensor leaves the skin on the way.
    """

    def __init__(self, finger: Finger, names: Sequence[str]) -> None:
        self.finger = finger
        self.names = tuple(t for t in TERMS if t in names)
        n = len(finger.array)
        self.tied = "position" in self.names and "origin" in self.names and n > 1
        material = finger.skin.single_material
        self.poisson = 0.5 if material is None else material.poisson
        for name in ("poisson", "thickness"):
            if name in self.names and (
                material is None or (name == "thickness" and not np.isfinite(finger.skin.thickness))
            ):
                raise InvalidValueError(
                    f"fit = {name}",
                    f"a {type(finger.skin).__name__} like this has no single {name}",
                    "one layer on a rigid base and a round finger have both; a half plane has poisson",
                )
        counts = {"depths": n, "position": n - 1 if self.tied else n}
        self.slices: dict[str, slice] = {}
        at = 0
        for name in self.names:
            self.slices[name] = slice(at, at + counts.get(name, 1))
            at += counts.get(name, 1)
        self.size = at

    @property
    def has_depth(self) -> bool:
        """Whether the depth is among the unknowns."""
        return "depth" in self.names or "depths" in self.names

    def _depths(self) -> FloatArray:
        return np.asarray(self.finger.array.depth)

    @property
    def _radius(self) -> float:
        return self.finger.skin.period / (2 * np.pi)

    def start(self, origin: float, depth_factor: float = 1.0, height: float = 3.0) -> FloatArray:
        """Starting values: the finger as drawn, with the given origin, depths scaled, and `height` of these thick.

        Within the bounds.
        """
        p = np.zeros(self.size)
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
        for name in self.names:
            p[self.slices[name]] = values.get(name, 0.0)
        return np.clip(p, *self.bounds())

    def bounds(self) -> tuple[FloatArray, FloatArray]:
        """Lower and upper bounds of p."""
        depths = self._depths()
        low, high = np.full(self.size, -np.inf), np.full(self.size, np.inf)
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
        for name, (a, b) in ranges.items():
            if name in self.names:
                low[self.slices[name]], high[self.slices[name]] = a, b
        return low, high

    def scale(self) -> FloatArray:
        """A typical size of each element of p."""
        out = np.full(self.size, float(self._depths().mean()))
        if "poisson" in self.names:
            out[self.slices["poisson"]] = 0.1
        return out

    def origin(self, p: FloatArray, fixed: float) -> float:
        """The origin in p, or the fixed one."""
        return float(p[self.slices["origin"]][0]) if "origin" in self.names else fixed

    def _positions(self, p: FloatArray) -> FloatArray:
        moves = p[self.slices["position"]]
        return np.append(moves, -moves.sum()) if self.tied else moves

    def apply(self, p: FloatArray) -> Finger:
        """The finger with the parameters p."""
        array, skin = self.finger.array, self.finger.skin
        changes: dict[str, Any] = {}
        if self.has_depth:
            changes["depth"] = self._depths() + p[self.slices["depths" if "depths" in self.names else "depth"]]
        if "position" in self.names:
            changes["y"] = np.asarray(array.y) + self._positions(p)
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

    def unit(self, p: FloatArray, positions: FloatArray, load: FloatArray) -> FloatArray:
        """What unit gains would read, shape (m, n): touches at `positions` (m,) with loads (N, T) (m, 2)."""
        return self.apply(p).measure(LineLoad.of_components(load, positions), linear=True)

    def readings(self, p: FloatArray, positions: FloatArray, load: FloatArray) -> FloatArray:
        """Readings with the finger's own gains and offsets, shape (m, n)."""
        array = self.finger.array
        return np.asarray(np.asarray(array.gain) * self.unit(p, positions, load) + np.asarray(array.offset))

    def expansion(self, p: FloatArray) -> FloatArray:
        """How what is reported follows from p, shape (reported, size).

        The last of tied places is minus the others; the thickness goes down from the deepest sensor.
        """
        rows = [np.eye(self.size)[self.slices[name]] for name in self.names]
        if "thickness" in self.names and self.has_depth:
            part = self.slices["depths" if "depths" in self.names else "depth"]
            deepest = int(np.argmax(self._depths() + p[part])) if "depths" in self.names else 0
            rows[self.names.index("thickness")][0, part.start + deepest] = 1.0
        if self.tied:
            i = self.names.index("position")
            rows[i] = np.concatenate([rows[i], -rows[i].sum(axis=0, keepdims=True)])
        return np.concatenate(rows) if rows else np.zeros((0, 0))

    def parameters(self, p: FloatArray, sensors: npt.NDArray[np.intp]) -> list[tuple[str, int | None, float, str]]:
        """(name, sensor, value, unit) of what is reported, in absolute values."""
        fitted = self.apply(p)
        out: list[tuple[str, int | None, float, str]] = []
        for name in self.names:
            part = self.slices[name]
            values = p[part]
            if name == "depth":
                values = np.atleast_1d(np.asarray(fitted.array.depth).mean())
            elif name == "depths":
                values = np.asarray(fitted.array.depth)
            elif name == "position":
                values = np.asarray(fitted.array.y)
            elif name == "thickness":
                values = np.atleast_1d(fitted.skin.thickness)
            each = name in ("depths", "position")
            label = {"depths": "depth", "position": "y"}.get(name, name)
            out += [
                (label, int(sensors[i]) if each else None, float(value), _UNITS[name]) for i, value in enumerate(values)
            ]
        return out
