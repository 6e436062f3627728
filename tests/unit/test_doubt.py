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
        assert np.isfinite(found.position[k]) == np.isfinite(found.std[k]).all() == np.isfinite(one.position)
        np.testing.assert_allclose(found.residual[k], one.residual, rtol=1e-4, atol=1e-6, equal_nan=False)
        if np.isfinite(one.position):
            np.testing.assert_allclose(found.position[k], one.position, atol=2e-8, equal_nan=False)
            spread = 2e-2 if "family" in options else 1e-3
            np.testing.assert_allclose(found.std[k], one.std, rtol=spread, equal_nan=False)
            moved += abs(plain.position[k] - one.position) > 1e-6
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
        FINGER.locate(readings, doubt=np.where(np.arange(6) == 5, np.nan, -1.0) * np.ones(readings.shape))
    with pytest.raises(InvalidValueError, match="real numbers"):
        FINGER.locate(readings, doubt=np.full(readings.shape, "much"))
    with pytest.raises(InvalidValueError, match="StickLocator"):
        FINGER.locator("hertz", stick=0.5)(readings, doubt)
    pad = ss.Finger(ss.HalfSpace(ss.Material(young=0.4e6)), ss.SensorArray.grid((2, 3), 2e-3, 2e-3, noise=1e-4))
    with pytest.raises(InvalidValueError, match="RoundLocator"):
        pad.locator("round_hertz", half_width=(1e-3, 1e-3))(readings, doubt)


def test_on_an_area_a_doubt_counts_as_noise_does():
    """Doubts that are alike in all frames are those of sensors with so much more noise, which the exact loop finds."""
    array, rng = ss.SensorArray.grid((4, 4), 3e-3, depth=3e-3, noise=4e-5), np.random.default_rng(0)
    pad, each = ss.Finger(ss.HalfSpace(ss.Material(young=0.4e6)), array), np.linspace(1e-5, 3e-4, 16)
    noisy = replace(pad, array=replace(array, noise=np.hypot(array.noise, each)))
    at = rng.uniform(-4e-3, 4e-3, (100, 2))
    readings = noisy.read(ss.PointLoad(force=1.0, angle=0.2, azimuth=0.4, position=at), rng)
    doubt = np.tile(each, (100, 1))
    doubt[50:] = 0.0
    found, wanted = pad.locate(readings, doubt=doubt), noisy.locate(readings)
    assert (found.status[:50] == wanted.status[:50]).mean() > 0.97
    same = np.flatnonzero(found.ok[:50] & wanted.ok[:50])
    std = wanted.std[same, :2]
    assert (np.abs(found.position - wanted.position)[same] < 0.02 * std).all()
    assert found.std[same] == pytest.approx(wanted.std[same], rel=0.1)
    np.testing.assert_array_equal(found.table[50:], pad.locate(readings[50:]).table)
    told = replace(pad, tolerances=ss.Tolerances(gain=0.02)).locate(readings, doubt=doubt)
    assert (told.std[same, 0] > 0.95 * wanted.std[same, 0]).all()


@pytest.mark.parametrize(("spread", "sure", "doubting"), [(0.5, 0.5, 1.0), (2.0, 2.0, 2.0)])
def test_misfit_that_is_alike_in_neighbours_takes_nothing_off_a_doubt(spread, sure, doubting):
    known = replace(FINGER, spread=ss.spread.Spread([0.0], straight=[spread], leaning=[spread]))
    readings = FINGER.read(ss.LineLoad(2000.0, position=[0.2e-3, 1.1e-3]))
    for doubt, expected in ((0.0, sure), (20.0, doubting)):
        wide, plain = (f.locate(readings, doubt=doubt * np.ones((2, 1)) * NOISE).std[:, 0] for f in (known, FINGER))
        np.testing.assert_allclose(wide / plain, expected, rtol=3e-3, equal_nan=False)


def held(runs, spread, rng):
    """Raw frames of `runs` presses that are held for 6 s, on rubber whose sensors forget each their own share.

    The mean shares, the force's time, the positions, and readings (m, runs, n).
    """
    share = np.array([[0.15, 0.3, 0.15, 0.05, 0.1, 0.2]])
    time = np.arange(0.0, 14.0, 0.05)
    force = 60.0 * np.clip(np.minimum(time - 2.0, 9.0 - time), 0, 1)  # falls from 8 to 9 s
    position = rng.uniform(-3e-3, 3e-3, runs)
    loads = ss.LineLoad(np.repeat(force[:, None], runs, axis=1), 0.0, np.broadcast_to(position, (time.size, runs)))
    own = np.clip(share * (1 + spread * rng.standard_normal((runs, 6))), 0.0, 0.9)
    elastic = QUIET.read(loads).reshape(time.size, -1)
    felt = ss.Relaxation(own.reshape(1, -1), [3.0], rest=0.0).apply(elastic, time)
    felt = felt.reshape(time.size, runs, 6) + 1e-4 * rng.standard_normal((time.size, runs, 6))
    return share, time, position, felt


QUIET = replace(FINGER, array=replace(FINGER.array, noise=1e-4))


def test_intervals_hold_in_the_fall_of_a_press_that_was_held():
    """Shares that are off by 30 %: stated, the intervals hold in the hold and in the fall; not stated, they do not."""
    share, time, position, felt = held(200, 0.3, np.random.default_rng(5))
    inside = {}
    for doubt in (0.0, 0.3):
        # undone, a share that is off by e makes an error of e / (1 - share) of what is taken
        rubber = ss.Relaxation(share, [3.0], rest=0.0, doubt=doubt / (1 - share[0]))
        for part, frames in (("hold", time == time[np.searchsorted(time, 7.5)]), ("fall", np.abs(time - 8.8) < 0.01)):
            errors = []
            for run in range(len(position)):
                out = rubber.undoing(felt[:, run], time)
                found = QUIET.locate(out.readings[frames], doubt=out.doubt[frames], friction=0)
                ok = found.status == ss.Status.OK
                errors += (np.abs(found.position - position[run]) / found.std[..., 0])[ok].tolist()
            assert len(errors) > 120
            inside[doubt, part] = np.mean(np.array(errors) < 1.96)
    for part in ("hold", "fall"):
        assert inside[0.0, part] < 0.6
        assert inside[0.3, part] == pytest.approx(0.95, abs=0.05)  # 2.5 standard errors of 140
