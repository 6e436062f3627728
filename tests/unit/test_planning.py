"""Where to touch next: the error announced is the error made, and touches so chosen serve better than others."""

import numpy as np
import pytest

import subskin as ss
from subskin.calibration import next_touch
from subskin.calibration.known import explained, fitted
from subskin.errors import GeometryError, InvalidValueError, UnknownOptionError

SKIN = ss.HalfPlane(ss.Material(young=0.4e6))
TRUE = ss.Finger(SKIN, ss.SensorArray.line(5, pitch=4e-3, depth=4e-3, gain=[80, 110, 95, 100, 90], noise=2e-3))
PLACES = np.linspace(-8e-3, 8e-3, 17)


def proposed(finger, count, **options):
    made = []
    for _ in range(count):
        made.append(next_touch(finger, made, PLACES, force=40.0, **options).position)
    return np.array(made)


def test_the_error_announced_is_the_error_of_calibrated_fingers():
    rng, touches = np.random.default_rng(4), proposed(TRUE, 8)
    announced = next_touch(TRUE, touches, PLACES, force=40.0).error
    aims = TRUE.read(ss.LineLoad(40.0, position=PLACES))
    off = []
    for _ in range(15):
        readings = TRUE.read(ss.LineLoad(40.0, position=touches), rng)
        fit = ("gain", "offset", "depth", "origin")
        found = explained(fitted(TRUE, readings, touches, fit=fit, force=40.0, origin=0.0))  # as `calibrate` does
        off.append(found.finger.locate(aims).position + found.origin - PLACES)
    assert announced == pytest.approx(np.sqrt(np.mean(np.square(off))), rel=0.3)


def test_its_touches_leave_less_error_than_touches_at_random():
    rng = np.random.default_rng(5)
    left = next_touch(TRUE, proposed(TRUE, 6), PLACES, force=40.0).error
    others = [next_touch(TRUE, rng.choice(PLACES, 6), PLACES, force=40.0).error for _ in range(20)]
    assert left < min(others)


def test_the_error_after_a_touch_is_the_error_once_it_is_made():
    here = next_touch(TRUE, [0.0, 4e-3], PLACES, force=40.0)
    again = next_touch(TRUE, [0.0, 4e-3, here.position], PLACES, force=40.0)
    assert again.error == pytest.approx(here.error_after, rel=1e-6)
    assert here.error_after < here.error


def test_what_is_known_well_needs_no_touch():
    known = {"gain": 1e-6, "offset": 1e-9, "depth": 1e-9, "origin": 2e-4}
    finger = next_touch(TRUE, [], PLACES, force=40.0, known=known)
    assert finger.error == pytest.approx(2e-4, rel=1e-3)  # all positions move with the origin


def test_on_an_area_it_spreads_its_touches():
    array = ss.SensorArray.grid(shape=(2, 3), pitch=5e-3, depth=5e-3, transducer=ss.MeanPressure(), noise=5.0)
    tip = ss.Finger(ss.HalfSpace(ss.Material(young=0.4e6)), array)
    axis = np.linspace(-5e-3, 5e-3, 5)
    places = np.stack(np.meshgrid(axis, axis), axis=-1).reshape(-1, 2)
    made = np.empty((0, 2))
    for _ in range(5):
        made = np.vstack([made, next_touch(tip, made, places, force=2.0, origin=(0.0, 0.0)).position])
    assert len(np.unique(made, axis=0)) == 5
    assert np.ptp(made, axis=0).min() > 5e-3


@pytest.mark.parametrize(
    ("given", "error"),
    [
        ({"candidates": []}, InvalidValueError),
        ({"candidates": [[0.0, 1e-3]]}, GeometryError),
        ({"known": {"poisson": 0.1}}, UnknownOptionError),
        ({"known": {"gain": -1.0}}, InvalidValueError),
        ({"fit": "gains"}, InvalidValueError),
        ({"finger": ss.Finger(SKIN, ss.SensorArray.line(4, 4e-3, 4e-3))}, InvalidValueError),
    ],
)
def test_what_makes_no_sense_is_refused(given, error):
    with pytest.raises(error, match=r"needed|fitted are|has to|noise|needs"):
        next_touch(**{"finger": TRUE, "positions": [], "candidates": PLACES} | given)
