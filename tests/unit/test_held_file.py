"""[relaxation] of each sensor and its doubt: in a finger file, in its presses, its streams and live."""

from __future__ import annotations

import numpy as np
import pytest

import subskin as ss
from subskin.errors import FileError, GeometryError, InvalidValueError
from subskin.live import Chain, DeviceFrames

FILE = """\
[skin]
young = "0.4 MPa"

[sensors]            # four gauges
count = 4
pitch = "2 mm"
depth = "2 mm"
noise = 1e-4

[locate]
friction = 0
search = ["-5 mm", "5 mm"]

[recording]
sensors = ["a", "b", "c", "d"]
time = { column = "t", unit = "s" }
position = { column = "y", unit = "m" }
press = { column = "z", unit = "m" }
"""
HELD = '\n[relaxation]\nshare = [[0.3, 0.1, 0.1, 0.1]]\ntime = ["3 s"]\ndoubt = 0.3\n'
LATER = '\n[calibration]\norigin = "1 mm"\n'
SHARE = np.array([[0.3, 0.1, 0.1, 0.1]])


def recording(file, folder, presses=7):
    """Presses along the row, held for 6 s, on rubber whose first sensor forgets most; a table."""
    time = np.arange(0.0, 14.0 * presses, 0.05)
    down = np.clip(np.minimum(time % 14 - 2.0, 9.0 - time % 14), 0, 1)
    position = np.linspace(-3e-3, 3e-3, presses)[(time // 14).astype(int)]
    readings = file.finger.read(ss.LineLoad(40.0 * down, position=position))
    felt = ss.Relaxation(SHARE, [3.0], rest=0.0).apply(readings, time)
    felt = felt + 1e-4 * np.random.default_rng(0).standard_normal(felt.shape)
    columns = {"t": time, "y": position, "z": 2e-3 * down} | dict(zip("abcd", felt.T))
    ss.io.write_table(folder / "raw.parquet", columns)
    return ss.io.read_table(folder / "raw.parquet"), readings


@pytest.fixture(scope="module")
def files(tmp_path_factory):
    plain, held = (ss.io.parse_finger(FILE + more) for more in ("", HELD))
    return plain, held, *recording(plain, tmp_path_factory.mktemp("held"))


def test_the_file_says_each_sensor_s_share_and_the_doubt(files):
    np.testing.assert_array_equal(files[1].relaxation.share, SHARE)
    assert files[1].relaxation.doubt == 0.3
    with pytest.raises(FileError, match="share of 3 sensors"):
        ss.io.parse_finger(FILE + HELD.replace("0.3, 0.1,", "0.3,"))
    grid = FILE.replace("count = 4", 'layout = "grid"\nshape = [2, 2]').split("[locate]")[0]
    grid = grid.replace('"0.4 MPa"', '"0.4 MPa"\nkind = "half_space"')
    assert ss.io.parse_finger(grid + HELD.replace("doubt = 0.3", "")).relaxation is not None
    with pytest.raises(FileError, match="on an area"):
        ss.io.parse_finger(grid + HELD)


def test_what_a_recording_says_is_written_and_read_again(files):
    plain, _, table, _ = files
    fit = ss.io.fit_held(plain, table, terms=1)
    np.testing.assert_allclose(fit.own.share, SHARE, atol=0.01, equal_nan=False)
    np.testing.assert_allclose(fit.own.time, [3.0], rtol=0.05, equal_nan=False)
    assert fit.own.doubt < 0.1
    before = ss.io.parse_finger(FILE + HELD + LATER, "mine.toml")
    written = ss.io.with_relaxation(before, fit.own)
    again = ss.io.parse_finger(written.text, "mine.toml")
    for name in ("share", "time", "doubt"):
        np.testing.assert_array_equal(getattr(again.relaxation, name), getattr(written.relaxation, name))
    assert again.origin == before.origin
    assert "# four gauges" in written.text
    assert written.text.count("[relaxation]") == 1
    assert written.text.index("[relaxation]") < written.text.index("[calibration]")
    assert ss.io.with_relaxation(plain.of_differences(), fit.own).differences
    with pytest.raises(GeometryError, match="of 3 sensors"):
        ss.io.with_relaxation(plain, ss.Relaxation([[0.1, 0.2, 0.3]], [1.0]))
    with pytest.raises(InvalidValueError, match="table"):
        ss.io.fit_held(plain, [[1.0, 2.0]])


def test_presses_are_those_of_the_skin_undone(files):
    plain, held, table, elastic = files
    expected = elastic[(table.numbers("t") % 14 - 4.0).round(6) == 0]
    largest = np.abs(expected).max()
    as_read, undone = (np.abs(file.segment(table).reading - expected).max() / largest for file in (plain, held))
    assert as_read > 0.1
    assert undone < 0.01


def test_a_stream_weighs_each_frame_by_its_doubt_at_once_and_frame_by_frame(files):
    plain, held, table, _ = files
    out, time = held.run(table), table.numbers("t")
    # of the offset too, which is known the less the longer the touch lasts: by 0.3 of the noise a second
    own = np.sqrt(out["tare"].doubt ** 2 - out["relaxation"].doubt ** 2)
    begin, end = (np.searchsorted(time, at) for at in (4.0, 8.0))
    np.testing.assert_allclose(own[end] - own[begin], 0.3 * 1e-4 * 4.0, rtol=1e-6, equal_nan=False)
    late, early = (np.abs(time % 14 - at) < 0.02 for at in (8.0, 3.2))
    # undone by the same shares without a doubt
    sure = ss.io.parse_finger(FILE + HELD.replace("doubt = 0.3", "")).run(table)
    assert sure["tare"].doubt is None
    wider = out["found"].std[:, 0] / sure["found"].std[:, 0]
    # between two sensors; above one of them its doubt says nothing
    assert 1 < np.nanmax(wider[early]) < 2.5 < 4 < np.nanmax(wider[late])
    tared = held.tare(table)
    found = held.locate(tared.readings, doubt=tared.doubt)
    np.testing.assert_array_equal(found.table, out["found"].table)
    chain, state, live = Chain(held), None, []
    chain.prepare()
    readings = table.readings(held.names)[:260]
    for k in range(0, len(readings), 4):
        part = slice(k, k + 4)
        state, batch = chain.step(state, DeviceFrames(readings[part], time[part]), float(time[part][-1]))
        live.append(batch.found)
    np.testing.assert_array_equal(ss.Estimate.join(live).table, out["found"].table[:260])
    assert np.isfinite(plain.run(table)["found"].position).any()


def test_an_answer_that_takes_no_doubt_gets_the_readings_alone(files):
    _, held, table, _ = files
    out = held.run(table, answer=np.sum)
    assert out["found"] == out["tare"].readings.sum()
