"""Angles and angles of friction that were meant in degrees."""

from __future__ import annotations

import numpy as np
import pytest

import subskin as ss

ROW = ss.Finger(ss.HalfPlane(ss.Material(young=0.4e6)), ss.SensorArray.line(5, pitch=1.5e-3, depth=2e-3, noise=1e-4))
READINGS = ROW.read(ss.LineLoad(40.0))


@pytest.mark.parametrize("make", [ss.PointLoad, lambda **load: ss.RoundHertz(half_width=1e-3, **load)])
def test_an_azimuth_in_degrees_is_refused(make):
    with pytest.raises(ss.errors.InvalidValueError, match=r"azimuth = 90: has to be <= 6\.28319 \[rad\].*deg2rad"):
        make(force=1.0, angle=0.3, azimuth=90)
    assert make(force=1.0, angle=0.3, azimuth=2 * np.pi).azimuth == pytest.approx(0.0, abs=1e-15)  # a whole turn


@pytest.mark.parametrize(
    "call",
    [
        lambda mu: ROW.locate(READINGS, friction=mu),
        lambda mu: ss.design.Touches(20.0, friction=mu),
        ss.decide.Friction.known,
        lambda mu: ss.decide.Friction.between(0.5 * mu, mu),
    ],
)
def test_an_angle_of_friction_in_degrees_is_told_from_a_coefficient(call):
    with pytest.warns(ss.errors.ValidityWarning, match=r"= 45 is a coefficient.*np\.deg2rad\(45\)"):
        call(45.0)
    call(3.0)  # without a warning, which would be an error here


def test_any_friction_at_all_is_no_degrees():
    ROW.locate(READINGS, friction=np.inf)
