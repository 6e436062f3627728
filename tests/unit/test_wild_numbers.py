"""Readings beyond reckoning, masked readings, and chi-square that is what it is said to be."""

from __future__ import annotations

import numpy as np
import pytest

import subskin as ss

SKIN = ss.HalfPlane(ss.Material(0.4e6))
FINGER = ss.Finger(SKIN, ss.SensorArray.line(6, 1.5e-3, 2e-3, noise=1e-4))
TOUCH = FINGER.read(ss.LineLoad(40.0, 0.3, 0.8e-3), np.random.default_rng(0))
VERBS = {
    "locate": lambda finger, frames: finger.locate(frames),
    "without one": lambda finger, frames: finger.locate(frames, outliers=1),
    "fit": lambda finger, frames: finger.fit(frames),
    "decide": ss.decide.contact_type,
    "pressure": ss.pressure_map,
}


@pytest.mark.parametrize("verb", VERBS)
def test_every_status_is_one(verb):
    """Whatever a frame holds, and whatever the noise: a status, and no number for nonsense."""
    one = np.repeat(TOUCH[None], 7, axis=0)
    one[:, 2] = [1e12, 1e20, 1e70, 1e150, -1e200, 1e308, -1e308]
    found = VERBS[verb](FINGER, np.concatenate([one, TOUCH * np.array([1e20, 1e80, 1e155, 1e300])[:, None]]))
    assert set(found.status) <= set(ss.Status)
    assert (found.status[7:] == ss.Status.UNEXPLAINED).all()
    assert (found.status[:7] == (ss.Status.OK if verb == "without one" else ss.Status.UNEXPLAINED)).all()
    assert "unexplained" in repr(found).lower()
    exact = ss.Finger(SKIN, ss.SensorArray.line(6, 1.5e-3, 2e-3, noise=1e-300))
    assert VERBS[verb](exact, TOUCH[None]).status[0] == ss.Status.UNEXPLAINED


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("verb", ["locate", "fit", "decide"])
def test_on_an_area_too_every_status_is_one(verb):
    grid = ss.SensorArray.grid((3, 3), 3e-3, depth=3e-3, transducer=ss.MeanPressure(), noise=20.0)
    pad = ss.Finger(ss.HalfSpace(ss.Material(0.4e6)), grid)
    frames = np.repeat(pad.read(ss.PointLoad(1.0, position=(1e-3, 0.0)))[None], 5, axis=0)
    frames[:, 2] = [1e12, 1e70, 1e160, -1e300, 1.7e308]
    assert (VERBS[verb](pad, frames).status == ss.Status.UNEXPLAINED).all()


def test_what_is_masked_is_missing():
    holed = np.where(np.arange(6) == 3, np.nan, TOUCH)
    masked = np.ma.masked_array(np.where(np.arange(6) == 3, 0.5, TOUCH), mask=np.arange(6) == 3)
    for verb in VERBS.values():
        a, b = verb(FINGER, masked), verb(FINGER, holed)
        assert np.array_equal(a.table, b.table, equal_nan=True)
        assert a.used.tolist() == [True, True, True, False, True, True]
    several = np.ma.masked_array(np.tile(TOUCH, (5, 1)), mask=True)
    assert (FINGER.locate(several).status == ss.Status.INCOMPLETE).all()
    kinds = [ss.side_angle(FINGER, part, position=0.8e-3, half_width=0.3e-3).angle for part in (masked, holed)]
    assert np.array_equal(*kinds, equal_nan=True)
    time = np.arange(30) * 0.01
    stream = np.ma.masked_array(np.tile(TOUCH, (30, 1)), mask=np.tile(np.arange(6) == 3, (30, 1)))
    tared = [ss.Tare(FINGER)(part, time).readings for part in (stream, stream.filled(np.nan))]
    assert np.array_equal(*tared, equal_nan=True)


def test_what_is_masked_is_refused_elsewhere():
    masked = np.ma.masked_array([1e-3, 2e-3, 3e-3], mask=[False, True, False])
    with pytest.raises(ss.errors.InvalidValueError, match="masked"):
        ss.SensorArray(y=masked, depth=2e-3)
    with pytest.raises(ss.errors.InvalidValueError, match="masked"):
        SKIN.stress(ss.LineLoad(1.0), masked, 0.0)
    with pytest.raises(ss.errors.InvalidValueError, match="masked"):
        FINGER.locate(TOUCH, search=np.ma.masked_array([-1e-3, 1e-3], mask=[True, False]))
    plain = np.ma.masked_array([1e-3, 2e-3, 3e-3])
    assert ss.SensorArray(y=plain, depth=2e-3).y.tolist() == [1e-3, 2e-3, 3e-3]


@pytest.mark.parametrize("noise", [1e-2, 1e-4, 1e-6, 1e-8])
def test_chi_square_is_that_of_the_answer(noise):
    """However large readings are beside their noise, and at the edge of the cone: to 1e-6, or 1e-6 a sensor."""
    unit = 3 / (2 * np.pi)
    finger = ss.Finger(ss.HalfPlane(ss.Material(1.0)), ss.SensorArray.line(6, 0.75, 1.0, noise=noise * unit))
    rng = np.random.default_rng(1)
    angle, y = rng.choice([-1, 1], 12000) * rng.uniform(0.7, np.pi / 4, 12000), rng.uniform(-3.3, 3.3, 12000)
    frames = finger.read(ss.LineLoad(1.0, angle, y), rng)
    found = finger.locate(frames)
    at = np.isfinite(found.position)
    assert at.mean() > 0.9
    fields = finger.tabulate()(found.position[at])
    left = (frames[at] - np.einsum("fnk,fk->fn", fields, found.components[at])) / finger.array.noise
    chi2 = (left**2).sum(axis=1)
    assert (np.abs(found.residual[at] - chi2) < 1e-6 * np.maximum(chi2, 6)).all()
    assert np.median(chi2) == pytest.approx(2.4, abs=0.4)  # that of three readings to spare


@pytest.mark.parametrize("ratio", [1e9, 1e11])
def test_an_exact_load_is_explained_however_small_the_noise(ratio):
    """What is beyond the digits of the table is not held against a load."""
    finger = ss.Finger(SKIN, ss.SensorArray.line(6, 1.5e-3, 2e-3, noise=0.02 / ratio))
    rng = np.random.default_rng(2)
    load = ss.LineLoad(40.0, rng.uniform(-0.5, 0.5, 50), rng.uniform(-3e-3, 3e-3, 50))
    found = finger.locate(finger.read(load))
    assert (found.status == ss.Status.OK).all()
    assert found.position == pytest.approx(load.position, abs=1e-11)
