"""A row of sensors and touches on a point: how often `locate` is OK and wrong with load="line", "point" and "either".

    python benchmarks/study_beside.py [--count 2000] [--seed 0] [--data FOLDER] [--json FILE]

Rows of barometers, and of strains along the depth, at unit depth, one depth apart, in a half space (nu = 1/2). Touches
of one strength lean within 40 degrees to all sides, drags across the row among them; noise is a share of the reading
beneath a normal load. OK and wrong: OK, and off by more than five standard errors or 0.3 depths. Rows of four once more
with touches that press straight down, and `friction=0`.

A second table is of real boards: FOLDER (../shared/data) holds recordings that do not ship with this package. Each
column of four barometers is calibrated by touches above it, spread evenly, and finds the other touches above it and
beside it. OK and wrong is there off by more than 2 mm or five standard errors. "line": calibrated and located as lines.
"either": both as usual. The third table counts what is neither: the mean of all that `finger.blind_spots` draws, two
touches, and rollers 0.8 to 2 depths wide. Last come times of a frame.
"""

from __future__ import annotations

import time
import warnings

import numpy as np

import subskin as ss
from _common import arguments, show
from study_coverage import COLUMNS, DATA, PSI, WATER

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
    where = np.stack([at, rng.uniform(*strip, count)], axis=-1)
    return tip.read(ss.PointLoad(1.0, angle, azimuth, where), rng), at


ASIDE = ((0.0, 0.6), (0.6, 2.1), (2.1, 4.1), (4.1, 8.0))
"""Millimetres beside the column."""
ON_COLUMN = 0.1
SPACE = ss.HalfSpace(ss.Material(young=0.4e6))


def column(folder, name: str) -> tuple:
    """Of touches (m,) how far beside the column [mm], where along it [m], readings (m, 4) [Pa]; the pitch [m]."""
    file, header, pitch = WATER[name[:2]]
    raw = np.genfromtxt(folder / "underwater" / file, delimiter=",", skip_header=header)
    readings = raw[:, 2:6] if name[-1] == "R" else raw[:, 9:5:-1]
    return np.abs(raw[:, 0] - COLUMNS[name]), raw[:, 1] * 1e-3, PSI * readings, pitch


def on_boards(folder) -> list[list[str]]:
    """Rows of the second table."""
    rows = []
    for name in COLUMNS:
        aside, along, readings, pitch = column(folder, name)
        above = np.flatnonzero(aside < ON_COLUMN)
        above = above[np.argsort(along[above], kind="stable")]
        drawn = ss.Finger(SPACE, ss.SensorArray.line(4, pitch, 5e-3, transducer=ss.NormalStrain(), noise=10.0))
        for every in (6, 4, 2):
            used = above[1::every]
            fit = ("gain", "lift", "depth", "origin", *(("position",) if len(used) > 12 else ()))
            for load in ("line", None):
                made = ss.calibrate(drawn, readings[used], along[used], fit=fit, load=load)
                found, truth = made.finger.locate(readings, load=load), made.on_finger(along)
                off = np.abs(found.position - truth)
                wrong = found.ok & ((off > 2e-3) | (off > 5 * found.std[:, 0]))
                ends = np.asarray(made.finger.array.y)
                free = np.ones(len(along), dtype=bool)
                free[used] = False
                inside = free & (ends.min() < truth) & (truth < ends.max())
                row = [name, str(len(used)), load or "either"]
                strips = [inside & (aside >= low) & (aside < high) for low, high in ASIDE]
                for strip in (*strips, free & ~inside):
                    row.append(f"{found.ok[strip].mean():.0%}, {wrong[strip].mean():.1%}")
                here = strips[0] & found.ok
                held = (off < 1.959964 * found.std[:, 0])[here].mean() if here.any() else np.nan
                rows.append([*row, "" if np.isnan(held) else f"{held:.0%}"])
                print(rows[-1], flush=True)
    return rows


def outside() -> list[list[str]]:
    """Rows of the third table: what is neither a line nor a point, at a signal of 300 noises, 400 touches of each."""
    rows = []
    for kind in KINDS:
        for sensors in (4, 6, 8):
            tip, row = finger(kind, sensors, 1e-3), [f"{kind}, {sensors}"]
            known = {load: tip.blind_spots(family=load, snr=300, count=400) for load in ("line", "either")}
            names = [spot.name for spot in known["either"].rows if spot.name != "line"]
            for spots in known.values():
                row.append(f"{np.mean([spots[name].wrong for name in names]):.1%}")
                row += [f"{spots[name].wrong:.1%}" for name in ("two", "wide_roller")]
            rows.append(row)
    return rows


def times() -> list[list[str]]:
    """Rows of the last table: six barometers, touches on a point within two depths of the row, then line loads."""
    rng, tip, rows = np.random.default_rng(0), finger("pressure", 6, 1e-2), []
    for strip in (None, (0.0, 2.0)):
        frames, _ = touches(tip, strip, np.deg2rad(40), 500, rng)
        for load in ("line", "point", "either"):
            tip.locator("either").warm_up()
            took = []
            for some in (frames[0], frames):
                each = []
                for _ in range(200 if some.ndim == 1 else 20):
                    start = time.perf_counter()
                    tip.locate(some, load=load)
                    each.append((time.perf_counter() - start) / len(np.atleast_2d(some)))
                took.append(f"{1e6 * np.median(each):.3g}")
            rows.append(["line loads" if strip is None else "points", load, *took])
    return rows


def main() -> None:
    """Run and print."""
    options = arguments(__doc__, count=2000, seed=0, data=DATA)
    if (options.data / "underwater").is_dir():
        warnings.simplefilter("ignore", ss.errors.ValidityWarning)
        head = ["column", "touches", "load", *(f"{low:g} to {high:g} mm: OK, wrong" for low, high in ASIDE)]
        head += ["beyond the ends: OK, wrong", "above it, in 95 %"]
        show("Columns of real boards", head, on_boards(options.data), options.json)
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
                    std = found.std[:, 0]
                    off = np.abs(found.position - at)
                    wrong = found.ok & ((off > 5 * std) | (off > 0.3))
                    held = (off < 1.959964 * std)[found.ok].mean() if found.ok.sum() >= 50 else np.nan
                    row += [f"{found.ok.mean():.1%}", f"{wrong.mean():.2%}", "" if np.isnan(held) else f"{held:.1%}"]
                row.append(f"{np.nanmean(found.point_probability):.2f}")
                rows.append(row)
                print(row, flush=True)
    head = [
        "sensors",
        *(f"{load}: {what}" for load in ("line", "either") for what in ("all", "two touches", "a roller")),
    ]
    show("OK and wrong of what is neither", head, outside(), options.json)
    head = ["touches", "load", "a frame by itself [us]", "in a batch [us]"]
    show("Time of a frame", head, times(), options.json)
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
