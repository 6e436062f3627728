"""The half space against reference values of 16 to 22 digits, found by routes that share nothing with the code here.

Their `g` components are engineering shears; E is 2.
"""

from __future__ import annotations

import json

import numpy as np
import pytest

import subskin as ss
from subskin.contact.local import local_transforms_of

STRESS = [f"s{c}" for c in ("xx", "yy", "zz", "xy", "xz", "yz")]
STRAIN = ["exx", "eyy", "ezz", "gxy", "gxz", "gyz"]
MOVED = ["ux", "uy", "uz"]
LOAD = np.array([1.0, 0.375, -0.25])
SIX = ("xx", "yy", "zz", "xy", "xz", "yz")
EXACT = 1e-12  # far away and on the axis, of the largest component at the point
TOLERANCE = 1e-10  # elsewhere

CASES = {
    ("12_point_forces_3d", "point"): ss.PointLoad,
    ("13_rectangular_patch", "uniform"): lambda **load: ss.Patch(half_widths=(1.0, 0.75), **load),
    ("13_rectangular_patch", "bilinear"): lambda components: ss.Patch(
        components=3 * components, half_widths=(1.0, 0.75), slopes=(0.375, -0.625, 0.25)
    ),
    ("14_hertz_circle_friction", "hertz"): lambda **load: ss.RoundHertz(half_width=1.0, **load),
    ("14_hertz_circle_friction", "punch"): lambda **load: ss.RoundPunch(half_width=1.0, **load),
    ("14_hertz_circle_friction", "cone"): lambda **load: ss.Cone(half_width=1.0, **load),
    ("14_hertz_circle_friction", "hertz_ellipse"): lambda **load: ss.EllipticHertz(half_widths=(1.0, 0.625), **load),
    ("14_hertz_circle_friction", "partial_slip"): lambda **load: ss.RoundHertz(half_width=1.0, stick=0.75, **load),
}
PARTS = {
    ("07_point_forces_3d", "normal_P"): lambda: ss.PointLoad(components=(1.0, 0.0, 0.0)),
    ("07_point_forces_3d", "tangential_Qy"): lambda: ss.PointLoad(components=(0.0, 1.0, 0.0)),
    ("08a_hertz_sphere", "normal"): lambda: ss.RoundHertz(components=(2 * np.pi / 3, 0.0, 0.0), half_width=1.0),
    ("08a_hertz_sphere", "tangential_y"): lambda: ss.RoundHertz(components=(0.0, 2 * np.pi / 3, 0.0), half_width=1.0),
}


def read(shared, name):
    return json.loads((shared / "reference" / f"{name}.json").read_text())


def check(contact, points, nu, values):
    """All that the table has at each of its points, against the field at all of them at once."""
    where = np.array([[float(p[k]) for k in "xyz"] for p in points]).T
    state = ss.HalfSpace(ss.Material(2.0, nu)).state(contact, *where)
    double = np.array([1, 1, 1, 2, 2, 2])
    seen = {
        "stress": (STRESS, [getattr(state.stress, c) for c in SIX]),
        "strain": (STRAIN, [m * getattr(state.strain, c) for m, c in zip(double, SIX, strict=True)]),
        "displacement": (MOVED, [getattr(state.displacement, c) for c in "xyz"]),
    }
    r = np.hypot(where[1], where[2])
    share = np.where((r == 0) | (np.hypot(where[0], r) > 4), EXACT, TOLERANCE)
    compared = 0
    for names, found in seen.values():
        if names[0] in values[0]:
            expected = np.array([[float(v[n]) for v in values] for n in names])
            size = np.abs(expected).max(axis=0)
            assert (np.abs(np.array(found) - expected) <= share * np.where(size > 0, size, 1e-3)).all()
            compared += len(names)
    return compared


@pytest.mark.parametrize("nu", [0.5, 0.45, 0.3125])
@pytest.mark.parametrize("case", CASES, ids=lambda case: case[1])
def test_combined_load(case, nu, shared):
    points = read(shared, case[0])["cases"][case[1]]
    values = [p[f"nu_{nu}"] for p in points]
    assert check(CASES[case](components=LOAD), points, nu, values) >= 12
    if "torsion" in values[0]:
        turned = CASES[case](components=np.zeros(3), moment=1.0)
        assert check(turned, points, nu, [v["torsion"] for v in values]) >= 9


@pytest.mark.parametrize("case", [case for case in CASES if case[1] != "partial_slip"], ids=lambda case: case[1])
def test_family_of_a_shape(case, shared):
    """W_m and its derivative along x, m = 0 ... 3, of the shape alone."""
    points = read(shared, case[0])["cases"][case[1]]
    where = np.array([[float(p[k]) for k in "xyz"] for p in points]).T
    families = local_transforms_of(CASES[case](components=np.array([1.0, 0.0, 0.0])), *where)
    r = np.hypot(where[1], where[2])
    share = np.where((r == 0) | (np.hypot(where[0], r) > 4), EXACT, TOLERANCE)
    for name, found in (("W", families.p), ("D", families.dp)):
        expected = np.array([[complex(float(re), float(im)) for re, im in p[name]] for p in points]).T
        inside = where[0] > 0  # on the surface no derivative is asked for
        off = np.abs(found - expected)[:, inside].max(axis=0)
        assert (off <= share[inside] * np.abs(expected)[:, inside].max(axis=0)).all()


@pytest.mark.parametrize("nu", [0.5, 0.3125, 0.0])
@pytest.mark.parametrize("case", PARTS, ids="-".join)
def test_each_direction(case, nu, shared):
    points = read(shared, case[0])["points"]
    assert check(PARTS[case](), points, nu, [p[f"nu_{nu}"][case[1]] for p in points]) >= 12
