"""How each compiled loop of a pressure begins a frame, and which weight it tries next."""

from __future__ import annotations

from ..._compiled import compiled
from ..scan import MOST_CHI2
from . import columns as column

OK, AMBIGUOUS, NO_CONTACT, UNEXPLAINED, PENDING = 0.0, 1.0, 2.0, 3.0, -1.0
EDGE = 0.02
"""Share of the force at the edge of the search from which some may lie beyond it."""


@compiled()
def begun(reading, sensors, silent, row, b):
    """Whether a frame has a pressure to be found: its whitened readings into b, what else there is to say into `row`.

    sensors (4, n): offset, 1 / noise, ends of the range; no contact where chi-square is at most `silent`.
    """
    row[:] = float("nan")
    usable, power = True, 0.0
    for i in range(b.size):
        usable &= sensors[2, i] < reading[i] < sensors[3, i]
        b[i] = (reading[i] - sensors[0, i]) * sensors[1, i]
        power += b[i] * b[i]
    if not (usable and power < MOST_CHI2):
        row[column.STATUS] = PENDING
        return False
    row[column.STATUS], row[column.RESIDUAL] = NO_CONTACT, power
    return power > silent


@compiled()
def next_factor(factor, count, chi2, largest):
    """By what the weight has to change, after a change by `factor`: 0 where it will do."""
    if count < 0:
        return 9.0  # too little smoothness for the arithmetic
    return 0.0 if chi2 <= largest or factor > 1.0 else 1.0 / 9.0  # too smooth for these readings
