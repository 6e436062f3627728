"""Truth against estimate: where the touches were, where they were found, and by how much the two differ."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt
from matplotlib.axes import Axes
from matplotlib.collections import PolyCollection
from matplotlib.colors import LogNorm
from matplotlib.figure import Figure

from .. import _check
from .._check import FloatArray
from ..errors import GeometryError
from ..estimate import Estimate, Status
from .parts import legend, zero_line
from .style import BLACK, BLUE, DASHED, GREY, MM, NORMAL_95, ORANGE, PINK, SINGLE, SKY, VERMILLION, finished, new_figure

__all__ = ["truth_against_estimate"]

MANY = 2000
"""More frames than this are drawn as a density, and their odd ones thinned to this number."""


class _Look(NamedTuple):
    marker: str
    colour: str
    name: str


LOOKS = {
    Status.OK: _Look("o", BLUE, "ok"),
    Status.AMBIGUOUS: _Look("D", ORANGE, "ambiguous"),
    Status.NO_CONTACT: _Look("P", GREY, "no contact"),
    Status.UNEXPLAINED: _Look("X", VERMILLION, "unexplained"),
    Status.INCOMPLETE: _Look("s", PINK, "incomplete"),
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
        raise GeometryError(
            f"shapes {seen}",
            "one estimate for each true position, and at least one, is needed",
            "a true position for each frame",
        )
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
    axes.axline((0.0, 0.0), slope=1.0, color=BLACK, linewidth=0.6, zorder=0.9)
    lost = frames.where(~np.isfinite(frames.found))
    if lost.truth.size:
        ticks = lost.thinned().truth
        edge: dict[str, Any] = {"transform": axes.get_xaxis_transform(), "label": f"no position ({lost.truth.size})"}
        axes.plot(ticks, np.full(ticks.size, 0.012), "|", color=BLACK, ms=6, mew=0.6, **edge)
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
            axes.plot(position, low, color=BLACK, linewidth=0.7, zorder=2.4, label="95 % of errors")
            axes.plot(position, high, color=BLACK, linewidth=0.7, zorder=2.4)
        else:
            look = {"color": SKY, "alpha": 0.3, "linewidth": 0, "zorder": 0.4, "label": "95 % of errors"}
            axes.fill_between(position, low, high, **look)
        axes.plot(position, middle, color=BLACK, linewidth=0.9, linestyle=DASHED, zorder=2.5, label="median error")
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
    error = good.error
    rms = np.sqrt(np.mean(error**2))
    text = f"{good.truth.size} ok: |error| median {np.median(np.abs(error)):.3g} mm, rms {rms:.3g} mm"
    parts = []
    spread = np.sum((good.truth - good.truth.mean()) ** 2)
    if spread > 0:
        parts.append(f"$R^2$ = {1 - np.sum(error**2) / spread:.4f}")
    if np.isfinite(good.half).all():
        parts.append(f"{100 * np.mean(np.abs(error) <= good.half):.1f} % within their 95 % interval")
    return "\n".join([text, ", ".join(parts)] if parts else [text])
