"""How often `calibration.orient` finds which way round the sensors are connected, by one to three presses.

    python benchmarks/study_orient.py [--cases 100]

A row of 6 and 4 x 4 sensors of strain, 3 mm deep; sensors are 5 % of a depth and gains 2 % off their drawing, noise is
1 % of a newton's reading. Presses are off by up to half a depth along each axis from what was told, lean by up to .3,
and press as hard as they like; for the scale of the gains somebody tells the force to 20 %.
"""

from __future__ import annotations

import argparse
from dataclasses import replace

import numpy as np

import subskin as ss
from _common import show
from subskin.calibration import orient, telling

DEPTH = 3e-3


def fingers() -> dict[str, ss.Finger]:
    """Fingers as they are drawn, with noise."""
    row = ss.SensorArray.line(6, DEPTH, DEPTH)
    grid = ss.SensorArray.grid((4, 4), DEPTH, DEPTH)
    rubber = ss.Material(young=0.4e6)
    made = {"row of 6": ss.Finger(ss.HalfPlane(rubber), row), "4 x 4": ss.Finger(ss.HalfSpace(rubber), grid)}
    noise = {name: 0.01 * np.abs(f.read(one(f, np.zeros(2), 1.0))).max() for name, f in made.items()}
    return {name: replace(f, array=replace(f.array, noise=noise[name])) for name, f in made.items()}


def one(finger: ss.Finger, at: np.ndarray, strength: float, lean: float = 0.0, turn: float = 0.0) -> ss.Contact:
    """A press: of so many newtons on an area, 40 times as many a metre on a row."""
    if finger.array.on_area:
        return ss.PointLoad(force=strength, angle=lean, azimuth=turn, position=at)
    return ss.LineLoad(force=40.0 * strength, angle=lean, position=at[0])


def faults(finger: ss.Finger) -> dict[str, tuple[np.ndarray, float, float]]:
    """By name: which sensor each channel is read by, sign and scale of the gains."""
    n = len(finger.array)
    index, side = np.arange(n), round(n**0.5)
    found = {
        "as drawn": (index, 1.0, 1.0), "reversed": (index[::-1], 1.0, 1.0), "sign": (index, -1.0, 1.0),
        "gains doubled": (index, 1.0, 2.0),
    }  # fmt: skip
    swapped = index.copy()
    swapped[[0, 1]] = 1, 0
    found["first two swapped"] = (swapped, 1.0, 1.0)
    if finger.array.on_area:
        square = index.reshape(side, side)
        found |= {
            "y mirrored": (square[::-1].reshape(-1), 1.0, 1.0),
            "y and z swapped": (square.T.reshape(-1), 1.0, 1.0),
        }
    return found


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--cases", type=int, default=100)
    cases = parser.parse_args().cases
    told, rows = ss.Tolerances(gain=0.02, position=0.05), []
    for name, finger in fingers().items():
        array, rng = finger.array, np.random.default_rng(1)
        sites = telling(finger, 3)
        for fault, (order, sign, scale) in faults(finger).items():
            shares = []
            for presses in (1, 2, 3):
                right = sure = 0
                for _ in range(cases):
                    made = ss.Finger(*told.draw(finger.skin, array, rng))
                    near = np.array([array.points[i] for i in sites[:presses]])
                    read, forces = [], rng.uniform(0.5, 2.0, presses)
                    for at, force in zip(near, forces, strict=True):
                        off = rng.uniform(-0.5, 0.5, 2) * DEPTH * (1.0 if array.on_area else np.array([1.0, 0.0]))
                        press = one(finger, at + off, force, rng.uniform(0, 0.3), rng.uniform(-np.pi, np.pi))
                        read.append(sign * scale * made.read(press, rng)[order])
                    unit = 1.0 if array.on_area else 40.0
                    said = unit * forces * rng.uniform(0.8, 1.2, presses)
                    found = orient(finger, read, near if array.on_area else near[:, 0], force=said)
                    found_order = np.argsort(order)
                    good = (found.order == found_order).all() and found.sign == sign
                    right += good and abs(np.log(found.scale / scale)) < np.log(1.5)
                    sure += found.sure
                shares.append(f"{right} / {sure}")
            rows.append([name, fault, *shares])
    show(f"found, and sure, of {cases}", ["sensors", "connected", "one press", "two", "three"], rows)


if __name__ == "__main__":
    main()
