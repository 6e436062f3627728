"""The table of the fingers that a search found, for the report, the command line and the studio."""

from __future__ import annotations

import numpy as np

from .search import Check, DesignedFinger, DesignStudy, Goals
from .words import after, in_words, met

__all__ = ["finger_table", "legend_of"]


def finger_table(study: DesignStudy) -> tuple[list[str], list[list[str]], int]:
    """Columns, one row for each finger of `study`, and how many of the first columns are text.

    `legend_of` says what the columns are. What there was no choice of has no column.
    """
    goals = study.goals
    choices = (len(goals.choices) > 1) + (len(goals.skins) > 1)
    both = any(finger.outcome is not None for finger in study.fingers)
    rows = [_cells(goals, finger, rank, both) for rank, finger in enumerate(study.fingers, start=1)]
    return list(rows[0]), [list(row.values()) for row in rows], 2 + choices + goals.on_area


def legend_of(study: DesignStudy) -> str:
    """What the columns of `finger_table` are."""
    accuracy = study.goals.accuracy
    outcome = next((finger.outcome for finger in study.fingers if finger.outcome is not None), None)
    ratio = "how many times too large the worst value is"
    if outcome is None or accuracy.calibrated == "none":
        parts = [f"goals: met, or {ratio}{'' if outcome is None else ' as made'}"]
    else:
        parts = [f"goals: met as made, met once it is calibrated, or {ratio} then"]
    lost = "share of touches that are ambiguous or not noticed"
    if outcome is not None:
        lost = f"share of touches that are ambiguous, not noticed or lost by a finger {after(outcome)}"
    errors = ", ".join(name for name, _ in _errors(study.goals))
    parts += [f"{errors}: standard errors that 95 % of the touches keep", f"unsure: {lost}"]
    if outcome is not None:
        parts.append("as made: the same share before a calibration")
    if accuracy.feature is not None:
        parts.append("two: distance at which two touches read as two")
    if accuracy.edge is not None:
        parts.append("edge: standard error of an edge's direction that 95 % of the edges keep")
    return "; ".join(parts) + "."


def _cells(goals: Goals, finger: DesignedFinger, rank: int, both: bool) -> dict[str, str]:
    """Cells by column; with `both` there are fingers that tolerances are counted of."""
    row = finger.row
    values = finger.values | {check.criterion.name: check.value for check in finger.checks}
    cells = {
        "": str(rank),
        "goals": "calibrated" if finger.meets and not met(finger.as_made) else _times(finger.checks),
    }
    if len(goals.choices) > 1:
        cells["sensor"] = goals.choices[row.sensor].name
    if len(goals.skins) > 1:
        cells["skin"] = goals.skins[row.skin].name
    if goals.on_area:
        cells["layout"] = row.layout.text
    else:
        cells["n"] = str(row.count)
    cells |= {"pitch": "-" if row.free else in_words(row.pitch, "m"), "depth": in_words(row.depth, "m")}
    for name, unit in _errors(goals):
        known = name == "angle" and goals.touches.friction == 0
        cells[name] = "-" if known else in_words(values[f"{name}_95"], unit)
    if not both:
        cells["unsure"] = in_words(values["unsure"], "")
    else:
        for name, checks in (("unsure", finger.calibrated), ("as made", finger.as_made)):
            cells[name] = next(in_words(c.value, "") for c in checks if c.criterion.name == "unsure")
    if goals.accuracy.feature is not None:
        cells["two"] = in_words(finger.point, "m")
    if goals.accuracy.edge is not None:
        cells["edge"] = in_words(finger.edge, "rad")
    return cells


def _errors(goals: Goals) -> list[tuple[str, str]]:
    """Errors that the table shows, and their units: those of position and angle; on an area those that are wanted."""
    every = [("position", "m"), ("angle", "rad"), ("force", ""), ("radius", "m")]
    if not goals.on_area:
        return every[:2]
    return [one for one in every if getattr(goals.accuracy, one[0]) is not None]


def _times(checks: tuple[Check, ...]) -> str:
    """Met, or how many times what was wanted the worst is, never rounded down to 1."""
    excess = max(check.ratio for check in checks)
    if excess <= 1:
        return "met"
    return f"{np.ceil(100 * excess) / 100:.3g} x" if np.isfinite(excess) else "not met"
