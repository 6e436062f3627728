"""`subskin touches`: simulated touches to learn from, in a Zarr store."""

from __future__ import annotations

import argparse
import sys
import time
from importlib.resources import files
from pathlib import Path
from typing import Any, TextIO

from .. import io
from ..errors import InvalidValueError
from .cluster import DASK, cluster
from .common import give, progress_bar
from .options import JSON, command, option

_EXAMPLES = """\
  subskin touches --example > touches.toml             # a file to begin with; every key is explained in it
  subskin touches touches.toml --plan                  # touches, shards, bytes and core-hours; nothing is written
  subskin touches touches.toml -o touches.zarr         # the same command goes on where it was stopped
  subskin touches touches.toml -o touches.zarr --dask tcp://host:8786
  subskin touches touches.toml -o touches.parquet      # one table, begun anew where it was stopped

  xarray.open_zarr("touches.zarr")                     # in Python: readings, parameters, labels, done
"""
_NOTES = """\
Draws contacts at random, as touches.toml says, and writes readings and what made them, in shards of a seed each: the
same file gives the same bits, whoever computes it. Needs pip install "subskin[touches]"; a table .parquet needs
"subskin[parquet]".
"""


_TABLES = (".parquet", ".pq", ".csv")


@command(
    _EXAMPLES,
    option("touches?", "touches.toml"),
    option("-o --out FILE", "the Zarr store, a folder, as touches.zarr; or one table, .parquet or .csv"),
    option("--plan", "say what all of it will cost, from the first shard, and stop"),
    option("--workers N", "shards computed at a time (one for each core)", type=int),
    DASK,
    option("--example", "print an example of touches.toml and stop"),
    JSON,
    notes=_NOTES,
)
def run_touches(options: argparse.Namespace) -> int:
    """Run the command."""
    if options.example:
        sys.stdout.write(files("subskin.io").joinpath("touches_example.toml").read_text(encoding="utf-8"))
        return 0
    if options.touches is None:
        raise InvalidValueError("no file", "a touches.toml is needed", "subskin touches --example > touches.toml")
    if options.workers is not None and options.workers < 1:
        raise InvalidValueError(f"--workers {options.workers}", "has to be >= 1", "--workers 1")
    if options.out is None and not options.plan:
        raise InvalidValueError("no -o", "a folder for the touches is needed", "-o touches.zarr, or --plan")
    file = io.load_touches(options.touches)
    if file.finger.finger.measured is not None:
        what = f"{file.finger.name} has a response in place, and readings are simulated by the field of its skin"
        print(f"subskin: warning: {what}", file=sys.stderr)
    if options.plan:
        return _plan(options, file)
    touches, start = file.touches, time.monotonic()
    try:
        with cluster(options) as executor, progress_bar("touches", touches.count) as advance:
            if options.out.lower().endswith(_TABLES):
                if executor is not None:
                    seen, rule = f"--dask with -o {options.out}", "workers write into a Zarr store, shard by shard"
                    raise InvalidValueError(seen, rule, "-o touches.zarr")
                io.write_touches(file, options.out, workers=options.workers, progress=advance)
                made: Any = range(touches.shards)
            else:
                made = io.save_touches(file, options.out, executor=executor, workers=options.workers, progress=advance)
    except KeyboardInterrupt:
        if not Path(options.out).is_dir():
            raise
        done = int(io.shards_done(options.out).sum())
        kept = f"{done} of {touches.shards} shards are in {options.out}"
        print(f"subskin: stopped; {kept}, the same command goes on from there", file=sys.stderr)
        return 130
    seconds = time.monotonic() - start
    return give(
        options, lambda: _as_json(options, file, made, seconds), lambda out: _show(out, options, file, made, seconds)
    )


def _as_json(options: argparse.Namespace, file: io.TouchesFile, made: Any, seconds: float) -> dict[str, Any]:
    touches = file.touches
    return {
        "touches": touches.count, "sensors": len(file.finger.names), "parameters": touches.parameters,
        "labels": touches.labels, "shards": touches.shards, "computed": len(made), "seconds": seconds,
        "out": options.out,
    }  # fmt: skip


def _show(out: TextIO, options: argparse.Namespace, file: io.TouchesFile, made: Any, seconds: float) -> None:
    touches = file.touches
    before = touches.shards - len(made)
    found = f", {before} of them found there" if before else ""
    print(f"{touches.count} touches, {len(file.finger.names)} sensors -> {options.out}", file=out)
    print(f"{touches.shards} shards{found}, in {seconds:.1f} s", file=out)


def _plan(options: argparse.Namespace, file: io.TouchesFile) -> int:
    cost = io.cost_of_touches(file)

    def people(out: TextIO) -> None:
        print(f"{cost.touches} touches, {len(file.finger.names)} sensors, in {cost.shards} shards", file=out)
        print(f"{in_bytes(cost.size)}, {cost.size / cost.touches:.0f} bytes a touch", file=out)
        micro = cost.core_hours * 3.6e9 / cost.touches
        print(f"{in_hours(cost.core_hours)} of one core, {micro:.3g} us a touch", file=out)
        print(f"measured on {cost.measured} touches of the first shard, on this machine", file=out)

    return give(options, lambda: {**vars(cost)}, people)


def in_bytes(size: float) -> str:
    """A size for people.

    Examples
    --------
    >>> in_bytes(7.5e9), in_bytes(120.0)
    ('7.5 GB', '120 bytes')
    """
    for unit, name in ((1e12, "TB"), (1e9, "GB"), (1e6, "MB"), (1e3, "kB")):
        if size >= unit:
            return f"{size / unit:.3g} {name}"
    return f"{size:.0f} bytes"


def in_hours(hours: float) -> str:
    """A time for people.

    Examples
    --------
    >>> in_hours(2.4), in_hours(0.05), in_hours(0.001)
    ('2.4 hours', '3 minutes', '3.6 seconds')
    """
    if hours >= 1:
        return f"{hours:.3g} hours"
    return f"{hours * 60:.3g} minutes" if hours >= 1 / 60 else f"{hours * 3600:.3g} seconds"
