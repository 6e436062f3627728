"""A session at the bench: where touches can be made, what is known of it, what a person is told, and the finger."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from .._check import FloatArray
from .._frozen import Frozen
from ..calibration import Calibration
from ..errors import InvalidValueError
from ..io.changed import with_calibration
from ..io.finger_file import FingerFile
from ..io.units import quantity

__all__ = ["BenchState", "Said", "calibrated", "candidates_of"]


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


def candidates_of(file: FingerFile, text: str | None = None, name: str = "positions") -> FloatArray:
    r"""Where touches can be made, on an area on both axes.

    Parameters
    ----------
    file : FingerFile
        The finger as drawn.
    text : str, optional
        "first:last:step", or a list; all over the sensors if left out: a depth beyond them, by a fourth of it.
    name : str, optional
        What messages call the text.

    Raises
    ------
    InvalidValueError
        A text that is neither.

    Examples
    --------
    >>> import subskin as ss
    >>> file = ss.io.parse_finger("[skin]\nyoung = 4e5\n[sensors]\ncount = 5\npitch = 3e-3\ndepth = 3e-3")
    >>> candidates_of(file, "-2 mm:2 mm:1 mm").tolist()
    [-0.002, -0.001, 0.0, 0.001, 0.002]
    """
    points, depth = file.finger.array.points, float(np.asarray(file.finger.array.depth).mean())
    area = points.ndim == 2 and points.shape[1] == 2 and bool(np.ptp(points[:, 1]))
    axes = []
    for axis in range(2 if area else 1):
        along = points[:, axis] if points.ndim == 2 else points
        if text is None:
            axes.append(np.arange(along.min() - depth, along.max() + 1.001 * depth, 0.25 * depth * (1 + area)))
        elif ":" in text:
            parts = [quantity(part, "m", name) for part in text.split(":")]
            if len(parts) != 3 or not parts[2] > 0 or not parts[1] > parts[0]:
                fix = f'{name} "-6 mm:6 mm:1 mm"'
                raise InvalidValueError(f'{name} "{text}"', "first:last:step is needed, rising", fix)
            axes.append(np.arange(parts[0], parts[1] + 1e-9, parts[2]))
        else:
            axes.append(np.array([quantity(part.strip(), "m", name) for part in text.split(",") if part.strip()]))
    axes = [np.round(along, 5) + 0.0 for along in axes]  # to what a person reads, and no -0
    return np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 2) if area else axes[0]


def calibrated(file: FingerFile, fit: Sequence[str], found: Calibration) -> FingerFile:
    """The finger as it is after a session: readings are differences from the free skin.

    Parameters
    ----------
    file : FingerFile
        The finger as drawn.
    fit : sequence of str
        What was fitted.
    found : Calibration
        What came of the touches.
    """
    facts: dict[str, Any] = {"source": "bench", "fit": list(fit), "touches": found.score.touches}
    facts["r2"] = float(found.r2)
    return with_calibration(replace(file, differences=True), found, facts)
