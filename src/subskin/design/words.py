"""A design in words, for the report and the command line: values in units for people, a verdict, reasons."""

from __future__ import annotations

import re
from collections.abc import Callable

import numpy as np

from .._check import FloatArray
from ._common import stretch
from .search import Check, Criterion, DesignGrid, DesignStudy, Goals, Remedy, Row
from .tolerance import SOURCES, Outcome
from .touches import Touches

__all__ = [
    "after", "amount_in_words", "force_in_words", "held", "in_words", "met", "reasons_of", "remedies_of",
    "row_in_words", "tolerances_of", "unit_of", "unseen", "usual_goals_of", "verdict_of",
]  # fmt: skip

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
    per_length = f"{touches.force:.6g} {touches.unit}"
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


def unit_of(goals: Goals, row: Row) -> str | None:
    """Unit of the readings of a design; None of several kinds."""
    units = {kind.transducer.unit for kind in goals.choices[row.sensor].kinds}
    return units.pop() if len(units) == 1 else None


def amount_in_words(source: str, amount: float, unit: str | None) -> str:
    """The amount of a tolerance in the unit that people use; `unit` is that of the readings, None of several kinds.

    Examples
    --------
    >>> amount_in_words("depth", 5e-5, "Pa"), amount_in_words("gains", 0.05, "Pa"), amount_in_words("offset", 2.0, "Pa")
    ('0.05 mm', '5 %', '2 Pa')
    """
    if SOURCES[source].unit == "reading":
        if unit is None:
            return "as the noise"
        return f"{amount:.3g} {unit}".strip()
    return f"{amount:g}" if source == "poisson" else in_words(amount, SOURCES[source].unit)


_AFTER = {
    "known": "calibrated on {} touches at known positions",
    "blind": "calibrated on {} touches of which nothing is known",
}


_ROW = " By sensors in a row locate takes touches for lines across it."


def after(outcome: Outcome) -> str:
    """After which calibration a finger is judged.

    Parameters
    ----------
    outcome : Outcome
        What its tolerances leave of it.
    """
    return _AFTER[outcome.method].format(outcome.presses)


def verdict_of(study: DesignStudy) -> str:
    """Whether the first finger meets every goal, and whether as made or only once it is calibrated.

    A finger that meets them calibrated alone is said to, with what it misses as made; so is one that would meet them.
    """
    best, calibrated = study.fingers[0], study.goals.accuracy.calibrated
    if best.outcome is None:
        if best.meets:
            return "It meets every goal. Only the noise of the sensors is counted, no tolerance of the making."
        why = _ROW if study.goals.on_area and not best.finger.array.on_area else ""
        return f"It misses: {_missed(best.checks)}.{why}"
    once = after(best.outcome)
    if best.meets and met(best.as_made):
        return f"It meets every goal as it is made{f', and {once}' if met(best.calibrated) else ''}."
    if best.meets:
        return f"It meets every goal once it is {once}. As made it misses: {_missed(best.as_made)}."
    if met(best.calibrated):
        return f"As made it misses: {_missed(best.as_made)}. It would meet every goal {once}."
    return f"It misses{'' if calibrated == 'none' else f', {once}'}: {_missed(best.checks)}."


def tolerances_of(study: DesignStudy) -> str:
    """Which tolerances of the making are counted, and whether they were stated."""
    best, stated = study.fingers[0], study.goals.tolerances
    if best.outcome is None:
        return "No tolerances of the making are counted, only the noise of the sensors."
    unit = unit_of(study.goals, best.row)
    listed = ", ".join(
        f"{SOURCES[name].text} {amount_in_words(name, amount, unit)}"
        for name, amount in best.outcome.amounts.items()
        if name != "noise"
    )
    who = "The tolerances that were stated" if stated else "No tolerances were stated. The usual ones"
    return f"{who} are counted, as standard deviations: {listed}."


def usual_goals_of(study: DesignStudy) -> str:
    """Which goal was taken because none was stated; nothing where all were."""
    accuracy = study.goals.accuracy
    if accuracy.blind_spots is not None or study.fingers[0].unopposed is None:
        return ""
    most = in_words(accuracy.outside, "")
    return (
        f"No goal was stated for touches outside the model. The usual one is taken: at most {most} of each kind "
        "of them may be OK and wrong."
    )


def remedies_of(study: DesignStudy) -> tuple[str, ...]:
    """What would do where no design of the grid does, one sentence a change; none where one does."""
    goals, room = study.goals, study.goals.room
    found: dict[str, Remedy] = {remedy.what: remedy for remedy in study.remedies}
    if not found:
        return ()
    borne, force, young, depth, count = (found[name] for name in ("borne", "force", "young", "depth", "count"))
    out, unit = [], goals.touches.unit
    if np.isfinite(borne.value):
        out.append(
            f"The largest force that a design within the limits bears is {borne.value:.3g} {unit} "
            f"({_row(goals, borne.row)}), and {goals.strongest:.6g} {unit} has to be borne."
        )
    if np.isfinite(force.value) and force.value < goals.strongest:
        out.append(f"A strongest force of {force.value:.3g} {unit} would do: {_row(goals, force.row)}.")
    if young.row is not None:
        own = goals.skins[young.row.skin]
        base = own.skin.material_at(young.row.depth).young
        out.append(
            f"A skin {young.value:.3g} times as stiff would do, {young.value * base / 1e6:.3g} MPa instead of "
            f"{base / 1e6:.3g} MPa: {_row(goals, young.row)}."
        )
    if depth.row is not None:
        ends = " to ".join(in_words(end, "m") for end in dict.fromkeys(room.depth))
        out.append(f"A depth of {in_words(depth.value, 'm')} would do instead of {ends}: {_row(goals, depth.row)}.")
    if count.row is not None:
        out.append(f"{count.value:.0f} sensors instead of {room.count[1]} would do: {_row(goals, count.row)}.")
    names = {"force": "a smaller force", "young": "another modulus", "depth": "another depth", "count": "more sensors"}
    no = [text for name, text in names.items() if not np.isfinite(found[name].value)]
    if no:
        listed = f"{', '.join(no[:-1])} or {no[-1]}" if len(no) > 1 else no[0]
        out.append(f"No way was found to meet the goals with {listed} alone.")
    out.append("What would do was looked for with noise alone.")
    return tuple(out)


def _row(goals: Goals, row: Row | None) -> str:
    return "" if row is None else row_in_words(goals, row)


def row_in_words(goals: Goals, row: Row) -> str:
    """What a design is: how many of what, how far apart and how deep, in which skin."""
    many = f"{row.layout.text}," if goals.on_area or row.free else f"{row.count} ×"
    apart = "" if row.free else f"{in_words(row.pitch, 'm')} apart, "
    return (
        f"{many} {goals.choices[row.sensor].name}, {apart}"
        f"{in_words(row.depth, 'm')} deep in “{goals.skins[row.skin].name}”"
    )


def met(checks: tuple[Check, ...]) -> bool:
    """Whether every goal is met.

    Parameters
    ----------
    checks : tuple of Check
        What the goals say of a finger.
    """
    return all(check.ratio <= 1 for check in checks)


def _missed(checks: tuple[Check, ...]) -> str:
    """What is missed, and by how much."""
    return "; ".join(
        f"{_does(c.criterion, c.value)} (at most {in_words(c.criterion.wanted, c.criterion.unit)} wanted)"
        for c in checks
        if not c.ratio <= 1
    )


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
    before = study.goals.layouts[n - 1]
    less = f"a {before.text}" if study.goals.on_area else str(before.count)
    fewer = f"; with {less} the best {_other(study, excess, (k, m, n - 1))}" if n else ", the fewest that were allowed"
    many = f"{row.count} positions ({row.layout.text})" if study.goals.on_area else f"{row.count} sensors"
    reasons = [
        _limit(study.goals, _own_checks(study, row)),
        f"{many}{fewer}.",
        _span("Depth", row.depth, depths, own.min(axis=1), d, ("shallower", "deeper"), ", with a pitch that suits it",
              lambda i: _worst(grid, (k, m, i, int(np.argmin(own[i])), n))),
        _span("Pitch", row.pitch, pitches, own[d], s, ("closer", "wider"), "", lambda i: _worst(grid, (k, m, d, i, n))),
    ]  # fmt: skip
    if row.free:
        base = study.goals.layouts[n].text
        what = f"{base} array" if study.goals.on_area else base
        reasons[-1] = f"Free positions: the sensors of the best {what}, each moved while that made it better."
    others = [("sensor", kind.name, (k, i, n)) for i, kind in enumerate(study.goals.choices) if i != m]
    others += [("skin", skin.name, (i, m, n)) for i, skin in enumerate(study.goals.skins) if i != k]
    for what, name, other in others:
        reasons.append(f'With {what} "{name}" the best of as many sensors {_other(study, excess, other)}.')
    told = np.where(np.isfinite(own), grid.values["log_det"][k, m, :, :, n], -np.inf)
    d, s = (int(i) for i in np.unravel_index(np.argmax(told), told.shape))
    if np.isfinite(told[d, s]) and own[d, s] > 1:
        reasons.append(
            "The design with the most information on average (D-optimality) has depth "
            f"{in_words(float(depths[d]), 'm')} and pitch {in_words(float(pitches[s]), 'm')}, and misses the goals: "
            f"{_worst(grid, (k, m, d, s, n))}."
        )
    return tuple(reasons)


def _own_checks(study: DesignStudy, row: Row) -> tuple[Check, ...]:
    """Those of a design that was looked at closely; free positions are not among the layouts of the grid."""
    own = [finger.checks for finger in study.fingers if finger.row == row]
    return own[0] if own else study.looked[row.which(study.goals)]


def _limit(goals: Goals, checks: tuple[Check, ...]) -> str:
    tight = max(checks, key=lambda check: check.ratio)
    most = in_words(tight.criterion.wanted, tight.criterion.unit)
    wanted = f"{_does(tight.criterion, tight.value)}, at most {most} wanted"
    if tight.ratio <= 1:
        needs = goals.tolerances != {} and goals.accuracy.calibrated != "none"
        return f"All goals are met{' once it is calibrated' if needs else ''}. The tightest: {wanted}."
    more = sum(check.ratio > 1 for check in checks) - 1
    return f"Not met: {wanted}{f', and {more} more' if more else ''}."


def _other(study: DesignStudy, excess: FloatArray, which: tuple[int, int, int]) -> str:
    """What the best row of a skin, kind and count does: of close looks, or else of the grid."""
    if which in study.looked:
        tight = max(study.looked[which], key=lambda check: check.ratio)
        return "meets the goals too" if tight.ratio <= 1 else f"misses the goals: {_does(tight.criterion, tight.value)}"
    k, m, n = which
    plane = excess[k, m, :, :, n]
    d, s = (int(i) for i in np.unravel_index(np.argmin(plane), plane.shape))
    if not np.isfinite(plane[d, s]):
        return unseen(study.grid, which) or "has no room, or does not notice all touches"
    if plane[d, s] <= 1:
        return "meets the goals on the grid, and was not looked at closely"
    return f"misses the goals on the grid: {_worst(study.grid, (k, m, d, s, n))}"


def unseen(grid: DesignGrid, which: tuple[int, int, int]) -> str:
    """That a layout does not see a touch, where no depth and pitch lets it; "" of others and of rows."""
    if not grid.goals.on_area:
        return ""
    k, m, n = which
    ranks = grid.values["rank"][k, m, :, :, n]
    needed = (3 if grid.goals.touches.friction == 0 else 5) + (grid.goals.touches.half_width is not None)
    best = np.nanmax(ranks) if np.isfinite(ranks).any() else np.nan
    return f"does not see the touch: it tells {best:.0f} of its {needed} unknowns" if best < needed else ""


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
