"""The best row of a study under constraints, and how far each choice could be missed."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from ... import _check
from ...errors import InvalidValueError
from ...finger import Finger
from ...transducer import Transducer
from .._common import stretch
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
    transducer, depth, pitch, count : Transducer, float, float, int
        Lengths in [m].
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

    Of rows that are equally good it is the one of fewest sensors.

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
    _check.noun("study", study, PlacementStudy, "design.placement_study(...)")
    if limits is not None:
        _check.noun("limits", limits, Mapping, 'limits={"ambiguous": 0.01}')
    values = study[measure]
    within = _check.scalar("within", within, at_least=0.0)
    depth, pitch, count = study.depth[:, None, None], study.pitch[:, :, None], study.count.astype(np.float64)
    good = np.ones(values.shape, dtype=np.bool_)
    largest = {"ambiguous": 0.01, "unfelt": 0.01} if limits is None else limits
    for name, most in largest.items():
        good &= study[name] <= most  # NaN, a row that does not fit, is not
    for name, quantity, bounds in (
        ("depths", depth, depths), ("pitches", pitch, pitches), ("counts", count, counts),
        ("lengths", pitch * (count - 1), lengths),
    ):  # fmt: skip
        ends = _check.ends(name, bounds, f"{name}=(least, largest)")
        if ends is not None:
            slack = 1e-9 * abs(ends[1])
            good &= (quantity >= ends[0] - slack) & (quantity <= ends[1] + slack)
    rank = np.where(good & np.isfinite(values), -values if measure == "log_det" else values, np.inf)
    if not np.isfinite(rank).any():
        known = {name: study[name][np.isfinite(study[name])] for name in largest}
        said = ", ".join(f"least {name} of all: {v.min():.3g}" for name, v in known.items() if v.size)
        raise InvalidValueError(
            f"none of {rank.size} rows",
            "keeps within all limits" + (f" ({said})" if said else ""),
            "more sensors, less noise, or wider limits",
        )
    least = float(rank.min())
    at = np.argwhere(rank == least)
    k, d, s, c = (int(i) for i in at[np.argmin(at[:, 3])])
    near: npt.NDArray[np.bool_] = rank <= (least + within if measure == "log_det" else least * (1 + within))
    fewest, most_sensors = _about(study.count, np.any(near[k], axis=(0, 1)), c)
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
        depths=_about(study.depth, np.any(near[k, :, :, c], axis=1), d),
        pitches=_about(study.pitch[d], near[k, d, :, c], s),
        counts=(int(fewest), int(most_sensors)),
    )


def _about(axis: npt.NDArray[np.float64 | np.int_], near: npt.NDArray[np.bool_], at: int) -> tuple[float, float]:
    """Ends of the values about the one `at` for which `near` holds without a gap, in the order of size."""
    order = np.argsort(axis, kind="stable")
    low, high = stretch(near[order], int(np.flatnonzero(order == at)[0]))
    return float(axis[order[low]]), float(axis[order[high]])
