"""A row that is calibrated by points on it: which of both pressed is found, and what follows knows of points too."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

import subskin as ss
from subskin.calibration import orient, sensor_health

SPACE = ss.HalfSpace(ss.Material(young=0.4e6))
PITCH, DEPTH = 6e-3, 5.4e-3
GAIN = np.array([80.0, 110.0, 90.0, 100.0, 95.0])


def row(skin=SPACE, depth=DEPTH, gain=GAIN, noise=1e-4):
    kind = ss.MeanPressure()
    return ss.Finger(skin, ss.SensorArray.line(5, PITCH, depth, transducer=kind, gain=gain, noise=noise * 1e4))


def touches(tip, points, count=40, force=1.0, seed=0):
    """Positions of a motor whose zero lies 9 mm beside the finger's, and what it reads of lines, or of points."""
    rng = np.random.default_rng(seed)
    at = np.linspace(-15e-3, 15e-3, count)
    on_row = np.stack([at, np.zeros(count)], axis=-1)
    load = ss.PointLoad(force, position=on_row) if points else ss.LineLoad(100 * force, position=at)
    return tip.read(load, rng), at + 9e-3


@pytest.mark.parametrize("points", [False, True])
@pytest.mark.parametrize("skin", [SPACE, ss.Layered(ss.Layer(ss.Material(0.4e6), 15e-3))], ids=str)
def test_what_pressed_is_found_with_depth_gain_and_origin(skin, points):
    readings, at = touches(row(skin), points)
    found = ss.calibrate(row(skin, 5e-3, 1.0), readings, at, force=1.0 if points else 100.0)
    assert found.load == ("point" if points else "line")
    assert ("by points on the row" in repr(found)) == points
    by_name = {(p.name, p.sensor): p for p in found.parameters}
    depth = by_name["depth", None]
    assert abs(depth.value - (DEPTH - 5e-3)) < 4 * depth.std or abs(depth.value - DEPTH) < 4 * depth.std
    np.testing.assert_allclose(found.finger.array.gain, GAIN, rtol=2e-3)
    assert abs(found.origin - 9e-3) < 2e-5
    assert found.r2 > 0.9999
    again, at = touches(row(skin), points, seed=1)
    assert found.evaluate(again, at, force=1.0 if points else 100.0).r2 > 0.9999
    wrong = ss.calibrate(row(skin, 5e-3, 1.0), readings, at, load="line" if points else "point", accept_misfit=True)
    assert 1 - wrong.r2 > 3 * (1 - found.r2)
    located = found.finger.locate(again)
    inside = np.abs(at - found.origin) < 11e-3
    assert located.ok[inside].mean() > 0.9
    assert (located.point_probability[located.ok] > 0.5).mean() == points


def test_where_nothing_is_known_in_space_touches_are_lines():
    plane = ss.Finger(ss.HalfPlane(ss.Material(young=0.4e6)), row().array)
    readings, at = touches(row(), True)
    options = {"accept_misfit": True}
    assert ss.calibrate(plane, readings, at, **options).load == "line"
    assert ss.calibrate(plane, readings, at, load="either", **options).load == "point"
    slice_ = dataclasses.replace(plane, skin=ss.HalfPlane(ss.Material(young=0.4e6), plane="stress"))
    with pytest.raises(ss.errors.InvalidValueError, match="known in space"):
        ss.calibrate(slice_, readings, at, load="point")
    with pytest.raises(ss.errors.InvalidValueError, match='"line", "point" or "either"'):
        ss.calibrate(plane, readings, at, load="ball")
    area = ss.Finger(SPACE, ss.SensorArray.grid((2, 2), PITCH, DEPTH, noise=1e-4))
    sites = np.random.default_rng(0).uniform(-4e-3, 4e-3, (20, 2))
    frames = area.read(ss.PointLoad(1.0, position=sites))
    with pytest.raises(ss.errors.GeometryError, match="area"):
        ss.calibrate(area, frames, sites, load="line")
    assert ss.calibrate(area, frames, sites, fit=("gain", "origin")).load == "point"


def test_errors_are_measured_on_points_held_out():
    """A layer taken for a half space leaves a misfit: the spread is that of points, and its intervals hold."""
    made = row(ss.Layered(ss.Layer(ss.Material(0.4e6), 14e-3)))
    readings, at = touches(made, True, count=48)
    found = ss.calibrate(row(SPACE, 5e-3, 1.0), readings[::2], at[::2])
    assert found.load == "point"
    assert found.finger.spread is not None
    assert min(found.held_out) > 10
    located = found.finger.locate(readings[1::2])
    off = np.abs(located.position - (at[1::2] - found.origin))
    assert located.ok.mean() > 0.3
    assert (off < 1.96 * located.position_std)[located.ok].mean() > 0.88


def test_sensors_that_changed_are_found_by_points():
    tip = row()
    gain = np.array(GAIN)
    gain[2] *= 0.6
    rng = np.random.default_rng(0)
    at = np.stack([rng.uniform(-13e-3, 13e-3, 400), np.zeros(400)], axis=-1)
    drag = rng.uniform(-0.4, 0.4, 400)
    load = ss.PointLoad(components=np.stack([np.ones(400), drag, np.zeros(400)], axis=-1), position=at)
    found = sensor_health(tip, row(gain=gain).read(load, rng))
    np.testing.assert_allclose(found.gain_ratio, [1, 1, 0.6, 1, 1], atol=0.02)


def test_which_way_round_is_found_by_points():
    tip, rng = row(), np.random.default_rng(0)
    at = np.array([-11e-3, -5e-3, 2e-3])
    press = ss.PointLoad(force=1.0, position=np.stack([at, np.zeros(3)], axis=-1))
    found = orient(tip, tip.read(press, rng)[:, ::-1], at)
    assert found.sure
    assert found.order.tolist() == [4, 3, 2, 1, 0]


def test_a_point_that_is_held_is_no_drift():
    """It rests on the skin for ten minutes; no line explains it."""
    tip = dataclasses.replace(row(gain=1.0), array=dataclasses.replace(row().array, gain=1.0, noise=20.0))
    time = np.arange(0.0, 300.0, 0.05)
    press = tip.read(ss.PointLoad(components=(1.0, 0.2, 0.0), position=(1e-3, 0.0)))
    assert tip.locate(press, load="line").status == ss.Status.UNEXPLAINED
    raw = np.where(time[:, None] > 5.0, press, 0.0) + np.random.default_rng(0).normal(0, 20.0, (time.size, 5))
    found = ss.Tare(tip, drift=1.0)(raw, time)
    assert not found.free[time > 6.0].any()
    np.testing.assert_allclose(found.offset[-1], 0.0, atol=20.0)
