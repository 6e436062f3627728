"""`pressure_map`: how near the truth and how fast, beside a loop over `scipy.optimize.nnls` on the same problem.

    python benchmarks/bench_pressure.py [--frames 2000] [--peer 100] [--json FILE]

A Hertz contact over the middle of a row in a half plane, lengths in depths, noise in shares of the reading of a unit
line load right above (the contact's own largest reading is 0.6 of that: of it, the noise is 1.7 times as much). Errors
are relative, in the L2 norm along the surface. Asked for: 0.10 at half width 1, pitch 0.25, noise 0.1 %, also with
drag of 30 degrees to either side; at most 100 us a frame in one thread. Times
are of the processor: what else it does is left out.

The peer is given the weights (and angles) that `pressure_map` found and only solves for the pressure.
"""

from __future__ import annotations

import os

os.environ.setdefault("OMP_NUM_THREADS", "1")
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import time

import numpy as np
from scipy.optimize import nnls

import subskin as ss
from _common import arguments, finger, show


def touches(count: int, half_width: float, degrees: float, seed: int = 0) -> ss.Hertz:
    """Unit loads within half a depth of the middle."""
    position = np.random.default_rng(seed).uniform(-0.5, 0.5, count)
    return ss.Hertz(force=np.ones(count), angle=np.deg2rad(degrees), position=position, half_width=half_width)


def errors(found: ss.estimate.PressureMap, touch: ss.Contact) -> np.ndarray:
    """Relative L2 error of the pressure of each frame."""
    true = touch.expand(1).pressure(found.y)
    return np.linalg.norm(found.pressure - true, axis=-1) / np.linalg.norm(true, axis=-1)


def best_of(runs: int, work: object) -> float:
    """Processor seconds of the fastest run."""
    spent = []
    for _ in range(runs):
        start = time.thread_time()
        work()
        spent.append(time.thread_time() - start)
    return min(spent)


def peer(
    mapper: ss.estimate.PressureMapper, frames: np.ndarray, found: ss.estimate.PressureMap
) -> tuple[float, np.ndarray]:
    """Processor seconds a frame and pressures of a loop over nnls, with the Hessian's factor for the stacked matrix."""
    y = found.y
    sigma, hats = np.asarray(mapper.array.noise), mapper._hats(mapper.array.live)
    step, m = y[1] - y[0], len(y) - 2
    normal, tangential = hats.columns(0), hats.columns(1)
    stiffness = (2 * np.eye(m) - np.eye(m, k=1) - np.eye(m, k=-1)) / step
    cost = mapper.least_force * np.linalg.norm(normal, axis=1).max()
    plain = normal @ normal.T
    answers = np.zeros((len(frames), len(y)))
    start = time.thread_time()
    for f, frame in enumerate(frames / sigma):
        t = np.tan(found.angle[f])
        columns = normal + t * tangential if t else normal
        gram = columns @ columns.T if t else plain
        root = np.linalg.cholesky(gram + found.weight[f] * stiffness)
        answers[f, 1:-1] = nnls(root.T, np.linalg.solve(root, columns @ frame - cost), maxiter=10000)[0]
    return (time.thread_time() - start) / len(frames), answers


def target(options: object) -> list[list[str]]:
    """What is asked for, by rule and drag."""
    rows = []
    tip = finger(25, 0.25, 1e-3)
    for rule in ("evidence", "discrepancy", "gcv"):
        for degrees in (-30, 0, 30) if rule == "evidence" else (0, 30):
            touch = touches(options.frames, 1.0, degrees)
            frames = tip.read(touch, np.random.default_rng(1))
            for shear in ("none", "proportional") if degrees == 0 else ("proportional",):
                mapper = ss.estimate.PressureMapper(tip, rule=rule, shear=shear)
                found = mapper(frames)
                spent = best_of(3, lambda m=mapper, f=frames: m(f)) / len(frames)
                few = slice(options.peer)
                theirs, answers = peer(mapper, frames[few], mapper(frames[few]))
                apart = np.abs(answers - found.pressure[few]).max() / found.pressure.max()
                error, off = errors(found, touch), np.rad2deg(found.angle) - degrees
                rows.append(
                    [
                        f"{rule}, shear {shear}, {degrees} deg",
                        f"{np.sqrt((error**2).mean()):.4f}",
                        f"{np.quantile(error, 0.95):.4f}",
                        f"{100 * np.abs(found.normal_force / np.cos(np.deg2rad(degrees)) - 1).mean():.2f}",
                        f"{np.sqrt((off**2).mean()):.3f}" if shear != "none" else "",
                        f"{(found.status == ss.Status.OK).mean():.1%}",
                        f"{1e6 * spent:.0f}",
                        f"{1e6 * theirs:.0f}",
                        f"{apart:.0e}",
                    ]
                )
    return rows


def sweep(options: object) -> list[list[str]]:
    """Errors over noise, pitch and half width, the row 6 depths long."""
    rows = []
    count = max(options.frames // 10, 50)
    for noise in (1e-4, 1e-3, 1e-2):
        for pitch in (0.25, 0.5, 1.0):
            tip = finger(round(6 / pitch) + 1, pitch, noise)
            mapper = ss.estimate.PressureMapper(tip)
            cells = []
            for half_width in (0.25, 0.5, 1.0, 2.0):
                touch = touches(count, half_width, 30)
                found = mapper(tip.read(touch, np.random.default_rng(2)))
                there = np.isfinite(found.normal_force)
                cells.append(f"{np.sqrt((errors(found, touch)[there] ** 2).mean()):.3f}")
                if half_width == 1.0:
                    middle = len(found.y) // 2
                    width = float(np.nanmedian(found.resolution[:, middle]))
            rows.append([f"{noise:.2%}, {pitch}", *cells, f"{width:.2f}"])
    return rows


def main() -> None:
    """Run and print."""
    options = arguments(__doc__, frames=2000, peer=100)
    columns = [
        "rule", "rms error", "95 %", "force off %", "angle off deg", "OK", "us a frame", "nnls us", "apart",
    ]  # fmt: skip
    title = f"Pressure of a Hertz contact, half width 1, 25 sensors 0.25 apart, noise 0.1 %, {options.frames} frames"
    show(title, columns, target(options), options.json)
    columns = ["noise, pitch", *(f"half width {w}" for w in (0.25, 0.5, 1.0, 2.0)), "resolution"]
    show(
        "rms error over noise, pitch and half width in depths; drag 30 degrees, row of 6",
        columns,
        sweep(options),
        options.json,
    )


if __name__ == "__main__":
    main()
