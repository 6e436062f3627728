"""Maps by fast Fourier transforms beside the same field point by point: stress of local contacts on an even grid.

    python benchmarks/bench_map.py [--side 64] [--repeats 3] [--json FILE]

Points 16 mm x 16 mm wide, 2 mm beneath the surface of a half space and of a layer of 6 mm. The difference is the
largest of any component over the largest stress of the map.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from functools import partial

import numpy as np

import subskin as ss
from _common import arguments, show

SIX = ("xx", "yy", "zz", "xy", "xz", "yz")


def best(call: Callable[[], ss.Stress], repeats: int) -> tuple[float, np.ndarray]:
    """The shortest time of `repeats` calls, and the components of the last."""
    times = []
    for _ in range(repeats):
        start = time.perf_counter()
        stress = call()
        times.append(time.perf_counter() - start)
    return min(times), np.array([getattr(stress, c) for c in SIX])


def mapped_stress(skin: ss.Skin, contact: ss.LocalContact, at: np.ndarray) -> ss.Stress:
    """By a map: what it has to say is worked out here."""
    return skin.map(contact, 2e-3, at, at).stress


def main() -> None:
    """Run and print."""
    options = arguments(__doc__, side=64, repeats=3)
    rng = np.random.default_rng(0)
    nodes = np.linspace(-4e-3, 4e-3, 9)
    hill = 1e5 * np.outer(*(np.cos(np.pi * nodes / 8e-3),) * 2) * rng.uniform(0.5, 1.0, (9, 9))
    contacts = {
        "one `RoundHertz`": ss.RoundHertz(force=1.0, angle=0.4, half_width=2e-3),
        "one `EllipticHertz`": ss.EllipticHertz(force=1.0, angle=0.4, half_widths=(2e-3, 1e-3)),
        "20 `EllipticHertz`": sum(
            ss.EllipticHertz(force=0.1, angle=0.4, position=at, half_widths=(1e-3, 0.6e-3))
            for at in rng.uniform(-4e-3, 4e-3, (20, 2))
        ),
        "`PressureGrid`, 9 x 9 nodes": ss.PressureGrid(nodes, nodes, hill, np.stack([0.3 * hill, 0.1 * hill], -1)),
    }
    soft = ss.Material(young=0.4e6)
    at, rows = np.linspace(-8e-3, 8e-3, options.side), []
    for where, skin in (("half space", ss.HalfSpace(soft)), ("layer", ss.Layered(ss.Layer(soft, 6e-3)))):
        for name, contact in contacts.items():
            mapped, seen = best(partial(mapped_stress, skin, contact, at), options.repeats)
            pointwise, expected = best(partial(skin.stress, contact, 2e-3, at[:, None], at), 1)
            error = np.abs(seen - expected).max() / np.abs(expected).max()
            ratio = f"{pointwise / mapped:.2g}"
            rows.append([where, name, f"{1e3 * mapped:.0f}", f"{1e3 * pointwise:.0f}", ratio, f"{error:.0e}"])
    columns = ["skin", "contact", "map, ms", "by points, ms", "times as quick", "largest difference"]
    show(f"Stress on {options.side} x {options.side} points, by a map and point by point", columns, rows, options.json)


if __name__ == "__main__":
    main()
