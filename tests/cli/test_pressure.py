"""`subskin pressure`: what it prints, the tables and the figure it writes, and what it refuses."""

from __future__ import annotations

import csv
import json

import numpy as np
import pytest
from PIL import Image

import subskin as ss

SKIN = """\
[skin]
young = "0.4 MPa"

[sensors]
count = 17
pitch = "0.5 mm"
depth = "2 mm"
noise = 2e-5
"""
ROLLERS = ss.Hertz(force=[40.0, 20.0], angle=[0.3, -0.2], position=[0.5e-3, -1e-3], half_width=1.5e-3)


@pytest.fixture
def tip(folder):
    (folder / "skin.toml").write_text(SKIN)
    array = ss.SensorArray.line(17, pitch=0.5e-3, depth=2e-3, noise=2e-5)
    finger = ss.Finger(ss.HalfPlane(ss.Material(young=0.4e6)), array)
    rng = np.random.default_rng(0)
    frames = [*finger.read(ROLLERS, rng), 2e-5 * rng.standard_normal(17)]
    with (folder / "readings.csv").open("w", newline="") as file:
        csv.writer(file).writerows([[f"s{i}" for i in range(17)], *frames])
    return finger, np.array(frames)


def table(path) -> dict[str, list[str]]:
    with path.open(newline="") as file:
        rows = list(csv.DictReader(file))
    return {name: [row[name] for row in rows] for name in rows[0]}


def test_it_writes_the_map_the_totals_and_a_figure(tip, folder, subskin):
    finger, frames = tip
    done = subskin(
        "pressure", "skin.toml", "readings.csv", "-o", "map.csv", "--totals", "forces.csv", "--figure", "map.png"
    )
    assert done.code == 0, done.err
    assert "nothing beyond noise" in done.out
    assert "subskin locate and fit object to more" in done.out
    found = ss.pressure_map(finger, frames)
    mapped, totals = table(folder / "map.csv"), table(folder / "forces.csv")
    assert len(mapped["row"]) == 2 * len(found.y)  # the untouched frame has none
    np.testing.assert_allclose(np.array(mapped["pressure"], float), found.pressure[:2].reshape(-1), rtol=1e-9)
    np.testing.assert_allclose(np.array(mapped["y"][: len(found.y)], float), found.y)
    assert totals["status"] == ["ok", "ok", "no_contact"]
    np.testing.assert_allclose(np.array(totals["normal_force"][:2], float), ROLLERS.normal_force, rtol=0.01)
    np.testing.assert_allclose(np.array(totals["angle"][:2], float), ROLLERS.angle, atol=0.02)
    assert 0.5e-3 < float(totals["resolution"][0]) < 2e-3
    assert (folder / "map.png").stat().st_size > 10_000


def test_json_says_the_same(tip, subskin):
    finger, frames = tip
    done = subskin("pressure", "skin.toml", "readings.csv", "--shear", "none", "--rule", "gcv", "--json")
    said = json.loads(done.out)
    found = ss.pressure_map(finger, frames, shear="none", rule="gcv")
    assert (said["frames"], said["rule"], said["shear"]) == (3, "gcv", "none")
    assert said["pressure"][2][0] is None
    y, there = np.array(said["y"]), np.isfinite(found.normal_force)
    np.testing.assert_allclose(y, found.y)
    for f in np.flatnonzero(there):
        np.testing.assert_allclose(said["pressure"][f], found.pressure[f])


def test_it_prints_the_first_frames(tip, subskin):
    done = subskin("pressure", "skin.toml", "readings.csv", "--rows", "1-2")
    assert done.code == 0
    assert "normal_force" in done.out
    assert " 1 " in done.out
    assert " 0  " not in done.out.split("the first frames")[1]


def test_a_finger_without_friction_has_no_shear(tip, folder, subskin):
    (folder / "dry.toml").write_text(SKIN + "\n[locate]\nfriction = 0\n")
    said = json.loads(subskin("pressure", "dry.toml", "readings.csv", "--json").out)
    assert said["shear"] == "none"


@pytest.mark.parametrize(
    ("more", "message"),
    [
        (("--shear", "free"), "one function of y"),
        (("--figure", "map.txt"), "a figure is .svg"),
        (("--totals", "nowhere/forces.csv"), "nowhere"),
        (("--rows", "2", "--figure", "map.png"), "no frame has a contact"),
        (("--rule", "lcurve"), "invalid choice"),
    ],
)
def test_what_cannot_be_done_writes_nothing(tip, folder, subskin, more, message):
    done = subskin("pressure", "skin.toml", "readings.csv", "-o", "map.csv", *more)
    assert done.code == 2
    assert message in done.err
    assert not (folder / "map.csv").exists()
    assert not (folder / "map.png").exists()


def test_a_finger_without_noise_is_named(tip, folder, subskin):
    (folder / "mute.toml").write_text(SKIN.replace("noise = 2e-5", "noise = 0"))
    done = subskin("pressure", "mute.toml", "readings.csv")
    assert done.code == 2
    assert "mute.toml" in done.err


PAD = """\
[skin]
kind = "half_space"
young = "0.4 MPa"

[sensors]
layout = "grid"
shape = [5, 5]
pitch = "1.5 mm"
depth = "2 mm"
kind = "mean_pressure"
noise = 20

[calibration]
turn = "90 deg"
"""


@pytest.fixture
def pad(folder):
    """A finger that lies turned by a quarter, an untouched frame and a frame dragged along its own y."""
    (folder / "pad.toml").write_text(PAD)
    array = ss.SensorArray.grid(shape=(5, 5), pitch=1.5e-3, depth=2e-3, transducer=ss.MeanPressure(), noise=20.0)
    finger = ss.Finger(ss.HalfSpace(ss.Material(young=0.4e6)), array)
    rng = np.random.default_rng(0)
    touch = ss.RoundHertz(force=2.0, angle=0.4, position=(1e-3, 0.5e-3), half_width=1.5e-3)
    frames = np.stack([20.0 * rng.standard_normal(25), finger.read(touch, rng)])
    with (folder / "pad.csv").open("w", newline="") as file:
        csv.writer(file).writerows([[f"s{i}" for i in range(25)], *frames])
    return finger, frames


def test_on_an_area_it_writes_images_on_the_axes_of_the_tables_and_a_movie(pad, folder, subskin):
    finger, frames = pad
    outputs = ("-o", "map.csv", "--totals", "forces.csv", "--figure", "map.png", "--movie", "press.gif")
    done = subskin("pressure", "pad.toml", "pad.csv", *outputs)
    assert done.code == 0, done.err
    found = ss.pressure_map(finger, frames)[1]
    mapped, totals = table(folder / "map.csv"), table(folder / "forces.csv")
    y, z, along, across = (np.array(mapped[name], float) for name in ("y", "z", "shear_y", "shear_z"))
    own = np.stack(np.meshgrid(found.y, found.z, indexing="ij"), axis=-1).reshape(-1, 2)
    np.testing.assert_allclose((y, z), (-own[:, 1], own[:, 0]), atol=1e-12)  # own y lies along the tables' z
    np.testing.assert_allclose(
        np.array(mapped["pressure"], float), found.pressure.reshape(-1), rtol=1e-9, equal_nan=False
    )
    drag = found.shear.reshape(-1, 2)
    np.testing.assert_allclose((along, across), (-drag[:, 1], drag[:, 0]), atol=1e-6 * drag.max(), equal_nan=False)
    assert totals["status"] == ["no_contact", "ok"]
    assert float(totals["tangential_z"][1]) == pytest.approx(found.tangential_force[0], rel=1e-9)
    assert (float(totals["centre_y"][1]), float(totals["centre_z"][1])) == pytest.approx((-0.5e-3, 1e-3), abs=2e-4)
    assert (folder / "map.png").stat().st_size > 10_000
    with Image.open(folder / "press.gif") as movie:
        assert movie.n_frames == 2
        shades = []
        for i in range(2):
            movie.seek(i)
            image = np.asarray(movie.convert("RGB"), float)
            shades.append(image[image.shape[0] // 3 : image.shape[0] // 2, image.shape[1] // 3 : -image.shape[1] // 3])
    assert shades[0].max(axis=(0, 1))[1] < shades[1].max(axis=(0, 1))[1]  # no pressure is dark
    said = json.loads(subskin("pressure", "pad.toml", "pad.csv", "--json").out)
    np.testing.assert_allclose(
        np.reshape(said["shear_stress"][1], (-1, 2)).T, (along, across), atol=1e-6 * drag.max(), equal_nan=False
    )


def test_a_free_drag_on_an_area_is_refused(pad, folder, subskin):
    done = subskin("pressure", "pad.toml", "pad.csv", "--shear", "free", "-o", "map.csv")
    assert (done.code, (folder / "map.csv").exists()) == (2, False)
    assert 'shear="proportional"' in done.err


def test_a_free_drag_on_an_area_is_written_with_its_moment(folder, subskin):
    moves = ", ".join(f'{{name = "displacement", axis = "{axis}"}}' for axis in "xyz")
    three = PAD.replace('kind = "mean_pressure"', f"channels = [{moves}]")
    (folder / "three.toml").write_text(three.replace("noise = 20", "noise = 5e-8"))
    finger = ss.load(folder / "three.toml").finger
    touch = ss.RoundHertz(components=(2.0, 0.6, 0.0), position=(0.4e-3, 0.3e-3), half_width=1.5e-3)
    frame = finger.read(touch, np.random.default_rng(0))
    with (folder / "three.csv").open("w", newline="") as file:
        csv.writer(file).writerows([[f"s{i}" for i in range(75)], frame])
    done = subskin("pressure", "three.toml", "three.csv", "--shear", "free", "-o", "map.csv", "--totals", "forces.csv")
    assert done.code == 0, done.err
    found = ss.pressure_map(finger, frame, shear="free")
    mapped, totals = table(folder / "map.csv"), table(folder / "forces.csv")
    drag, std = found.shear.reshape(-1, 2), found.shear_std.reshape(-1, 2)
    along, across, doubt = (np.array(mapped[name], float) for name in ("shear_y", "shear_z", "shear_std"))
    np.testing.assert_allclose((along, across), (-drag[:, 1], drag[:, 0]), atol=1e-6 * drag.max(), equal_nan=False)
    np.testing.assert_allclose(doubt, np.sqrt((std**2).mean(axis=1)), rtol=1e-6, equal_nan=False)
    assert float(totals["moment"][0]) == pytest.approx(float(found.moment), rel=1e-6)
    assert float(totals["moment_std"][0]) == pytest.approx(float(found.moment_std), rel=1e-6)
    assert float(totals["tangential_z"][0]) == pytest.approx(0.6, abs=0.05)
