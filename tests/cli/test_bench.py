"""A finger calibrated while a simulated stage touches it; what is written, and what is kept on the way."""

import io
import json
from contextlib import chdir
from unittest import mock

import numpy as np
import pytest

import subskin as ss
from subskin.live.ports import Robot

from .._commands import subskin

FINGER = """\
[skin]
young = "0.4 MPa"
[sensors]
count = 6
pitch = "2 mm"
depth = "2.5 mm"
noise = 1e-4
"""
QUICK = ("--rest", "0.2 s", "--hold", "0.1 s", "--accuracy", "0.05 mm")


def typed(folder, *arguments, words=""):
    """Run a command in `folder` while somebody types `words`."""
    with chdir(folder), mock.patch("sys.stdin", io.StringIO(words)):
        return subskin(*arguments)


@pytest.fixture(scope="module")
def session(tmp_path_factory):
    folder = tmp_path_factory.mktemp("bench")
    (folder / "finger.toml").write_text(FINGER)
    options = ("--port", "robot?seed=3", "--force", "40 N/m", "-o", "out.toml", "--json")
    run = typed(folder, "bench", "finger.toml", *options, *QUICK)
    return folder, run


def test_the_finger_written_is_the_one_that_was_touched(session):
    folder, run = session
    assert run.code == 0, run.err
    lines = [json.loads(line) for line in run.out.splitlines()]
    assert [lines[0]["said"], lines[-2]["said"], lines[-1]["said"]] == ["rest", "reached", "written"]
    drawn, found = ss.load(folder / "finger.toml"), ss.load(folder / "out.toml")
    robot = Robot(drawn, seed=3)
    true = robot.finger.array
    ratio = np.asarray(found.finger.array.gain) / np.asarray(true.gain)
    assert ratio / ratio.mean() == pytest.approx(np.ones(6), abs=0.03)
    assert float(np.mean(found.finger.array.depth)) == pytest.approx(float(np.mean(true.depth)), rel=0.02)
    assert found.origin == pytest.approx(float(robot.origin), abs=0.05e-3)
    assert np.asarray(found.finger.array.noise) == pytest.approx(np.asarray(true.noise), rel=0.4)
    assert found.differences


def test_the_stage_presses_as_hard_as_it_is_told(session):
    folder, run = session
    assert run.code == 0
    drawn, found = ss.load(folder / "finger.toml"), ss.load(folder / "out.toml")
    true = Robot(drawn, seed=3).finger.array
    assert np.asarray(found.finger.array.gain) == pytest.approx(np.asarray(true.gain), rel=0.05)


def test_the_touches_are_kept_and_calibrate_to_the_same_finger(session):
    folder, run = session
    assert run.code == 0
    options = ("--fit", "gain,depth,origin", "--force-column", "force", "-o", "again.toml")
    again = typed(folder, "calibrate", "finger.toml", "out.touches.csv", *options)
    assert again.code == 0, again.err
    one, two = (ss.load(folder / name).finger.array for name in ("out.toml", "again.toml"))
    assert np.asarray(two.gain) == pytest.approx(np.asarray(one.gain), rel=0.02)
    assert np.asarray(two.depth) == pytest.approx(np.asarray(one.depth), rel=0.01)


def test_words_that_are_typed(session):
    folder, _ = session
    options = ("--port", "robot", "-o", "ended.toml", "--rest", "0.2 s", "--hold", "0.1 s")
    run = typed(folder, "bench", "finger.toml", *options, words="what\nend\n")
    assert run.code == 1
    assert '"what": known are again, skip, end' in run.out
    assert "ended after 0 touches" in run.out
    assert "a calibration needs at least two" in run.err
    assert not (folder / "ended.toml").exists()


@pytest.mark.parametrize(
    ("options", "says"),
    [
        (("--port", "robot", "-o", "finger.toml"), "same file as the finger"),
        (("-o", "x.toml"), "nothing says where the device is"),
        (("--port", "robot", "-o", "x.toml", "--positions", "3 mm:1 mm:1 mm"), "first:last:step"),
        (("--port", "robot?rate=many", "-o", "x.toml"), "a number is needed"),
        (("--port", "robot?seed=-1", "-o", "x.toml"), "robot?seed = -1: a whole number"),
        (("--port", "robot", "-o", "-"), "-o -: what happens is said on standard output"),
        (("--port", "robot", "-o", "none/x.toml"), "there is no folder none"),
        (("--port", "robot", "-o", "x.toml", "--accuracy", "2 s"), "2 s"),
    ],
)
def test_what_makes_no_sense_is_refused(session, options, says):
    folder, _ = session
    run = typed(folder, "bench", "finger.toml", *options)
    assert run.code == 2
    assert says in run.err
    assert "Traceback" not in run.err
