"""Why a finger is as it is: sentences, from the grid of all designs that were tried."""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np

from ..._check import FloatArray
from .grid import Criterion, DesignGrid

if TYPE_CHECKING:
    from .goals import Row
    from .rank import Check

__all__ = ["held", "in_words", "reasons_of"]

Looked: TypeAlias = "Mapping[tuple[int, int, int], tuple[Check, ...]]"

_NEAR = 1.1
"""A design within this of the best excess is as good as that."""


def in_words(value: float, unit: str) -> str:
    """A value in the unit that people use: mm, degrees, per cent, or as it is.

    Examples
    --------
    >>> in_words(0.00123, "m"), in_words(0.1, "rad"), in_words(0.0123, ""), in_words(float("inf"), "m")
    ('1.23 mm', '5.73°', '1.23 %', 'without bound')
    """
    if not np.isfinite(value):
        return "without bound"
    least, text = {"m": (1e-6, "< 0.001 mm"), "rad": (2e-5, "< 0.001°"), "": (1e-4, "< 0.01 %")}.get(unit, (0.0, ""))
    if 0 < value < least:
        return text
    scale, name = {"m": (1e3, " mm"), "rad": (180 / np.pi, "°"), "": (100.0, " %")}.get(unit, (1.0, f" {unit}"))
    return f"{value * scale:.3g}{name}"


def held(sentence: str) -> str:
    """The sentence, with spaces that no line breaks at between a number and its unit."""
    return re.sub(r"(?<=\d) (?=%|mm|N/m)", "\xa0", sentence)


def reasons_of(grid: DesignGrid, row: Row, looked: Looked) -> tuple[str, ...]:
    """Why this row: its count, depth and pitch, its kind of sensor and skin, and what limits it.

    `looked` has the checks of every design that was looked at closely, by its skin, kind and count, this one's among
    them; of the others the grid tells.
    """
    k, m = row.skin, row.sensor
    n = int(np.searchsorted(grid.counts, row.count))
    excess = np.where(np.isfinite(grid.excess), grid.excess, np.inf)
    goals = grid.goals
    reasons = [_limit(looked[k, m, n]), _count(grid, excess, looked, k, m, n)]
    d = int(np.argmin(np.abs(np.log(grid.depths[k] / row.depth))))
    s = int(np.argmin(np.abs(np.log(grid.pitches / row.pitch))))
    along_depth = excess[k, m, :, :, n].min(axis=1)
    reasons.append(
        _span(grid, "Depth", row.depth, grid.depths[k], along_depth, d, ("shallower", "deeper"),
              lambda i: (k, m, i, int(np.argmin(excess[k, m, i, :, n])), n), ", with a pitch that suits it")
    )  # fmt: skip
    reasons.append(
        _span(grid, "Pitch", row.pitch, grid.pitches, excess[k, m, d, :, n], s, ("closer", "wider"),
              lambda i: (k, m, d, i, n))
    )  # fmt: skip
    for what, chosen, names in (
        ("sensor", m, [kind.name for kind in goals.sensors]),
        ("skin", k, [choice.name for choice in goals.skins]),
    ):
        for i, name in enumerate(names):
            if i != chosen:
                other = (k, i, n) if what == "sensor" else (i, m, n)
                reasons.append(f'With {what} "{name}" as many sensors {_other(grid, excess, looked, other)}.')
    reasons += _information(grid, excess, k, m, n)
    return tuple(reasons)


def _other(grid: DesignGrid, excess: FloatArray, looked: Looked, which: tuple[int, int, int]) -> str:
    """What the best row of a skin, kind and count does: of close looks, or else of the grid."""
    if which in looked:
        tight = max(looked[which], key=lambda check: check.ratio)
        does = f"{tight.criterion.label} {in_words(tight.value, tight.criterion.unit)}"
        return "meet the goals too" if tight.ratio <= 1 else f"miss the goals: {does}"
    best, index = _best(excess, *which)
    if not np.isfinite(best):
        return "find no room, or do not feel all touches"
    if best <= 1:
        return "can do all that was searched for too, and were not looked at closely"
    return f"leave at best {_worst(grid, index)}, on the grid"


def _limit(checks: tuple[Check, ...]) -> str:
    tight = max(checks, key=lambda check: check.ratio)
    value, wanted = (
        in_words(tight.value, tight.criterion.unit),
        in_words(tight.criterion.wanted, tight.criterion.unit),
    )
    if tight.ratio <= 1:
        return f"All goals are met. The tightest: {tight.criterion.label} {value}, at most {wanted} wanted."
    missed = [c for c in checks if c.ratio > 1]
    others = f", and {len(missed) - 1} more" if len(missed) > 1 else ""
    return f"Not met: {tight.criterion.label} {value}, at most {wanted} wanted{others}."


def _worst(grid: DesignGrid, index: tuple[int, ...]) -> str:
    """What a design of the grid fails by, or what is tightest."""

    def ratio(c: Criterion) -> float:
        value = float(grid.values[c.name][index]) / c.wanted
        return value if np.isfinite(value) else np.inf

    criterion = max(grid.criteria, key=ratio)
    value = in_words(float(grid.values[criterion.name][index]), criterion.unit)
    return f"{criterion.label} {value}"


def _best(excess: FloatArray, k: int, m: int, n: int) -> tuple[float, tuple[int, ...]]:
    plane = excess[k, m, :, :, n]
    d, s = np.unravel_index(int(np.argmin(plane)), plane.shape)
    return float(plane[d, s]), (k, m, int(d), int(s), n)


def _count(grid: DesignGrid, excess: FloatArray, looked: Looked, k: int, m: int, n: int) -> str:
    count = int(grid.counts[n])
    if n == 0:
        return f"{count} sensors are the fewest that were allowed."
    fewer = _other(grid, excess, looked, (k, m, n - 1))
    return f"{count} sensors: {count - 1} {fewer}."


def _span(
    grid: DesignGrid, name: str, chosen: float, values: FloatArray, excess: FloatArray, at: int,
    sides: tuple[str, str], index: Any, suits: str = "",
) -> str:  # fmt: skip
    """How far a depth or a pitch may be changed, and what it would cost beyond that."""
    text = f"{name} {in_words(chosen, 'm')}: "
    if values.size == 1:
        return f"{text}the only one that was allowed."
    best = float(excess.min())
    limit, verb = (1.0, "would do") if best <= 1 else (_NEAR * best, "would be within 10 % of the best")
    good = excess <= limit
    if not good[at]:
        at = int(np.argmin(excess))
    low = at
    while low > 0 and good[low - 1]:
        low -= 1
    high = at
    while high < values.size - 1 and good[high + 1]:
        high += 1
    if low == high:
        text += f"for noise alone none of its neighbours on the grid {verb}"
    else:
        first, last = min(float(values[low]), chosen), max(float(values[high]), chosen)
        text += f"for noise alone anything from {in_words(first, 'm')} to {in_words(last, 'm')} {verb}"
    text += suits
    beyond = [(low - 1, sides[0])] * (low > 0) + [(high + 1, sides[1])] * (high < values.size - 1)
    beyond = [(i, side) for i, side in beyond if np.isfinite(excess[i])]
    for i, side in beyond:
        text += f"; {side}, {_worst(grid, index(i))}"
    return text + "."


def _information(grid: DesignGrid, excess: FloatArray, k: int, m: int, n: int) -> list[str]:
    """What the largest determinant of the information would have chosen."""
    plane = np.where(np.isfinite(excess[k, m, :, :, n]), grid.values["log_det"][k, m, :, :, n], -np.inf)
    d, s = np.unravel_index(int(np.argmax(plane)), plane.shape)
    index = (k, m, int(d), int(s), n)
    if not np.isfinite(plane[d, s]) or excess[index] <= 1:
        return []
    position = f"depth {in_words(float(grid.depths[k, d]), 'm')} and pitch {in_words(float(grid.pitches[s]), 'm')}"
    sentence = (
        f"The most information on average (D-optimality) would be had at {position}, which misses the goals: "
        f"{_worst(grid, index)}."
    )
    return [sentence]
