"""Which pads hold: lifts in simulation with fingers of other sensors, depths, pitches and counts.

    python benchmarks/study_grasp_fingers.py [--count 24] [--seed 0] [--json FILE]

Each finger is a pad of 16 x 16 mm, E = 1 MPa, two of them on the gripper of `subskin grasp`, with the same things,
shaken and filled as there. Noise: 2e-4 of a strain, 2 um of a displacement, 20 Pa of a pressure.
"""

from __future__ import annotations

from concurrent.futures import ProcessPoolExecutor
from functools import partial

import numpy as np

import subskin as ss
from _common import arguments, show
from subskin.grasp import lifts, summary, things
from subskin.transducer import Displacement

SKIN = ss.HalfSpace(ss.Material(young=1e6))
STRAIN, MAGNETS = (ss.NormalStrain(),), tuple(Displacement(axis) for axis in ("x", "y", "z"))
ROSETTE = (ss.NormalStrain(), ss.ShearStrain("xy"), ss.ShearStrain("xz"))
BAROMETER = (ss.MeanPressure(),)
NOISE = {ss.NormalStrain: 2e-4, ss.ShearStrain: 2e-4, Displacement: 2e-6, ss.MeanPressure: 20.0}
FINGERS = {
    "magnets, 4 x 4, 5 mm apart, 2.5 mm deep": (MAGNETS, 4, 5e-3, 2.5e-3),
    "the same, 1.5 mm deep": (MAGNETS, 4, 5e-3, 1.5e-3),
    "the same, 4 mm deep": (MAGNETS, 4, 5e-3, 4e-3),
    "magnets, 3 x 3, 6 mm apart": (MAGNETS, 3, 6e-3, 2.5e-3),
    "magnets, 2 x 2, 8 mm apart": (MAGNETS, 2, 8e-3, 2.5e-3),
    "magnets, 6 x 6, 3 mm apart": (MAGNETS, 6, 3e-3, 2.5e-3),
    "strain along 3 axes, 4 x 4, 5 mm apart": (ROSETTE, 4, 5e-3, 2.5e-3),
    "normal strain, 4 x 4, 5 mm apart": (STRAIN, 4, 5e-3, 2.5e-3),
    "normal strain, 8 x 8, 2.3 mm apart": (STRAIN, 8, 2.3e-3, 2.5e-3),
    "barometers, 4 x 4, 5 mm apart": (BAROMETER, 4, 5e-3, 2.5e-3),
}


def finger(kinds: tuple, count: int, pitch: float, depth: float) -> ss.Finger:
    """A grid of sensors, all kinds at each position."""
    at = (np.arange(count) - (count - 1) / 2) * pitch
    y, z = (np.repeat(each.ravel(), len(kinds)) for each in np.meshgrid(at, at, indexing="ij"))
    noise = np.tile([NOISE[type(kind)] for kind in kinds], count**2)
    return ss.Finger(SKIN, ss.SensorArray(y=y, z=z, depth=depth, noise=noise, transducer=kinds * count**2))


def main() -> None:
    """Lift with each, two at a time."""
    options = arguments(__doc__, count=24, seed=0)
    todo = things(options.count, options.seed)
    with ProcessPoolExecutor(2) as pool:
        found = list(pool.map(partial(one, todo), FINGERS.values()))
    rows = [
        [
            name,
            str(came["dropped"]),
            *(f"{value:.2f}" for value in (100 * came["slid_2mm"], came["grip"], came["friction"])),
        ]
        for name, came in zip(FINGERS, found, strict=True)
    ]
    heads = ["pads", "dropped", "slid <= 2 mm [%]", "grip / least", "friction learnt / true"]
    show(f"{options.count} lifts", heads, rows, options.json)


def one(todo: list, design: tuple) -> dict:
    """What came of all lifts with one finger."""
    return dict(summary(lifts(todo, "skin", finger(*design))))


if __name__ == "__main__":
    main()
