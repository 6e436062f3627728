"""Columns of the table that the evidence fills, one row a frame: of the frame, then of each kind of contact."""

from typing import NamedTuple

STATUS, KIND = 0, 1
LOG_EVIDENCE, CHI2, POSITION, NORMAL, TANGENTIAL, HALF_WIDTH, EACH = 0, 1, 2, 3, 4, 5, 6
"""How probable each kind of contact makes readings."""


class Columns(NamedTuple):
    """Where the columns of a kind begin, and what stands in which of them."""

    first: int
    each: int
    position: tuple[int, ...]
    components: tuple[int, ...]
    half_width: int
    edge: tuple[int, ...] = ()


LONG = Columns(KIND, EACH, (POSITION,), (NORMAL, TANGENTIAL), HALF_WIDTH)
LOCAL = Columns(KIND, 11, (2, 3), (4, 5, 6), 7, (8, 9, 10))
"""Of long contacts, and of contacts on an area; the log of the evidence and chi-square come first in both.

On an area half length, direction and its standard error of an edge come last.
"""
