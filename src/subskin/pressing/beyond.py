"""Whether bodies that were pressed on a grid overlap beyond it, where the solver did not look."""

from __future__ import annotations

from typing import Any

import numpy as np

from .._check import FloatArray
from ..skin import Skin
from .case import Balance, Case, hats
from .influence import influence

__all__ = ["touches_beyond"]

_OVERLAP = 1e-3
"""Overlap beyond the window that counts, in shares of the greatest displacement: its pressure is a coarser one."""
_FAR_ROW = 24
"""Windows on either side of a row within which the bodies are looked at."""
_PARTS = 16
"""Nodes of a window beneath which its pressure is taken for the look beyond it."""
_WIDER, _FARTHEST = 3, 27.0
"""Times the size of the grid on an area that is looked over, each time more coarsely."""
_NODES = 96


def touches_beyond(skin: Skin, body: Any, case: Case, state: Balance) -> list[FloatArray]:
    """Where the bodies overlap most beyond the window, from the indenter's centre, none where they do not.

    On a row each end counts by itself: were the window to grow to one side alone, what touches there would lift the
    other off.
    """
    return (_row if len(case.axes) == 1 else _area)(skin, body, case, state)


def _row(skin: Skin, body: Any, case: Case, state: Balance) -> list[FloatArray]:
    wide, low = case.step * case.y.size, case.y[0] - 0.5 * case.step
    h = wide / _PARTS
    rough = hats(low + h * np.arange(_PARTS + 1), h, case.y) @ state.pressure * (case.step / h)
    most = min(_FAR_ROW, int(0.5 * skin.period / wide) - 1 if np.isfinite(skin.period) else _FAR_ROW) * _PARTS
    if most < _PARTS:
        return []
    rows = influence(skin, h, (most + _PARTS + 1,)).rows[0]
    within = case.influence.normal(state.pressure)
    limit, found = _OVERLAP * float(np.abs(within).max()), []
    for side in (-1, 1):
        edge = 0 if side < 0 else _PARTS
        nodes = edge + side * np.arange(most + 1)  # from the window's end outwards, in steps of h
        moved = rows[np.abs(nodes[:, None] - np.arange(_PARTS + 1))] @ rough
        moved += within[0 if side < 0 else -1] - moved[0]  # the same zero as within the window
        y = low + h * (edge + side * np.linspace(0, most, 16 * most + 1)[1:])
        y = y[(y > body.ends[0]) & (y < body.ends[1])]
        if not y.size:
            continue
        sunk = np.interp(side * ((y - low) / h - edge), np.arange(most + 1), moved)
        left = case.gap(y) + sunk - state.depth - state.tilt[0] * y
        worst = int(np.argmin(left))
        if left[worst] < -limit:
            found.append(y[worst : worst + 1])
    return found


def _area(skin: Skin, body: Any, case: Case, state: Balance) -> list[FloatArray]:
    middle = np.array([0.5 * (nodes[0] + nodes[-1]) for nodes in case.axes])
    half = 0.5 * case.step * np.array(case.height.shape)
    size, limits = float(half.max()), np.array(body.ends)
    if (middle - half <= limits[:, 0] + case.step).all() and (middle + half >= limits[:, 1] - case.step).all():
        return []
    wide = float(_WIDER)
    while wide <= _FARTHEST:
        step = 2 * wide * size / _NODES
        y, z = (m + 0.5 * step * (np.arange(2 * _NODES - 1) - (_NODES - 1.0)) for m in middle)
        away = (np.abs(y - middle[0])[:, None] > half[0]) | (np.abs(z - middle[1]) > half[1])
        left = np.asarray(case.gap(y[:, None], z)) - state.depth - state.tilt[0] * y[:, None] - state.tilt[1] * z
        if (left[away] < 0).any():  # else the skin, which sinks, cannot touch there
            shares = [hats(fine[::2], step, nodes) for fine, nodes in zip((y, z), case.axes, strict=True)]
            rough = shares[0] @ state.pressure @ shares[1].T * (case.cell / step**2)
            between = np.empty(left.shape)
            between[::2, ::2] = sunk = influence(skin, step, (_NODES, _NODES), False).normal(rough)
            between[1::2, ::2] = 0.5 * (sunk[1:] + sunk[:-1])
            between[:, 1::2] = 0.5 * (between[:, 2::2] + between[:, :-1:2])
            left = np.where(away, left + between, np.inf)
            at = np.unravel_index(int(np.argmin(left)), left.shape)
            if left[at] < -_OVERLAP * state.scale:
                return [np.array([y[at[0]], z[at[1]]])]
        wide *= _WIDER
    return []
