"""The estimator of patches: rectangles on an area, prepared once for a finger, then called on frames."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from ... import _check
from ..._check import FloatArray
from ...array import SensorArray
from ...errors import InvalidValueError
from ...finger import Finger
from ...radial import tabulate_radial
from ..answer import Status
from ..area.judge import plain
from ..area.locator import LocalLocator
from ..area.point import tabulated
from ..area.rectangle import RectangleModel, rules
from ..area.search import reach_of, search_of
from ..frames import sensor_rows
from ..layout import LEANING, PATCH
from ..resultants import ResultantReader
from ..varpro import Limits

__all__ = ["PatchLocator"]

PRESSURES = ("even", "linear", "punch")
_FLAT, _STEPS = 0.9, 40
"""Share of a punch's half side that is flat; and steps by which it is pressed in."""
_VAGUE, _APART = 0.3, 1.0
"""Standard deviations, over the normal force and over the depth, from which an answer is AMBIGUOUS."""


_RATIO, _STEP, _LEAST, _MOST = 0.5, 0.6, 0.5, 400_000
"""Of rectangles to start from: how their sides grow, steps in half widths, but at least so many depths; readings."""
_USUAL, _INSIDE = 0.02, 0.98
_COUNT = 10
_UPPER = np.triu_indices(_COUNT)
"""Unknowns and components of the loop, and where a square has their covariance."""
_START = np.dtype((np.record, [(name, float) for name in ("y", "z", "yy", "yz", "zz")]))
"""Where the loop starts: a centre, and second moments about it over the force."""


class _Extents(ResultantReader):
    """Resultants, and the second moments of their pressures."""

    _extent = True


def _punch() -> tuple[FloatArray, FloatArray]:
    """The pressure across a flat punch with rounded edges, of the half width 1: a profile for `rules`.

    As it is pressed in, flat punches of the half width c from the flat's b on follow each other, each of the force
    c arccos(b / c) dc. Source: Ciavarella, Hills and Monno (1998), whose force is the integral of these.
    """
    t, weights = np.polynomial.legendre.leggauss(_STEPS)
    c = 1 - 0.5 * (1 - _FLAT) * (1 + t)
    force = weights * c * np.arccos(_FLAT / c)
    turn = np.cos((np.arange(2 * _STEPS) + 0.5) * np.pi / (2 * _STEPS))
    return (c[:, None] * turn).ravel(), np.repeat(force, 2 * _STEPS)


class PatchLocator(LocalLocator):
    """doc."""

    def __init__(
        self, finger: Finger, search: Any, half_width: Any, turn: Any, pressure: str, *, friction: float,
        false_alarm: float, ambiguity: float, outliers: int,
    ) -> None:  # fmt: skip
        array, depth = finger.array, float(np.asarray(finger.array.depth).min())
        box, _ = search_of(array, search)
        largest = 0.5 * float(np.ptp(box, axis=1).max())
        sides = np.array([(0.1 * depth, largest)] * 2) if half_width is None else half_width
        turns = (-np.inf, np.inf) if turn is None else turn
        lean = (-1.0, 1.0) if pressure == "linear" else (0.0, 0.0)
        self.layout = LEANING if pressure == "linear" else PATCH
        self._ends = np.array([*box.reshape(-1), *turns, *sides[0], *np.square(sides[1]), *lean, *lean])
        self._finger, self._depth, self.pressure, self.half_width = finger, depth, pressure, sides
        self._reach = reach_of(array, box, float(np.hypot(*sides[:, 1])))
        held = int((self._ends[1::2] == self._ends[::2])[2:5].sum())
        self._starts = _Extents(finger)
        more = 3 + 2 * (pressure == "linear") - held
        super().__init__(
            tabulate_radial(finger, self._reach), array, tuple(tuple(e) for e in box.tolist()), friction=friction,
            false_alarm=false_alarm, ambiguity=ambiguity, outliers=outliers, known=-more,
        )  # fmt: skip

    def _kernel(self) -> Any:
        from .kernel import fit_patches

        return fit_patches

    def _prepare(self, pattern: npt.NDArray[np.bool_]) -> tuple[Any, ...]:
        from .kernel import PatchSearch

        array = self.array.select(pattern)
        points, error = tabulated(self.response.select(pattern), array)
        profile = _punch() if self.pressure == "punch" else None
        along, across = (rules(float(half), self._depth, profile) for half in self.half_width[:, 1])
        leans = float(self.pressure == "linear")
        model = RectangleModel(points, along, across, self._depth, leans, np.empty((0, 0)))
        middle = np.array([[np.mean(ends) for ends in self.search]])
        strongest = np.abs(self.response.select(pattern)(middle) / np.asarray(array.noise)[:, None]).max()
        search = PatchSearch(
            model, self._bank(model, len(array)), Limits(self.friction), self._detection, self._left(len(array), self._false_alarm),
            self._left(len(array), _USUAL), self._ambiguity, float(len(array) * ((error + 3e-5) * strongest) ** 2), self._ends,
        )  # fmt: skip
        return sensor_rows(array), pattern, plain(search)

    def _bank(self, model: RectangleModel, sensors: int) -> PatchBank:
        """Rectangles to start from, the largest first, as many as are looked at in good time."""
        from .kernel import PatchBank, fill_bank

        box, depth, (long, wide) = np.array(self.search), self._depth, self.half_width
        parts: list[FloatArray] = []
        sides = depth * np.arange(_RATIO, 12, _RATIO)
        for half in np.unique(np.clip(sides, *wide))[::-1]:
            step = _STEP * depth
            axes = [np.linspace(*ends, max(int(np.ceil(np.ptp(ends) / step)), 1) + 1)[1:-1] for ends in box]
            at = np.stack(np.meshgrid(*axes), axis=-1).reshape(-1, 2)
            for length in np.unique(np.clip(sides[sides >= 0.99 * half], *long)):
                for turn in np.arange(2 if length < 1.2 * half else 4) * 0.25 * np.pi:
                    parts.append(np.column_stack([at, np.tile([turn, length, half**2], (len(at), 1))]))
            if sum(len(part) for part in parts) * sensors > _MOST:
                break
        shapes = np.concatenate(parts)
        basis = np.empty((len(shapes), 3, sensors), np.float32)
        fill_bank(shapes, plain(model), basis)
        return PatchBank(np.cumsum([0, *(len(part) for part in parts)]), shapes, basis)

    def _fill(self, frames: FloatArray, arrays: tuple[Any, ...], out: FloatArray) -> None:
        from .kernel import FOUND

        rows, pattern, search = arrays
        whole = np.full((len(frames), pattern.size), np.nan)
        whole[:, pattern] = frames
        table, _ = self._starts._frames(whole)
        start = np.empty(len(frames), _START)
        asked = table[:, self._starts.layout.columns :]
        with np.errstate(invalid="ignore"):
            start["y"], start["z"] = asked[:, 3] / asked[:, 0], asked[:, 4] / asked[:, 0]
            for k, (one, two) in enumerate(("yy", "yz", "zz")):
                start[one + two] = asked[:, 6 + k] / asked[:, 0] - start[one] * start[two]
        found = np.full(len(frames), np.nan, FOUND)
        found["rival_chi2"] = np.inf
        self._compiled(frames, rows, start, search, found)
        self._laid(found, int(pattern.sum()), out)

    def _laid(self, found: Any, sensors: int, out: FloatArray) -> None:
        """What the loop found, in the columns of the layout."""
        at, square = self.layout, np.zeros((len(found), _COUNT, _COUNT))
        square[:, *_UPPER] = square[:, *_UPPER[::-1]] = found["covariance"]
        values, slopes = _as_patch(found, "", self.layout is LEANING)
        out[:, : at.unknowns] = values
        with np.errstate(invalid="ignore"):
            square = slopes @ square @ np.swapaxes(slopes, 1, 2)
        out[:, at.covariance : at.residual] = square[:, *np.triu_indices(at.unknowns)]
        out[:, at.residual] = found["residual"]
        out[:, at.rival : at.rival_chi2] = _as_patch(found, "rival_", self.layout is LEANING)[0]
        out[:, at.rival_chi2] = found["rival_chi2"]
        out[:, at.status] = found["status"]
        std = np.sqrt(np.diagonal(square, axis1=1, axis2=2))
        box = np.asarray(self.search)
        with np.errstate(invalid="ignore"):
            inside = ((values[:, :2] > box[:, 0]) & (values[:, :2] < box[:, 1])).all(axis=1)
            force = np.linalg.norm(values[:, 2:5], axis=1)
            sure = (std[:, 2] < _VAGUE * values[:, 2]) & (std[:, :2] < _APART * self._depth).all(axis=1)
            sure &= (std[:, 3:5] < force[:, None]).all(axis=1)
        low, high = self._ends[6:10:2], self._ends[7:10:2]
        sides = np.stack([found["length"], found["q"]], axis=1)
        sure &= ((sides < _INSIDE * high) | (low == high)).all(axis=1)
        unsure = (found["status"] == Status.OK) & ~(inside & sure & (sensors > self.unknowns))
        out[unsure, at.status] = Status.AMBIGUOUS


def _as_patch(found: Any, of: str, leans: bool) -> tuple[FloatArray, FloatArray]:
    """Unknowns of a layout (f, k), of the best or the "rival_"; and how they go with `UNKNOWNS`, (f, k, 10).

    The side that is nearest to y is the first one: the turn is an eighth of a full one at most.
    """
    from .kernel import UNKNOWNS

    y, z, direction, long, q, lean, tilt, n, ty, tz = (found[of + name] for name in UNKNOWNS)
    with np.errstate(invalid="ignore"):
        wide, quarter = np.sqrt(q), np.rint(direction / (0.5 * np.pi))
    turned = np.where(np.isnan(quarter), 0, quarter).astype(int) % 4
    k, odd = 8 + 2 * leans, turned % 2 == 1
    values, slopes = np.empty((len(found), k)), np.zeros((len(found), k, _COUNT))
    values[:, :5] = np.stack([y, z, n, ty, tz], axis=1)
    slopes[:, [0, 1, 2, 3, 4], [0, 1, 7, 8, 9]] = 1.0
    along, across = np.zeros((2, len(found), _COUNT))
    along[:, 3], across[:, 4] = 1.0, 0.5 / wide
    values[:, 5], values[:, 6] = np.where(odd, wide, long), np.where(odd, long, wide)
    slopes[:, 5], slopes[:, 6] = np.where(odd[:, None], across, along), np.where(odd[:, None], along, across)
    values[:, 7], slopes[:, 7, 2] = direction - 0.5 * np.pi * quarter, 1.0
    if leans:
        along, across = -(lean / long**2)[:, None] * along, -(tilt / q)[:, None] * across
        along[:, 5], across[:, 6] = 1 / long, 1 / wide
        both = np.stack([lean / long, tilt / wide], axis=1), np.stack([along, across], axis=1)
        each = np.arange(len(found))
        for column, which, sign in ((8, [0, 1, 0, 1], [1, -1, -1, 1]), (9, [1, 0, 1, 0], [1, 1, -1, -1])):
            side, way = np.array(which)[turned], np.array(sign)[turned]
            values[:, column], slopes[:, column] = way * both[0][each, side], way[:, None] * both[1][each, side]
    return values, slopes
