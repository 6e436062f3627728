"""The estimator of patches: rectangles on an area, prepared once for a finger, then called on frames."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
import numpy.typing as npt

from ... import _check
from ..._check import FloatArray
from ...errors import InvalidValueError
from ...finger import Finger
from ...radial import tabulate_radial
from ..answer import Status
from ..area.judge import plain
from ..area.locator import LocalLocator
from ..area.point import tabulated
from ..area.rectangle import FIELD_ERROR, RectangleAt, RectangleModel, rules
from ..area.search import reach_of, search_of
from ..frames import sensor_rows
from ..layout import HOLLOW, LEANING, PATCH, Layout
from ..resultants import ResultantReader
from ..varpro import Limits

__all__ = ["PatchLocator"]

PRESSURES = {"even": PATCH, "linear": LEANING, "punch": HOLLOW}
"""Layouts, by the name of a pressure."""
_VAGUE, _APART = 0.3, 1.0
"""Standard deviations, over the normal force and over the depth, from which an answer is AMBIGUOUS."""
_LEAST = 0.1
"""Depths up to which half widths are not looked for, if nothing is said."""
_GROWS, _LONGEST, _STEP, _MOST = 0.5, 12.0, 0.6, 400_000
"""Of rectangles to start from, in depths: how much longer each side is than the one before, and the longest; the step
of their middles; and how many readings of them are kept."""
_UNLIKE = 0.012
"""Share of a load that is added to its standard deviation: measured on pressed boxes (docs/patches.md)."""
_KNOWN = 1e-150
"""Variance of what is held."""
_USUAL, _INSIDE = 0.02, 0.98
"""Chance that noise leaves more than what ends the search; share of the largest side from which it may be larger."""
_BOWL = (-0.75, 1.5)
"""Ends of `hollow`, where the pressure would be less than nothing in a corner or in the middle."""
_COUNT, _DIRECTION = 11, 4
_UPPER = np.triu_indices(_COUNT)
"""Unknowns and components of the loop, where the ends have the direction's, and a square the covariance."""
_START = np.dtype((np.record, [(name, float) for name in ("y", "z", "yy", "yz", "zz")]))
"""Where the loop starts: a centre, and second moments about it over the force."""


class _Extents(ResultantReader):
    """Resultants, and the second moments of their pressures."""

    _extent = True


class PatchLocator(LocalLocator):
    """Finds the rectangle that presses in frames of readings: position, forces, both half widths and its turn.

    The drag is in proportion to the pressure. Climbs start from the resultant and from a bank of rectangles
    (docs/patches.md).

    Parameters
    ----------
    finger : Finger
        The forward model, on an area, each sensor with its noise.
    search : ((float, float), (float, float)), optional
        Where its middle may be, y and z [m]; by default up to 1.5 depths beyond the outermost sensors.
    half_width : (float, float) or ((float, float), (float, float)), optional
        Least and largest half width [m], or those of one side and of the other: with a `turn`, of that turned from y
        and of that turned from z. Twice the same where it is known. By default from a tenth of the least depth to half
        the longer side of the search.
    turn : float or (float, float), optional
        By how much it is turned, from +y towards +z [rad], or a range of it; any, if nothing is said.
    pressure : {"even", "linear", "punch"}, optional
        Even; linear along both sides, with two unknowns more; or as of a flat punch with rounded edges, a parabola
        along both sides, with one unknown more.
    options
        `friction`, `false_alarm`, `ambiguity`, `outliers`, as of `AreaLocator`.

    Raises
    ------
    InvalidValueError, GeometryError
        As of `AreaLocator`; half widths or turns out of order, another pressure.

    Examples
    --------
    >>> import subskin as ss
    >>> array = ss.SensorArray.grid((4, 4), pitch=4e-3, depth=2.5e-3, noise=2e-4)
    >>> finger = ss.Finger(ss.HalfSpace(ss.Material(young=0.4e6)), array)
    >>> locator = finger.locator("patch", turn=0.0)
    >>> locator.unknowns, locator.half_width.round(5).tolist()
    (7, [[0.00025, 0.00975], [0.00025, 0.00975]])
    """

    takes_doubt = False

    def __init__(
        self, finger: Finger, search: Any = None, half_width: Any = None, turn: Any = None, pressure: str = "even", *,
        friction: float = 1.0, false_alarm: float = 1e-6, ambiguity: float = 13.8, outliers: int = 0,
    ) -> None:  # fmt: skip
        array, depth = finger.array, float(np.asarray(finger.array.depth).min())
        box, _ = search_of(array, search)
        _check.choice("pressure", pressure, PRESSURES)
        largest = 0.5 * float(np.ptp(box, axis=1).max())
        sides, turns = _sides(half_width, (_LEAST * depth, largest)), _turns(turn)
        lean = (-1.0, 1.0) if pressure == "linear" else (0.0, 0.0)
        bowl = _BOWL if pressure == "punch" else (0.0, 0.0)
        self.layout = PRESSURES[pressure]
        self._ends = np.array([*box.reshape(-1), *turns, *sides[0], *np.square(sides[1]), *lean, *lean, *bowl])
        self._finger, self._depth, self.pressure, self.half_width = finger, depth, pressure, sides
        self._reach = reach_of(array, box, float(np.hypot(*sides[:, 1])))
        held = int((self._ends[1::2] == self._ends[::2])[2:5].sum())
        self._straight = 0.5 * (turns[0] + turns[1]) if np.isfinite(turns[0]) else 0.0
        self._starts = _Extents(finger)
        more = self.layout.unknowns - 5 - held
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
        along, across = (rules(float(half), self._depth) for half in self.half_width[:, 1])
        model = RectangleModel(points, along, across, self._depth, float(self.pressure != "even"), np.empty((0, 0)))
        middle = np.array([[np.mean(ends) for ends in self.search]])
        strongest = np.abs(self.response.select(pattern)(middle) / np.asarray(array.noise)[:, None]).max()
        most, usual = (self._left(len(array), chance) for chance in (self._false_alarm, _USUAL))
        wrong = float(len(array) * ((error + FIELD_ERROR) * strongest) ** 2)
        search = PatchSearch(
            model, self._bank(model, len(array)), Limits(self.friction), self._detection, most, usual, self._ambiguity,
            wrong, self._ends, RectangleAt(*self._ends[::2].tolist()), RectangleAt(*self._ends[1::2].tolist()),
        )  # fmt: skip
        return sensor_rows(array), pattern, plain(search)

    def _bank(self, model: RectangleModel, sensors: int) -> Any:
        """Rectangles to start from, the largest first, as many as are looked at in good time."""
        from .kernel import SHAPE, PatchBank, fill_bank

        classes = [0]
        shapes = np.zeros(max(_MOST // sensors, 1), SHAPE)
        for at, turn, length, half in self._classes():
            end = classes[-1] + len(at)
            if end > len(shapes):
                break
            some = shapes[classes[-1] : end]
            some["y"], some["z"], some["direction"], some["length"], some["q"] = *at.T, turn, length, half * half
            classes.append(end)
        shapes = shapes[: classes[-1]]
        basis = np.empty((len(shapes), 3, sensors), np.float32)
        fill_bank(shapes, plain(model), basis)
        return PatchBank(np.array(classes), shapes, basis)

    def _classes(self) -> Iterator[tuple[FloatArray, float, float, float]]:
        """Of each size and turn, the largest first: middles (k, 2), turn, half length and half width."""
        box, depth, (long, wide) = np.array(self.search), self._depth, self.half_width
        known = bool(np.isfinite(self._ends[_DIRECTION]))
        sides = depth * np.arange(_GROWS, _LONGEST, _GROWS)
        axes = [np.arange(low, high, _STEP * depth)[1:] for low, high in box]
        at = np.stack(np.meshgrid(*axes), axis=-1).reshape(-1, 2)
        for half in np.unique(np.clip(sides, *wide))[::-1]:
            # of a direction that may be any, the longer side is the length
            for length in np.unique(np.clip(sides if known else sides[sides >= 0.99 * half], *long)):
                for turn in [self._straight] if known else np.arange(2 if length < 1.2 * half else 4) * 0.25 * np.pi:
                    yield at, float(turn), float(length), float(half)

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
            for k, (one, two) in enumerate((("y", "y"), ("y", "z"), ("z", "z"))):
                start[one + two] = asked[:, 6 + k] / asked[:, 0] - start[one] * start[two]
        found = np.full(len(frames), np.nan, FOUND)
        found["rival_chi2"] = np.inf
        self._compiled(frames, rows, start, search, found)
        self._laid(found, int(pattern.sum()), out)

    def _laid(self, found: Any, sensors: int, out: FloatArray) -> None:
        """What the loop found, in the columns of the layout."""
        at, square = self.layout, np.zeros((len(found), _COUNT, _COUNT))
        square[:, *_UPPER] = square[:, *_UPPER[::-1]] = found["covariance"]
        values, slopes = _as_patch(found, "", self.layout, self._straight)
        out[:, : at.unknowns] = values
        with np.errstate(invalid="ignore"):
            square = slopes @ square @ np.swapaxes(slopes, 1, 2)
        square[np.abs(square) < _KNOWN] = 0.0
        if at.hollow:  # a pressed punch is no parabola
            load = values[:, 2:5]
            square[:, 2:5, 2:5] += (_UNLIKE * load[:, :, None]) * (_UNLIKE * load[:, None, :])
        out[:, at.covariance : at.residual] = square[:, *np.triu_indices(at.unknowns)]
        out[:, at.residual] = found["residual"]
        out[:, at.rival : at.rival_chi2] = _as_patch(found, "rival_", self.layout, self._straight)[0]
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


def _sides(given: Any, usual: tuple[float, float]) -> FloatArray:
    """Ends of both half widths, (2, 2)."""
    sides = np.array(_check.real("half_width", usual if given is None else given, unit="m", above=0.0))
    if sides.shape not in ((2,), (2, 2)) or not (sides[..., 0] <= sides[..., 1]).all():
        rule = "ascending half widths are needed, of both sides or of each"
        fix = "half_width=(1e-3, 5e-3), or half_width=((1e-3, 5e-3), (2e-3, 2e-3))"
        raise InvalidValueError(f"half_width = {_check.shown(given)} of a patch", rule, fix)
    return np.array(np.broadcast_to(sides, (2, 2)))


def _turns(given: Any) -> tuple[float, float]:
    """Ends of the turn."""
    if given is None:
        return -np.inf, np.inf
    turns = _check.real("turn", given, unit="rad", fix="angles are in radians: np.deg2rad(30)")
    if turns.shape not in ((), (2,)) or not 0 <= float(turns.flat[-1] - turns.flat[0]) < 0.5 * np.pi:
        rule = "a turn, or two that ascend by less than a quarter of a full one, are needed [rad]"
        raise InvalidValueError(f"turn = {_check.shown(given)}", rule, "turn=0.0, or turn=(-0.2, 0.2)")
    return float(turns.flat[0]), float(turns.flat[-1])


def _as_patch(found: Any, of: str, at: Layout, straight: float) -> tuple[FloatArray, FloatArray]:
    """Unknowns of a layout (f, k), of the best or the "rival_"; and how they go with `UNKNOWNS`, (f, k, 11).

    The side that is nearest to the direction `straight` is the first one.
    """
    from .kernel import UNKNOWNS

    y, z, direction, long, q, lean, tilt, hollow, n, ty, tz = (found[of + name] for name in UNKNOWNS)
    with np.errstate(invalid="ignore"):
        wide, quarter = np.sqrt(q), np.rint((direction - straight) / (0.5 * np.pi))
    turned = np.where(np.isnan(quarter), 0, quarter).astype(int) % 4
    k, odd = at.unknowns, turned % 2 == 1
    values, slopes = np.empty((len(found), k)), np.zeros((len(found), k, _COUNT))
    values[:, :5] = np.stack([y, z, n, ty, tz], axis=1)
    slopes[:, [0, 1, 2, 3, 4], [0, 1, 8, 9, 10]] = 1.0
    along, across = np.zeros((2, len(found), _COUNT))
    along[:, 3], across[:, 4] = 1.0, 0.5 / wide
    values[:, 5], values[:, 6] = np.where(odd, wide, long), np.where(odd, long, wide)
    slopes[:, 5], slopes[:, 6] = np.where(odd[:, None], across, along), np.where(odd[:, None], along, across)
    values[:, 7], slopes[:, 7, 2] = direction - 0.5 * np.pi * quarter, 1.0
    if at.hollow:
        values[:, 8], slopes[:, 8, 7] = hollow, 1.0
    if at.leaning:
        along, across = -(lean / long**2)[:, None] * along, -(tilt / q)[:, None] * across
        along[:, 5], across[:, 6] = 1 / long, 1 / wide
        both = np.stack([lean / long, tilt / wide], axis=1), np.stack([along, across], axis=1)
        each = np.arange(len(found))
        for column, which, sign in ((8, [0, 1, 0, 1], [1, -1, -1, 1]), (9, [1, 0, 1, 0], [1, 1, -1, -1])):
            side, way = np.array(which)[turned], np.array(sign)[turned]
            values[:, column], slopes[:, column] = way * both[0][each, side], way[:, None] * both[1][each, side]
    return values, slopes
