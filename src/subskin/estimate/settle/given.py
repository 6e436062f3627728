"""What Python hands to the loop that settles: errors, tables, thresholds."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from ..._check import FloatArray


class Errors(NamedTuple):
    """Standard deviations of each sensor (n,): `still` in units of its noise, `gain` as shares, `position` [m]; and the
    shares of gain and depth that are each sensor's `own` and in `common`, as square roots. ratios (2,): how far
    Poisson's ratio may be off, in its deviations.
    """

    still: FloatArray
    gain: FloatArray
    position: FloatArray
    own: float
    common: float
    ratios: FloatArray


class Variants(NamedTuple):
    """What sensors read by the finger as drawn, and by others.

    On an area sensors (V, 4, n), table (V, rows, numbers), first (n + 1,), terms (V, terms, 5), as of `PointModel`; on
    a row table (V, cells, 5, 2, n), start and step, as of `Line`. deeper, other, sizes: which is of sensors one
    deviation deeper, which what one of Poisson's ratio changes, and the first of those by which readings change with q,
    q^2 and so on; -1 where there is none.
    """

    sensors: FloatArray
    table: FloatArray
    first: npt.NDArray[np.int64]
    terms: npt.NDArray[np.int64]
    start: float
    step: float
    deeper: int
    other: int
    sizes: int


class SettledColumns(NamedTuple):
    """Where a row of the answer has what (`Layout`)."""

    covariance: int
    residual: int
    rival: int
    rival_chi2: int
    status: int
    size: int


class Settling(NamedTuple):
    """Thresholds, as of `area.judge.Settings`.

    forces: components of a load; aside [m]: where it is not 0, the second coordinate is z^2 / aside of loads beside a
    row, and only the first tells positions apart; widest: half width at q = 1 [m]; box, beyond (2 P,): ends of the
    search, and of where a load is thought of; longest: of a step [m]; level: mean square of the errors of a frame
    without a load; share: mean square of what a load adds, of its largest reading squared, and the same with all sizes.
    """

    friction: float
    largest: float
    ambiguity: float
    apart: float
    forces: int
    aside: float
    widest: float
    box: FloatArray
    beyond: FloatArray
    longest: float
    level: float
    share: float
    share_sized: float
    columns: SettledColumns
