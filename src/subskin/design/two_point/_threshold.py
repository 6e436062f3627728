"""From which separation on a distance is large enough, and stays so."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import numpy.typing as npt

from ..._check import FloatArray

_CLOSER = 17
"""Separations in a closer look."""
_LOOKS = 3
"""Closer looks, each at the least of the one before."""

Look = Callable[[FloatArray, npt.NDArray[np.intp]], FloatArray]


def from_which_on(step: FloatArray, distance: FloatArray, needed: float, look: Look) -> FloatArray:
    """Separation beyond which every distance (s, k) is enough, shape (k,); infinite where the last is not.

    `look(separation (s, j), which (j,))` gives more distances. Two points that are told may be one's metamer again
    farther apart: the distance then falls to 0 and rises again, perhaps between two steps.
    """
    tiny = 1e-9 * needed
    # below the first step the distance goes on as a power of the separation
    ratio = np.log(step[1] / step[0])
    power = ratio / np.maximum(np.log(np.maximum(distance[1], tiny) / np.maximum(distance[0], tiny)), ratio)
    out = step[0] * np.minimum(needed / np.maximum(distance[0], needed), 1.0) ** power
    never = distance[-1] < needed
    out[never] = np.inf
    suspect = distance < needed
    suspect[1:-1] |= _dips(distance)
    left_over = np.flatnonzero(~never & suspect.any(axis=0))
    while left_over.size:
        last = step.size - 1 - np.argmax(suspect[::-1, left_over], axis=0)
        low, high = step[np.maximum(last - 1, 0)], step[last + 1]
        for _ in range(_LOOKS):
            closer = np.geomspace(low, high, _CLOSER)
            seen = np.maximum(look(closer, left_over), tiny)
            short = seen < needed
            found = short.any(axis=0)
            at = np.clip(np.argmin(seen, axis=0), 1, _CLOSER - 2)
            low = np.where(found, low, _at(closer, at - 1))
            high = np.where(found, high, _at(closer, at + 1))
            if found.all():
                break
        k = np.minimum(_CLOSER - 1 - np.argmax(short[::-1], axis=0), _CLOSER - 2)
        before, after, under, over = _at(closer, k), _at(closer, k + 1), _at(seen, k), _at(seen, k + 1)
        with np.errstate(divide="ignore", invalid="ignore"):
            between = before * (after / before) ** (np.log(needed / under) / np.log(over / under))
        out[left_over[found]] = between[found]
        suspect[last, left_over] = False
        left_over = left_over[~found & suspect[:, left_over].any(axis=0)]
    return np.asarray(out)


def _dips(distance: FloatArray) -> npt.NDArray[np.bool_]:
    """Inner steps beside which the distance may go through 0: its square is about a parabola there."""
    left, here, right = distance[:-2] ** 2, distance[1:-1] ** 2, distance[2:] ** 2
    bend = left - 2 * here + right
    least = here - (right - left) ** 2 / np.where(bend > 0, 8 * bend, np.inf)
    return np.asarray((here <= left) & (here <= right) & (least < 0.5 * here))


def _at(values: FloatArray, index: npt.NDArray[np.intp]) -> FloatArray:
    """Of each column (s, k) the value of its own row (k,)."""
    return np.asarray(np.take_along_axis(values, index[None], axis=0)[0])
