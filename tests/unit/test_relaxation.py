"""Relaxation: against the convolution it stands for, exactly undone, and fitted again from held touches."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import quad

import subskin as ss
from subskin.errors import GeometryError, InvalidValueError

RUBBER = ss.Relaxation([0.06, 0.1], [0.4, 6.0])


def creep(t):
    """What is left of a step after t."""
    return 1 - sum(p * (1 - np.exp(-t / tau)) for p, tau in zip(RUBBER.share, RUBBER.time))


def uneven(seconds, count, seed=0):
    return np.concatenate([[0.0], np.sort(np.random.default_rng(seed).uniform(0, seconds, count))])


def ramps(time, seed=1):
    """A piecewise-linear touch of two sensors, whose corners are among the times."""
    corners = np.concatenate([[0.0], time[5::40]])
    level = np.random.default_rng(seed).uniform(0, 2, corners.size)
    level[0] = 0.0
    return np.interp(time, corners, level)[:, None] * [1.0, -0.3]


def test_a_step_falls_as_the_series_says():
    time = uneven(30, 300)
    step = np.where(time >= time[1], 1.0, 0.0)
    # the elastic reading goes in a line between frames: a step is one in the limit
    time[0] = time[1] - 1e-9
    felt = RUBBER.apply(step[:, None], time)[:, 0]
    np.testing.assert_allclose(felt[1:], creep(time[1:] - time[1]), rtol=1e-8)


def test_it_is_the_convolution_with_the_rate_of_the_touch():
    """Stieltjes: r(t) = integral of creep(t - s) u'(s) ds, by quadrature of each linear piece."""
    time = uneven(20, 60)
    touch = ramps(time)
    felt = replace(RUBBER, rest=0.0).apply(touch, time)
    slope = np.diff(touch[:, 0]) / np.diff(time)
    for k in (7, 30, 60):
        pieces = zip(time[:k], time[1 : k + 1], slope[:k])
        expected = sum(v * quad(lambda s, k=k: creep(time[k] - s), a, b, epsabs=1e-13)[0] for a, b, v in pieces)
        assert felt[k, 0] == pytest.approx(expected, abs=1e-11)


@pytest.mark.parametrize("count", [50, 2000])
def test_undone_it_is_exact_at_any_times(count):
    time = uneven(40, count)
    touch = 5.0 + ramps(time)
    rested = replace(RUBBER, rest=5.0)
    felt = rested.apply(touch, time)
    assert np.abs(felt - touch).max() > 0.05
    np.testing.assert_allclose(rested.undo(felt, time), touch, atol=1e-12)
    np.testing.assert_allclose(RUBBER.undo(felt, time), touch, atol=1e-12)  # rests at its first reading


def test_a_missing_reading_is_bridged_and_the_other_sensors_do_not_notice():
    time = np.arange(0, 20, 0.1)
    touch = np.interp(time, [0, 2, 4, 12, 14, 20], [0, 0, 1, 1, 0, 0])[:, None] * [1.0, 2.0]
    felt = RUBBER.apply(touch, time).copy()
    whole = RUBBER.undo(felt, time)
    felt[60:80, 0] = np.nan  # held all the while: the line across the gap is what was there
    found = RUBBER.undo(felt, time)
    assert np.isnan(found[60:80, 0]).all()
    np.testing.assert_array_equal(found[:, 1], whole[:, 1])
    np.testing.assert_allclose(found[80:, 0], touch[80:, 0], atol=1e-12)


def test_frames_of_one_time_are_a_step():
    time = np.array([0.0, 1.0, 1.0, 9.0])
    felt = RUBBER.apply(np.array([[0.0], [0.0], [1.0], [1.0]]), time)[:, 0]
    np.testing.assert_allclose(felt, [0, 0, 1, creep(8.0)], rtol=1e-14)


def test_each_sensor_may_have_its_own_shares():
    time = uneven(20, 100)
    touch = ramps(time)
    both = ss.Relaxation([[0.1, 0.3]], [2.0]).apply(touch, time)
    for i, share in enumerate((0.1, 0.3)):
        one = ss.Relaxation([share], [2.0]).apply(touch[:, i : i + 1], time)
        np.testing.assert_array_equal(both[:, i], one[:, 0])


def recording(share, time_constants, noise=1e-3, seed=0, gains=(1.0, -0.4, 0.2)):
    """Eight touches of different heights, each held for 6 s, with ramps of half a second."""
    time = np.arange(0, 120, 0.02)
    phase = time % 15
    height = np.random.default_rng(7).uniform(0.5, 2, 8)[(time // 15).astype(int)]
    touch = height * np.clip(np.minimum(phase - 4, 11 - phase) * 2, 0, 1)
    felt = ss.Relaxation(share, time_constants).apply(touch[:, None] * np.array(gains), time)
    rng = np.random.default_rng(seed)
    held = np.array([[15 * k + 4.5, 15 * k + 10.5] for k in range(8)])
    return felt + noise * rng.standard_normal(felt.shape), time, held, touch[:, None] * np.array(gains)


@pytest.mark.parametrize(
    ("share", "constants"), [([0.15], [2.0]), ([0.06, 0.1], [0.4, 5.0]), ([0.05, 0.05, 0.08], [0.1, 1.0, 8.0])]
)
def test_the_series_is_found_again_and_undone(share, constants):
    raw, time, held, touch = recording(share, constants)
    found = ss.stream.fit_relaxation(raw, time, held, terms=len(share), rest=0.0)
    assert found.common
    assert (np.abs(found.relaxation.share - share) < 4.5 * found.share_std + 1e-4).all()
    assert (np.abs(found.relaxation.time - constants) < 4.5 * found.time_std).all()
    assert (found.after < 1.03).all()
    assert (found.before > 3 * found.after)[:2].all()
    undone = found.relaxation.undo(raw, time)
    away = undone - touch
    assert np.sqrt((away**2).mean()) < {1: 1.2e-3, 2: 1.4e-3, 3: 2.7e-3}[len(share)]  # against 1e-3 of noise
    assert np.sqrt(((raw - touch) ** 2).mean()) > 0.03


def test_standard_errors_are_those_of_the_scatter():
    scores = []
    for seed in range(12):
        raw, time, held, _ = recording([0.15], [2.0], seed=seed)
        found = ss.stream.fit_relaxation(raw[:3000], time[:3000], held[:4], terms=1, rest=0.0)
        scores.append(
            [
                (found.relaxation.share[0] - 0.15) / found.share_std[0],
                (found.relaxation.time[0] - 2) / found.time_std[0],
            ]
        )
    spread = np.sqrt((np.array(scores) ** 2).mean(axis=0))
    assert (0.5 < spread).all()
    assert (spread < 1.7).all()


def test_sensors_that_relax_each_in_their_own_way_are_said_to():
    raw, time, held, touch = recording([[0.2, 0.1, 0.2]], [2.0])
    found = ss.stream.fit_relaxation(raw, time, held, terms=1, rest=0.0)
    assert not found.common
    np.testing.assert_allclose(found.scale / found.scale[0], [1, 0.5, 1], atol=0.03)
    left = np.abs(found.own.undo(raw, time) - touch).mean()
    assert left < 0.4 * np.abs(found.relaxation.undo(raw, time) - touch).mean()


def test_a_sensor_that_the_touches_do_not_move_says_nothing():
    raw, time, held, _ = recording([0.15], [2.0], gains=(1.0, 0.5, 0.0))
    found = ss.stream.fit_relaxation(raw, time, held, terms=1, rest=0.0)
    assert found.common
    assert np.isnan(found.scale).tolist() == [False, False, True]
    assert np.asarray(found.own.share)[:, 2] == pytest.approx(np.asarray(found.relaxation.share), rel=1e-3)


def test_missing_readings_do_no_harm():
    raw, time, held, _ = recording([0.15], [2.0])
    raw[np.random.default_rng(0).random(raw.shape) < 0.1] = np.nan
    raw[:, 2] = np.nan
    found = ss.stream.fit_relaxation(raw, time, held, terms=1, rest=0.0)
    np.testing.assert_allclose(found.relaxation.share, 0.15, atol=0.003)


def test_a_skin_that_does_not_relax_has_no_share():
    raw, time, held, _ = recording([0.0], [2.0])
    found = ss.stream.fit_relaxation(raw, time, held, terms=1, rest=0.0)
    assert found.relaxation.share[0] < 2e-3
    assert found.common


@pytest.mark.parametrize(
    ("call", "error", "seen"),
    [
        (lambda: ss.Relaxation([0.6, 0.5], [1, 2]), ss.errors.InvalidValueError, "share in all"),
        (lambda: ss.Relaxation([-0.1], [1]), ss.errors.InvalidValueError, "share"),
        (lambda: ss.Relaxation([0.1], [0]), ss.errors.InvalidValueError, "time"),
        (lambda: ss.Relaxation([0.1], [1, 2]), ss.errors.GeometryError, "one of each"),
        (lambda: ss.Relaxation([[0.1, 0.2]], [1]).undo(np.zeros((2, 3)), [0, 1]), ss.errors.GeometryError, "2 sensors"),
        (lambda: RUBBER.undo(np.zeros((2, 3)), [1, 0]), ss.errors.InvalidValueError, "go back"),
        (lambda: RUBBER.undo(np.zeros((2, 3)), [1]), ss.errors.GeometryError, "time of shape"),
        (lambda: replace(RUBBER, rest=[1, 2]).undo(np.zeros((2, 3)), [0, 1]), ss.errors.GeometryError, "rest"),
        (
            lambda: ss.stream.fit_relaxation(np.zeros((9, 1)), np.arange(9), [(0, 8)], terms=4),
            ss.errors.InvalidValueError,
            "terms",
        ),
        (
            lambda: ss.stream.fit_relaxation(np.zeros((9, 1)), np.arange(9), [(0, 2)]),
            ss.errors.InvalidValueError,
            "5 frames",
        ),
        (lambda: ss.stream.fit_relaxation(np.zeros((9, 1)), np.arange(9), [0, 2]), ss.errors.GeometryError, "held"),
    ],
)
def test_what_cannot_be_done_is_said(call, error, seen):
    with pytest.raises(error, match=seen):
        call()


def test_a_state_goes_on_and_not_back():
    left, _ = RUBBER.undo.step(None, np.zeros((2, 3)), [0.0, 1.0])
    with pytest.raises(ss.errors.InvalidValueError, match="go back"):
        RUBBER.undo.step(left, np.zeros((1, 3)), [0.5])
    with pytest.raises(ss.errors.GeometryError, match="state"):
        RUBBER.undo.step(left, np.zeros((1, 2)), [1.5])


@pytest.mark.parametrize("value", [0.0, np.nan])
def test_nothing_relaxes_in_readings_of_nothing(value):
    time = np.arange(0.0, 10.0, 0.01)
    with pytest.raises(ss.errors.ConvergenceError, match="never change"):
        ss.stream.fit_relaxation(np.full((time.size, 3), value), time, [(2.0, 8.0)], terms=1, rest=np.zeros(3))


def test_a_doubt_is_a_share_of_what_each_term_makes_of_the_reading():
    """Of a step u after t: sum of share u (1 - exp(-t / tau)), and after its end what is left of that."""
    time = np.concatenate([[0.0, 1.0 - 1e-9], np.arange(1.0, 9.0, 0.25), [9.0 - 1e-9], np.arange(9.0, 20.0, 0.25)])
    touch = np.where((time >= 1.0) & (time < 9.0), 3.0, 0.0)[:, None] * [1.0, -0.5]
    doubted = replace(RUBBER, rest=0.0, doubt=[0.3, 0.1])
    felt = doubted.apply(touch, time)
    out = doubted.undoing(felt, time)
    np.testing.assert_array_equal(out.readings, doubted.undo(felt, time))
    held, gone = (time >= 1.0) & (time < 8.99), time >= 9.0
    for i, doubt in enumerate((0.3, 0.1)):
        expected = np.zeros(time.size)
        for p, tau in zip(RUBBER.share, RUBBER.time):
            expected[held] += p * -np.expm1(-(time[held] - 1.0) / tau)
            expected[gone] += p * -np.expm1(-8.0 / tau) * np.exp(-(time[gone] - 9.0) / tau)
        told = held | gone
        np.testing.assert_allclose(
            out.doubt[told, i], doubt * abs(touch[5, i]) * expected[told], atol=1e-7, equal_nan=False
        )


def test_shares_that_differ_from_touch_to_touch_are_a_doubt_and_noise_is_none():
    time = np.arange(0, 900, 0.05)
    phase, k = time % 15, (time // 15).astype(int)
    ramp = np.clip(np.minimum(phase - 4, 11 - phase) * 2, 0, 1)
    held = np.array([[15 * k + 4.5, 15 * k + 10.5] for k in range(60)])
    gains, rng = np.array([1.0, -0.4]), np.random.default_rng(3)
    for spread in (0.0, 0.3):
        more = spread * rng.standard_normal((60, 2))
        # what the mean share takes of each touch, taken more or less often
        whole = ss.Relaxation([0.1], [1.0]).apply(ramp[:, None] * gains, time)
        felt = ramp[:, None] * gains + (1 + more[k]) * (whole - ramp[:, None] * gains)
        felt = felt + 1e-3 * rng.standard_normal(felt.shape)
        fit = ss.stream.fit_relaxation(felt, time, held, terms=1, rest=0.0)
        # undone, a hold that lost p (1 + e) is (1 - p (1 + e)) / (1 - p): wrong by e p / (1 - p), where p was taken
        assert fit.own.doubt == pytest.approx(more.std() / 0.9, rel=0.1, abs=0.02)


def test_doubts_and_shares_of_other_sensors_are_refused():
    for wrong in ({"doubt": [0.1, 0.2, 0.3]}, {"share": [[0.1, 0.2, 0.3]], "time": [1.0]}):
        with pytest.raises(GeometryError, match="of 3 sensors"):
            replace(RUBBER, **wrong).undoing(np.zeros((4, 2)), np.arange(4.0))
    with pytest.raises(InvalidValueError, match="doubt"):
        replace(RUBBER, doubt=-0.1)


def test_free_skin_after_a_touch_that_does_not_read_as_before_is_a_doubt():
    """Rubber that keeps a share of what it has forgotten for good: the holds do not say it, the free skin does."""
    raw, time, held, touch = recording([0.15], [2.0], gains=(1.0, -0.4))
    free = np.array([[15 * k + 2.0, 15 * k + 3.9, 15 * k + 11.1, 15 * k + 11.6] for k in range(8)])
    assert ss.stream.fit_relaxation(raw, time, held, terms=1, rest=0.0, free=free).own.doubt < 0.02
    kept = np.zeros(time.size)
    for k in range(8):
        after = (time > 15 * k + 10.9) & (time < 15 * k + 14.9)
        kept[after] = 0.05 * touch[np.searchsorted(time, 15 * k + 8.0), 0]
    worse = ss.stream.fit_relaxation(raw - kept[:, None] * [1.0, -0.4], time, held, terms=1, rest=0.0, free=free)
    # soon after a touch of 1 what was taken is 0.15 (1 - exp(-3.25)) exp(-0.3) = 0.11 of it; a third of it stays away
    assert worse.own.doubt == pytest.approx(0.05 / 0.11 / np.sqrt(2), rel=0.25)
    with pytest.raises(GeometryError, match="two stretches"):
        ss.stream.fit_relaxation(raw, time, held, free=free[:, :2])
    with pytest.raises(InvalidValueError, match="a frame has to lie"):
        ss.stream.fit_relaxation(raw, time, held, free=free + 1e3)
