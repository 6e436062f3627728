"""`subskin calibrate --blind`: readings to a finger file, a table for people, JSON, figure, errors."""

import json

import numpy as np
import pytest

from subskin.io.finger_file import load

DRAWN = """\
# six gauges
[skin]
young = "0.4 MPa"

[sensors]
count = 6
pitch = "1.5 mm"
depth = "2 mm"  # as drawn
noise = 5e-5

[locate]
search = ["-4.5 mm", "4.5 mm"]
"""


@pytest.fixture
def touches(folder, subskin):
    """Readings of a finger that differs from finger.toml, and its own file."""
    (folder / "finger.toml").write_text(DRAWN)
    real = DRAWN.replace('"2 mm"', '"2.08 mm"') + "\n"
    gains = "gain = [1.03, 0.95, 1.04, 0.98, 1.06, 0.99]\n"
    (folder / "real.toml").write_text(real.replace("noise = 5e-5\n", "noise = 5e-5\n" + gains))
    made = ("--count", 150, "--position", "-3.7..3.7 mm", "--angle", "-35..35 deg", "--force", "50..200 N/m")
    assert subskin("simulate", "real.toml", "-o", "readings.csv", *made, "--seed", 2).code == 0
    return folder


def test_the_file_written_locates_as_the_real_finger_does(touches, subskin):
    ran = subskin("calibrate", "--blind", "finger.toml", "readings.csv", "-o", "new.toml", "--figure", "learnt.svg")
    assert (ran.code, ran.err) == (0, "")
    for text in (
        "of 150 touches used", "times those of a finger known exactly", "common scale of the gains",
        "common shift", "common scale of depths and positions", "-> new.toml", "-> learnt.svg", "learnt",
    ):  # fmt: skip
        assert text in ran.out, text
    assert (touches / "learnt.svg").stat().st_size > 5000
    written = (touches / "new.toml").read_text()
    assert written.startswith("# six gauges")
    assert "# as drawn" in written
    assert "blind = true" in written
    real, new = load("real.toml").finger.array, load("new.toml").finger.array
    ratio = np.asarray(new.gain) / np.asarray(real.gain)
    assert np.ptp(np.log(ratio)) < 0.01
    answers = {}
    for name in ("real", "new", "finger"):
        ran = subskin("locate", f"{name}.toml", "readings.csv", "--truth", "position", "--json")
        answers[name] = json.loads(ran.out)
    assert answers["finger"]["status"]["unexplained"] > 100
    assert answers["new"]["status"]["ok"] >= answers["real"]["status"]["ok"] - 2
    angle = {n: np.array(answers[n]["columns"]["angle"], dtype=float) for n in ("real", "new")}
    assert np.nanstd(angle["real"] - angle["new"]) < 0.004


def test_json_and_rows(touches, subskin):
    ran = subskin("calibrate", "--blind", "finger.toml", "readings.csv", "--json", "--every", 2)
    result = json.loads(ran.out)
    assert ran.err == ""
    assert (result["touches"], result["dead"], result["weak"]) == (75, [], [])
    assert result["used"] + sum(result["left_out"].values()) == 75
    assert len(result["unknown"]) == 3
    assert 1 < result["error_ratio"]["angle"] < 1.3
    assert result["touches_for_1.3"] < 75
    gains = [p for p in result["parameters"] if p["name"] == "gain"]
    assert [p["sensor"] for p in gains] == ["s0", "s1", "s2", "s3", "s4", "s5"]
    for p in gains:
        assert p["limit"] == pytest.approx(p["value"] * 0.05 / np.sqrt(6), rel=1e-6)
        assert p["touches_for_half"] is None  # never
    assert {p["known"] for p in result["parameters"]} <= {"learnt", "partly", "as_drawn"}


def test_errors_of_the_drawing_with_and_without_units(touches, subskin):
    def prior(*options):
        ran = subskin("calibrate", "--blind", "finger.toml", "readings.csv", "--json", *options)
        assert ran.code == 0, ran.err
        return {(p["name"], p["sensor"]): p["prior"] for p in json.loads(ran.out)["parameters"]}

    found = prior("--gain-error", "10 %", "--depth-error", "0.1 mm", "--position-error", "0.03")
    assert found["gain", "s1"] == pytest.approx(0.1)
    assert found["depth", None] == pytest.approx(1e-4)
    assert found["y", "s1"] == pytest.approx(0.03 * 2e-3)
    found = prior("--fit", "gain,depth,offset,poisson", "--poisson-error", "0.02", "--offset-error", "1e-4")
    assert found["offset", "s0"] == pytest.approx(1e-4)
    assert found["poisson", None] == pytest.approx(0.02)


@pytest.mark.parametrize(
    ("options", "code", "said"),
    [
        (("--fit", "gain,origin"), 2, "origin"),
        (("--fit", "poisson"), 2, "--poisson-error"),
        (("--gain-error", "much"), 2, "--gain-error"),
        (("--gain-error", "0"), 2, "has to be > 0"),
        (("--depth-error", "3 Pa"), 2, "--depth-error"),
        (("--force-column", "force"), 2, "are unknown"),
        (("--figure", "learnt.doc"), 2, ".svg, .png or .pdf"),
        (("--rows", "0-2"), 1, "at least"),
        (("--half-width", "3 Pa"), 2, "--half-width"),
    ],
)
def test_bad_input_writes_nothing(touches, subskin, options, code, said):
    ran = subskin("calibrate", "--blind", "finger.toml", "readings.csv", "-o", "new.toml", *options)
    assert ran.code == code
    assert said in ran.err
    assert ran.out == ""
    assert not (touches / "new.toml").exists()


def test_options_of_blind_need_it(touches, subskin):
    ran = subskin("calibrate", "finger.toml", "readings.csv", "--depth-error", "5 %")
    assert ran.code == 2
    assert "--blind" in ran.err


def test_a_finger_without_noise(touches, subskin):
    (touches / "finger.toml").write_text(DRAWN.replace("noise = 5e-5", "noise = 0"))
    ran = subskin("calibrate", "--blind", "finger.toml", "readings.csv")
    assert ran.code == 2
    assert "noise" in ran.err


AREA = """\
[skin]
kind = "half_space"
young = "0.4 MPa"

[sensors]
layout = "grid"
shape = [2, 4]
pitch = "3 mm"
depth = "3 mm"
kind = "mean_pressure"
noise = 20

[locate]
friction = 0
search = [["-3 mm", "3 mm"], ["-6 mm", "6 mm"]]

[calibration]
origin = ["20 mm", "10 mm"]
turn = "10 deg"
"""


def test_sensors_on_an_area(folder, subskin):
    """Readings of a grid that differs from its drawing, to a file; its frame stays, for touches say nothing of it."""
    (folder / "area.toml").write_text(AREA)
    gains = "gain = [1.03, 0.95, 1.04, 0.98, 1.06, 0.99, 0.93, 1.02]\n"
    (folder / "real.toml").write_text(AREA.replace("noise = 20\n", "noise = 20\n" + gains))
    there = ("--position", "18.5..21.5 mm", "--across", "5.5..14.5 mm", "--force", "0.5..2 N", "--seed", 1)
    assert subskin("simulate", "real.toml", "-o", "touches.csv", "--count", 60, *there).code == 0
    ran = subskin("calibrate", "--blind", "area.toml", "touches.csv", "-o", "new.toml", "--fit", "gain,position")
    assert (ran.code, ran.err) == (0, "")
    for text in ("determine 20 of 24", "common shift", "common turn", "a moment of a touch", "-> new.toml"):
        assert text in ran.out, text
    new = load("new.toml")
    real = load("real.toml").finger.array
    assert np.ptp(np.log(np.asarray(new.finger.array.gain) / np.asarray(real.gain))) < 0.02
    assert new.origin.tolist() == [20e-3, 10e-3]
    assert new.turn == pytest.approx(np.deg2rad(10))
    ran = subskin("calibrate", "--blind", "area.toml", "touches.csv", "--half-width", "1 mm", "--rows", "0-4")
    assert ran.code == 1
    assert "at least" in ran.err
