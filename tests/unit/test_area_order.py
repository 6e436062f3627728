"""Frames on an area go by their strongest sensor: each is in its group, and what comes out does not depend on turns."""

from __future__ import annotations

import numpy as np
import pytest

import subskin as ss
from subskin.estimate.area.scan import by_strongest


def ordered(readings, rows, strong=0.0):
    """Strongest sensors, and the order of frames."""
    (frames, n), integer = readings.shape, np.int64
    hot, order = np.full(frames, -1, dtype=integer), np.full(frames, -1, dtype=integer)
    start = np.full(n + 2, 7, dtype=integer)
    by_strongest(readings, rows, strong, hot, start, order)
    return hot, order


def test_frames_of_one_strongest_sensor_stand_together():
    rng = np.random.default_rng(0)
    readings, offset, noise = rng.normal(size=(500, 9)), rng.normal(size=9), rng.uniform(0.5, 2.0, 9)
    rows = np.stack([offset, 1 / noise, np.full(9, -1e9), np.full(9, 1e9)])
    hot, order = ordered(readings, rows)
    assert np.array_equal(hot, np.abs((readings - offset) / noise).argmax(axis=1))
    assert np.array_equal(order, np.argsort(hot, kind="stable"))


def test_weak_frames_come_last():
    readings = np.random.default_rng(2).normal(size=(200, 4))
    hot, order = ordered(readings, np.stack([np.zeros(4), np.ones(4), np.full(4, -9.0), np.full(4, 9.0)]), 1.5)
    weak = np.abs(readings).max(axis=1) < 1.5
    assert 10 < weak.sum() < 190
    assert np.array_equal(hot == 4, weak)
    assert set(order[-weak.sum() :]) == set(np.flatnonzero(weak))


@pytest.mark.parametrize("frames", [0, 1])
def test_no_frame_and_one(frames):
    hot, order = ordered(np.ones((frames, 4)), np.stack([np.zeros(4), np.ones(4), np.full(4, -9.0), np.full(4, 9.0)]))
    assert (list(hot), list(order)) == ([0] * frames, [0] * frames)


def test_a_frame_that_lacks_a_sensor_has_its_turn():
    readings = np.array([[1.0, 2.0, 3.0], [np.nan, 5.0, 1.0], [4.0, np.inf, 1.0], [np.nan] * 3])
    _, order = ordered(readings, np.stack([np.zeros(3), np.ones(3), np.full(3, -9.0), np.full(3, 9.0)]))
    assert sorted(order) == [0, 1, 2, 3]


@pytest.mark.parametrize("side", [4, 7], ids=["in lanes", "one by one"])
def test_frames_one_by_one_in_any_turn_or_at_once_give_the_same(side):
    """Neither the frames that bounds are asked of side by side nor the one that shares a tile's table count."""
    array = ss.SensorArray.grid((side, side), 2e-3, 2e-3, transducer=ss.MeanPressure(), noise=400.0)
    finger = ss.Finger(ss.HalfSpace(ss.Material(young=0.4e6)), array)
    rng = np.random.default_rng(1)
    load = ss.PointLoad(force=rng.uniform(0.2, 1.0, 60), angle=0.3, position=rng.uniform(-4e-3, 4e-3, (60, 2)))
    frames = finger.read(load, rng)
    frames[3] = 0.0  # no contact
    at_once, turns = finger.locate(frames), rng.permutation(60)
    turned, single = finger.locate(frames[turns]), [finger.locate(frame) for frame in frames]
    for name in ("table", "position", "status"):  # NumPy's own sums of a batch may differ in the last bit
        value = getattr(at_once, name)
        assert len(np.unique(value[np.isfinite(value)])) > 1
        assert np.array_equal(value[turns], getattr(turned, name), equal_nan=True)
        assert np.array_equal(value, np.stack([getattr(one, name) for one in single]), equal_nan=True)
