"""Taring: offsets are followed while the skin is free and never under a touch, however a stream is cut."""

from __future__ import annotations

import pickle
from dataclasses import replace
from time import process_time

import numpy as np
import pytest

import subskin as ss

SKIN = ss.HalfPlane(ss.Material(young=0.4e6))
NOISE = 1e-4
RATE = 100.0


def finger(count=6, **more):
    return ss.Finger(
        SKIN, ss.SensorArray.line(count, pitch=1.5e-3, depth=2e-3, **{"noise": NOISE, "offset": 0.3, **more})
    )


def clock(seconds, rate=RATE):
    return np.arange(round(seconds * rate)) / rate


def presses(time, period=10.0, start=4.0, stop=9.0, force=40.0):
    """Force of touches with ramps of a quarter of a second, which begin and end in each period."""
    phase = time % period
    return force * np.clip(4 * np.minimum(phase - start, stop - phase), 0, 1)


def stream(tip, time, force, drift=0.0, seed=0, angle=0.2):
    rng = np.random.default_rng(seed)
    load = ss.LineLoad(force, np.full(time.size, angle), 1.5e-3 * np.sin(time / 7))
    return tip.read(load, rng) + drift


@pytest.fixture(scope="module")
def drifting():
    """Two minutes with twelve touches, drift of 12 % of the full scale, known."""
    tip, time = finger(), clock(120)
    force = presses(time)
    slopes = np.random.default_rng(3).normal(size=6)
    drift = 2.8e-3 * np.sin(2 * np.pi * time / 240)[:, None] * slopes / np.abs(slopes).max()
    return tip, time, force, drift, stream(tip, time, force, drift)


def test_offsets_are_followed_and_touches_are_not(drifting):
    tip, time, force, drift, raw = drifting
    fastest = np.abs(np.diff(drift, axis=0)).max() * RATE
    found = ss.Tare(tip, drift=fastest)(raw, time)
    assert not found.free[force > 2.0].any()
    settled = (force == 0) & (time % 10 < 4) & (time % 10 > 1)
    assert found.free[settled].all()
    away = found.offset - 0.3 - drift
    assert np.abs(drift).max() > 25 * NOISE
    assert np.sqrt((away[settled] ** 2).mean()) < 0.35 * NOISE
    # under a touch the offset stands still, and is off by what has drifted since it began
    assert np.abs(away).max() < 5 * fastest + 2 * NOISE
    held = force == 40.0
    assert (np.diff(found.offset, axis=0)[held[1:] & held[:-1]] == 0).all()


def test_drift_taken_off_is_not_seen_by_locate(drifting):
    tip, time, force, _, raw = drifting
    pressed = force == 40.0
    truth = 1.5e-3 * np.sin(time / 7)
    without = tip.locate(raw[pressed])
    tared = ss.Tare(tip, drift=2e-4)(raw, time)
    found = tip.locate(tared.readings[pressed])
    assert (without.status == ss.Status.OK).mean() < 0.5
    assert (found.status == ss.Status.OK).mean() > 0.97
    error = found.position - truth[pressed]
    assert np.sqrt(np.nanmean(error**2)) < 0.02e-3


def test_a_steady_touch_is_never_tared():
    """Ten minutes, no more than eight noises on the strongest sensor, while six of drift would be believed."""
    tip, time = finger(), clock(600, rate=20.0)
    force = np.where(time > 5.0, 1.2, 0.0)
    raw = tip.read(ss.LineLoad(force, 0.2, 0.0), np.random.default_rng(0))
    assert np.abs(tip.read(ss.LineLoad(1.2, 0.2, 0.0)) - 0.3).max() < 7.5 * NOISE
    found = ss.Tare(tip, drift=0.01 * NOISE)(raw, time)
    assert not found.free[time > 6.0].any()
    np.testing.assert_allclose(found.offset[-1], 0.3, atol=NOISE)


def test_two_fingers_that_rest_are_not_tared_although_no_load_explains_them():
    tip, time = finger(), clock(60)
    rng = np.random.default_rng(0)
    two = tip.read(ss.LineLoad(40.0, 0.1, -2.5e-3)) + tip.read(ss.LineLoad(40.0, 0.1, 2.5e-3)) - 0.3
    raw = np.where(time[:, None] > 5.0, two, 0.3) + NOISE * rng.standard_normal((time.size, 6))
    assert tip.locate(two).status == ss.Status.UNEXPLAINED
    found = ss.Tare(tip, drift=0.01 * NOISE)(raw, time)
    assert not found.free[time > 5.1].any()


@pytest.mark.parametrize("size", [40.0, -40.0])
def test_a_step_of_one_sensor_is_taken_up(size):
    tip, time = finger(), clock(30)
    raw = stream(tip, time, np.zeros(time.size))
    raw[time > 10.0, 2] += size * NOISE
    found = ss.Tare(tip, drift=0.05 * NOISE)(raw, time)
    assert not found.free[(time > 10.2) & (time < 12.5)].any()
    assert found.free[time > 18.0].all()
    assert abs(found.offset[-1, 2] - 0.3 - size * NOISE) < NOISE


def test_a_step_within_the_noise_is_taken_up_as_drift():
    tip, time = finger(), clock(30)
    raw = stream(tip, time, np.zeros(time.size))
    raw[time > 10.0] += 0.5 * NOISE * np.array([1, -1, 1, 1, -1, 1])
    found = ss.Tare(tip)(raw, time)
    assert found.free[time > 20.0].all()
    np.testing.assert_allclose(found.offset[-1] - 0.3, 0.5 * NOISE * np.array([1, -1, 1, 1, -1, 1]), atol=0.4 * NOISE)


def test_a_stream_that_began_under_a_touch_finds_its_offsets_when_let_go():
    """What is left then could only be a pull."""
    tip, time = finger(), clock(40)
    force = np.where(time < 10.0, 40.0, 0.0)
    found = ss.Tare(tip, drift=0.05 * NOISE)(stream(tip, time, force), time)
    assert found.free[time > 20.0].all()
    np.testing.assert_allclose(found.offset[-1], 0.3, atol=NOISE)


def test_offsets_known_beforehand_let_it_begin_under_a_touch():
    tip, time = finger(), clock(20)
    force = np.where(time < 10.0, 40.0, 0.0)
    found = ss.Tare(tip, known=0.1 * NOISE)(stream(tip, time, force), time)
    assert not found.free[(time > 0.1) & (time < 10.0)].any()
    assert found.free[time > 11.0].all()
    np.testing.assert_allclose(found.offset[time < 10.0], 0.3, atol=1e-15)


def test_rubber_that_comes_back_is_not_taken_for_an_offset():
    """A pull that fades: it has to stay the same to be taken up."""
    tip, time = finger(), clock(40)
    since = np.maximum(time - 10.0, 0.0)
    recoil = np.where((time > 10.0)[:, None], -0.05 * (tip.read(ss.LineLoad(40.0, 0.1, 0.0)) - 0.3), 0.0)
    raw = stream(tip, time, np.zeros(time.size)) + recoil * np.exp(-since / 4)[:, None]
    found = ss.Tare(tip, drift=0.02 * NOISE)(raw, time)
    np.testing.assert_allclose(found.offset, 0.3, atol=1.5 * NOISE)


def test_a_frozen_sensor_is_neither_followed_nor_trusted():
    tip, time = finger(), clock(60)
    force = presses(time)
    raw = stream(tip, time, force, drift=0.1 * NOISE * time[:, None])
    raw[time > 16.0, 2] = raw[np.argmax(time > 16.0), 2]  # under a touch, and stays there
    found = ss.Tare(tip)(raw, time)
    late = time > 20.0
    assert found.frozen[late, 2].all()
    assert not np.delete(found.frozen, 2, axis=1).any()
    assert np.isnan(found.readings[late, 2]).all()
    assert np.ptp(found.offset[late, 2]) == 0
    # the others go on as if it were not there
    assert found.free[(force == 0) & (time % 10 < 4) & (time % 10 > 1) & late].all()
    where = tip.locate(found.readings[(force == 40.0) & late])
    assert (where.status == ss.Status.OK).mean() > 0.95


def test_a_rounded_sensor_that_stands_still_is_not_frozen():
    tip, time = finger(resolution=5 * NOISE), clock(30)
    found = ss.Tare(tip)(tip.read(ss.LineLoad(np.zeros(time.size)), np.random.default_rng(0)), time)
    assert not found.frozen.any()
    assert found.free.all()


def test_wild_readings_neither_end_the_free_skin_nor_spoil_its_offset():
    tip, time = finger(), clock(120)
    rng = np.random.default_rng(5)
    raw = stream(tip, time, np.zeros(time.size))
    wild = rng.random(raw.shape) < 0.01
    raw[wild] += rng.choice([-1, 1], wild.sum()) * 0.02
    found = ss.Tare(tip)(raw, time)
    assert found.free.mean() > 0.9
    assert np.abs(found.offset - 0.3).max() < 2.5 * NOISE


def test_missing_saturated_and_dead_sensors_cost_only_themselves():
    tip, time = finger(gain=[1, 1, 1, 0, 1, 1], low=-5.0, high=5.0), clock(40)
    force = presses(time)
    raw = stream(tip, time, force, drift=0.1 * NOISE * time[:, None])
    whole = ss.Tare(tip)(raw, time)
    spoilt = raw.copy()
    spoilt[:, 3] = 4.0
    spoilt[500:700, 1], spoilt[700:900, 1] = np.nan, 5.0
    found = ss.Tare(tip)(spoilt, time)
    np.testing.assert_array_equal(found.readings[:, 3], 4.0)
    assert np.ptp(found.offset[550:900, 1]) == 0
    # and is known less and less, until it reads again
    stds = [ss.Tare(tip).step(None, spoilt[:k], time[:k])[0].std[1] for k in (501, 850)]
    assert stds[1] - stds[0] == pytest.approx(0.3 * NOISE * 3.49, rel=0.3)
    settled = (force == 0) & (time > 11) & (time % 10 < 4) & (time % 10 > 1)
    others = np.ix_(settled, [0, 2, 4, 5])
    np.testing.assert_allclose(found.offset[others], whole.offset[others], atol=0.3 * NOISE)
    assert found.free[settled].all()


def test_steps_of_time_may_differ():
    tip = finger()
    time = np.sort(np.random.default_rng(0).uniform(0, 60, 4000))
    drift = 0.2 * NOISE * time[:, None] * np.array([1, -1, 0.5, 1, 0, -0.5])
    found = ss.Tare(tip)(stream(tip, time, presses(time), drift), time)
    settled = (presses(time) == 0) & (time % 10 < 4) & (time % 10 > 1)
    assert np.abs((found.offset - 0.3 - drift)[settled]).max() < 2 * NOISE


def test_a_hundred_thousand_frames_take_well_under_a_second():
    tip, time = finger(), clock(1000)
    raw = stream(tip, time, presses(time))
    tare = ss.Tare(tip)
    tare(raw[:100], time[:100])
    begin = process_time()
    tare(raw, time)
    assert process_time() - begin < 0.5


def test_without_a_linear_transducer_there_is_still_drift_to_follow():
    tip, time = finger(transducer=ss.EnergyDensity(), noise=1e-3), clock(20)
    rng = np.random.default_rng(0)
    raw = 0.3 + 1e-3 * rng.standard_normal((time.size, 6)) + 1e-4 * time[:, None]
    raw[time > 10, 2] += 1.0
    found = ss.Tare(tip)(raw, time)
    assert not found.free[time > 10.2].any()


@pytest.mark.parametrize("dead", [(), (2,)])
def test_offsets_that_are_far_from_the_free_skin_s_are_said(dead):
    """As those of a finger that was calibrated on differences; a sensor that is dead says nothing of it."""
    tip, time = finger(gain=[0.0 if i in dead else 1.0 for i in range(6)]), clock(3)
    raw = stream(tip, time, np.zeros(time.size))
    assert ss.Tare(tip)(raw, time).doubts == ()
    away = ss.Tare(replace(tip, array=replace(tip.array, offset=0.1)))
    (said,) = away(raw, time).doubts
    assert "reads 0.3" in said
    assert "offset is 0.1" in said
    assert away(raw[:0], time[:0]).doubts == ()
    one = ss.Tare(replace(tip, array=replace(tip.array, offset=[0.3, *[0.1] * 5])))
    assert one(raw, time).doubts == ()  # one that is right speaks for the rest


@pytest.mark.parametrize(
    ("call", "error", "seen"),
    [
        (lambda: ss.Tare(finger(noise=0.0)), ss.errors.InvalidValueError, "noise = 0 of sensor 0"),
        (lambda: ss.Tare(finger(), drift=[1, 2]), ss.errors.GeometryError, "drift of shape"),
        (lambda: ss.Tare(finger(), guard=0.0), ss.errors.InvalidValueError, "guard"),
        (lambda: ss.Tare(finger(), known=np.nan), ss.errors.InvalidValueError, "known"),
        (lambda: ss.Tare(finger(), drift=-1.0), ss.errors.InvalidValueError, "drift"),
        (lambda: ss.Tare(finger())(np.zeros((3, 5)), [0, 1, 2]), ss.errors.GeometryError, "6 sensors"),
        (lambda: ss.Tare(finger())(np.zeros((3, 6)), [0, 1]), ss.errors.GeometryError, "time of shape"),
        (lambda: ss.Tare(finger())(np.zeros((3, 6)), [0, 2, 1]), ss.errors.InvalidValueError, "go back"),
        (lambda: ss.Tare(finger())(np.zeros((2, 6)), [0, np.nan]), ss.errors.InvalidValueError, "finite"),
    ],
)
def test_what_cannot_be_done_is_said(call, error, seen):
    with pytest.raises(error, match=seen):
        call()


def test_a_state_of_another_finger_or_a_later_time_is_refused():
    left, _ = ss.Tare(finger()).step(None, np.zeros((2, 6)), [0.0, 1.0])
    with pytest.raises(ss.errors.GeometryError, match="state"):
        ss.Tare(finger(4)).step(left, np.zeros((1, 4)), [2.0])
    with pytest.raises(ss.errors.InvalidValueError, match="go back"):
        ss.Tare(finger()).step(left, np.zeros((1, 6)), [0.5])
    with pytest.raises(ValueError, match="read-only"):
        left.offset[0] = 1.0


def test_inputs_are_left_alone():
    raw, time = np.zeros((5, 6)), np.arange(5.0)
    kept = raw.copy()
    found = ss.Tare(finger())(raw, time)
    np.testing.assert_array_equal(raw, kept)
    assert replace(found).readings is found.readings


def test_a_held_touch_costs_no_stall_once_the_tare_is_prepared(monkeypatch):
    """The wider table is made by `prepare`: no question of a stream waits for one."""
    tip, time = finger(), clock(12)
    tare = ss.Tare(tip, drift=0.05 * NOISE)
    tare.prepare()
    made = []
    real = ss.response.Response.from_function
    monkeypatch.setattr(ss.response.Response, "from_function", lambda *a, **k: made.append(1) or real(*a, **k))
    raw = tip.read(ss.LineLoad(np.where(time > 2.0, 40.0, 0.0), 0.2, 0.0), np.random.default_rng(0))
    found = tare(raw, time)
    assert not found.free[time > 2.1].any()
    assert made == []
    fresh = ss.Tare(finger(noise=1.1 * NOISE), drift=0.05 * NOISE)
    fresh(raw, time)
    assert made


def test_on_an_area_a_held_touch_stays_one_and_a_step_of_one_sensor_is_taken_up():
    array = ss.SensorArray.grid(shape=(4, 4), pitch=3e-3, depth=3e-3, transducer=ss.MeanPressure(), noise=20.0)
    tip = ss.Finger(ss.HalfSpace(ss.Material(young=0.4e6)), array)
    time = clock(20, rate=50.0)
    touch = tip.read(ss.PointLoad(1.5, 0.3, 0.8, position=(1e-3, -2e-3)))
    raw = np.where(((time > 2.0) & (time < 10.0))[:, None], touch, 0.0)
    raw += 20.0 * np.random.default_rng(0).standard_normal(raw.shape)
    raw[time > 12.0, 5] += 800.0
    found = ss.Tare(tip, drift=1.0)(raw, time)
    assert not found.free[(time > 2.1) & (time < 10.0)].any()
    assert np.abs(found.offset[(time > 3.0) & (time < 12.0)]).max() < 20.0
    assert not found.free[(time > 12.1) & (time < 14.5)].any()
    assert found.free[time > 18.5].all()
    assert found.offset[-1, 5] == pytest.approx(800.0, abs=15.0)


def test_a_stream_that_begins_anew_keeps_its_offsets_and_a_held_touch(drifting):
    tip, time, force, _, raw = drifting
    tare = ss.Tare(tip, drift=2e-4)
    held = int(np.flatnonzero(force == 40.0)[50])
    state, _ = tare.step(None, raw[:held], time[:held])
    again = tare.resumed(state)
    np.testing.assert_array_equal(again.offset, state.offset)
    np.testing.assert_array_equal(again.std, state.std)
    _, found = tare.step(again, raw[held : held + 100], time[:100])  # its clock began again
    assert not found.free.any()
    np.testing.assert_array_equal(found.offset, np.broadcast_to(state.offset, found.offset.shape))
    assert tare.resumed(None) is None


def test_zero_now_is_the_mean_of_the_last_quarter_of_a_second():
    tip, time = finger(), clock(6)
    tare = ss.Tare(tip)
    raw = tip.read(ss.LineLoad(np.where(time > 3.0, 40.0, 0.0), 0.2, 0.0), np.random.default_rng(0))
    state, found = tare.step(None, raw, time)
    assert not found.free[-1]
    zeroed = tare.zeroed(state)
    np.testing.assert_allclose(zeroed.offset, raw[-26:].mean(axis=0), atol=0.6 * NOISE)
    np.testing.assert_allclose(zeroed.std, NOISE / np.sqrt(26), rtol=0.03)
    _, after = tare.step(zeroed, raw[-50:], time[-50:] + 0.5)
    assert after.free.all()
    np.testing.assert_allclose(after.readings, 0.3, atol=6 * NOISE)


def test_a_state_can_be_gone_on_with_twice_and_copied(drifting):
    """Frames are kept in arrays that states share: what comes behind one state is not what comes behind another."""
    tip, time, _, _, raw = drifting
    tare, state = ss.Tare(tip), None
    at_once, made = tare.step(None, raw[:900], time[:900])
    for k in range(0, 600, 7):
        state, _ = tare.step(state, raw[k : k + 7], time[k : k + 7])
    at = slice(k + 7, 900)
    before, copied = state.frames.copy(), pickle.loads(pickle.dumps(state))
    other, _ = tare.step(state, raw[at] + 0.5, time[at])  # in the room behind the state
    np.testing.assert_array_equal(state.frames, before)
    for begun in (state, copied):
        left, out = tare.step(begun, raw[at], time[at])
        np.testing.assert_array_equal(out.readings, made.readings[at])
        np.testing.assert_array_equal(left.frames, at_once.frames)
    assert other.frames[-1, 0] == pytest.approx(raw[899, 0] + 0.5, abs=0.01)
    with pytest.raises(ValueError, match="read-only"):
        state.frames[0] = 0.0
