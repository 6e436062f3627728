"""Hostile files: recordings and bags with bytes overwritten, cut out, doubled, and lengths made huge.

Each is read in a process of its own kind, so that a crash of a library below shows. What counts: a clear error or right
data, never a traceback, a crash, a hang or memory.
"""

from __future__ import annotations

import argparse
import os
import resource
import signal
import tempfile
import time
from collections import Counter
from pathlib import Path

import numpy as np

import subskin as ss
from _common import show
from study_live_kill import BOARD, CHANNELS, TEXT, step
from subskin.errors import FileError
from subskin.live.convert import convert
from subskin.live.record import Recorder
from subskin.live.recording import opened
from subskin.live.sinks.bags import read_bag

SLOW = 20
"""Seconds after which a file counts as a hang."""


def seeds(folder: Path) -> dict[str, bytes]:
    """Good files of each kind."""
    file = ss.io.parse_finger(TEXT)
    rng = np.random.default_rng(0)
    for name in ("good.arrows", "good.parquet"):
        with Recorder(folder / name, file, BOARD) as recorder:
            for k in range(20):
                raw = rng.standard_normal((10, CHANNELS)) * 1e-4
                recorder.put(step(0.01 * k, raw, 10 * k, file.locate(raw)))
                time.sleep(0.02)
    convert(folder / "good.parquet", folder / "good.mcap")
    return {name: (folder / f"good.{name}").read_bytes() for name in ("arrows", "parquet", "mcap")}


def spoilt(data: bytes, rng: np.random.Generator) -> bytes:
    """The same with some damage."""
    bad = bytearray(data)
    for _ in range(int(rng.integers(1, 12))):
        at, size, what = int(rng.integers(len(bad) or 1)), int(rng.integers(1, 200)), int(rng.integers(6))
        if what == 0:
            bad[at : at + size] = rng.bytes(size)
        elif what == 1:
            del bad[at : at + size]
        elif what == 2:
            bad[at:at] = bad[at : at + size]
        elif what == 3:
            bad[at : at + 8] = (2 ** int(rng.integers(64)) - 1).to_bytes(8, "little")
        elif what == 4:
            bad[at : at + 4] = (2 ** int(rng.integers(32)) - 1).to_bytes(4, "little")
        else:
            del bad[at:]
    return bytes(bad)


def read(path: Path, kind: str) -> str:
    """What came of reading it."""
    try:
        if kind == "mcap":
            read_bag(path, path.with_suffix(".out"), "/subskin/raw")
        else:
            with opened(path) as recording:
                for _ in recording.steps():
                    pass
                if recording.left:
                    return "said what is left out"
    except FileError:
        return "refused"
    return "read"


def worker(folder: Path, kind: str, good: bytes, seed: int, count: int, told: int) -> None:
    """Read `count` files; a letter to `told` for each."""
    rng, path = np.random.default_rng(seed), folder / f"bad.{kind}"
    for _ in range(count):
        path.write_bytes(spoilt(good, rng))
        signal.alarm(SLOW)
        try:
            found = read(path, kind)
        except BaseException as error:
            found = f"TRACEBACK {type(error).__name__}"
        signal.alarm(0)
        grown = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss // 1024
        os.write(told, f"{found}|{grown}\n".encode())
    os._exit(0)


def main() -> None:
    """Print a table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seconds", type=float, default=60.0)
    options = parser.parse_args()
    counts: dict[str, Counter[str]] = {}
    largest: Counter[str] = Counter()
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        good = seeds(folder)
        end, seed = time.monotonic() + options.seconds, 0
        while time.monotonic() < end:
            for kind, data in good.items():
                seed += 1
                source, told = os.pipe()
                child = os.fork()
                if not child:
                    worker(folder, kind, data, seed, 200, told)
                os.close(told)
                with os.fdopen(source) as lines:
                    for line in lines:
                        found, _, grown = line.strip().partition("|")
                        counts.setdefault(kind, Counter())[found] += 1
                        largest[kind] = max(largest[kind], int(grown))
                _, status = os.waitpid(child, 0)
                if status:
                    counts[kind][f"CRASH {status}"] += 1
    kinds = sorted({found for c in counts.values() for found in c})
    rows = [[kind, *(str(c[found]) for found in kinds), str(largest[kind])] for kind, c in counts.items()]
    show("hostile files", ["kind", *kinds, "largest memory (MB)"], rows)


if __name__ == "__main__":
    main()
