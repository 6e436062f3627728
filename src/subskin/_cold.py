"""How a loop begins, of which no machine code is kept: in plain Python for a few frames, or compiled at once."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

__all__ = ["at_once", "few"]

_FEW = [16]
"""What goes in plain Python takes up to 0.1 s a frame, where to compile the loop takes 5 to 30 s."""


def few() -> int:
    """Frames that a loop takes in plain Python before it is compiled.

    Examples
    --------
    >>> with at_once():
    ...     few()
    0
    """
    return _FEW[-1]


@contextmanager
def at_once() -> Iterator[None]:
    """Within this context no loop begins in plain Python: what will be in a hurry later is compiled."""
    _FEW.append(0)
    try:
        yield
    finally:
        _FEW.pop()
