"""Many lifts with some hands: what is dropped, how far things slide, how hard they are squeezed."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import partial
from typing import Any

import numpy as np

from .. import _check
from .._tasks import Executor, run_tasks
from ..errors import InvalidValueError
from ..finger import Finger
from .hand import Hand
from .lifting import Lifted, lift, pad_finger
from .peers import ConeHand, FixedHand, ForceHand
from .scene import Thing

__all__ = ["HANDS", "hand_of", "lifts", "summary"]

HANDS = ("skin", "force", "cone", "fixed")
"""`Hand`; it is told the true forces; these and the friction; it grips with one force."""
_SLID = 2e-3
"""What counts as slid [m]."""
_TOGETHER = 8
_GRIP = 13.8
"""What holds 0.6 kg that are filled to 0.9 kg, at a friction of 0.4, 1.25 times [N]."""


def hand_of(name: str, finger: Finger | None = None, *, grip: float = _GRIP) -> Hand:
    """One of `HANDS`, with two pads.

    Parameters
    ----------
    name : str
        "skin", "force", "cone" or "fixed".
    finger : Finger, optional
        Both pads; `pad_finger()` if left out.
    grip : float, optional
        Of a fixed grip [N].

    Raises
    ------
    InvalidValueError
        Another name.

    Examples
    --------
    >>> type(hand_of("cone")).__name__
    'ConeHand'
    """
    _check.choice("hand", name, HANDS)
    fingers = [pad_finger() if finger is None else finger] * 2
    if name == "fixed":
        return FixedHand(fingers, grip=grip)
    return {"skin": Hand, "force": ForceHand, "cone": ConeHand}[name](fingers)


def lifts(
    things: Sequence[Thing],
    hand: str = "skin",
    finger: Finger | None = None,
    *,
    grip: float = _GRIP,
    executor: Executor | None = None,
    progress: Callable[[], object] | None = None,
) -> list[Lifted]:
    """Lift each of some things, with the noise of its number.

    Parameters
    ----------
    things : sequence of Thing
        What is lifted.
    hand, finger, grip
        As of `hand_of`.
    executor : Executor, optional
        What shares the work, such as a `ProcessPoolExecutor`; one after the other in this thread, if left out.
    progress : callable, optional
        Called after each.

    Examples
    --------
    >>> from subskin.grasp import things
    >>> [lifted.dropped for lifted in lifts(things(2), "cone")]
    [False, False]
    """
    found: dict[int, list[Lifted]] = {}
    # a finger that goes to another process is prepared there anew: some lifts go together
    chunk = 1 if executor is None else _TOGETHER
    tasks = [
        partial(_some, things, range(i, min(i + chunk, len(things))), hand, finger, grip)
        for i in range(0, len(things), chunk)
    ]

    def passed(_number: int, lifted: list[Lifted]) -> None:
        for _ in lifted:
            if progress is not None:
                progress()

    run_tasks(tasks, found.__setitem__, executor=executor, workers=1, passed=passed)
    return [lifted for i in range(len(tasks)) for lifted in found[i]]


def _some(things: Sequence[Thing], numbers: range, name: str, finger: Finger | None, grip: float) -> list[Lifted]:
    hand = hand_of(name, finger, grip=grip)
    hand.warm_up()
    return [lift(things[i], hand, i) for i in numbers]


def summary(lifted: Sequence[Lifted]) -> Mapping[str, Any]:
    """What came of some lifts, in numbers.

    Parameters
    ----------
    lifted : sequence of Lifted
        What came of each.

    Returns
    -------
    dict
        `lifts`, `dropped`; `slid_2mm` (share that slid at most 2 mm); `slid` and `slid_95` (median and 95 % of how far
        [m]); `grip` (its median over the least that holds, of what was not dropped); `friction` (median of what was
        learnt over the truth, of what learnt any); `real_time` (simulated time over time taken); `slowest` (99th
        percentile of a step with its frame [s]).

    Raises
    ------
    InvalidValueError
        No lifts.

    Examples
    --------
    >>> from subskin.grasp import things
    >>> summary(lifts(things(2), "cone"))["dropped"]
    0
    """
    if not lifted:
        raise InvalidValueError("no lifts", "one at least is needed", "lifts(things(10))")
    slid = np.sort([each.slid for each in lifted])
    held = [each for each in lifted if not each.dropped]
    learnt = [each.friction / each.thing.friction for each in lifted if each.friction > 0]
    return {
        "lifts": len(lifted),
        "dropped": sum(each.dropped for each in lifted),
        "slid_2mm": float((slid <= _SLID).mean()),
        "slid": float(np.median(slid)),
        "slid_95": float(slid[int(np.ceil(0.95 * len(slid))) - 1]),
        "grip": float(np.median([each.waste for each in held])) if held else np.nan,
        "friction": float(np.median(learnt)) if learnt else np.nan,
        "real_time": float(np.median([each.seconds / each.wall for each in lifted])),
        "slowest": float(np.median([each.slowest for each in lifted])),
    }
