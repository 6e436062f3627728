"""The memo's last idea, judged: a point force on an area from two planar solutions at right angles.

    python benchmarks/study_two_planes.py [--count 500] [--seed 0] [--json FILE]

Grids of barometers at unit depth in a half space (nu = 1/2). Touches lean within 40 degrees to all sides, over the
middle half of the grid or over all of it; noise is 0.1 % of the reading beneath a normal load. Three ways to find them:

- one row, one column: the row and the column of the strongest sensor are each located as if a line load pressed; the
  row gives y and the drag along y, the column z and the drag along z. A line load's N/m become N by the one length that
  is right above the middle sensor.
- sums: readings summed over z, times the pitch, are those of a line load with the whole force, located along y; and the
  other way round. This is exact for a grid without end whose pitch goes to 0.
- in space: `finger.locate`.

Errors are medians: of the position in depths, of the normal force, of the direction of the force. The planar locators
are given a noise of 5 % of the full scale, so that they answer at all; the last column says how many touches they
refuse with the true noise.
"""

from __future__ import annotations

import numpy as np

import subskin as ss
from _common import arguments, show

FULL_SCALE = 1 / (2 * np.pi)
NOISE, LOOSE = 1e-3, 5e-2
MATERIAL = ss.Material(young=1.0)


def row(side: int, pitch: float, noise: float) -> ss.Finger:
    """A row of barometers in a half plane."""
    array = ss.SensorArray.line(side, pitch, 1.0, transducer=ss.MeanPressure(), noise=noise)
    return ss.Finger(ss.HalfPlane(MATERIAL), array)


def planar(frames: np.ndarray, side: int, pitch: float, noise: float, loose: float) -> tuple:
    """Position, components and whether it is refused, of frames of one row."""
    found = row(side, pitch, loose).locate(frames)
    refused = row(side, pitch, noise).locate(frames).status == ss.Status.UNEXPLAINED
    return found.position, found.load.components, refused


def errors(at: np.ndarray, force: np.ndarray, load: ss.PointLoad) -> list[str]:
    """Medians of position, normal force and direction, over what was answered."""
    known = np.isfinite(at).all(-1) & np.isfinite(force).all(-1)
    off = np.linalg.norm(at - load.position, axis=-1)[known]
    normal = np.abs(force[:, 0] / load.components[:, 0] - 1)[known]
    cosine = (
        (force * load.components).sum(-1) / np.linalg.norm(force, axis=-1) / np.linalg.norm(load.components, axis=-1)
    )
    turn = np.rad2deg(np.arccos(np.clip(cosine, -1, 1)))[known]
    return [f"{np.median(off):.4f}", f"{np.median(normal):.1%}", f"{np.median(turn):.1f}", f"{1 - known.mean():.1%}"]


def main() -> None:
    """Run and print."""
    options = arguments(__doc__, count=500, seed=0)
    rows = []
    for side, pitch in ((5, 1.0), (9, 0.5), (9, 1.0), (17, 0.5)):
        array = ss.SensorArray.grid((side, side), pitch, 1.0, transducer=ss.MeanPressure(), noise=NOISE * FULL_SCALE)
        tip = ss.Finger(ss.HalfSpace(MATERIAL), array)
        # the length that turns N/m into N: a normal load above the middle sensor
        middle = tip.read(ss.PointLoad(1.0)).reshape(side, side)[:, side // 2]
        length = 1 / float(planar(middle[None], side, pitch, 1.0, LOOSE * FULL_SCALE)[1][0, 0])
        for where, part in (("the middle half", 0.5), ("all of it", 1.0)):
            rng = np.random.default_rng(options.seed)
            half = 0.5 * (side - 1) * pitch * part
            angle, azimuth = rng.uniform(0, np.deg2rad(40), options.count), rng.uniform(-np.pi, np.pi, options.count)
            load = ss.PointLoad(1.0, angle, azimuth, rng.uniform(-half, half, (options.count, 2)))
            frames = tip.read(load, rng)
            square = frames.reshape(-1, side, side)  # y, z
            hot = np.abs(frames).argmax(axis=1)
            j, k = np.divmod(hot, side)
            each = np.arange(options.count)
            name = f"{side} x {side}, pitch {pitch:g}, {where}"
            ways = {
                "one row, one column": (square[each, :, k], square[each, j], length, NOISE * FULL_SCALE),
                "sums": (
                    square.sum(axis=2) * pitch,
                    square.sum(axis=1) * pitch,
                    1.0,
                    NOISE * FULL_SCALE * pitch * np.sqrt(side),
                ),
            }
            for way, (along, across, scale, noise) in ways.items():
                y, first, no = planar(along, side, pitch, noise, LOOSE * FULL_SCALE)
                z, second, also = planar(across, side, pitch, noise, LOOSE * FULL_SCALE)
                force = scale * np.stack([0.5 * (first[:, 0] + second[:, 0]), first[:, 1], second[:, 1]], axis=-1)
                found = errors(np.stack([y, z], axis=-1), force, load)
                rows.append([name, way, *found, f"{(no | also).mean():.0%}"])
                print(rows[-1], flush=True)
            answer = tip.locate(frames)
            refused = f"{(answer.status == ss.Status.UNEXPLAINED).mean():.0%}"
            rows.append([name, "in space", *errors(answer.position, answer.load.components, load), refused])
            print(rows[-1], flush=True)
    columns = [
        "grid and touches",
        "way",
        "position, depths",
        "normal force",
        "direction, degrees",
        "no answer",
        "refused",
    ]
    show(f"Two planar solutions at right angles, {options.count} touches", columns, rows, options.json)


if __name__ == "__main__":
    main()
