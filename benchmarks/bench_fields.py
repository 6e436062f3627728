"""Stress on a 1000 x 1000 grid beneath line loads and a Hertz contact, and batches read by 16 x 16 sensors.

    python benchmarks/bench_fields.py [--side 1000] [--repeats 3] [--json FILE]

Bytes are those of the four components that come back. The peer is the textbook sum written straight in NumPy.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any

import numpy as np

import subskin as ss
from _common import arguments, show


def best(call: Callable[[], Any], repeats: int) -> tuple[float, Any]:
    """The shortest time of `repeats` calls, and the last result."""
    times, result = [], None
    for _ in range(repeats):
        start = time.perf_counter()
        result = call()
        times.append(time.perf_counter() - start)
    return min(times), result


def bandwidth() -> float:
    """Bytes a second of a copy of 256 MB, read and write counted."""
    a = np.ones(1 << 25)
    b = np.empty_like(a)
    time_taken, _ = best(lambda: np.copyto(b, a), 5)
    return 2 * a.nbytes / time_taken


def flamant(loads: list[ss.LineLoad], x: np.ndarray, y: np.ndarray) -> list[np.ndarray]:
    """sigma_x, sigma_y, tau_xy of line loads (memo eq. 4), as one would write it."""
    out = [np.zeros(np.broadcast_shapes(x.shape, y.shape)) for _ in range(3)]
    for load in loads:
        t = y - load.position
        r2 = x * x + t * t
        radial = -2 / np.pi * (load.normal_force * x + load.tangential_force * t) / r2
        for total, part in zip(out, (radial * x * x / r2, radial * t * t / r2, radial * x * t / r2), strict=True):
            total += part
    return out


def reading(repeats: int) -> list[list[str]]:
    """Time of a frame in a batch of 300, of 16 x 16 sensors 2 mm deep in a half space."""
    rng, frames, rows = np.random.default_rng(0), 300, []
    load = {
        "components": rng.uniform((1.0, -0.5, -0.5), (2.0, 0.5, 0.5), (frames, 3)),
        "position": rng.uniform(-12e-3, 12e-3, (frames, 2)),
    }
    wide = rng.uniform(0.7e-3, 3e-3, (frames, 2))
    touches = {"point": ss.PointLoad(**load), "patch": ss.Patch(**load, half_widths=wide)}
    for kind in (ss.NormalStrain(), ss.MeanPressure()):
        array = ss.SensorArray.grid((16, 16), pitch=2e-3, depth=2e-3, transducer=kind)
        finger = ss.Finger(ss.HalfSpace(ss.Material(young=0.4e6, poisson=0.45)), array)
        for name, touch in touches.items():
            seconds, _ = best(lambda: finger.read(touch), 3 * repeats)  # noqa: B023
            rows.append([f"{name}, {type(kind).__name__}", f"{1e6 * seconds / frames:.1f}"])
    return rows


def main() -> None:
    """Run and print."""
    options = arguments(__doc__, side=1000, repeats=3)
    skin = ss.HalfPlane(ss.Material(young=0.4e6))
    x = np.linspace(1e-5, 5e-3, options.side)[:, None]
    y = np.linspace(-5e-3, 5e-3, options.side)[None, :]
    rng = np.random.default_rng(0)
    loads = [
        ss.LineLoad(40.0, a, p) for a, p in zip(rng.uniform(-0.5, 0.5, 50), rng.uniform(-4e-3, 4e-3, 50), strict=True)
    ]
    together, roller = sum(loads), ss.Hertz(40.0, 0.2, 1e-4, 1e-3)
    copy = bandwidth()
    rows = []
    result_bytes = 4 * 8 * options.side**2
    times, field = best(lambda: skin.stress(together, x, y), options.repeats)
    peer, reference = best(lambda: flamant(loads, x, y), options.repeats)
    got = np.stack([field.xx, field.yy, field.xy])
    error = np.abs(got - np.stack(reference)).max(0) / np.abs(np.stack(reference)).max(0)
    for name, seconds, note in (
        ("50 line loads, HalfPlane.stress", times, f"{error.max():.0e}"),
        ("50 line loads, the sum in NumPy", peer, "-"),
        ("one Hertz contact, HalfPlane.stress", best(lambda: skin.stress(roller, x, y), options.repeats)[0], "-"),
    ):
        rate = result_bytes / seconds
        rows.append([name, f"{1e3 * seconds:.0f}", f"{rate / 1e9:.3f}", f"{rate / copy:.2%}", note])
    columns = ["", "ms", "GB/s of results", f"of a copy's {copy / 1e9:.1f} GB/s", "largest difference"]
    show(f"Fields on {options.side} x {options.side} points", columns, rows, options.json)
    show("Readings of 16 x 16 sensors, in a batch", ["", "us a frame"], reading(options.repeats), options.json)


if __name__ == "__main__":
    main()
