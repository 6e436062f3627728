"""Sensors on an area from a recording to located touches: simulate, segment, calibrate, locate."""

import json

import numpy as np
import pytest

import subskin as ss

SENSORS = """\
[skin]
kind = "half_space"
young = "0.4 MPa"

[sensors]      # as drawn
layout = "grid"
shape = [3, 3]
pitch = "2 mm"
depth = "2 mm"
kind = "mean_pressure"
noise = 30

[locate]
friction = 0
"""
RECORDING = """
[recording]
sensors = ["a", "b", "c", "d", "e", "f", "g", "h", "i"]
unit = "kPa"
position = [{ column = "x", unit = "mm" }, { column = "y", unit = "1/1000 mm" }]
press = { column = "z", unit = "1/320 mm" }
"""
MOUNTED = """
[calibration]
origin = ["20 mm", "10 mm"]
turn = "10 deg"
"""
ORIGIN, TURN = np.array([20e-3, 10e-3]), np.deg2rad(10)


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    """Fingers as drawn and as mounted, and what the mounted one reads of touches; the folder."""
    from .. import _commands

    folder = tmp_path_factory.mktemp("area")
    (folder / "drawn.toml").write_text(SENSORS)
    (folder / "real.toml").write_text(SENSORS.replace('"2 mm"\nkind', '"2.2 mm"\nkind') + MOUNTED)
    (folder / "raw.toml").write_text(SENSORS + RECORDING)
    span = ("--position", "16.5..23.5 mm", "--across", "6.5..13.5 mm")
    args = ("--force", "1.5 N", "--count", 50, "--spread", 0.2, *span, "-o", folder / "touches.csv")
    assert _commands.subskin("simulate", folder / "real.toml", *args).code == 0
    return folder


@pytest.fixture
def folder(made, monkeypatch):
    monkeypatch.chdir(made)
    return made


def touches(name="touches.csv", sensors="s"):
    table = ss.io.read_table(name)
    names = [f"s{i}" for i in range(9)] if sensors == "s" else list(sensors)
    return table.readings(names), np.stack([table.numbers(f"position_{axis}") for axis in "yz"], axis=-1)


def nodes_of(response):
    """Positions of a table's nodes, but for those at its ends."""
    return np.stack(np.meshgrid(response.y[1:-1], response.z[1:-1], indexing="ij"), axis=-1)


def same_response(one, other, share):
    """Equal to within a share of the largest number; nothing is missing, and not all is nothing."""
    largest = np.abs(other).max()
    assert largest > 0
    assert np.isfinite(one).all()
    assert np.abs(one - other).max() < share * largest


def test_what_is_simulated_lies_on_the_axes_of_the_touches(folder, subskin):
    lean = ("--angle", "20 deg", "--azimuth", "50 deg", "--count", 5, "--force", "1 N", "-o", "lean.csv")
    assert subskin("simulate", "real.toml", *lean).code == 0
    readings, at = touches("lean.csv")
    cos, sin = np.cos(TURN), np.sin(TURN)
    own = (at - ORIGIN) @ np.array([[cos, -sin], [sin, cos]])
    load = ss.PointLoad(1.0, np.deg2rad(20), np.deg2rad(50) - TURN, own)
    assert np.abs(readings - ss.load("real.toml").finger.read(load)).max() < 6 * 30
    found = subskin("locate", "real.toml", "lean.csv", "-o", "found.csv")
    assert found.code == 0
    free = ss.load("real.toml").finger.locate(readings)  # the file says friction = 0
    assert np.isnan(ss.io.read_table("found.csv").numbers("azimuth_std")).all()
    (folder / "free.toml").write_text((folder / "real.toml").read_text().replace("friction = 0", "friction = 1"))
    assert subskin("locate", "free.toml", "lean.csv", "-o", "free.csv").code == 0
    table = ss.io.read_table("free.csv")
    azimuth, error = table.numbers("azimuth"), table.numbers("azimuth_std")
    np.testing.assert_allclose(azimuth, free.load.azimuth + TURN, rtol=1e-9, equal_nan=False)
    assert error.max() < 0.5
    assert (np.abs(azimuth - np.deg2rad(50)) < 5 * error).all()


def test_a_file_is_calibrated_as_python_does(folder, subskin):
    """Every second touch; the others are located on the axes of the touches, as the object that Python has does."""
    out = subskin("calibrate", "drawn.toml", "touches.csv", "-o", "calibrated.toml", "--every", 2, "--json")
    assert out.code == 0, out.err
    said, (readings, at) = json.loads(out.out), touches()
    found = ss.calibrate(ss.load("drawn.toml").finger, readings[::2], at[::2])
    assert found.finger.measured is None
    np.testing.assert_array_equal(said["origin"], found.origin)
    assert [(p["name"], p["value"]) for p in said["parameters"]] == [(p.name, p.value) for p in found.parameters]
    assert said["r2_held_out"] == found.evaluate(readings[1::2], at[1::2]).r2 > 0.999
    file = ss.load("calibrated.toml")
    assert "# as drawn" in file.text
    np.testing.assert_allclose(file.origin, ORIGIN, atol=0.1e-3)
    assert file.turn == pytest.approx(found.turn, rel=1e-8) == pytest.approx(TURN, abs=0.02)
    mine, theirs = file.locate(readings), found.finger.locate(readings, friction=0)
    std = np.sqrt(np.diagonal(theirs.load.covariance, axis1=-2, axis2=-1)[:, :2])
    off = np.abs(mine.position - theirs.position) / std
    assert np.median(off) < 1e-4
    assert off.max() < 0.2  # a digit of the file may change the climb, which ends where little is left to gain
    np.testing.assert_array_equal(mine.status, theirs.status)
    rest = ("--every", 2, "--skip-used", "--truth", "position_y,position_z", "-o", "located.csv")
    assert subskin("locate", "calibrated.toml", "touches.csv", *rest, "--figure", "truth.svg").code == 0
    table = ss.io.read_table("located.csv")
    assert len(table) == 25
    written = np.stack([table.numbers("position_y"), table.numbers("position_z")], axis=-1)
    np.testing.assert_array_equal(written, file.on_touches(mine.position[1::2]))
    assert np.nanmedian(table.numbers("error")) < 0.05e-3
    assert (folder / "truth.svg").stat().st_size > 1000


def test_how_alike_gains_are_may_be_said(folder, subskin):
    for name in ("real", "drawn"):
        text = (folder / f"{name}.toml").read_text()
        (folder / f"noisy-{name}.toml").write_text(text.replace("noise = 30", "noise = 2000"))
    span = ("--position", "16.5..23.5 mm", "--across", "6.5..13.5 mm")
    args = ("--force", "1.5 N", "--count", 12, "--spread", 0.2, *span, "-o", "noisy.csv")
    assert subskin("simulate", "noisy-real.toml", *args).code == 0
    gains = {}
    for error in ("1 %", "25 %", None):
        more = () if error is None else ("--gain-error", error)
        out = subskin("calibrate", "noisy-drawn.toml", "noisy.csv", "-o", "alike.toml", "--json", *more)
        assert out.code == 0, out.err
        found = json.loads(out.out)["parameters"]
        gains[error] = np.array([p["value"] for p in found if p["name"] == "gain"])
    off = {error: np.median(np.abs(gain / np.median(gain) - 1)) for error, gain in gains.items()}
    assert off["1 %"] < 0.2 * off["25 %"]
    np.testing.assert_array_equal(gains[None], gains["25 %"])
    out = subskin("calibrate", "noisy-drawn.toml", "noisy.csv", "-o", "alike.toml", "--gain-error", "0 %")
    assert out.code == 2
    assert "--gain-error 0 %: has to be > 0" in out.err


def test_forces_and_columns_have_names(folder, subskin):
    loads = ("--force-column", "force", "--angle-column", "angle", "--azimuth-column", "azimuth")
    named = ("--every", 3, "--position-column", "position_y,position_z", "--fit", "gain,origin,turn", *loads)
    out = subskin("calibrate", "real.toml", "touches.csv", "-o", "gains.toml", *named)
    assert out.code == 0, out.err
    assert "multiples of the touches" not in out.out
    gain = np.asarray(ss.load("gains.toml").finger.array.gain)
    assert 0.75 < gain.min() < gain.max() < 1.25
    only = subskin("calibrate", "gains.toml", "touches.csv", "-o", "o.toml", "--fit", "origin", "--rows", "0-9", *loads)
    assert only.code == 0, only.err
    turn = ss.load("gains.toml").turn
    assert ss.load("o.toml").turn == pytest.approx(turn)  # where it is not fitted it is that of the file
    assert turn == pytest.approx(TURN, abs=0.02)


def test_a_raw_recording_is_cut_into_presses(folder, subskin):
    where = ("--origin", "5 mm, -3 mm", "--position", "3..7 mm", "--across", "-5..-1 mm", "--force", "1 N")
    raw = ("--recording", "--count", 9, "--drift", 50, "--rate", "20 Hz", "--relaxation", 0.1)
    assert subskin("simulate", "raw.toml", "-o", "raw.csv", *raw, *where).code == 0
    assert set(ss.io.read_table("raw.csv").columns) == {*"abcdefghi", "time", "x", "y", "z"}
    assert subskin("segment", "raw.toml", "raw.csv", "-o", "presses.csv").code == 0
    readings, at = touches("presses.csv", "abcdefghi")
    expected = np.stack(np.meshgrid([3, 5, 7], [-5, -3, -1], indexing="ij"), axis=-1).reshape(-1, 2)
    np.testing.assert_allclose(1e3 * at, expected, atol=1e-9)
    model = ss.load("raw.toml").finger.read(ss.PointLoad(1.0, position=at - [5e-3, -3e-3]))
    assert np.corrcoef(readings.ravel(), model.ravel())[0, 1] > 0.999
    shown = subskin("segment", "raw.toml", "raw.csv")
    assert "y [mm]" in shown.out
    assert "z [mm]" in shown.out


@pytest.fixture(scope="module")
def table(made):
    """table.toml: calibrated without a model, of every second touch on a lattice."""
    from .. import _commands

    grid = ("--grid", "--count", 121, "--position", "17..23 mm", "--across", "7..13 mm", "--force", "1 N")
    assert _commands.subskin("simulate", made / "real.toml", *grid, "-o", made / "lattice.csv").code == 0
    (made / "magnets.toml").write_text(SENSORS + 'normal_force = ["1 N", "1 N"]\n' + MOUNTED)
    args = ("--response", "table", "--every", 2, "-o", made / "table.toml")
    out = _commands.subskin("calibrate", made / "magnets.toml", made / "lattice.csv", *args)
    assert out.code == 0, out.err
    return out


def test_a_table_without_a_model_locates(folder, subskin, table):
    assert "61 touches used" in table.out
    assert "every touch carries 1 N (normal_force under [locate])" in table.out
    rest = ("--every", 2, "--skip-used", "--truth", "position_y,position_z", "--json")
    out = subskin("locate", "table.toml", "lattice.csv", *rest)
    assert out.code == 0, out.err
    score = json.loads(out.out)["against_truth"]
    assert score["ok"]["count"] > 0.7 * 60
    assert score["ok"]["median"] < 0.05e-3
    file, (readings, at) = ss.load("table.toml"), touches("lattice.csv")
    force = file.locate(readings).load.components[:, 0]
    np.testing.assert_array_equal(force[np.isfinite(force)], 1.0)
    from subskin.measured import MeasuredResponse

    cos, sin = np.cos(TURN), np.sin(TURN)
    own = (at - ORIGIN) @ np.array([[cos, -sin], [sin, cos]])
    made = MeasuredResponse.from_touches(readings[::2], own[::2])
    same_response(file.finger.measured.values, made.values, 1e-6)


def test_a_table_of_touches_that_lean_knows_drags(folder, subskin):
    """Loads are those of the touches' axes; the table's are the finger's."""
    from subskin.measured import MeasuredResponse

    (folder / "free.toml").write_text((folder / "real.toml").read_text().replace("friction = 0", "friction = 1"))
    lean = ("--angle", "0..25 deg", "--azimuth", "0..360 deg", "--force", "1..2 N", "--count", 60)
    assert subskin("simulate", "free.toml", *lean, "-o", "leaning.csv").code == 0
    named = ("--force-column", "force", "--angle-column", "angle", "--azimuth-column", "azimuth")
    out = subskin("calibrate", "free.toml", "leaning.csv", "--response", "table", *named, "-o", "drags.toml")
    assert out.code == 0, out.err
    assert "same force" not in out.out
    (readings, at), given = touches("leaning.csv"), ss.io.read_table("leaning.csv")
    force, angle, azimuth = (given.numbers(name) for name in ("force", "angle", "azimuth"))
    cos, sin = np.cos(TURN), np.sin(TURN)
    back = np.array([[cos, -sin], [sin, cos]])
    drag = (force * np.sin(angle))[:, None] * np.stack([np.cos(azimuth), np.sin(azimuth)], axis=-1) @ back
    forces = np.column_stack([force * np.cos(angle), drag])
    made = MeasuredResponse.from_touches(readings, (at - ORIGIN) @ back, components=forces)
    file = ss.load("drags.toml")
    same_response(file.finger.measured.values, made.values, 1e-5)
    true = ss.load("free.toml").finger.receptive_field(nodes_of(made))
    off = file.finger.measured.values[1:-1, 1:-1] - true
    off, size = (np.sqrt(np.mean(np.square(part), axis=(0, 1, 2))) for part in (off, true))
    assert (off < size * [0.05, 0.25, 0.25]).all()


def test_a_table_mounted_elsewhere_needs_three_touches(folder, subskin, table):
    """Its response moves with it; positions come out on the axes of the touches."""
    text = (folder / "real.toml").read_text().replace('["20 mm", "10 mm"]', '["30 mm", "5 mm"]')
    (folder / "moved.toml").write_text(text)
    where = ("--position", "28..32 mm", "--across", "3..7 mm", "--count", 12, "--force", "1 N")
    assert subskin("simulate", "moved.toml", *where, "-o", "again.csv").code == 0
    rows = ("--rows", "0,4,8", "--fit", "origin")
    out = subskin("calibrate", "table.toml", "again.csv", "-o", "today.toml", *rows)
    assert out.code == 0, out.err
    file = ss.load("today.toml")
    np.testing.assert_allclose(file.origin, [30e-3, 5e-3], atol=0.1e-3)
    np.testing.assert_array_equal(file.finger.measured.values, ss.load("table.toml").finger.measured.values)
    readings, at = touches("again.csv")
    assert np.nanmedian(np.abs(file.on_touches(file.locate(readings).position) - at)) < 0.1e-3


@pytest.mark.parametrize(
    ("command", "says"),
    [
        (("calibrate", "drawn.toml", "touches.csv", "--position-column", "position_y"), "two columns, y and z"),
        (("calibrate", "drawn.toml", "touches.csv", "--response", "table", "--fit", "gain"), "--response table"),
        (("calibrate", "free.toml", "touches.csv", "--response", "table"), "friction is not 0"),
        (("calibrate", "magnets.toml", "lattice.csv", "--response", "table", "-o", "-"), "a file beside the finger"),
        (("calibrate", "drawn.toml", "touches.csv", "--blind", "--response", "table"), "known positions"),
        (("calibrate", "drawn.toml", "touches.csv", "--blind", "--azimuth-column", "azimuth"), "unknown"),
        (("simulate", "real.toml", "--origin", "5 mm"), "y and z are needed"),
        (("locate", "lost.toml", "touches.csv"), "needs this file beside it"),
    ],
)
def test_what_cannot_be_is_said(folder, subskin, table, command, says):
    (folder / "free.toml").write_text((folder / "real.toml").read_text().replace("friction = 0", "friction = 1"))
    (folder / "lost.toml").write_text((folder / "table.toml").read_text())
    out = subskin(*command)
    assert out.code in (1, 2)
    assert says in out.err
    assert "Fix:" in out.err
    assert len(out.err.splitlines()) == 1


def test_a_raw_stream_is_located_while_its_offsets_drift(folder, subskin):
    """Frame by frame, --tare takes units and offsets from the file."""
    (folder / "stream.toml").write_text(SENSORS + RECORDING + MOUNTED)
    raw = ("--recording", "--count", 4, "--drift", 10, "--rate", "20 Hz", "--relaxation", 0.05, "--force", "1 N")
    assert subskin("simulate", "stream.toml", "-o", "stream.csv", *raw).code == 0
    out = subskin("locate", "stream.toml", "stream.csv", "--tare", "6", "-o", "tared.csv")
    assert out.code == 0, out.err
    given, found = ss.io.read_table("stream.csv"), ss.io.read_table("tared.csv")
    held = given.numbers("z") > 0.99 * given.numbers("z").max()
    error = [
        1e-3 * given.numbers("x") - found.numbers("position_y"),
        1e-6 * given.numbers("y") - found.numbers("position_z"),
    ]
    assert np.isfinite(error[0][held]).mean() > 0.9
    assert np.nanmedian(np.hypot(*error)[held]) < 0.05e-3
