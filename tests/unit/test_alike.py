"""What is known of gains before any touch: those of one kind are alike."""

from __future__ import annotations

import numpy as np
import pytest

import subskin as ss
from subskin.calibration import Health
from subskin.calibration.alike import AlikeGains
from subskin.errors import InvalidValueError

GRID = {"shape": (2, 4), "pitch": 7e-3, "depth": 5e-3, "transducer": ss.NormalStrain(), "noise": 2e-5}
SKIN = ss.HalfSpace(ss.Material(young=0.4e6))
FIT = ("gain", "depth", "origin", "turn")


def alike(gain, information, error=0.25, drawn=1.0):
    array = ss.SensorArray.grid(**{**GRID, "gain": drawn})
    return AlikeGains(array, error).judged(np.array(gain), np.array(information))


def test_gains_are_the_likeliest_of_a_normal_distribution_about_an_unknown_mean():
    rng = np.random.default_rng(0)
    drawn = rng.uniform(0.5, 2.0, 8)
    said, information = 3.0 * drawn * rng.normal(1.0, 0.15, 8), 10 ** rng.uniform(-1, 3, 8) / drawn**2
    one = alike(said, information, drawn=drawn)
    found = one.settled(said, information)
    # least squares over eight gains and their common factor, whose errors are those of the factor found
    common = np.mean(found / drawn)
    rows = np.zeros((16, 9))
    rows[:8, :8], rows[8:, :8], rows[8:, 8] = np.diag(np.sqrt(information)), np.diag(1 / drawn), -1.0
    rows[8:] /= 0.25 * common
    expected = np.linalg.lstsq(rows, np.concatenate([np.sqrt(information) * said, np.zeros(8)]), rcond=None)[0]
    np.testing.assert_allclose(found, expected[:8], rtol=1e-3)  # three rounds of the factor
    np.testing.assert_allclose(one.slopes(found) @ found, (found / drawn - common) / (0.25 * common), atol=1e-12)


def test_a_gain_of_which_nothing_is_said_is_the_common_one_and_a_certain_one_is_as_said():
    said, information = np.array([1.1, 0.9, 1.0, 1.0, 1.2, 0.8, 1.0, 57.0]), np.array([1e9] * 7 + [0.0])
    found = alike(said, information).settled(said, information)
    np.testing.assert_allclose(found[:7], said[:7], rtol=1e-7)
    assert found[7] == pytest.approx(1.0)


@pytest.mark.parametrize("own", [0.0, -1.0, 0.05, 3.0])
def test_a_gain_that_touches_show_to_be_another_is_one_of_its_own(own):
    said, information = np.array([1.1, 0.9, 1.0, 1.0, 1.2, 0.8, 1.0, own]), np.full(8, 1e4)
    one = alike(said, information)
    assert one.known.tolist() == [True] * 7 + [False]
    assert one.settled(said, information)[7] == own
    # where the touches say little of it, it is no other
    information[7] = 0.5
    assert alike(said, information).known.all()


def test_nothing_is_known_where_errors_are_infinite_or_a_sensor_is_the_only_one_of_its_kind():
    said, information = np.linspace(0.8, 1.2, 8), np.full(8, 10.0)
    assert not alike(said, information, error=np.inf).known.any()
    kinds = [ss.MeanPressure(), *[ss.NormalStrain()] * 7]
    array = ss.SensorArray.grid(**{**GRID, "transducer": kinds})
    assert AlikeGains(array, 0.25).judged(said, information).known.tolist() == [False] + [True] * 7


def calibrated(seed, touches, noise=2e-5, **more):
    """A finger drawn by chance and calibrated on touches anywhere above it; errors of its gains, and what was found."""
    rng = np.random.default_rng(seed)
    gain = rng.normal(1.0, 0.15, 8)
    real = ss.Finger(SKIN, ss.SensorArray.grid(**{**GRID, "gain": gain, "noise": noise}))
    at = rng.uniform([-4e-3, -11e-3], [4e-3, 11e-3], (touches, 2))
    drawn = ss.Finger(SKIN, ss.SensorArray.grid(**{**GRID, "depth": 5.2e-3, "noise": noise}))
    found = ss.calibrate(drawn, real.read(ss.PointLoad(force=1.0, position=at), rng), at, fit=FIT, force=1.0, **more)
    std = np.array([p.std for p in found.parameters if p.name == "gain"])
    return np.asarray(found.finger.array.gain) - gain, std, found


def test_few_touches_leave_gains_alike_and_call_no_sensor_dead_or_weak():
    off, std, own = [], [], []
    for seed in range(12):
        error, sigma, found = calibrated(seed, 4, 1e-3)
        assert all(state == Health.OK for state in found.health)
        off.append(error)
        std.append(sigma)
        own.append(calibrated(seed, 4, 1e-3, gain_error=np.inf)[0])
    size = np.sqrt(np.mean(np.square(off)))
    assert size < 0.15
    assert size < 0.7 * np.sqrt(np.mean(np.square(own)))
    held = np.mean(np.abs(off) <= 2 * np.array(std))
    assert held > 0.9


def test_many_touches_say_all_of_the_gains():
    error, std, found = calibrated(3, 60)
    own = calibrated(3, 60, gain_error=np.inf)[2]
    np.testing.assert_allclose(found.finger.array.gain, own.finger.array.gain, atol=0.05 * std.min())
    assert np.abs(error / std).max() < 4.5


def test_a_dead_sensor_near_a_touch_is_found_and_one_far_from_all_is_not_called_dead():
    rng = np.random.default_rng(1)
    gain = np.ones(8)
    gain[2] = 0.0
    real = ss.Finger(SKIN, ss.SensorArray.grid(**{**GRID, "gain": gain}))
    drawn = ss.Finger(SKIN, ss.SensorArray.grid(**GRID))
    points = real.array.points
    at = points[[0, 1, 2, 3, 4, 5]] + 1e-3
    found = ss.calibrate(
        drawn, real.read(ss.PointLoad(force=1.0, position=at), rng), at, fit=("gain", "depth"), force=1.0
    )
    assert found.health[2] == Health.DEAD
    assert [state for i, state in enumerate(found.health) if i != 2] == [Health.OK] * 7


@pytest.mark.parametrize("error", [0.0, -0.1, float("nan")])
def test_an_error_of_gains_that_is_none_is_refused(error):
    with pytest.raises(InvalidValueError, match="gain_error"):
        calibrated(0, 6, gain_error=error)
