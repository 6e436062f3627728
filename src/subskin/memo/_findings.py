"""The numbers of the errata, each computed from the memo's formulas and from what should be there instead."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TypeAlias

import numpy as np

from .._check import FloatArray
from ._symbols import over_contact
from .section2 import eq2, eq4, eq5, eq8, eq10, eq10_corrected, eq11, eq11_corrected
from .section3 import FIGURE_6, eq12, eq13
from .section6 import eq24, eq25, eq26, eq26_corrected
from .sections4_5 import (
    eq14,
    eq15,
    eq15_constant,
    eq16,
    eq17,
    eq17_corrected,
    eq18,
    eq20,
    eq20_corrected,
    eq21,
    eq21_corrected,
    eq22,
    eq22_corrected,
)
from .three_sensors import ThreeSensorSolution, Verdict, three_sensor

Numbers: TypeAlias = Mapping[str, float | str]

ALPHA = np.pi / 6
READINGS = (-0.3, -0.5, -0.2)
"""Readings of no load in particular, for what holds whatever the readings."""


def resultant() -> Numbers:
    """Force that acts on the half disc from its arc, turned round: the load, in units of P."""

    def radial(theta: FloatArray) -> FloatArray:
        return -eq2(1.0, ALPHA, 1.0, theta).sigma_r

    arc = -np.pi / 2, np.pi / 2
    return {
        "Fx": over_contact(lambda theta: radial(theta) * np.cos(theta), *arc),
        "Fy": over_contact(lambda theta: radial(theta) * np.sin(theta), *arc),
    }


def uniaxial() -> Numbers:
    """Strain (8) over strain (5) straight beneath a normal load."""
    stress = eq4(1.0, 0.0, 1.0, 0.0).sigma_x
    return {"ratio": float(eq8(1.0, 0.0, 1.0, 0.0, 1.0) / eq5(stress, 1.0))}


def resistance_plane_strain() -> Numbers:
    """R/rho at a strain of 0.1."""
    printed = eq10(1.0, 0.1)
    exact = eq10_corrected(1.0, 0.1)
    return {"ratio": float(printed.ratio), "first": float(printed.first_order), "exact": float(exact)}


def resistance_plane_stress() -> Numbers:
    """R/rho at a strain of 0.1, the lateral strains equal."""
    return {"ratio": float(eq11(1.0, 0.1, -0.05, -0.05).ratio), "exact": float(eq11_corrected(1.0, 0.1))}


def _solve(readings: tuple[float, ...], b: float) -> ThreeSensorSolution:
    return three_sensor(readings, [-b, 0.0, b], 1.0, young=1.0)


def polynomial() -> Numbers:
    """Degrees, false roots and the double root of (13), at depth 1."""
    false = [r.position for r in _solve(READINGS, 2.0).roots if r.verdict is Verdict.NOT_A_SOLUTION]
    over_middle = eq12(1.0, 0.0, 0.0, 1.0, 0.75, 1.0)
    over_middle[1] *= 1 + 1e-6
    moved = [r.position for r in _solve(tuple(over_middle.tolist()), 0.75).accepted if abs(r.position) < 0.5]
    return {
        "degree_line": _solve((-0.1, -0.2, -0.3), 0.75).degree,
        "degree_equal": _solve((-0.1, -0.1, -0.1), 0.75).degree,
        "at_zero": abs(float(eq13(READINGS, 0.0, 1.0, 1.0))),
        "false_roots": " and ".join(f"{position:+.0f}" for position in false),
        "moved": max(moved),
    }


def figure_6() -> Numbers:
    """The roots of Fig. 6's example, as a table, and its readings before rounding."""
    six = FIGURE_6
    y = [-six.pitch, 0.0, six.pitch]
    found = three_sensor([-e for e in six.printed], y, six.depth, young=1.0)
    verdicts = {Verdict.PULLS: "pulls", Verdict.SLIPS: "slips", Verdict.ACCEPTED: "**the answer**"}
    table = ["| $y$ | $P/E$ | $\\alpha$ | verdict |", "|---|---|---|---|"]
    table += [
        f"| {r.position:.5f} | {r.force:.5f} | {np.rad2deg(r.angle):.2f} degrees | {verdicts[r.verdict]} |"
        for r in found.roots
    ]
    exact = -eq12(six.P, six.alpha, six.y, six.depth, six.pitch, 1.0)
    return {"table": "\n".join(table), "exact": ", ".join(f"{e:.5f}" for e in exact)}


def punch() -> Numbers:
    """Integral of (14), in units of P."""
    return {"load": over_contact(lambda y: eq14(1.0, 1.0, y), -1.0, 1.0)}


def wedge() -> Numbers:
    """Integral of (15), in units of pi a K cot(theta/2), and the slope of a right-angled wedge."""
    theta, k = 2.8, float(eq15_constant(1.0, 0.5))
    load = over_contact(lambda y: eq15(k, theta, 1.0, y), -1.0, 1.0, near=(0.0,), closest=1e-14)
    return {"load": load / (np.pi * k / np.tan(theta / 2)), "slope": 1 / np.tan(np.pi / 4)}


def cylinder() -> Numbers:
    """Integral of (16), in units of P."""
    return {"load": over_contact(lambda y: eq16(1.0, 1.0, y), -1.0, 1.0)}


def half_width() -> Numbers:
    """(17) against Hertz: widths, greatest pressures, and the radius that the surface fits under (16)."""
    p, radius, young, nu = 1.0, 1.0, 100.0, 0.5
    printed, true = float(eq17(p, radius, young, nu)), float(eq17_corrected(p, radius, young, nu))
    fits = np.pi * young * printed**2 / (4 * p * (1 - nu**2))
    peak = eq16(p, printed, 0.0) / eq16(p, true, 0.0)
    return {"ratio": printed / true, "peak": float(peak), "radius": fits / radius}


def semi_ellipse() -> Numbers:
    """Integral of (18) in units of P, and its value at the edges in units of P / (a2 - a1)."""
    return {
        "load": over_contact(lambda y: eq18(1.0, -0.5, 0.5, y), -0.5, 0.5),
        "edge": float(eq18(1.0, -0.5, 0.5, np.nextafter(0.5, 0.0))),
    }


def sliding_cylinder() -> Numbers:
    """(20) over its corrected form, beneath the centre of a contact of width 1."""

    def ratio(x: float) -> float:
        given = (1.0, x, 0.0, ALPHA, 1.0, -0.5, 0.5)
        return float(eq20(*given) / eq20_corrected(*given))

    return {"deep": ratio(1e3), "near": ratio(0.05)}


def slope() -> Numbers:
    """(21): dimension, sign, and the depth at which the true slope vanishes."""
    from scipy.optimize import brentq

    once, twice = (float(eq21(1.0, 2.0 * k, 0.3 * k, ALPHA, 1.0)) for k in (1.0, 2.0))
    right, wide = (float(eq21_corrected(1.0, k, 0.3 * k, ALPHA, 1.0)) for k in (1.0, 2.0))
    return {
        "falls": once / twice,
        "should": right / wide,
        "printed": float(eq21(1.0, 2.0, 0.1, ALPHA, 1.0)),
        "true": float(eq21_corrected(1.0, 1.0, 0.1, ALPHA, 1.0)),
        "blind": float(brentq(lambda x: float(eq21_corrected(1.0, 1.0, x, ALPHA, 1.0)), 0.5, 1.0, xtol=1e-15)),
    }


def wide_contact() -> Numbers:
    """(22) against the limit of (21) and, made a slope by a factor a, against the true limit."""
    width = 2.0
    printed = float(eq22(1.0, width, ALPHA, 1.0))
    return {
        "limit": printed / float(eq21(1.0, width, 0.0, ALPHA, 1.0)),
        "part": printed * width / float(eq22_corrected(1.0, width / 2, ALPHA, 1.0)),
    }


def spectrum() -> Numbers:
    """(25) at a negative frequency against the Fourier integral of (24)."""
    from scipy.integrate import quad

    s = -0.1
    # h is even: twice the cosine integral over the half line
    half = quad(lambda y: float(eq24(1.0, y)), 0, np.inf, weight="cos", wvar=2 * np.pi * abs(s))[0]
    return {"printed": float(eq25(s, 1.0)), "integral": 2 * half}


def density() -> Numbers:
    """The root of (26), the density of sensors, and what the printed one attenuates."""
    f = float(eq26_corrected(1e3))
    return {"f": f, "density": f / np.pi, "attenuation": float(eq26(3.2 * np.pi))}
