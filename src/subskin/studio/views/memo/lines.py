"""Line loads: the strain beneath one (Figs. 2, 3), and its position from three readings (Fig. 6)."""

from __future__ import annotations

from typing import Any

import numpy as np

from ....memo import FIGURE_6, eq8, eq12, eq13, three_sensor
from ....memo.three_sensors import Verdict
from .figure import Figure, Number, curve, mark, panel

__all__ = ["FIGURES"]

_VERDICTS = {
    Verdict.ACCEPTED: ("presses within the cone", "good"),
    Verdict.PULLS: ("pulls", "bad"),
    Verdict.SLIPS: ("would slip", "bad"),
    Verdict.NOT_A_SOLUTION: ("is no solution", "bad"),
}


def _strain(alpha: float, depth: float) -> dict[str, Any]:
    y, lean = np.linspace(-6.0, 6.0, 361), np.deg2rad(alpha)
    curves = []
    for kind, depth_ in zip("1234", (depth, 1.5 * depth, 2 * depth, 3 * depth)):
        # the memo's y runs from the field point to the load
        strain = eq8(P=1.0, alpha=lean, x=depth_, y=-y, E=1.0)
        curves.append(curve(f"depth {depth_:.3g}", kind, y, strain))
    blind = [-depth, depth, *([-depth / np.tan(lean)] if abs(alpha) > 0.5 else [])]
    marks = [mark("reads nothing", "1", at) for at in blind if abs(at) < 6]
    told = [
        f"A sensor at the depth {depth:.3g} reads nothing at y = "
        + ", ".join(f"{at:.3g}" for at in sorted(blind))
        + "."
    ]
    return {
        "panels": [
            panel("Strain beneath the load", "position of the sensor from the load, y", "εx E / P", curves, marks=marks)
        ],
        "told": told,
    }


def _three(y: float, alpha: float, depth: float, pitch: float, error: float) -> dict[str, Any]:
    exact = eq12(P=FIGURE_6.P, alpha=np.deg2rad(alpha), y=y, x=depth, b=pitch, E=1.0)
    readings = exact * np.array([1.0, 1.0 + 0.01 * error, 1.0])
    at = np.linspace(-8.0, 8.0, 641)
    found = three_sensor(readings, [-pitch, 0.0, pitch], depth, young=1.0)
    marks, told = [], []
    for root in found.roots:
        words, kind = _VERDICTS[root.verdict]
        marks.append(mark(f"{root.position:.2f}: {words}", kind, root.position))
        told.append(f"y = {root.position:.3f}: P/E = {root.force:.3g} at {np.degrees(root.angle):.1f}°; it {words}.")
    told += [note.text for note in found.notes]
    f = eq13(readings, at, depth, pitch) / (depth**2 + at**2) ** 4
    marks += [mark("the load", "right", y, 0.0)]
    return {
        "panels": [
            panel(
                "Roots of eq. (13)",
                "position of the load, y",
                "f(y) / (x² + y²)⁴",
                [curve("f, by eq. (13)", "right", at, f)],
                marks=marks,
            )
        ],
        "told": told or ["No load explains these readings."],
    }


FIGURES = (
    Figure(
        "2",
        "Figs. 2 and 3: strain beneath a line load",
        "Lean the load: a third position appears at which a sensor reads nothing, square to the load.",
        (Number("alpha", "angle α", 30.0, -80.0, 80.0, 1.0, "°"), Number("depth", "depth d", 1.0, 0.5, 2.0, 0.05)),
        ("1 to 4", "6 to 8"),
        _strain,
    ),
    Figure(
        "6",
        "Fig. 6: a load found from three readings",
        "Each zero of f is a load that makes the same three readings. Most of them pull, or lean too far to hold.",
        (
            Number("y", "position of the load y", FIGURE_6.y, -4.0, 4.0, 0.05),
            Number("alpha", "angle α", -22.5, -80.0, 80.0, 0.5, "°"),
            Number("depth", "depth x", FIGURE_6.depth, 1.0, 5.0, 0.1),
            Number("pitch", "pitch of sensors b", FIGURE_6.pitch, 0.5, 6.0, 0.1),
            Number("error", "error of the middle reading", 0.0, -10.0, 10.0, 0.1, "%"),
        ),
        ("12", "13", "Fig. 6"),
        _three,
    ),
)
