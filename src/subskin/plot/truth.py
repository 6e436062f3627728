"""Truth against estimate: along a row, and on an area from above."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt
from matplotlib.axes import Axes
from matplotlib.collections import EllipseCollection, LineCollection, PolyCollection
from matplotlib.colors import LogNorm
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from .. import _check
from .._check import FloatArray
from ..errors import GeometryError
from ..estimate import Estimate, Status
from .style import DASHED, MM, NORMAL_95, SINGLE, Ink, finished, legend, new_figure, zero_line

__all__ = ["truth_above", "truth_against_estimate"]

MANY = 2000
"""More frames than this are drawn as a density, and their odd ones thinned to this number."""


class _Look(NamedTuple):
    marker: str
    colour: str
    name: str


LOOKS = {
    Status.OK: _Look("o", Ink.BLUE, "ok"),
    Status.AMBIGUOUS: _Look("D", Ink.ORANGE, "ambiguous"),
    Status.NO_CONTACT: _Look("P", Ink.GREY, "no contact"),
    Status.UNEXPLAINED: _Look("X", Ink.VERMILLION, "unexplained"),
    Status.INCOMPLETE: _Look("s", Ink.PINK, "incomplete"),
}
"""How a frame of each status is drawn."""


class _Frames(NamedTuple):
    """Positions in mm; `half` is half the 95 % interval, NaN where no standard deviation is known."""

    truth: FloatArray
    found: FloatArray
    half: FloatArray
    status: npt.NDArray[np.int8]

    @property
    def error(self) -> FloatArray:
        return self.found - self.truth

    def where(self, chosen: npt.NDArray[np.bool_] | slice) -> _Frames:
        return _Frames(self.truth[chosen], self.found[chosen], self.half[chosen], self.status[chosen])

    def thinned(self) -> _Frames:
        return self.where(slice(None, None, self.truth.size // MANY + 1))


@finished
def truth_against_estimate(
    truth: npt.ArrayLike,
    estimate: npt.ArrayLike | Estimate,
    std: npt.ArrayLike | None = None,
    status: npt.ArrayLike | None = None,
    *,
    title: str = "",
) -> Figure:
    """Estimated position against the true one, and the error below it.

    Each touch is drawn with a marker for its status and, where there are at most 200, its 95 % interval;
    touches that got no position are ticks on the lower edge. Beyond 2000 frames, those that are OK become a
    density, and the median and the band run along with the position. The numbers in the figure, the median and
    the band that holds 95 % of the errors are those of the OK frames alone. An error far outside that band is
    a triangle on the lower panel's edge.

    Parameters
    ----------
    truth : array_like, shape (...)
        True positions y [m].
    estimate : array_like, shape (...), or Estimate
        Found positions y [m], NaN where there is none. An `Estimate` brings its own `std` and `status`.
    std : array_like, shape (...), optional
        Standard deviation of each position [m].
    status : array_like, shape (...), optional
        Number of the `Status` of each frame; all OK where it is not given.
    title : str, optional
        Heading.

    Raises
    ------
    InvalidValueError, GeometryError
        A truth that is not finite, a negative standard deviation, shapes that do not match, nothing to draw.

    Examples
    --------
    >>> figure = truth_against_estimate([0.0, 1e-3, 2e-3], [0.1e-3, 1e-3, 1.9e-3], std=5e-5)
    >>> [axes.get_ylabel() for axes in figure.axes]
    ['estimated position [mm]', 'error [mm]']
    """
    frames = _frames(truth, estimate, std, status)
    figure = new_figure(SINGLE, 116.0)
    upper, lower = figure.subplots(2, 1, sharex=True, height_ratios=(1.6, 1.0))
    clouds = [*_found(upper, frames), *_errors(lower, frames)]
    upper.set_title(_numbers(frames), fontsize=7, fontweight="normal", linespacing=1.4)
    figure.suptitle(title, fontsize=8, fontweight="bold", x=0.02, ha="left")
    if clouds:
        most = max(float(np.max(np.asarray(cloud.get_array()))) for cloud in clouds)
        for cloud in clouds:
            cloud.set_norm(LogNorm(1.0, max(most, 2.0)))
        figure.colorbar(clouds[0], ax=[upper, lower], label="ok frames in a cell", aspect=60, pad=0.03)
    statuses = [str(bars.get_label()) for bars in upper.containers]
    legend(figure, upper, lower, first=statuses, ncols=3, columnspacing=1.2, markerscale=1.2)
    return figure


def _frames(
    truth: npt.ArrayLike, estimate: npt.ArrayLike | Estimate, std: npt.ArrayLike | None, status: npt.ArrayLike | None
) -> _Frames:
    if isinstance(estimate, Estimate):
        std = estimate.std[..., 0] if std is None else std
        status = estimate.status if status is None else status
        estimate = estimate.position
    true = _check.real("truth", truth, unit="m")
    arrays = {
        "truth": true,
        "estimate": _check.real("estimate", estimate, unit="m", finite=False),
        "std": _check.real("std", np.nan if std is None else std, unit="m", finite=False),
        "status": _check.real("status", Status.OK if status is None else status, at_least=0, at_most=max(Status)),
    }
    if (arrays["std"] < 0).any():
        _check.real("std", np.nan_to_num(arrays["std"]), unit="m", at_least=0.0)
    if _check.broadcast(**arrays) != true.shape or not true.size:
        seen = ", ".join(f"{name} {a.shape}" for name, a in arrays.items())
        rule = "one estimate for each true position, and at least one, is needed"
        raise GeometryError(f"shapes {seen}", rule, "a true position for each frame")
    t, found, spread, kinds = (np.broadcast_to(a, true.shape).reshape(-1) for a in arrays.values())
    half = np.where(np.isfinite(spread), NORMAL_95 * spread, np.nan)
    return _Frames(t * MM, found * MM, half * MM, kinds.astype(np.int8))


def _kinds(frames: _Frames) -> Iterator[tuple[Status, _Frames]]:
    """The frames of each status that have a position, the OK ones first."""
    for kind in Status:
        chosen = frames.where((frames.status == kind) & np.isfinite(frames.found))
        if chosen.truth.size:
            yield kind, chosen


def _found(axes: Axes, frames: _Frames) -> list[PolyCollection]:
    clouds = []
    for kind, group in _kinds(frames):
        if kind == Status.OK and group.truth.size > MANY:
            clouds.append(_density(axes, group.truth, group.found))
        else:
            _points(axes, kind, group, group.found, f"{LOOKS[kind].name} ({group.truth.size})")
    axes.axline((0.0, 0.0), slope=1.0, color=Ink.BLACK, linewidth=0.6, zorder=0.9)
    lost = frames.where(~np.isfinite(frames.found))
    if lost.truth.size:
        ticks = lost.thinned().truth
        edge: dict[str, Any] = {"transform": axes.get_xaxis_transform(), "label": f"no position ({lost.truth.size})"}
        axes.plot(ticks, np.full(ticks.size, 0.012), "|", color=Ink.BLACK, ms=6, mew=0.6, **edge)
    axes.set_ylabel("estimated position [mm]")
    return clouds


def _errors(axes: Axes, frames: _Frames) -> list[PolyCollection]:
    clouds = []
    good = frames.where((frames.status == Status.OK) & np.isfinite(frames.found))
    reach = _reach(frames, good)
    for kind, group in _kinds(frames):
        inside = group.where(np.abs(group.error) <= reach)
        if kind == Status.OK and group.truth.size > MANY:
            clouds.append(_density(axes, inside.truth, inside.error))
        else:
            _points(axes, kind, inside, inside.error)
        beyond = group.where(np.abs(group.error) > reach).thinned()
        for side, marker in ((1, "^"), (-1, "v")):
            at = beyond.truth[np.sign(beyond.error) == side]
            look: dict[str, Any] = {"ms": 3.5 if at.size < 100 else 1.5, "mew": 0, "zorder": 3}
            look |= {"color": LOOKS[kind].colour, "label": "beyond the axis" if at.size else "_"}
            axes.plot(at, np.full(at.size, side * reach), marker, **look)
    zero_line(axes)
    if good.truth.size:
        position, low, middle, high = _bands(good)
        if clouds:
            axes.plot(position, low, color=Ink.BLACK, linewidth=0.7, zorder=2.4, label="95 % of errors")
            axes.plot(position, high, color=Ink.BLACK, linewidth=0.7, zorder=2.4)
        else:
            look = {"color": Ink.SKY, "alpha": 0.3, "linewidth": 0, "zorder": 0.4, "label": "95 % of errors"}
            axes.fill_between(position, low, high, **look)
        axes.plot(position, middle, color=Ink.BLACK, linewidth=0.9, linestyle=DASHED, zorder=2.5, label="median error")
    axes.set(xlabel="true position [mm]", ylabel="error [mm]", ylim=(-1.08 * reach, 1.08 * reach))
    return clouds


def _bands(frames: _Frames) -> FloatArray:
    """Positions, and the 2.5, 50 and 97.5 % quantiles of the error there: running if there are many."""
    levels = [0.025, 0.5, 0.975]
    if frames.truth.size <= MANY:
        ends = np.array([frames.truth.min(), frames.truth.max()])
        return np.vstack([ends, np.repeat(np.quantile(frames.error, levels)[:, None], 2, axis=1)])
    order = np.argsort(frames.truth, kind="stable")
    bins = np.array_split(order, min(40, frames.truth.size // 200))
    return np.array([[frames.truth[i].mean(), *np.quantile(frames.error[i], levels)] for i in bins]).T


def _reach(frames: _Frames, good: _Frames) -> float:
    """How far the error axis goes: over the OK frames and their bars, but not out to gross errors."""
    found = good if good.truth.size else frames.where(np.isfinite(frames.found))
    if not found.truth.size:
        return 1.0
    size = np.abs(found.error) + np.nan_to_num(found.half)
    half, most = np.quantile(np.abs(found.error), [0.5, 0.8])
    typical = max(10.0 * float(half), 3.0 * float(most))
    return 1.1 * min(float(size.max()), max(typical, float(np.median(size)))) or 1.0


def _points(axes: Axes, kind: Status, frames: _Frames, height: FloatArray, label: str = "_") -> None:
    look, few = LOOKS[kind], frames.truth.size <= 200
    thin, height = frames.thinned(), height[:: frames.truth.size // MANY + 1]
    bars = thin.half if few and np.isfinite(thin.half).any() else None
    style: dict[str, Any] = {"color": look.colour, "ms": 3.0 if few else 1.5, "mew": 0, "elinewidth": 0.6, "zorder": 2}
    axes.errorbar(thin.truth, height, yerr=bars, fmt=look.marker, label=label, **style)


def _density(axes: Axes, x: FloatArray, y: FloatArray) -> PolyCollection:
    return axes.hexbin(x, y, gridsize=(70, 45), mincnt=1, cmap="viridis_r", linewidths=0.1, zorder=1)


def _numbers(frames: _Frames) -> str:
    good = frames.where((frames.status == Status.OK) & np.isfinite(frames.found))
    if not good.truth.size:
        return "no frame is ok"
    error, spread = good.error, np.sum((good.truth - good.truth.mean()) ** 2)
    rms = np.sqrt(np.mean(error**2))
    text = f"{good.truth.size} ok: |error| median {np.median(np.abs(error)):.3g} mm, rms {rms:.3g} mm"
    parts = [f"$R^2$ = {1 - np.sum(error**2) / spread:.4f}"] if spread > 0 else []
    if np.isfinite(good.half).all():
        parts.append(f"{100 * np.mean(np.abs(error) <= good.half):.1f} % within their 95 % interval")
    return "\n".join([text, *filter(None, [", ".join(parts)])])


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
    outlines: npt.ArrayLike | None = None,
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
    outlines : array_like, shape (m, k, 2), optional
        Corners of what was found, (y, z) [m]; drawn where no true positions are.
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
        axes.plot(*points.T, "s", color=Ink.GREY, ms=5, mew=0, alpha=0.35, zorder=0.5, label="sensor")
    known = np.asarray(np.isfinite(at).all(axis=1))
    scale = 1.0
    if truth is not None:
        scale = _larger(true, at, known)
        ends = true + scale * (at - true)
        lines = np.stack([true[known], ends[known]], axis=1)
        axes.add_collection(LineCollection(list(lines), colors=Ink.BLACK, linewidths=0.5, zorder=1.5))
        axes.plot(*true.T, "+", color=Ink.BLACK, ms=3.5, mew=0.6, zorder=1.6, label="true position")
        at = ends
    corners = np.zeros((0, 2))
    if outlines is not None and truth is None:
        sides = MM * np.asarray(outlines)[known]
        look: dict[str, Any] = {"facecolors": "none", "edgecolors": Ink.BLACK, "linewidths": 0.6, "zorder": 1.5}
        axes.add_collection(PolyCollection(list(sides), label="outline found", **look))
        corners = sides.reshape(-1, 2)
    doubt = np.zeros_like(at)
    if covariance is not None and len(at) <= MANY // 10:
        good = known & (kinds == Status.OK)
        _ellipses(axes, at[good], np.asarray(covariance)[good], scale)
        square = np.asarray(covariance)[:, [0, 1], [0, 1]]
        doubt[good] = scale * MM * np.sqrt(_95 * np.where(np.isfinite(square), square, 0.0))[good]
    for kind in Status:
        chosen = (kinds == kind) & known
        if chosen.any():
            mark = LOOKS[kind]
            style: dict[str, Any] = {"color": mark.colour, "ms": 3.0, "mew": 0, "zorder": 2}
            axes.plot(*at[chosen].T, mark.marker, label=f"found, {mark.name} ({chosen.sum()})", **style)
    if not known.all():
        count = int((~known).sum())
        axes.plot([], [], " ", label=f"{count} frame{'s' * (count > 1)} without a position")
    every = np.concatenate([at[known], *([] if truth is None else [true]), *([] if points is None else [points])])
    if not len(every):
        raise GeometryError("no frame has a position", "there is nothing to draw", "found[found.ok]")
    doubt = np.minimum(doubt, _WIDEST * np.ptp(every, axis=0).max())[known]
    every = np.concatenate([every, corners, at[known] - doubt, at[known] + doubt])
    low, high = every.min(axis=0), every.max(axis=0)
    room = 0.06 * max(float((high - low).max()), 1e-3)
    axes.set(xlabel="$y$ [mm]", ylabel="$z$ [mm]")
    axes.xaxis.set_major_locator(MaxNLocator(6, steps=[1, 2, 5, 10]))  # that of a narrow picture has no room for more
    axes.set(xlim=(low[0] - room, high[0] + room), ylim=(low[1] - room, high[1] + room))
    axes.set_aspect("equal")
    told = _said(true, at, scale, known & (kinds == Status.OK), truth is not None)
    axes.set_title(told, fontsize=7, fontweight="normal")
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
    steps = (step * 10.0**k for k in range(6) for step in _ROUND)
    return max((step for step in steps if step <= _SHOWN * width / size), default=1.0)


def _ellipses(axes: Any, at: FloatArray, covariance: FloatArray, scale: float) -> None:
    """The ellipses that hold the truth in 95 % of cases, as much larger as the errors."""
    values, vectors = np.linalg.eigh(np.where(np.isfinite(covariance), covariance, 0.0))
    sizes = 2 * scale * MM * np.sqrt(_95 * np.maximum(values, 0.0))
    angles = np.degrees(np.arctan2(vectors[:, 1, 1], vectors[:, 0, 1]))
    drawn = EllipseCollection(
        sizes[:, 1], sizes[:, 0], angles, units="xy", offsets=at, offset_transform=axes.transData,
        facecolors=Ink.SKY, edgecolors="none", alpha=0.3, zorder=1.0,
    )  # fmt: skip
    axes.add_collection(drawn)
    # a collection has no key of its own
    axes.plot([], [], "o", color=Ink.SKY, alpha=0.3, ms=6, mew=0, label="95 % ellipse")


def _said(true: FloatArray, at: FloatArray, scale: float, good: npt.NDArray[np.bool_], known: bool) -> str:
    if not known:
        return f"{int(good.sum())} ok frames of {len(at)}"
    if not good.any():
        return "no frame is ok"
    error = np.linalg.norm(at - true, axis=1)[good] / scale
    larger = f"\nerrors are drawn {scale:g} times as large" if scale > 1 else ""
    within = f"95 % within {np.quantile(error, 0.95):.2g} mm"
    return f"{int(good.sum())} ok frames: median error {np.median(error):.2g} mm\n{within}{larger}"
