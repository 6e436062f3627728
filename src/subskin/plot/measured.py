"""The readings of one frame, beside what a load would give: the lower panel of a finger's section."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes

from .._check import FloatArray
from ..array import SensorArray
from ..contact import Contact, LineLoad
from ..estimate import Estimate
from ..finger import Finger
from .parts import unit_of, zero_line
from .style import BLACK, MM, NORMAL_95, VERMILLION

__all__ = ["draw_readings"]

_UNITS = {"": (100.0, "measured [%]"), "Pa": (1e-3, "measured [kPa]")}


def draw_readings(axes: Axes, finger: Finger, contact: Contact, estimate: Estimate | None, frame: FloatArray) -> None:
    """The frame, freed of offset and gain, against what the contact and the load found would give."""
    array = finger.array
    live, gain = array.live, np.where(array.live, array.gain, np.nan)
    measured = (frame - np.asarray(array.offset)) / gain
    half = NORMAL_95 * np.asarray(array.noise) / np.abs(gain)
    scale, label = _UNITS.get(unit_of(finger, otherwise="?"), (1.0, "measured"))

    loads: list[tuple[Contact, dict[str, Any]]] = [(contact, {"color": BLACK, "linewidth": 3.2, "alpha": 0.25})]
    if estimate is not None and np.isfinite(np.squeeze(estimate.position)):
        found = LineLoad(*(float(np.squeeze(v)) for v in (estimate.force, estimate.angle, estimate.position)))
        loads.append((found, {"color": VERMILLION, "linewidth": 1.1}))
    dense = _alike(finger, np.linspace(*axes.get_xlim(), 401) / MM)
    for load, style in loads:
        if dense is not None:
            axes.plot(MM * np.asarray(dense.array.y), scale * dense.measure(load), **style)
        else:
            at, size = MM * np.asarray(array.y)[live], scale * finger.measure(load)[live]
            axes.plot(at, size, "_", ms=10, color=style["color"], mew=style["linewidth"])
    bars: dict[str, Any] = {"ms": 4.5, "mfc": "white", "mec": BLACK, "mew": 0.9, "ecolor": BLACK, "elinewidth": 0.8}
    axes.errorbar(MM * np.asarray(array.y), scale * measured, yerr=scale * half, fmt="o", zorder=3, **bars)
    zero_line(axes)
    axes.margins(y=0.12)
    axes.set_ylabel(label)


def _alike(finger: Finger, y: FloatArray) -> Finger | None:
    """Sensors like those of the finger all along it; None where they differ from each other."""
    array = finger.array
    depth, width = np.asarray(array.depth), np.asarray(array.width)
    if np.ptp(depth) or np.ptp(width) or len(set(array.transducers)) > 1:
        return None
    return Finger(finger.skin, SensorArray(y, depth[0], array.transducers[0], width=width[0]))
