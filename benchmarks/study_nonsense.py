"""How often an estimate is OK and wrong when what pressed, or the finger, is not what the model says.

    python benchmarks/study_nonsense.py [--touches 1500] [--fits 150] [--loads 20000] [--json FILE]

Sensors of strain along the depth in a half plane of rubber (nu = 1/2), 0.75 depths apart; noise as a share of the
strain beneath a unit normal load; unit normal forces that lean up to 35 degrees, anywhere over the row where nothing
else is said. Each cell: share of frames OK / OK and the position off by more than five standard deviations / OK and off
by more than 0.3 depths / OK and the normal force off by more than 30 %, all in %. Of two touches the nearer counts,
and the sum of their forces. First `locate`, of an exact finger and of one with tolerances;
then `fit` of a roller (family "hertz"); then line loads beside the row at several forces. Positions are searched where
they are by default, 1.5 depths beyond the outermost sensors.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace

import numpy as np

import subskin as ss
from _common import FULL_SCALE, arguments, finger, show

PITCH, SENSORS, NOISE = 0.75, (4, 6, 8), (1e-3, 1e-2)
REACH = 8.0  # depths beside the row that are tabulated
LEAN = 0.6
NODES = np.cos(np.pi * (np.arange(24) + 0.5) / 24)  # of a flat punch, its edges included
RUBBER = ss.Material(1.0)
SKINS = {
    "bonded layer, 1.3 depths thick": ss.Layered(ss.Layer(RUBBER, 1.3)),
    "bonded layer, 2 depths": ss.Layered(ss.Layer(RUBBER, 2.0)),
    "stiff film of 0.2 depths on rubber": ss.Layered((ss.Layer(ss.Material(10.0), 0.2),), base=RUBBER),
    "round, radius 4 depths, core 2": ss.Round(RUBBER, 4.0, 2.0),
    "Poisson's ratio 0.4": ss.HalfPlane(ss.Material(1.0, 0.4)),
}


@dataclass
class Case:
    """A finger as its estimator knows it, and tables of readings on this skin and others."""

    tip: ss.Finger
    noise: float
    count: int
    rng: np.random.Generator

    def __post_init__(self) -> None:
        self.half = 0.5 * PITCH * (len(self.tip.array) - 1)
        self.angle = self.rng.uniform(-LEAN, LEAN, self.count)
        self.y = self.rng.uniform(-self.half, self.half, self.count)

    def read(self, y: np.ndarray, normal: object, tangential: object, tip: ss.Finger | None = None) -> np.ndarray:
        """Readings without noise of line loads at y (count,) or (count, k), these being added up."""
        table = (tip or self.tip).tabulate((-self.half - REACH, self.half + REACH))
        forces = np.stack(np.broadcast_arrays(normal, tangential, y)[:2], axis=-1)
        each = np.einsum("...nl,...l->...n", table(y), forces)
        return each.sum(axis=1) if np.ndim(y) == 2 else each

    def line(self, y: np.ndarray | None = None, tip: ss.Finger | None = None) -> np.ndarray:
        """Of a unit normal load."""
        return self.read(self.y if y is None else y, 1.0, np.tan(self.angle), tip)

    def spread(self, half: np.ndarray, nodes: np.ndarray, weights: np.ndarray) -> np.ndarray:
        """Of a contact as a sum of line loads."""
        weights = np.broadcast_to(weights, (self.count, nodes.size))
        return self.read(self.y[:, None] + half[:, None] * nodes, weights, weights * np.tan(self.angle)[:, None])

    def noisy(self, readings: np.ndarray, times: float = 1.0) -> np.ndarray:
        """With noise."""
        return readings + times * self.noise * FULL_SCALE * self.rng.standard_normal(readings.shape)

    def one(self) -> np.ndarray:
        """One sensor a frame, as a mask."""
        n = len(self.tip.array)
        return np.arange(n) == self.rng.integers(0, n, self.count)[:, None]


Row = tuple[str, Callable[[Case], tuple[np.ndarray, np.ndarray, float]], int]


def contacts() -> Iterator[Row]:
    """What pressed: name, readings with the true positions and the normal force, and `outliers`."""

    def two(case: Case, weak: bool) -> tuple[np.ndarray, np.ndarray, float]:
        apart = case.rng.uniform(0.5, 3.0, case.count)
        y = np.stack([case.y - 0.5 * apart, case.y + 0.5 * apart], axis=-1)
        force = np.stack([np.ones(case.count), case.rng.uniform(0.1, 0.4, case.count) if weak else case.y * 0 + 1], -1)
        return case.noisy(case.read(y, force, force * np.tan(case.angle)[:, None])), y, float(force.sum(1).mean())

    def beside(case: Case, low: float, high: float) -> tuple[np.ndarray, np.ndarray, float]:
        y = case.rng.choice([-1, 1], case.count) * (case.half + case.rng.uniform(low, high, case.count))
        return case.noisy(case.line(y)), y, 1.0

    def wide(case: Case, kind: str, low: float, high: float) -> tuple[np.ndarray, np.ndarray, float]:
        half = case.rng.uniform(low, high, case.count)
        weights = np.full(NODES.size, 1 / NODES.size)
        if kind == "roller":  # sqrt(1 - t^2) by Gauss's nodes for it
            weights = 2 / NODES.size * (1 - NODES**2)
        elif kind == "tilted":
            weights = weights * (1 + 2 * case.rng.uniform(-0.5, 0.5, case.count)[:, None] * NODES)
        return case.noisy(case.spread(half, NODES, weights)), case.y, 1.0

    def force(case: Case, normal: float, tangential: object) -> tuple[np.ndarray, np.ndarray, float]:
        return case.noisy(case.read(case.y, normal, tangential)), case.y, normal

    def sign(case: Case) -> np.ndarray:
        return case.rng.choice([-1.0, 1.0], case.count)

    yield "a line load (the model holds)", lambda c: (c.noisy(c.line()), c.y, 1.0), 0
    yield "two touches 0.5-3 apart", lambda c: two(c, False), 0
    yield "two touches, one of 0.1-0.4 of the other's force", lambda c: two(c, True), 0
    yield "a wide flat, half width 0.8-2", lambda c: wide(c, "flat", 0.8, 2.0), 0
    yield "a wide roller, half width 0.8-2", lambda c: wide(c, "roller", 0.8, 2.0), 0
    yield "a tilted flat, half width 0.5-1.5", lambda c: wide(c, "tilted", 0.5, 1.5), 0
    yield "shear alone", lambda c: force(c, 0.0, sign(c)), 0
    yield "shear beyond the cone, tan 1.2-3", lambda c: force(c, 1.0, sign(c) * c.rng.uniform(1.2, 3.0, c.count)), 0
    yield "a pull", lambda c: force(c, -1.0, np.tan(c.angle)), 0
    yield "a load 0.3-1.4 beyond the row", lambda c: beside(c, 0.3, 1.4), 0
    yield "a load 1.6-4 beyond the row", lambda c: beside(c, 1.6, 4.0), 0


def fingers() -> Iterator[Row]:
    """What is not as the finger says; as `contacts`."""

    def skin(case: Case, other: ss.Skin) -> tuple[np.ndarray, np.ndarray, float]:
        return case.noisy(case.line(tip=replace(case.tip, skin=other))), case.y, 1.0

    def displaced(case: Case) -> tuple[np.ndarray, np.ndarray, float]:
        readings = np.empty((case.count, len(case.tip.array)))
        for rows in np.array_split(np.arange(case.count), 12):
            off = 0.05 * case.rng.standard_normal((2, readings.shape[1]))
            array = replace(case.tip.array, y=case.tip.array.y + off[0], depth=case.tip.array.depth + off[1])
            part = replace(case.tip, array=array)
            readings[rows] = part.measure(ss.LineLoad(1 / np.cos(case.angle[rows]), case.angle[rows], case.y[rows]))
        return case.noisy(readings), case.y, 1.0

    def faulty(case: Case, fault: str) -> tuple[np.ndarray, np.ndarray, float]:
        readings, one = case.line(), case.one()
        bound = 0.35 * FULL_SCALE
        if fault == "gains":
            readings = readings * (1 + 0.1 * case.rng.standard_normal(readings.shape))
        elif fault == "nothing":
            readings[one] = 0.0
        elif fault == "earlier":
            readings[one] = case.rng.permutation(case.line(case.rng.permutation(case.y)))[one]
        elif fault == "weak":
            readings[one] *= 0.6
        elif fault == "drift":
            readings += 5 * case.noise * FULL_SCALE * case.rng.standard_normal(readings.shape)
        readings = case.noisy(readings, 3.0 if fault == "noise" else 1.0)
        if fault in ("known", "unknown"):
            readings = np.clip(readings, -bound, bound)
            if fault == "known":
                readings[np.abs(readings) >= bound] = np.nan
        return readings, case.y, 1.0

    for name, other in SKINS.items():
        yield f"skin: {name}", lambda c, other=other: skin(c, other), 0
    yield "sensors 5 % of a depth (sd) out of place", displaced, 0
    for name, fault in {
        "gains off by 10 % (sd)": "gains",
        "one sensor stuck at nothing": "nothing",
        "one sensor stuck at an earlier touch": "earlier",
        "one sensor at 0.6 of its gain": "weak",
        "saturated at 0.35 full scale, range known": "known",
        "saturated at 0.35 full scale, range not known": "unknown",
        "offsets drifted by 5 noises (sd)": "drift",
        "noise three times as large as said": "noise",
    }.items():
        yield name, lambda c, fault=fault: faulty(c, fault), 0
        if fault in ("nothing", "earlier"):
            yield f"  {name}, outliers=1", lambda c, fault=fault: faulty(c, fault), 1


def shares(found: ss.Estimate, y: np.ndarray, normal: float) -> list[float]:
    """OK, and OK while wrong in three ways, of all frames."""
    truth = y[:, None] if y.ndim == 1 else y
    off = np.abs(found.position[:, None] - truth).min(axis=1)
    ok = found.status == ss.Status.OK
    force = np.abs(found.components[:, 0] - normal) > 0.3 * abs(normal)
    return [float(np.mean(k)) for k in (ok, ok & (off > 5 * found.std[:, 0]), ok & (off > 0.3), ok & force)]


TOLD = ss.Tolerances(gain=0.02, depth=0.05, position=0.05, poisson=0.05, offset=0.01 * FULL_SCALE)


def table(count: int, family: str | None = None, told: ss.Tolerances | None = None) -> list[list[str]]:
    """A row for each wrong model, a cell for each finger; at the end the mean over wrong models; `locate`, or a fit."""
    rows, wrong = [], []
    for number, (name, make, outliers) in enumerate([*contacts(), *fingers()]):
        cells = []
        for sensors in SENSORS:
            for noise in NOISE:
                if outliers and sensors < 6:
                    cells.append(None)
                    continue
                case = Case(finger(sensors, PITCH, noise), noise, count, np.random.default_rng([number, sensors]))
                readings, y, normal = make(case)
                tip = replace(case.tip, tolerances=told)
                found = (
                    tip.fit(readings, family, outliers=outliers) if family else tip.locate(readings, outliers=outliers)
                )
                cells.append(shares(found, y, normal))
        rows.append([name, *("-" if c is None else "/".join(f"{100 * k:.2g}" for k in c) for c in cells)])
        if number and not outliers:
            wrong.append(cells)
    mean = np.array(wrong).mean(axis=0)
    return [*rows, ["mean of the wrong models", *("/".join(f"{100 * k:.2g}" for k in c) for c in mean)]]


def beside(loads: int) -> list[list[str]]:
    """Line loads beside the row and over it, at several forces: OK, and OK while off by 5 deviations or 0.3 depths."""
    rows = []
    for name, low, high in (("1.6-4 beyond", 1.6, 4.0), ("4-8 beyond", 4.0, 8.0), ("0.3-1.4 beyond", 0.3, 1.4)):
        for force in (0.3, 1.0, 4.0, 16.0):
            row = [f"{name}, force {force:g}"]
            for sensors in SENSORS:
                for noise in NOISE:
                    case = Case(finger(sensors, PITCH, noise), noise, loads, np.random.default_rng(sensors))
                    side = case.rng.choice([-1, 1], loads)
                    y = side * (case.half + case.rng.uniform(low, high - 1e-9, loads))
                    found = case.tip.locate(case.noisy(force * case.line(y)))
                    ok, off = found.status == ss.Status.OK, np.abs(found.position - y)
                    wrong = ok & ((off > 5 * found.std[:, 0]) | (off > 0.3))
                    row.append(f"{100 * ok.mean():.3g} / {100 * wrong.mean():.3f}")
            rows.append(row)
    return rows


def main() -> None:
    """Run and print."""
    options = arguments(__doc__, touches=1500, fits=150, loads=20000)
    columns = [f"{sensors} at {100 * noise:g} %" for sensors in SENSORS for noise in NOISE]
    head = "OK / 5 deviations / 0.3 depths / force, %"
    show(f"locate: {head}", ["readings from", *columns], table(options.touches), options.json)
    show(
        f"locate with tolerances: {head}", ["readings from", *columns], table(options.touches, told=TOLD), options.json
    )
    show(f'fit "hertz": {head}', ["readings from", *columns], table(options.fits, "hertz"), options.json)
    columns = ["line loads [depths]", *columns]
    show("locate beside the row: OK / OK and wrong, %", columns, beside(options.loads), options.json)


if __name__ == "__main__":
    main()
