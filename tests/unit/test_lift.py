"""What a load adds to every sensor wherever it presses: one forward model for all that reads, fits and weighs."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import subskin as ss
from subskin.errors import GeometryError, InvalidValueError

SKIN = ss.HalfPlane(ss.Material(young=0.4e6))
SPACE = ss.HalfSpace(ss.Material(young=0.4e6))
LIFT = np.array([1e-4, 2e-4, -1e-4, 0.0, 1e-4, 3e-5])
ROW = ss.SensorArray.line(count=6, pitch=1.5e-3, depth=2e-3, noise=1e-5, gain=2.0, offset=0.3, lift=LIFT)
FINGER = ss.Finger(SKIN, ROW)
AREA = ss.SensorArray.grid(shape=(3, 4), pitch=3e-3, depth=3e-3, transducer=ss.MeanPressure(), noise=20.0)
LIFTED = replace(AREA, lift=np.random.default_rng(0).normal(0.0, 3e3, 12), gain=-1.5)


def test_a_reading_is_that_of_the_field_and_of_the_normal_force():
    touch = ss.LineLoad(force=[10.0, 40.0], angle=[0.0, 0.5], position=0.8e-3)
    plain = ss.Finger(SKIN, replace(ROW, lift=0.0)).read(touch)
    np.testing.assert_allclose(
        FINGER.read(touch) - plain, LIFT * (touch.force * np.cos(touch.angle))[:, None], atol=1e-16, equal_nan=False
    )
    fields = FINGER.receptive_field([0.0, 0.8e-3])
    np.testing.assert_allclose(
        fields @ [3.0, 4.0] + 0.3, FINGER.read(ss.LineLoad(5.0, np.arctan2(4, 3), [0.0, 0.8e-3])), equal_nan=False
    )
    loads = {"force": np.array([7.0]), "position": np.array([0.8e-3])}
    from_loads = ss.synthetic.simulate_readings(FINGER, ss.LineLoad, loads)
    np.testing.assert_allclose(from_loads[0], FINGER.read(ss.LineLoad(7.0, position=0.8e-3)), equal_nan=False)


@pytest.mark.parametrize("load", ["line", "point"])
def test_a_touch_on_a_row_is_found_exactly(load):
    finger = FINGER if load == "line" else replace(FINGER, skin=SPACE)
    touch = ss.LineLoad(40.0, 0.3, 0.8e-3) if load == "line" else ss.PointLoad(0.5, position=(0.8e-3, 1e-3))
    found = finger.locate(finger.read(touch), load=load)
    assert found.status == ss.Status.OK
    np.testing.assert_allclose(found.position, 0.8e-3, atol=1e-6, equal_nan=False)
    np.testing.assert_allclose(found.force, touch.force, rtol=1e-3, equal_nan=False)


def test_a_wide_touch_its_kind_and_its_pressure_are_found():
    roller = ss.Hertz(force=40.0, angle=0.0, position=0.4e-3, half_width=1.0e-3)
    readings = FINGER.read(roller)
    found = FINGER.fit(readings, "hertz")
    np.testing.assert_allclose([found.half_width, found.position], [1.0e-3, 0.4e-3], rtol=1e-3, equal_nan=False)
    assert ss.pressure_map(FINGER, readings).normal_force == pytest.approx(40.0, rel=0.02)
    plain = ss.Finger(SKIN, replace(ROW, lift=0.0))
    one, other = (ss.decide.contact_type(f, f.read(roller)).probability for f in (FINGER, plain))
    np.testing.assert_allclose(one, other, atol=0.05, equal_nan=False)


@pytest.mark.parametrize("transducer", [ss.MeanPressure(), ss.transducer.ShearStrain("xy"), ss.NormalStrain()])
def test_a_touch_on_an_area_is_found_exactly(transducer):
    """Of sensors whose readings under a normal force are the same all round, or are not."""
    scale = 1.0 if transducer.unit else 1e-6
    array = replace(LIFTED, transducer=transducer, noise=20.0 * scale, lift=scale * np.asarray(LIFTED.lift))
    finger = ss.Finger(SPACE, array)
    touch = ss.PointLoad(force=1.5, angle=0.3, azimuth=0.8, position=(1e-3, -2e-3))
    found = finger.locate(finger.read(touch))
    assert found.status == ss.Status.OK
    np.testing.assert_allclose(found.position, (1e-3, -2e-3), atol=1e-7, equal_nan=False)
    np.testing.assert_allclose(found.load.components, touch.components, rtol=1e-4, equal_nan=False)
    missing = np.where(np.arange(12) == 5, np.nan, finger.read(touch))
    np.testing.assert_allclose(finger.locate(missing).position, (1e-3, -2e-3), atol=1e-7, equal_nan=False)
    np.testing.assert_allclose(
        finger.receptive_field((1e-3, -2e-3)) @ touch.components, finger.read(touch), equal_nan=False
    )


def test_a_round_touch_on_an_area_and_its_pressure_are_found():
    finger = ss.Finger(SPACE, LIFTED)
    tip = ss.RoundHertz(force=1.5, angle=0.0, position=(1e-3, -2e-3), half_width=2e-3)
    found = finger.fit(finger.read(tip), "round_hertz")
    np.testing.assert_allclose([found.half_width, *found.position], [2e-3, 1e-3, -2e-3], rtol=1e-4, equal_nan=False)
    assert ss.pressure_map(finger, finger.read(tip)).normal_force == pytest.approx(1.5, rel=0.1)


def test_an_area_is_calibrated_with_it():
    """In the response in place it is a part of what a load reads, and no offset."""
    at = np.stack(np.meshgrid(np.linspace(-4e-3, 4e-3, 7), np.linspace(-5e-3, 5e-3, 7)), axis=-1).reshape(-1, 2)
    true = ss.Finger(SPACE, replace(LIFTED, gain=1.0))
    data = true.read(ss.PointLoad(2.0, position=at), np.random.default_rng(0))
    drawn = ss.Finger(SPACE, AREA)
    found = ss.calibrate(drawn, data, at, fit=("gain", "lift", "depth", "origin"), force=2.0)
    np.testing.assert_allclose(found.finger.array.lift, true.array.lift, atol=100.0, equal_nan=False)
    for force in (0.2, 2.0):
        light = found.finger.locate(true.read(ss.PointLoad(force, position=(1e-3, 2e-3))))
        np.testing.assert_allclose(found.on_finger((1e-3, 2e-3)), light.position, atol=0.2e-3, equal_nan=False)
        assert light.status == ss.Status.OK


def test_in_place_it_is_a_part_of_the_response():
    """Where the field is not that of the skin, the response in place has it in its values, and no offset."""
    at = np.stack(np.meshgrid(np.linspace(-3e-3, 3e-3, 5), np.linspace(-3e-3, 3e-3, 5)), axis=-1).reshape(-1, 2)
    layer = ss.Layered(ss.Layer(ss.Material(young=0.4e6), thickness=5e-3))
    drawn = ss.SensorArray.grid(shape=(3, 2), pitch=3e-3, depth=3e-3, transducer=ss.MeanPressure(), noise=20.0)
    true = ss.Finger(layer, replace(drawn, lift=8e3))
    fit = ("gain", "lift", "origin")
    found = ss.calibrate(ss.Finger(SPACE, drawn), true.read(ss.PointLoad(2.0, position=at)), at, fit=fit, force=2.0)
    known = found.finger.measured
    assert known is not None
    assert not known.offset.any()
    for force in (0.2, 2.0):
        light = found.finger.locate(true.read(ss.PointLoad(force, position=(1e-3, 0.5e-3))), friction=0)
        np.testing.assert_allclose(light.position, found.on_finger((1e-3, 0.5e-3)), atol=0.3e-3, equal_nan=False)
        assert light.force == pytest.approx(force, rel=0.1)


def test_what_knows_no_lift_says_so():
    with pytest.raises(InvalidValueError, match="lift"):
        ss.SensorArray.line(3, 1e-3, 2e-3, lift=1.0, transducer=ss.transducer.MaxCompressiveStrain())
    with pytest.raises(GeometryError, match="lift of shape"):
        ss.SensorArray.line(3, 1e-3, 2e-3, lift=[1.0, 2.0])
    with pytest.raises(InvalidValueError, match="sensors with a lift"):
        ss.estimate.side.side_angle(FINGER, np.zeros(6), position=0.0, half_width=1e-3)
