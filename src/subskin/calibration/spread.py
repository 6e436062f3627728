"""How far positions are really off: standard errors of a calibrated finger held against touches held out."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import numpy.typing as npt

from .._check import FloatArray
from ..errors import ConvergenceError
from ..estimate.estimate import Status
from ..spread import Spread
from .calibration import Calibration

__all__ = ["checked", "measured", "size_of"]

_FOLDS = 5
_FEWEST = 5
"""Touches held out and OK from which a spread is measured: with fewer it is not known to a half."""
_LEANING = (0.0, 1.0)
"""Friction of loads that press straight down, and of loads that may lean."""
_SHARE = 0.95
_KNOWN = 4.0
"""Ratio of two gains of a sensor, with and without some touches, above which only these touches knew it."""
_REACH, _STEP = 3.0, 0.5
"""How far beyond the row, and how finely, the spread is written down [depth]: misfit changes within a depth."""


def checked(found: Calibration, fit: Any, sizes: tuple[float, float], touches: tuple[int, int]) -> Calibration:
    """What was `found` by the `fit`, its finger with the spread of its standard errors and whether it is to be trusted.

    `sizes` and `touches` are what `measured` says of the fit. Of residuals that look like noise, of no more than its
    stated size, the standard errors are right as they are. A finger of which only some numbers are fitted anew (its
    origin, say) stays as it was where the touches do not tell.
    """
    anew = {"gain", "depth"} <= set(fit.names) or {"gain", "depths"} <= set(fit.names)
    spread = None if anew else fit.finger.spread
    if fit.uncertainty.process is not None and (anew or all(touches)):
        spread = _along(found, fit, sizes)
    trusted = not found.misfit.wrong and (anew or fit.finger.trusted)
    if trusted and spread is None:
        return found
    return replace(found, finger=replace(found.finger, spread=spread, trusted=trusted), held_out=touches)


def _along(found: Calibration, fit: Any, sizes: tuple[float, float]) -> Spread:
    """Standard errors of positions along the row: those of the process of the misfit, times the measured `sizes`."""
    y, depth = np.asarray(found.finger.array.y), float(np.mean(np.asarray(found.finger.array.depth)))
    first, last = y.min() - _REACH * depth, y.max() + _REACH * depth
    nodes = np.linspace(first, last, int(np.ceil((last - first) / (_STEP * depth))) + 1)
    straight, leaning = fit.uncertainty.of_positions(nodes) * np.array(sizes)[:, None]
    return Spread(nodes, straight, leaning)


def measured(fit: Any) -> tuple[tuple[float, float], tuple[int, int]]:
    """Errors of positions over the standard errors of the process of the misfit, of touches located by the others.

    `fit` is a solved `fit.Fit`, whose file imports this. Every fifth touch is left out in turn, then each of five
    blocks of neighbours: the first stand for new touches among those of the calibration, the second for touches in a
    gap. A fold in which the fit cannot do without its touches counts for nothing: it does not settle, or the gain of a
    sensor that no other touch came near goes astray, and no such finger is used. With the size for straight and leaning
    loads comes the number of touches that it rests on; where they are too few, or residuals are noise, it is 1, and the
    number 0.
    """
    if fit.uncertainty.process is None:
        return (1.0, 1.0), (0, 0)
    order = np.argsort(fit.positions, kind="stable")
    errors: tuple[list[float], list[float]] = ([], [])
    for rows in [*(order[k::_FOLDS] for k in range(_FOLDS)), *np.array_split(order, _FOLDS)]:
        try:
            _held_out(fit, rows, errors)
        except ConvergenceError:
            continue
    enough = [len(kept) >= _FEWEST for kept in errors]
    sizes = [size_of(np.array(kept)) if told else 1.0 for kept, told in zip(errors, enough, strict=True)]
    counts = [len(kept) * told for kept, told in zip(errors, enough, strict=True)]
    return (sizes[0], sizes[1]), (counts[0], counts[1])


def _held_out(fit: Any, rows: npt.NDArray[np.intp], errors: tuple[list[float], list[float]]) -> None:
    """Add to `errors`, of straight and of leaning loads, those of the touches `rows`, located by the others."""
    part = fit.without(rows)
    gains = np.abs(part.gain / fit.gain)
    if not ((gains > 1 / _KNOWN) & (gains < _KNOWN)).all():
        return
    part.uncertainty.process = fit.uncertainty.process  # of all touches it is known best
    finger, origin = part.finger_found(), part.forward.origin(part.p, part.origin)
    truth = fit.positions[rows] - origin
    ratio = part.uncertainty.of_positions(truth)
    for i, friction in enumerate(_LEANING):
        found = finger.locate(fit.given[rows], friction=friction)
        sure = (found.status == Status.OK) & (found.std[..., 0] > 0)
        sure &= (friction > 0) | (fit.load[rows, 1] == 0)
        errors[i].extend((np.abs(found.position - truth) / (ratio[i] * found.std[..., 0]))[sure].tolist())


def size_of(errors: FloatArray) -> float:
    """Standard deviation of a normal distribution of which 95 % is no larger than 95 % of the `errors` (n,), |e|.

    The error of rank i of n new ones stands for the share i/(n + 1) of all: Vovk, Gammerman and Shafer, Algorithmic
    Learning in a Random World (2005), section 2. The rank nearest above 95 % is taken; of few, the largest.

    Examples
    --------
    >>> round(size_of(np.arange(1, 20) / 10), 3)  # the 19th of 19 stands for 95 %
    0.969
    """
    from scipy.special import ndtri

    n = len(errors)
    rank = min(int(np.ceil(_SHARE * (n + 1) - 1e-9)), n)
    return float(np.sort(errors)[rank - 1] / ndtri(0.5 + 0.5 * rank / (n + 1)))
