"""From a finger file to Python: what the file says holds for every verb, and a raw recording has one path."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import subskin as ss
from subskin.errors import FileError, InvalidValueError
from subskin.io import finger_text, parse_finger, parse_goals, read_table, save_finger, write_table
from subskin.synthetic import simulate_recording

from .._commands import subskin

DRAWN = """\
[skin]
young = "0.2 MPa"

[sensors]
count = 5
pitch = "5 mm"
depth = "5 mm"
gain = "-100 kPa"
offset = "1013 hPa"
noise = "20 Pa"
low = "300 hPa"
high = "1100 hPa"

[locate]
friction = 0
search = ["-14 mm", "14 mm"]

[recording]
sensors = ["a", "b", "c", "d", "e"]
unit = "hPa"
time = { column = "ms", unit = "ms" }
position = { column = "x", unit = "1/1000 mm" }
press = { column = "z", unit = "1/320 mm" }
force = { column = "cell", unit = "mN" }

[touch]
length = "20 mm"

[tare]
drift = "0.2 hPa/s"
"""
ORIGIN = 12e-3


@pytest.fixture(scope="module")
def rig(tmp_path_factory):
    """A raw recording in hPa, ms and mN, the finger calibrated on every second press of it, and where it pressed."""
    folder = tmp_path_factory.mktemp("rig")
    drawn = parse_finger(DRAWN)
    real = replace(drawn.finger, array=replace(drawn.finger.array, depth=5.3e-3, gain=-1e5 * np.linspace(0.9, 1.1, 5)))
    rng = np.random.default_rng(5)
    parts = [
        simulate_recording(
            real, np.arange(2e-3, 22e-3, 2e-3), force=f, origin=ORIGIN, relaxation=0.0, drift=40, rng=rng
        )
        for f in (30.0, 60.0)
    ]
    time = np.concatenate([parts[0].time, parts[0].time[-1] + 0.02 + parts[1].time])
    drift = parts[0].readings[-1] - parts[1].readings[0]
    raw = np.concatenate([parts[0].readings, parts[1].readings + drift])
    position, press = (np.concatenate([getattr(p, k) for p in parts]) for k in ("position", "press"))
    pressing = np.clip((press / 4e-3 - 0.3) / 0.7, 0, None)
    force = pressing * np.repeat([30.0, 60.0], [len(p.time) for p in parts])  # N/m
    columns = {"ms": 1e3 * time, "x": 1e6 * position, "z": 320e3 * press, "cell": 1e3 * (0.02 * force + 0.7)}
    write_table(folder / "raw.csv", columns | {n: raw[:, i] / 100 for i, n in enumerate("abcde")})
    (folder / "drawn.toml").write_text(DRAWN)
    for command in (
        ("segment", "drawn.toml", "raw.csv", "-o", "presses.csv"),
        ("calibrate", "drawn.toml", "presses.csv", "-o", "calibrated.toml", "--every", 2),
    ):
        paths = [folder / str(c) if "." in str(c) else c for c in command]
        ran = subskin(*paths)
        assert (ran.code, ran.err) == (0, "")
    file = ss.load(folder / "calibrated.toml")
    noise = np.maximum(file.finger.array.noise, 20.0)  # of a frame: presses are means of many
    file = file.with_finger(replace(file.finger, array=replace(file.finger.array, noise=noise)), file.origin)
    save_finger(file, folder / "calibrated.toml")
    return folder, ss.load(folder / "calibrated.toml"), (time, raw, position, press, force)


def held(press):
    return press == press.max()


def test_the_verbs_keep_to_the_file(rig):
    folder, file, _ = rig
    presses = read_table(folder / "presses.csv")
    readings, truth = presses.readings(file.names), presses.numbers("position") - file.origin
    found = file.locate(readings)
    ok = found.status == ss.Status.OK
    assert ok.mean() > 0.9
    assert np.abs(found.position - truth)[ok].max() < 0.15e-3
    same = file.finger.locate(readings, friction=0.0, search=(-14e-3, 14e-3))
    np.testing.assert_array_equal(found.table, same.table)
    assert (found.table != file.finger.locate(readings).table).any()
    np.testing.assert_array_equal(file.locate(presses).table, found.table)
    np.testing.assert_array_equal(file.locate(folder / "presses.csv").table, found.table)
    fitted = file.fit(readings[:2], "hertz")
    np.testing.assert_array_equal(fitted.angle, 0.0)
    said = file.decide(readings[:2], sure=0.9)
    np.testing.assert_array_equal(
        said.table, ss.decide.contact_type(file.finger, readings[:2], friction=0.0, search=(-14e-3, 14e-3)).table
    )
    assert said.sure == 0.9


def test_an_option_of_the_call_takes_the_place_of_the_files(rig):
    folder, file, _ = rig
    presses = read_table(folder / "presses.csv")
    leaning = file.locate(presses, friction=0.8)
    assert leaning.friction == 0.8
    assert file.fit(presses, "wedge", friction=0.8).friction == 0.8
    assert (np.abs(file.locate(presses, search=(0.0, 14e-3)).position) >= 0).sum() < len(leaning)


def test_a_raw_recording_goes_one_way(rig):
    """By path, by table, by arrays and on the command line, and it finds the very presses it was calibrated on."""
    folder, file, (*_, position, press, _) = rig
    out = file.run(folder / "raw.csv")
    found, at = out["found"], held(press)
    ok = found.status[at] == ss.Status.OK
    assert ok.mean() > 0.95
    assert np.median(np.abs(found.position + file.origin - position)[at][ok]) < 0.05e-3
    np.testing.assert_array_equal(file.run(read_table(folder / "raw.csv"))["found"].table, found.table)
    frames = file.frames(read_table(folder / "raw.csv"))
    np.testing.assert_array_equal(file.run(*frames)["found"].table, found.table)
    np.testing.assert_array_equal(file.tare(*frames).readings, out["tare"].readings)
    np.testing.assert_array_equal(file.locate(file.tare(*frames).readings).table, found.table)
    ran = subskin("locate", folder / "calibrated.toml", folder / "raw.csv", "--tare", "-o", folder / "found.csv")
    assert ran.code == 0
    assert ran.err == ""
    table = read_table(folder / "found.csv")
    assert np.isfinite(table.numbers("position")).sum() > 0.9 * at.sum()
    np.testing.assert_allclose(table.numbers("position"), found.position + file.origin, rtol=1e-12)
    unread = subskin("locate", folder / "calibrated.toml", folder / "raw.csv", "-o", folder / "unread.csv")
    assert "Fix: --tare reads it by [recording]" in unread.err


def test_differences_have_no_offset_of_the_raw_readings_and_no_range(rig):
    folder, file, (time, raw, *_) = rig
    assert file.differences
    assert "differences = true" in (folder / "calibrated.toml").read_text()
    assert np.isinf(file.finger.array.low).all()
    np.testing.assert_array_equal(file.limits, np.outer([3e4, 1.1e5], np.ones(5)))
    assert not file.finger.array.offset.any()  # it was drawn with 1013 hPa
    tared = file.tare(raw / 100, time)
    np.testing.assert_allclose(tared.readings, raw - tared.offset, atol=1e-6)
    assert tared.doubts == ()
    away = replace(file.finger, array=replace(file.finger.array, offset=500.0))
    plain = ss.Tare(away, drift=20.0)(raw, time)
    np.testing.assert_allclose(plain.readings, raw - plain.offset + 500, atol=1e-6)
    assert "differences = true under [calibration]" in plain.doubts[0]


def test_a_saturated_reading_is_missing_however_far_its_offset_has_gone(rig):
    _, file, (time, raw, *_) = rig
    cut = raw[:200] / 100
    cut[150:, 2] = 1100.0
    assert np.isnan(file.tare(cut, time[:200]).readings[150:, 2]).all()
    assert np.isfinite(file.tare(cut, time[:200]).readings[:, [0, 1, 3, 4]]).all()


def test_segment_keeps_the_load_cell_per_length_of_contact(rig):
    folder, file, _ = rig
    presses = read_table(folder / "presses.csv")
    np.testing.assert_allclose(presses.numbers("force"), np.repeat([30.0, 60.0], 10), rtol=1e-6)
    np.testing.assert_array_equal(file.segment(folder / "raw.csv").force, presses.numbers("force"))
    found = file.locate(presses)
    ok = found.status == ss.Status.OK
    np.testing.assert_allclose(found.force[ok], presses.numbers("force")[ok], rtol=0.05)  # calibrated in N/m
    assert file.segment(folder / "raw.csv", hold=1.0, early=0.2).reading.shape == (20, 5)


def test_what_cannot_be_read_is_said(rig):
    folder, file, _ = rig
    with pytest.raises(FileError, match=r"it has no table \[recording\]"):
        replace(file, recording=None).segment(folder / "raw.csv")
    with pytest.raises(InvalidValueError, match="time is missing"):
        file.run(np.zeros((3, 5)))
    with pytest.raises(InvalidValueError, match="a table with the columns"):
        file.segment(np.zeros((3, 5)))
    with pytest.raises(FileError, match=r"unit .*a force per length.*20 mm long is 25 N/m"):
        parse_finger(DRAWN.replace('[touch]\nlength = "20 mm"', ""))
    with pytest.raises(FileError, match="has to be > 0"):
        parse_finger(DRAWN.replace('length = "20 mm"', "length = 0"))


GOALS = """\
touch = {{force = {force}, span = "10 mm"{length}}}
accuracy = {{position = "0.5 mm"}}
room = {{count = 4, depth = "2 mm", least_pitch = "2 mm"}}
sensor = [{{name = "gauge", kind = "normal_strain", noise = 1e-4}}]
skin = [{{name = "soft", young = "0.4 MPa"}}]
"""


def test_goals_take_newtons_where_the_length_is_known():
    known = ', length = "20 mm"'
    goals = parse_goals(GOALS.format(force='["0.5 N", "60 N/m"]', length=known)).goals
    assert (goals.touches.force, goals.strongest, goals.touches.length) == (25.0, 60.0, 0.02)
    row = ss.design.search.Row(skin=0, sensor=0, layout=goals.layouts[0], depth=2e-3, pitch=2e-3)
    file = parse_goals(GOALS.format(force='"0.5 N"', length=known))
    assert parse_finger(finger_text(file, row, (-5e-3, 5e-3), [])).length == 0.02
    with pytest.raises(FileError, match=r'force = "0.5 N": a force per length.*Fix: 0.5 N over a contact 20 mm long'):
        parse_goals(GOALS.format(force='"0.5 N"', length=""))
    with pytest.raises(FileError, match="length"):
        parse_goals(GOALS.format(force='"0.5 N"', length=', length = "0 mm"'))


def test_commands_take_and_give_newtons(rig):
    folder, file, _ = rig
    ran = subskin("simulate", folder / "calibrated.toml", "-o", folder / "r.csv", "--count", 3, "--force", "0.8 N")
    assert (ran.code, ran.err) == (0, "")
    np.testing.assert_allclose(read_table(folder / "r.csv").numbers("force"), 40.0)
    subskin("locate", folder / "calibrated.toml", folder / "presses.csv", "-o", folder / "located.csv")
    located = read_table(folder / "located.csv")
    assert np.isfinite(located.numbers("newtons")).sum() >= 10
    np.testing.assert_allclose(located.numbers("newtons"), 0.02 * located.numbers("force"), rtol=1e-12)
    (folder / "bare.toml").write_text(file.text.replace("[touch]\nlength", "[touch]\n# length").replace("mN", "mN/m"))
    ran = subskin("simulate", folder / "bare.toml", "-o", folder / "r.csv", "--force", "0.8 N")
    assert ran.code == 2
    assert "20 mm long is 25 N/m" in ran.err


def test_presses_of_several_depths_without_a_force_are_said(rig):
    folder, _, _ = rig
    bare = "\n".join(line for line in DRAWN.splitlines() if "cell" not in line)
    (folder / "unweighed.toml").write_text(bare)
    deep = read_table(folder / "raw.csv")
    columns = {name: deep.numbers(name).copy() for name in deep.columns}
    columns["z"][len(deep) // 2 :] *= 1.5
    write_table(folder / "deep.csv", columns)
    ran = subskin("segment", folder / "unweighed.toml", folder / "deep.csv", "-o", folder / "deep_presses.csv")
    assert "presses of 4 to 6 mm, and no force" in ran.err
    ran = subskin("calibrate", folder / "unweighed.toml", folder / "deep_presses.csv", "-o", folder / "c.toml")
    assert "Fix: [recording] force, or --force-column" in ran.err
    ran = subskin("segment", folder / "drawn.toml", folder / "deep.csv", "-o", folder / "deep_presses.csv")
    assert ran.err == ""
