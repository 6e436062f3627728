"""A recording made into other files, each read again by a library that did not write it."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pyarrow.parquet as pq
import pytest
from mcap.reader import make_reader
from rosbags.highlevel import AnyReader
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

import subskin as ss
from subskin.errors import FileError, UnknownOptionError
from subskin.estimate import Status
from subskin.live.convert import convert
from subskin.live.record import Recorder
from subskin.live.recording import About, opened
from subskin.live.recording.files import write_parquet
from subskin.live.recording.rows import rows_of, table_of
from subskin.live.sinks.bags import read_bag
from subskin.live.sinks.messages import DEFINITIONS, Filled, typestore

from .. import _commands
from . import _live

EPOCH = 1.7e9


@pytest.fixture(scope="module")
def finger():
    return ss.io.parse_finger(_live.TEXT)


@pytest.fixture(scope="module")
def steps(finger):
    return _live.stream(finger)


@pytest.fixture(scope="module")
def recording(finger, steps, tmp_path_factory):
    path = tmp_path_factory.mktemp("recording") / "touch.parquet"
    with Recorder(path, finger, _live.BOARD, epoch=EPOCH) as recorder:
        for made in steps:
            recorder.put(made)
    return path


@pytest.fixture(scope="module")
def mcap(recording):
    path = recording.with_name("touch.mcap")
    convert(recording, path, topic="/left/finger")
    return path


def messages(path):
    """(topic, time, message) of an MCAP file by `mcap`, decoded with nothing but the definitions in it."""
    stores = {}
    with path.open("rb") as file:
        for schema, channel, message in make_reader(file).iter_messages():
            if schema.id not in stores:
                stores[schema.id] = get_typestore(Stores.EMPTY)
                stores[schema.id].register(get_types_from_msg(schema.data.decode(), schema.name))
            yield channel.topic, message.log_time, stores[schema.id].deserialize_cdr(message.data, schema.name)


def frames_of(steps):
    return [made for made in steps if len(made.raw)]


def test_csv_holds_every_row(recording, steps, tmp_path):
    convert(recording, tmp_path / "touch.csv")
    table = ss.io.read_table(tmp_path / "touch.csv")
    rows = pq.read_table(recording)
    assert list(table.columns) == rows.schema.names
    assert len(table) == rows.num_rows
    kinds = rows["kind"].to_pylist()
    for name in ("raw.p3", "position_y", "cov.y.ty", "time"):
        np.testing.assert_array_equal(table.numbers(name), rows[name].to_numpy())
    assert kinds.count("event") == 5
    assert kinds.count("command") == 1
    assert kinds.count("step") == 1


def test_mcap_says_what_touched(mcap, steps):
    found = list(messages(mcap))
    contacts = [(time, m) for topic, time, m in found if topic == "/left/finger/contact"]
    framed = frames_of(steps)
    assert len(contacts) == sum(len(made.raw) for made in framed)
    loads = [made.found.load for made in framed]
    components, covariance = (np.concatenate([getattr(x, n) for x in loads]) for n in ("components", "covariance"))
    position, status = (np.concatenate([getattr(made.found, n) for made in framed]) for n in ("position", "status"))
    times = np.concatenate([made.time for made in framed])
    for i, (time, m) in enumerate(contacts):
        assert time == m.header.stamp.sec * 10**9 + m.header.stamp.nanosec == round(EPOCH * 1e9) + round(times[i] * 1e9)
        assert (m.header.frame_id, m.status) == ("left_finger", status[i])
        np.testing.assert_array_equal([m.position.y, m.force.x, m.force.y], [position[i], *components[i]])
        assert m.covariance_of == ["y", "n", "ty"]
        np.testing.assert_array_equal(m.covariance.reshape(3, 3), covariance[i])
        assert (m.unit, m.length) == ("N/m", 0.01) if status[i] == 0 else m.unit == "" and np.isnan(m.length)
        assert m.slip == m.NOT_ASKED == 255
    assert {m.OK for _, m in contacts} == {0}
    raw = [m for topic, _, m in found if topic == "/left/finger/raw"]
    table = np.array([m.sensors[0].values for m in raw])
    np.testing.assert_array_equal(table, np.concatenate([made.raw for made in framed]).astype(np.float32))
    events = [m for topic, _, m in found if topic == "/left/finger/events"]
    assert [m.kind for m in events] == [*["contact_on"] * 4, "zeroed"]
    assert json.loads(events[0].values) == {"force": 40.0, "far": None}


def test_a_wrench_is_in_newtons_about_the_origin_of_the_frame(mcap, steps):
    wrenches = [m.wrench for topic, _, m in messages(mcap) if topic.endswith("/wrench")]
    found = [made.found for made in frames_of(steps)]
    expected = []
    for estimate in found:
        for one in estimate:
            if one.status == 2:
                expected.append(np.zeros(6))
            elif one.status == 0:
                force = np.array([*one.load.components, 0.0]) * 0.01
                expected.append([*force, *np.cross([0.0, float(one.position), 0.0], force)])
    told = [[*(getattr(w.force, a) for a in "xyz"), *(getattr(w.torque, a) for a in "xyz")] for w in wrenches]
    assert len(told) > 20
    assert np.count_nonzero(np.abs(expected)[:, [0, 5]].min(axis=1)) > 10  # presses, and they turn about z
    np.testing.assert_allclose(told, expected, rtol=1e-14, equal_nan=False)


def test_a_contact_that_is_not_sure_has_no_wrench(finger, steps):
    about, store = About.for_finger(finger, _live.CHANNELS, EPOCH, "csv"), typestore()
    for status in Status:
        found = steps[2].found
        table = found.table.copy()
        table[:, found.layout.status] = status
        made = _live.step(1.0, steps[2].raw, readings=steps[2].raw, found=replace(found, table=table))
        told = Filled(about, store.types.__getitem__).of(table_of(about, [made]))
        wrenches = [m.content.wrench for m in told if m.topic == "/subskin/wrench"]
        assert len(wrenches) == (len(made.raw) if status in (Status.OK, Status.NO_CONTACT) else 0)
        assert all((w.force.x == 0) == (status == Status.NO_CONTACT) for w in wrenches)


def test_without_a_length_there_are_no_newtons_and_it_is_said(finger, steps, tmp_path):
    short = ss.io.parse_finger(_live.TEXT.split("[touch]")[0])
    path = tmp_path / "touch.parquet"
    with Recorder(path, short, _live.BOARD) as recorder:
        recorder.put(steps[2])
    done = _commands.subskin("convert", path, tmp_path / "touch.mcap")
    assert done.code == 0
    assert "no WrenchStamped" in done.err
    assert "[touch] length" in done.err
    topics = {topic for topic, *_ in messages(tmp_path / "touch.mcap")}
    assert topics == {"/subskin/raw", "/subskin/readings", "/subskin/contact", "/subskin/events"}


def test_on_an_area_forces_are_newtons(tmp_path):
    text = """\
[skin]
kind = "half_space"
young = "0.4 MPa"

[sensors]
layout = "grid"
shape = [3, 3]
pitch = "3 mm"
depth = "3 mm"
noise = 1e-4
"""
    file = ss.io.parse_finger(text)
    raw = file.finger.read(ss.PointLoad(force=1.5, angle=0.3, azimuth=0.8, position=(1e-3, -2e-3)))[None]
    found = file.locate(raw)
    about = About.for_finger(file, [f"c{i}" for i in range(9)], EPOCH, "board")
    made = _live.step(1.0, raw, readings=raw, found=found)
    path = tmp_path / "area.parquet"
    write_parquet(path, about, [rows_of(about, [made])], "yes")
    convert(path, tmp_path / "area.mcap")
    told = {topic.split("/")[-1]: m for topic, _, m in messages(tmp_path / "area.mcap")}
    contact, wrench = told["contact"], told["wrench"].wrench
    force, at = found.load.components[0], np.array([0.0, *found.position[0]])
    np.testing.assert_array_equal([contact.position.x, contact.position.y, contact.position.z], at)
    assert contact.unit == "N"
    assert contact.covariance_of == ["y", "z", "n", "ty", "tz"]
    np.testing.assert_array_equal(contact.covariance.reshape(5, 5), found.load.covariance[0])
    np.testing.assert_array_equal([wrench.force.x, wrench.force.y, wrench.force.z], force)
    torque = [wrench.torque.x, wrench.torque.y, wrench.torque.z]
    assert np.abs(torque).min() > 1e-5
    np.testing.assert_allclose(torque, np.cross(at, force), rtol=1e-13, equal_nan=False)


def test_rosbag2_is_read_by_rosbags(recording, mcap, tmp_path):
    convert(recording, tmp_path / "bag", "rosbag2", topic="/left/finger")
    with AnyReader([tmp_path / "bag"]) as reader:
        told = [(c.topic, time, bytes(data)) for c, time, data in reader.messages()]
    with mcap.open("rb") as file:
        other = [(c.topic, m.log_time, m.data) for _, c, m in make_reader(file).iter_messages()]
    assert sorted(told) == sorted(other)
    assert len(told) > 200
    with pytest.raises(FileError, match="already"):
        convert(recording, tmp_path / "bag", "rosbag2")


@pytest.mark.parametrize("kind", ["mcap", "rosbag2"])
def test_a_bag_becomes_a_recording(recording, mcap, steps, tmp_path, kind):
    bag = mcap
    if kind == "rosbag2":
        bag = tmp_path / "bag"
        convert(recording, bag, kind, topic="/left/finger")
    target = tmp_path / "again.parquet"
    done = _commands.subskin("convert", bag, target, "--topic", "/left/finger/raw")
    framed = frames_of(steps)
    raw = np.concatenate([made.raw for made in framed]).astype(np.float32)
    assert done.code == 0
    assert f"{len(raw)} frames" in done.out
    with opened(target) as again:
        found = list(again.steps())
        assert (again.about.finger, again.about.channels) == (_live.TEXT, ("s0", "s1", "s2", "s3"))
    np.testing.assert_array_equal(np.concatenate([step.frames.values for step in found]), raw)
    times = np.concatenate([made.time for made in framed])
    np.testing.assert_allclose([step.host_time for step in found], times - times[0], atol=1e-9)
    done = _commands.subskin("convert", bag, tmp_path / "no.parquet")
    assert done.code == 2
    assert "/left/finger/raw, /left/finger/readings" in done.err


def test_an_mcap_that_was_cut_gives_what_is_in_it(recording, tmp_path):
    from subskin.live.sinks.messages import CHUNK

    assert CHUNK <= 1 << 18
    about = None
    with opened(recording) as source:
        about = source.about
        batches = list(source.batches())
    long, cut = tmp_path / "long.parquet", tmp_path / "cut.mcap"
    write_parquet(long, about, batches * 12, "yes")
    convert(long, cut)
    data = cut.read_bytes()
    cut.write_bytes(data[: len(data) * 2 // 3])
    count, left = read_bag(cut, tmp_path / "cut.parquet", "/subskin/raw")
    assert 0 < count < 12 * 60
    assert "after byte" in left


def test_lerobot_has_ticks_episodes_and_statistics(finger, steps, tmp_path):
    path, folder = tmp_path / "touch.parquet", tmp_path / "set"
    framed = [made for made in frames_of(steps) for _ in [0]]
    late = [_live.step(made.host_time + 30.0, made.raw, readings=made.readings, found=made.found) for made in framed]
    with Recorder(path, finger, _live.BOARD) as recorder:
        for made in framed + late:
            recorder.put(made)
    convert(path, folder, "lerobot", fps=100, task="pick it up")
    info = json.loads((folder / "meta/info.json").read_text())
    data = pq.read_table(folder / info["data_path"].format(chunk_index=0, file_index=0))
    assert (info["codebase_version"], info["fps"], info["total_episodes"]) == ("v3.0", 100, 2)
    assert set(info["features"]) == set(data.schema.names)
    rows = data.to_pylist()
    assert len(rows) == info["total_frames"]
    assert [row["index"] for row in rows] == list(range(len(rows)))
    time, raw = (np.concatenate([getattr(made, n) for made in framed]) for n in ("time", "raw"))
    for row in rows:
        np.testing.assert_allclose(row["timestamp"], row["frame_index"] / 100, rtol=1e-6)
        latest = np.flatnonzero(time <= time[0] + row["frame_index"] / 100 + 1e-9)[-1]
        np.testing.assert_array_equal(row["observation.tactile.raw"], raw[latest].astype(np.float32))
    episodes = pq.read_table(folder / "meta/episodes/chunk-000/file-000.parquet").to_pylist()
    assert [e["length"] for e in episodes] == [sum(row["episode_index"] == k for row in rows) for k in (0, 1)]
    assert [(e["dataset_from_index"], e["tasks"]) for e in episodes] == [
        (0, ["pick it up"]), (episodes[0]["length"], ["pick it up"])
    ]  # fmt: skip
    told = json.loads((folder / "meta/stats.json").read_text())["observation.tactile.readings"]
    readings = np.array([row["observation.tactile.readings"] for row in rows])
    np.testing.assert_allclose(told["mean"], readings.mean(axis=0), rtol=1e-5, atol=1e-9)
    np.testing.assert_allclose(told["std"], readings.std(axis=0), rtol=1e-5)
    assert told["max"] == readings.max(axis=0).tolist()
    assert told["count"] == [len(rows)]
    assert [p.name for p in tmp_path.iterdir() if p.name.startswith(".")] == []


def test_what_is_asked_in_vain_is_said(recording, tmp_path):
    for target, kind, options, error in (
        ("touch.xyz", None, {}, FileError),
        ("touch", "hdf5", {}, UnknownOptionError),
        ("touch.csv", None, {"fps": 3}, UnknownOptionError),
        ("touch.mcap", None, {"topic": "left"}, ss.errors.InvalidValueError),
        ("touch", "lerobot", {"fps": 0.0}, ss.errors.InvalidValueError),
        ("none/touch.csv", None, {}, FileError),
    ):
        with pytest.raises(error):
            convert(recording, tmp_path / target, kind, **options)
    assert list(tmp_path.iterdir()) == []
    done = _commands.subskin("convert", recording, recording)
    assert done.code == 2
    assert "same file" in done.err
    done = _commands.subskin("recover", tmp_path / "none.arrows")
    assert done.code == 2
    assert "no such file" in done.err


def test_a_recording_that_was_not_closed_is_not_converted(recording, finger, steps, tmp_path):
    path = tmp_path / "touch.arrows"
    with Recorder(path, finger, _live.BOARD) as recorder:
        recorder.put(steps[0])
    path.write_bytes(path.read_bytes()[:-8])
    with pytest.raises(FileError, match="subskin recover"):
        convert(path, tmp_path / "touch.csv")
    assert not (tmp_path / "touch.csv").exists()
    done = _commands.subskin("recover", path, "--json")
    assert json.loads(done.out)["frames"] == 5


def test_a_hostile_bag_is_refused(mcap, tmp_path):
    data, rng, path = mcap.read_bytes(), np.random.default_rng(2), tmp_path / "bad.mcap"
    refused = 0
    for k in range(60):
        bad = bytearray(data if k % 3 else data[: int(rng.integers(len(data)))])
        for _ in range(int(rng.integers(1, 30))):
            at = int(rng.integers(len(bad) or 1))
            bad[at : at + 8] = rng.bytes(8) if k % 2 else (2 ** int(rng.integers(64)) - 1).to_bytes(8, "little")
        path.write_bytes(bytes(bad))
        try:
            read_bag(path, tmp_path / "out.parquet", "/left/finger/raw")
        except FileError:
            refused += 1
    assert refused > 20


def test_the_package_for_ros_has_the_same_messages():
    folder = Path(__file__).parents[2] / "ros2" / "subskin_msgs" / "msg"
    if not folder.is_dir():
        pytest.skip("only the package's source has it")
    for kind in ("Contact", "Event"):
        assert (folder / f"{kind}.msg").read_text() == DEFINITIONS[f"subskin_msgs/msg/{kind}"]
