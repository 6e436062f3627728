"""A live stream: from the last byte to the answer, a frame by itself, 8 kHz in batches, and an hour with faults.

    python benchmarks/bench_live.py [--seconds 10] [--simulated 60] [--busy 0] [--json FILE]

The device is a process of its own that writes to a pty: 16 channels, each frame with the time at which it was sent.
`--seconds` is how long each stream is read in real time, `--simulated` how much simulated time goes through with every
fault once a second on average (3600: the hour), `--busy` how many other processes compute meanwhile. Garbage is
collected as usual. Asked for (1 kHz): p50 0.5 ms and p99 5 ms on a quiet machine; a frame through tare, locate and
slip 120 us; 8 kHz with decisions half a core; of the faulty stream every good frame once, in order, none invented,
no growth of memory, no step over 50 ms.
"""

from __future__ import annotations

import gc
import multiprocessing
import os
import pty
import resource
import subprocess
import sys
import time
import tty
from pathlib import Path

import numpy as np

import subskin as ss
from _common import arguments, show
from subskin.live import Chain, DeviceFrames, Live
from subskin.live.drivers import Driver, Field, Fixed
from subskin.live.ports import Port, PortEnded, PortLost
from subskin.live.ports.simulated import Faults, Simulated

CHANNELS, NOISE = 16, 2e-4
SLIP = (0.4, 0.8)


def finger(sensors: int = CHANNELS) -> ss.Finger:
    """A row on a half plane."""
    array = ss.SensorArray.line(sensors, pitch=1.5e-3, depth=2e-3, noise=NOISE)
    return ss.Finger(ss.HalfPlane(ss.Material(young=0.4e6)), array)


def board() -> Fixed:
    """A counter, the time of sending in us, a float for each sensor, a check."""
    head = [Field("frame", "u32", "counter"), Field("time", "u32", "time", 1e-6)]
    return Fixed([*head, *(Field(f"s{i}", "f32") for i in range(CHANNELS))], start=b"\xa5\x5a", check="crc16_ccitt")


def touched(frames: int, rate: float, sensors: int = CHANNELS) -> np.ndarray:
    """Readings of touches of half a second, each second one."""
    time = np.arange(frames) / rate
    force = np.where(time % 1.0 > 0.5, 40.0, 0.0)
    return finger(sensors).read(ss.LineLoad(force, 0.2, 3e-3 * np.sin(time)), np.random.default_rng(0))


def send(name: str, rate: float, at_once: int, seconds: float) -> None:
    """The device: frames in their time down a pty, in which stands when they were sent."""
    line, device = os.open(name, os.O_RDWR), board()
    frames = int(seconds * rate)
    raw = touched(frames, rate)
    begin = time.monotonic()
    for k in range(0, frames, at_once):
        wait = begin + (k + at_once - 1) / rate - time.monotonic()
        if wait > 0:
            time.sleep(wait)
        part = slice(k, k + at_once)
        now = np.full(len(raw[part]), time.monotonic() % 4000.0)
        os.write(line, device.encode(raw[part], now, np.arange(k, k + len(now))))
    time.sleep(0.3)


class Line(Port, name="bench pty"):
    """The other end of the pty."""

    def __init__(self, number: int) -> None:
        self.name, self._number = "pty", number

    def read(self, timeout: float) -> bytes:
        """What has come."""
        import select

        if not select.select([self._number], [], [], timeout)[0]:
            return b""
        try:
            data = os.read(self._number, 1 << 16)
        except OSError:
            data = b""
        if not data:
            raise PortEnded("pty", "it is at its end")
        return data

    def write(self, data: bytes) -> None:
        """Nothing is sent."""

    def close(self) -> None:
        """Nothing is left open."""

    def reopen(self) -> None:
        """It is never lost."""


def through_a_pty(rate: float, at_once: int, seconds: float, slip: tuple[float, float] | None) -> list[str]:
    """Latency of the answers, frames lost, and the share of a core."""
    chain = Chain(finger(), channels=board().channels, slip=slip)
    chain.prepare()
    ours, theirs = pty.openpty()
    tty.setraw(theirs)
    code = f"import sys; sys.path.insert(0, {str(Path(__file__).parent)!r}); import bench_live; "
    code += f"bench_live.send({os.ttyname(theirs)!r}, {rate}, {at_once}, {seconds})"
    live = Live(chain, Line(ours), board())
    late, sizes = [], []
    device = subprocess.Popen([sys.executable, "-c", code])
    used = None
    while not live.ended and (device.poll() is None or live.frames < seconds * rate):
        batches = live.take(0.2)
        if not batches and device.poll() is not None:
            break
        now = time.monotonic() % 4000.0
        for batch in batches:
            if used is None:
                used, began = time.process_time(), time.monotonic()
            late.append(now - float(batch.device_time[-1]))
            sizes.append(len(batch))
    cpu = (time.process_time() - used) / (time.monotonic() - began)
    live.close()
    device.wait(10)
    os.close(ours), os.close(theirs)
    settled = 1e3 * np.array(late[len(late) // 10 :])
    p50, p99 = np.quantile(settled, [0.5, 0.99])
    lost = int(seconds * rate) - live.frames
    name = f"{rate:.0f} Hz by {at_once}, {'slip' if slip else 'no slip'}"
    return [name, f"{p50:.2f}", f"{p99:.2f}", f"{settled.max():.1f}", f"{np.mean(sizes):.1f}", str(lost), f"{cpu:.2f}"]


def by_itself(sensors: int) -> list[list[str]]:
    """Time of one frame: the parts, and the whole step of the chain."""
    tip = finger(sensors)
    chain, pipeline = Chain(tip, slip=SLIP), Chain(tip).pipeline
    chain.prepare()
    raw = touched(4000, 1000.0, sensors)
    mu = ss.decide.Friction.between(*SLIP)

    def parts() -> list[float]:
        state, times = None, []
        for k in range(len(raw)):
            at = np.array([1e-3 * k])
            begin = time.perf_counter_ns()
            state, out = pipeline.step(state, raw[k : k + 1], at)
            ss.decide.slip(out["found"], mu)
            times.append(1e-3 * (time.perf_counter_ns() - begin))
        return times

    def whole() -> list[float]:
        state, times = None, []
        for k in range(len(raw)):
            frames = DeviceFrames(raw[k : k + 1], [1e-3 * k])
            begin = time.perf_counter_ns()
            state, _ = chain.step(state, frames, 1e-3 * k + 5e-4)
            times.append(1e-3 * (time.perf_counter_ns() - begin))
        return times

    rows = []
    for name, call in (("tare, locate, slip", parts), ("the whole step: clock and events too", whole)):
        best = min((call() for _ in range(3)), key=np.median)[1000:]
        rows.append([name, str(sensors), f"{np.median(best):.0f}", f"{np.quantile(best, 0.99):.0f}"])
    return rows


def faulty(seconds: float, rate: float = 1000.0) -> list[str]:
    """Simulated time with every fault: each good frame once and in order, none invented, memory, the longest step."""
    raw = touched(10_000, rate)

    def signal(at: np.ndarray) -> np.ndarray:
        frame = np.rint(at * rate).astype(np.int64)
        values = raw[frame % len(raw)].copy()
        values[:, 0] = frame  # a sensor that says which frame it is
        return values

    driver: Driver = board()
    array = ss.SensorArray.line(CHANNELS, pitch=1.5e-3, depth=2e-3, noise=NOISE, gain=[0.0] + [1.0] * (CHANNELS - 1))
    chain = Chain(ss.Finger(ss.HalfPlane(ss.Material(young=0.4e6)), array), channels=driver.channels, slip=SLIP)
    chain.prepare()
    each = Faults(**dict.fromkeys(FAULTS, 1 / len(FAULTS)))
    port = Simulated(signal, board(), rate=rate, faults=each, seed=1, duration=seconds, batch=0.004)
    nothing = DeviceFrames(np.empty((0, CHANNELS)))
    state, events, base, steps = None, {}, None, 0
    ids = np.full(int(seconds * rate) + 10_000, -1, dtype=np.int64)  # room for all of it: only the chain may grow
    took = np.zeros((2, int(seconds / 0.004) + 100_000))
    ids[:], took[:] = -1, 0.0
    seen = invented = 0
    while True:
        try:
            data = port.read(0.0)
            command = ""
        except PortEnded:
            break
        except PortLost:
            state, _ = chain.step(state, nothing, port.clock(), "port_lost")
            while True:
                try:
                    port.reopen()
                    break
                except PortLost:
                    pass
            driver.reset()
            data, command = b"", "port_back"
        begin, spent = time.perf_counter(), time.thread_time()
        frames = nothing if command else driver.feed(data)
        state, batch = chain.step(state, frames, port.clock(), command)
        took[:, steps] = time.perf_counter() - begin, time.thread_time() - spent
        steps += 1
        for event in batch.events:
            events[event.kind] = events.get(event.kind, 0) + 1
        frame = batch.raw[:, 0].astype(np.int64)
        ids[seen : seen + len(frame)] = frame
        invented += int((batch.raw != signal(frame / rate).astype(np.float32)).any(axis=1).sum())
        seen += len(batch)
        if base is None and seen > min(30, seconds / 3) * rate:
            base = memory()
    grown = memory() - (base or 0.0)
    arrived = ids[:seen]
    longest, used = took[:, :steps]
    total = int(seconds * rate)
    spoilt = np.zeros(total + 10_000, dtype=bool)
    for first, last, _ in port.spoilt:
        spoilt[first : last + 1] = True
    good = np.flatnonzero(~spoilt[:total])
    missing = np.setdiff1d(good, arrived).size
    order = int((np.diff(arrived) <= 0).sum())
    return [
        f"{seconds:.0f} s", f"{len(port.spoilt)}", str(arrived.size), str(missing), str(invented), str(order),
        f"{grown:.1f}", f"{1e3 * max(longest[100:]):.1f}",
        f"{1e3 * max(used[100:]):.1f}", f"{sum(used):.1f}", str(events.get("reset", 0)),
    ]  # fmt: skip


FAULTS = ("dropped", "cut", "changed", "garbage", "restarted", "unplugged")


def memory() -> float:
    """What this process holds [MB]."""
    gc.collect()
    pages = Path("/proc/self/statm")
    if pages.exists():
        return int(pages.read_text().split()[1]) * resource.getpagesize() / 1e6
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1e3


def spin() -> None:
    """A core that is busy."""
    while True:
        pass


def main() -> None:
    """Run and print."""
    options = arguments(__doc__, seconds=10, simulated=60, busy=0)
    others = [multiprocessing.Process(target=spin, daemon=True) for _ in range(options.busy)]
    for one in others:
        one.start()
    rows = [row for sensors in (8, CHANNELS) for row in by_itself(sensors)]
    show("A frame by itself [us]", ["", "sensors", "p50", "p99"], rows, options.json)
    runs = [(1000.0, 1, None), (1000.0, 1, SLIP), (8000.0, 8, SLIP), (8000.0, 32, SLIP)]
    rows = [through_a_pty(rate, at_once, options.seconds, slip) for rate, at_once, slip in runs]
    columns = ["stream", "p50 [ms]", "p99 [ms]", "max [ms]", "frames a batch", "lost", "cores"]
    show("From sending to the answer, 16 channels through a pty", columns, rows, options.json)
    for one in others:
        one.terminate()
    columns = ["simulated", "faults", "frames", "missing", "invented", "out of order", "grown [MB]"]
    columns += ["longest step [ms]", "its CPU [ms]", "CPU [s]", "resets"]
    show("Faults, one a second on average", columns, [faulty(float(options.simulated))], options.json)


if __name__ == "__main__":
    main()
