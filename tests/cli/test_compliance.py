"""`subskin compliance`: what it prints, its figure, and what it refuses."""

from __future__ import annotations

import json

import pytest

ROUND = """\
[skin]
kind = "round"
young = "0.4 MPa"
radius = "8 mm"
core_radius = "4 mm"

[sensors]
count = 8
pitch = "0.5 mm"
depth = "0.8 mm"
noise = 2e-5
"""
PARTICLE = ("--width", "0.8 mm", "--height", "30 um")
FEW = ("--young", "0.05..2 MPa", "--moduli", "3")
TWO = (*FEW[:-1], "2")


@pytest.fixture
def tip(folder):
    (folder / "round.toml").write_text(ROUND)
    return folder


def test_regimes_and_a_recommendation(tip, subskin):
    done = subskin("compliance", "round.toml", *PARTICLE, "--force", "40 N/m", *FEW, "--figure", "c.png")
    assert done.code == 0
    assert "too soft" in done.out
    assert "too stiff" in done.out
    assert "-> E = 0.316 MPa" in done.out
    assert (tip / "c.png").stat().st_size > 10_000


def test_json_says_the_same(tip, subskin):
    done = subskin("compliance", "round.toml", *PARTICLE, "--force", "20..40 N/m", *TWO, "--json")
    found = json.loads(done.out)
    assert done.code == 0
    assert found["regime"][0][1] == ["tip", "tip", "tip"]
    assert found["force"][0] == pytest.approx(20.0)
    assert found["thickness"] == pytest.approx([4e-3])
    assert found["best"]["young"] in found["young"]


@pytest.mark.parametrize(
    ("more", "message"),
    [
        (("--force", "0 N/m"), "has to be > 0"),
        (("--force", "40 mm"), "N/m"),
        (("--force", "40 N/m", "--moduli", "0"), "--moduli 0"),
        (("--force", "40 N/m", "--moduli", "2", "--figure", "c.png"), "three or more"),
        (("--force", "40 N/m", "--figure", "c.txt"), "a figure is .svg"),
        (("--force", "40 N/m", "--thickness", "9 mm"), "thickness = 0.009 m"),
    ],
)
def test_bad_input_is_one_message_and_no_file(tip, subskin, more, message):
    done = subskin("compliance", "round.toml", *PARTICLE, *more)
    assert done.code == 2
    assert message in done.err
    assert "Traceback" not in done.err
    assert {file.name for file in tip.iterdir()} == {"finger.toml", "round.toml"}


def test_a_flat_skin_needs_a_flat_that_ends(tip, subskin):
    done = subskin("compliance", "finger.toml", *PARTICLE, "--force", "40 N/m")
    assert done.code == 2
    assert "flat without end" in done.err
