"""The angle of force on a side, three ways: full fit, slope beneath the centre, gradients at two depths; and a peer.

    python benchmarks/bench_side_angle.py [--frames 1000] [--peer 20] [--json FILE]

Hertz contacts, centres within half a depth of the row's middle, leaning within 40 degrees. The row has 5 or 9 sensors
half a depth apart; the gradients are taken from two rows of 9, a quarter depth apart, at 0.9 and 1.1 depths. The fit
is told nothing; the slope is told centre and half width exactly, or the centre with an error of 1 % of the depth; the
gradient rule the centre exactly. Errors are rms in degrees over the frames that got an angle, whose share follows; the
peer is least_squares of the same model as the fit's from 9 starts.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np
from scipy.optimize import least_squares

import subskin as ss
from _common import FULL_SCALE, arguments, show

SKIN = ss.HalfPlane(ss.Material(young=1.0))
WIDTHS = (0.3, 0.7, 1.0, 1.2, 1.5, 2.0)
WIDEST = 2.5
KNOWN = 0.01


def row(sensors: int, noise: float) -> ss.Finger:
    """Sensors at unit depth, half a depth apart."""
    return ss.Finger(SKIN, ss.SensorArray.line(sensors, pitch=0.5, depth=1.0, noise=noise * FULL_SCALE))


def pair(noise: float) -> ss.Finger:
    """Two rows of nine."""
    y = np.tile(0.25 * np.arange(-4, 5), 2)
    return ss.Finger(SKIN, ss.SensorArray(y=y, depth=np.repeat([0.9, 1.1], 9), noise=noise * FULL_SCALE))


def strain(s: np.ndarray, position: float, normal: float, drag: float, half_width: float) -> np.ndarray:
    """Strain at unit depth beneath a Hertz contact, nu = 1/2 (docs/theory.md)."""
    z = s - position + 1j
    root = np.sqrt(z - half_width) * np.sqrt(z + half_width)
    f, df = -2 / (z + root), 2 / (root * (z + root))
    return 1.5 / np.pi * (normal * df.real + drag * (df.imag - f.real))


def peer(tip: ss.Finger, frame: np.ndarray) -> float:
    """Angle by least_squares, from three places and three widths, the best admissible of them."""
    s, sigma = np.asarray(tip.array.y), np.asarray(tip.array.noise)

    def residual(p: np.ndarray) -> np.ndarray:
        return (strain(s, p[0], p[1], p[2], abs(p[3]) + 1e-6) - frame) / sigma

    starts = [[y, 1.0, 0.0, a] for y in (-1.0, 0.0, 1.0) for a in (0.3, 0.9, 1.8)]
    best = min(
        (least_squares(residual, p, method="lm") for p in starts),
        key=lambda r: r.cost + 1e9 * (r.x[1] <= 0 or abs(r.x[2]) > r.x[1] or abs(r.x[3]) > WIDEST),
    )
    return float(np.arctan2(best.x[2], best.x[1]))


def timed(tell: Callable[[], Any], frames: int) -> tuple[Any, float]:
    """What is told, and the best time of three in microseconds a frame."""
    times = []
    for _ in range(3):
        start = time.perf_counter()
        told = tell()
        times.append(time.perf_counter() - start)
    return told, 1e6 * min(times) / frames


def main() -> None:
    """Run and print."""
    options = arguments(__doc__, frames=1000, peer=20)
    rng = np.random.default_rng(0)
    rows, spent = [], {}
    count = options.frames
    for sensors, noise in ((5, 1e-3), (9, 1e-3), (5, 1e-2), (9, 1e-2)):
        one, two = row(sensors, noise), pair(noise)
        one.fit(np.zeros(sensors), half_width=(0.0, WIDEST))
        for a in WIDTHS:
            angle = rng.uniform(-np.deg2rad(40), np.deg2rad(40), count)
            touch = ss.Hertz(np.ones(count), angle, rng.uniform(-0.5, 0.5, count), half_width=a)
            frames, pairs = one.read(touch, rng), two.read(touch, rng)
            position, off = touch.position, touch.position + KNOWN * rng.normal(size=count)
            ways = {
                "fit": partial(one.fit, frames, half_width=(0.0, WIDEST)),
                "slope": partial(ss.side_angle, one, frames, position=position, half_width=a),
                "off": partial(ss.side_angle, one, frames, position=off, half_width=a, position_std=KNOWN),
                "gradients": partial(ss.estimate.side_angle_from_gradients, two, pairs, position=position),
            }
            cells = [f"{sensors}, {noise:.1%}, {a:g}"]
            for name, way in ways.items():
                told, taken = timed(way, count)
                spent.setdefault(name, []).append(taken)
                given = told.status == ss.Status.OK
                error = np.rad2deg(told.angle - angle)[given]
                rms = f"{np.sqrt((error**2).mean()):.2f}" if given.any() else "-"
                cells.append(f"{rms} ({given.mean():.0%})")
            few = slice(options.peer)
            start = time.perf_counter()
            theirs = np.array([peer(one, frame) for frame in frames[few]])
            spent.setdefault("peer", []).append(1e6 * (time.perf_counter() - start) / options.peer)
            cells.append(f"{np.sqrt(np.mean(np.rad2deg(theirs - angle[few]) ** 2)):.2f}")
            rows.append(cells)
    held = ss.Hertz(np.ones(100_000), 0.3, 0.1, half_width=0.7)
    many, double = row(7, 1e-3), pair(1e-3)
    frames, pairs = many.read(held, rng), double.read(held, rng)
    _, slope = timed(partial(ss.side_angle, many, frames, position=0.1, half_width=0.7), 100_000)
    _, gradients = timed(partial(ss.estimate.side_angle_from_gradients, double, pairs, position=0.1), 100_000)
    us = {name: f"{np.median(taken):.3g}" for name, taken in spent.items()}
    rows.append(["us a frame", *us.values()])
    rows.append(["us a frame, contact held", "-", f"{slope:.2g}", "-", f"{gradients:.2g}", "-"])
    columns = [
        "sensors, noise, half width / depth",
        "fit",
        "slope",
        f"slope, centre off by {KNOWN:.0%}",
        "gradients",
        "least_squares, 9 starts",
    ]
    show(
        f"Angle on a side: rms error in degrees (share of frames that get an angle), {count} frames each",
        columns,
        rows,
        options.json,
    )


if __name__ == "__main__":
    main()
