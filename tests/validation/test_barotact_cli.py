"""The main job on a recording of a real skin, from the command line alone.

Four barometers 6 mm apart beneath silicone, 60 presses 0.5 mm apart over 30 mm; the row ends 11 mm before they do.
"""

import json

import numpy as np
import pytest

from subskin.cli import main
from subskin.io.finger_file import load
from subskin.io.tables import read_table

FINGER = """\
[skin]
young = "0.5 MPa"     # only scales the gains
poisson = 0.5         # start of the fit

[sensors]
count = 4
pitch = "6 mm"
depth = "5 mm"        # start of the fit
kind = "normal_strain"

[locate]
friction = 0          # presses are normal
search = ["-10.5 mm", "10.5 mm"]

[recording]
sensors = ["Sensor_0", "Sensor_1", "Sensor_2", "Sensor_3"]
unit = "Pa"
time = { column = "time", unit = "s" }
position = { column = "x", unit = "1e-3 mm" }
press = { column = "z", unit = "1/320 mm" }
"""
FIT = "gain,depth,origin,poisson,width,position"


@pytest.fixture(scope="module")
def folder(shared, tmp_path_factory):
    """Presses cut from the recording, and the finger calibrated on every second one."""
    raw = shared / "data" / "barotact" / "test_full_20230706_175400.csv"
    if not raw.is_file():
        pytest.skip("needs the recording in ../shared/data/barotact, which does not ship with the project")
    folder = tmp_path_factory.mktemp("barotact")
    (folder / "finger.toml").write_text(FINGER)
    assert main(["segment", f"{folder}/finger.toml", str(raw), "-o", f"{folder}/presses.csv"]) == 0
    files = [f"{folder}/{name}" for name in ("finger.toml", "presses.csv", "calibrated.toml")]
    assert main(["calibrate", *files[:2], "-o", files[2], "--every", "2", "--fit", FIT]) == 0
    return folder


@pytest.fixture
def command(capsys):
    def run(*arguments):
        assert main([*map(str, arguments), "--json"]) == 0
        return json.loads(capsys.readouterr().out)

    return run


def test_sixty_presses(folder):
    table = read_table(folder / "presses.csv")
    assert len(table) == 60
    np.testing.assert_allclose(table.numbers("position"), 0.5e-3 * np.arange(60), atol=1e-9)
    np.testing.assert_allclose(table.numbers("depth"), 6e-3, rtol=1e-3)
    held = table.numbers("t_end") - table.numbers("t_start")
    assert (np.abs(held - 8.0) < 0.1).all()
    readings = table.readings([f"Sensor_{i}" for i in range(4)])
    np.testing.assert_array_equal(readings.argmax(axis=0), [0, 11, 23, 35])  # 6 mm apart, the first at 0 or before
    std = np.stack([table.numbers(f"Sensor_{i}_std") for i in range(4)])
    assert std.max() < 40 < 1e-2 * readings.max()


def test_held_out_presses_are_explained(folder, command):
    data = command("calibrate", folder / "finger.toml", folder / "presses.csv", "--every", 2, "--fit", FIT)
    assert (data["touches"], data["held_out"]) == (30, 30)
    assert data["r2_held_out"] >= 0.995
    assert data["weak"] == data["dead"] == []
    found = {p["name"]: p for p in data["parameters"] if p["sensor"] is None}
    assert 0.1 < found["poisson"]["value"] < 0.3
    positions = [p["value"] for p in data["parameters"] if p["name"] == "y"]
    np.testing.assert_allclose(np.diff(positions), 6e-3, atol=0.25e-3)


def test_poisson_alone_reaches_the_fit_too(folder, command):
    options = ("--every", 2, "--fit", "gain,depth,origin,poisson")
    assert command("calibrate", folder / "finger.toml", folder / "presses.csv", *options)["r2_held_out"] >= 0.995


def test_an_incompressible_line_load_does_not(folder, command):
    """The memo's h(y) with nu = 1/2: the indenter is round, and its field falls off faster than a line's."""
    options = ("--every", 2, "--fit", "gain,depth,origin")
    assert 0.93 < command("calibrate", folder / "finger.toml", folder / "presses.csv", *options)["r2_held_out"] < 0.96


def test_held_out_presses_are_located(folder, command):
    options = ("--every", 2, "--skip-used", "--truth", "position")
    data = command("locate", folder / "calibrated.toml", folder / "presses.csv", *options)
    columns = {name: np.array(values) for name, values in data["columns"].items()}
    score = data["against_truth"]
    assert score["ok"]["median"] <= 0.06e-3
    assert abs(score["ok"]["mean"]) <= 0.1e-3
    # every press well over the row is ok, to where its interval reaches the end; every one beyond that is flagged
    y = columns["truth"].astype(float) - load(folder / "calibrated.toml").origin
    assert set(columns["status"][np.abs(y) < 8.5e-3]) == {"ok"}
    assert not set(columns["status"][np.abs(y) > 10.5e-3]) & {"ok"}
    ok = columns["status"] == "ok"
    force = columns["force"][ok].astype(float)
    assert np.quantile(np.abs(force - 1), 0.9) < 0.05  # of the presses' load, the same in all


@pytest.mark.parametrize("rows", ["10,30,50", "5,18,31", "8,20,32", "2,16,34", "10,20,30", "3,4,5"])
def test_three_presses_after_mounting_anew(folder, command, tmp_path, capsys, rows):
    """Geometry and gains are known from before, only the motor's origin is not."""
    text = (folder / "calibrated.toml").read_text()
    (tmp_path / "unmounted.toml").write_text(text[: text.index("[calibration]")])
    fit = ("--fit", "origin", "--rows", rows)
    files = (tmp_path / "unmounted.toml", folder / "presses.csv", tmp_path / "today.toml")
    assert main(["calibrate", *map(str, files[:2]), "-o", str(files[2]), *fit]) == 0
    before, after = (load(path).finger.array for path in (folder / "calibrated.toml", files[2]))
    for name in ("gain", "y", "depth"):
        np.testing.assert_array_equal(getattr(after, name), getattr(before, name))
    assert (np.asarray(after.noise) >= before.noise).all()
    capsys.readouterr()
    data = command("locate", files[2], folder / "presses.csv", "--rows", rows, "--skip-used", "--truth", "position")
    score = data["against_truth"]["ok"]
    assert score["count"] >= 32
    assert abs(score["mean"]) <= 0.2e-3
    assert score["median"] <= 0.15e-3
