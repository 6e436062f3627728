"""What a calibration found, for a page: how well it explains its touches, and what is another number than before."""

from __future__ import annotations

from typing import Any

import numpy as np

from ...calibration import Calibration
from ...io.finger_file import FingerFile

__all__ = ["fit_told"]


def fit_told(file: FingerFile, found: Calibration | None, *, relative: bool) -> dict[str, Any]:
    """What a page is told of a calibration, or that there is none yet.

    Parameters
    ----------
    file : FingerFile
        The finger as it was.
    found : Calibration or None
        What the touches made of it.
    relative : bool
        The force of the touches is not known, and nor is the gain of all sensors together.
    """
    if found is None:
        return {"health": ["ok"] * len(file.names), "r2": None, "doubts": [], "changes": []}
    return {
        "health": [one.name.lower() for one in found.health],
        "r2": float(found.r2),
        "doubts": list(found.doubts),
        "changes": _changes(file, found, relative),
    }


def _changes(file: FingerFile, found: Calibration, relative: bool) -> list[list[str]]:
    """What is another number than in the file: what, in the file, found."""
    old, new = file.finger.array, found.finger.array
    rows = []
    gains = [np.broadcast_to(np.asarray(one.gain, float), (len(new),)) for one in (old, new)]
    depths = [1e3 * float(np.mean(np.asarray(one.depth))) for one in (old, new)]
    if relative:
        gains = [gain / gain.mean() for gain in gains]
    for name, before, after in zip(file.names, *gains, strict=True):
        rows.append([f"gain of {name}{', of the mean' if relative else ''}", f"{before:.4g}", f"{after:.4g}"])
    rows.append(["depth of the sensors, mean", f"{depths[0]:.3f} mm", f"{depths[1]:.3f} mm"])
    for axis, (before, after) in zip(
        "yz", np.broadcast(*map(np.atleast_1d, (file.origin, found.origin))), strict=False
    ):
        rows.append([f"origin {axis}", f"{1e3 * before:.3f} mm", f"{1e3 * after:.3f} mm"])
    return rows
