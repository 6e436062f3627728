"""A recording: nothing is left out, killed or cut it can be read, damaged it says so, and a full disk ends only it."""

from __future__ import annotations

import resource
import subprocess
import sys
import threading
import time
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest

import subskin as ss
from subskin.errors import FileError, InvalidValueError
from subskin.live.record import Recorder
from subskin.live.recording import About, opened, recover
from subskin.live.recording.files import Growing
from subskin.live.recording.rows import Counted

from . import _live

WAIT = 30.0  # seconds; what takes longer hangs
EACH = 3  # steps in a batch of the stream


@pytest.fixture(scope="module")
def finger():
    return ss.io.parse_finger(_live.TEXT)


@pytest.fixture(scope="module")
def steps(finger):
    return _live.stream(finger)


@pytest.fixture(scope="module")
def growing(finger, steps, tmp_path_factory):
    """The bytes of a stream of several batches, after which byte each batch is whole, and where the first begins."""
    path = tmp_path_factory.mktemp("stream") / "touch.arrows"
    about = About.for_finger(finger, _live.CHANNELS, 0.0, "csv")
    file, counted, ends = Growing(path, about), Counted(about), []
    start = path.stat().st_size
    for first in range(0, len(steps), EACH):
        file.append(counted.rows(steps[first : first + EACH]))
        ends.append(path.stat().st_size)
    file.end()
    file.close()
    return path.read_bytes(), ends, start


def same(step, made):
    frames = step.frames
    for name in ("device_time", "sequence"):
        np.testing.assert_array_equal(getattr(frames, name), getattr(made, name))
    assert frames.values.tobytes() == made.raw.tobytes()  # -0 and NaN too
    assert (step.host_time, step.command, dict(step.values)) == (made.host_time, made.command, made.values)
    assert (frames.lost, frames.bad) == (made.lost, made.bad)


def steps_in(path):
    with opened(path) as recording:
        found = list(recording.steps())
    return found, recording


def test_what_went_in_comes_out(finger, steps, tmp_path):
    with Recorder(tmp_path / "touch.parquet", finger, _live.BOARD, options={"rate": 2}, epoch=1.5e9) as recorder:
        for made in steps:
            recorder.put(made)
        assert [path.name for path in tmp_path.iterdir()] == ["touch.parquet.arrows"]
    assert [path.name for path in tmp_path.iterdir()] == ["touch.parquet"]
    found, recording = steps_in(tmp_path / "touch.parquet")
    assert len(found) == len(steps)
    for step, made in zip(found, steps, strict=True):
        same(step, made)
    about = recording.about
    assert (about.finger, about.channels, about.names) == (_live.TEXT, _live.CHANNELS, finger.names)
    assert (about.epoch, about.length, dict(about.options), about.driver) == (1.5e9, 0.01, {"rate": 2}, "csv")
    assert {"subskin", "numpy", "python"} <= set(about.versions)


def test_the_rows_say_what_was_found(finger, steps, tmp_path):
    with Recorder(tmp_path / "touch.parquet", finger, _live.BOARD) as recorder:
        for made in steps:
            recorder.put(made)
    rows = pq.read_table(tmp_path / "touch.parquet").to_pylist()
    frames = [row for row in rows if row["kind"] == "frame"]
    framed = [made for made in steps if len(made.raw)]
    expected = np.concatenate([made.found.position for made in framed])
    np.testing.assert_array_equal([row["position_y"] for row in frames], expected)
    loads = [made.found.load for made in framed]
    components, covariance = (np.concatenate([getattr(x, n) for x in loads]) for n in ("components", "covariance"))
    np.testing.assert_array_equal([(row["normal"], row["drag_y"]) for row in frames], components)
    np.testing.assert_array_equal([row["cov.n.ty"] for row in frames], covariance[:, 1, 2])
    assert {row["load"] for row in frames if row["status"] == "ok"} == {"line"}
    assert {row["status"] for row in frames} >= {"ok", "no_contact"}
    assert [row["frame"] for row in frames] == list(range(len(frames)))
    events = [(row["name"], row["text"], row["values"]) for row in rows if row["kind"] == "event"]
    assert events[0] == ("contact_on", "contact_on at 0.02", '{"force": 40.0, "far": null}')
    assert ("zeroed", "zeroed at 10.065", "") in events
    order = [(row["step"], row["kind"] == "event") for row in rows]
    assert order == sorted(order)


def test_a_stream_that_is_cut_gives_what_is_whole(growing, steps, tmp_path):
    data, ends, start = growing
    path = tmp_path / "cut.arrows"
    head, rows = 0, [(len(made.raw) or 1) + len(made.events) for made in steps]
    rows = [sum(rows[first : first + EACH]) for first in range(0, len(rows), EACH)]
    for cut in range(0, len(data), 97):
        path.write_bytes(data[:cut])
        try:
            with opened(path) as recording:
                count = sum(batch.num_rows for batch in recording.batches())
        except FileError as error:
            head = cut if "cut off in its head" in error.rule else -1
            continue
        assert count == sum(n for n, end in zip(rows, ends, strict=True) if end <= cut)
        assert (recording.left == "") == (cut in (*ends, start))
        assert not recording.closed
    assert 0 < head < start + 97
    found, _ = steps_in(path)
    assert len(found) >= len(steps) - EACH
    for step, made in zip(found, steps, strict=False):
        same(step, made)


@pytest.mark.parametrize("tail", [b"\0" * 512, b"\xff\xff\xff\xff\x40\x42\x0f\0" + b"x" * 64, b"\xff" * 99, b"PAR1"])
def test_garbage_after_the_last_batch_is_left(growing, steps, tmp_path, tail):
    data, ends, _ = growing
    steps = steps[: (len(ends) - 1) * EACH]
    old = tmp_path / "touch.parquet.arrows"
    old.write_bytes(data[: ends[-2]] + tail)
    found = recover(old)
    assert (found.path, found.closed) == (tmp_path / "touch.parquet", False)
    assert str(len(tail)) in found.left
    assert found.frames == sum(len(made.raw) for made in steps)
    assert old.read_bytes() == data[: ends[-2]] + tail
    for step, made in zip(steps_in(found.path)[0], steps, strict=True):
        same(step, made)


def test_recover_of_a_whole_one_keeps_all_and_writes_over_nothing(growing, tmp_path):
    data, *_ = growing
    old = tmp_path / "touch.parquet.arrows"
    old.write_bytes(data)
    found = recover(old)
    assert (found.left, found.closed) == ("", True)
    with pytest.raises(FileError, match="already"):
        recover(old)
    with pytest.raises(FileError, match="same file"):
        recover(old, old)
    old.write_bytes(data[:200])
    with pytest.raises(FileError, match="cut off in its head"):
        recover(old, tmp_path / "none.parquet")
    assert not (tmp_path / "none.parquet").exists()


def flipped(data, rng, count):
    for at in rng.integers(len(data), size=count):
        bad = bytearray(data)
        bad[at] ^= 1 << int(rng.integers(8))
        yield bytes(bad)


def test_a_bit_that_flips_in_a_stream_is_noticed(growing, steps, tmp_path):
    path, refused, noticed = tmp_path / "bad.arrows", 0, 0
    for bad in flipped(growing[0], np.random.default_rng(5), 60):
        path.write_bytes(bad)
        try:
            found, recording = steps_in(path)
        except FileError:
            refused += 1
            continue
        noticed += recording.left != ""
        whole = {made.host_time: made for made in steps}
        for step in found:  # what is given is right, always
            same(step, whole[step.host_time])
        assert recording.left or len(found) == len(steps)
    assert refused > 0
    assert noticed > 20


def test_a_bit_that_flips_in_a_closed_recording_is_noticed(finger, steps, tmp_path):
    good, bad_path = tmp_path / "touch.parquet", tmp_path / "bad.parquet"
    with Recorder(good, finger, _live.BOARD) as recorder:
        for made in steps:
            recorder.put(made)
    refused = 0
    for bad in flipped(good.read_bytes(), np.random.default_rng(6), 60):
        bad_path.write_bytes(bad)
        try:
            found, _ = steps_in(bad_path)
        except FileError:
            refused += 1
            continue
        for step, made in zip(found, steps, strict=True):
            same(step, made)
    assert refused > 25


def test_a_head_that_was_changed_is_refused(finger, growing, tmp_path):
    with Recorder(tmp_path / "touch.parquet", finger, _live.BOARD):
        pass
    for data in (growing[0], (tmp_path / "touch.parquet").read_bytes()):
        assert data.count(b"0.4 MPa") >= 1
        bad = tmp_path / "bad"
        bad.write_bytes(data.replace(b"0.4 MPa", b"0.5 MPa"))  # a good finger, but not the one that was recorded
        with pytest.raises(FileError, match="differs from its checksum"):
            steps_in(bad)


def test_a_full_disk_ends_the_recording_and_nothing_else(finger, steps, tmp_path):
    told = []
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    recorder = Recorder(tmp_path / "touch.parquet", finger, _live.BOARD, tell=told.append)
    part = tmp_path / "touch.parquet.arrows"
    most = part.stat().st_size + 50_000
    resource.setrlimit(resource.RLIMIT_FSIZE, (most, before[1]))
    try:
        deadline = time.monotonic() + WAIT
        put = 0
        while not recorder.failed and time.monotonic() < deadline:
            recorder.put(steps[0])
            put += 1
            time.sleep(0.02)
        for made in steps:
            recorder.put(made)  # the stream goes on
        failed = recorder.close()
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)
    assert told == [failed]
    assert "File too large" in failed
    assert str(part) in failed
    assert not (tmp_path / "touch.parquet").exists()
    found = recover(part)
    assert found.left == ""
    assert found.frames == recorder.frames
    assert 0 < recorder.frames < put * len(steps[0].raw)


def test_who_brings_frames_waits_for_a_slow_disk(finger, steps, tmp_path, monkeypatch):
    monkeypatch.setattr("subskin.live.record._FRAMES", 40)
    free, slow, append = threading.Event(), threading.Event(), Growing.append

    def late(self, batch):
        slow.set()
        assert free.wait(WAIT)
        append(self, batch)

    recorder = Recorder(tmp_path / "touch.parquet", finger, _live.BOARD)
    monkeypatch.setattr(Growing, "append", late)
    total, brought = 60, []

    def bring():
        for i in range(total):
            recorder.put(steps[0])
            brought.append(i)

    thread = threading.Thread(target=bring, daemon=True)
    thread.start()
    assert slow.wait(WAIT)
    thread.join(0.3)
    assert thread.is_alive()
    assert len(brought) <= 2 * 40 // 5
    free.set()
    thread.join(WAIT)
    assert not thread.is_alive()
    assert recorder.close() == ""
    assert recorder.frames == total * len(steps[0].raw)
    assert len(steps_in(tmp_path / "touch.parquet")[0]) == total


def test_a_recording_is_never_written_over(finger, steps, tmp_path):
    path = tmp_path / "touch.parquet"
    with Recorder(path, finger, _live.BOARD) as recorder:
        with pytest.raises(FileError, match=r"subskin recover"):
            Recorder(path, finger, _live.BOARD)
        with pytest.raises(InvalidValueError, match="4 channels"):
            recorder.put(_live.step(0.0, np.zeros((1, 3))))
    with pytest.raises(FileError, match="already"):
        Recorder(path, finger, _live.BOARD)
    with pytest.raises(InvalidValueError, match="closed"):
        recorder.put(steps[0])
    for name in ("touch.xyz", "nofolder/touch.parquet"):
        with pytest.raises(FileError):
            Recorder(tmp_path / name, finger, _live.BOARD)
    assert [p.name for p in tmp_path.iterdir()] == ["touch.parquet"]


KILLED = """
import os, signal, sys, time
import subskin as ss
from subskin.live.record import Recorder
sys.path.insert(0, sys.argv[1])
import _live
file = ss.io.parse_finger(_live.TEXT)
for k, delay in enumerate(sys.argv[3:]):
    ready, told = os.pipe()
    child = os.fork()
    if not child:
        recorder = Recorder(f"{sys.argv[2]}/{k}.parquet", file, _live.BOARD)
        os.write(told, b".")
        while True:
            recorder.put(_live.step(time.monotonic(), [[1.0, 2.0, 3.0, 4.0]]))
            time.sleep(1e-3)
    os.read(ready, 1)
    time.sleep(float(delay))
    at = time.monotonic()
    os.kill(child, signal.SIGKILL)
    os.waitpid(child, 0)
    print(at, flush=True)
"""


def test_killed_at_any_moment_all_but_the_last_second_is_there(tmp_path):
    delays = ("0.3", "0.6")
    command = [sys.executable, "-c", KILLED, str(Path(_live.__file__).parent), str(tmp_path), *delays]
    done = subprocess.run(command, capture_output=True, text=True, timeout=120, check=True)
    for k, at in enumerate(map(float, done.stdout.split())):
        found = recover(tmp_path / f"{k}.parquet.arrows")
        steps, _ = steps_in(found.path)
        assert not found.closed
        assert len(steps) == found.frames
        assert at - steps[-1].host_time < 1.0
        assert [step.number for step in steps] == list(range(len(steps)))


def fuzzed(rng, seeds, count):
    """Bytes that look like files of a kind: cut, joined, overwritten; and some that do not."""
    for _ in range(count):
        data = bytearray(seeds[rng.integers(len(seeds))])
        for _ in range(rng.integers(1, 6)):
            data = data or bytearray(b"?")
            at, size = int(rng.integers(len(data))), int(rng.integers(1, 64))
            what = int(rng.integers(4))
            if what == 0:
                data[at : at + size] = rng.bytes(size)
            elif what == 1:
                del data[at : at + size * 8]
            elif what == 2:
                data[at:at] = data[: size * 8]
            else:
                data[at : at + 8] = (2 ** int(rng.integers(64)) - 1).to_bytes(8, "little")
        yield bytes(data)


def test_a_hostile_file_is_refused(finger, steps, growing, tmp_path):
    good = tmp_path / "touch.parquet"
    with Recorder(good, finger, _live.BOARD) as recorder:
        for made in steps:
            recorder.put(made)
    seeds = [growing[0], good.read_bytes(), b"PAR1" + bytes(64) + b"PAR1", b"", b"\xff\xff\xff\xff" + bytes(60)]
    path, refused = tmp_path / "bad.arrows", 0
    for bad in fuzzed(np.random.default_rng(11), seeds, 150):
        path.write_bytes(bad)
        try:
            steps_in(path)
        except FileError as error:
            refused += str(path) in error.seen
    assert refused > 50


def most_memory():
    """The most that this process has taken since the mark was reset [MB]."""
    return int(Path("/proc/self/status").read_text().partition("VmHWM:")[2].split()[0]) / 1024


@pytest.mark.skipif(not Path("/proc/self/clear_refs").exists(), reason="Linux tells the most memory that was taken")
def test_a_page_that_says_it_is_huge_takes_no_memory(finger, steps, tmp_path):
    """The head of a page is a Thrift struct without a checksum; its third field is the size of the page."""
    good, bad = tmp_path / "touch.parquet", tmp_path / "bad.parquet"
    with Recorder(good, finger, _live.BOARD) as recorder:
        for made in steps:
            recorder.put(made)
    data = good.read_bytes()
    at = pq.read_metadata(good).row_group(0).column(0).dictionary_page_offset
    fields = 0
    while fields < 3:  # each of the first three is a mark and a number, whose last byte has no high bit
        assert data[at] == 0x15
        end = at + 1
        while data[end] & 0x80:
            end += 1
        at, begin, fields = end + 1, at + 1, fields + 1
    bad.write_bytes(data[:begin] + b"\xfe\xff\xff\xff\x0f" + data[at:])  # 2**31 - 1
    Path("/proc/self/clear_refs").write_text("5")  # the mark falls to what is taken now
    before = most_memory()
    with pytest.raises(FileError, match="is damaged"):
        steps_in(bad)
    assert most_memory() < before + 200


def test_who_is_no_recording_is_told(tmp_path):
    pq.write_table(pa.table({"a": [1]}), tmp_path / "table.parquet")
    for name in ("none.parquet", "table.parquet", "-"):
        with pytest.raises(FileError), opened(name if name == "-" else tmp_path / name):
            pass
