"""A row of sensors and touches on a point: how often `locate` is OK and wrong with load="line", "point" and "either".

    python benchmarks/study_beside.py [--count 2000] [--seed 0] [--json FILE]

Rows of barometers, and of strains along the depth, at unit depth, one depth apart, in a half space (nu = 1/2). Touches
of one strength lean within 40 degrees to all sides, drags across the row among them; noise is a share of the reading
beneath a normal load. OK and wrong: OK, and off by more than five standard errors or 0.3 depths. Rows of four once more
with touches that press straight down, and `friction=0`.
"""

from __future__ import annotations

import numpy as np

import subskin as ss
from _common import arguments, show

KINDS = {"pressure": (ss.MeanPressure(), 1 / (2 * np.pi)), "strain": (ss.NormalStrain(), 3 / (2 * np.pi))}
STRIPS = ((0.0, 0.3), (0.3, 1.0), (1.0, 2.0), (2.0, 3.0), (3.0, 6.0))


def finger(kind: str, sensors: int, noise: float) -> ss.Finger:
    """A row of sensors."""
    transducer, full_scale = KINDS[kind]
    array = ss.SensorArray.line(sensors, 1.0, 1.0, transducer=transducer, noise=noise * full_scale)
    return ss.Finger(ss.HalfSpace(ss.Material(young=1.0)), array)


def touches(
    tip: ss.Finger, strip: tuple[float, float] | None, most: float, count: int, rng: np.random.Generator
) -> tuple:
    """Readings and positions y of touches on a point, z in `strip` depths, or of line loads; `most` they lean by."""
    y = np.asarray(tip.array.y)
    at, angle = rng.uniform(y.min(), y.max(), count), rng.uniform(0, most, count)
    azimuth = rng.uniform(-np.pi, np.pi, count)
    if strip is None:
        return tip.read(ss.LineLoad(1.0, angle * np.sign(azimuth), at), rng), at
    place = np.stack([at, rng.uniform(*strip, count)], axis=-1)
    return tip.read(ss.PointLoad(1.0, angle, azimuth, place), rng), at


def main() -> None:
    """Run and print."""
    options = arguments(__doc__, count=2000, seed=0)
    rows = []
    cases = [(kind, sensors, 1.0) for kind in KINDS for sensors in (4, 6, 8)] + [(kind, 4, 0.0) for kind in KINDS]
    for kind, sensors, friction in cases:
        for noise in (1e-3, 1e-2):
            tip = finger(kind, sensors, noise)
            rng = np.random.default_rng(options.seed)
            for strip in (None, *STRIPS):
                frames, at = touches(tip, strip, np.deg2rad(40) * friction, options.count, rng)
                straight = "" if friction else ", straight"
                row = [
                    f"{kind}, {sensors}, {noise:.1%}{straight}",
                    "line" if strip is None else f"{strip[0]:g} to {strip[1]:g}",
                ]
                for load in ("line", "point", "either"):
                    found = tip.locate(frames, load=load, friction=friction)
                    std = found.position_std if load == "either" else np.sqrt(found.load.covariance[:, 0, 0])
                    off = np.abs(found.position - at)
                    wrong = found.ok & ((off > 5 * std) | (off > 0.3))
                    held = (off < 1.959964 * std)[found.ok].mean() if found.ok.sum() >= 50 else np.nan
                    row += [f"{found.ok.mean():.1%}", f"{wrong.mean():.2%}", "" if np.isnan(held) else f"{held:.1%}"]
                row.append(f"{np.nanmean(found.point_probability):.2f}")
                rows.append(row)
                print(row, flush=True)
    columns = ["touch, depths beside"]
    columns += [f"{load}: {what}" for load in ("line", "point", "either") for what in ("OK", "OK and wrong", "in 95 %")]
    show(
        f"A row and touches on a point, {options.count} touches a line",
        ["sensors, noise", *columns, "probability of a point"],
        rows,
        options.json,
    )


if __name__ == "__main__":
    main()
