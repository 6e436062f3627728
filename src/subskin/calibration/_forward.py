"""The forward model as a function of a vector of parameters, for `calibrate`."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from itertools import pairwise
from typing import Any

import numpy as np
import numpy.typing as npt

from .. import _check
from .._check import FloatArray
from ..contact import LineLoad
from ..errors import InvalidValueError
from ..finger import Finger

__all__ = ["TERMS", "Forward", "checked_names", "slices"]

TERMS = ("origin", "depth", "depths", "position", "poisson", "width", "thickness")
_BLOCK = 4096
"""Touches at a time."""

_ABOVE_BASE = 0.999
"""Deepest that a trial puts a sensor, of the skin's thickness where that is not fitted."""

_ABOVE_CENTRE = 0.9
"""Deepest that a trial puts a sensor in a round finger whose thickness is fitted, of its radius."""

_THICKEST = 0.94
"""Largest thickness of a round finger, of its radius; its core has at least a twentieth of it."""


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
        raise InvalidValueError(
            "fit has both depth and depths", "choose one shift for all, or one depth a sensor", "leave one of them out"
        )
    return tuple(name for name in known if name in names)


def slices(sizes: Mapping[str, int]) -> dict[str, slice]:
    """Where each name stands in a vector, one after the other."""
    ends = np.cumsum([0, *sizes.values()]).tolist()
    return {name: slice(*pair) for name, pair in zip(sizes, pairwise(ends), strict=True)}


class Forward:
    """A finger whose geometry and material depend on a vector p: the terms of `names`, in the order of `TERMS`.

    `position` moves each sensor along the row; where the origin is fitted too, the mean position stays as drawn.
    `thickness` is what lies beneath the deepest sensor, and without it the depths end at the
    base: no sensor leaves the skin on the way.
    """

    terms: tuple[str, ...] = TERMS

    def __init__(self, finger: Finger, names: Sequence[str]) -> None:
        self.finger = finger
        self.names = tuple(t for t in self.terms if t in names)
        n = len(finger.array)
        self.tied = "position" in self.names and "origin" in self.names and n > 1
        material = finger.skin.single_material
        self.poisson = 0.5 if material is None else material.poisson
        for name in ("poisson", "thickness"):
            there = material is not None and (name == "poisson" or np.isfinite(finger.skin.thickness))
            if name in self.names and not there:
                rule = f"a {type(finger.skin).__name__} like this has no single {name}"
                fix = "one layer on a rigid base and a round finger have both; a half plane has poisson"
                raise InvalidValueError(f"fit = {name}", rule, fix)
        counts = self._counts(self.names, n)
        self.slices = slices({name: counts.get(name, 1) for name in self.names})
        self.size = sum(part.stop - part.start for part in self.slices.values())

    def _counts(self, names: Sequence[str], sensors: int) -> dict[str, int]:
        """How many numbers there are of a name, where it is not one."""
        return {"depths": sensors, "position": sensors - 1 if self.tied else sensors}

    @property
    def depth(self) -> slice | None:
        """Where the depths are in p, if they are among the unknowns."""
        return self.slices.get("depths", self.slices.get("depth"))

    def _depths(self) -> FloatArray:
        return np.asarray(self.finger.array.depth)

    @property
    def _radius(self) -> float:
        return self.finger.skin.period / (2 * np.pi)

    def start(self, origin: Any, depth_factor: float = 1.0, height: float = 3.0) -> FloatArray:
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

    def moved(
        self, p: FloatArray, fixed: float, positions: FloatArray, load: FloatArray
    ) -> tuple[FloatArray, FloatArray]:
        """Touches at `positions` (m,) on the motor's axis with `load` (m, 2), as they lie on the finger."""
        return positions - self.origin(p, fixed), load

    def apply(self, p: FloatArray) -> Finger:
        """The finger with the parameters p."""
        array, skin = self.finger.array, self.finger.skin
        changes: dict[str, Any] = {}
        if self.depth:
            changes["depth"] = self._depths() + p[self.depth]
        if "position" in self.names:
            changes |= self._moves(p)
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

    def _moves(self, p: FloatArray) -> dict[str, FloatArray]:
        """Where the sensors are."""
        moves = p[self.slices["position"]]
        return {"y": np.asarray(self.finger.array.y) + (np.append(moves, -moves.sum()) if self.tied else moves)}

    def pooled(self, noise: FloatArray, gain: FloatArray) -> FloatArray:
        """Each sensor's noise (n,), by its own residuals."""
        return noise

    def unit(self, p: FloatArray, positions: FloatArray, load: FloatArray) -> FloatArray:
        """What unit gains would read, shape (m, n): touches at `positions` (m,) with loads (N, T) (m, 2)."""
        return self.apply(p).measure(LineLoad.of_components(load, positions), linear=True)

    def from_origins(
        self, p: FloatArray, origins: Sequence[float], positions: FloatArray, load: FloatArray
    ) -> Iterator[FloatArray]:
        """What unit gains would read with each of the origins: the touches move together, and the finger stays."""
        step = max(1, _BLOCK // positions.size)
        for i in range(0, len(origins), step):
            yield from self.unit(p, positions - np.asarray(origins[i : i + step])[:, None], load)

    def readings(self, p: FloatArray, positions: FloatArray, load: FloatArray) -> FloatArray:
        """Readings with the finger's own gains, lifts and offsets, shape (m, n)."""
        array = self.finger.array
        lifted = np.asarray(array.lift) * load[:, :1] + np.asarray(array.offset)
        return np.asarray(np.asarray(array.gain) * self.unit(p, positions, load) + lifted)

    def expansion(self, p: FloatArray) -> FloatArray:
        """How what is reported follows from p, shape (reported, size).

        The last of tied positions is minus the others; the thickness goes down from the deepest sensor.
        """
        rows = [np.eye(self.size)[self.slices[name]] for name in self.names]
        if "thickness" in self.names and self.depth:
            deepest = int(np.argmax(self._depths() + p[self.depth])) if "depths" in self.names else 0
            rows[self.names.index("thickness")][0, self.depth.start + deepest] = 1.0
        if self.tied:
            i = self.names.index("position")
            rows[i] = np.concatenate([rows[i], -rows[i].sum(axis=0, keepdims=True)])
        return np.concatenate(rows) if rows else np.zeros((0, 0))

    def parameters(self, p: FloatArray, sensors: npt.NDArray[np.intp]) -> list[tuple[str, int | None, float, str]]:
        """(name, sensor, value, unit) of what is reported, in absolute values."""
        fitted = self.apply(p)
        depths = np.asarray(fitted.array.depth)
        each = {"depths": ("depth", depths), "position": ("y", np.asarray(fitted.array.y))}
        whole = {"depth": depths.mean(), "thickness": fitted.skin.thickness}
        out: list[tuple[str, int | None, float, str]] = []
        for name in self.names:
            if name in each:
                label, values = each[name]
                out += [(label, int(i), float(value), "m") for i, value in zip(sensors, values, strict=True)]
            else:
                value = float(whole.get(name, p[self.slices[name]][0]))
                out.append((name, None, value, "" if name == "poisson" else "m"))
        return out
