"""Ports of this machine: a pseudo terminal, loopback sockets, files and pipes; and a device that is simulated."""

from __future__ import annotations

import json
import os
import pty
import socket
import threading
from contextlib import suppress

import numpy as np
import pytest
from websockets.sync import server

import subskin as ss
from subskin.errors import FileError, InvalidValueError, UnknownOptionError
from subskin.live import drivers
from subskin.live.drivers import Field
from subskin.live.ports import Faults, Log, PortEnded, PortLost, Simulated, listed, opened

from .._commands import subskin

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


def test_a_board_on_a_cable_that_is_pulled_out_in_mid_frame_and_plugged_in_again(terminal):
    """AnySkin's exact frames (raunaqbhirangi/anyskin) down a pseudo terminal."""
    ours, name, theirs = terminal
    driver = drivers.named("anyskin", sensors=1)
    frame = bytes.fromhex("0000c841 00002041 0000a4c1 00209643 0d0a")
    with opened(f"serial:{name}") as port:
        os.write(ours, frame[7:] + 3 * frame + frame[:9])  # joined in mid-frame
        data = read(port, 11 + 3 * 18 + 9)
        assert driver.feed(data).values.tolist() == 3 * [[25.0, 10.0, -20.5, 300.25]]
        os.close(ours)
        os.close(theirs)
        with pytest.raises(PortLost):
            port.read(WAIT)
        driver.reset()
        again, others = pty.openpty()
        port.name = os.ttyname(others)  # as a link in /dev/serial/by-id would lead to it
        port.reopen()
        os.write(again, 2 * frame)
        assert len(driver.feed(read(port, 36))) == 2
        for number in (again, others):
            os.close(number)


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


def test_udp():
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as free:
        free.bind(("127.0.0.1", 0))
        number = free.getsockname()[1]
    with opened(f"udp::{number}") as port, socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as device:
        assert port.read(0.0) == b""
        device.sendto(b"1,2\n", ("127.0.0.1", number))
        device.sendto(b"3,4\n", ("127.0.0.1", number))
        assert read(port, 8) == b"1,2\n3,4\n"
        with pytest.raises(PortLost, match="cannot be listened at"):
            opened(f"udp:127.0.0.1:{number}")


def test_websocket():
    def messages(connection):
        connection.send('{"message": "Welcome",\n "n": 1}')
        connection.send(b"\x01\x02")
        connection.recv()  # until the reader has read
        connection.send("x" * (1 << 19))  # more than is taken

    with server.serve(messages, "127.0.0.1", 0) as serving:
        number = serving.socket.getsockname()[1]
        thread = threading.Thread(target=serving.serve_forever)
        thread.start()
        try:
            with opened(f"ws://127.0.0.1:{number}") as port:
                assert read(port, 34) == b'{"message": "Welcome",  "n": 1}\n\x01\x02'
                assert port.read(0.0) == b""
                port.write(b"go")
                with pytest.raises(PortLost, match="too big"):
                    port.read(WAIT)
        finally:
            serving.shutdown()
            thread.join()
    with pytest.raises(PortLost, match="no WebSocket answers"):
        port.reopen()


def test_lab_streaming_layer():
    lsl = pytest.importorskip("pylsl", exc_type=(ImportError, RuntimeError))
    name = f"subskin-{os.getpid()}"
    info = lsl.StreamInfo(name, "tactile", 2, 100.0, "float32", name)
    channels = info.desc().append_child("channels")
    for label, unit in (("p0", "Pa"), ("p1", "Pa")):
        channels.append_child("channel").append_child_value("label", label).append_child_value("unit", unit)
    outlet = lsl.StreamOutlet(info)
    with opened(f"lsl:{name}") as port:
        assert port.driver.channels == ("p0_Pa", "p1_Pa")
        assert port.read(0.0) == b""
        assert outlet.wait_for_consumers(WAIT)
        outlet.push_sample([1.5, 2.5], 10.25)
        outlet.push_sample([3.5, 4.5], 10.5)
        data = b""
        while len(data) < 2 * 31 and (more := port.read(WAIT)):
            data += more
        frames = port.driver.feed(data)
        assert frames.values.tolist() == [[1.5, 2.5], [3.5, 4.5]]
        assert frames.device_time.tolist() == [10.25, 10.5]
        del outlet
        with pytest.raises(PortLost, match="gone"):
            port.read(WAIT)


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


def test_what_is_plugged_in(monkeypatch):
    class Plugged:
        def __init__(self, device, vid=None, pid=None, maker=None, product=None):
            self.device, self.vid, self.pid, self.manufacturer, self.product = device, vid, pid, maker, product
            self.serial_number, self.description = None, "n/a"

    boards = [
        Plugged("/dev/ttyS0"),
        Plugged("/dev/ttyUSB0", 0x0403, 0x6001, "FTDI", "FT232R"),
        Plugged("/dev/ttyACM0", 0x239A, 0x80CC, "Adafruit", "QT Py M0"),
    ]
    monkeypatch.setattr("serial.tools.list_ports.comports", lambda: boards)
    found = listed()
    assert [one.port for one in found] == ["serial:/dev/ttyACM0", "serial:/dev/ttyUSB0", "serial:/dev/ttyS0"]
    assert [one.driver for one in found] == ["anyskin", "unknown", "unknown"]
    assert (found[0].says, found[0].usb, found[2].says) == ("Adafruit QT Py M0", "239a:80cc", "")
    said = subskin("ports")
    assert said.code == 0
    assert "QT Py M0" in said.out
    assert json.loads(subskin("ports", "--json").out)["ports"][1]["usb"] == "0403:6001"
    boards.clear()
    assert "no serial port was found" in subskin("ports").out


@pytest.mark.parametrize("name", ["crc", "contactile"])
def test_every_good_frame_of_a_bad_device_is_read_once(name):
    """45 s with a fault of each kind every two seconds, but none that only changes values."""
    fields = [Field("n", "u32", "counter"), Field("t", "u32", "time", 1e-6), Field("a", "f64"), Field("b", "f64")]
    made = {
        "crc": lambda: drivers.Fixed(fields, start=b"\xa5\x5a", check="crc16_ccitt"),
        "contactile": lambda: drivers.named("contactile", pillars=1),
    }
    driver = made[name]()
    faults = Faults(dropped=0.5, cut=0.5, changed=0.5, garbage=0.5, restarted=0.2, unplugged=0.2)
    width = len(driver.channels)
    port = Simulated(
        lambda t: np.tile(np.rint(100 * t)[:, None], (1, width)), made[name](), rate=100, faults=faults, seed=5,
        duration=45, batch=0.02,
    )  # fmt: skip
    got = []
    while True:
        try:
            got.append(driver.feed(port.read(0.0)).values)
        except PortLost:
            with suppress(PortLost):
                port.reopen()
                driver.reset()
        except PortEnded:
            break
    found = np.concatenate(got)
    spoilt = {i for first, last, why in port.spoilt if why != "garbage" for i in range(first, last + 1)}
    assert len({why for _, _, why in port.spoilt}) == 6
    assert found[:, 0].astype(int).tolist() == sorted(set(range(4500)) - spoilt)
    assert (found == found[:, :1]).all()


@pytest.mark.parametrize(
    ("port", "said"),
    [
        ("seriel:/dev/ttyACM0", "did you mean serial:"),
        ("tcp:5000", "a host and a port"),
        ("serial:/dev/null?speed=9600", "known: baud"),
        ("serial:/dev/null?baud=fast", "whole number"),
        ("demo:500", "demo has no address"),
    ],
)
def test_a_port_that_cannot_be_had(port, said):
    with pytest.raises((InvalidValueError, UnknownOptionError), match=said):
        opened(port)


class Time:
    """A clock that goes on only where somebody sleeps."""

    def __init__(self):
        self.now = 50.0

    def monotonic(self):
        return self.now

    def sleep(self, seconds):
        self.now += seconds


def played(monkeypatch, tmp_path, driver, data, rate=None):
    """When each frame of a log came [s]."""
    told = Time()
    monkeypatch.setattr("subskin.live.ports.local.time", told)
    (tmp_path / "log.bin").write_bytes(data)
    came, reads = [], drivers.from_table(driver)
    with Log(opened(f"file:{tmp_path / 'log.bin'}"), drivers.from_table(driver), rate) as log, suppress(PortEnded):
        while True:
            frames = len(reads.feed(log.read(0.1)))
            came += frames * [told.now - 50.0]
    return np.array(came)


def test_a_log_is_played_as_fast_as_it_came(monkeypatch, tmp_path):
    lines = {"name": "lines", "columns": ["ms", "a", "b"], "time": "ms", "tick": "ms"}
    device = np.concatenate([np.arange(0, 900, 10), np.arange(0, 500, 10)])  # it was switched on again
    data = b"".join(b"%d,1.5,2.5\n" % ms for ms in device)
    at = played(monkeypatch, tmp_path, lines, data)
    assert len(at) == 139  # the first line may have been joined in its middle
    passed = 0.01 * np.concatenate([np.arange(89), 88 + np.arange(50)])
    assert np.abs(at - passed).max() < 0.3  # a piece holds some frames
    assert at[-1] == pytest.approx(passed[-1], abs=0.02)
    plain = {"name": "lines", "sensors": 2}
    assert played(monkeypatch, tmp_path, plain, b"1,2\n" * 400, rate=200.0)[-1] == pytest.approx(1.995)
    with pytest.raises(InvalidValueError, match="no times"):
        played(monkeypatch, tmp_path, plain, b"1,2\n" * 400)
