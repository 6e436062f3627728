"""The ranked fingers as a table for people."""

from __future__ import annotations

import numpy as np

from .rank import DesignedFinger, DesignStudy
from .reasons import in_words

__all__ = ["finger_table"]


def finger_table(study: DesignStudy) -> tuple[list[str], list[list[str]]]:
    """Columns, and one row for each finger of `study`; the first four columns are text.

    Errors are those that 95 % of the touches keep, the tolerances of making included where they were stated;
    unsure is the share of touches that are ambiguous or not felt, two the distance at which two are told from one.
    """
    goals = study.goals
    feature = goals.accuracy.feature is not None
    columns = ["", "goals", "sensor", "skin", "n", "pitch", "depth", "place", "angle", "unsure"]
    columns += ["two"] * feature
    return columns, [_row(study, finger, rank) for rank, finger in enumerate(study.fingers, start=1)]


def _row(study: DesignStudy, finger: DesignedFinger, rank: int) -> list[str]:
    goals, row, values = study.goals, finger.row, finger.values
    done = {check.criterion.name: check.value for check in finger.checks}
    cells = [
        str(rank),
        "met" if finger.meets else _times(finger.excess),
        goals.sensors[row.sensor].name,
        goals.skins[row.skin].name,
        str(row.count),
        in_words(row.pitch, "m"),
        in_words(row.depth, "m"),
        in_words(done.get("position_95", values["position_95"]), "m"),
        in_words(done.get("angle_95", values["angle_95"]), "rad"),
        in_words(values["unsure"], ""),
    ]
    if goals.accuracy.feature is not None:
        cells.append(in_words(finger.point, "m"))
    return cells


def _times(excess: float) -> str:
    """How many times what was wanted, never rounded down to 1."""
    return f"{np.ceil(100 * excess) / 100:.3g} x" if np.isfinite(excess) else "not met"
