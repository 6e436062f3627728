"""A recording run again gives the same bits, and with another finger that finger's answers."""

from __future__ import annotations

import json
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

import subskin as ss
from subskin.errors import FileError, InvalidValueError
from subskin.live.chain import Chain
from subskin.live.frames import DeviceFrames
from subskin.live.record import Recorder
from subskin.live.recording import opened, recover
from subskin.live.replay import Replay, replay
from subskin.measured import MeasuredResponse

from .. import _commands
from . import _live


@pytest.fixture(scope="module")
def finger():
    return ss.io.parse_finger(_live.TEXT)


@pytest.fixture(scope="module")
def session(finger, tmp_path_factory):
    """A recording of a device that loses frames, is unplugged, begins again; touched, marked and zeroed."""
    path = tmp_path_factory.mktemp("session") / "touch.parquet"
    chain = Chain(finger, channels=_live.CHANNELS, slip=(0.4, 0.8))
    rng, state, made = np.random.default_rng(9), None, []
    time = np.arange(600) * 2e-3
    force = 40.0 * ((time % 0.5) > 0.3)
    raw = finger.finger.read(ss.LineLoad(force, angle=0.2, position=0.4e-3), rng) + 0.3 + 1e-4 * time[:, None]
    raw[33, 1] = np.nan
    device = np.where(time < 0.9, time, time - 0.9) + 7.0
    at = 0
    with Recorder(path, finger, _live.BOARD, options=chain.options) as recorder:

        def step(*given):
            nonlocal state
            state, batch = chain.step(state, *given)
            recorder.put(batch)
            made.append(batch)

        none = DeviceFrames(np.empty((0, 4)))
        while at < len(time):
            count = int(rng.integers(0, 12))
            part = slice(at, at + count)
            host = 50.0 + time[min(at + count, 599)] + 1e-3 * rng.random()
            numbers = np.arange(at, at + len(time[part])) + at // 300
            step(DeviceFrames(raw[part], device[part], numbers, lost=int(at == 300), bad=int(rng.integers(2))), host)
            at += count
            if len(made) in (20, 40, 45, 60):
                command = {20: "mark", 40: "port_lost", 45: "port_back", 60: "zero"}[len(made)]
                step(none, host + 1e-4, command, {"text": "so"} if command == "mark" else {})
    return path, made


def equal(a, b):
    for name in ("time", "device_time", "sequence", "raw", "readings", "free"):
        assert getattr(a, name).tobytes() == getattr(b, name).tobytes(), name
    assert (a.found is None) == (b.found is None)
    if a.found is not None:
        assert a.found.table.tobytes() == b.found.table.tobytes()
        assert a.decision.probability.tobytes() == b.decision.probability.tobytes()
    assert [(e.kind, e.time, e.frame, e.text) for e in a.events] == [
        (e.kind, e.time, e.frame, e.text) for e in b.events
    ]


def test_the_same_steps_give_the_same_bits(session):
    path, made = session
    kinds = {event.kind for batch in made for event in batch.events}
    assert {"contact_on", "contact_off", "mark", "zeroed", "port_lost", "port_back", "reset"} <= kinds
    again = list(replay(path))
    assert len(again) == len(made)
    for a, b in zip(again, made, strict=True):
        equal(a, b)


def test_a_stream_that_was_cut_gives_the_same_up_to_the_cut(session, finger, tmp_path):
    _path, made = session
    cut = tmp_path / "touch.parquet.arrows"
    with Recorder(cut, finger, _live.BOARD, options=Chain(finger, slip=(0.4, 0.8)).options) as recorder:
        for batch in made:
            recorder.put(batch)
    cut.write_bytes(cut.read_bytes()[:-100])
    with opened(recover(cut).path) as recording:
        for a, b in zip(Replay(recording), made, strict=False):
            equal(a, b)


def test_it_says_whether_it_came_out_as_recorded(session, finger):
    path, _ = session
    with opened(path) as recording:
        same = Replay(recording)
        for _ in same:
            pass
        assert same.same is not None
        assert same.same.rows > 600
        assert same.same.others == 0
    with opened(path) as recording:
        other = Replay(recording)
        other.chain = Chain(finger, slip=(0.2, 0.4))
        for _ in other:
            pass
        assert other.same.others > 50
        assert {"slip_ratio", "slip_probability"} <= other.same.different
        assert other.same.different <= {"slip", "slip_ratio", "slip_probability", "events"}


def test_another_finger_gives_its_own_answers(session, finger, tmp_path):
    path, made = session
    twice = ss.io.parse_finger(_live.TEXT.replace("0.4 MPa", "0.8 MPa"))
    with opened(path) as recording:
        for a, b in zip(Replay(recording, twice), made, strict=True):
            if len(a.raw):
                np.testing.assert_allclose(a.found.force, 2 * b.found.force, rtol=1e-6)
    (tmp_path / "twice.toml").write_text(twice.text)
    again = tmp_path / "again.parquet"
    done = _commands.subskin("replay", path, "--finger", tmp_path / "twice.toml", "-o", again)
    assert (done.code, done.err) == (0, "")
    assert "600 frames" in done.out
    with opened(again) as recording:
        assert recording.about.finger == twice.text
        table = [row for rows in recording.batches() for row in rows.column("kind").to_pylist()]
        assert table.count("frame") == 600
    done = _commands.subskin("replay", again)
    assert "to the last bit" in done.out


def test_a_part_is_shown_as_it_is_in_the_whole(session):
    path, made = session
    whole = {batch.host_time: batch for batch in made}
    shown = list(replay(path, begin=0.4, end=0.8, speed=50.0))
    start = made[0].host_time
    assert 0.4 <= shown[0].host_time - start
    assert shown[-1].host_time - start <= 0.8
    assert len(shown) == sum(0.4 <= host - start <= 0.8 for host in whole)
    for batch in shown:
        equal(batch, whole[batch.host_time])


def test_the_command_line(session, tmp_path):
    path, _made = session
    done = _commands.subskin("replay", path, "--json")
    told = json.loads(done.out)
    assert (told["frames"], told["same"], told["different_rows"]) == (600, True, 0)
    assert told["events"]["mark"] == 1
    done = _commands.subskin("replay", path)
    assert "mark: so" in done.out
    assert "rows as they were recorded, to the last bit" in done.out
    for wrong in (["--speed", "0"], ["--from", "2 s", "--to", "1 s"], ["--from", "x"], ["--finger", "none.toml"]):
        done = _commands.subskin("replay", path, *wrong)
        assert done.code == 2
        assert done.err.startswith("subskin: error:")
    with pytest.raises(InvalidValueError), opened(path) as recording:
        Replay(recording, speed=-1.0)
    with pytest.raises(FileError):
        next(replay(tmp_path / "none.parquet"))


def test_at_a_speed_it_is_shown_as_it_happened(session):
    path, _ = session
    done = _commands.subskin("replay", path, "--speed", "20")
    assert done.code == 0
    assert "mark: so" in done.out
    assert "frames/s" in done.out
    assert "to the last bit" in done.out


def test_a_finger_with_a_response_in_place_has_to_be_given(tmp_path):
    text = (
        '[skin]\nkind = "half_space"\nyoung = 4e5\n[sensors]\nlayout = "grid"\nshape = [3, 3]\npitch = "4 mm"\n'
        'depth = "4 mm"\nkind = "mean_pressure"\nnoise = 5\n[locate]\nfriction = 0\n'
    )
    drawn = ss.io.parse_finger(text)
    axis = np.linspace(-5e-3, 5e-3, 8)
    at = np.stack(np.meshgrid(axis, axis), axis=-1).reshape(-1, 2)
    readings = drawn.finger.read(ss.PointLoad(2.0, position=at), np.random.default_rng(0))
    measured = replace(drawn.finger, measured=MeasuredResponse.from_touches(readings, at))
    ss.io.save_finger(drawn.with_finger(measured, (0.0, 0.0)), tmp_path / "calibrated.toml")
    file = ss.load(tmp_path / "calibrated.toml")
    board = SimpleNamespace(channels=file.names, name="board")
    state, chain = None, Chain(file)
    with Recorder(tmp_path / "x.parquet", file, board) as recorder:
        for k, load in enumerate((0.0, 0.0, 2.0)):
            raw = file.finger.read(ss.PointLoad(load, position=(1e-3, -2e-3)))
            state, batch = chain.step(state, DeviceFrames(raw[None], [0.1 * k]), 0.1 * k)
            recorder.put(batch)
    with opened(tmp_path / "x.parquet") as recording, pytest.raises(FileError, match="--finger with the file"):
        Replay(recording)
    with opened(tmp_path / "x.parquet") as recording:
        again = list(Replay(recording, file))
    assert again[-1].found.position[0] == pytest.approx([1e-3, -2e-3], abs=0.2e-3)
    assert again[-1].found.table.tobytes() == batch.found.table.tobytes()


def test_a_csv_of_a_recording_is_refused_with_what_to_do(session, tmp_path):
    from subskin.live.convert import convert

    convert(session[0], tmp_path / "touch.csv")
    with pytest.raises(FileError, match=r"has no finger in it.*subskin convert"), opened(tmp_path / "touch.csv"):
        pass
