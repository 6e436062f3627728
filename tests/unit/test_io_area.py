"""[sensors] on an area: layouts, channels, transducers with arguments; read, changed, written and read again."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import subskin as ss
from subskin.errors import FileError
from subskin.io import load, parse_finger, save_finger
from subskin.transducer import MagnetDisplacement, ShearStrain

AREA = """\
[skin]
kind = "half_space"
young = "0.4 MPa"

[sensors]
layout = "grid"
shape = [2, 3]
pitch = ["3 mm", "2 mm"]
depth = ["0.5 mm", "2 mm", "1 mm"]   # of each channel
channels = [
    {name = "shear_strain", plane = "xz"},
    "normal_strain",
    {name = "magnet_displacement", axis = "x", moment = "5 mA*m^2", gap = "3 mm"},
]
noise = [1e-4, 1e-4, 1e-6]
"""
ROW = '[skin]\nkind = "half_space"\nyoung = 4e5\n[sensors]\ndepth = "3 mm"\n'


def test_a_grid_of_channels():
    array = parse_finger(AREA).finger.array
    kinds = [ShearStrain("xz"), ss.NormalStrain(), MagnetDisplacement("x", 5e-3, 3e-3)]
    made = ss.SensorArray.grid((2, 3), (3e-3, 2e-3), [0.5e-3, 2e-3, 1e-3], channels=kinds, noise=[1e-4, 1e-4, 1e-6])
    assert array.transducers == made.transducers
    for name in ("y", "z", "depth", "noise"):
        np.testing.assert_allclose(getattr(array, name), getattr(made, name), rtol=1e-15)
    np.testing.assert_allclose(array.y, np.repeat([-1.5e-3, 1.5e-3], 9), rtol=1e-12, equal_nan=False)
    np.testing.assert_allclose(array.z[:9:3], [-2e-3, 0.0, 2e-3], atol=1e-15)
    np.testing.assert_allclose(array.depth[:3], [0.5e-3, 2e-3, 1e-3])


@pytest.mark.parametrize(
    ("text", "made"),
    [
        (
            'layout = "hexagonal"\nshape = [3, 4]\npitch = "2 mm"\ncentre = ["1 mm", "2 mm"]',
            ((3, 4), 2e-3, (1e-3, 2e-3)),
        ),
        ('layout = "hexagonal"\nshape = [2, 2]\npitch = 1e-3', ((2, 2), 1e-3, (0.0, 0.0))),
    ],
)
def test_hexagonal(text, made):
    points = ss.SensorArray.hexagonal(*made[:2], depth=1.0, centre=made[2]).points
    np.testing.assert_array_equal(parse_finger(ROW + text).finger.array.points, points)


def test_points():
    array = parse_finger(ROW + 'y = ["1 mm", 0, 2e-3]\nz = ["0 mm", "3 mm", -1e-3]').finger.array
    np.testing.assert_allclose(array.points, [[1e-3, 0.0], [0.0, 3e-3], [2e-3, -1e-3]], rtol=1e-15)
    array = parse_finger(
        ROW + 'count = 2\npitch = "1 mm"\nkind = {name = "lateral_strain", direction = "45 deg"}'
    ).finger
    assert array.array.transducers[0].direction == pytest.approx(np.pi / 4)


def same(one, two):
    assert one.transducers == two.transducers
    for name in ("y", "z", "depth", "gain", "noise", "low", "high"):
        np.testing.assert_allclose(getattr(one, name), getattr(two, name), rtol=1e-8, atol=1e-11)


@pytest.mark.parametrize(
    "changes",
    [
        {"gain": np.linspace(1, 2, 18)},
        {"depth": np.linspace(1e-3, 2e-3, 18)},
        {"y": np.linspace(-2e-3, 2e-3, 18), "gain": np.linspace(1, 2, 18)},
        {"z": np.linspace(-2e-3, 2e-3, 18)},
        {"z": np.zeros(18)},
    ],
    ids=" ".join,
)
def test_what_changes_is_written_and_comes_back(changes, tmp_path):
    """Moved apart, the channels are sensors of their own; else the layout stays as it was written."""
    file = parse_finger(AREA)
    array = replace(file.finger.array, **changes)
    changed = file.with_finger(replace(file.finger, array=array), origin=0.0)
    assert ("channels" in changed.text) == ("layout" in changed.text) == (not {"y", "z"} & set(changes))
    save_finger(changed, tmp_path / "area.toml")
    again = load(tmp_path / "area.toml")
    same(again.finger.array, array)
    assert "# of each channel" in again.text


def test_many_columns_are_not_all_shown():
    assert "columns   s0, s1, s2, ..., s17" in repr(parse_finger(AREA))


@pytest.mark.parametrize(
    ("old", "new", "line", "said"),
    [
        ("shape = [2, 3]", "shape = [2]", 7, "shape = [2]: two counts are needed"),
        ("shape = [2, 3]", "count = 6", 7, 'count beside layout = "grid": a grid has no count'),
        ("shape = [2, 3]", "", 5, 'layout = "grid" without shape'),
        ('layout = "grid"', "", 6, 'shape beside layout = "row": a row has no shape. Fix: layout = "grid"'),
        ('layout = "grid"', 'layout = "hexagonal"', 8, "pitch of shape (2,): one number is needed"),
        ('layout = "grid"', 'layout = "round"', 6, "has to be 'row', 'grid' or 'hexagonal'"),
        ('["0.5 mm", "2 mm", "1 mm"]', '["0.5 mm", "2 mm"]', 9, "depth of shape (2,): it has to broadcast to (6, 3)"),
        ('plane = "xz"', 'plain = "xz"', 10, 'argument "plain": shear_strain has no such argument. Fix: known: plane'),
        ('plane = "xz"', 'plane = "zz"', 10, "plane = 'zz': has to be"),
        ('"5 mA*m^2"', '"5 mA"', 10, 'moment = "5 mA": a value in A*m^2 is needed'),
        (', gap = "3 mm"', "", 10, "it needs other arguments"),
        ('    "normal_strain",', "    3,", 10, "channels = 3: the name of a kind of sensor is needed"),
        ("noise =", 'kind = "normal_strain"\nnoise =', 15, "kind beside channels: each says"),
        ('"half_space"', '"half_plane"', 5, "sensors at z = -2 to 2 mm in a half plane"),
    ],
)
def test_what_is_wrong_is_said_with_its_line(old, new, line, said):
    text = AREA.replace(old, new, 1)
    assert text != AREA
    with pytest.raises(FileError) as refused:
        parse_finger(text)
    assert said in str(refused.value)
    assert abs(int(str(refused.value).split("line ")[1].split(":")[0]) - line) <= 1
