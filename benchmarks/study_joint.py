"""How often joint 95 % regions hold the truth where few sensors feel a touch, or sensors lie far apart.

    [PYTHONPATH=../before/src] python benchmarks/study_joint.py [--count 6000] [--seed 0] [--json FILE]

Strains along the depth, and barometers, at unit depth; noise is a share of the largest reading beneath a unit load.
Touches lean within 35 degrees, 0.5 to 1.5 units of force, anywhere over the sensors. Cells: OK frames, and the share of
these whose joint region of position and force holds the truth; the least and the largest share of the intervals; time
of a frame of them all. `../before`, a checkout of 53d4d737, takes the curvature of chi-square at its top.
"""

from __future__ import annotations

import time

import numpy as np
from scipy.special import chdtri

import subskin as ss
from _common import arguments, show

KINDS = {"strain": ss.NormalStrain(), "pressure": ss.MeanPressure()}
RUBBER = ss.Material(young=1.0)
GRIDS, ROWS = ((2, 3), (3, 3), (4, 4)), ((4, 1.0), (4, 1.5), (6, 1.5))
NOISE = (1e-3, 1e-2, 3e-2)


def finger(kind: str, size: tuple, noise: float) -> ss.Finger:
    """A grid of these sensors one depth apart, or a row of so many at a pitch."""
    area, more = isinstance(size[1], int), {"transducer": KINDS[kind]}
    if area:
        tip = ss.Finger(ss.HalfSpace(RUBBER), ss.SensorArray.grid(size, 1.0, 1.0, noise=1.0, **more))
        full = np.abs(tip.read(ss.PointLoad(1.0, position=tuple(tip.array.points[0])))).max()
        array = ss.SensorArray.grid(size, 1.0, 1.0, noise=noise * full, **more)
    else:
        tip = ss.Finger(ss.HalfPlane(RUBBER), ss.SensorArray.line(*size, 1.0, noise=1.0, **more))
        full = np.abs(tip.read(ss.LineLoad(1.0, position=float(tip.array.y[1])))).max()
        array = ss.SensorArray.line(*size, 1.0, noise=noise * full, **more)
    return ss.Finger(tip.skin, array)


def held(tip: ss.Finger, count: int, rng: np.random.Generator) -> list[str]:
    """Cells of a finger."""
    points, force, angle = tip.array.points, rng.uniform(0.5, 1.5, count), rng.uniform(0, np.deg2rad(35), count)
    azimuth = rng.uniform(-np.pi, np.pi, count)
    if tip.array.on_area:
        at = rng.uniform(points.min(axis=0), points.max(axis=0), (count, 2))
        touch = ss.PointLoad(force, angle, azimuth, at)
        truth = np.concatenate([at, touch.components], axis=-1)
    else:
        at, angle = rng.uniform(points[:, 0].min(), points[:, 0].max(), count), angle * np.sign(azimuth)
        touch = ss.LineLoad(force, angle, at)
        truth = np.column_stack([at, force * np.cos(angle), force * np.sin(angle)])
    readings, took = tip.read(touch, rng), []
    for _ in range(6):  # of which the first prepares
        start = time.perf_counter()
        found = tip.locate(readings)
        took.append(1e6 * (time.perf_counter() - start) / count)
    ok, k = found.ok, truth.shape[1]
    answer = np.concatenate([np.reshape(found.position, (count, -1)), found.load.components], axis=-1)
    off, c = (truth - answer)[ok], found.load.covariance[ok]
    joint = np.einsum("fi,fij,fj->f", off, np.linalg.inv(c), off) < chdtri(k, 0.05)
    each = (np.abs(off) < 1.959964 * np.sqrt(np.diagonal(c, axis1=1, axis2=2))).mean(axis=0)
    return [f"{ok.mean():.0%}", f"{joint.mean():.1%}", f"{each.min():.1%} to {each.max():.1%}", f"{min(took):.2g}"]


def main() -> None:
    """Run and print."""
    options = arguments(__doc__, count=6000, seed=0)
    rows = []
    for kind in KINDS:
        for size in (*GRIDS, *ROWS):
            area = isinstance(size[1], int)
            for noise in NOISE[: 2 if area else 3]:
                named = f"{size[0]} x {size[1]}" if area else f"a row of {size[0]}, {size[1]:g} depths apart"
                tip = finger(kind, size, noise)
                rows.append(
                    [f"{kind}, {named}", f"{noise:.1%}", *held(tip, options.count, np.random.default_rng(options.seed))]
                )
    head = ["sensors", "noise", "OK", "joint region holds", "intervals hold", "a frame [us]"]
    show("Joint 95 % regions", head, rows, options.json)


if __name__ == "__main__":
    main()
