"""How often `locate` answers, and how often it is wrong, where the finger is not its drawing, or the touch has a size.

    python benchmarks/study_tolerances.py [--grid 4 | --row 8 | --tips 8 [--beside 0.5]] [--fingers 40]

Strain sensors 3 mm deep: a grid one depth apart and point loads of .5 to 1.5 N, leaning by up to .4, within the
sensors' rectangle; or a row .75 depths apart and line loads of 20 to 60 N/m; or such a row on a half space, and point
loads so many depths beside it. Each finger is drawn at random from its
tolerances and reads 120 touches; then one finger as drawn reads contacts of balls, or rollers. A frame is wrong that is
OK and off by more than five of its own standard deviations or .3 depths. Noise and offsets are shares of the strain
that a normal touch of mean strength makes above a sensor.
"""

from __future__ import annotations

import argparse
import time
from dataclasses import dataclass, replace

import numpy as np

import subskin as ss
from _common import show

DEPTH = 3e-3
RUBBER = ss.Material(young=0.4e6)


@dataclass(frozen=True)
class Bench:
    """Sensors without noise, and what presses them."""

    finger: ss.Finger
    half: float
    beside: float | None = None

    @classmethod
    def grid(cls, side: int) -> Bench:
        """A square of so many sensors a side."""
        array = ss.SensorArray.grid((side, side), DEPTH, DEPTH)
        return cls(ss.Finger(ss.HalfSpace(RUBBER), array), 0.5 * (side - 1) * DEPTH)

    @classmethod
    def row(cls, count: int) -> Bench:
        """A row of so many sensors."""
        array = ss.SensorArray.line(count, 0.75 * DEPTH, DEPTH)
        return cls(ss.Finger(ss.HalfPlane(RUBBER), array), 0.375 * (count - 1) * DEPTH)

    @classmethod
    def tips(cls, count: int, beside: float) -> Bench:
        """A row of so many sensors on a half space, pressed by tips."""
        array = ss.SensorArray.line(count, 0.75 * DEPTH, DEPTH)
        return cls(ss.Finger(ss.HalfSpace(RUBBER), array), 0.375 * (count - 1) * DEPTH, beside * DEPTH)

    @property
    def peak(self) -> float:
        """The strain that a touch of mean strength makes."""
        array = self.finger.array
        above = array.points[len(array) // 2] if array.on_area else array.y[len(array) // 2]
        touch: ss.Contact = ss.LineLoad(force=40.0, position=above)
        if array.on_area or self.beside is not None:
            touch = ss.PointLoad(force=1.0, position=array.points[len(array) // 2])
        return float(np.abs(self.finger.read(touch)).max())

    def touches(self, rng: np.random.Generator, count: int, half_width: float = 0.0) -> tuple[ss.Contact, np.ndarray]:
        """Touches, and position and components of each."""
        strength = rng.uniform(0.5, 1.5, count)
        size = {"half_width": half_width} if half_width else {}
        if self.finger.array.on_area:
            drag, turn = strength * rng.uniform(0, 0.4, count), rng.uniform(-np.pi, np.pi, count)
            forces = np.stack([strength, drag * np.cos(turn), drag * np.sin(turn)], axis=-1)
            position = rng.uniform(-self.half, self.half, (count, 2))
            kind = ss.RoundHertz if half_width else ss.PointLoad
            return kind(position=position, components=forces, **size), np.concatenate([position, forces], axis=-1)
        if self.beside is not None:
            y = rng.uniform(-self.half, self.half, count)
            forces = strength[:, None] * np.stack([np.ones(count), rng.uniform(-0.4, 0.4, count), np.zeros(count)], -1)
            position = np.stack([y, np.full(count, self.beside)], axis=-1)
            kind = ss.RoundHertz if half_width else ss.PointLoad
            return kind(position=position, components=forces, **size), np.concatenate([y[:, None], forces[:, :2]], -1)
        angle, y = rng.uniform(-0.4, 0.4, count), rng.uniform(-self.half, self.half, count)
        kind = ss.Hertz if half_width else ss.LineLoad
        forces = 40.0 * strength * np.stack([np.cos(angle), np.sin(angle)])
        return kind(force=40.0 * strength, angle=angle, position=y, **size), np.stack([y, *forces], axis=-1)


def counted(found: ss.Estimate | ss.estimate.Either, true: np.ndarray) -> np.ndarray:
    """Of each frame: OK, wrong, and of the OK ones how many intervals of position and of N hold; of either, force."""
    if isinstance(found, ss.estimate.Either):
        off, std = np.abs(found.position - true[:, 0]), found.std
        wrong = found.ok & ((off > 5 * std[:, 0]) | (off > 0.3 * DEPTH))
        point = found.ok & (found.likeliest > 0)
        force = np.abs(found.force - np.hypot(true[:, 1], true[:, 2])) < 1.96 * std[:, 1]
        holds = np.where(found.ok, off < 1.96 * std[:, 0], np.nan)
        return np.stack([found.ok, wrong, holds, np.where(point, force, np.nan)])
    forces = found.load.components.shape[-1]
    k = true.shape[-1] - forces
    off = np.abs(found.position.reshape(len(true), -1) - true[:, :k])
    std = np.sqrt(np.diagonal(found.load.covariance, axis1=-2, axis2=-1))
    wrong = found.ok & ((off > 5 * std[:, :k]).any(axis=-1) | (np.linalg.norm(off, axis=-1) > 0.3 * DEPTH))
    normal = np.abs(found.load.components[:, 0] - true[:, k]) < 1.96 * std[:, k]
    holds = (off < 1.96 * std[:, :k]).mean(axis=-1)
    return np.stack([found.ok, wrong, np.where(found.ok, holds, np.nan), np.where(found.ok, normal, np.nan)])


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--grid", type=int, default=4)
    parser.add_argument("--row", type=int, default=0)
    parser.add_argument("--tips", type=int, default=0)
    parser.add_argument("--beside", type=float, default=0.0)
    parser.add_argument("--fingers", type=int, default=40)
    given = parser.parse_args()
    bench = Bench.row(given.row) if given.row else Bench.grid(given.grid)
    if given.tips:
        bench = Bench.tips(given.tips, given.beside)
    peak, rows = bench.peak, []
    for share in (1e-3, 1e-2):
        rng = np.random.default_rng(1)
        finger = replace(bench.finger, array=replace(bench.finger.array, noise=share * peak))
        all_ = ss.Tolerances(gain=0.02, depth=0.05, position=0.05, poisson=0.05, offset=0.01 * peak)
        cases = {
            "gains 2 %": ss.Tolerances(gain=0.02),
            "depths 5 %": ss.Tolerances(depth=0.05),
            "positions 5 % of a depth": ss.Tolerances(position=0.05),
            "Poisson's ratio .05": ss.Tolerances(poisson=0.05),
            "offsets 1 %": ss.Tolerances(offset=0.01 * peak),
            "all of these": all_,
        }
        for name, told in cases.items():
            parts: dict[str, list[np.ndarray]] = {"exact": [], "told": []}
            for _ in range(given.fingers):
                touch, true = bench.touches(rng, 120)
                readings = ss.Finger(*told.draw(finger.skin, finger.array, rng)).read(touch, rng)
                parts["exact"].append(counted(finger.locate(readings), true))
                parts["told"].append(counted(replace(finger, tolerances=told).locate(readings), true))
            rows.append([f"{share:.1%}", name, *_shown(parts)])
        for size in (0.3, 0.5, 1.0):
            touch, true = bench.touches(rng, 120 * given.fingers, size * DEPTH)
            readings = finger.read(touch, rng)
            for name, told in (("nothing", ss.Tolerances()), ("all of these", all_)):
                parts = {
                    "exact": [counted(finger.locate(readings), true)],
                    "told": [counted(replace(finger, tolerances=told).locate(readings), true)],
                }
                rows.append([f"{share:.1%}", f"half width {size:g} depths, told {name}", *_shown(parts)])
        touch, _ = bench.touches(rng, 2000)
        readings = finger.read(touch, rng)
        for name, told in (("size alone", ss.Tolerances()), ("all", all_)):
            times: list[list[float]] = [[], []]
            for k in range(8):
                each = (finger, replace(finger, tolerances=told))[k % 2]
                each.locate(readings)
                begin = time.perf_counter()
                each.locate(readings)
                times[k % 2].append(1e6 * (time.perf_counter() - begin) / len(readings))
            rows.append([f"{share:.1%}", f"us a frame, told {name}", *(f"{np.median(one):.1f}" for one in times)])
    show(
        "A finger that is not its drawing",
        ["noise", "what is off", "exact: OK, wrong, holds y, N", "told: OK, wrong, holds y, N"],
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
