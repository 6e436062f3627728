"""The main job on a recording of a real skin: four barometers under silicone (see ../shared/data/README.md)."""

from __future__ import annotations

import numpy as np
import pytest

import subskin as ss

SEARCH = (-25e-3, 25e-3)


@pytest.fixture(scope="module")
def presses(shared):
    """Places [m] and readings [Pa] of the 60 presses: the first 40 % of a plateau of z, less the rest before it."""
    path = shared / "data" / "barotact" / "test_full_20230706_175400.csv"
    if not path.is_file():
        pytest.skip("needs the barotact recording in ../shared/data, which does not ship with the project")
    raw = np.genfromtxt(path, delimiter=",", skip_header=1)
    pressure, x, z = raw[:, :4], raw[:, 4] * 1e-6, raw[:, 5]
    steps = np.flatnonzero(np.diff(np.concatenate([[0], (z > 0.99 * z.max()).astype(int), [0]])))
    places, readings = [], []
    for start, stop in zip(steps[::2], steps[1::2]):
        leaving = start
        while z[leaving - 1] < z[leaving]:
            leaving -= 1
        early = start + max(int(0.4 * (stop - start)), 1)
        readings.append(pressure[start:early].mean(0) - pressure[leaving - 10 : leaving].mean(0))
        places.append(x[start])
    assert len(places) == 60
    return np.array(places), np.array(readings)


@pytest.fixture(scope="module")
def drawn():
    return ss.Finger(ss.HalfPlane(ss.Material(young=0.4e6)), ss.SensorArray.line(4, pitch=6e-3, depth=5e-3))


@pytest.mark.parametrize(
    ("fit", "least_r2"),
    [
        (("gain", "offset", "depth", "origin", "place"), 0.995),
        (("gain", "offset", "depth", "origin", "place", "poisson"), 0.999),
    ],
)
def test_every_second_press_calibrates_and_the_others_are_located(presses, drawn, fit, least_r2):
    places, readings = presses
    found = ss.calibrate(drawn, readings[::2], places[::2], fit=fit)
    assert found.evaluate(readings[1::2], places[1::2]).r2 >= least_r2
    located = found.finger.locate(readings[1::2], friction=0, search=SEARCH)
    error = located.position - (places[1::2] - found.origin)
    assert np.median(np.abs(error)) <= 0.06e-3  # of all thirty, those far beyond the row among them
    ok = located.status == ss.Status.OK
    assert ok.sum() >= 20
    assert np.abs(error[ok]).max() < 0.4e-3
    over = np.abs(places[1::2] - found.origin) < 9e-3
    assert ok[over].all()


def test_three_presses_find_where_the_motor_began(presses, drawn):
    places, readings = presses
    known = ss.calibrate(
        drawn, readings[::2], places[::2], fit=("gain", "offset", "depth", "origin", "place")
    )
    three = [11, 21, 31]
    again = ss.calibrate(known.finger, readings[three], places[three], fit=("origin",))
    rest = np.setdiff1d(np.arange(1, 60, 2), three)
    located = again.finger.locate(readings[rest], friction=0, search=SEARCH)
    error = (located.position - (places[rest] - again.origin))[located.status == ss.Status.OK]
    assert error.size >= 18
    assert abs(error.mean()) <= 0.2e-3
    assert abs(np.median(error)) <= 0.2e-3
