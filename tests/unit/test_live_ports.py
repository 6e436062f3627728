"""Ports of this machine: a pseudo terminal, loopback sockets, files and pipes; and a device that is simulated."""

from __future__ import annotations

import os
import pty
import socket
from contextlib import suppress

import numpy as np
import pytest

import subskin as ss
from subskin.errors import FileError, InvalidValueError, UnknownOptionError
from subskin.live import drivers
from subskin.live.ports import Faults, PortEnded, PortLost, Simulated, opened

WAIT = 5.0
"""How long a byte that was sent on this machine may take [s]; a test that fails waits so long, once."""


def read(port, count):
    data = b""
    while len(data) < count and (more := port.read(WAIT)):
        data += more
    return data


@pytest.fixture
def terminal():
    ours, theirs = pty.openpty()
    yield ours, os.ttyname(theirs), theirs
    for number in (ours, theirs):
        with suppress(OSError):
            os.close(number)


def test_serial(terminal):
    ours, name, theirs = terminal
    with opened(f"serial:{name}?baud=9600") as port:
        assert port.read(0.0) == b""
        os.write(ours, b"[[1],[2]]\r\n")
        assert read(port, 11) == b"[[1],[2]]\r\n"
        port.write(b"z\n")
        assert os.read(ours, 2) == b"z\n"
        os.close(theirs)
        os.close(ours)
        with pytest.raises(PortLost, match="gone"):
            port.read(WAIT)
        with pytest.raises(PortLost, match="cannot be opened"):
            port.reopen()


def test_tcp():
    server = socket.create_server(("127.0.0.1", 0))
    with server, opened(f"tcp:127.0.0.1:{server.getsockname()[1]}") as port:
        assert port.read(0.0) == b""
        peer, _ = server.accept()
        peer.sendall(b"12")
        assert read(port, 2) == b"12"
        port.write(b"S\n")
        assert peer.recv(2) == b"S\n"
        peer.close()
        with pytest.raises(PortLost, match="other side"):
            port.read(WAIT)
        port.reopen()
        assert port.read(0.0) == b""
    with pytest.raises(PortLost, match="nobody answers"):
        port.reopen()


def test_files_end(tmp_path):
    (tmp_path / "log.bin").write_bytes(b"\x00\x01")
    with opened(f"file:{tmp_path / 'log.bin'}") as port:
        assert port.read(0.0) == b"\x00\x01"
        with pytest.raises(PortEnded):
            port.read(0.0)
    with pytest.raises(FileError, match="No such file"):
        opened("file:nothing.bin")


def test_standard_input(monkeypatch):
    out, into = os.pipe()
    with os.fdopen(out) as stream:
        monkeypatch.setattr("sys.stdin", stream)
        with opened("-") as port:
            assert port.read(0.0) == b""
            os.write(into, b"1,2\n")
            assert port.read(WAIT) == b"1,2\n"
            os.close(into)
            with pytest.raises(PortEnded):
                port.read(WAIT)


def count_up(time):
    return np.tile(np.rint(1000 * time)[:, None], (1, 4))


def all_of(port):
    """Bytes up to the end."""
    while True:
        try:
            yield port.read(0.0)
        except PortEnded:
            return


def test_a_simulated_device_is_the_same_however_it_is_read():
    bytes_ = []
    for batch in (0.001, 0.37):
        faults = Faults(dropped=1, cut=1, changed=1, garbage=1, stuck=1, restarted=0.2)
        driver = drivers.named("anyskin", sensors=1)
        port = Simulated(count_up, driver, faults=faults, noise=0.1, drift=0.1, seed=3, duration=3.7, batch=batch)
        bytes_.append(b"".join(all_of(port)))
    assert len(bytes_[0]) > 50_000
    assert bytes_[0] == bytes_[1]


def test_the_demo_needs_a_finger_and_reads_it():
    with pytest.raises(InvalidValueError, match="needs a finger"):
        opened("demo")
    text = "[skin]\nyoung = 4e5\n[sensors]\ncount = 8\npitch = 1.5e-3\ndepth = 2e-3\nnoise = 1e-4"
    file = ss.io.parse_finger(text)
    with opened("demo?batch=0.1&duration=3&rate=100", file) as port:
        frames = [port.driver.feed(port.read(0.0)) for _ in range(30)]
    readings = np.concatenate([f.values for f in frames])
    assert readings.shape == (300, 8)
    found = file.locate(readings)
    assert set(found.status[:110]) == {ss.Status.NO_CONTACT}
    pressed = found.status[180:270] == ss.Status.OK
    assert pressed.mean() > 0.9
    force = found.force[180:270][pressed]
    assert force.max() > 3 * force.min() > 0


@pytest.mark.parametrize(
    ("port", "said"),
    [
        ("seriel:/dev/ttyACM0", "did you mean serial:"),
        ("tcp:5000", "a host and a port"),
        ("serial:/dev/null?speed=9600", "known: baud"),
        ("serial:/dev/null?baud=fast", "whole number"),
    ],
)
def test_a_port_that_cannot_be_had(port, said):
    with pytest.raises((InvalidValueError, UnknownOptionError), match=said):
        opened(port)
