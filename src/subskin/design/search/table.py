"""The ranked fingers as a table for people."""

from __future__ import annotations

import numpy as np

from .rank import DesignedFinger, DesignStudy
from .reasons import in_words

__all__ = ["finger_table"]


def finger_table(study: DesignStudy) -> tuple[list[str], list[list[str]], int]:
    """Columns, one row for each finger of `study`, and how many of the first columns are text.

    Errors are those that 95 % of the touches keep, the tolerances of making included where they were stated; unsure is
    the share of touches that are ambiguous or not felt, two the distance at which two are told from one. What there was
    no choice of has no column.
    """
    rows = [_row(study, finger, rank) for rank, finger in enumerate(study.fingers, start=1)]
    return list(rows[0]), [list(row.values()) for row in rows], 2 + sum(_choices(study))


def _choices(study: DesignStudy) -> tuple[bool, bool]:
    """Whether there was a choice of sensors, and of skins."""
    return len(study.goals.sensors) > 1, len(study.goals.skins) > 1


def _row(study: DesignStudy, finger: DesignedFinger, rank: int) -> dict[str, str]:
    goals, row, values = study.goals, finger.row, finger.values
    done = {check.criterion.name: check.value for check in finger.checks}
    cells = {"": str(rank), "goals": "met" if finger.meets else _times(finger.excess)}
    kinds, skins = _choices(study)
    if kinds:
        cells["sensor"] = goals.sensors[row.sensor].name
    if skins:
        cells["skin"] = goals.skins[row.skin].name
    cells |= {
        "n": str(row.count),
        "pitch": in_words(row.pitch, "m"),
        "depth": in_words(row.depth, "m"),
        "position": in_words(done.get("position_95", values["position_95"]), "m"),
        "angle": in_words(done.get("angle_95", values["angle_95"]), "rad") if goals.touches.friction > 0 else "-",
        "unsure": in_words(values["unsure"], ""),
    }
    if goals.accuracy.feature is not None:
        cells["two"] = in_words(finger.point, "m")
    return cells


def _times(excess: float) -> str:
    """How many times what was wanted, never rounded down to 1."""
    return f"{np.ceil(100 * excess) / 100:.3g} x" if np.isfinite(excess) else "not met"
