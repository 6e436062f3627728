"""The figure of a pressure map: what is drawn is what was found."""

from __future__ import annotations

import numpy as np
import pytest

import subskin as ss
from subskin.plot import pressure_figure

FINGER = ss.Finger(
    ss.HalfPlane(ss.Material(young=0.4e6)), ss.SensorArray.line(count=13, pitch=1e-3, depth=2e-3, noise=2e-5)
)
ROLLER = ss.Hertz(force=40.0, angle=0.3, position=0.5e-3, half_width=2e-3)
FRAME = FINGER.read(ROLLER, np.random.default_rng(0))


def curves(axes) -> dict[str, np.ndarray]:
    return {line.get_label(): line.get_xydata() for line in axes.lines}


def test_curves_band_and_sensors_are_those_found():
    holed = FRAME.copy()
    holed[2] = np.nan
    found = ss.pressure_map(FINGER, holed)
    upper, lower = pressure_figure(found, truth=ROLLER, origin=1e-3).axes
    drawn = curves(upper)
    np.testing.assert_allclose(drawn["pressure found"][:, 0], 1e3 * (found.y + 1e-3))
    np.testing.assert_allclose(drawn["pressure found"][:, 1], found.pressure / 1e3)
    np.testing.assert_allclose(drawn["shear found"][:, 1], found.shear / 1e3)
    np.testing.assert_allclose(
        drawn["what pressed"][:, 1].max(), 2 * 40 * np.cos(0.3) / (np.pi * 2e-3) / 1e3, rtol=1e-3
    )
    np.testing.assert_allclose(drawn["sensors"][:, 0], 1e3 * (np.delete(FINGER.array.y, 2) + 1e-3))
    np.testing.assert_allclose(drawn["not used"][:, 0], 1e3 * (FINGER.array.y[2] + 1e-3))
    band = {c.get_label(): c.get_paths()[0].vertices for c in upper.collections}["pressure, 95 %"]
    assert band[:, 1].max() == pytest.approx(found.pressure_interval.max() / 1e3)
    assert band[:, 1].min() == 0
    np.testing.assert_allclose(lower.lines[0].get_ydata(), 1e3 * found.resolution)
    (bar,) = [xy for name, xy in drawn.items() if name.startswith("resolution")]
    width = np.interp(found.centre, found.y, found.resolution)
    assert np.ptp(bar[:, 0]) == pytest.approx(1e3 * width)


def test_without_shear_there_is_none_drawn():
    plain = ss.Hertz(force=40.0, half_width=2e-3)
    found = ss.pressure_map(FINGER, FINGER.read(plain), shear="none")
    upper, _ = pressure_figure(found).axes
    assert upper.get_ylabel() == "pressure [kPa]"
    assert "shear found" not in curves(upper)


def test_what_cannot_be_drawn_is_refused():
    found = ss.pressure_map(FINGER, [FRAME, FRAME])
    with pytest.raises(ss.errors.GeometryError, match="one frame"):
        pressure_figure(found)
    with pytest.raises(ss.errors.InvalidValueError, match="NO_CONTACT"):
        pressure_figure(ss.pressure_map(FINGER, np.zeros(13)))
    two = ss.Hertz(force=[1.0, 2.0], half_width=1e-3)
    with pytest.raises(ss.errors.GeometryError, match="contacts of shape"):
        pressure_figure(ss.pressure_map(FINGER, FRAME), truth=two)
