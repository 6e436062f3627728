"""`subskin check`: what it says of each kind of skin, and what it refuses."""

import json
import re
from functools import cache

import numpy as np
import pytest

import subskin as ss
from subskin.design import half_plane_error
from subskin.io.finger_file import load

from .. import _commands

FEW = ("--touches", "20")  # of each blind spot, where a test is about the half plane

SENSORS = """
[sensors]
count = 6
pitch = "2 mm"
depth = "2 mm"
gain = -1e5
offset = 1e5
"""
SKINS = {
    "flat": '[skin]\nyoung = "0.4 MPa"\n',
    "layer": '[skin]\nkind = "layers"\n[[skin.layers]]\nyoung = "0.4 MPa"\nthickness = "6 mm"\n',
    "stack": """[skin]
kind = "layers"
[[skin.layers]]
young = "2 MPa"
poisson = 0.48
thickness = "0.3 mm"
[[skin.layers]]
young = "40 kPa"
thickness = "5 mm"
bond = "frictionless"
[skin.base]
young = "10 GPa"
poisson = 0.3
""",
    "round": '[skin]\nkind = "round"\nyoung = "0.4 MPa"\nradius = "8 mm"\ncore_radius = "4 mm"\n',
}
SKINS = {name: f'[oriented]\ndate = "2026-11-27"\npresses = 2\n{text}' for name, text in SKINS.items()}


@pytest.fixture
def check(subskin, tmp_path, monkeypatch):
    """Runs `check` on one of the skins."""
    monkeypatch.chdir(tmp_path)
    for name, skin in SKINS.items():
        (tmp_path / f"{name}.toml").write_text(skin + SENSORS)
    return lambda name, *options: subskin("check", f"{name}.toml", *options)


@pytest.fixture(scope="module")
def plain(tmp_path_factory):
    """What `check` says of each skin, which is worked out once."""
    folder = tmp_path_factory.mktemp("plain")

    @cache
    def ran(name):
        file = folder / f"{name}.toml"
        file.write_text(SKINS[name] + SENSORS)
        return _commands.subskin("check", file, *FEW)

    return ran


def told(text):
    """The errors of place, force and angle that the table shows, row by row."""
    rows = re.findall(r"^ (half plane as drawn|half plane, calibrated|its own skin) +(.*)$", text, re.M)
    return {name: np.array(cells.split(), dtype=float) for name, cells in rows}


@pytest.mark.parametrize(
    ("name", "said"),
    [
        ("layer", "6 mm (0.4 MPa, nu 0.5) on a rigid base, read as a half plane"),
        ("stack", "0.3 mm (2 MPa, nu 0.48) and 5 mm (40 kPa, nu 0.5, sliding) on a half plane (10 GPa, nu 0.3)"),
        ("round", "a radius of 8 mm (0.4 MPa, nu 0.5) on a rigid core of 4 mm, read as a half plane"),
    ],
)
def test_every_kind_of_skin(check, plain, name, said):
    ran = plain(name)
    assert (ran.code, ran.err) == (0, "")
    assert said in ran.out
    found = half_plane_error(load(f"{name}.toml").finger)
    table = told(ran.out)
    for row, error in (("half plane as drawn", found.as_drawn), ("half plane, calibrated", found.calibrated)):
        s = error.summary()
        shown = [
            scale * s[key][k]
            for key, scale in (("position", 1e3), ("force", 100.0), ("angle", 180 / np.pi))
            for k in ("median", "worst")
        ]
        np.testing.assert_allclose(table[row], [*shown, 0, error.status["unexplained"]], rtol=0.051)
    np.testing.assert_array_equal(table["its own skin"], 0.0)
    assert f"{found.beneath[0]:.3f}" in ran.out
    assert f"{100 * found.normal:.1f} % under a normal touch, {100 * found.tangential:.1f} % under a drag" in ran.out
    assert f"to be {1e3 * found.depth:.3g} mm deep, not 2 mm" in ran.out
    assert "-> use the finger's own skin: the half plane misplaces touches by up to 0." in ran.out


def test_json(check):
    ran = check("round", "--json", "--half-width", "0.2 mm", "--snr", 50, *FEW)
    assert (ran.code, ran.err) == (0, "")
    data = json.loads(ran.out)
    finger = load("round.toml").finger
    found = half_plane_error(finger, half_width=2e-4, snr=50.0)
    assert (data["half_width"], data["touches"]) == (2e-4, 123)
    np.testing.assert_allclose(data["beneath"], found.beneath, rtol=1e-12)
    np.testing.assert_allclose(data["worst_reading"]["tangential"], found.tangential, rtol=1e-12)
    np.testing.assert_allclose(data["calibrated_depth"], found.depth, rtol=1e-12)
    for name in ("as_drawn", "calibrated", "own"):
        error = getattr(found, name)
        assert data["locate"][name]["status"] == error.status
        assert data["locate"][name]["unanswered"] == error.unanswered
        np.testing.assert_allclose(data["locate"][name]["angle"]["worst"], error.summary()["angle"]["worst"], rtol=1e-9)


class TestWhatIf:
    """A file with a half plane in it, tried as another skin."""

    def test_a_thickness(self, check, plain):
        assert check("flat", "--thickness", "6 mm", *FEW).out == plain("layer").out

    def test_a_radius_and_a_thickness(self, check, plain):
        assert check("flat", "--radius", "8 mm", "--thickness", "4 mm", *FEW).out == plain("round").out

    def test_a_radius_alone_leaves_half_of_it_to_the_core_and_says_so(self, check, plain):
        ran = check("flat", "--radius", "8 mm", *FEW)
        assert ran.out == plain("round").out
        assert "on a rigid core of 4 mm" in ran.out

    def test_thick_enough(self, check):
        ran = check("flat", "--thickness", "1 m", *FEW)
        assert (ran.code, "-> the half plane will do" in ran.out) == (0, True)
        position, angle = re.search(r"up to ([\d.]+) mm and turns them by ([\d.]+) deg", ran.out).groups()
        assert 0 < float(position) < 0.04
        assert 0 < float(angle) < 1.2

    def test_touches_too_wide_for_any_line_load(self, check):
        ran = check("layer", "--half-width", "4 mm", *FEW)
        assert (ran.code, "-> the touches are too wide for either" in ran.out) == (0, True)
        assert "no answer for" in ran.out

    def test_nothing_to_compare(self, check):
        ran = check("flat", *FEW)
        assert (ran.code, ran.err) == (0, "")
        assert "half plane" not in ran.out
        ran = check("flat", "--map", "error.png")
        assert (ran.code, ran.out) == (2, "")
        assert 'Fix: --thickness "6 mm", --radius "8 mm" or both' in ran.err


@pytest.mark.parametrize("kind", ["png", "svg", "pdf"])
def test_the_map(check, tmp_path, monkeypatch, kind):
    monkeypatch.setattr("subskin.design.half_plane.MAP_THICKNESS", (1.5, 3.0))
    monkeypatch.setattr("subskin.design.half_plane.MAP_RADIUS", (4.0, np.inf))
    whole = ss.design.half_plane_map
    asked = []

    def small(**options):
        asked.append({k: options[k] for k in ("poisson", "half_width")})
        return whole((1.5, 3.0), (4.0, np.inf), count=3, **options)

    monkeypatch.setattr("subskin.design.half_plane_map", small)
    ran = check("round", "--map", f"error.{kind}", "--half-width", "0.5 mm", *FEW)
    assert (ran.code, ran.err) == (0, "")
    assert ran.out.endswith(f"-> error.{kind}\n")
    start = {"png": b"\x89PNG", "svg": b"<?xml", "pdf": b"%PDF"}[kind]
    assert (tmp_path / f"error.{kind}").read_bytes().startswith(start)
    assert asked == [{"poisson": 0.5, "half_width": 0.25}]


def test_the_map_rings_this_finger_and_no_stack_of_another_kind(check, monkeypatch):
    rings = []
    monkeypatch.setattr("subskin.design.half_plane_map", lambda **_: {})
    monkeypatch.setattr("subskin.plot.half_plane_map_figure", lambda values, here: rings.append(here))
    monkeypatch.setattr("subskin.plot.save", lambda figure, path: None)
    for name in ("layer", "round", "stack"):
        assert check(name, "--map", "error.png", *FEW).code == 0
    np.testing.assert_allclose(rings[:2], [(3.0, np.inf), (2.0, 4.0)])
    assert rings[2] is None


@pytest.mark.parametrize(
    ("name", "options", "said"),
    [
        ("layer", ("--thickness", "6 mm"), "--thickness beside a skin that is no half plane"),
        ("flat", ("--thickness", "1 mm"), "the sensors have to lie in the skin, which is 0.001 m thick"),
        ("flat", ("--thickness", "0 mm"), "thickness = 0: has to be > 0"),
        ("flat", ("--thickness", "6 kg"), "--thickness"),
        ("flat", ("--radius", "8 mm", "--thickness", "7.9 mm"), "the core has to lie within the finger"),
        ("flat", ("--radius", "-8 mm"), "radius = -0.008: has to be > 0"),
        ("round", ("--half-width", "20 mm"), "it reaches round the finger"),
        ("layer", ("--half-width", "-1 mm"), "half_width = -0.001: has to be >= 0"),
        ("layer", ("--snr", "0"), "snr = 0: has to be > 0"),
        ("layer", ("--map", "error.bmp"), "a figure is .svg, .png or .pdf"),
        ("layer", ("--map", "no/error.png"), "there is no folder no"),
        ("missing", (), "there is no such file"),
    ],
)
def test_bad_input(check, tmp_path, name, options, said):
    before = sorted(p.name for p in tmp_path.iterdir())
    ran = check(name, *[f"{a}={b}" for a, b in zip(options[::2], options[1::2], strict=True)])
    assert (ran.code, ran.out) == (2, "")
    assert ran.err.startswith("subskin: error: ")
    assert ran.err.count("\n") == 1
    assert said in ran.err
    assert sorted(p.name for p in tmp_path.iterdir()) == before


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("count = 6", "count = 2", "2 sensors that respond: locate needs at least 3"),
        ("count = 6", 'count = 6\nkind = "energy_density"', "transducer EnergyDensity"),
        ('young = "0.4 MPa"', 'young = "0.4 MPa"\nplane = "stress"', 'plane = "stress"'),
    ],
)
def test_fingers_that_cannot_be_compared(check, tmp_path, old, new, said):
    (tmp_path / "odd.toml").write_text((SKINS["flat"] + SENSORS).replace(old, new))
    ran = check("odd", "--thickness", "6 mm")
    assert (ran.code, ran.out) == (2, "")
    assert said in ran.err


def test_blind_spots(check, tmp_path):
    (tmp_path / "few.toml").write_text(SKINS["flat"] + SENSORS.replace("count = 6", "count = 4") + "noise = 20\n")
    ran = check("few", "--snr", 100, "--touches", 200, "--json")
    assert (ran.code, ran.err) == (0, "")
    told, finger = json.loads(ran.out)["blind_spots"], load("few.toml").finger
    found = ss.blind_spots(finger, snr=100.0, count=200)
    assert told["sentence"] == found.sentence
    rows = {row["name"]: row for row in told["rows"]}
    assert rows["wide_roller"]["wrong"] == found["wide_roller"].wrong > 0.1
    text = check("few", "--snr", 100, "--touches", 200).out
    cells = [100 * getattr(found["wide_roller"], name) for name in ("ok", "wrong", "far", "force", "unexplained")]
    assert re.search("a wide roller, half width 0.8 to 2 depths +" + " +".join(f"{c:.1f}" for c in cells), text)
    ran = check("few", "--family", "hertz", "--json", *FEW)
    assert "wide_roller" not in {row["name"] for row in json.loads(ran.out)["blind_spots"]["rows"]}


def test_the_options_of_the_file_count(check, tmp_path):
    (tmp_path / "normal.toml").write_text(SKINS["flat"] + SENSORS + "noise = 20\n[locate]\nfriction = 0.0\n")
    told = json.loads(check("normal", "--touches", 50, "--json").out)["blind_spots"]
    assert (told["sensors"], told["spare"]) == (6, 4)
