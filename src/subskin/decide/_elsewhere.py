"""Whether a load beyond the search explains a frame about as well as the kind that is decided for."""

from __future__ import annotations

import numpy as np

from .._check import FloatArray
from ..estimate.locate import row_locator
from ..finger import Finger

__all__ = ["beyond_search"]

_SEARCHED, _FARTHEST = 0.5, 8.0
"""Depths beside the row: up to which kinds are searched, and up to which a load is thought of, as in `locate`."""


def beyond_search(finger: Finger, frames: FloatArray, friction: float) -> FloatArray:
    """Least chi-square (m,) that a line load beyond the default search of `contact_type` leaves of frames (m, n)."""
    y, deepest = np.asarray(finger.array.y), float(np.max(finger.array.depth))
    near = _SEARCHED * deepest
    # about a finger that is round, what is far off comes back
    far = min(_FARTHEST * deepest, 0.5 * (finger.skin.period - float(np.ptp(y))))
    least = np.full(len(frames), np.inf)
    if not far > near:
        return least
    for side in ((y.min() - far, y.min() - near), (y.max() + near, y.max() + far)):
        least = np.fmin(least, row_locator(finger, search=side, friction=friction)(frames).residual)
    return least
