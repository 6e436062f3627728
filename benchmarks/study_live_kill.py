"""What is left of a recording that is killed (SIGKILL) at a random moment; and how much memory a large one takes.

Each recorder runs in a process of its own at 1000 frames a second, one frame a step, and is killed between 0 and 3 s
after it began. A frame counts as due where it was handed to the recorder more than a second before the kill.
"""

from __future__ import annotations

import argparse
import os
import resource
import signal
import tempfile
import time
from pathlib import Path
from types import SimpleNamespace

import numpy as np

import subskin as ss
from _common import show
from subskin.live.convert import convert
from subskin.live.record import Recorder
from subskin.live.recording import opened, recover

CHANNELS = 16
RATE = 1000.0
TEXT = f"""
[skin]
young = "0.4 MPa"

[sensors]
count = {CHANNELS}
pitch = "2 mm"
depth = "2 mm"
noise = 1e-4
"""
BOARD = SimpleNamespace(channels=tuple(f"p{i}" for i in range(CHANNELS)), name="board")


def step(time_of: float, raw: np.ndarray, number: int, found: object = None) -> SimpleNamespace:
    """What a chain would hand to a recorder."""
    n = len(raw)
    return SimpleNamespace(
        host_time=time_of, command="", values={}, time=time_of + np.arange(n) / RATE, device_time=np.full(n, np.nan),
        sequence=number + np.arange(n), raw=raw, readings=raw, free=np.zeros(n, dtype=bool), lost=0, bad=0,
        found=found, decision=None, events=(),
    )  # fmt: skip


def record(path: Path, file: ss.io.FingerFile, ready: int) -> None:
    """Record until killed; frame k is handed over at `began` + k / RATE."""
    recorder = Recorder(path, file, BOARD)
    raw = np.random.default_rng(0).standard_normal((1, CHANNELS))
    os.write(ready, b".")
    began, number = time.monotonic(), 0
    while True:
        recorder.put(step(time.monotonic(), raw, number))
        number += 1
        time.sleep(max(began + number / RATE - time.monotonic(), 0.0))


def kills(file: ss.io.FingerFile, count: int, seed: int) -> dict[str, float]:
    """What is left after each kill."""
    rng = np.random.default_rng(seed)
    unreadable, holes, ages, frames = 0, 0, [], []
    with tempfile.TemporaryDirectory() as folder:
        for k in range(count):
            path = Path(folder) / f"{k}.parquet"
            read, write = os.pipe()
            child = os.fork()
            if not child:
                record(path, file, write)
            os.read(read, 1)
            time.sleep(float(rng.uniform(0.0, 3.0)))
            os.kill(child, signal.SIGKILL)
            at = time.monotonic()
            os.waitpid(child, 0)
            os.close(read)
            os.close(write)
            try:
                found = recover(f"{path}.arrows")
            except ss.errors.FileError:
                unreadable += 1
                continue
            with opened(found.path) as recording:
                steps = list(recording.steps())
            if not steps:  # killed within the first quarter of a second
                continue
            numbers = np.concatenate([s.frames.sequence for s in steps])
            holes += int((np.diff(numbers) != 1).sum() + (numbers[0] != 0))
            ages.append(at - steps[-1].host_time)
            frames.append(len(numbers))
    return {"unreadable": unreadable, "holes": holes, "frames": sum(frames), "median": float(np.median(ages)),
            "worst": max(ages), "recovered": len(ages)}  # fmt: skip


def peak() -> float:
    """Largest memory of this process so far [MB]."""
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024


def large(file: ss.io.FingerFile, megabytes: float) -> list[list[str]]:
    """Memory while a recording grows, is closed, and is converted: growth of the peak over that of a short one."""
    rng = np.random.default_rng(1)
    rows = []
    with tempfile.TemporaryDirectory() as folder:
        for size in (8.0, megabytes):
            path = Path(folder) / f"{size:g}.parquet"
            raw = rng.standard_normal((200, CHANNELS))
            number = 0
            began = time.perf_counter()
            recorder = Recorder(path, file, BOARD)
            part = Path(f"{path}.arrows")
            while part.stat().st_size < size * 2**20:
                recorder.put(step(number / RATE, raw, number))
                number += 200
            grown = peak()
            wrote = time.perf_counter() - began
            recorder.close()
            closed, took = peak(), time.perf_counter() - began - wrote
            convert(path, path.with_suffix(".csv"))
            said = f"{size:g} MB, {number} frames"
            rows.append([said, *(f"{x:.0f}" for x in (wrote, took, grown, closed, peak()))])
    return rows


def main() -> None:
    """Print the tables."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--kills", type=int, default=50)
    parser.add_argument("--megabytes", type=float, default=1000.0, help="size of the large recording")
    parser.add_argument("--seed", type=int, default=0)
    options = parser.parse_args()
    file = ss.io.parse_finger(TEXT)
    memory = large(file, options.megabytes) if options.megabytes else []
    found = kills(file, options.kills, options.seed) if options.kills else None
    if found:
        show(
            f"{options.kills} recorders killed at random moments",
            ["files that gave frames", "unreadable", "holes", "frames", "age of the last frame (s), median", "worst"],
            [[*(f"{found[k]:.0f}" for k in ("recovered", "unreadable", "holes", "frames")),
              f"{found['median']:.2f}", f"{found['worst']:.2f}"]],
        )  # fmt: skip
    if memory:
        show(
            "peak memory of the process (MB)",
            ["recording", "recorded in (s)", "closed in (s)", "while recording", "closed", "converted"],
            memory,
        )


if __name__ == "__main__":
    main()
