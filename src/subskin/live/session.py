"""A session at the bench: what is known of it, and what the person is told."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np

from .._check import FloatArray
from .._frozen import Frozen
from ..calibration import Calibration

__all__ = ["BenchState", "Said"]


@dataclass(frozen=True)
class Said:
    """One thing that the bench tells the person.

    Parameters
    ----------
    kind : str
        "rest" (hands off), "restless", "noise", "touch" (where to touch now), "hold", "short", "taken", "again",
        "skip", "calibrated", "reached" or "ended".
    text : str
        What a person reads.
    values : mapping
        Its numbers in SI.
    """

    kind: str
    text: str
    values: dict[str, Any] = field(default_factory=dict)


@dataclass(frozen=True, eq=False)
class BenchState(Frozen):
    """All that a bench carries from frame to frame.

    Parameters
    ----------
    phase : str
        "rest", "touch", "hold", "lift" or "done".
    asked : float or ndarray or None
        Where the person is to touch, on the axis of the touches [m].
    noise, zero : ndarray, shape (n,), or None
        Noise of each sensor, and what it reads of the free skin [reading]; None before they are measured.
    readings : ndarray, shape (m, n)
        Touches taken so far, as differences from the free skin [reading].
    positions : ndarray, shape (m,) or (m, 2)
        Where they were [m].
    found : Calibration or None
        The finger as the touches so far make it; None where they are too few.
    error : float
        Error of positions that is left, over the candidates [m]; NaN before it is known.
    skipped : tuple
        Positions that the person cannot reach.
    redo : float or ndarray or None
        Where a touch was taken back, and is asked for again [m].
    time, kept : ndarray, shape (k,), (k, n)
        Frames of the phase that are still looked at [s], [reading].
    run : int
        Frames one after the other that speak for the next phase.
    peak : float
        Largest reading of the touch, in noises [-].
    """

    phase: str
    readings: FloatArray
    positions: FloatArray
    asked: Any = None
    noise: FloatArray | None = None
    zero: FloatArray | None = None
    found: Calibration | None = None
    error: float = float("nan")
    skipped: tuple[Any, ...] = ()
    redo: Any = None
    time: FloatArray = field(default_factory=lambda: np.empty(0))
    kept: FloatArray = field(default_factory=lambda: np.empty((0, 0)))
    run: int = 0
    peak: float = 0.0
