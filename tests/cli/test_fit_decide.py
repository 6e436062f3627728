"""`subskin fit` and `subskin decide`: a contact's width and kind from a table of readings."""

import json

import numpy as np
import pytest

import subskin as ss
from subskin.io.tables import read_table, write_table

SIX = """\
[skin]
young = "0.4 MPa"

[sensors]
count = 6
pitch = "1 mm"
depth = "2 mm"
noise = 2e-5
"""
FINGER = ss.Finger(
    ss.HalfPlane(ss.Material(young=0.4e6)), ss.SensorArray.line(count=6, pitch=1e-3, depth=2e-3, noise=2e-5)
)
TOUCHES = (
    ss.Hertz(40.0, 0.3, 0.4e-3, half_width=1.6e-3),
    ss.Wedge(40.0, 0.3, 0.4e-3, half_width=0.5e-3),
    ss.Hertz(40.0, -0.2, -0.4e-3, half_width=1.2e-3),
)


@pytest.fixture
def table(folder):
    """finger.toml of six sensors, and r.csv: three touches and a frame of nothing."""
    (folder / "finger.toml").write_text(SIX)
    frames = np.array([*(FINGER.read(touch) for touch in TOUCHES), np.zeros(6)])
    write_table("r.csv", {f"s{i}": frames[:, i] for i in range(6)})
    return folder


def columns(path, *names):
    read = read_table(path)
    return [read.numbers(name) for name in names]


class TestFit:
    def test_writes_what_finger_fit_finds(self, subskin, table):
        ran = subskin("fit", "finger.toml", "r.csv", "-o", "f.csv")
        assert (ran.code, ran.err) == (0, "")
        assert "f.csv" in ran.out
        found = FINGER.fit([FINGER.read(touch) for touch in TOUCHES], "hertz")
        position, width, low, high, chi2 = columns(
            "f.csv", "position", "half_width", "half_width_low", "half_width_high", "residual"
        )
        np.testing.assert_allclose(position[[0, 2]], found.position[[0, 2]], rtol=1e-9)
        np.testing.assert_allclose(width[[0, 2]], [1.6e-3, 1.2e-3], rtol=1e-5)
        assert (low[[0, 2]] < width[[0, 2]]).all()
        assert (width[[0, 2]] < high[[0, 2]]).all()
        np.testing.assert_allclose(chi2[:3], found.residual, rtol=1e-6, atol=1e-6)
        lines = (table / "f.csv").read_text().splitlines()
        statuses = [line.split(",")[10] for line in lines[1:]]
        assert statuses == ["ok", "ok", "ok", "no_contact"]  # a narrow wedge reads like a narrower roller

    def test_a_contact_that_sticks_in_its_middle(self, subskin, table):
        frame = FINGER.read(ss.PartialSlip(40.0, 0.2, 0.4e-3, half_width=1.6e-3, friction=0.5))
        write_table("stuck.csv", {f"s{i}": frame[i : i + 1] for i in range(6)})
        for text, stick in (("0.5", 0.5), ("0.3..0.7", (0.3, 0.7))):
            assert subskin("fit", "finger.toml", "stuck.csv", "--stick", text, "-o", "f.csv").code == 0
            angle, std = columns("f.csv", "angle", "angle_std")
            found = FINGER.fit(frame, stick=stick)
            np.testing.assert_allclose([angle[0], std[0]], [found.angle, found.std[2]], rtol=1e-6)
            assert angle[0] == pytest.approx(0.2, abs=2e-3)  # the frame is without noise
            assert 0.0 < std[0] < 0.1
            plain = FINGER.fit(frame)
            assert not abs(plain.angle - 0.2) < 2e-3  # a contact that slides is another
        ran = subskin("fit", "finger.toml", "stuck.csv", "--stick", "-1")
        assert ran.code != 0
        assert "stick" in ran.err

    def test_round_contacts_on_an_area(self, subskin, folder):
        ends = '[["-4 mm", "4 mm"], ["-4 mm", "4 mm"]]'
        grid = 'layout = "grid"\nshape = [3, 3]\npitch = "2 mm"\ndepth = "2 mm"\nnoise = 1e-4\n'
        skin = '[skin]\nkind = "half_space"\nyoung = "0.4 MPa"\n'
        (folder / "area.toml").write_text(f"{skin}\n[sensors]\n{grid}\n[locate]\nsearch = {ends}\n")
        tip = ["--contact", "round_hertz", "--half-width", "1.6 mm", "--count", "6", "--seed", "1"]
        assert subskin("simulate", "area.toml", "-o", "t.csv", *tip).code == 0
        ran = subskin("fit", "area.toml", "t.csv", "-o", "f.csv", "--figure", "f.png")
        assert (ran.code, ran.err) == (0, "")
        assert (folder / "f.png").stat().st_size > 1000
        assert "no moment about the normal is fitted" in ran.out
        long = ("--contact", "hertz", "--half-width", "1 mm")
        assert "same at every z" in subskin("simulate", "area.toml", "--moment", "0.2 N*mm", *long).err
        (true,) = (read_table("t.csv").numbers(name) for name in ["position_z"])
        z, std = columns("f.csv", "position_z", "position_z_std")
        assert (np.abs(z - true) < 4 * std).all()
        assert std.max() < 0.1e-3
        low, high = columns("f.csv", "half_width_low", "half_width_high")
        assert ((low < 1.6e-3) & (1.6e-3 < high)).sum() >= 5
        ran = subskin("fit", "area.toml", "t.csv", "--family", "hertz")
        assert ran.code != 0
        assert "round_hertz" in ran.err
        balls = ("--kind", "ball=round_hertz: 1..2.5 mm", "--kind", "none=none")
        ran = subskin("decide", "area.toml", "t.csv", *balls, "-o", "k.csv")
        assert (ran.code, ran.err) == (0, "")
        assert "ball" in ran.out
        (z,) = columns("k.csv", "position_z")
        assert (np.abs(z - true) < 0.3e-3).all()

    def test_patches(self, subskin, folder):
        """On the axes of the tables, on which a finger may be turned: then the sides change their names."""
        grid = 'layout = "grid"\nshape = [4, 4]\npitch = "4 mm"\ndepth = "2.5 mm"\nnoise = 2e-4\n'
        skin = '[skin]\nkind = "half_space"\nyoung = "0.4 MPa"\n'
        more = {"force": [4.0, 4.0], "angle": 0.2, "half_widths": (4e-3, 3e-3), "turn": 0.3}
        pads = ss.Patch(position=(1e-3, 0.5e-3), slopes=(100.0, -40.0, 0.0), **more)
        for turn in (0.0, 0.25, 0.5 * np.pi, 2.6):
            text = f'{skin}\n[sensors]\n{grid}[calibration]\nturn = "{turn} rad"\n'
            (folder / "area.toml").write_text(text)
            frames = ss.io.load("area.toml").finger.read(pads, np.random.default_rng(1))
            write_table("p.csv", {f"s{i}": frames[:, i] for i in range(16)})
            ran = subskin("fit", "area.toml", "p.csv", "--family", "patch", "--pressure", "linear", "-o", "f.csv")
            assert ran.code == 0, ran.err
            y, z, there, along, across = (
                columns("f.csv", name)[0] for name in ("half_width_y", "half_width_z", "turn", "slope_y", "slope_z")
            )
            std = columns("f.csv", "half_width_y_std", "slope_y_std")
            assert (np.abs(there) <= np.pi / 4).all()
            # the rectangle, and its pressure, on the axes of the tables
            steep = (along + 1j * across) * np.exp(1j * there)
            assert np.abs(steep - (100 - 40j) * np.exp(1j * (0.3 + turn))).max() < 40
            quarter = round((0.3 + turn) / (np.pi / 2))
            np.testing.assert_allclose([y, z][quarter % 2], 4e-3, atol=0.2e-3)
            np.testing.assert_allclose(there, 0.3 + turn - quarter * np.pi / 2, atol=0.15)
            if turn == 0.0:
                straight = std
            elif quarter % 2:  # that of the other side
                assert not np.allclose(std, straight, rtol=0.05)
        ran = subskin("locate", "area.toml", "p.csv", "--load", "patch", "--json")
        assert json.loads(ran.out)["status"]["unexplained"] == 2  # an even one does not explain them
        ran = subskin("fit", "area.toml", "p.csv", "--family", "patch", "--turn", "10..-10 deg")
        assert "swap them" in ran.err
        kinds = ("--kind", "pad=patch: 1..5 mm, 1..5 mm", "--kind", "tip=cone: 0.2..1 mm")
        even = ss.io.load("area.toml").finger.read(ss.Patch(position=(1e-3, 0.5e-3), **more), np.random.default_rng(2))
        write_table("e.csv", {f"s{i}": even[:, i] for i in range(16)})
        assert (
            json.loads(subskin("decide", "area.toml", "e.csv", *kinds, "--json").out)["columns"]["kind"] == ["pad"] * 2
        )

    def test_the_direction_of_an_edge(self, subskin, folder):
        grid = 'layout = "grid"\nshape = [4, 4]\npitch = "2 mm"\ndepth = "2 mm"\nnoise = 1e-4\n'
        skin, turn = '[skin]\nkind = "half_space"\nyoung = "0.4 MPa"\n', '[calibration]\nturn = "20 deg"\n'
        (folder / "area.toml").write_text(f"{skin}\n[sensors]\n{grid}\n{turn}")
        finger = ss.io.load("area.toml").finger
        at = np.linspace(-2e-3, 2e-3, 30)[:, None] * [np.cos(0.9), np.sin(0.9)]
        felt = finger.measure(ss.PointLoad(force=1 / 30, position=at)).sum(axis=0)
        write_table("e.csv", {f"s{i}": np.array([felt[i], 0.0]) for i in range(16)})
        kinds = ("--kind", "box=edge: 0..0.5 mm, 1..4 mm", "--kind", "tip=cone: 0.2..1 mm")
        ran = subskin("decide", "area.toml", "e.csv", *kinds, "--json")
        told = json.loads(ran.out)["columns"]
        assert told["kind"] == ["box", "no contact"]
        assert told["direction"][0] == pytest.approx(0.9 + np.deg2rad(20), abs=0.01)
        assert told["half_length"][0] == pytest.approx(2e-3, rel=0.05)
        assert 0 < told["direction_std"][0] < 0.01
        assert told["direction"][1] is None
        ran = subskin("decide", "area.toml", "e.csv")
        assert "1.4 times as long as wide" in ran.out
        assert "direction" in subskin("decide", "area.toml", "e.csv", *kinds).out
        for wrong in ("box=edge: 0..0.5 mm", "tip=cone: 0.2..1 mm, 1..2 mm"):
            assert "half lengths" in subskin("decide", "area.toml", "e.csv", "--kind", wrong).err

    def test_family_and_width(self, subskin, table):
        ran = subskin("fit", "finger.toml", "r.csv", "--family", "wedge", "--width", "0.1..1 mm", "--json")
        data = json.loads(ran.out)
        assert (data["family"], data["frames"]) == ("wedge", 4)
        assert data["columns"]["half_width"][1] == pytest.approx(0.5e-3, rel=1e-4)
        assert data["columns"]["half_width"][0] is None
        assert data["status"] == {"ok": 1, "ambiguous": 0, "no_contact": 1, "unexplained": 2, "incomplete": 0}

    def test_table_for_people(self, subskin, table):
        ran = subskin("fit", "finger.toml", "r.csv")
        assert "half_width_low" in ran.out
        assert "0.0016" in ran.out
        one = subskin("fit", "finger.toml", "r.csv", "--rows", "2", "-o", "-")
        assert len(one.out.splitlines()) == 2
        assert "unexplained" in one.err

    def test_four_sensors_have_none_to_spare(self, subskin, table):
        (table / "finger.toml").write_text(SIX.replace("count = 6", "count = 4"))
        assert "no reading to spare" in subskin("fit", "finger.toml", "r.csv").out

    def test_figure(self, subskin, table):
        assert subskin("fit", "finger.toml", "r.csv", "--figure", "f.svg").code == 0
        assert "position along the skin" in (table / "f.svg").read_text() or (table / "f.svg").stat().st_size > 5000


class TestDecide:
    def test_names_and_probabilities(self, subskin, table):
        ran = subskin("decide", "finger.toml", "r.csv", "-o", "k.csv")
        assert (ran.code, ran.err) == (0, "")
        lines = [line.split(",") for line in (table / "k.csv").read_text().splitlines()]
        kinds = ["p_line", "p_vertex", "p_flat_side", "p_round_side", "p_two_touches", "p_none_of_these"]
        assert lines[0][:8] == ["row", "kind", *kinds]
        assert [line[1] for line in lines[1:]] == ["round side", "vertex", "round side", "no contact"]
        said = ss.decide.contact_type(FINGER, [FINGER.read(touch) for touch in TOUCHES])
        shares = np.stack(columns("k.csv", *kinds), axis=-1)
        np.testing.assert_allclose(shares[:3], said.probability, atol=1e-9)
        assert np.isnan(shares[3]).all()

    def test_says_the_edges_of_the_usual_kinds(self, subskin, table):
        out = subskin("decide", "finger.toml", "r.csv").out
        assert "vertex: any contact narrower than a roller of half width 0.8 mm" in out
        assert "to a roller of half width 4.8 mm" in out

    def test_kinds_of_one_s_own(self, subskin, table):
        kinds = ("--kind", "edge=wedge: 0.2..0.7 mm", "--kind", "big can = hertz: 1..3 mm * 2", "--sure", "0.99")
        data = json.loads(subskin("decide", "finger.toml", "r.csv", *kinds, "--json").out)
        assert data["kinds"] == {"edge": 1, "big can": 2}
        assert data["columns"]["kind"] == ["big can", "edge", "big can", "no contact"]
        people = subskin("decide", "finger.toml", "r.csv", *kinds).out
        assert "0.2 to 0.7" in people
        assert "big can" in people

    def test_cannot_tell(self, subskin, table):
        (table / "finger.toml").write_text(SIX.replace("count = 6", "count = 4"))
        free = [x for n in ("wedge", "punch", "hertz") for x in ("--kind", f"{n}={n}: 0.05..2.4 mm")]
        ran = subskin("decide", "finger.toml", "r.csv", *free)
        assert "cannot tell" in ran.out

    def test_figure(self, subskin, table):
        assert subskin("decide", "finger.toml", "r.csv", "--figure", "k.png").code == 0
        assert (table / "k.png").read_bytes()[:4] == b"\x89PNG"


@pytest.mark.parametrize(
    ("arguments", "seen"),
    [
        (("fit", "finger.toml", "r.csv", "--width", "2 mm .. 1 mm"), "swap"),
        (("fit", "finger.toml", "r.csv", "--family", "line", "--width", "1 mm"), "line"),
        (("fit", "finger.toml", "missing.csv"), "missing.csv"),
        (("fit", "finger.toml", "r.csv", "--figure", "f.txt"), "--figure"),
        (("fit", "finger.toml", "r.csv", "-o", "no/such/folder/f.csv"), "folder"),
        (("decide", "finger.toml", "r.csv", "--kind", "edge"), "NAME=FAMILY"),
        (("decide", "finger.toml", "r.csv", "--kind", "edge=wedge"), "largest half width"),
        (("decide", "finger.toml", "r.csv", "--kind", "edge=cone: 1 mm"), "cone"),
        (("decide", "finger.toml", "r.csv", "--kind", "edge=wedge: 1 mm * two"), "NAME=FAMILY"),
        (("decide", "finger.toml", "r.csv", "--kind", "edge=wedge: 1 kg"), "kg"),
        (("decide", "finger.toml", "r.csv", "--sure", "2"), "sure"),
    ],
)
def test_bad_input_is_told_in_one_line(subskin, table, arguments, seen):
    before = sorted(p.name for p in table.iterdir())
    ran = subskin(*arguments)
    assert ran.code == 2
    assert ran.err.startswith("subskin: error: ")
    assert len(ran.err.splitlines()) == 1
    assert seen in ran.err
    assert sorted(p.name for p in table.iterdir()) == before
