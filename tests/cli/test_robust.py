"""`subskin locate --tare --outliers`: a stream with drift and wild readings, from a table."""

import json

import numpy as np
import pytest

import subskin as ss
from subskin.io.finger_file import load
from subskin.io.tables import read_table, write_table

from .conftest import ORIENTED


@pytest.fixture
def stream(folder):
    """Three touches of 4 s on six sensors that drift; two readings are wild."""
    text = (folder / "finger.toml").read_text()
    text = text.replace("count = 4", "count = 6").replace('"p3"]', '"p3", "p4", "p5"]')
    (folder / "finger.toml").write_text(text.replace("friction = 0", "friction = 1") + ORIENTED)
    finger = load("finger.toml").finger
    time = np.arange(0.0, 30.0, 0.02)
    pressed = (time % 10 > 4) & (time % 10 < 8)
    position = 3e-3 * np.floor(time / 10) - 3e-3
    readings = finger.read(ss.LineLoad(40.0 * pressed, 0.2, position), np.random.default_rng(0))
    readings = readings + 3.0 * time[:, None] * np.array([1, -1, 0.5, 1, -0.5, 0])
    wild = np.flatnonzero(pressed)[[20, 300]]
    readings[wild, 2] += 3000.0
    columns = {"time": time, "position": position} | {f"p{i}": readings[:, i] for i in range(6)}
    write_table("stream.csv", columns)
    return pressed, wild


def test_a_stream_is_tared_and_its_wild_readings_left_out(subskin, stream):
    pressed, wild = stream
    shares = {}
    for options in ((), ("--tare", "6"), ("--tare", "6", "--outliers", "1")):
        ran = subskin("locate", "finger.toml", "stream.csv", "-o", "located.csv", *options)
        assert (ran.code, ran.err) == (0, "")
        table = read_table("located.csv")
        status = np.array(table.texts("status"))
        shares[options] = (status[pressed] == "ok").mean()
    assert shares[()] < 0.4
    assert shares["--tare", "6"] > 0.95
    assert (status[wild] == "ok").all()
    used = table.texts("used")
    assert [used[k] for k in wild] == ["p0 p1 p3 p4 p5"] * 2


def test_rows_left_out_are_part_of_the_stream_all_the_same(subskin, stream):
    whole = json.loads(subskin("locate", "finger.toml", "stream.csv", "--tare", "6", "--json").out)
    some = json.loads(subskin("locate", "finger.toml", "stream.csv", "--tare", "6", "--rows", "700-720", "--json").out)
    assert some["columns"]["position"] == whole["columns"]["position"][700:721]


def test_the_default_drift_is_that_of_the_noise(subskin, stream):
    ran = json.loads(subskin("locate", "finger.toml", "stream.csv", "--json", "--tare").out)
    again = json.loads(subskin("locate", "finger.toml", "stream.csv", "--json", "--tare", "1.5").out)
    assert ran == again  # 0.3 times 5 Pa


@pytest.mark.parametrize(
    ("options", "seen"),
    [
        (("--tare", "fast"), '--tare "fast": a reading per second is needed'),
        (("--tare", "-1"), "has to be >= 0"),
        (("--outliers", "2"), "outliers = 2"),
    ],
)
def test_bad_options_are_said(subskin, stream, options, seen):
    ran = subskin("locate", "finger.toml", "stream.csv", "-o", "out.csv", *options)
    assert ran.code == 2
    assert seen in ran.err


def test_a_table_without_times_cannot_be_tared(subskin, folder):
    assert subskin("simulate", "finger.toml", "-o", "r.csv", "--count", 5).code == 0
    ran = subskin("locate", "finger.toml", "r.csv", "--tare")
    assert ran.code == 2
    assert '"time", needed for the time of each frame' in ran.err


def test_a_stream_is_in_the_units_of_the_recording(subskin, stream, folder):
    """Readings in hPa, times in ms; as `segment` reads them."""
    whole = subskin("locate", "finger.toml", "stream.csv", "-o", "whole.csv", "--tare", "6")
    assert whole.code == 0
    table = read_table("stream.csv")
    columns = {name: table.numbers(name) for name in table.columns}
    counts = {name: values * (1000 if name == "time" else 0.01) for name, values in columns.items()}
    write_table("counts.csv", counts | {"position": columns["position"]})
    text = (folder / "finger.toml").read_text().replace('unit = "Pa"', 'unit = "hPa"')
    (folder / "counts.toml").write_text(text.replace('unit = "s"', 'unit = "ms"'))
    ran = subskin("locate", "counts.toml", "counts.csv", "-o", "counted.csv", "--tare", "6")
    assert (ran.code, ran.err) == (0, "")
    expected, found = read_table("whole.csv"), read_table("counted.csv")
    for name in ("position", "force", "residual"):
        np.testing.assert_allclose(found.numbers(name), expected.numbers(name), rtol=1e-6, atol=1e-9)
    assert found.texts("status") == expected.texts("status")


@pytest.mark.parametrize("command", ["fit", "decide", "pressure"])
def test_every_command_that_goes_frame_by_frame_takes_a_stream(subskin, stream, command):
    """Twenty frames of a touch are explained once drift is off."""
    explained = []
    for tare in ((), ("--tare", "6")):
        ran = subskin(command, "finger.toml", "stream.csv", "--rows", "701-720", "--json", *tare)
        told = json.loads(ran.out)
        # "none of these" explains what drifts, to a tenth or so
        explained.append(
            told["status"]["ok"] + told["status"]["ambiguous"] - told.get("kinds", {}).get("none of these", 0)
        )
    assert explained == [0, 20]


def test_relaxation_and_the_fastest_drift_stand_in_the_file(subskin, folder):
    """A stream of simulated rubber: with [relaxation] the force of a touch that is held stays."""
    assert subskin("simulate", "finger.toml", "-o", "raw.csv", "--recording", "--count", 3, "--hold", "4 s").code == 0
    text = (folder / "finger.toml").read_text() + '[relaxation]\nshare = [0.2]\ntime = ["1.5 s"]\n[tare]\ndrift = 1\n'
    (folder / "rubber.toml").write_text(text)
    time = read_table("raw.csv").numbers("time")
    late = (time % 5.5 > 4.0) & (time % 5.5 < 4.9)
    forces = []
    for name in ("finger.toml", "rubber.toml"):
        assert subskin("locate", name, "raw.csv", "-o", "out.csv", "--tare").code == 0
        forces.append(np.nanmedian(read_table("out.csv").numbers("force")[late]))
    np.testing.assert_allclose(forces, [40.0 * (1 - 0.2 * (1 - np.exp(-2.6))), 40.0], rtol=0.02)


def test_offsets_that_are_not_the_free_skin_s_are_said(subskin, stream, folder):
    assert "warning" not in subskin("locate", "finger.toml", "stream.csv", "--tare").err
    text = (folder / "finger.toml").read_text()
    (folder / "finger.toml").write_text(text.replace("offset = 1e5", "offset = 700"))
    ran = subskin("locate", "finger.toml", "stream.csv", "--tare")
    assert ran.code == 0
    assert "knows differences" in ran.err


def test_what_each_sensor_forgets_is_fitted_undone_and_weighed(subskin, folder):
    """From a recording of simulated rubber to frames that are weighed by the doubt of what was undone."""
    time = np.arange(0.0, 84.0, 0.05)
    down = np.clip(np.minimum(time % 14 - 2.0, 9.0 - time % 14), 0, 1)
    position = np.linspace(-8e-3, 8e-3, 6)[(time // 14).astype(int)]
    touches = ss.LineLoad(40.0 * down, position=position)
    felt = ss.Relaxation([[0.3, 0.1, 0.1, 0.1]], [3.0]).apply(load("finger.toml").finger.read(touches), time)
    felt = felt + 5.0 * np.random.default_rng(0).standard_normal(felt.shape)
    columns = {"time": time, "x": 1e6 * position, "z": 640 * down} | {f"p{i}": felt[:, i] for i in range(4)}
    write_table("raw.csv", columns)
    with (folder / "finger.toml").open("a") as file:
        file.write(ORIENTED)
    ran = subskin("segment", "finger.toml", "raw.csv", "-o", "presses.csv", "--relaxation", "relaxed.toml")
    assert (ran.code, ran.err) == (0, "")
    assert ran.out.startswith("6 presses")
    assert "in doubt by" in ran.out
    assert "-> relaxed.toml" in ran.out
    file = ss.load("relaxed.toml")
    lost = file.relaxation.of_sensors(4)[0].sum(axis=0)
    np.testing.assert_allclose(lost, [0.3, 0.1, 0.1, 0.1], atol=0.05)
    assert 0 < file.relaxation.doubt < 0.5
    assert subskin("locate", "relaxed.toml", "raw.csv", "-o", "out.csv", "--tare").err == ""
    found = file.run(read_table("raw.csv"))["found"]
    for name, values in (("position", found.position), ("position_std", found.std[..., 0])):
        np.testing.assert_array_equal(read_table("out.csv").numbers(name), values + file.origin * (name == "position"))
    ran = subskin("decide", "relaxed.toml", "raw.csv", "--rows", "700", "--tare")
    assert ran.code == 0
    assert "does not weigh its doubt" in ran.err
    assert "it is the same file as" in subskin("segment", "finger.toml", "raw.csv", "--relaxation", "finger.toml").err
