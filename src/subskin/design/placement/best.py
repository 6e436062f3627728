"""The best row of a study under constraints, and how far each choice could be missed."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from ... import _check
from ..._check import FloatArray
from ...errors import InvalidValueError
from ...finger import Finger
from ...transducer import Transducer
from .study import PlacementStudy

__all__ = ["BestRow", "best_row"]


@dataclass(frozen=True, eq=False)
class BestRow:
    """The best row of a study.

    Attributes
    ----------
    finger : Finger
        The row, in the study's skin.
    index : (int, int, int, int)
        Its kind, depth, pitch and count in the study's arrays.
    measure : str
        What it is best at.
    values : dict of str to float
        All its `PLACEMENT_MEASURES`.
    transducer : Transducer
    depth, pitch : float
        [m].
    count : int
    kinds : tuple of Transducer
        Those with a row that is nearly as good.
    depths, pitches : (float, float)
        [m]. Ranges about the best one in which there are admissible rows nearly as good: of the depth whatever the
        pitch, the kind and the count staying; of the pitch with all else staying.
    counts : (int, int)
        The same of the count, whatever depth and pitch.
    """

    finger: Finger
    index: tuple[int, int, int, int]
    measure: str
    values: dict[str, float]
    transducer: Transducer
    depth: float
    pitch: float
    count: int
    kinds: tuple[Transducer, ...]
    depths: tuple[float, float]
    pitches: tuple[float, float]
    counts: tuple[int, int]


def best_row(
    study: PlacementStudy,
    measure: str = "position_worst",
    *,
    limits: Mapping[str, float] | None = None,
    depths: tuple[float, float] | None = None,
    pitches: tuple[float, float] | None = None,
    counts: tuple[int, int] | None = None,
    lengths: tuple[float, float] | None = None,
    within: float = 0.1,
) -> BestRow:
    """The row with the least of one measure, or the largest `log_det`, among those that keep within limits.

    Parameters
    ----------
    study : PlacementStudy
        The rows.
    measure : str, optional
        One of `PLACEMENT_MEASURES`.
    limits : mapping of str to float, optional
        Largest admissible value of any measures; {"ambiguous": 0.01, "unfelt": 0.01} if left out.
    depths, pitches, lengths : (float, float), optional
        Least and largest depth, pitch, and distance of the first sensor from the last [m].
    counts : (int, int), optional
        Least and largest number of sensors.
    within : float, optional
        A row is nearly as good where its measure is larger by this share at most (`log_det`: smaller by this number).

    Returns
    -------
    BestRow
        The best row. Of rows that are equally good, the one of fewest sensors.

    Raises
    ------
    InvalidValueError
        No row keeps within the limits; an unknown measure.

    Examples
    --------
    >>> import numpy as np, subskin as ss
    >>> skin = ss.HalfPlane(ss.Material(young=0.4e6))
    >>> study = ss.design.placement_study(
    ...     skin, ss.NormalStrain(), 2e-3, 2e-3 * np.linspace(0.3, 2.0, 18), [4, 8],
    ...     ss.design.Touches(force=40.0), noise=5e-5, samples=1000,
    ... )
    >>> best = ss.design.best_row(study, lengths=(5e-3, 20e-3))
    >>> best.count, round(best.pitch * 1e3, 2)
    (8, 0.8)
    """
    values = study[measure]
    within = _check.scalar("within", within, at_least=0.0)
    good = _admissible(study, limits, depths, pitches, counts, lengths)
    rank = np.where(good & np.isfinite(values), -values if measure == "log_det" else values, np.inf)
    if not np.isfinite(rank).any():
        raise InvalidValueError(
            f"none of {rank.size} rows",
            "keeps within all limits" + _nearest(study, limits),
            "more sensors, less noise, or wider limits",
        )
    least = float(rank.min())
    at = np.argwhere(rank == least)
    k, d, s, c = (int(i) for i in at[np.argmin(at[:, 3])])
    near: npt.NDArray[np.bool_] = rank <= (least + within if measure == "log_det" else least * (1 + within))
    spread = {
        "depths": _run(study.depth, np.any(near[k, :, :, c], axis=1), d),
        "pitches": _run(study.pitch[d], near[k, d, :, c], s),
    }
    number = _run(study.count, np.any(near[k], axis=(0, 1)), c)
    return BestRow(
        finger=study.finger((k, d, s, c)),
        index=(k, d, s, c),
        measure=measure,
        values={name: float(array[k, d, s, c]) for name, array in study.values.items()},
        transducer=study.transducers[k],
        depth=float(study.depth[d]),
        pitch=float(study.pitch[d, s]),
        count=int(study.count[c]),
        kinds=tuple(study.transducers[int(i)] for i in np.flatnonzero(near.any(axis=(1, 2, 3)))),
        counts=(int(number[0]), int(number[1])),
        **spread,
    )


_LIMITS = {"ambiguous": 0.01, "unfelt": 0.01}


def _admissible(
    study: PlacementStudy,
    limits: Mapping[str, float] | None,
    depths: tuple[float, float] | None,
    pitches: tuple[float, float] | None,
    counts: tuple[int, int] | None,
    lengths: tuple[float, float] | None,
) -> npt.NDArray[np.bool_]:
    depth = study.depth[:, None, None]
    pitch, count = study.pitch[:, :, None], study.count.astype(np.float64)
    good = np.ones(study["wrong"].shape, dtype=np.bool_)
    for name, most in (_LIMITS if limits is None else limits).items():
        good &= study[name] <= most  # NaN, a row that does not fit, is not
    ranges = {
        "depths": (depth, depths),
        "pitches": (pitch, pitches),
        "counts": (count, counts),
        "lengths": (pitch * (count - 1), lengths),
    }
    for name, (quantity, bounds) in ranges.items():
        ends = _check.ends(name, bounds, f"{name}=(least, largest)")
        if ends is not None:
            slack = 1e-9 * abs(ends[1])
            good &= (quantity >= ends[0] - slack) & (quantity <= ends[1] + slack)
    return good


def _nearest(study: PlacementStudy, limits: Mapping[str, float] | None) -> str:
    said = []
    for name in _LIMITS if limits is None else limits:
        known = study[name][np.isfinite(study[name])]
        if known.size:
            said.append(f"least {name} of all: {known.min():.3g}")
    return f" ({', '.join(said)})" if said else ""


def _run(axis: npt.NDArray[np.float64 | np.int_], near: npt.NDArray[np.bool_], at: int) -> tuple[float, float]:
    """Ends of the values about the one `at` for which `near` holds without a gap, in the order of size."""
    order = np.argsort(axis, kind="stable")
    member, here = near[order], int(np.flatnonzero(order == at)[0])
    low = high = here
    while low > 0 and member[low - 1]:
        low -= 1
    while high < member.size - 1 and member[high + 1]:
        high += 1
    values: FloatArray = np.asarray(axis, dtype=np.float64)[order]
    return float(values[low]), float(values[high])
