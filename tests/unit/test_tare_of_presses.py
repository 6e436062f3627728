"""A raw stream, and a finger calibrated on presses cut out by `segment`: its offsets are of presses alone."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import subskin as ss
from subskin.io import parse_finger
from subskin.stream import Pipeline, Tare

SKIN = ss.HalfPlane(ss.Material(young=0.4e6))
ROW = ss.SensorArray.line(count=5, pitch=3e-3, depth=4e-3, noise=1e-4, gain=1.0)
AT = 2e-3
COMMON = 0.01  # what a press makes of all sensors beyond the skin's field
NOISE = 20.0 * np.asarray(ROW.noise)
"""Of the calibrated finger: as much as its model is wrong."""


def stream() -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Times, readings on a bias of their own, and the force: 5 s free, 40 s pressed, let go over 2 s, 10 s free."""
    time = np.arange(0.0, 60.0, 0.02)
    force = np.interp(time, [5.0, 5.2, 45.0, 47.0], [0.0, 40.0, 40.0, 0.0])
    tip = ss.Finger(SKIN, ROW)
    readings = tip.read(ss.LineLoad(force, position=AT), np.random.default_rng(0))
    return time, readings + COMMON * force[:, None] / 40.0 + np.linspace(0.1, 0.5, 5), force


def calibrated(noise: np.ndarray = NOISE) -> ss.Finger:
    return ss.Finger(SKIN, replace(ROW, offset=COMMON, noise=noise))


def run(finger: ss.Finger, **options) -> tuple[dict, np.ndarray]:
    time, readings, force = stream()
    return Pipeline({"tare": Tare(finger, differences=True, **options), "found": finger.locator()})(
        readings, time
    ), force


def test_a_free_skin_is_no_contact_and_a_press_is_where_it_was():
    out, force = run(calibrated(), noise=np.asarray(ROW.noise))
    status, found = np.asarray(out["found"].status), out["found"]
    assert (status[force == 0] == ss.Status.NO_CONTACT).all()
    held = np.flatnonzero(force == 40.0)[5:]  # a touch is told by medians of three
    assert (status[held] == ss.Status.OK).mean() > 0.99
    assert np.abs(found.position[held] - AT).max() < 0.1e-3
    # differences, for whoever shows them
    assert np.abs(out["tare"].readings[force == 0][:240]).max() < 1e-3


def test_frame_by_frame_it_is_the_same():
    finger = calibrated()
    time, readings, _ = stream()
    pipeline = Pipeline({"tare": Tare(finger, noise=ROW.noise, differences=True), "found": finger.locator()})
    whole, state = pipeline(readings, time), None
    for k in range(300):
        state, out = pipeline.step(state, readings[k], time[k])
        assert out["found"].status == whole["found"].status[k]
        assert np.array_equal(out["tare"].given_on, whole["tare"].given_on[k], equal_nan=True)


def test_a_long_press_is_held_for_a_touch():
    """A departure is judged as what presses read, offsets in it: no other offset of the skin."""
    out, force = run(calibrated(np.asarray(ROW.noise)))
    held = force == 40.0
    assert not out["tare"].free[held][50:].any()
    offset = out["tare"].offset[held]
    assert np.abs(offset - offset[0]).max() < 5e-4


def test_what_it_cannot_know_is_said():
    out, _ = run(calibrated(), noise=np.asarray(ROW.noise))
    (doubt,) = out["tare"].doubts
    assert "fitted to presses" in doubt
    assert "--fit gain,depth,origin" in doubt
    plain = ss.Finger(SKIN, replace(ROW, noise=NOISE))
    assert run(plain, noise=np.asarray(ROW.noise))[0]["tare"].doubts == ()


FILE = """\
[skin]
young = "0.4 MPa"

[sensors]
count = 5
pitch = "3 mm"
depth = "4 mm"
noise = 1e-4
"""


@pytest.mark.parametrize(
    ("given", "kept"), [("", 1e-4), ("\n[tare]\ndrift = 1e-5\n", 1e-4), ("[tare]\nnoise = 3e-4\n", 3e-4)]
)
def test_a_calibration_keeps_what_readings_stir_by(given, kept):
    """Its own noise counts how wrong the model is: drift as fast as a share of it would take touches for drift."""
    file = parse_finger(FILE + given)
    found = file.with_finger(calibrated(), 0.0)
    assert found.stirring == pytest.approx(kept)
    tare = found.pipeline().stages["tare"]
    assert tare.noise == pytest.approx(np.full(5, kept))
    assert found.with_finger(calibrated(2 * NOISE), 0.0).stirring == pytest.approx(kept)  # another calibration, later


def test_a_finger_that_is_no_noisier_needs_no_noise_of_its_own():
    file = parse_finger(FILE)
    assert file.with_finger(calibrated(np.asarray(ROW.noise)), 0.0).stirring is None


@pytest.mark.parametrize("bad", ["0", "-1", '"2 mm"'])
def test_a_noise_that_is_none_is_refused(bad):
    with pytest.raises(ss.errors.SubskinError, match="noise"):
        parse_finger(FILE + f"[tare]\nnoise = {bad}\n")
