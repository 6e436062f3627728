"""Device time to host time: what the bus delays is taken off, counters that begin again are followed, resets told."""

from __future__ import annotations

import numpy as np
import pytest

from subskin.live import ClockMap

LATE = 0.15e-3
"""The least delay, which no clock at one end can tell."""


def arrivals(true, rng, busy=0.02):
    """Host times: mostly a quarter of a millisecond late, sometimes tens of milliseconds, in their order."""
    delay = LATE + rng.exponential(0.25e-3, true.size)
    slow = rng.random(true.size) < busy
    delay[slow] += rng.exponential(20e-3, slow.sum())
    return np.maximum.accumulate(true + delay)


def mapped(device, host, batch=1):
    clock, state, out = ClockMap(), None, []
    for k in range(0, device.size, batch):
        part = slice(k, k + batch)
        assert clock.breaks(state, device[part], host[part][-1]) == []
        state, time = clock.step(state, device[part], host[part][-1])
        assert (time <= host[part][-1]).all()
        out.append(time)
    time = np.concatenate(out)
    assert (np.diff(time) >= 0).all()
    return state, time


@pytest.mark.parametrize(("rate", "batch"), [(200.0, 1), (1000.0, 20)])
def test_frames_lie_where_they_were_taken_to_a_fifth_of_a_millisecond(rate, batch):
    true = np.arange(int(30 * rate)) / rate
    host = 5e5 + arrivals(true, np.random.default_rng(1))
    state, time = mapped(1234.5 + true * (1 + 37e-6), host, batch)
    error = time - 5e5 - true - LATE
    settled = true > 10.0
    assert np.abs(error[settled]).max() < 0.2e-3
    assert np.abs(host[settled] - 5e5 - true[settled]).max() > 20e-3  # the arrivals themselves are far off
    assert state.skew == pytest.approx(-37e-6, abs=8e-6)


@pytest.mark.parametrize("length", [2**32 * 1e-6, 2**32 * 1e-3, 2**16 * 1e-3])
def test_a_counter_that_begins_again_is_followed(length):
    true = np.arange(0.0, 4.0, 0.01)
    device = (length - 2.0 + true) % length
    _, time = mapped(device, 100.0 + true, batch=7)
    np.testing.assert_allclose(time - 100.0, true, atol=1e-6)


@pytest.mark.parametrize(("before", "after"), [(50.0, 0.0), (50.0, 49.0), (4000.0, 3.0), (50.0, 500.0)])
def test_a_clock_that_began_again_or_was_set_is_told(before, after):
    clock = ClockMap()
    state, _ = clock.step(None, np.array([before - 0.1, before]), 10.0)
    assert clock.breaks(state, np.array([before + 0.1, after]), 10.2) == [(1, pytest.approx(after - before - 0.1))]


def test_a_frame_that_a_network_delivered_late_is_no_reset():
    clock = ClockMap()
    state, _ = clock.step(None, np.array([5.00, 5.01, 5.02]), 10.0)
    assert clock.breaks(state, np.array([5.015, 5.03]), 10.01) == []
    _, time = clock.step(state, np.array([5.015, 5.03]), 10.01)
    assert (np.diff([10.0, *time]) >= 0).all()


def test_after_a_reset_the_time_of_the_host_goes_on():
    clock = ClockMap()
    state, first = clock.step(None, 50.0 + 0.01 * np.arange(100), 20.99)
    state, second = clock.step(state.again(), np.array([0.0, 0.01]), 21.5)
    assert second[0] >= first[-1]
    assert second[-1] == pytest.approx(21.5)


def test_a_clock_that_stood_still_is_found_again():
    """Two seconds that the device did not count: not for a minute are its frames placed two seconds early."""
    true = np.arange(0.0, 20.0, 0.01)
    host = true + np.where(true > 8.0, 2.0, 0.0)
    _, time = mapped(true, host)
    assert np.abs(time - host)[true > 14.0].max() < 1e-3


def test_without_a_clock_frames_are_spread_over_the_time_since_the_last_batch():
    clock, state = ClockMap(), None
    nothing = np.full(4, np.nan)
    for k in range(5):
        state, time = clock.step(state, nothing, 7.0 + 0.04 * k)
    np.testing.assert_allclose(time, 7.16 - np.array([0.03, 0.02, 0.01, 0.0]), atol=1e-9)
    _, late = clock.step(state, nothing, 9.0)  # after a break the frames are not spread over all of it
    assert late[0] > 8.9


def test_a_frame_without_a_time_has_that_of_the_frame_before_it():
    clock = ClockMap()
    state, _ = clock.step(None, np.array([1.0]), 5.0)
    _, time = clock.step(state, np.array([np.nan, 1.01, np.nan]), 5.02)
    assert time[0] < time[1] == time[2]
