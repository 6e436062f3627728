"""`subskin orient`: which way round, from a table of presses; the finger file keeps what was confirmed."""

import json

import numpy as np
import pytest

import subskin as ss
from subskin.calibration import telling
from subskin.io.tables import write_table

PAD = """\
# a pad
[skin]
kind = "half_space"
young = "0.4 MPa"

[sensors]
layout = "grid"
shape = [4, 4]
pitch = "3 mm"
depth = "3 mm"
noise = 4e-5
"""


@pytest.fixture
def pad(tmp_path, monkeypatch):
    """A pad's file, and what it reads of two presses near where they tell most, as a table by name."""
    (tmp_path / "pad.toml").write_text(PAD)
    monkeypatch.chdir(tmp_path)
    finger = ss.load("pad.toml").finger
    sites = telling(finger, 2)
    at = finger.array.points[sites] + np.array([[0.8e-3, 1e-3], [-1e-3, 0.5e-3]])
    readings = finger.read(ss.PointLoad(force=1.2, angle=0.1, position=at), np.random.default_rng(0))

    def write(readings, **more):
        write_table(
            "presses.csv", {"near": [f"s{i}" for i in sites], **{f"s{i}": r for i, r in enumerate(readings.T)}, **more}
        )

    write(readings)
    return readings, write, at


def test_where_to_press(subskin, pad):
    ran = subskin("orient", "pad.toml")
    assert (ran.code, ran.out) == (0, "press near s1, then near s7, then near s13\n")


def test_what_is_confirmed_is_kept_and_no_longer_said_to_be_missing(subskin, pad):
    assert "which way round" in subskin("locate", "pad.toml", "presses.csv").err
    ran = subskin("orient", "pad.toml", "presses.csv")
    assert (ran.code, (ss.load("pad.toml").oriented)) == (0, None)
    ran = subskin("orient", "pad.toml", "presses.csv", "--write")
    assert (ran.code, ran.err) == (0, "")
    file = ss.load("pad.toml")
    assert file.oriented is not None
    assert file.text.startswith(PAD)
    assert subskin("locate", "pad.toml", "presses.csv").err == ""


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (lambda r: r[:, ::-1], '["s15", "s14", "s13"'),
        (lambda r: r.reshape(-1, 4, 4).swapaxes(1, 2).reshape(-1, 16), "y and z are swapped"),
        (lambda r: -r, "multiply gain under [sensors] by -1"),
    ],
    ids=["reversed", "swapped", "sign"],
)
def test_what_is_wrong_is_said_and_nothing_is_written(subskin, pad, change, said):
    readings, write, _ = pad
    write(change(readings))
    ran = subskin("orient", "pad.toml", "presses.csv", "--write")
    assert ran.code == 1
    assert said in ran.out
    assert ss.load("pad.toml").text == PAD


def test_the_scale_of_the_gains(subskin, pad):
    readings, write, _ = pad
    write(2 * readings, force=[1.2, 1.2])
    ran = subskin("orient", "pad.toml", "presses.csv", "--json")
    told = json.loads(ran.out)
    assert (ran.code, told["confirmed"], told["name"]) == (1, False, "as drawn")
    assert abs(told["scale"] - 2.0) < 3 * told["scale_std"] < 2.0
    assert "multiply gain" in subskin("orient", "pad.toml", "presses.csv").out


def test_presses_at_positions_on_the_axes_of_the_tables(subskin, pad, tmp_path):
    readings, _, at = pad
    (tmp_path / "pad.toml").write_text(PAD + '[calibration]\norigin = ["20 mm", "10 mm"]\n')
    where = dict(zip(("position_y", "position_z"), (at + np.array([20e-3, 10e-3])).T, strict=True))
    write_table("presses.csv", {**where, **{f"s{i}": r for i, r in enumerate(readings.T)}})
    assert subskin("orient", "pad.toml", "presses.csv").code == 0


@pytest.mark.parametrize(
    ("columns", "said"), [({"near": ["s1", "s99"]}, 'line 3: near = "s99"'), ({"neer": ["s1", "s7"]}, "position_y")]
)
def test_bad_input(subskin, pad, columns, said):
    readings, _, _ = pad
    write_table("presses.csv", {**columns, **{f"s{i}": r for i, r in enumerate(readings.T)}})
    ran = subskin("orient", "pad.toml", "presses.csv")
    assert (ran.code, said in ran.err, ran.err.count("\n")) == (2, True, 1)
