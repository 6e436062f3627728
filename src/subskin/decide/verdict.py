"""What is said of a frame by its probability of slip."""

from __future__ import annotations

from enum import IntEnum

__all__ = ["SlipVerdict"]


class SlipVerdict(IntEnum):
    """What to make of a frame; the thresholds are those of `slip`."""

    HOLDS = 0
    """The probability of slip is below the first threshold."""
    AT_RISK = 1
    """It is between the two."""
    SLIPS = 2
    """It is at the second or above. A contact that slides lies on the cone: its frames scatter about 1/2."""
    CANNOT_TELL = 3
    """No load, or one of two, or one that the estimator's own cone cut off where friction may hold more."""
