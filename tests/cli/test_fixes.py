"""What the command line says is to be done can be done on the command line, or in the file."""

import re

import pytest

import subskin as ss

HALF_SPACE = """\
[skin]
kind = "half_space"
young = "0.4 MPa"
[sensors]
layout = "grid"
shape = [3, 3]
pitch = "3 mm"
depth = "3 mm"
kind = "mean_pressure"
noise = 20
"""


def failed(run, *said):
    """The command ended with one line that says all of these, and nothing in Python."""
    assert run.code == 2
    assert len(run.err.strip().splitlines()) == 1
    for text in said:
        assert text in run.err
    assert not re.search(r"deg2rad|replace\(|finger\.\w+\(|_width=", run.err)


def test_a_flat_skin_needs_the_option_flat(subskin, folder):
    load = ("--width", "1 mm", "--height", "0.1 mm", "--force", "10 N/m")
    failed(subskin("compliance", "finger.toml", *load), '--flat "20 mm"')


@pytest.mark.parametrize("angle", ["0..30", "-30..30", "30"])
@pytest.mark.parametrize("text", [None, HALF_SPACE])
def test_degrees_without_a_unit(subskin, folder, angle, text):
    if text:
        (folder / "finger.toml").write_text(text)
    failed(subskin("simulate", "finger.toml", "--angle", angle), f'Fix: --angle="{angle} deg"', "in rad")


def test_angles_out_of_range(subskin, folder):
    failed(subskin("simulate", "finger.toml", "--angle", "-200..30 deg"), "-180 to 180 deg")
    failed(subskin("simulate", "finger.toml", "--angle", "-30 deg", "--contact", "point"), "--azimuth")
    failed(subskin("simulate", "finger.toml", "--angle", "4 rad", "--recording"), "-180 to 180 deg")


@pytest.mark.parametrize("position", ["-5..5mm", "-5e-3..5e-3", "-.005..5e-3", "-5mm..5mm"])
def test_a_value_may_begin_with_a_minus(subskin, folder, position):
    done = subskin("simulate", "finger.toml", "--position", position, "--count", "2", "--grid", "-o", "-")
    assert done.code == 0
    rows = done.out.splitlines()
    assert [float(row.split(",")[rows[0].split(",").index("position")]) for row in rows[1:]] == [-0.005, 0.005]


def test_a_response_in_place_is_taken_out_in_the_file(subskin, folder):
    """Without the line that the message names, the file is that of a finger that goes by the skin's field."""
    (folder / "area.toml").write_text(HALF_SPACE)
    at = ("--force", "0.5..1.5 N", "--angle", "0..30 deg", "--azimuth", "0..360 deg")
    subskin("simulate", "area.toml", "-o", "t.csv", "--count", "60", *at)
    columns = ("--force-column", "force", "--angle-column", "angle", "--azimuth-column", "azimuth")
    assert subskin("calibrate", "area.toml", "t.csv", "-o", "c.toml", "--response", "table", *columns).code == 0
    for command in ("fit", "decide", "pressure"):
        failed(subskin(command, "c.toml", "t.csv", "--rows", "0"), "remove the line response = ...")
    text = (folder / "c.toml").read_text()
    (folder / "c.toml").write_text("\n".join(line for line in text.splitlines() if not line.startswith("response")))
    assert ss.load("c.toml").finger.measured is None


def test_two_counts_are_a_grid(subskin, folder):
    text = (folder / "finger.toml").read_text()
    (folder / "finger.toml").write_text(text.replace("count = 4", "count = [3, 3]"))
    failed(subskin("locate", "finger.toml", "r.csv"), 'layout = "grid" and shape = [3, 3]', "line 6")


def test_a_load_cell_is_simulated_where_the_file_has_one(subskin, folder):
    """The force of the first press, as the cell tells it, is that at which the finger reads what it reads."""
    text = (folder / "finger.toml").read_text()
    cell = 'force = { column = "cell", unit = "N" }\n[touch]\nlength = "20 mm"\n'
    (folder / "finger.toml").write_text(text + cell)
    made = ("simulate", "finger.toml", "-o", "raw.csv", "--recording", "--count", "3", "--grid", "--force", "0.8 N")
    assert subskin(*made).code == 0
    assert subskin("segment", "finger.toml", "raw.csv", "-o", "presses.csv").code == 0
    file, presses = ss.load("finger.toml"), ss.io.read_table("presses.csv")
    forces = presses.numbers("force")
    assert ((forces > 30.0) & (forces < 40.0)).all()  # 0.8 N over 20 mm, less what the skin forgets
    load = ss.LineLoad(forces[0], position=presses.numbers("position")[0])
    read = presses.readings(file.names)[0] - file.finger.read(load) + file.finger.array.offset
    assert abs(read).max() < 10.0  # noise is 5, of a frame
