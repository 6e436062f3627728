"""Room behind the last frames of a stream, so that the next ones need not copy them."""

from __future__ import annotations

from typing import TypeAlias

import numpy as np

from .._check import FloatArray

__all__ = ["Arrays", "behind", "since"]

Arrays: TypeAlias = tuple[FloatArray, FloatArray]
"""Frames (m, n) and their times (m,)."""

_LEAST = 64
_WIDE = 8
"""Where the frames that are kept fill less than one part in so many of the arrays, they leave these."""


def behind(frames: FloatArray, time: FloatArray, room: list[Arrays], many: int) -> Arrays:
    """Arrays that begin with the frames of a state, and have room for `many` more.

    A state ends where its own frames end. What lies behind belongs to no one until a step takes it, so frames are
    copied only where no room is left, or where a state is gone on with for the second time.

    Parameters
    ----------
    frames, time : ndarray, shape (k, n) and (k,)
        Those of the state.
    room : list
        The arrays that they lie at the beginning of, where nobody has taken them yet.
    many : int
        How many are to come.
    """
    kept = len(time)
    size = kept + many
    try:
        arrays = room.pop()  # at once: of two threads one gets it
        if size <= len(arrays[1]):
            return arrays
    except IndexError:
        pass
    most = size + max(size, _LEAST)
    arrays = np.empty((most, frames.shape[1])), np.empty(most)
    arrays[0][:kept], arrays[1][:kept] = frames, time
    return arrays


def since(arrays: Arrays, head: int, end: int) -> tuple[FloatArray, FloatArray, list[Arrays]]:
    """The frames and times from `head` to `end`, closed to writing, and the room behind them."""
    frames, time = arrays[0][head:end], arrays[1][head:end]
    room = [(arrays[0][head:], arrays[1][head:])]
    if _WIDE * (end - head + _LEAST) < len(arrays[1]):
        frames, time, room = frames.copy(), time.copy(), []
    frames.setflags(write=False)
    time.setflags(write=False)
    return frames, time, room
