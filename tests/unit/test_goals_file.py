"""goals.toml: what is read, what is refused and how, and fingers written from it."""

from importlib.resources import files

import numpy as np
import pytest

import subskin as ss
from subskin.design.placement import Arrangement
from subskin.design.search import Row
from subskin.errors import FileError
from subskin.io.finger_file import parse_finger
from subskin.io.goals_file import finger_text, load_goals, parse_goals

GOALS = """\
title = "Test finger"
[touch]
force = ["20 N/m", "100 N/m"]
friction = 0.5
span = "6 mm"
[accuracy]
position = "0.1 mm"
angle = "3 deg"
[room]
count = [4, 5]
depth = ["1.5 mm", "3 mm"]
least_pitch = "1 mm"
longest_row = "8 mm"
[[sensor]]
name = "gauge"
kind = "normal_strain"
noise = 2e-4
[[sensor]]
name = "barometer"
kind = "mean_pressure"
noise = "0.03 kPa"
width = "0.6 mm"
largest = "80 kPa"
resolution = "5 Pa"
[[skin]]
name = "silicone"
young = "0.4 MPa"
[[skin]]
name = "thin"
kind = "layers"
[[skin.layers]]
young = "0.1 MPa"
poisson = 0.45
thickness = "5 mm"
[tolerances]
position = "0.05 mm"
gain = 0.01
[search]
depths = 3
seed = 7
"""


def test_quantities_arrive_in_si():
    goals = parse_goals(GOALS).goals
    assert (goals.touches.force, goals.strongest, goals.touches.friction) == (20.0, 100.0, 0.5)
    assert goals.touches.span == (-3e-3, 3e-3)
    assert goals.accuracy.position == pytest.approx(1e-4, rel=1e-12)
    assert goals.accuracy.angle == pytest.approx(np.deg2rad(3), rel=1e-12)
    assert goals.accuracy.feature is None
    assert goals.room.count == (4, 5)
    assert goals.room.depth == (1.5e-3, 3e-3)
    assert (goals.room.least_pitch, goals.room.longest_row) == (1e-3, 8e-3)
    gauge, barometer = goals.sensors
    assert gauge.transducer == ss.NormalStrain()
    assert (gauge.noise, gauge.error, gauge.largest) == (2e-4, 2e-4, np.inf)
    assert (barometer.noise, barometer.width, barometer.largest) == (30.0, 0.6e-3, 80e3)
    assert barometer.error == pytest.approx(np.sqrt(30**2 + 5**2 / 12), rel=1e-12)
    assert isinstance(goals.skins[0].skin, ss.HalfPlane)
    thin = goals.skins[1].skin
    assert isinstance(thin, ss.Layered)
    assert thin.thickness == 5e-3
    assert goals.tolerances == {"position": 0.05e-3, "gain": 0.01}
    assert (goals.effort.depths, goals.effort.pitches, goals.effort.seed) == (3, 30, 7)


def test_tolerances_are_stated_usual_or_none():
    start, end = GOALS.index("[tolerances]"), GOALS.index("[search]")
    without = GOALS[:start] + GOALS[end:]
    assert parse_goals(without).goals.tolerances is None
    assert parse_goals(without + "[tolerances]\n").goals.tolerances is None
    assert parse_goals(without + "[tolerances]\nnone = true\n").goals.tolerances == {}


def test_which_finger_is_judged_and_its_blind_spots():
    more = GOALS.replace('angle = "3 deg"', 'angle = "3 deg"\ncalibrated = "none"\nblind_spots = 0.05')
    accuracy = parse_goals(more).goals.accuracy
    assert (accuracy.calibrated, accuracy.blind_spots) == ("none", 0.05)
    assert (parse_goals(GOALS).goals.accuracy.calibrated, parse_goals(GOALS).goals.accuracy.blind_spots) == (
        "known",
        None,
    )


def test_one_force_is_both():
    goals = parse_goals(GOALS.replace('force = ["20 N/m", "100 N/m"]', 'force = "30 N/m"')).goals
    assert goals.touches.force == goals.strongest == 30.0


def test_a_mark_before_the_first_letter_does_no_harm(tmp_path):
    (tmp_path / "goals.toml").write_bytes(b"\xef\xbb\xbf" + GOALS.encode())
    assert load_goals(tmp_path / "goals.toml").goals.title == "Test finger"


def test_the_example_that_the_command_prints_is_read():
    text = files("subskin.io").joinpath("goals_example.toml").read_text(encoding="utf-8")
    goals = parse_goals(text).goals
    assert len(goals.sensors) == len(goals.skins) == 2


@pytest.mark.parametrize("sensor", [0, 1])
@pytest.mark.parametrize("skin", [0, 1])
def test_a_design_written_as_a_finger_is_the_same_finger(skin, sensor):
    file = parse_goals(GOALS)
    row = Row(skin, sensor, Arrangement("row", (4,)), 2e-3, 1.2e-3)
    wanted = file.goals.finger(row)
    text = finger_text(file, row, (-6e-3, 5e-3), ['why: "so"', "and = this"])
    written = parse_finger(text)
    positions = np.linspace(-3e-3, 3e-3, 7)
    np.testing.assert_array_equal(written.finger.receptive_field(positions), wanted.receptive_field(positions))
    for name in ("y", "noise", "low", "high", "resolution", "width"):
        np.testing.assert_array_equal(getattr(written.finger.array, name), getattr(wanted.array, name))
    assert written.options == {"friction": 0.5}
    assert written.search == (-6e-3, 5e-3)
    assert text.startswith('# why: "so"\n# and = this\n')


REFUSED = {
    "empty": ("", "it needs [touch]"),
    "no skin": (GOALS.replace("[[skin]]", "[[coat]]"), '"coat"'),
    "misspelt": (GOALS.replace("least_pitch", "least_pich"), 'did you mean "least_pitch"'),
    "unit": (GOALS.replace('span = "6 mm"', 'span = "6 N"'), "line 5: [touch] span"),
    "span": (GOALS.replace('span = "6 mm"', 'span = "-6 mm"'), "line 5: [touch] span"),
    "weakest": (GOALS.replace('"20 N/m", "100', '"200 N/m", "100'), "line 3: [touch] force"),
    "three forces": (GOALS.replace('"20 N/m", ', '"20 N/m", "30 N/m", '), "one value, or the two ends"),
    "no accuracy": (GOALS.replace('position = "0.1 mm"\nangle = "3 deg"', ""), "no accuracy is wanted"),
    "few": (GOALS.replace("[4, 5]", "[2, 5]"), "line 10: [room] count = [2, 5]"),
    "fractions": (GOALS.replace("[4, 5]", "[4.5, 5]"), "line 10"),
    "row": (GOALS.replace('"8 mm"', '"2 mm"'), "line 13: [room] longest_row"),
    "kind": (GOALS.replace("mean_pressure", "mean_presure"), 'did you mean "mean_pressure"'),
    "not linear": (GOALS.replace("normal_strain", "energy_density"), "line 16: [sensor]"),
    "noise": (GOALS.replace("noise = 2e-4", "noise = 0"), "line 17: [sensor] noise"),
    "noise unit": (GOALS.replace('"0.03 kPa"', '"0.03 mm"'), "line 21: [sensor] noise"),
    "same names": (GOALS.replace('"barometer"', '"gauge"'), 'two sensors called "gauge"'),
    "skin": (GOALS.replace('young = "0.4 MPa"', 'young = "-1 MPa"'), "line 27: [skin] young"),
    "layer": (GOALS.replace("poisson = 0.45", "poisson = 0.6"), "line 33: [skin.layers] poisson"),
    "tolerance": (GOALS.replace("gain = 0.01", "gian = 0.01"), 'did you mean "gain"'),
    "of a reading": (GOALS.replace("gain = 0.01", "noise = 0.01"), "no such tolerance"),
    "long": (GOALS.replace('span = "6 mm"', "span = 6"), "line 5: [touch] span = 6"),
    "negative": (GOALS.replace('position = "0.05 mm"', 'position = "-1 mm"'), "line 36: [tolerances] position"),
    "none and some": (GOALS.replace("gain = 0.01", "none = true"), "line 37: [tolerances] none"),
    "calibrated": (
        GOALS.replace('angle = "3 deg"', 'angle = 0.1\ncalibrated = "yes"'),
        "line 9: [accuracy] calibrated",
    ),
    "seed": (GOALS.replace("seed = 7", "seed = -1"), "[search] seed"),
    "friction": (GOALS.replace("friction = 0.5", "friction = -0.5"), "line 4: [touch] friction"),
    "unsure": (GOALS.replace('angle = "3 deg"', "angle = 0.1\nunsure = 2"), "line 9: [accuracy] unsure"),
}


@pytest.mark.parametrize("case", REFUSED)
def test_what_is_wrong_is_said_with_its_line(case):
    text, words = REFUSED[case]
    with pytest.raises(FileError) as caught:
        parse_goals(text)
    assert words in str(caught.value)
    assert str(caught.value).startswith("goals.toml")
