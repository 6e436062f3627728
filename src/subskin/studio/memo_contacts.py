"""Line loads (Figs. 2, 3, 6); vertices (Fig. 9), a cylinder (11, 13), drag in proportion to pressure (12)."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..contact import FlatPunch, LineLoad, Wedge
from ..material import Material
from ..memo import (
    FIGURE_6,
    eq8,
    eq12,
    eq13,
    eq14,
    eq15,
    eq15_constant,
    eq16,
    eq17,
    eq17_corrected,
    eq18,
    eq18_corrected,
    eq20,
    eq20_corrected,
    eq21,
    eq21_corrected,
    three_sensor,
)
from ..memo.three_sensors import Verdict
from ..skin import HalfPlane
from .memo_figure import Figure, Number, curve, drawn, mark, panel

__all__ = ["FIGURES"]

_SKIN = HalfPlane(Material(young=1.0, poisson=0.5))
_ALONG = "position along the skin, y"
_EDGES = np.sin(np.linspace(-0.5, 0.5, 241)[1:-1] * np.pi)
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
    return drawn(
        told,
        panel("Strain beneath the load", "position of the sensor from the load, y", "εx E / P", curves, marks=marks),
    )


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
    return drawn(
        told or ["No load explains these readings."],
        panel(
            "Roots of eq. (13)",
            "position of the load, y",
            "f(y) / (x² + y²)⁴",
            [curve("f, by eq. (13)", "right", at, f)],
            marks=marks,
        ),
    )


def _vertices(half_width: float, depth: float, theta: float) -> dict[str, Any]:
    a, lean = half_width, np.deg2rad(theta)
    inside = a * _EDGES
    constant = float(eq15_constant(E=1.0, nu=0.5))
    wedge = eq15(K=constant, theta=lean, a=a, y=inside + 1e-9)
    load = float(np.pi * a * constant / np.tan(lean / 2))
    surface = [
        curve("flat punch, eq. (14)", "1", inside, eq14(P=load, a=a, y=inside)),
        curve("wedge, eq. (15)", "2", inside, wedge),
    ]
    y = np.linspace(-6.0, 6.0, 361)
    touches = {
        "flat punch": FlatPunch(1.0, half_width=a),
        "wedge": Wedge(1.0, half_width=a),
        "line load": LineLoad(1.0),
    }
    beneath = [
        curve(name, kind, y, _SKIN.strain(touch, x=depth, y=y).xx)
        for (name, touch), kind in zip(touches.items(), "123")
    ]
    most = 4 * load / (np.pi * a)
    ratio = max(abs(c["y"]).max() for c in beneath[:2]) / abs(beneath[2]["y"]).max()
    return drawn(
        [f"At this depth the largest strain is {ratio:.2f} of that beneath a line. Deeper, vertices show less."],
        panel("Pressure on the surface", _ALONG, "p / E", surface, low=0.0, high=most),
        panel(f"Strain at the depth {depth:.3g}", _ALONG, "εx E / P", beneath),
    )


def _cylinder(load: float, radius: float) -> dict[str, Any]:
    given: dict[str, Any] = {"P": load, "R": radius, "E": 1.0, "nu": 0.5}
    right, printed = float(eq17_corrected(**given)), float(eq17(**given))
    curves = [
        curve(
            f"eq. (16), a = {right:.3g} by (17) corrected",
            "right",
            right * _EDGES,
            eq16(P=load, a=right, y=right * _EDGES),
        ),
        curve(
            f"a = {printed:.3g} by (17) as printed",
            "printed",
            printed * _EDGES,
            eq16(P=load, a=printed, y=printed * _EDGES),
        ),
    ]
    a1, a2 = -right, right
    edges = [
        curve("eq. (18) corrected", "right", right * _EDGES, eq18_corrected(P=load, a1=a1, a2=a2, y=right * _EDGES)),
        curve("eq. (18) as printed", "printed", right * _EDGES, eq18(P=load, a1=a1, a2=a2, y=right * _EDGES)),
    ]
    return drawn(
        [f"The printed a is {printed / right:.3g} half widths; it makes {right / printed:.3g} of the true pressure."],
        panel("Pressure under a cylinder", _ALONG, "p / E", curves, low=0.0),
        panel("Pressure between two edges", _ALONG, "p / E", edges, low=0.0),
    )


def _drag(alpha: float, ripple: float) -> dict[str, Any]:
    y = np.linspace(-1.0, 1.0, 201)
    shape = np.sqrt(1 - y**2) * (1.1 + ripple * np.sin(4.5 * y) + 0.2 * y)
    p = shape / shape.max()
    curves = [curve("pressure p", "right", y, p), curve("shear q = p tan α", "2", y, np.tan(np.deg2rad(alpha)) * p)]
    return drawn(
        [f"Everywhere the drag is {abs(np.tan(np.deg2rad(alpha))):.2f} of the pressure."],
        panel("Drag in proportion to pressure", _ALONG, "traction / largest p", curves),
    )


def _dragged(alpha: float, depth: float) -> dict[str, Any]:
    # the memo's alpha drags towards -y
    y, lean = np.linspace(-5.0, 5.0, 101), -np.deg2rad(alpha)
    given: dict[str, Any] = {"P": 1.0, "x": depth, "y": -y, "alpha": -lean, "E": 1.0, "a1": -1.0, "a2": 1.0}
    strain = [
        curve("eq. (20) corrected", "right", y, eq20_corrected(**given)),
        curve("eq. (20) as printed", "printed", y, eq20(**given)),
    ]
    x = np.linspace(0.0, 4.0, 201)
    memo: dict[str, Any] = {"P": 1.0, "x": x, "alpha": lean, "E": 1.0}
    right, printed = eq21_corrected(half_width=1.0, **memo), eq21(a=2.0, **memo)
    slopes = [curve("eq. (21) corrected", "right", x, right), curve("eq. (21) as printed", "printed", x, printed)]
    here = float(eq21_corrected(P=1.0, half_width=1.0, x=depth, alpha=lean, E=1.0))
    blind = float(np.sqrt((np.sqrt(5.0) - 1.0) / 2.0))
    return drawn(
        [f"At x = {blind:.3f} a the slope is zero at every angle: a depth to keep sensors away from."],
        panel(f"Strain at the depth {depth:.3g} a", "position along the skin, y / a", "εx E a / P", strain),
        panel(
            "Slope of the strain beneath the centre",
            "depth, x / a",
            "(dεx/dy) E a² / P",
            slopes,
            marks=[mark("at this depth", "right", depth, here), mark("blind depth", "bad", blind, 0.0)],
        ),
    )


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
    Figure(
        "9",
        "Fig. 9: a flat punch and a wedge",
        "The punch presses infinitely at its edges, the wedge at its tip. Two half widths down they are alike.",
        (
            Number("half_width", "half width a", 1.0, 0.2, 2.0, 0.05),
            Number("depth", "depth x", 0.5, 0.2, 4.0, 0.05),
            Number("theta", "angle of the wedge θ", 160.0, 90.0, 175.0, 1.0, "°"),
        ),
        ("14", "15"),
        _vertices,
    ),
    Figure(
        "11",
        "Fig. 11: a cylinder",
        "Equation (17) calls the whole width the half width. Taken for it, the pressure is half of what it is.",
        (Number("load", "load P / E", 0.05, 0.005, 0.2, 0.005), Number("radius", "radius R", 4.0, 0.5, 20.0, 0.5)),
        ("16", "17", "18"),
        _cylinder,
    ),
    Figure(
        "12",
        "Fig. 12: drag in proportion to pressure",
        "The memo's contacts are dragged everywhere by the same share of the pressure.",
        (
            Number("alpha", "angle α", 25.0, -45.0, 45.0, 1.0, "°"),
            Number("ripple", "unevenness of the pressure", 0.5, 0.0, 0.8, 0.05),
        ),
        (),
        _drag,
    ),
    Figure(
        "13",
        "Fig. 13: a cylinder that is dragged",
        "Lean the load and look at the slope beneath the centre, from which the memo would tell the angle.",
        (Number("alpha", "angle α", 30.0, -45.0, 45.0, 1.0, "°"), Number("depth", "depth x", 0.4, 0.1, 4.0, 0.05, "a")),
        ("19", "20", "21", "22"),
        _dragged,
    ),
)
