"""`subskin tolerances`: its tables, JSON, figure, and what it refuses."""

from __future__ import annotations

import json

import numpy as np
import pytest

from subskin.design import Touches, tolerance_budget
from subskin.io.finger_file import load

STRAIN = """\
[skin]
young = "0.4 MPa"

[sensors]
count = 6
pitch = "1.5 mm"
depth = "2 mm"
noise = 1e-4

[locate]
friction = 0.8
"""
FORCE = ("--force", "20 N/m", "--draws", "20")


@pytest.fixture
def strain(folder):
    (folder / "strain.toml").write_text(STRAIN)
    return folder


def test_tables_of_costs_of_needed_amounts_and_of_what_is_won_back(strain, subskin):
    done = subskin(
        "tolerances", "strain.toml", *FORCE, "--only", "gains,young", "--gains", "3 %", "--wanted-angle", "0.2 deg",
        "--calibrate", "known", "--fingers", "1", "--figure", "t.png",
    )  # fmt: skip
    assert done.code == 0, done.err
    assert "angle [deg]" in done.out
    assert "all at once" in done.out
    assert "how tight each has to be" in done.out
    assert "after self-calibration" in done.out
    assert "-> t.png" in done.out
    young = next(line for line in done.out.splitlines() if line.startswith(" young"))
    assert young.split()[:5] == ["young:", "Young's", "modulus", "10", "%"]
    assert young.split()[5:9] == ["0", "0", "0", "0"]
    assert (strain / "t.png").stat().st_size > 10_000


def test_json_is_the_budget(strain, subskin):
    done = subskin(
        "tolerances", "strain.toml", *FORCE, "--depth", "0.05 mm", "--poisson", "0.01", "--span", "4 mm", "--seed", "3",
        "--only", "depth,poisson,position,noise", "--wanted-position", "0.1 mm", "--json",
    )  # fmt: skip
    assert done.code == 0, done.err
    found = json.loads(done.out)
    finger = load("strain.toml").finger
    tolerances = {"position": 4e-5, "depth": 5e-5, "poisson": 0.01, "noise": 1e-4}
    budget = tolerance_budget(finger, Touches(20.0, 0.8, (-2e-3, 2e-3)), tolerances, draws=20, rng=3)
    for shown, row in zip(found["rows"], budget.rows, strict=True):
        assert shown["source"] == row.source
        assert shown["angle_rms"] == pytest.approx(row.angle_rms, rel=1e-9)
        assert shown["position_worst"] == pytest.approx(row.position_worst, rel=1e-9)
    assert found["together"]["amount"] is None
    assert found["total"]["force_rms"] == pytest.approx(budget.total.force_rms)
    for shown, needed in zip(found["needed"], budget.needed(position=1e-4), strict=True):
        assert shown["alone"] == (pytest.approx(needed.alone) if np.isfinite(needed.alone) else None)
        assert shown["shared"] == (pytest.approx(needed.shared) if np.isfinite(needed.shared) else None)


def test_zero_leaves_a_source_out(strain, subskin):
    done = subskin("tolerances", "strain.toml", *FORCE, "--only", "gain,depth", "--depth", "0", "--json")
    assert [row["source"] for row in json.loads(done.out)["rows"]] == ["gain"]


@pytest.mark.parametrize(
    ("more", "message"),
    [
        (("--force", "0 N/m"), "force = 0"),
        (("--force", "20 mm"), "N/m"),
        (("--force", "20 N/m", "--depth", "-1 mm"), "depth"),
        (("--force", "20 N/m", "--depth", "5 %"), "--depth"),
        (("--force", "20 N/m", "--thickness", "1 mm"), "thickness of a HalfPlane"),
        (("--force", "20 N/m", "--only", "thickness"), "--only thickness"),
        (("--force", "20 N/m", "--only", "deepness"), "--only deepness"),
        (("--force", "20 N/m", "--only", "position", "--calibrate", "daily"), "daily"),
        (("--force", "20 N/m", "--only", "position", "--draws", "0"), "draws = 0"),
        (("--force", "20 N/m", "--only", "position", "--wanted-angle", "0 deg"), "--wanted-angle 0 deg"),
        (("--force", "20 N/m", "--only", "position", "--span", "-1..30 mm"), "a narrower span"),
        (("--force", "20 N/m", "--figure", "t.txt"), "a figure is .svg"),
        (("--force", "20 N/m", "--figure", "none/t.png"), "none"),
    ],
)
def test_bad_input_is_one_message_and_no_file(strain, subskin, more, message):
    done = subskin("tolerances", "strain.toml", *more)
    assert done.code == 2
    assert message in done.err
    assert "Traceback" not in done.err
    assert {file.name for file in strain.iterdir()} == {"finger.toml", "strain.toml"}
