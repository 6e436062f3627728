"""`subskin check` of layers that are bent to a round tip."""

from __future__ import annotations

import json
from dataclasses import asdict

import pytest

import subskin as ss
from subskin.design.tip import tip_error
from subskin.io.finger_file import parse_finger

FILE = """
[skin]
kind = "layers"
[[skin.layers]]
young = "0.4 MPa"
thickness = "4 mm"

[sensors]
layout = "grid"
shape = [4, 4]
pitch = "2 mm"
depth = "1.6 mm"
kind = "mean_pressure"

[tip]
radius = "20 mm"
"""


def test_the_file_and_the_command(subskin, tmp_path):
    assert parse_finger(FILE).tip == (20e-3, None)
    with pytest.raises(ss.errors.FileError, match=r"radius = .-20 mm"):
        parse_finger(FILE.replace('"20 mm"', '"-20 mm"'))
    (tmp_path / "f.toml").write_text(FILE)
    ran = subskin("check", tmp_path / "f.toml", "--tip-map", tmp_path / "m.png")
    assert ran.code == 0
    assert ran.err.count("\n") == 1  # that nobody has pressed where it is known: `subskin orient`
    assert "which way round" in ran.err
    found = tip_error(parse_finger(FILE).finger, 20e-3)
    assert f"misplace touches by up to {1e3 * found.position:.2g} mm" in " ".join(ran.out.split())
    assert (tmp_path / "m.png").stat().st_size > 10_000
    data = json.loads(subskin("check", tmp_path / "f.toml", "--json").out)
    assert data["tip"] == {**asdict(found), "kinds": list(found.kinds)}
    (tmp_path / "g.toml").write_text(FILE.replace('[tip]\nradius = "20 mm"\n', ""))
    ran = subskin("check", tmp_path / "g.toml", "--tip-map", tmp_path / "n.png")
    assert ran.code != 0
    assert "[tip] radius" in ran.err
