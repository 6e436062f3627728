"""Sensors that died or changed are found from touches of which nothing is known, with errors that hold."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import subskin as ss

SKINS = {
    "half plane": ss.HalfPlane(ss.Material(young=0.4e6)),
    "layer": ss.Layered(ss.Layer(ss.Material(0.4e6, 0.45), 4e-3)),
    "round": ss.Round(ss.Material(0.4e6), 8e-3, 4e-3),
}


def finger(count=6, skin="half plane", **more):
    return ss.Finger(
        SKINS[skin], ss.SensorArray.line(count, pitch=1.5e-3, depth=2e-3, **{"noise": 1e-4, "offset": 0.5, **more})
    )


def changed(tip, gains):
    gain = np.array(tip.array.gain)
    for sensor, ratio in gains.items():
        gain[sensor] *= ratio
    return replace(tip, array=replace(tip.array, gain=gain))


def used(tip, count=500, seed=1, lean=0.6):
    """Ordinary use: touches all over the row, of any force, with free skin between."""
    rng = np.random.default_rng(seed)
    reach = float(np.max(tip.array.y)) + 0.5e-3
    load = ss.LineLoad(rng.uniform(5, 60, count), rng.uniform(-lean, lean, count), rng.uniform(-reach, reach, count))
    return np.concatenate([tip.read(load, rng), tip.read(ss.LineLoad(np.zeros(50)), rng)]), load


@pytest.mark.parametrize("skin", SKINS)
@pytest.mark.parametrize("gains", [{2: 0.6}, {0: 0.6}, {3: 1.3}, {1: 0.95}, {}], ids=str)
def test_a_changed_gain_is_found(skin, gains):
    tip = finger(skin=skin)
    now = changed(tip, gains)
    found = ss.calibration.sensor_health(tip, used(now)[0])
    truth = np.asarray(now.array.gain)
    assert (np.abs(found.gain_ratio - truth) < 4.5 * found.std + 1e-3).all()
    assert np.flatnonzero(found.changed).tolist() == list(gains)
    assert [h == ss.calibration.Health.WEAK for h in found.health] == list(truth < 0.9)
    assert found.touches == pytest.approx(500, abs=15)
    assert found.explained_now > 0.995
    np.testing.assert_allclose(found.finger.array.gain, truth, atol=0.01)


@pytest.mark.parametrize("value", [None, 0.5, 0.47, "noise"])
def test_a_dead_sensor_is_found_whatever_it_reads(value):
    tip = finger()
    readings, load = used(changed(tip, {3: 0.0}))
    if value == "noise":
        readings[:, 3] = np.random.default_rng(2).normal(0.5, 0.01, len(readings))
    elif value is not None:
        readings[:, 3] = value
    found = ss.calibration.sensor_health(tip, readings)
    assert [h.name for h in found.health] == ["OK"] * 3 + ["DEAD"] + ["OK"] * 2
    assert found.finger.array.gain[3] == 0
    where = found.finger.locate(readings[:500])
    ok = where.status == ss.Status.OK
    assert ok.mean() > 0.7
    score = ((where.position - load.position) / where.std[:, 0])[ok]
    assert 0.9 < score.std() < 1.15


def test_a_sensor_that_gives_no_readings_is_dead():
    tip = finger()
    readings, _ = used(tip)
    readings[:, 4] = np.nan
    found = ss.calibration.sensor_health(tip, readings)
    assert found.health[4] == ss.calibration.Health.DEAD
    assert np.isnan(found.gain_ratio[4])
    assert np.isinf(found.std[4])
    assert not found.changed.any()


def test_one_dead_and_one_weak():
    tip = finger(8)
    found = ss.calibration.sensor_health(tip, used(changed(tip, {2: 0.6, 5: 0.0}))[0])
    assert found.health[2] == ss.calibration.Health.WEAK
    assert found.health[5] == ss.calibration.Health.DEAD
    assert found.gain_ratio[2] == pytest.approx(0.6, abs=0.01)
    assert found.explained < 0.3
    assert found.explained_now > 0.99


def test_an_offset_that_has_jumped_too_is_told_from_the_gain():
    tip = finger()
    readings, _ = used(changed(tip, {3: 0.8}))
    readings[:, 3] += 2e-3
    found = ss.calibration.sensor_health(tip, readings)
    assert found.gain_ratio[3] == pytest.approx(0.8, abs=0.01)
    assert found.shift[3] == pytest.approx(2e-3, abs=3e-5)
    assert (np.delete(found.shift, 3) == 0).all()
    np.testing.assert_allclose(found.finger.array.offset, 0.5 + found.shift)


def test_many_small_changes_at_once():
    ratios = 1 + 0.03 * np.array([0, -1, 2, 0, 1, -2, 0, -1])
    tip = finger(8)
    found = ss.calibration.sensor_health(tip, used(changed(tip, dict(enumerate(ratios))), 1000)[0])
    assert (np.abs(found.gain_ratio / found.gain_ratio[0] - ratios) < 0.012).all()
    assert (found.gain_ratio[2] - 1) > 0.04


@pytest.mark.long
def test_standard_errors_are_those_of_the_scatter():
    tip = finger(noise=5e-4)
    now = changed(tip, {2: 0.8})
    scores = []
    for seed in range(25):
        found = ss.calibration.sensor_health(tip, used(now, 200, seed=seed)[0])
        scores.append((found.gain_ratio[2] - 0.8) / found.std[2])
    assert 0.65 < np.std(scores) < 1.5
    assert abs(np.mean(scores)) < 0.8


def test_wild_readings_do_not_matter():
    tip = finger()
    readings, _ = used(changed(tip, {2: 0.6}), 1000)
    rng = np.random.default_rng(0)
    wild = rng.random(readings.shape) < 0.01
    readings[wild] += rng.uniform(-0.03, 0.03, wild.sum())
    found = ss.calibration.sensor_health(tip, readings)
    assert found.gain_ratio[2] == pytest.approx(0.6, abs=0.02)
    assert np.flatnonzero(found.changed).tolist() == [2]


def test_what_is_off_now_and_then_does_not_count_for_what_it_is_off():
    """A sensor reads 40 noises too much at three touches of ten. Its mean is off by 12; mostly it is off by none."""
    tip = finger(8)
    readings, _ = used(changed(tip, {2: 0.8}), 400)
    readings[np.random.default_rng(0).random(len(readings)) < 0.3, 5] += 40e-4
    found = ss.calibration.sensor_health(tip, readings)
    assert np.abs(found.shift).max() < 1e-4
    assert found.gain_ratio == pytest.approx([1, 1, 0.8, 1, 1, 1, 1, 1], abs=0.02)
    assert found.explained_now > 0.65


def test_normal_loads_take_fewer_sensors():
    tip = finger(4)
    readings, _ = used(changed(tip, {1: 0.6}), lean=0.0)
    found = ss.calibration.sensor_health(tip, readings, friction=0)
    assert found.gain_ratio[1] == pytest.approx(0.6, abs=0.01)


def test_transducers_that_are_not_linear():
    tip = finger(transducer=ss.VolumeResistance(exact=True))
    found = ss.calibration.sensor_health(tip, used(changed(tip, {2: 0.6}))[0])
    assert found.gain_ratio[2] == pytest.approx(0.6, abs=0.01)


def test_touches_in_one_position_do_not_tell():
    """Errors are then large, and nothing is called changed but what is."""
    tip = finger()
    readings = tip.read(ss.LineLoad(np.linspace(20, 60, 300), 0.1, 1e-3), np.random.default_rng(0))
    found = ss.calibration.sensor_health(tip, readings)
    assert not found.changed.any()
    assert np.nanmax(found.std) > 0.02
    np.testing.assert_array_equal(found.finger.array.gain, 1.0)


@pytest.mark.parametrize(
    ("call", "error", "seen"),
    [
        (lambda: ss.calibration.sensor_health(finger(), np.zeros((5, 4))), ss.errors.GeometryError, "6 sensors"),
        (lambda: ss.calibration.sensor_health(finger(), np.zeros(6)), ss.errors.GeometryError, "6 sensors"),
        (lambda: ss.calibration.sensor_health(finger(3), np.zeros((5, 3))), ss.errors.ConvergenceError, "at least 4"),
        (lambda: ss.calibration.sensor_health(finger(), np.full((50, 6), 0.5)), ss.errors.ConvergenceError, "touches"),
        (
            lambda: ss.calibration.sensor_health(finger(noise=0.0), np.zeros((5, 6))),
            ss.errors.InvalidValueError,
            "noise",
        ),
    ],
)
def test_what_cannot_be_done_is_said(call, error, seen):
    with pytest.raises(error, match=seen):
        call()


def test_a_model_that_is_a_little_wrong_kills_no_sensor():
    """Sensors that work are not called dead because the finger is 2 % deeper than it is taken for."""
    skin = ss.HalfPlane(ss.Material(young=0.4e6))
    drawn, made = (
        ss.Finger(skin, ss.SensorArray.line(6, pitch=1.5e-3, depth=depth, noise=5e-5)) for depth in (2e-3, 2.04e-3)
    )
    rng = np.random.default_rng(0)
    touch = ss.LineLoad(np.full(300, 40.0), rng.uniform(-0.5, 0.5, 300), rng.uniform(-3.5e-3, 3.5e-3, 300))
    found = ss.calibration.sensor_health(drawn, made.read(touch, rng))
    assert ss.calibration.Health.DEAD not in found.health
    assert (np.abs(found.gain_ratio - 1) < 0.1).all()
