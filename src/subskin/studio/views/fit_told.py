"""What a calibration found, for a page: how well it explains its touches, and what is another number than before."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..._check import FloatArray
from ..._shown import with_error
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
    """What is another number than in the file: what, in the file, found, its standard error; empty where not fitted."""
    old, new = file.finger.array, found.finger.array
    n = len(new)
    gains = [np.broadcast_to(np.asarray(one.gain, float), (n,)) for one in (old, new)]
    depths = [1e3 * float(np.mean(np.asarray(one.depth))) for one in (old, new)]
    slope = np.eye(n)
    if relative:
        slope = (slope - gains[1][:, None] / gains[1].sum()) / gains[1].mean()
        gains = [gain / gain.mean() for gain in gains]
    rows = []
    for name, before, after, error in zip(file.names, *gains, _errors(found, "gain", slope), strict=True):
        rows.append([f"gain of {name}{', of the mean' if relative else ''}", f"{before:.4g}", *_shown(after, error)])
    depth_errors = (_errors(found, term, np.full((1, k), 1e3 / k))[0] for term, k in (("depth", 1), ("depths", n)))
    depth_error = next(filter(np.isfinite, depth_errors), np.nan)
    rows.append(["depth of the sensors, mean", f"{depths[0]:.3f} mm", *_shown(depths[1], depth_error, "mm")])
    origins = [1e3 * each for each in np.broadcast_arrays(*map(np.atleast_1d, (file.origin, found.origin)))]
    for axis, before, after in zip("yz", *origins, strict=False):
        term = f"origin_{axis}" if len(origins[0]) > 1 else "origin"
        error = _errors(found, term, np.full((1, 1), 1e3))[0]
        rows.append([f"origin {axis}", f"{before:.3f} mm", *_shown(after, error, "mm")])
    return rows


def _errors(found: Calibration, name: str, slope: FloatArray) -> FloatArray:
    """Standard errors of what is linear in the fitted numbers of a name; NaN where these were not fitted."""
    at = [i for i, p in enumerate(found.parameters) if p.name == name]
    if len(at) != slope.shape[1]:
        return np.full(len(slope), np.nan)
    return np.asarray(np.sqrt(np.einsum("ij,jk,ik->i", slope, found.covariance[np.ix_(at, at)], slope)))


def _shown(value: float, error: float, unit: str = "") -> tuple[str, str]:
    """A number and its standard error, to the digits that the error leaves."""
    if not (np.isfinite(error) and error > 0):
        return f"{value:.3f} {unit}" if unit else f"{value:.4g}", ""
    number, _, rest = with_error(value, error, "").partition(" +- ")
    return f"{number} {unit}".strip().replace("-", "\N{MINUS SIGN}"), f"{rest} {unit}".strip()
