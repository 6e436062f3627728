"""A design in words, for the report and the command line: values in units for people, reasons, a table."""

from __future__ import annotations

import re
from collections.abc import Callable

import numpy as np

from .._check import FloatArray
from ._common import stretch
from .search import Check, Criterion, DesignedFinger, DesignGrid, DesignStudy, Goals, Row
from .touches import Touches

__all__ = ["finger_table", "force_in_words", "held", "in_words", "reasons_of"]

_NEAR = 1.1
"""A design within this of the best excess is as good as that."""
_UNITS = {"m": (1e3, " mm", 1e-6, "0.001"), "rad": (180 / np.pi, "°", 2e-5, "0.001"), "": (100.0, " %", 1e-4, "0.01")}
"""Of each SI unit: the factor to the unit that people use, its name, and below what a value is said to be small."""


def in_words(value: float, unit: str) -> str:
    """A value in the unit that people use: mm, degrees, per cent, or as it is.

    Parameters
    ----------
    value : float
        In the SI unit that `unit` names.
    unit : str
        "m", "rad", "" for a share, or another.

    Examples
    --------
    >>> in_words(0.00123, "m"), in_words(0.1, "rad"), in_words(0.0123, ""), in_words(float("inf"), "m")
    ('1.23 mm', '5.73°', '1.23 %', 'without bound')
    """
    if not np.isfinite(value):
        return "without bound"
    factor, name, least, small = _UNITS.get(unit, (1.0, f" {unit}", 0.0, ""))
    return f"< {small}{name}" if 0 < value < least else f"{value * factor:.3g}{name}"


def force_in_words(touches: Touches) -> str:
    """The force of `touches`, in N too where the length of the contact is known.

    Examples
    --------
    >>> force_in_words(Touches(force=25.0)), force_in_words(Touches(force=25.0, length=20e-3))
    ('25 N/m', '25 N/m (0.5 N over 20 mm)')
    """
    per_length = f"{touches.force:.6g} N/m"
    if touches.length is None:
        return per_length
    return f"{per_length} ({touches.force * touches.length:.3g} N over {in_words(touches.length, 'm')})"


def held(sentence: str) -> str:
    r"""A sentence, with spaces that no line breaks at between a number and its unit.

    Examples
    --------
    >>> held("0.1 mm at most")
    '0.1\xa0mm at most'
    """
    return re.sub(r"(?<=\d) (?=%|mm|N/m)", "\xa0", sentence)


def reasons_of(study: DesignStudy, row: Row) -> tuple[str, ...]:
    """Why a row is as it is: its count, depth and pitch, its kind of sensor and skin, and what limits it.

    Designs of `study` that were looked at closely are judged by their checks, the others by the grid. The row is one of
    those.
    """
    grid, which = study.grid, row.which(study.goals)
    k, m, n = which
    excess = np.where(np.isfinite(grid.excess), grid.excess, np.inf)
    own, depths, pitches = excess[k, m, :, :, n], grid.depths[k], grid.pitches
    d, s = (int(np.argmin(np.abs(np.log(tried / at)))) for tried, at in ((depths, row.depth), (pitches, row.pitch)))
    fewer = f": {row.count - 1} {_other(study, excess, (k, m, n - 1))}" if n else " are the fewest that were allowed"
    reasons = [
        _limit(study.looked[which]),
        f"{row.count} sensors{fewer}.",
        _span("Depth", row.depth, depths, own.min(axis=1), d, ("shallower", "deeper"), ", with a pitch that suits it",
              lambda i: _worst(grid, (k, m, i, int(np.argmin(own[i])), n))),
        _span("Pitch", row.pitch, pitches, own[d], s, ("closer", "wider"), "", lambda i: _worst(grid, (k, m, d, i, n))),
    ]  # fmt: skip
    others = [("sensor", kind.name, (k, i, n)) for i, kind in enumerate(study.goals.sensors) if i != m]
    others += [("skin", skin.name, (i, m, n)) for i, skin in enumerate(study.goals.skins) if i != k]
    for what, name, other in others:
        reasons.append(f'With {what} "{name}" as many sensors {_other(study, excess, other)}.')
    told = np.where(np.isfinite(own), grid.values["log_det"][k, m, :, :, n], -np.inf)
    d, s = (int(i) for i in np.unravel_index(np.argmax(told), told.shape))
    if np.isfinite(told[d, s]) and own[d, s] > 1:
        reasons.append(
            "The most information on average (D-optimality) would be had at depth "
            f"{in_words(float(depths[d]), 'm')} and pitch {in_words(float(pitches[s]), 'm')}, which misses the goals: "
            f"{_worst(grid, (k, m, d, s, n))}."
        )
    return tuple(reasons)


def _limit(checks: tuple[Check, ...]) -> str:
    tight = max(checks, key=lambda check: check.ratio)
    most = in_words(tight.criterion.wanted, tight.criterion.unit)
    wanted = f"{_does(tight.criterion, tight.value)}, at most {most} wanted"
    if tight.ratio <= 1:
        return f"All goals are met. The tightest: {wanted}."
    more = sum(check.ratio > 1 for check in checks) - 1
    return f"Not met: {wanted}{f', and {more} more' if more else ''}."


def _other(study: DesignStudy, excess: FloatArray, which: tuple[int, int, int]) -> str:
    """What the best row of a skin, kind and count does: of close looks, or else of the grid."""
    if which in study.looked:
        tight = max(study.looked[which], key=lambda check: check.ratio)
        return "meet the goals too" if tight.ratio <= 1 else f"miss the goals: {_does(tight.criterion, tight.value)}"
    k, m, n = which
    plane = excess[k, m, :, :, n]
    d, s = (int(i) for i in np.unravel_index(np.argmin(plane), plane.shape))
    if not np.isfinite(plane[d, s]):
        return "find no room, or do not feel all touches"
    if plane[d, s] <= 1:
        return "can do all that was searched for too, and were not looked at closely"
    return f"leave at best {_worst(study.grid, (k, m, d, s, n))}, on the grid"


def _worst(grid: DesignGrid, index: tuple[int, ...]) -> str:
    """What a design of the grid fails by, or what is tightest."""
    values = {c: float(grid.values[c.name][index]) for c in grid.criteria}
    tight = max(values, key=lambda c: values[c] / c.wanted if np.isfinite(values[c]) else np.inf)
    return _does(tight, values[tight])


def _does(criterion: Criterion, value: float) -> str:
    return f"{criterion.label} {in_words(value, criterion.unit)}"


def _span(
    name: str, chosen: float, values: FloatArray, excess: FloatArray, at: int, sides: tuple[str, str], suits: str,
    worst: Callable[[int], str],
) -> str:  # fmt: skip
    """How far a depth or a pitch may be changed, and what it would cost beyond that."""
    text = f"{name} {in_words(chosen, 'm')}: "
    if values.size == 1:
        return f"{text}the only one that was allowed."
    best = float(excess.min())
    limit, verb = (1.0, "would do") if best <= 1 else (_NEAR * best, "would be within 10 % of the best")
    good = excess <= limit
    low, high = stretch(good, at if good[at] else int(np.argmin(excess)))
    if low == high:
        text += f"for noise alone none of its neighbours on the grid {verb}{suits}"
    else:
        first, last = min(float(values[low]), chosen), max(float(values[high]), chosen)
        text += f"for noise alone anything from {in_words(first, 'm')} to {in_words(last, 'm')} {verb}{suits}"
    for i, side in zip((low - 1, high + 1), sides, strict=True):
        if 0 <= i < values.size and np.isfinite(excess[i]):
            text += f"; {side}, {worst(i)}"
    return text + "."


def finger_table(study: DesignStudy) -> tuple[list[str], list[list[str]], int]:
    """Columns, one row for each finger of `study`, and how many of the first columns are text.

    Errors are those that 95 % of the touches keep, the tolerances of making included where they were stated; unsure is
    the share of touches that are ambiguous or not felt, two the distance at which two are told from one. What there was
    no choice of has no column.
    """
    goals = study.goals
    choices = (len(goals.sensors) > 1) + (len(goals.skins) > 1)
    rows = [_cells(goals, finger, rank) for rank, finger in enumerate(study.fingers, start=1)]
    return list(rows[0]), [list(row.values()) for row in rows], 2 + choices


def _cells(goals: Goals, finger: DesignedFinger, rank: int) -> dict[str, str]:
    row = finger.row
    values = finger.values | {check.criterion.name: check.value for check in finger.checks}
    # how many times what was wanted, never rounded down to 1
    times = f"{np.ceil(100 * finger.excess) / 100:.3g} x" if np.isfinite(finger.excess) else "not met"
    cells = {"": str(rank), "goals": "met" if finger.meets else times}
    if len(goals.sensors) > 1:
        cells["sensor"] = goals.sensors[row.sensor].name
    if len(goals.skins) > 1:
        cells["skin"] = goals.skins[row.skin].name
    cells |= {
        "n": str(row.count),
        "pitch": in_words(row.pitch, "m"),
        "depth": in_words(row.depth, "m"),
        "position": in_words(values["position_95"], "m"),
        "angle": in_words(values["angle_95"], "rad") if goals.touches.friction > 0 else "-",
        "unsure": in_words(values["unsure"], ""),
    }
    if goals.accuracy.feature is not None:
        cells["two"] = in_words(finger.point, "m")
    return cells
