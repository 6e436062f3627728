"""The forward model."""

from __future__ import annotations

import copy
import pickle

import numpy as np
import pytest

import subskin as ss

E, D = 0.4e6, 2e-3
SKIN = ss.HalfPlane(ss.Material(E, 0.5))
TOUCH = ss.Hertz(40.0, 0.3, 0.8e-3, half_width=0.6e-3)


def finger(skin=SKIN, count=4, **parameters):
    return ss.Finger(skin, ss.SensorArray.line(count=count, pitch=1.5e-3, **{"depth": D, **parameters}))


def test_three_sensors_read_memo_eq_12():
    """Sensors at -b, 0, +b under a load at y: DESIGN.md's reading of eq. (12)."""
    b, y, p, alpha = 1.5e-3, 0.4e-3, 40.0, -0.35
    three = ss.Finger(SKIN, ss.SensorArray(y=[-b, 0.0, b], depth=D))
    expected = [
        -3 / (2 * np.pi * E) * p * (D * np.cos(alpha) + t * np.sin(alpha)) * (D**2 - t**2) / (D**2 + t**2) ** 2
        for t in (-b - y, -y, b - y)
    ]
    np.testing.assert_allclose(three.read(ss.LineLoad(p, alpha, y)), expected, rtol=1e-13)


def test_a_narrow_sensor_tends_to_a_point_with_the_square_of_its_width():
    widths = D * np.array([0.4, 0.2, 0.1, 0.05])
    load = ss.LineLoad(40.0)
    point = finger(count=1).read(load)[0]
    off = [abs(finger(count=1, width=w).read(load)[0] - point) for w in widths]
    assert abs(np.polyfit(np.log(widths), np.log(off), 1)[0] - 2) < 0.02


def test_receptive_field_of_exact_resistance_is_its_slope_at_rest():
    """A nonlinear sensor that can be made linear: the derivative of its reading by the load, at no load.

    At nu = 1/2 the reading is a parabola in the load, of which central differences of any width give the slope.
    """
    made = finger(transducer=ss.VolumeResistance(exact=True))
    h = 10.0
    up, down = (made.read(ss.LineLoad(h, angle, 0.4e-3)) for angle in (0.0, np.pi))
    np.testing.assert_allclose(made.receptive_field(0.4e-3)[:, 0], (up - down) / (2 * h), rtol=1e-9)


def test_batches():
    made = finger()
    many = ss.Hertz(40.0, [[0.0], [0.3]], [0.0, 1e-3, 2e-3], half_width=0.6e-3)
    readings = made.read(many)
    assert readings.shape == (2, 3, 4)
    for i, j in np.ndindex(2, 3):
        one = ss.Hertz(40.0, [0.0, 0.3][i], [0.0, 1e-3, 2e-3][j], half_width=0.6e-3)
        np.testing.assert_allclose(readings[i, j], made.read(one), rtol=1e-12, atol=1e-17)
    assert made.read(ss.LineLoad(np.zeros((0,)))).shape == (0, 4)


def test_noise_only_with_a_generator():
    made = finger(noise=1e-3)
    np.testing.assert_array_equal(made.read(TOUCH), made.read(TOUCH))
    noisy = made.read(TOUCH, np.random.default_rng(4)) - made.read(TOUCH)
    assert (noisy != 0).all()
    assert np.abs(noisy).max() < 5e-3


def test_what_is_kept_of_a_finger_does_not_travel_with_it():
    made = finger(width=0.4e-3, transducer=[ss.NormalStrain(), *2 * [ss.MeanPressure()], ss.NormalStrain()])
    fresh = len(pickle.dumps(made))
    readings = made.read(TOUCH)
    assert len(pickle.dumps(made)) == fresh
    np.testing.assert_array_equal(pickle.loads(pickle.dumps(made)).read(TOUCH), readings)
    np.testing.assert_array_equal(copy.copy(made).read(TOUCH), readings)


def test_repr_is_short():
    text = repr(finger(count=64, noise=1e-3))
    assert len(text) < 250
    assert text.splitlines()[2:] == [
        "  sensors   64 NormalStrain",
        "  position  y = -47.2 to 47.2 mm, 1.5 mm apart",
        "  depth     2 mm",
        "  noise     0.001, gain 1",
    ]


def test_a_state_is_worked_out_as_it_is_asked_for():
    state = SKIN.state(TOUCH, D, [0.0, 1e-3])
    assert state.strain is state.strain
    np.testing.assert_array_equal(SKIN.at(D, [0.0, 1e-3])(TOUCH).stress.xx, SKIN.stress(TOUCH, D, [0.0, 1e-3]).xx)
    for skin in (SKIN, ss.Layered(ss.Layer(ss.Material(E), 2 * D)), ss.Round(ss.Material(E), 4 * D, 2 * D)):
        with pytest.raises(ss.errors.GeometryError):
            skin.at(-D, 0.0)(TOUCH)


def test_range_and_resolution_reach_the_reading():
    plain = finger(gain=1e6).read(TOUCH)
    assert finger(gain=1e6, high=plain.max() / 2).read(TOUCH).max() == plain.max() / 2
    np.testing.assert_allclose(finger(gain=1e6, resolution=100.0).read(TOUCH), np.round(plain / 100) * 100)


@pytest.mark.parametrize(("skin", "array"), [("skin", ss.SensorArray(y=0, depth=1)), (SKIN, [1, 2, 3])])
def test_is_made_of_a_skin_and_an_array(skin, array):
    with pytest.raises(ss.errors.InvalidValueError, match="is needed"):
        ss.Finger(skin, array)


@pytest.mark.parametrize("bad", [np.nan, "left", [0.0, np.inf]])
def test_receptive_field_at_no_position(bad):
    with pytest.raises(ss.errors.InvalidValueError, match="position"):
        finger().receptive_field(bad)


def test_half_plane_refuses_what_it_does_not_know():
    with pytest.raises(ss.errors.InvalidValueError, match='has to be "strain" or "stress"'):
        ss.HalfPlane(ss.Material(1.0), plane="strange")
    with pytest.raises(ss.errors.InvalidValueError, match="a Material is needed"):
        ss.HalfPlane(0.4e6)
