"""Forces by a finger whose touches had no known force are loads of these touches, on every screen, and no newtons."""

from __future__ import annotations

import json

import numpy as np
import pytest
from matplotlib.text import Text

import subskin as ss
from subskin.errors import FileError
from subskin.io import parse_finger, read_table

from .._commands import subskin

FILE = """\
[skin]
young = "0.4 MPa"

[sensors]
count = 5
pitch = "3 mm"
depth = "4 mm"
noise = 1e-5

[locate]
friction = 0

[touch]
length = "10 mm"
"""
SKIN = ss.HalfPlane(ss.Material(young=0.4e6))
POSITIONS = np.linspace(-7e-3, 7e-3, 29)
DRAWN = parse_finger(FILE).finger
TOUCHES = DRAWN.read(ss.LineLoad(20.0, position=POSITIONS), np.random.default_rng(0))


@pytest.fixture(scope="module")
def rig(tmp_path_factory):
    """A folder with a finger calibrated on touches of no known force, and one of known force."""
    folder = tmp_path_factory.mktemp("relative")
    (folder / "drawn.toml").write_text(FILE)
    rows = np.column_stack([POSITIONS, np.full(29, 20.0), TOUCHES])
    names = "position,force,s0,s1,s2,s3,s4"
    np.savetxt(folder / "touches.csv", rows, delimiter=",", header=names, comments="")
    for name, more in (("relative", []), ("newtons", ["--force-column", "force"])):
        out = folder / f"{name}.toml"
        done = subskin("calibrate", folder / "drawn.toml", folder / "touches.csv", "-o", out, *more)
        assert (done.code, done.err) == (0, "")
    return folder


def test_the_finger_remembers(rig):
    relative, newtons = ss.load(rig / "relative.toml"), ss.load(rig / "newtons.toml")
    assert relative.finger.relative
    assert not newtons.finger.relative
    assert "multiples of the load of the touches" in repr(relative)
    assert "multiples" not in repr(newtons)
    assert relative.with_finger(relative.finger, 0.0).finger.relative
    # only a new gain changes what forces are
    for force, fit, expected in ((None, ("gain", "origin"), True), (20.0, ("gain", "origin"), False)):
        assert ss.calibrate(DRAWN, TOUCHES, POSITIONS, fit=fit, force=force).finger.relative is expected
    assert ss.calibrate(relative.finger, TOUCHES, POSITIONS, fit=("origin",)).finger.relative


@pytest.mark.parametrize("load", ["line", "point", "either"])
def test_answers_name_their_unit(load):
    space = ss.HalfSpace(ss.Material(young=0.4e6))
    point = ss.PointLoad(1.0, position=(1e-3, 0.0))
    for relative in (False, True):
        finger = ss.Finger(SKIN if load == "line" else space, DRAWN.array, relative=relative)
        readings = finger.read(ss.LineLoad(20.0, position=1e-3) if load == "line" else point)
        found = finger.locate(np.stack([readings, readings]), load=load, friction=0)
        one = found.point if load == "either" else found
        assert one.force_unit == ("touch loads" if relative else "N/m" if load == "line" else "N")
        for text in (repr(one), repr(one[1]), repr(one.load), one._repr_html_()):
            assert ("touch loads" in text) is relative
            assert not (relative and " N" in text.replace("NO_", "").replace("NaN", ""))
        assert ("force_unit" in found.to_dict()) is (relative or load == "either")
        if load == "either":  # a line or a point: each frame says
            assert found.to_dict()["force_unit"].tolist() == 2 * ["touch loads" if relative else "N"]


def test_so_do_pressures_slips_and_figures(rig):
    from subskin import plot

    file = ss.load(rig / "relative.toml")
    readings = read_table(rig / "touches.csv").readings(file.names)[10:13]
    found = file.locate(readings)
    pressed = ss.pressure_map(file.finger, readings)
    slip = ss.decide.slip(file.locate(readings, friction=1.0), 0.5)
    for text in (repr(pressed), repr(slip)):
        assert "touch loads" in text
        assert "N/m" not in text
    labels = [axes.get_ylabel() for axes in plot.pressure_figure(pressed[0]).axes]
    assert any("touch loads / m" in label for label in labels)
    assert not any("Pa]" in label for label in labels)
    assert plot.slip_figure(slip, frame=0).axes[0].get_xlabel() == "normal force $N$ [touch loads]"
    drawn = found[0].plot()
    words = " ".join(artist.get_text() for artist in drawn.findobj(Text))
    assert "touch loads" in words
    assert "N/m" not in words


@pytest.mark.parametrize("ending", ["csv", "parquet"])
def test_tables_of_the_command_line_say_so(rig, ending):
    for name, relative in (("relative", True), ("newtons", False)):
        out = rig / f"{name}.{ending}"
        for command in (("locate",), ("fit", "hertz"), ("decide",), ("pressure",)):
            first = [command[0], rig / f"{name}.toml", rig / "touches.csv"]
            more = ["--family", command[1]] if command[1:] else []
            target = ["--totals", out] if command[0] == "pressure" else ["-o", out]
            done = subskin(*first, *more, *target)
            assert done.code == 0, done.err
            columns = read_table(out).columns
            assert ("force_unit" in columns) is relative
            assert ("newtons" in columns) is (not relative and command[0] != "pressure")
            assert command[0] == "decide" or ("touch loads" in subskin(*first, *more).out) is relative
            told = json.loads(subskin(*first, *more, "--json").out)
            told = told.get("columns", told.get("totals"))
            assert ("force_unit" in told) is relative


def test_limits_in_newtons_are_refused(rig):
    text = (rig / "relative.toml").read_text().replace("friction = 0", "friction = 0\nnormal_force = {}")
    with pytest.raises(FileError, match="multiples of the load of the touches"):
        parse_finger(text.format('["1 N/m", "2 N/m"]'))
    file = parse_finger(text.format("[0.1, 2.0]"))
    assert file.normal_force == (0.1, 2.0)
    assert "normal force 0.1 to 2 touch loads" in repr(file)


def test_one_force_of_all_touches_may_be_stated(rig):
    limits = "friction = 0\nnormal_force = ['0.2 N', '0.2 N']"  # 20 N/m over 10 mm
    (rig / "stated.toml").write_text(FILE.replace("friction = 0", limits))
    done = subskin("calibrate", rig / "stated.toml", rig / "touches.csv", "-o", rig / "known.toml")
    assert "every touch carries 20 N/m" in done.out
    known, newtons = ss.load(rig / "known.toml"), ss.load(rig / "newtons.toml")
    assert not known.finger.relative
    np.testing.assert_array_equal(known.finger.array.gain, newtons.finger.array.gain)
    column = ("--force-column", "force")
    assert "every touch" not in subskin("calibrate", rig / "stated.toml", rig / "touches.csv", *column).out


def test_recordings_write_no_newtons(rig):
    from subskin.live.recording.layout import About

    for name, newtons in (("relative", False), ("newtons", True)):
        about = About.for_finger(ss.load(rig / f"{name}.toml"), ["s0"], 0.0, "")
        assert about.newtons is newtons
        told = ["time: double"]
        assert About.of(about.metadata(told), told, "x").newtons is newtons
