"""The files of a session at the bench: where touches can be made, and the finger that comes of them."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from .._check import FloatArray
from ..calibration import Calibration
from ..errors import InvalidValueError
from ..io.finger_file import FingerFile
from ..io.units import quantity
from .bench import Bench

__all__ = ["calibrated", "candidates_of"]


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


def calibrated(bench: Bench, found: Calibration) -> FingerFile:
    """The finger as it is after a session: readings are differences from the free skin.

    Parameters
    ----------
    bench : Bench
        What asked for the touches.
    found : Calibration
        What came of them.
    """
    facts: dict[str, Any] = {"source": "bench", "fit": list(bench.fit), "touches": found.score.touches}
    facts["r2"] = float(found.r2)
    return replace(bench.file, differences=True).with_finger(found.finger, found.origin, facts, turn=found.turn)
