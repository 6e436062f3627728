"""A raw stream, and a finger calibrated on presses from `segment`: what these have in common goes with the load."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import subskin as ss
from subskin.errors import FileError, InvalidValueError
from subskin.io import parse_finger
from subskin.stream import Pipeline, Tare

from .._commands import subskin

SKIN = ss.HalfPlane(ss.Material(young=0.4e6))
ROW = ss.SensorArray.line(count=5, pitch=3e-3, depth=4e-3, noise=1e-4, gain=1.0)
AT = 2e-3
COMMON = 0.004  # what a press makes of all sensors beyond the skin's field, which is up to 0.02
NOISE = 10.0 * np.asarray(ROW.noise)
"""Of the calibrated finger: as much as its model is wrong."""


def stream() -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Times, readings on a bias of their own, and the force: 5 s free, 40 s pressed, let go over 2 s, 10 s free."""
    time = np.arange(0.0, 60.0, 0.02)
    force = np.interp(time, [5.0, 5.2, 45.0, 47.0], [0.0, 40.0, 40.0, 0.0])
    tip = ss.Finger(SKIN, ROW)
    readings = tip.read(ss.LineLoad(force, position=AT), np.random.default_rng(0))
    return time, readings + COMMON * force[:, None] / 40.0 + np.linspace(0.1, 0.5, 5), force


def calibrated(noise: np.ndarray = NOISE) -> ss.Finger:
    return ss.Finger(SKIN, replace(ROW, lift=COMMON / 40.0, noise=noise))


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
    assert np.abs(out["tare"].readings[force == 0][:240]).max() < 1e-3  # differences


def test_a_light_touch_is_where_it_was():
    """Of whatever force: what all sensors read more goes with it, and is not that of the presses."""
    finger = calibrated(np.asarray(ROW.noise))
    force = np.geomspace(4.0, 80.0, 12)
    found = finger.locate(ss.Finger(SKIN, ROW).read(ss.LineLoad(force, position=AT)) + COMMON * force[:, None] / 40.0)
    assert (found.status == ss.Status.OK).all()
    np.testing.assert_allclose(found.position, AT, atol=1e-9)
    np.testing.assert_allclose(found.force, force, rtol=1e-9)
    # as an offset, which it is of presses of 40 N/m alone, none of the light ones is
    alike = ss.Finger(SKIN, replace(ROW, offset=COMMON)).locate(finger.read(ss.LineLoad(force, position=AT)))
    assert not ((alike.status == ss.Status.OK) & (np.abs(alike.position - AT) < 0.1e-3))[force < 20.0].any()


def test_frame_by_frame_it_is_the_same():
    finger = calibrated()
    time, readings, _ = stream()
    pipeline = Pipeline({"tare": Tare(finger, noise=ROW.noise, differences=True), "found": finger.locator()})
    whole, state = pipeline(readings, time), None
    for k in range(300):
        state, out = pipeline.step(state, readings[k], time[k])
        assert out["found"].status == whole["found"].status[k]
        assert out["found"].table.tobytes() == whole["found"].table[k].tobytes()


def test_a_long_press_is_held_for_a_touch():
    """A departure is judged as what presses read, offsets in it: no other offset of the skin."""
    out, force = run(calibrated(np.asarray(ROW.noise)))
    held = force == 40.0
    assert not out["tare"].free[held][50:].any()
    offset = out["tare"].offset[held]
    assert np.abs(offset - offset[0]).max() < 5e-4


def test_an_offset_of_differences_is_refused():
    """A free skin has none: it would be a touch all the time."""
    finger = ss.Finger(SKIN, replace(ROW, offset=COMMON))
    with pytest.raises(InvalidValueError, match=r"offset = 0\.004 .*calibrate again with lift"):
        Tare(finger, differences=True)
    with pytest.raises(FileError, match=r"offset = 0\.004 of a finger that reads differences"):
        parse_finger(FILE + "offset = 0.004\n[calibration]\ndifferences = true\n")
    with pytest.raises(InvalidValueError, match=r"offset = 0\.004"):
        parse_finger(FILE).of_differences().with_finger(finger, 0.0)
    assert Tare(finger)(np.zeros((9, 5)), np.arange(9.0)).readings.shape == (9, 5)  # raw ones have theirs


def presses(forces: np.ndarray, positions: np.ndarray) -> np.ndarray:
    """Differences as `segment` writes them, of a skin with a lift of COMMON / 40 at every sensor."""
    true = ss.Finger(SKIN, replace(ROW, lift=COMMON / 40.0))
    return true.read(ss.LineLoad(forces, position=positions), np.random.default_rng(1))


def test_calibrating_on_presses_finds_the_lift(tmp_path):
    """By presses of one force and of several; on the command line an offset of presses is a lift."""
    positions = np.linspace(-7e-3, 7e-3, 29)
    drawn = ss.Finger(SKIN, replace(ROW, gain=0.8))
    fit = ("gain", "lift", "depth", "origin")
    for forces in (np.full(29, 40.0), np.linspace(10.0, 60.0, 29)):
        found = ss.calibrate(drawn, presses(forces, positions), positions, fit=fit, force=forces)
        np.testing.assert_allclose(found.finger.array.lift, COMMON / 40.0, rtol=0.05)
        assert not np.any(found.finger.array.offset)
        assert {p.name for p in found.parameters} == {"origin", "depth", "gain", "lift"}
        held = presses(forces, positions + 0.2e-3)
        assert found.evaluate(held, positions + 0.2e-3, force=forces).r2 > 0.999
    constant = ("gain", "offset", "depth", "origin")
    told = {"force": forces, "accept_misfit": True}
    as_offset = ss.calibrate(drawn, presses(forces, positions), positions, fit=constant, **told)
    assert 1 - as_offset.r2 > 100 * (1 - found.r2)  # presses of several forces tell them apart
    both = ss.calibrate(drawn, presses(forces, positions) + 0.02, positions, fit=("offset", *fit), force=forces)
    np.testing.assert_allclose(both.finger.array.offset, 0.02, rtol=0.02)
    np.testing.assert_allclose(both.finger.array.lift, COMMON / 40.0, rtol=0.05)
    with pytest.raises(InvalidValueError, match="offset and lift, of touches of one force"):
        ss.calibrate(drawn, presses(np.full(29, 40.0), positions), positions, fit=("offset", *fit))
    np.savetxt(
        tmp_path / "presses.csv",
        np.column_stack([positions, np.arange(29.0), np.arange(29.0) + 0.5, presses(np.full(29, 40.0), positions)]),
        delimiter=",", header="position,t_start,t_end,s0,s1,s2,s3,s4", comments="",
    )  # fmt: skip
    (tmp_path / "finger.toml").write_text(FILE)
    out = tmp_path / "calibrated.toml"
    ran = subskin("calibrate", tmp_path / "finger.toml", tmp_path / "presses.csv", "-o", out)
    assert (ran.code, ran.err) == (0, "")
    file = ss.load(out)
    np.testing.assert_allclose(file.finger.array.lift, COMMON, rtol=0.05)  # per press, whose force is not known
    assert file.with_finger(file.finger, 0.0).finger.array.lift.tolist() == file.finger.array.lift.tolist()
    assert file.to_fit(("gain", "offset", "lift")) == ("gain", "lift")


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
