"""A stream with drift: what was read, the offset that was followed, and when the skin was free."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Patch

from .. import _check
from .._check import FloatArray
from ..errors import GeometryError, InvalidValueError
from .style import BLACK, BLUE, DOUBLE, VERMILLION, finished, new_figure

if TYPE_CHECKING:
    from ..stream import Tared

__all__ = ["drift_figure"]

_FREE = "#E3F1EA"


@finished
def drift_figure(
    readings: npt.ArrayLike,
    time: npt.ArrayLike,
    tared: Tared,
    *,
    sensor: int = 0,
    truth: npt.ArrayLike | None = None,
    unit: str = "",
) -> Figure:
    """One sensor's readings and its offset as `Tare` followed it; below, the offset alone, enlarged.

    Parameters
    ----------
    readings : array_like, shape (m, n)
        The stream as it came [units of the transducers].
    time : array_like, shape (m,)
        Time of each frame [s].
    tared : Tared
        What `Tare` made of it.
    sensor : int, optional
        Which sensor, from 0.
    truth : array_like, shape (m,), optional
        The sensor's true offset, where known [unit of its transducer].
    unit : str, optional
        Unit of a reading, for the axes.

    Raises
    ------
    GeometryError
        Shapes that do not match.
    InvalidValueError
        A sensor that is not there.

    Examples
    --------
    >>> import numpy as np, subskin as ss
    >>> skin = ss.HalfPlane(ss.Material(young=0.4e6))
    >>> finger = ss.Finger(skin, ss.SensorArray.line(count=4, pitch=2e-3, depth=2e-3, noise=1e-4))
    >>> time = np.arange(0.0, 10.0, 0.01)
    >>> raw = finger.read(ss.LineLoad(40.0 * (time > 5.0)), np.random.default_rng(0))
    >>> figure = drift_figure(raw, time, ss.Tare(finger)(raw, time))
    >>> [axes.get_ylabel() for axes in figure.axes]
    ['reading', 'offset']
    """
    data = _check.real("readings", _check.readings(readings), finite=False)
    clock = _check.real("time", time, unit="s")
    if data.ndim != 2 or tared.offset.shape != data.shape or clock.shape != data.shape[:1] or not clock.size:
        raise GeometryError(
            f"readings of shape {data.shape}, time {clock.shape}, offsets {tared.offset.shape}",
            "a stream of at least a frame and what Tare made of it are needed",
            "drift_figure(readings, time, tare(readings, time))",
        )
    if not 0 <= sensor < data.shape[1]:
        raise InvalidValueError(f"sensor = {sensor}", f"the stream has sensors 0 to {data.shape[1] - 1}", "sensor=0")
    true = None if truth is None else _check.real("truth", truth)
    if true is not None and true.shape != clock.shape:
        raise GeometryError(
            f"truth of shape {true.shape}", f"one for each of the {clock.size} frames", "leave out truth"
        )
    followed = tared.offset[:, sensor]
    figure = new_figure(DOUBLE, 84.0)
    panels = figure.subplots(2, 1, sharex=True, height_ratios=(1.0, 1.0))
    panels[0].plot(clock, data[:, sensor], color=BLUE, lw=0.6, label="read")
    for axes in panels:
        _shade(axes, clock, tared.free)
        axes.plot(clock, followed, color=VERMILLION, lw=1.2, label="offset, followed", zorder=3)
        if true is not None:
            axes.plot(clock, true, color=BLACK, lw=0.8, ls=(0, (3, 2)), label="offset, true", zorder=4)
    seen = np.concatenate([followed[np.isfinite(followed)], np.empty(0) if true is None else true])
    if seen.size and np.ptp(seen) > 0:
        margin = 0.15 * float(np.ptp(seen))
        panels[1].set_ylim(float(seen.min()) - margin, float(seen.max()) + margin)
    of = f" [{unit}]" if unit else ""
    panels[0].set(ylabel=f"reading{of}", xlim=(clock[0], clock[-1] if clock[-1] > clock[0] else clock[0] + 1))
    panels[1].set(ylabel=f"offset{of}", xlabel="time [s]")
    panels[0].set_title(f"sensor {sensor}", fontweight="normal")
    handles, _ = panels[0].get_legend_handles_labels()
    handles.append(Patch(facecolor=_FREE, label="taken for free of contact"))
    figure.legend(handles=handles, loc="outside lower center", ncols=len(handles))
    return figure


def _shade(axes: Axes, clock: FloatArray, free: npt.NDArray[np.bool_]) -> None:
    """A band over each stretch of free skin."""
    edges = np.diff(np.concatenate([[0], free.astype(np.int8), [0]]))
    ends = np.append(clock, clock[-1])
    for a, b in zip(clock[edges[:-1] == 1], ends[edges == -1], strict=True):
        axes.axvspan(float(a), float(b), color=_FREE, lw=0, zorder=0)
