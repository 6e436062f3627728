"""`subskin design`: its files, its report, stopping and going on, what it refuses."""

from __future__ import annotations

import contextlib
import csv
import json
import re
from html.parser import HTMLParser

import numpy as np
import pytest

import subskin as ss
from subskin.design.placement import study_at_depth
from subskin.io.finger_file import load

from .. import _commands

GOALS = """\
title = "A <finger> & more"
[touch]
force = ["20 N/m", "100 N/m"]
friction = 0.5
span = "6 mm"
feature = "3 mm"
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
[[skin]]
name = "silicone"
young = "0.4 MPa"
[tolerances]
position = "0.02 mm"
[search]
depths = 3
pitches = 4
touches = 1000
keep = 1
"""


QUICK = re.sub(r"\nfeature.*", "", GOALS).replace('position = "0.02 mm"', "none = true").replace("[4, 5]", "[5, 5]")
"""Nothing that takes long to look at closely."""


@pytest.fixture
def goals(folder):
    (folder / "goals.toml").write_text(QUICK)
    return folder


@pytest.fixture(scope="module")
def searched(tmp_path_factory):
    """A folder in which two searches ended, one after another program's."""
    folder = tmp_path_factory.mktemp("design")
    (folder / "goals.toml").write_text(GOALS)
    (folder / "two").mkdir()
    (folder / "two" / "finger_7.toml").write_text("old")
    (folder / "two" / "finger_mine.toml").write_text("mine")
    with contextlib.chdir(folder):
        runs = (
            _commands.subskin("design", "goals.toml", "-o", "one"),
            _commands.subskin("design", "goals.toml", "-o", "two", "--workers", 1, "--json"),
        )
    said = [line for done in runs for line in done.err.splitlines() if "min so far" not in line]
    assert ([done.code for done in runs], said) == ([0, 0], [])
    return folder, *runs


class Page(HTMLParser):
    """What a page is made of, and what it would fetch."""

    def __init__(self, text):
        super().__init__()
        self.open, self.fetched, self.pictures, self.words = [], [], 0, []
        self.feed(text)

    def handle_starttag(self, tag, attributes):
        if tag not in ("meta", "img", "link", "br"):
            self.open.append(tag)
        for name, value in attributes:
            if name in ("src", "href") and not value.startswith(("data:", "#")):
                self.fetched.append(value)
        self.pictures += tag == "img"

    def handle_endtag(self, tag):
        assert self.open.pop() == tag

    def handle_data(self, data):
        self.words.append(data)


def test_fingers_table_and_report(searched):
    folder, done, _ = searched
    assert "Not met: distance that two touches need" in done.out
    page = Page((folder / "one" / "report.html").read_text())
    text = " ".join(page.words)
    assert page.open == []
    assert page.fetched == []
    assert page.pictures >= 6
    assert "A <finger> & more: a design" in text
    assert "Why finger 1" in text
    assert "No finger within the limits meets every goal" in text
    with (folder / "one" / "designs.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert len(rows) == 3 * (4 + 3)  # the widest pitch, 8/3 mm, has room for four sensors only
    assert {row["skin"] for row in rows} == {"silicone"}
    # its sentence on the first finger, beside the standard errors that locate itself gives for such touches
    numbers = r"For finger 1 it is (\S+) mm and (\S+)° on average, (\S+) mm and (\S+)° at its worst"
    said = [float(number) for number in re.search(numbers, text.replace("\xa0", " ")).groups()]
    position, angle = np.meshgrid(np.linspace(-3e-3, 3e-3, 101), np.arctan(0.5) * np.linspace(-1, 1, 41))
    finger = load(folder / "one" / "finger_1.toml").finger
    found = finger.locate(finger.read(ss.LineLoad(20.0, angle, position)), friction=0.5)
    std = found.std[..., [0, 2]] * [1e3, 180 / np.pi]
    assert said[:2] == pytest.approx(std.mean(axis=(0, 1)), rel=0.02)
    assert said[2:] == pytest.approx(std.max(axis=(0, 1)), rel=0.08)  # there the profile is no parabola


def test_the_fingers_are_files_like_any_other(searched, subskin, monkeypatch):
    folder, _, done = searched
    monkeypatch.chdir(folder)
    best = json.loads(done.out)["fingers"][0]
    again = subskin("simulate", "two/finger_1.toml", "-o", "readings.csv", "--count", "20", "--seed", "1")
    assert again.code == 0, again.err
    found = subskin("locate", "two/finger_1.toml", "readings.csv", "-o", "found.csv")
    assert found.code == 0, found.err
    text = (folder / "two" / "finger_1.toml").read_text()
    assert f"count = {best['count']}" in text
    assert f'depth = "{best["depth"] * 1e3:.9g} mm"' in text
    assert best["reasons"][0] in text


def test_the_same_goals_give_the_same_bytes(searched):
    for file in ("finger_1.toml", "designs.csv", "report.html"):
        assert (searched[0] / "one" / file).read_bytes() == (searched[0] / "two" / file).read_bytes(), file


def test_a_finger_of_an_earlier_search_does_not_stay(searched):
    assert not (searched[0] / "two" / "finger_7.toml").exists()
    assert (searched[0] / "two" / "finger_mine.toml").read_text() == "mine"


def test_stopped_and_gone_on(goals, subskin, monkeypatch):
    """By Ctrl-C in the third of six rows."""
    (goals / "long.toml").write_text(QUICK.replace("depths = 3", "depths = 6"))
    rows, seen = goals / "out" / "search", []

    def stopped(*arguments, **more):
        seen.append(arguments)
        if len(seen) == 3:
            raise KeyboardInterrupt
        return study_at_depth(*arguments, **more)

    with monkeypatch.context() as patched:
        patched.setattr("subskin.design.search.grid.study_at_depth", stopped)
        done = subskin("design", "long.toml", "-o", "out", "--no-report", "--workers", 1)
    kept = {file: file.stat().st_mtime_ns for file in rows.glob("*.npz")}
    assert done.code == 130
    assert 2 <= len(kept) < 6
    said = f"subskin: stopped; {len(kept)} rows are kept in out/search, the same command goes on from there\n"
    assert done.err == said
    assert not (goals / "out" / "designs.csv").exists()
    assert subskin("design", "long.toml", "-o", "out", "--no-report").code == 0
    assert {file: file.stat().st_mtime_ns for file in kept} == kept  # not written again
    assert subskin("design", "long.toml", "-o", "whole", "--no-report").code == 0
    for file in ("finger_1.toml", "designs.csv"):
        assert (goals / "out" / file).read_bytes() == (goals / "whole" / file).read_bytes()


def test_a_damaged_row_is_worked_out_again(goals, subskin):
    assert subskin("design", "goals.toml", "-o", "out", "--no-report").code == 0
    whole = (goals / "out" / "designs.csv").read_bytes()
    for file in (goals / "out" / "search").glob("*.npz"):
        file.write_bytes(file.read_bytes()[:50])
    assert subskin("design", "goals.toml", "-o", "out", "--no-report").code == 0
    assert (goals / "out" / "designs.csv").read_bytes() == whole


def test_goals_that_cannot_be_met_are_said_not_to_be(goals, subskin):
    (goals / "goals.toml").write_text(QUICK.replace('"0.1 mm"\nangle', '"0.1 um"\nangle'))
    done = subskin("design", "goals.toml", "-o", "out", "--no-report")
    assert done.code == 0
    assert "Not met: error of the position" in done.out
    assert "met  " not in done.out.split("\n")[4]
    assert not (goals / "out" / "report.html").exists()


def test_the_example_is_printed(subskin):
    done = subskin("design", "--example")
    assert done.code == 0
    assert done.out.startswith("# What a finger is wanted for")


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ((), "a goals.toml is needed"),
        (("nothing.toml",), "there is no such file"),
        (("finger.toml",), 'table "sensors": no such table is known'),
        (("goals.toml", "-o", "goals.toml"), "it is the same file as the goals"),
        (("goals.toml", "--workers", "0"), "--workers 0"),
        (("goals.toml", "--seed", "-3"), "seed = -3"),
    ],
)
def test_bad_input_is_refused_in_one_line(goals, subskin, arguments, message):
    before = sorted(goals.iterdir())
    done = subskin("design", *arguments)
    assert done.code == 2
    assert message in done.err
    assert done.err.count("\n") == 1
    assert sorted(goals.iterdir()) == before
