"""Touches on an area from above: where they were found, and where they were."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt
from matplotlib.collections import EllipseCollection, LineCollection
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from .. import _check
from .._check import FloatArray
from ..errors import GeometryError
from ..estimate import Status
from .parts import legend
from .style import BLACK, GREY, MM, SINGLE, SKY, finished, new_figure
from .truth import LOOKS, MANY

__all__ = ["truth_above"]

_SHOWN = 0.06
"""Share of the picture's width that an error is drawn long, in the median."""
_ROUND = (1, 2, 5)
_WIDEST = 0.25
"""Share of the picture's width that is kept free at most beyond a position for its ellipse."""
_95 = 5.991464547107979
"""Chi-square of two unknowns that holds 95 %."""


@finished
def truth_above(
    found: npt.ArrayLike,
    truth: npt.ArrayLike | None = None,
    *,
    status: npt.ArrayLike | None = None,
    covariance: npt.ArrayLike | None = None,
    sensors: npt.ArrayLike | None = None,
    title: str = "",
) -> Figure:
    """Positions found on an area, from above; with the true ones, the errors as lines, drawn larger than they are.

    Each touch has the marker of its status; those without a position are counted below. Where a covariance is known, an
    ellipse about an OK one, as much larger, holds the truth in 95 % of cases. The numbers above are those of the frames
    that are OK.

    Parameters
    ----------
    found : array_like, shape (m, 2)
        Found positions (y, z) [m], NaN where there is none.
    truth : array_like, shape (m, 2), optional
        True positions [m].
    status : array_like, shape (m,), optional
        Number of the `Status` of each frame; all OK where it is not given.
    covariance : array_like, shape (m, 2, 2), optional
        Of each position [m^2].
    sensors : array_like, shape (n, 2), optional
        Where the sensors are, (y, z) [m].
    title : str, optional
        Heading.

    Raises
    ------
    GeometryError
        Shapes that do not match, nothing to draw.

    Examples
    --------
    >>> figure = truth_above([(0.1e-3, 0.0), (1e-3, 1e-3)], [(0.0, 0.0), (1e-3, 1.1e-3)])
    >>> figure.axes[0].get_title(loc="left").splitlines()
    ['2 ok frames: median error 0.1 mm', '95 % within 0.1 mm']
    """
    at = MM * _check.real("found", found, unit="m", finite=False)
    true = at if truth is None else MM * _check.real("truth", truth, unit="m")
    if at.ndim != 2 or at.shape[1] != 2 or not len(at) or true.shape != at.shape:
        seen = f"found of shape {at.shape}, truth of shape {true.shape}"
        raise GeometryError(seen, "both need the shape (m, 2), with m > 0", "found.position")
    kinds = np.zeros(len(at)) if status is None else np.asarray(status)
    figure = new_figure(SINGLE, 92.0)
    axes = figure.subplots()
    points = None if sensors is None else MM * _check.real("sensors", sensors, unit="m")
    if points is not None:
        axes.plot(*points.T, "s", color=GREY, ms=5, mew=0, alpha=0.35, zorder=0.5, label="sensor")
    known = np.asarray(np.isfinite(at).all(axis=1))
    scale = 1.0
    if truth is not None:
        scale = _larger(true, at, known)
        ends = true + scale * (at - true)
        lines = np.stack([true[known], ends[known]], axis=1)
        axes.add_collection(LineCollection(list(lines), colors=BLACK, linewidths=0.5, zorder=1.5))
        axes.plot(*true.T, "+", color=BLACK, ms=3.5, mew=0.6, zorder=1.6, label="true position")
        at = ends
    doubt = np.zeros_like(at)
    if covariance is not None and len(at) <= MANY // 10:
        good = known & (kinds == Status.OK)
        _ellipses(axes, at[good], np.asarray(covariance)[good], scale)
        square = np.asarray(covariance)[:, [0, 1], [0, 1]]
        doubt[good] = scale * MM * np.sqrt(_95 * np.where(np.isfinite(square), square, 0.0))[good]
    for kind in Status:
        chosen = (kinds == kind) & known
        if chosen.any():
            look = LOOKS[kind]
            style: dict[str, Any] = {"color": look.colour, "ms": 3.0, "mew": 0, "zorder": 2}
            axes.plot(*at[chosen].T, look.marker, label=f"found, {look.name} ({chosen.sum()})", **style)
    if not known.all():
        count = int((~known).sum())
        axes.plot([], [], " ", label=f"{count} frame{'s' * (count > 1)} without a position")
    every = np.concatenate([at[known], *([] if truth is None else [true]), *([] if points is None else [points])])
    if not len(every):
        raise GeometryError("no frame has a position", "there is nothing to draw", "found[found.ok]")
    doubt = np.minimum(doubt, _WIDEST * np.ptp(every, axis=0).max())[known]
    every = np.concatenate([every, at[known] - doubt, at[known] + doubt])
    low, high = every.min(axis=0), every.max(axis=0)
    room = 0.06 * max(float((high - low).max()), 1e-3)
    axes.set(xlabel="$y$ [mm]", ylabel="$z$ [mm]")
    axes.xaxis.set_major_locator(MaxNLocator(6, steps=[1, 2, 5, 10]))  # that of a narrow picture has no room for more
    axes.set(xlim=(low[0] - room, high[0] + room), ylim=(low[1] - room, high[1] + room))
    axes.set_aspect("equal")
    axes.set_title(
        _said(true, at, scale, known & (kinds == Status.OK), truth is not None), fontsize=7, fontweight="normal"
    )
    figure.suptitle(title, fontsize=8, fontweight="bold", x=0.02, ha="left")
    legend(figure, axes, ncols=2, columnspacing=1.2)
    return figure


def _larger(true: FloatArray, at: FloatArray, known: npt.NDArray[np.bool_]) -> float:
    """How much larger errors are drawn, 1, 2 or 5 times a power of ten, so that one sees them."""
    error = np.linalg.norm(at - true, axis=1)[known]
    size = float(np.median(error)) if error.size else 0.0
    width = float(np.ptp(true, axis=0).max())
    if not size > 0 or not width > 0:
        return 1.0
    wanted = _SHOWN * width / size
    steps = [step * 10.0**k for k in range(6) for step in _ROUND]
    return max([step for step in steps if step <= wanted], default=1.0)


def _ellipses(axes: Any, at: FloatArray, covariance: FloatArray, scale: float) -> None:
    """The ellipses that hold the truth in 95 % of cases, as much larger as the errors."""
    values, vectors = np.linalg.eigh(np.where(np.isfinite(covariance), covariance, 0.0))
    sizes = 2 * scale * MM * np.sqrt(_95 * np.maximum(values, 0.0))
    angles = np.degrees(np.arctan2(vectors[:, 1, 1], vectors[:, 0, 1]))
    drawn = EllipseCollection(
        sizes[:, 1], sizes[:, 0], angles, units="xy", offsets=at, offset_transform=axes.transData,
        facecolors=SKY, edgecolors="none", alpha=0.3, zorder=1.0,
    )  # fmt: skip
    axes.add_collection(drawn)
    axes.plot(
        [], [], "o", color=SKY, alpha=0.3, ms=6, mew=0, label="95 % ellipse"
    )  # a collection has no key of its own


def _said(true: FloatArray, at: FloatArray, scale: float, good: npt.NDArray[np.bool_], known: bool) -> str:
    if not known:
        return f"{int(good.sum())} ok frames of {len(at)}"
    if not good.any():
        return "no frame is ok"
    error = np.linalg.norm(at - true, axis=1)[good] / scale
    larger = f"\nerrors are drawn {scale:g} times as large" if scale > 1 else ""
    within = f"95 % within {np.quantile(error, 0.95):.2g} mm"
    return f"{int(good.sum())} ok frames: median error {np.median(error):.2g} mm\n{within}{larger}"
