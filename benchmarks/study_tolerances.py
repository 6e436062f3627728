"""How often `locate` on an area answers, and how often it is wrong, where the finger is not its drawing.

    python benchmarks/study_tolerances.py [--side 4] [--fingers 40]

Pads of side x side strain sensors, 3 mm deep and apart, and point loads of .5 to 1.5 N within the sensors' rectangle,
leaning by up to .4. Each finger is drawn at random from its tolerances and reads 120 touches; then one finger as drawn
reads balls' contacts. A frame is wrong that is OK and off by more than five of its own standard deviations or .3
depths. Noise is a share of the reading that a newton makes.
"""

from __future__ import annotations

import argparse
import time
from dataclasses import replace

import numpy as np

import subskin as ss
from _common import show

DEPTH = 3e-3
SKIN = ss.HalfSpace(ss.Material(young=0.4e6))


def touches(rng: np.random.Generator, count: int, half: float) -> dict[str, np.ndarray]:
    """Positions and components of loads."""
    force, lean, turn = rng.uniform(0.5, 1.5, count), rng.uniform(0, 0.4, count), rng.uniform(-np.pi, np.pi, count)
    drag = force * lean
    components = np.stack([force, drag * np.cos(turn), drag * np.sin(turn)], axis=-1)
    return {"position": rng.uniform(-half, half, (count, 2)), "components": components}


def counted(found: ss.Estimate, touch: dict[str, np.ndarray]) -> np.ndarray:
    """Of each frame: OK, wrong, and of the OK ones how many intervals of position and of N hold."""
    off = np.abs(found.position - touch["position"])
    std = np.sqrt(np.diagonal(found.load.covariance, axis1=-2, axis2=-1))
    far = np.hypot(off[:, 0], off[:, 1])
    wrong = found.ok & ((off > 5 * std[:, :2]).any(axis=-1) | (far > 0.3 * DEPTH))
    normal = np.abs(found.load.components[:, 0] - touch["components"][:, 0]) < 1.96 * std[:, 2]
    holds = (off < 1.96 * std[:, :2]).mean(axis=-1)
    return np.stack([found.ok, wrong, np.where(found.ok, holds, np.nan), np.where(found.ok, normal, np.nan)])


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--side", type=int, default=4)
    parser.add_argument("--fingers", type=int, default=40)
    given = parser.parse_args()
    half = 0.5 * (given.side - 1) * DEPTH
    rows = []
    for share in (1e-3, 1e-2):
        rng = np.random.default_rng(1)
        plain = ss.Finger(SKIN, ss.SensorArray.grid((given.side, given.side), DEPTH, DEPTH))
        peak = float(np.abs(plain.read(ss.PointLoad(force=1.0, position=(0.5 * DEPTH, 0.5 * DEPTH)))).max())
        finger = replace(plain, array=replace(plain.array, noise=share * peak))
        all_ = ss.Tolerances(gain=0.02, depth=0.05, position=0.05, poisson=0.05, offset=0.01 * peak)
        cases = {
            "gains 2 %": ss.Tolerances(gain=0.02),
            "depths 5 %": ss.Tolerances(depth=0.05),
            "positions 5 % of a depth": ss.Tolerances(position=0.05),
            "Poisson's ratio .05": ss.Tolerances(poisson=0.05),
            "offsets 1 % of a newton's": ss.Tolerances(offset=0.01 * peak),
            "all of these": all_,
        }
        for name, told in cases.items():
            parts: dict[str, list[np.ndarray]] = {"exact": [], "told": []}
            for _ in range(given.fingers):
                touch = touches(rng, 120, half)
                readings = ss.Finger(*told.draw(finger.skin, finger.array, rng)).read(ss.PointLoad(**touch), rng)
                parts["exact"].append(counted(finger.locate(readings), touch))
                parts["told"].append(counted(replace(finger, tolerances=told).locate(readings), touch))
            rows.append([f"{share:.1%}", name, *_shown(parts)])
        for size in (0.3, 0.5, 1.0):
            touch = touches(rng, 120 * given.fingers, half)
            readings = finger.read(ss.RoundHertz(half_width=size * DEPTH, **touch), rng)
            for name, told in (("nothing", ss.Tolerances()), ("all of these", all_)):
                parts = {
                    "exact": [counted(finger.locate(readings), touch)],
                    "told": [counted(replace(finger, tolerances=told).locate(readings), touch)],
                }
                rows.append([f"{share:.1%}", f"ball of {size:g} depths, told {name}", *_shown(parts)])
        touch = touches(rng, 2000, half)
        readings = finger.read(ss.PointLoad(**touch), rng)
        both = finger, replace(finger, tolerances=all_)
        times = []
        for each in both * 4:
            each.locate(readings)
            begin = time.perf_counter()
            each.locate(readings)
            times.append(1e6 * (time.perf_counter() - begin) / len(readings))
        rows.append(
            [f"{share:.1%}", "us a frame, in a batch", f"{np.median(times[::2]):.1f}", f"{np.median(times[1::2]):.1f}"]
        )
    show(
        "A finger that is not its drawing",
        ["noise", "what is off", "exact: OK, wrong, holds y z, N", "told: OK, wrong, holds y z, N"],
        rows,
    )


def _shown(parts: dict[str, list[np.ndarray]]) -> list[str]:
    """The two columns of a row."""
    out = []
    for each in parts.values():
        ok, wrong, held, normal = np.concatenate(each, axis=1)
        holds = f"{np.nanmean(held):.3f}, {np.nanmean(normal):.3f}" if ok.any() else "-"
        out.append(f"{ok.mean():.3f}, {wrong.mean():.4f}, {holds}")
    return out


if __name__ == "__main__":
    main()
