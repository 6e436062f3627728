"""A port read live: all there is as one batch, ports lost and back, nothing lost on the way, and the command."""

from __future__ import annotations

import asyncio
import json
import os
import signal
import subprocess
import sys
import threading
import time
from functools import partial
from pathlib import Path

import numpy as np
import pytest

import subskin as ss
from subskin.cli import main
from subskin.live import Chain, Live
from subskin.live.drivers import named
from subskin.live.ports import Port, PortEnded, PortLost

FINGER = ss.Finger(ss.HalfPlane(ss.Material(young=0.4e6)), ss.SensorArray.line(4, pitch=2e-3, depth=2e-3, noise=1e-4))
PATIENCE = 30.0
"""Seconds after which something hangs, on a machine however busy."""


class Scripted(Port, name="scripted"):
    """Hands out bytes, is lost at None, and ends."""

    def __init__(self, parts):
        self.name, self.driver, self.written = "scripted", named("lines", sensors=4), []
        self._parts, self.closed, self.opened = list(parts), False, 1

    def read(self, timeout):
        if not self._parts:
            raise PortEnded(self.name, "it is at its end")
        part = self._parts.pop(0)
        if part is None:
            raise PortLost(self.name, "unplugged", "plug it in")
        return part

    def write(self, data):
        self.written.append(data)

    def close(self):
        self.closed = True

    def reopen(self):
        self.opened += 1


@pytest.fixture(scope="module")
def lines():
    """A driver's bytes for frames that count in their first channel, and are pressed from frame 40 on."""
    driver = named("lines", sensors=4)
    raw = FINGER.read(ss.LineLoad(np.where(np.arange(80) < 40, 0.0, 30.0)), np.random.default_rng(0))
    return [driver.encode(raw[k : k + 1]) for k in range(80)], raw


def stream(parts, **options):
    port = Scripted(parts)
    return Live(Chain(FINGER, channels=port.driver.channels, **options), port, port.driver), port


def test_what_waits_becomes_one_batch_and_every_frame_comes_once(lines):
    data, raw = lines
    live, port = stream([b"".join(data[k : k + 7]) for k in range(0, 80, 7)])
    with live:
        live.start()
        live._thread.join(PATIENCE)  # all of it waits
        batches = list(live)
    assert len(batches) == 1
    # the first line after opening is left out: its beginning may be missing
    np.testing.assert_array_equal(np.concatenate([one.raw for one in batches]), raw[1:])
    assert live.ended
    assert port.closed
    assert live.frames == 79
    assert len(live.ring) == 79
    assert live.ring.last()["found"].shape == (79, 15)


def test_a_port_that_is_lost_and_back_is_told_and_the_stream_goes_on(lines, monkeypatch):
    from subskin.live import run

    monkeypatch.setattr(run, "_AGAIN", 0.01)
    data, _ = lines
    live, port = stream([*data[:20], b"0.1,0.2", None, *data[20:]])
    with live:
        batches = list(live)
    kinds = [event.kind for batch in batches for event in batch.events]
    assert kinds[:2] == ["port_lost", "port_back"]
    assert "contact_on" in kinds
    assert port.opened == 2
    # what was unfinished is forgotten, and the first line after opening left out again
    assert live.frames == 19 + 59
    commands = [batch.command for batch in batches if batch.command]
    assert commands == ["port_lost", "port_back"]


def test_zero_and_mark_are_steps_of_the_stream(lines):
    data, _ = lines
    live, _ = stream(data)
    with live:
        live.mark("begin")
        live.start()
        live._thread.join(PATIENCE)
        live.zero()
        batches = [one for _ in range(3) for one in live.take(0.01)]
    assert [one.command for one in batches] == ["mark", "", "zero"]
    assert batches[0].events[0].text == "begin"


def test_async_takes_the_same_frames(lines):
    data, raw = lines

    async def run():
        live, _ = stream(data)
        with live:
            return [one.raw async for one in live]

    got = asyncio.run(asyncio.wait_for(run(), PATIENCE))
    np.testing.assert_array_equal(np.concatenate(got), raw[1:])


def test_whoever_is_slow_gets_a_larger_batch_and_loses_nothing(lines):
    """Frames come while nobody takes them; a recorder that blocks holds up what is shown, and not the reader."""
    data, raw = lines
    kept = []

    class Slow:
        failed = ""

        def put(self, batch):
            time.sleep(0.02)
            kept.append(batch)

        def close(self):
            kept.append("closed")

    port = Scripted(data)
    live = Live(Chain(FINGER, channels=port.driver.channels), port, port.driver, Slow())
    with live:
        shown = list(live)
    np.testing.assert_array_equal(np.concatenate([one.raw for one in kept[:-1]]), raw[1:])
    assert kept[-1] == "closed"
    assert len(shown) < 40


def test_what_stops_the_reader_is_raised_where_the_batches_are_taken(lines):
    class Broken(Scripted):
        def read(self, timeout):
            if len(self._parts) < 78:
                raise OSError("burnt")
            return super().read(timeout)

    data, _ = lines
    port = Broken(data)
    with Live(Chain(FINGER, channels=port.driver.channels), port, port.driver) as live:
        with pytest.raises(OSError, match="burnt"):
            list(live)
        assert live.frames == 2  # what came before it went through
        assert live.ended


def test_closing_ends_the_thread_and_a_loop_over_it(lines):
    class Endless(Scripted):
        def read(self, timeout):
            time.sleep(0.005)
            return b"0,0,0,0\n"

    port = Endless([])
    live = Live(Chain(FINGER, channels=port.driver.channels), port, port.driver)
    threading.Timer(0.2, live.close).start()
    assert sum(len(one) for one in live) > 0
    live._thread.join(PATIENCE)
    assert not live._thread.is_alive()


def test_the_room_can_be_called_and_reads_the_demo():
    with ss.live(FINGER, port="demo?rate=200&batch=0.05&duration=4", slip=0.5, prepare=False) as live:
        kinds = [event.kind for batch in live for event in batch.events]
    assert kinds[0] == "contact_on"
    assert live.frames == 800
    with pytest.raises(ss.SubskinError, match="nothing says where the device is"):
        ss.live(FINGER)
    with pytest.raises(ss.SubskinError, match="without a driver"):
        ss.live(FINGER, port="file:" + os.devnull)
    with pytest.raises(ss.SubskinError, match="did you mean"):
        ss.live(FINGER, port="file:" + os.devnull, driver="line")


@pytest.fixture
def piped(tmp_path, lines):
    """A finger file, and a file with what its board sent."""
    text = "[skin]\nyoung = 4e5\n[sensors]\ncount = 4\npitch = 2e-3\ndepth = 2e-3\nnoise = 1e-4\n"
    (tmp_path / "finger.toml").write_text(text + '[live]\ndriver = {name = "lines", sensors = 4}\n')
    (tmp_path / "log.csv").write_bytes(b"".join(lines[0]))
    return str(tmp_path / "finger.toml"), f"file:{tmp_path / 'log.csv'}"


def test_the_command_prints_lines_where_it_is_piped(piped, capsys):
    finger, port = piped
    assert main(["live", finger, "--port", port, "--rate", "200"]) == 0
    out, err = capsys.readouterr()
    assert "contact_on: contact: ok" in out
    assert "79 frames" in out
    assert "1 contact_on" in out
    assert "ready in" in err


def test_a_board_that_its_driver_cannot_read_is_said(piped, capsys, tmp_path):
    (tmp_path / "other.csv").write_bytes(b"1,2,3,4,5,6\n" * 20)
    assert main(["live", piped[0], "--port", f"file:{tmp_path / 'other.csv'}"]) == 1
    assert "no frame came; " in capsys.readouterr().err


def test_the_command_prints_a_line_of_json_for_each_frame_and_event(piped, capsys):
    finger, port = piped
    assert main(["live", finger, "--port", port, "--rate", "200", "--json", "--slip", "0.4..0.8"]) == 0
    rows = [json.loads(line) for line in capsys.readouterr().out.splitlines()]
    frames = [row for row in rows if row["kind"] == "frame"]
    assert [row["row"] for row in frames] == list(range(79))
    assert frames[-1]["status"] == "ok"
    assert frames[-1]["slip"] == "holds"
    assert frames[0]["position"] is None
    assert frames[-1]["force"] == pytest.approx(30.0, rel=0.05)
    assert next(row["event"] for row in rows if row["kind"] == "event") == "contact_on"


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["{finger}", "--port", "tcp:127.0.0.1:1"], "nobody answers"),
        (["{finger}"], "no port"),
        (["--port", "udp::5000"], "no finger"),
        (["{finger}", "--port", "demo", "--rate", "100"], "only a file of bytes is played"),
        (["{wrong}"], "wrong.toml, line 18: [live.driver.fields] type"),
        (["{finger}", "--port", "demo", "--for", "-1 s"], "has to be > 0"),
        (["{finger}", "--port", "demo", "--slip", "0.8..0.4"], "the first has to be <= the second"),
        (["{finger}", "--port", "smoke:signals"], "no such kind of port"),
    ],
)
def test_what_cannot_be_opened_is_said_and_the_exit_code_is_2(piped, capsys, arguments, said):
    wrong = Path(piped[0]).with_name("wrong.toml")
    board = '[live.driver]\nname = "fixed"\nend = "0a"\n' + 2 * '[[live.driver.fields]]\nname = "a"\ntype = "u8"\n'
    finger = Path(piped[0]).read_text().partition("[live]")[0]
    wrong.write_text(f'{finger}[live]\nport = "file:{os.devnull}"\n{board[::-1].replace("8u", "71u", 1)[::-1]}')
    assert main(["live", *(one.format(finger=piped[0], wrong=wrong) for one in arguments)]) == 2
    assert said in capsys.readouterr().err


@pytest.mark.skipif(os.name != "posix", reason="signals are those of POSIX")
def test_ctrl_c_ends_it_cleanly_with_a_summary():
    env = {**os.environ, "PYTHONPATH": str(Path(ss.__file__).parents[1])}
    command = [sys.executable, "-m", "subskin", "live", "--port", "demo"]
    # what a shell starts in the background has learned to be deaf to it
    listen = partial(signal.signal, signal.SIGINT, signal.SIG_DFL)
    options = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, "text": True, "env": env, "preexec_fn": listen}
    with subprocess.Popen(command, **options) as process:
        watch = threading.Timer(4 * PATIENCE, process.kill)
        watch.start()
        first = process.stdout.readline()  # compiled, and the first line is there
        process.send_signal(signal.SIGINT)
        out, err = process.communicate()
        watch.cancel()
    assert "s  " in first or "no frame yet" in first
    assert process.returncode == 0, err
    assert "frames in" in out
    assert "Traceback" not in err
