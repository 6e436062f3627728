"""What `subskin live` shows while loops are compiled, by a second process; the first keeps all that is read."""

from __future__ import annotations

import os
import re
import select
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

import numba as nb
import numpy as np
import pytest

import subskin as ss
from subskin._compiling import when_compiling
from subskin.cli.live_preview import Preview, _newest
from subskin.cli.live_view import PlainLines
from subskin.errors import InvalidValueError
from subskin.live import Chain, DeviceFrames, Live
from subskin.live.batch import BareChain
from subskin.live.drivers import named
from subskin.live.ports import FilePort, Log, Port
from subskin.live.ports.simulated import Simulated

FINGER = ss.Finger(ss.HalfPlane(ss.Material(young=0.4e6)), ss.SensorArray.line(4, pitch=2e-3, depth=2e-3, noise=1e-4))
FREE, PRESSED = FINGER.read(ss.LineLoad(0.0)), FINGER.read(ss.LineLoad(30.0, angle=0.2, position=0.4e-3))
PATIENCE = 60.0
"""Seconds after which something hangs, on a machine however busy."""


class Board(Port, name="preview_board"):
    """Sends lines in real time: twenty of the free skin, then it is pressed for good."""

    def __init__(self):
        self.name, self.driver = "board", named("lines", sensors=4)
        self.sent = 0

    def read(self, timeout):
        time.sleep(0.005)
        self.sent += 1
        alive = 1e-9 * (self.sent % 3 - 1)  # a sensor that stands still is out
        return self.driver.encode((FREE if self.sent <= 20 else PRESSED)[None] + alive)

    def write(self, data):
        pass

    def close(self):
        pass

    def reopen(self):
        pass


def compile_a_loop():
    assert nb.njit(lambda x: x + 1)(1) == 2


def board():
    port = Board()
    return Live(Chain(FINGER, channels=port.driver.channels), port, port.driver)


def some_frames(live):
    after = time.monotonic() + PATIENCE
    while not live.frames and time.monotonic() < after:
        live.take()
    assert live.frames


def test_compiling_is_told_once_and_only_within():
    told = []
    with when_compiling(lambda: told.append("compiling")):
        assert told == []
        compile_a_loop()
        compile_a_loop()
        assert told == ["compiling"]
    with when_compiling(lambda: told.append("again")):
        pass
    compile_a_loop()
    assert told == ["compiling"]


def compiled_answer():
    """What the compiled loops say in words of a free frame, and of a pressed one."""
    chain, state, view = Chain(FINGER), None, None
    for at, raw in enumerate((FREE, PRESSED)):
        state, batch = chain.step(state, DeviceFrames(raw[None]), 0.2 * at)
        view = view or PlainLines(ss.io.parse_finger("skin = {young = 4e5}\nsensors = {y = [0.0], depth = 2e-3}"), None)
        view.file, view.latest = chain.file, batch
    return view.said()


def test_the_second_process_finds_what_the_compiled_loops_find_and_the_first_keeps_every_frame(capfd):
    live, shown, after = board(), "", time.monotonic() + PATIENCE
    with live:
        with Preview(live, bars=False, zero=None) as preview:
            assert not preview.shown
            compile_a_loop()
            assert preview.shown
            while "force" not in shown and time.monotonic() < after:
                time.sleep(0.05)
                shown += capfd.readouterr().err
        sent, batches = live.port.sent, live.take()
    force = re.compile(r"force (\S+) \+- (\S+) N/m")
    assert force.search(shown), shown
    assert force.search(shown).groups() == force.search(compiled_answer()).groups()
    assert "PREVIEW" in shown
    raw = np.concatenate([batch.raw for batch in batches])
    assert len(raw) >= sent - 1 > 20  # the last may be on its way
    np.testing.assert_allclose(raw[0], FREE, atol=1e-8)
    assert "contact_on" in [event.kind for batch in batches for event in batch.events]
    times = np.concatenate([batch.time for batch in batches])
    assert np.ptp(times) > 0.3 * 0.005 * len(raw)  # a busy machine may begin late; taken at once they have one time


def test_zero_is_said_while_loops_are_compiled(capfd):
    live, after = board(), time.monotonic() + PATIENCE
    with live, Preview(live, bars=False, zero=0.02) as preview:
        compile_a_loop()
        while preview.zero is not None and time.monotonic() < after:
            time.sleep(0.01)
    commands = [batch.command for batch in live._batches()]
    assert commands.count("zero") == 1


def test_nothing_is_shown_where_all_loops_were_kept():
    live = board()
    with live, Preview(live, bars=False, zero=None) as preview:
        pass
    assert not preview.shown
    assert live.port.sent == 0


@pytest.mark.parametrize("python", [os.devnull, shutil.which("false")])
def test_without_a_second_process_the_loops_are_compiled_as_ever(monkeypatch, capfd, python):
    """It cannot be started; or it dies at once."""
    monkeypatch.setattr(sys, "executable", python)
    live = board()
    with live:
        with Preview(live, bars=False, zero=None) as preview:
            compile_a_loop()
        assert preview.shown == (python != os.devnull)
        some_frames(live)


SCRIPT = """
import sys, time
sys.path.insert(0, {folder!r})
from test_live_preview import Preview, board, compile_a_loop
live = board()
try:
    with Preview(live, bars=True, zero=None):
        compile_a_loop()
        time.sleep(600)
except KeyboardInterrupt:
    live.close()
"""


@pytest.mark.skipif(os.name != "posix", reason="terminals are those of POSIX")
@pytest.mark.parametrize("end", [signal.SIGINT, signal.SIGKILL])
def test_the_terminal_shows_a_force_and_no_process_is_left(end):
    """The terminal is at its end when nobody holds it any more: a second process that goes on would."""
    master, slave = os.openpty()
    command = [sys.executable, "-c", SCRIPT.format(folder=str(Path(__file__).parent))]
    env = {**os.environ, "TERM": "xterm", "COLUMNS": "110", "PYTHONPATH": str(Path(ss.__file__).parents[1])}
    listen = {"preexec_fn": lambda: signal.signal(signal.SIGINT, signal.SIG_DFL)}
    with subprocess.Popen(command, stdin=slave, stdout=slave, stderr=slave, env=env, **listen) as process:
        os.close(slave)
        shown, sent, after = b"", False, time.monotonic() + 2 * PATIENCE
        while True:
            assert select.select([master], [], [], max(after - time.monotonic(), 0.0))[0], "a process is left"
            try:
                part = os.read(master, 65536)
            except OSError:  # Linux says so where others give nothing
                part = b""
            if not part:
                break
            shown += part
            if not sent and b"force" in shown:
                process.send_signal(end)
                sent, after = True, time.monotonic() + PATIENCE
    os.close(master)
    assert sent, shown.decode()
    assert b"PREVIEW" in shown
    assert b"Traceback" not in shown
    assert process.returncode == (-end if end == signal.SIGKILL else 0)
    assert shown.rindex(b"\x1b[?25h") > shown.rindex(b"\x1b[?25l")  # the cursor is there again


def test_of_what_was_read_the_first_and_the_newest_frames_are_shown_and_every_command():
    driver = named("lines", sensors=1)
    lines = [(0.1 * k, b"%d\n" % k) for k in range(12)]
    told = _newest([*lines[:10], (0.95, "zero"), *lines[10:], (1.2, "ended")], driver)
    assert [(few.command, few.values.ravel().tolist()) for few in told] == [
        ("", [1.0, 7.0, 8.0, 9.0]),
        ("zero", []),
        ("", [10.0, 11.0]),
    ]


def test_a_recording_begins_where_the_chain_begins(tmp_path):
    live = board()
    with live:
        some_frames(live)
        with pytest.raises(InvalidValueError, match="from the first on"):
            live.record(tmp_path / "late.parquet")
    port = Board()
    bare = Live(BareChain(ss.live.chain.file_of(FINGER), port.driver.channels), port, port.driver)
    with pytest.raises(InvalidValueError, match="from the first on"):
        bare.record(tmp_path / "bare.parquet")


def test_files_and_simulated_time_are_not_read_early(tmp_path):
    (tmp_path / "log.csv").write_text("1\n")
    driver = named("lines", sensors=1)
    assert board().port.real_time
    assert not FilePort(str(tmp_path / "log.csv")).real_time
    assert not Log(FilePort(str(tmp_path / "log.csv")), driver, rate=10.0).real_time
    assert not Simulated(lambda at: at[:, None], driver, batch=0.1).real_time
    assert Simulated(lambda at: at[:, None], driver).real_time


def test_it_leaves_once():
    """Told twice, by the pipe and by the first process, it does not break off what the first made it begin to end."""
    script = (
        "import signal, os, time\n"
        "from subskin.cli.live_preview import _leave\n"
        "signal.signal(signal.SIGTERM, _leave)\n"
        "try:\n    os.kill(os.getpid(), signal.SIGTERM); time.sleep(60)\n"
        "finally:\n    os.kill(os.getpid(), signal.SIGTERM); time.sleep(0.1); print('cursor shown')\n"
    )
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, timeout=60, check=False)
    assert (done.returncode, done.stdout) == (0, "cursor shown\n"), done.stderr
