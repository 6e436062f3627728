"""How much memory and time the commands take that answer frame by frame, and how quickly tables are read and written.

Peak resident memory is that of a process of its own. Frames are 20 000 simulated ones, again and again.
"""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np

import subskin as ss
from _common import arguments, show
from subskin.io import reading, writing

FINGER = '[skin]\nyoung = "0.4 MPa"\n[sensors]\ncount = 8\npitch = "1.5 mm"\ndepth = "2 mm"\nnoise = 1e-4\n'


def frames(rows: int) -> dict[str, np.ndarray]:
    """Readings of `rows` touches, and the time of each."""
    rng = np.random.default_rng(0)
    skin = ss.HalfPlane(ss.Material(young=0.4e6))
    finger = ss.Finger(skin, ss.SensorArray.line(count=8, pitch=1.5e-3, depth=2e-3, noise=1e-4))
    touch = ss.LineLoad(rng.uniform(10.0, 60.0, rows), rng.uniform(-0.5, 0.5, rows), rng.uniform(-5e-3, 5e-3, rows))
    readings = finger.read(touch, rng)
    return {"time": np.arange(rows) * 1e-3} | {f"s{i}": readings[:, i] for i in range(8)}


def write(path: Path, rows: int, block: dict[str, np.ndarray]) -> float:
    """Write a table of `rows` rows; the processor seconds that it took."""
    size, begin = len(block["time"]), time.process_time()
    with writing(path) as table:
        for first in range(0, rows, size):
            count = min(size, rows - first)
            moved = block["time"][:count] + first * 1e-3
            table.write({name: moved if name == "time" else values[:count] for name, values in block.items()})
    return time.process_time() - begin


def read(path: Path) -> float:
    """Read a table to its end; the processor seconds that it took."""
    begin = time.process_time()
    with reading(path) as table:
        for part in table:
            part.readings([f"s{i}" for i in range(8)])
    return time.process_time() - begin


def read_by_arrow(path: Path) -> float:
    """The same by PyArrow's reader, which holds all of it."""
    from pyarrow import csv

    begin = time.process_time()
    csv.read_csv(path)
    return time.process_time() - begin


_CHILD = """
import resource, subprocess, sys, time
begin = time.perf_counter()
subprocess.run([sys.executable, "-m", "subskin", *sys.argv[1:]], check=True, stdout=subprocess.DEVNULL)
print(time.perf_counter() - begin, resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss / 1e3)
"""


def run(*arguments: str) -> tuple[float, float]:
    """Seconds and peak memory [MB] of a command; a small process starts it, for a child's peak counts its parent's."""
    ran = subprocess.run([sys.executable, "-c", _CHILD, *arguments], check=True, capture_output=True, text=True)
    seconds, memory = map(float, ran.stdout.split())
    return seconds, memory


def main() -> None:
    """Print the tables."""
    given = arguments(__doc__, many=10_000_000, few=200_000)
    many, few = given.many, given.few
    block = frames(20_000)
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        (folder / "finger.toml").write_text(FINGER)
        os.chdir(folder)
        speed = []
        for kind in ("csv", "parquet"):
            path = folder / f"speed.{kind}"
            wrote, took = (500_000 / seconds / 1e6 for seconds in (write(path, 500_000, block), read(path)))
            speed.append([kind, f"{wrote:.2f}", f"{took:.2f}"])
        speed.append(["csv, PyArrow, whole", "-", f"{0.5 / read_by_arrow(folder / 'speed.csv'):.2f}"])
        show(
            "time and 8 sensors, rows a second of the processor",
            ["file", "written [Mrow/cpu s]", "read [Mrow/cpu s]"],
            speed,
        )
        rows = []
        for command, count in (("locate", many), ("fit", many), ("decide", few), ("pressure", few)):
            for kind in ("csv", "parquet"):
                write(folder / f"big.{kind}", count, block)
                out = "--totals" if command == "pressure" else "-o"
                seconds, memory = run(command, "finger.toml", f"big.{kind}", out, f"out.{kind}")
                rows.append([command, kind, f"{count:.0e}", f"{seconds:.0f}", f"{memory:.0f}"])
                print(" ".join(rows[-1]), file=sys.stderr)
                for file in folder.glob(f"*.{kind}"):
                    file.unlink()
        show("commands", ["command", "file", "rows", "time [s]", "peak memory [MB]"], rows)


if __name__ == "__main__":
    main()
