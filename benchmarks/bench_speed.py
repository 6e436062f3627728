"""Frames a second of `locate`, covariance and rival included, on one core, beside its peers.

    python benchmarks/bench_speed.py [--frames 100000] [--repeats 30] [--singles 20000] [--peer 40] [--json FILE]

Asked for: 2 M frames/s with 4 sensors, 1 M with 8; a frame by itself 30 us (median) through `Finger.locate`, 5 us (99th
percentile) through a prepared locator.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any

import numpy as np

from _common import arguments, eq13_roots, finger, multi_start, search, show, touches


def seconds(call: Callable[[], Any], repeats: int) -> np.ndarray:
    """Time of each of `repeats` calls, after one that is not counted."""
    call()
    out = []
    for _ in range(repeats):
        start = time.perf_counter_ns()
        call()
        out.append(time.perf_counter_ns() - start)
    return np.array(out) * 1e-9


def main() -> None:
    """Run and print."""
    options = arguments(__doc__, frames=100_000, repeats=30, singles=20_000, peer=40)
    rows = []
    for sensors, pitch, noise in (
        (4, 1.0, 1e-3),
        (4, 0.5, 1e-3),
        (4, 1.0, 1e-2),
        (8, 1.0, 1e-3),
        (8, 0.5, 1e-3),
        (8, 1.0, 1e-2),
    ):
        tip, ends = finger(sensors, pitch, noise), search(sensors, pitch)
        frames = tip.read(touches(sensors, pitch, options.frames, seed=0), np.random.default_rng(1))
        locator, one = tip.locator(search=ends), frames[0].copy()
        batch = seconds(lambda locator=locator, frames=frames: locator(frames), options.repeats)
        public = seconds(lambda tip=tip, one=one, ends=ends: tip.locate(one, search=ends), options.singles) * 1e6
        prepared = seconds(lambda locator=locator, one=one: locator(one), options.singles) * 1e6
        few = frames[: options.peer]
        peer = seconds(lambda tip=tip, few=few, ends=ends: [multi_start(tip, f, ends) for f in few], 1)[0] / len(few)
        roots = seconds(lambda tip=tip, few=few: [eq13_roots(tip, f) for f in few], 3).min() / len(few)
        rows.append(
            [
                f"{sensors}, {pitch} depth, {noise:.1%}",
                f"{options.frames / np.median(batch) / 1000000.0:.2f}",
                f"{options.frames / batch.min() / 1000000.0:.2f}",
                f"{np.median(public):.1f}",
                f"{np.median(prepared):.1f}",
                f"{np.percentile(prepared, 99):.1f}",
                f"{1 / peer:.0f}",
                f"{1 / roots:.0f}",
            ]
        )
    columns = ["sensors, pitch, noise", "M frames/s, median", "best", "Finger.locate, us"]
    columns += ["Locator, us", "Locator, 99 %, us"]
    columns += ["least_squares, 8 starts, frames/s", "numpy.roots of eq. (13), frames/s"]
    show(f"Speed of locate, batches of {options.frames}", columns, rows, options.json)


if __name__ == "__main__":
    main()
