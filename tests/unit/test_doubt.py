"""Doubts of readings: a frame with doubts is one of a finger with so much more noise; intervals after a hold."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import subskin as ss
from subskin.errors import GeometryError, InvalidValueError

SKIN = ss.HalfPlane(ss.Material(young=0.4e6))
NOISE = 1e-3 * np.array([1, 2, 1, 1, 0.5, 1])
FINGER = ss.Finger(SKIN, ss.SensorArray.line(6, pitch=1.5e-3, depth=2e-3, noise=NOISE))


def doubted(frames, seed=0):
    """Readings of touches in and beyond the row, some lost, and their doubts, of which one sensor has most."""
    rng = np.random.default_rng(seed)
    touch = ss.LineLoad(rng.uniform(10, 60, frames), rng.uniform(-0.5, 0.5, frames), rng.uniform(-6e-3, 6e-3, frames))
    doubt = 2e-3 * rng.exponential(size=(frames, 6)) * [1, 1, 4, 1, 1, 1]
    doubt[::7] = 0.0
    readings = FINGER.read(touch, rng) + doubt * rng.standard_normal(doubt.shape)
    readings[5:6, 2] = np.nan
    return readings, doubt


def noisier(doubt):
    return replace(FINGER, array=replace(FINGER.array, noise=np.hypot(NOISE, doubt)))


@pytest.mark.parametrize(
    "options",
    [
        {},
        {"friction": 0.0},
        {"friction": np.inf},
        {"search": (-6e-3, 6e-3)},
        {"normal_force": (5.0, 40.0)},
        {"outliers": 1},
        {"family": "hertz"},
        {"family": "point"},
    ],
    ids=str,
)
def test_a_frame_with_doubts_is_one_of_a_finger_with_so_much_more_noise(options):
    readings, doubt = doubted(14)
    found = FINGER.locator(**options)(readings, doubt)
    plain = FINGER.locator(**options)(readings)
    moved = 0
    for k in range(len(readings)):
        one = noisier(doubt[k]).locator(**options)(readings[k])
        assert found.status[k] == one.status
        np.testing.assert_allclose(found.position[k], one.position, atol=2e-8)
        np.testing.assert_allclose(found.std[k], one.std, rtol=2e-2 if "family" in options else 1e-3)
        np.testing.assert_allclose(found.residual[k], one.residual, rtol=1e-4, atol=1e-6)
        moved += np.isfinite(one.position) and abs(plain.position[k] - one.position) > 1e-6
    assert moved > 2
    np.testing.assert_array_equal(found.table[::7], plain.table[::7])


def test_frames_by_themselves_give_the_same_bits():
    readings, doubt = doubted(40)
    locator = FINGER.locator()
    whole = locator(readings, doubt)
    for k in (0, 1, 5, 39):
        np.testing.assert_array_equal(locator(readings[k], doubt[k]).table, whole.table[k])
    parts = [locator(readings[part], doubt[part]).table for part in (slice(0, 13), slice(13, 40))]
    np.testing.assert_array_equal(np.concatenate(parts), whole.table)


def test_either_takes_doubts_and_a_large_one_leaves_nothing():
    readings, doubt = doubted(6)
    found = FINGER.locate(readings, load="either", doubt=doubt)
    np.testing.assert_array_equal(found.line.table, FINGER.locate(readings, doubt=doubt).table)
    lost = FINGER.locate(readings, doubt=np.full(readings.shape, 10.0)).status
    assert (lost[np.arange(6) != 5] == ss.Status.NO_CONTACT).all()


def test_what_is_no_doubt_is_refused():
    readings, doubt = doubted(3)
    with pytest.raises(GeometryError, match="one of each reading"):
        FINGER.locate(readings, doubt=doubt[0])
    with pytest.raises(InvalidValueError, match=">= 0"):
        FINGER.locate(readings, doubt=-doubt)
    with pytest.raises(InvalidValueError, match="StickLocator"):
        FINGER.locator("hertz", stick=0.5)(readings, doubt)
    pad = ss.Finger(ss.HalfSpace(ss.Material(young=0.4e6)), ss.SensorArray.grid((2, 3), 2e-3, 2e-3, noise=1e-4))
    with pytest.raises(InvalidValueError, match="on an area"):
        pad.locate(readings, doubt=doubt)
