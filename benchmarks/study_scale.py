"""Work shared out: the same bytes by one thread, two, and Dask, also with a worker killed; the rate of touches.

Needs `pip install "subskin[dask,touches]"`. Peak memory and processor time are those of a process of its own.
"""

from __future__ import annotations

import hashlib
import os
import signal
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import xarray
from distributed import Client, LocalCluster

import subskin as ss
from _common import arguments, show
from subskin.design import Goals, Touches, search_grid
from subskin.design.search import Accuracy, Effort, Room, SensorKind, SkinChoice
from subskin.io import cost_of_touches, load_touches

ROW = '[skin]\nyoung = "0.4 MPa"\n[sensors]\ncount = 8\npitch = "1.5 mm"\ndepth = "2 mm"\nnoise = 1e-4\n'
LAYER = ROW.replace('young = "0.4 MPa"', 'kind = "layers"\nlayers = [{ young = "0.4 MPa", thickness = "6 mm" }]')
AREA = """\
[skin]
kind = "half_space"
young = "0.4 MPa"
[sensors]
layout = "grid"
shape = [4, 4]
pitch = "3 mm"
depth = "3 mm"
kind = "mean_pressure"
noise = 20
"""
LONG = """\
finger = "finger.toml"
touches = {count}
load = {{ force = ["5 N/m", "60 N/m"], angle = ["-30 deg", "30 deg"], noise = [0.5, 2] }}
contact = [{{ family = "line" }}, {{ family = "hertz", share = 2, half_width = ["0.2 mm", "2 mm"] }}]
fault = {{ dead = 0.01, weak = 0.02, shifted = 0.02 }}
"""
POINT = """\
finger = "finger.toml"
touches = {count}
load = {{ force = ["0.1 N", "2 N"], angle = ["0 deg", "30 deg"], azimuth = ["0 deg", "360 deg"] }}
contact = [{{ family = "point" }}]
"""
ROUND = POINT.replace('family = "point"', 'family = "round_hertz", half_width = ["0.2 mm", "2 mm"]')


def goals() -> Goals:
    """Twenty rows of designs."""
    return Goals(
        touches=Touches(force=20.0, friction=0.5, span=(-4e-3, 4e-3)),
        strongest=100.0,
        accuracy=Accuracy(position=0.1e-3),
        sensors=(SensorKind("gauge", ss.NormalStrain(), 2e-4), SensorKind("pressure", ss.MeanPressure(), 30.0)),
        skins=(SkinChoice("silicone", ss.HalfPlane(ss.Material(young=0.4e6))),),
        room=Room(count=(4, 6), depth=(1e-3, 4e-3), least_pitch=0.8e-3, longest_row=14e-3),
        tolerances={},
        effort=Effort(depths=10, pitches=4, touches=1000, keep=1),
    )


def digest(arrays: Any) -> str:
    """The first letters of a digest of all bytes."""
    done = hashlib.sha256()
    for array in arrays:
        done.update(np.ascontiguousarray(array).tobytes())
    return done.hexdigest()[:12]


def searched(**how: Any) -> list[str]:
    """The digest of a search, and its time."""
    begin = time.perf_counter()
    grid = search_grid(goals(), **how)
    return [digest(grid.values[name] for name in sorted(grid.values)), f"{time.perf_counter() - begin:.1f}"]


def killer(client: Client) -> Callable[[], None]:
    """Kills a worker when a quarter of the rows is there."""
    count = 0

    def passed() -> None:
        nonlocal count
        count += 1
        if count == 5:
            os.kill(next(iter(client.run(os.getpid).values())), signal.SIGKILL)

    return passed


def command(*said: str) -> tuple[float, float, float]:
    """A command of subskin in a process of its own: its time, its processor time [s], its peak memory [MB]."""
    begin = time.perf_counter()
    process = os.posix_spawn(sys.executable, [sys.executable, "-m", "subskin", *said], os.environ)
    _, status, used = os.wait4(process, 0)
    if status:
        raise SystemExit(f"subskin {' '.join(said)} failed")
    return time.perf_counter() - begin, used.ru_utime + used.ru_stime, used.ru_maxrss / 1024


def shared_out(target: Path | None) -> None:
    """One search, by all who can do it."""
    rows = [["one thread", *searched(workers=1)], ["two threads", *searched(workers=2)]]
    begin = time.perf_counter()
    workers = {"n_workers": 2, "threads_per_worker": 1, "dashboard_address": None, "silence_logs": 50}
    with LocalCluster(**workers) as cluster, Client(cluster) as client:
        rows.append(["start of Dask", "-", f"{time.perf_counter() - begin:.1f}"])
        rows.append(["Dask, two processes", *searched(executor=client)])
        rows.append(["Dask, one killed in mid-run", *searched(executor=client, progress=killer(client))])
    show("a search of 20 rows of designs", ["by", "digest", "time [s]"], rows, target)
    if len({row[1] for row in rows} - {"-"}) != 1:
        raise SystemExit("the digests differ")


def many_touches(count: int, target: Path | None) -> None:
    """Touches to learn from, by threads and by Dask, and rows of them read at random."""
    Path("finger.toml").write_text(ROW)
    Path("touches.toml").write_text(LONG.format(count=count))
    rows = []
    for name, more in (("threads", ()), ("Dask, two processes", ("--dask", "local", "--workers", "2"))):
        out = f"{name.split(',')[0]}.zarr"
        seconds, busy, memory = command("touches", "touches.toml", "-o", out, *more)
        size = sum(path.stat().st_size for path in Path(out).rglob("*") if path.is_file())
        found = xarray.open_zarr(out, chunks=None)
        blocks = [slice(i, i + 100_000) for i in range(0, count, 100_000)]
        each = digest(found[array][block] for array in ("readings", "parameters") for block in blocks)
        some = np.sort(np.random.default_rng(0).choice(count, 256, replace=False))
        begin = time.perf_counter()
        found.readings[some].values  # noqa: B018
        read = time.perf_counter() - begin
        rows.append([name, each, f"{seconds:.1f}", f"{busy:.1f}" if not more else "-", f"{size / count:.1f}",
                     f"{memory:.0f}", f"{1e3 * read:.0f}"])  # fmt: skip
    columns = ["by", "digest", "time [s]", "cpu [s]", "bytes a touch", "peak memory [MB]", "256 rows at random [ms]"]
    show(f"{count:.0e} touches of 8 sensors", columns, rows, target)
    if rows[0][1] != rows[1][1]:
        raise SystemExit("the digests differ")


def plans(target: Path | None) -> None:
    """What 1e8 touches cost, from the first shard."""
    rows = []
    for name, finger, text in (
        ("8 sensors in a row, half plane, line and hertz", ROW, LONG),
        ("8 sensors in a row, 6 mm layer, line and hertz", LAYER, LONG),
        ("16 sensors on an area, half space, point", AREA, POINT),
        ("16 sensors on an area, half space, round_hertz", AREA, ROUND),
    ):
        Path("finger.toml").write_text(finger)
        Path("touches.toml").write_text(text.format(count=100_000_000))
        cost = cost_of_touches(load_touches("touches.toml"))
        each = cost.core_hours * 3.6e9 / cost.touches
        rows.append([name, f"{cost.measured}", f"{each:.2f}", f"{cost.core_hours:.3g}", f"{cost.size / 1e9:.2f}"])
    columns = ["1e8 touches", "measured on", "cpu a touch [us]", "core-hours", "size [GB]"]
    show("extrapolated from the first of 1000 shards, as by --plan", columns, rows, target)


def main() -> None:
    """Print the tables."""
    given = arguments(__doc__, count=1_000_000)
    target = None if given.json is None else given.json.absolute()
    with tempfile.TemporaryDirectory() as folder:
        os.chdir(folder)
        many_touches(given.count, target)
        plans(target)
        shared_out(target)


if __name__ == "__main__":
    main()
