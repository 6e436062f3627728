"""How often `locate(touches=2)` finds the number of touches on an area, and how often it is wrong.

    python benchmarks/study_touches.py [--frames 600]

Strain sensors 3 mm deep, one depth apart. One touch of .5 to 1.5 N, or two at least a depth apart of which the weaker
has half to all of the other's force, all within the sensors' rectangle, lean by up to .4. Noise is a share of the
strain that a newton makes above a sensor. A frame is wrong that is OK and has another number of touches, or one of them
off by more than five of its own standard deviations or .3 depths. With tolerances each frame is of a finger drawn anew.
"""

from __future__ import annotations

import argparse
import time

import numpy as np

import subskin as ss
from _common import show
from study_tolerances import DEPTH, Bench

TOLD = {"gain": 0.02, "depth": 0.05, "position": 0.05, "poisson": 0.05}


def drawn(bench: Bench, rng: np.random.Generator, frames: int, touches: int) -> tuple[np.ndarray, np.ndarray]:
    """Positions (f, touches, 2) and components (f, touches, 3)."""
    at = rng.uniform(-bench.half, bench.half, (20 * frames, touches, 2))
    if touches == 2:
        at = at[np.linalg.norm(at[:, 0] - at[:, 1], axis=-1) >= DEPTH]
    at, strength = at[:frames], rng.uniform(0.5, 1.5, (frames, 1))
    normal = np.concatenate([strength, strength * rng.uniform(0.5, 1.0, (frames, 1))], axis=-1)[:, :touches]
    lean, turn = rng.uniform(0, 0.4, normal.shape), rng.uniform(-np.pi, np.pi, normal.shape)
    return at, normal[..., None] * np.stack([np.ones_like(lean), lean * np.cos(turn), lean * np.sin(turn)], axis=-1)


def counted(found: ss.estimate.TouchSet, at: np.ndarray) -> tuple[float, float, float, float]:
    """Shares of frames: right number, OK, wrong; and of the OK ones' intervals of positions that hold."""
    touches = at.shape[1]
    place, std = found.each.position[:, :touches], found.each.std[:, :touches, :2]
    swap = np.linalg.norm(place - at[:, ::-1], axis=-1).max(axis=-1) < np.linalg.norm(place - at, axis=-1).max(axis=-1)
    off = np.abs(place - np.where(swap[:, None, None], at[:, ::-1], at))
    right = found.count == touches
    bad = (off > 5 * std).any(axis=(1, 2)) | (np.linalg.norm(off, axis=-1) > 0.3 * DEPTH).any(axis=-1)
    good = found.ok & right
    holds = (off < 1.96 * std)[good].mean() if good.any() else np.nan
    return right.mean(), found.ok.mean(), (found.ok & (~right | bad)).mean(), float(holds)


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--frames", type=int, default=600)
    frames, rows = parser.parse_args().frames, []
    for side in (4, 8):
        bench = Bench.grid(side)
        peak = bench.peak
        for share in (1e-3, 1e-2):
            array = ss.SensorArray.grid((side, side), DEPTH, DEPTH, noise=share * peak)
            for name, told in (("exact", None), ("told", ss.Tolerances(**TOLD, offset=0.01 * peak))):
                rng = np.random.default_rng(1)
                finger = ss.Finger(bench.finger.skin, array, tolerances=told)
                for touches in (1, 2):
                    at, force = drawn(bench, rng, frames, touches)
                    readings = rng.normal(0, share * peak, (frames, len(array)))
                    for f in range(frames):
                        made = finger if told is None else ss.Finger(*told.draw(finger.skin, array, rng))
                        offset = np.asarray(made.array.offset)
                        pressed = ss.PointLoad(position=at[f], components=force[f])
                        readings[f] += (made.read(pressed) - offset).sum(axis=0) + offset
                    finger.locate(readings[:20], touches=2)
                    begin = time.perf_counter()
                    found = finger.locate(readings, touches=2)
                    spent = 1e3 * (time.perf_counter() - begin) / frames
                    right, ok, wrong, holds = counted(found, at)
                    rows.append(
                        [f"{side} x {side}", f"{share:.1%}", name, str(touches), f"{right:.1%}", f"{ok:.1%}",
                         f"{wrong:.2%}", "none" if np.isnan(holds) else f"{holds:.1%}", f"{spent:.1f}"]
                    )  # fmt: skip
    columns = ["sensors", "noise", "finger", "touches", "number right", "OK", "wrong", "95 % holds", "ms a frame"]
    show("One touch or two", columns, rows)


if __name__ == "__main__":
    main()
