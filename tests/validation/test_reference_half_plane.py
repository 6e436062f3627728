"""The half plane against reference values of 22 digits, found by routes that share nothing with the closed forms.

The files keep the memo's angle, which drags towards -y: `angle` = -alpha here. Their `g_xy` is the engineering shear.
"""

from __future__ import annotations

import json

import numpy as np
import pytest

import subskin as ss

TOLERANCE = 1e-10  # of the largest component at the point


def profile(angle):
    weights = np.array([0.0, 1.0])  # 0.5 + 0.5 s on [-1, 1]
    return ss.PressureProfile([-1.0, 1.0], np.cos(angle) * weights, np.sin(angle) * weights)


CASES = {
    "01_line_load": lambda angle: ss.LineLoad(1, angle),
    "02_uniform_strip": lambda angle: ss.Strip(2, angle, half_width=1),
    "03a_linear_strip_ramp": profile,
    "04a_flat_punch": lambda angle: ss.FlatPunch(1, angle, half_width=1),
    "05a_hertz": lambda angle: ss.Hertz(1, angle, half_width=1),
    "06_wedge": lambda angle: ss.Wedge(np.pi, angle, half_width=1),
}


@pytest.fixture(scope="module", params=CASES)
def case(request, shared):
    data = json.loads((shared / "reference" / f"{request.param}.json").read_text())
    points = data["points"]
    assert len(points) >= 20
    x, y = (np.array([float(p[k]) for p in points]) for k in ("x", "y"))
    return CASES[request.param], data["parameters"], points, x, y


def check(seen, expected):
    """Arrays of shape (components, points)."""
    seen, expected = np.array(seen), np.array(expected, dtype=float)
    assert (np.abs(seen - expected) <= TOLERANCE * np.abs(expected).max(axis=0)).all()


@pytest.mark.parametrize(("suffix", "drag"), [("_n", 0), ("_t", 1), ("", None)])
def test_stress(case, suffix, drag):
    build, parameters, points, x, y = case
    angle = -parameters["alpha"] if drag is None else drag * np.pi / 2
    s = ss.HalfPlane(ss.Material(parameters["E"], 0.5)).stress(build(angle), x, y)
    expected = [[float(p[f"{name}{suffix}"]) for p in points] for name in ("sx", "sy", "txy")]
    check([s.xx, s.yy, s.xy], expected)


@pytest.mark.parametrize(
    ("plane", "nu"), [("strain", 0.5), ("strain", 0.3125), ("strain", 0), ("stress", 0.5), ("stress", 0.3125)]
)
def test_strain(case, plane, nu):
    build, parameters, points, x, y = case
    key = f"plane_{plane}_nu_{nu}"
    state = ss.HalfPlane(ss.Material(parameters["E"], nu), plane=plane).state(build(-parameters["alpha"]), x, y)
    e = state.strain
    expected = [[float(p["strains"][key][name]) for p in points] for name in ("ex", "ey", "gxy")]
    check([e.xx, e.yy, e.gamma_xy], expected)
    if plane == "strain":
        out_of_plane, name, scale = state.stress.zz, "sz", [state.stress.xx, state.stress.yy]
    else:
        out_of_plane, name, scale = e.zz, "ez", [e.xx, e.yy]
    values = np.array([float(p["strains"][key][name]) for p in points])
    assert (np.abs(out_of_plane - values) <= TOLERANCE * np.abs(scale).max(axis=0)).all()


def test_slope_beneath_a_sliding_hertz_contact(shared):
    """The correct form of the memo's eqs. (20) to (22); the slope by differences of the eighth order."""
    data = json.loads((shared / "reference" / "05b_hertz_centre_slope.json").read_text())
    p = data["parameters"]
    skin = ss.HalfPlane(ss.Material(p["E"], p["nu"]))
    touch = ss.Hertz(p["P"], -p["alpha"], half_width=p["a"])
    weights = np.array([1 / 280, -4 / 105, 1 / 5, -4 / 5, 0, 4 / 5, -1 / 5, 4 / 105, -1 / 280])
    for point in data["points"]:
        x = float(point["x"])
        h = min(x, 1.0) / 64 if x > 1e-3 else 1 / 64  # at the surface the field is as smooth as the pressure
        seen = skin.strain(touch, x, h * np.arange(-4, 5)).xx
        centre, slope = float(point["eps_x_at_centre"]), float(point["slope_deps_x_dy_at_centre"])
        np.testing.assert_allclose(seen[4], centre, rtol=1e-10)
        np.testing.assert_allclose(weights @ seen / h, slope, rtol=1e-8, atol=1e-9)
