"""Touches on a point from the command line: rows that say what presses, and sensors on an area."""

import json

import numpy as np
import pytest

import subskin as ss

SENSORS = """
[skin]
kind = "half_space"
young = 4e5
[sensors]
depth = "2 mm"
kind = "mean_pressure"
noise = 30
"""
ROW = SENSORS + 'count = 6\npitch = "2 mm"\n[locate]\nload = "either"\nbeside = "5 mm"\n'
AREA = SENSORS + 'layout = "grid"\nshape = [3, 3]\npitch = "2 mm"\n'


@pytest.fixture
def tables(tmp_path, monkeypatch):
    """row.toml, area.toml and what both read under the same touches, y.csv beside them; the current folder."""
    rng = np.random.default_rng(0)
    at = np.stack([rng.uniform(-1.5e-3, 1.5e-3, 60), rng.uniform(-1.5e-3, 1.5e-3, 60)], axis=-1)
    touch = ss.PointLoad(1.0, rng.uniform(0, 0.5, 60), rng.uniform(-3, 3, 60), at)
    for name, text in (("row", ROW), ("area", AREA)):
        (tmp_path / f"{name}.toml").write_text(text)
        file = ss.load(tmp_path / f"{name}.toml")
        columns = np.column_stack([at, file.finger.read(touch, rng)])
        np.savetxt(tmp_path / f"{name}.csv", columns, delimiter=",", comments="", header="y,z," + ",".join(file.names))
    monkeypatch.chdir(tmp_path)
    return tmp_path


def test_a_row_says_what_presses(tables, subskin):
    file, table = ss.load("row.toml"), ss.io.read_table("row.csv")
    assert "load = either" in repr(file)
    out = subskin("locate", "row.toml", "row.csv", "--truth", "y", "-o", "out.csv")
    assert out.code == 0
    assert "status ok" in out.out
    found, written = file.locate(table.readings(file.names)), ss.io.read_table("out.csv")
    np.testing.assert_allclose(written.numbers("position"), found.position, rtol=1e-12, equal_nan=False)
    np.testing.assert_allclose(written.numbers("point_probability"), found.point_probability, rtol=1e-9)
    y, z = (table.numbers(axis) for axis in "yz")
    sure = written.numbers("point_probability") > 0.5
    assert sure.mean() > 0.9
    assert np.abs(written.numbers("position") - y)[sure].max() < 0.2e-3
    assert subskin("locate", "row.toml", "row.csv", "--load", "point", "--beside", "4 mm", "-o", "p.csv").code == 0
    point = file.locate(table.readings(file.names), load="point", beside=4e-3)
    beside = ss.io.read_table("p.csv").numbers("beside")
    np.testing.assert_allclose(beside, point.beside, rtol=1e-12, equal_nan=False)
    assert np.median(np.abs(beside - np.abs(z))) < 0.05e-3
    line = subskin("locate", "row.toml", "row.csv", "--load", "line")
    assert line.code == 0
    assert "point_probability" not in line.out
    assert file.fit(table.readings(file.names), "line").shape == (60,)


def test_an_area_is_located(tables, subskin):
    out = subskin("locate", "area.toml", "area.csv", "--truth", "y,z", "-o", "out.csv")
    assert out.code == 0
    assert "all with a position" in out.out
    table, given = ss.io.read_table("out.csv"), ss.io.read_table("area.csv")
    file = ss.load("area.toml")
    found = file.locate(given.readings(file.names))
    np.testing.assert_allclose(table.numbers("position_z"), found.position[:, 1], rtol=1e-12)
    assert np.abs(table.numbers("position_z") - given.numbers("z")).max() < 0.3e-3
    error = np.hypot(*(table.numbers(f"position_{axis}") - given.numbers(axis) for axis in "yz"))
    np.testing.assert_allclose(table.numbers("error"), error, rtol=1e-9)
    assert np.median(error) < 0.1e-3


def test_touches_on_an_area_are_simulated(tables, subskin):
    where = ("--across", "-1..1 mm", "--angle", "0..30 deg", "--azimuth", "0..360 deg", "--force", "0.5..2 N")
    assert subskin("simulate", "area.toml", "--count", 30, *where, "-o", "touches.csv").code == 0
    table, file = ss.io.read_table("touches.csv"), ss.load("area.toml")
    column = {name: table.numbers(name) for name in ("position_y", "position_z", "force", "angle", "azimuth")}
    at = np.stack([column.pop("position_y"), column.pop("position_z")], axis=-1)
    assert np.abs(at[:, 1]).max() < 1e-3
    assert np.ptp(column["azimuth"]) > 3
    expected = file.finger.read(ss.PointLoad(**column, position=at))
    assert np.abs(table.readings(file.names) - expected).max() < 6 * 30.0
    located = subskin("locate", "area.toml", "touches.csv", "--truth", "position_y,position_z")
    assert located.code == 0
    assert "30" in located.out
    round_ = ("--contact", "round_hertz", "--half-width", "1 mm", "--grid", "--count", 9)
    assert subskin("simulate", "area.toml", *round_, "-o", "round.csv").code == 0
    at = ss.io.read_table("round.csv").numbers("position_y")
    np.testing.assert_allclose(at, np.repeat([-2e-3, 0.0, 2e-3], 3), atol=1e-12)


@pytest.mark.parametrize(
    ("command", "says"),
    [
        (("locate", "area.toml", "area.csv", "--truth", "y"), "two columns"),
        (("locate", "row.toml", "row.csv", "--truth", "y,z"), "one column"),
        (("locate", "area.toml", "area.csv", "--load", "line"), "solved in a plane"),
        (("locate", "area.toml", "area.csv", "--beside", "1 mm"), "sensors in a row"),
        (("simulate", "row.toml", "--recording", "--contact", "point"), "a recording of a row is of long contacts"),
        (("simulate", "row.toml", "--azimuth", "1 rad"), "the same at every z"),
        (("simulate", "area.toml", "--contact", "cone"), "needs one"),
        (("simulate", "area.toml", "--half-width", "1 mm"), "a point has none"),
    ],
)
def test_what_is_not_for_an_area_says_so(tables, subskin, command, says):
    out = subskin(*command)
    assert out.code == 2 or out.code == 1
    assert says in out.err
    assert "Fix:" in out.err
    assert len(out.err.splitlines()) == 1


def test_two_touches_at_once_on_an_area(tables, subskin):
    text = (tables / "area.toml").read_text().replace("[3, 3]", "[4, 4]")
    (tables / "pad.toml").write_text(text + "[calibration]\norigin = [0.01, 0.02]\n")
    file = ss.load("pad.toml")
    left, right = ss.PointLoad(1.0, 0.2, 0.5, (-2e-3, 1e-3)), ss.PointLoad(0.7, position=(2e-3, -5e-4))
    both = file.finger.read(left) + file.finger.read(right)
    np.savetxt("two.csv", [both, both], delimiter=",", comments="", header=",".join(file.names))
    out = subskin("locate", "pad.toml", "two.csv", "--touches", "2", "-o", "touches.csv")
    assert out.code == 0
    table = ss.io.read_table("touches.csv")
    assert table.numbers("touches").tolist() == [2, 2]
    for name, want in (
        ("position_y_1", 8e-3),
        ("position_z_1", 21e-3),
        ("position_y_2", 12e-3),
        ("position_z_2", 19.5e-3),
    ):
        np.testing.assert_allclose(table.numbers(name), want, atol=1e-5)
    np.testing.assert_allclose(table.numbers("force_2"), 0.7, rtol=1e-2)
    one = subskin("locate", "pad.toml", "two.csv")
    assert "two touches at once explain 2 of 2 unexplained frames that were looked at. Fix: --touches 2" in one.err
    np.savetxt("one.csv", [file.finger.read(left)], delimiter=",", comments="", header=",".join(file.names))
    assert "two touches" not in subskin("locate", "pad.toml", "one.csv").err
    shown = subskin("locate", "pad.toml", "two.csv", "--touches", "2").out
    assert "touches" in shown
    assert "force_2" in shown
    for options, words in (
        (("--touches", "4"), "from 1 to 3"), (("--touches", "2", "--truth", "y,z"), "that of one touch"),
        (("--touches", "2", "--outliers", "1"), "one of both"),
    ):  # fmt: skip
        bad = subskin("locate", "pad.toml", "two.csv", *options)
        assert bad.code != 0
        assert words in bad.err


def test_a_row_is_calibrated_by_points(tmp_path, monkeypatch, subskin):
    """`calibrate` finds what pressed, or is told; the file says it, and `locate` seeks both."""
    monkeypatch.chdir(tmp_path)
    rng, at = np.random.default_rng(0), np.linspace(-6e-3, 6e-3, 30)
    plain = ROW.replace('[locate]\nload = "either"\nbeside = "5 mm"\n', "")
    (tmp_path / "row.toml").write_text(plain)
    file = ss.load("row.toml")
    press = ss.PointLoad(1.0, position=np.stack([at, np.zeros(30)], axis=-1))
    np.savetxt(
        "row.csv", np.column_stack([at, file.finger.read(press, rng)]), delimiter=",", comments="",
        header="position," + ",".join(file.names),
    )  # fmt: skip
    ran = subskin("calibrate", "row.toml", "row.csv", "-o", "made.toml", "--fit", "gain,origin", "--json")
    assert ran.code == 0
    assert json.loads(ran.out)["load"] == "point"
    made = ss.load("made.toml")
    assert 'load = "point"' in made.text.partition("[calibration]")[2]
    out = subskin("locate", "made.toml", "row.csv", "--truth", "position", "-o", "out.csv")
    assert out.code == 0
    assert (ss.io.read_table("out.csv").numbers("point_probability") > 0.99).all()
    line = subskin("calibrate", "row.toml", "row.csv", "-o", "line.toml", "--load", "line", "--accept-misfit", "--json")
    assert json.loads(line.out)["load"] == "line"
    assert json.loads(line.out)["r2"] < json.loads(ran.out)["r2"]
    (tmp_path / "said.toml").write_text(plain + '[locate]\nload = "line"\n')
    said = subskin("calibrate", "said.toml", "row.csv", "-o", "said-made.toml", "--accept-misfit", "--json")
    assert json.loads(said.out)["load"] == "line"
    blind = subskin("calibrate", "--blind", "row.toml", "row.csv", "--load", "line")
    assert blind.code == 2
    assert "--load" in blind.err


def test_the_load_of_whatever_presses(tables, subskin):
    """Positions on the axes of the tables, torsion of an area, no rival; and what does not go with it."""
    for name, columns in (("row", {"position"}), ("area", {"position_y", "position_z", "torsion", "torsion_std"})):
        run = subskin("locate", f"{name}.toml", f"{name}.csv", "--load", "resultant", "-o", "loads.csv")
        assert run.code == 0, run.err
        table, file = ss.io.read_table("loads.csv"), ss.load(f"{name}.toml")
        assert columns <= set(table.columns)
        assert not [column for column in table.columns if column.startswith("second")]
    read = ss.io.read_table("area.csv")
    wanted = file.finger.resultant(np.stack([read.numbers(name) for name in file.names], axis=-1))
    np.testing.assert_allclose(table.numbers("force"), wanted.force, rtol=1e-9)
    np.testing.assert_allclose(table.numbers("torsion"), wanted.torsion, rtol=1e-9, atol=1e-18)
    for more in (("--touches", "2"), ("--outliers", "1")):
        run = subskin("locate", "area.toml", "area.csv", "--load", "resultant", *more)
        assert run.code != 0
        assert "Fix: leave it out" in run.err
