"""The response of a finger in place in a file beside it, and where a finger lies on the axes of the touches."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import subskin as ss
from subskin._axes import on_finger, on_touches
from subskin.errors import FileError, InvalidValueError
from subskin.estimate.on_area import moved
from subskin.io import load, parse_finger, save_finger
from subskin.measured import MeasuredResponse

TEXT = """\
[skin]
kind = "half_space"
young = "0.4 MPa"

[sensors]      # as drawn
layout = "grid"
shape = [2, 2]
pitch = "3 mm"
depth = "3 mm"
kind = "mean_pressure"
noise = 20
"""


@pytest.fixture(scope="module")
def response():
    rng = np.random.default_rng(0)
    y, z = np.linspace(-3e-3, 3e-3, 5), np.linspace(-2e-3, 2e-3, 6)
    values = rng.normal(size=(5, 6, 4, 3))
    together = 0.8 * np.eye(4) + 0.2
    return MeasuredResponse(y, z, values, rng.uniform(size=values.shape), rng.normal(size=4), [1, 2, 3, 4], together)


@pytest.fixture
def saved(response, tmp_path):
    """The path of a finger with a response, both files of it written."""
    file = parse_finger(TEXT)
    file = file.with_finger(replace(file.finger, measured=response), (12.25e-3, -3e-3), {"touches": 9}, turn=0.3)
    save_finger(file, tmp_path / "left.toml")
    return tmp_path / "left.toml"


def test_both_files_come_back(response, saved, tmp_path):
    file = load(saved)
    np.testing.assert_array_equal(file.origin, [12.25e-3, -3e-3])
    assert file.turn == pytest.approx(0.3, rel=1e-8)
    assert "# as drawn" in file.text
    for name in ("y", "z", "values", "variance", "offset", "noise", "correlation", "load"):
        np.testing.assert_array_equal(getattr(file.finger.measured, name), getattr(response, name))
    save_finger(file, tmp_path / "copy.toml")  # elsewhere, under another name
    assert load(tmp_path / "copy.toml").text == file.text
    without = file.with_finger(replace(file.finger, measured=None), file.origin, turn=file.turn)
    assert "response" not in without.text
    save_finger(without, tmp_path / "bare.toml")
    assert load(tmp_path / "bare.toml").finger.measured is None
    assert not (tmp_path / "bare.response.npz").exists()


def test_a_link_leads_to_both(saved, tmp_path):
    (tmp_path / "elsewhere").mkdir()
    link = tmp_path / "elsewhere" / "link.toml"
    link.symlink_to(saved)
    assert load(link).finger.measured is not None


def bitten(path):
    data = bytearray(path.read_bytes())
    data[len(data) // 2] ^= 1
    path.write_bytes(data)


@pytest.mark.parametrize(
    ("harm", "said"),
    [
        (lambda path: path.unlink(), "needs this file beside it, and it is not there"),
        (lambda path: path.write_bytes(path.read_bytes()[:-100]), "it holds no response"),
        (lambda path: path.write_bytes(b"PK"), "it holds no response"),
        (bitten, "left.response.npz"),
    ],
    ids=["missing", "cut", "short", "bitten"],
)
def test_what_is_wrong_beside_it_is_said(saved, harm, said):
    harm(saved.with_name("left.response.npz"))
    with pytest.raises(FileError, match=said) as refused:
        load(saved)
    assert "calibrate again, or copy both files" in str(refused.value)


def test_another_fingers_response_is_refused(response, saved, tmp_path):
    file = load(saved)
    other = replace(response, values=np.nextafter(response.values, 9.0))
    save_finger(file.with_finger(replace(file.finger, measured=other), file.origin), tmp_path / "right.toml")
    (tmp_path / "right.response.npz").replace(tmp_path / "left.response.npz")
    with pytest.raises(FileError, match="another checksum"):
        load(saved)


def test_a_text_alone_and_a_finger_of_more_sensors(saved):
    with pytest.raises(FileError, match="a text has no file beside it"):
        parse_finger(saved.read_text())
    saved.write_text(saved.read_text().replace("[2, 2]", "[2, 3]"))
    with pytest.raises(FileError, match="6 sensors, and the response beside it is of 4"):
        load(saved)


def test_both_files_are_written_or_neither(saved, monkeypatch, capfdbinary):
    file, before = load(saved), {p.name: p.read_bytes() for p in saved.parent.iterdir()}
    changed = file.with_finger(replace(file.finger, measured=file.finger.measured.widened(2.0)), (0.0, 0.0))

    def full(*_, **__):
        raise OSError(28, "No space left on device")

    with monkeypatch.context() as patched:
        patched.setattr(np, "savez", full)
        with pytest.raises(FileError, match="No space left"):
            save_finger(changed, saved)
    assert {p.name: p.read_bytes() for p in saved.parent.iterdir()} == before
    with pytest.raises(FileError, match="goes into a file beside"):
        save_finger(changed, "-")
    assert capfdbinary.readouterr().out == b""


def test_where_the_finger_lies():
    at = np.random.default_rng(1).normal(size=(7, 2))
    back = on_finger(on_touches(at, (0.3, -0.2), 0.7), (0.3, -0.2), 0.7)
    np.testing.assert_allclose(back, at, atol=1e-15)
    np.testing.assert_allclose(on_touches([1.0, 0.0], (0.0, 0.0), np.pi / 2), [0.0, 1.0], atol=1e-15)
    assert on_finger(5.0, 2.0) == 3.0


def test_what_was_found_is_moved_and_turned():
    """As if the finger's axes were the touches': the same numbers in others' coordinates."""
    origin, turn = np.array([0.02, -0.01]), 0.4
    finger = parse_finger(TEXT.replace("[2, 2]", "[4, 4]")).finger
    where, lean = np.array([[1e-3, -2e-3], [-2.5e-3, 0.5e-3]]), {"angle": [0.3, 0.2], "azimuth": [0.8, -2.0]}
    own = finger.locate(finger.read(ss.PointLoad(1.5, position=where, **lean), np.random.default_rng(0)))
    found = moved(own, origin, turn)
    np.testing.assert_allclose(found.position, on_touches(own.position, origin, turn), atol=1e-15)
    np.testing.assert_allclose(found.second.position, on_touches(own.second.position, origin, turn), atol=1e-15)
    np.testing.assert_allclose(np.exp(1j * (found.load.azimuth - own.load.azimuth)), np.exp(1j * turn), atol=1e-12)
    np.testing.assert_allclose(found.angle, own.angle, rtol=1e-12)
    # force, angle and azimuth are as sure as before; positions along the turned axes are what the others say of them
    np.testing.assert_allclose(found.std[:, 2:], own.std[:, 2:], rtol=1e-8)
    along = np.array([np.cos(turn), np.sin(turn)])
    variance = np.einsum("i,nij,j->n", along, found.covariance[:, :2, :2], along)
    np.testing.assert_allclose(np.sqrt(variance), own.std[:, 0], rtol=1e-8)
    np.testing.assert_array_equal(found.status, own.status)
    table = np.array(own.table[0])
    table[own.layout.square[2, 2]] = np.inf  # the force is not known: how errors mix is not said of half of them
    unknown = moved(replace(own[:1], table=table[None]), origin, turn).table[0]
    np.testing.assert_array_equal(unknown[own.layout.square], table[own.layout.square])


RECORDING = """
[recording]
sensors = ["a", "b", "c", "d"]
position = [{column = "x", unit = "mm"}, {column = "y", unit = "1/1000 mm"}]
force = {column = "cell", unit = "mN"}
[locate]
friction = 0
normal_force = ["0.5 N", 2]
[calibration]
origin = ["1 mm", 0]
turn = "90 deg"
"""


def test_what_a_file_says_of_an_area():
    file = parse_finger(TEXT + RECORDING)
    assert [(c.name, c.scale) for c in file.recording.tracks["position"]] == [("x", 1e-3), ("y", 1e-6)]
    assert file.recording.force.scale == pytest.approx(1e-3)  # newtons, though no length of a contact is given
    assert file.normal_force == (0.5, 2.0)
    assert "normal force 0.5 to 2 N" in repr(file)
    np.testing.assert_allclose(file.on_touches([[1e-3, 0.0]]), [[1e-3, 1e-3]], atol=1e-15)


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        (', {column = "y", unit = "1/1000 mm"}]', "]", "sensors on an area need two columns"),
        ('origin = ["1 mm", 0]', 'origin = "1 mm"', "y and z are needed"),
        ('["0.5 N", 2]', '["3 N", 2]', "the first has to be >= 0 and <= the second"),
        ('["0.5 N", 2]', '"3 N"', "the least and the largest are needed"),
        ('["0.5 N", 2]', '["3 N/m", "4 N/m"]', "a value in N is needed"),
        ('turn = "90 deg"', 'turn = "90 mm"', "a value in rad is needed"),
        ('turn = "90 deg"', 'response = "12"', "response"),
        ('layout = "grid"\nshape = [2, 2]', "count = 4", "one position is needed"),
    ],
)
def test_what_is_wrong_on_an_area_is_said(old, new, said):
    text = TEXT + RECORDING
    assert old in text
    with pytest.raises(FileError, match=said):
        parse_finger(text.replace(old, new))


def test_a_row_has_one_column_of_positions():
    row = TEXT.replace('layout = "grid"\nshape = [2, 2]', "count = 4") + RECORDING.split("[locate]")[0]
    with pytest.raises(FileError, match="a row needs one column"):
        parse_finger(row)


def test_a_known_force_is_used(response):
    """[locate] normal_force reaches the locator; a row takes it per length."""
    file = parse_finger(TEXT + RECORDING)
    with pytest.raises(InvalidValueError, match="normal_force"):  # of the field alone an area knows no such bound
        file.locator()
    made = replace(file, finger=replace(file.finger, measured=response)).locator()
    assert made._force == (0.5, 2.0)
    row = TEXT.replace('layout = "grid"\nshape = [2, 2]', "count = 6").replace("half_space", "half_plane")
    row += '[touch]\nlength = "20 mm"\n[locate]\nnormal_force = ["1 N", "60 N/m"]\n'
    file = parse_finger(row)
    assert file.normal_force == (50.0, 60.0)
    readings = file.finger.read(ss.LineLoad(55.0, position=1e-3), np.random.default_rng(0))
    assert file.locate(readings).ok
    assert not file.locate(2 * readings).ok


def test_from_which_standard_error_a_position_is_ambiguous_is_kept_and_files_without_it_are_read(response, tmp_path):
    file = parse_finger(TEXT)
    for name, vague in (("told", 0.4e-3), ("none", np.inf)):
        finger = replace(file.finger, measured=replace(response, vague=vague))
        save_finger(file.with_finger(finger, (0.0, 0.0), {}), tmp_path / f"{name}.toml")
        assert load(tmp_path / f"{name}.toml").finger.measured.vague == vague
    # as 0.2.0 wrote them: no such number, and a checksum without it
    path = tmp_path / "none.response.npz"
    with np.load(path) as arrays:
        old = {name: arrays[name] for name in arrays.files if name != "vague"}
    np.savez(path, **old)
    assert load(tmp_path / "none.toml").finger.measured.vague == np.inf
    # of a file that has it, it cannot go lost
    path = tmp_path / "told.response.npz"
    np.savez(path, **old)
    with pytest.raises(FileError, match="another checksum"):
        load(tmp_path / "told.toml")
