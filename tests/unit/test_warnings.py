"""A warning points at the line of whoever called, however deep within the package it arises."""

from __future__ import annotations

import ast
import warnings
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import subskin as ss

SOFT = ss.HalfPlane(ss.Material(young=0.4e6))
ARRAY = ss.SensorArray.line(count=6, pitch=1.5e-3, depth=2e-3, noise=1e-4)


CASES = {
    "unit of a depth": lambda: ss.Finger(SOFT, ss.SensorArray.line(count=3, pitch=1.5, depth=2.0)),
    "dataclass": lambda: ss.FlatPunch(force=40.0, half_width=1e-3, moment=0.1),
    "its copy": lambda: replace(ss.FlatPunch(force=40.0, half_width=1e-3), moment=0.1),
    "wide cylinder": lambda: ss.Hertz.from_radius(force=4e4, radius=8e-3, material=SOFT.material),
    "sharp wedge": lambda: ss.Wedge.from_angle(force=4.0, vertex_angle=1.0, material=SOFT.material),
    "surface": lambda: SOFT.stress(ss.LineLoad(force=40.0), 0.0, 0.0),
    "point on a surface": lambda: ss.HalfSpace(SOFT.material).strain(ss.PointLoad(force=1.0), 0.0, 0.0, 0.0),
    "distrusted": lambda: ss.Finger(SOFT, ARRAY, trusted=False).locate(np.zeros(6)),
    "through NumPy": lambda: np.apply_along_axis(ss.Finger(SOFT, ARRAY, trusted=False).locate, 0, np.zeros(6)),
}


@pytest.mark.parametrize("case", CASES.values(), ids=CASES)
def test_a_warning_points_at_the_callers_line(case):
    with warnings.catch_warnings(record=True) as seen:
        warnings.simplefilter("always")
        case()
    assert seen
    assert {Path(warning.filename) for warning in seen} == {Path(__file__)}


def test_warnings_are_given_in_one_way():
    package = Path(ss.__file__).parent
    givers = {
        path.relative_to(package).as_posix()
        for path in package.rglob("*.py")
        for node in ast.walk(ast.parse(path.read_text()))
        if isinstance(node, ast.Attribute) and ast.unparse(node) == "warnings.warn"
    }
    assert givers == {"_check.py"}
