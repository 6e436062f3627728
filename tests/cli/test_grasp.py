"""`subskin grasp`: its table, its files, and what it refuses."""

import csv
import json
import sys

import pytest

pytest.importorskip("mujoco")


def test_lifts_with_two_hands_and_all_files(folder, subskin):
    files = ("-o", "lifts.csv", "--figure", "lift.png", "--movie", "lift.gif")
    done = subskin("grasp", "--lifts", "2", "--hands", "cone,fixed", "--grip", "9 N", *files)
    assert done.code == 0
    assert "2 lifts" in done.out
    assert all(word in done.out for word in ("cone", "fixed", "dropped", "-> lifts.csv", "-> lift.gif", "-> lift.png"))
    rows = list(csv.DictReader((folder / "lifts.csv").read_text().splitlines()))
    assert [row["hand"] for row in rows] == ["cone", "cone", "fixed", "fixed"]
    assert all(row["dropped"] == "0" and 0 < float(row["slid"]) < 2e-3 for row in rows)
    assert (folder / "lift.gif").read_bytes()[:6] == b"GIF89a"
    assert (folder / "lift.png").stat().st_size > 10_000


def test_json_says_the_same(subskin):
    done = subskin("grasp", "--lifts", "1", "--hands", "force", "--seed", "3", "--json")
    found = json.loads(done.out)["hands"]["force"]
    assert done.code == 0
    assert found["lifts"] == 1
    assert found["dropped"] == 0
    assert 1.0 < found["grip"] < 1.5


def test_it_says_what_is_missing_where_mujoco_is(folder, subskin, monkeypatch):
    monkeypatch.setitem(sys.modules, "mujoco", None)
    done = subskin("grasp", "--lifts", "1")
    assert done.code == 2
    assert 'pip install "subskin[mujoco]"' in done.err
    assert len(done.err.splitlines()) == 1


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (("--hands", "claw"), "skin, force, cone, fixed"),
        (("--lifts", "0"), "1 to 100000"),
        (("--off", "5 N"), "--off"),
        (("--seed", "-1"), "--seed"),
        (("--workers", "0"), "--workers"),
        (("--movie", "lift.mp4"), ".gif"),
        (("--finger", "none.toml"), "none.toml"),
        (("--finger", "finger.toml"), "solved in a plane"),
    ],
)
def test_what_it_refuses(folder, subskin, arguments, said):
    done = subskin("grasp", *arguments)
    assert done.code == 2
    assert said in done.err
    assert len(done.err.splitlines()) <= 2
