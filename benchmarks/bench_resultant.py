"""The resultant of ten sorts of pressure, beside the pressure image's: how near, how sure, how fast.

    python benchmarks/bench_resultant.py [--count 100] [--images 10] [--json FILE]

Strain gauges 2.5 mm deep in a half space, 4 mm apart on 4 x 4 and 3 mm on 8 x 8, E = 0.4 MPa, noise 2e-4. Each pressure
has 4 N, a half size of 0.4 to 2.4 depths, its middle anywhere between the sensors, and a drag of up to half of its
force. None of the sorts is drawn as `estimate/resultants/pressures.py` draws. Forces are those of the pressures' nodes,
a fifth of a depth apart. `--images`: how many of each sort the pressure image answers too.

Pads are squares of half side 1 to 9 mm whose middles lie up to 3 mm from that of the 4 x 4 sensors; every other one
drags. Beside them stands the Cramer-Rao bound of one who knows that it is a rectangle.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from time import perf_counter

import numpy as np

import subskin as ss
from _common import arguments, show
from subskin.radial import tabulate_radial

SORTS = ("ball", "ellipse", "rectangle", "leaning", "punch", "ring", "two", "blobs", "corner", "waves")
DEPTH, NOISE, FORCE = 2.5e-3, 2e-4, 4.0
SKIN = ss.HalfSpace(ss.Material(young=0.4e6))


def finger(sensors: int, pitch: float) -> ss.Finger:
    """So many sensors a side, so far apart [m]."""
    return ss.Finger(SKIN, ss.SensorArray.grid((sensors, sensors), pitch, DEPTH, noise=NOISE))


def pressure(sort: str, u: np.ndarray, v: np.ndarray, size: float, rng: np.random.Generator) -> np.ndarray:
    """Of a sort, at distances (u, v) from its middle along its own axes."""
    aspect = np.exp(rng.uniform(-0.5, 0.5))
    r2, inside = (u**2 + v**2) / size**2, (np.abs(u * aspect) < size) & (np.abs(v / aspect) < size)

    def cap(y: float, z: float, radius: float) -> np.ndarray:
        return np.sqrt(np.maximum(1 - ((u - y) ** 2 + (v - z) ** 2) / radius**2, 0.0))

    if sort == "ball":
        return cap(0.0, 0.0, size)
    if sort == "ellipse":
        return np.sqrt(np.maximum(1 - (u * aspect / size) ** 2 - (v / aspect / size) ** 2, 0.0))
    if sort == "rectangle":
        return inside * 1.0
    if sort == "leaning":
        return inside * (1 + rng.uniform(0.3, 1.0) * u * aspect / size)
    if sort == "punch":
        return np.where(r2 < 0.97, 1 / np.sqrt(np.maximum(1 - r2, 0.03)), 0.0)
    if sort == "ring":
        return ((r2 < 1) & (r2 > rng.uniform(0.3, 0.7))) * 1.0
    if sort == "two":
        apart = rng.uniform(0.5, 1.0) * size
        return cap(apart, 0.0, size / 2) + rng.uniform(0.5, 1.5) * cap(-apart, 0.0, size / 2)
    if sort == "blobs":
        out = np.zeros_like(u)
        for _ in range(rng.integers(3, 7)):
            y, z = rng.normal(0.0, size / 2, 2)
            width = rng.uniform(0.2, 0.5) * size + 0.1 * DEPTH
            out += rng.uniform(0.3, 1.0) * np.exp(-((u - y) ** 2 + (v - z) ** 2) / (2 * width**2))
        return out
    if sort == "corner":
        return ((np.abs(u) < size) & (np.abs(v) < size) & ~((u > 0) & (v > 0))) * 1.0
    wave = np.zeros_like(u)
    for _ in range(10):
        k, turn = np.pi / size * rng.uniform(0.3, 2.0), rng.uniform(0.0, 2 * np.pi)
        wave += np.cos(k * (np.cos(turn) * u + np.sin(turn) * v) + rng.uniform(0.0, 2 * np.pi))
    return np.maximum(1 + wave / 3, 0.0) * np.maximum(1 - r2, 0.0)


def frames(
    tip: ss.Finger, sort: str, count: int, rng: np.random.Generator, fields: tuple[np.ndarray, np.ndarray]
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Readings (count, n), components (count, 3) and centres (count, 2) of one sort."""
    at, unit = fields
    middle = np.abs(tip.array.points).max()
    readings, loads, centres = [], [], []
    for _ in range(count):
        size = DEPTH * np.exp(rng.uniform(np.log(0.4), np.log(2.4)))
        y, z = at.T - rng.uniform(-middle, middle, 2)[:, None]
        turn = rng.uniform(0.0, np.pi)
        u, v = np.cos(turn) * y + np.sin(turn) * z, -np.sin(turn) * y + np.cos(turn) * z
        p = pressure(sort, u, v, size, rng)
        p = p if p.any() else np.exp(-(u**2 + v**2) / (0.1 * DEPTH) ** 2)
        p = p / p.sum()
        lean, azimuth = rng.uniform(0.0, 0.5), rng.uniform(0.0, 2 * np.pi)
        load = FORCE * np.array([1.0, lean * np.cos(azimuth), lean * np.sin(azimuth)])
        readings.append(np.einsum("m,mnc,c->n", p, unit, load) + NOISE * rng.standard_normal(unit.shape[1]))
        loads.append(load)
        centres.append(p @ at)
    return np.array(readings), np.array(loads), np.array(centres)


def errors(found: ss.Estimate, load: np.ndarray, centre: np.ndarray) -> list[str]:
    """Of frames that are OK: errors of N, T [% of N] and the centre [depths], what 95 % intervals hold, gross ones."""
    ok = found.status == ss.Status.OK
    deviation = np.sqrt(np.diagonal(found.load.covariance, axis1=-2, axis2=-1))
    off = np.concatenate([found.position - centre, found.components - load], axis=-1)
    if not ok.any():
        return ["0", *8 * ["-"]]
    z = np.abs(off / deviation)[ok]
    normal, drag = np.abs(off[ok, 2]) / FORCE, np.hypot(*off[ok, 3:].T) / FORCE
    return [
        f"{100 * ok.mean():.0f}",
        *(f"{100 * v:.1f}" for v in (np.median(normal), np.quantile(normal, 0.9), np.median(drag))),
        f"{np.median(np.hypot(*off[ok, :2].T)) / DEPTH:.3f}",
        *(f"{100 * (z[:, part] < 1.96).mean():.0f}" for part in (slice(2, 3), slice(3, 5), slice(0, 2))),
        f"{100 * (ok.sum() and (z[:, 2] > 4).sum()) / len(load):.1f}",
    ]


def image_errors(tip: ss.Finger, readings: np.ndarray, load: np.ndarray, centre: np.ndarray) -> list[str]:
    """As `errors`, of the pressure image."""
    found = ss.pressure_map(tip, readings)
    ok = found.status == ss.Status.OK
    off = np.abs(found.normal_force - load[:, 0])[ok]
    drag = np.hypot(*(found.tangential_force - load[:, 1:])[ok].T)
    away = found.centre - centre
    held = [off < 1.96 * found.normal_std[ok]]
    held.append(np.abs(found.tangential_force - load[:, 1:])[ok] < 1.96 * found.tangential_std[ok])
    held.append(np.abs(away)[ok] < 1.96 * found.centre_std[ok])
    return [
        f"{100 * ok.mean():.0f}",
        *(f"{100 * v / FORCE:.1f}" for v in (np.median(off), np.quantile(off, 0.9), np.median(drag))),
        f"{np.median(np.hypot(*away[ok].T)) / DEPTH:.3f}",
        *(f"{100 * part.mean():.0f}" for part in held),
        f"{100 * (off > 4 * found.normal_std[ok]).sum() / len(load):.1f}",
    ]


def bound(tip: ss.Finger, pads: ss.Patch, turns: bool = False) -> float:
    """The median over pads of the least standard deviation of N for one who knows that it is a rectangle [% of N].

    The turn is known too, unless it `turns`: then it may be any within a quarter of a full one.
    """
    out, count = [], 7 + turns
    for k in range(min(len(pads.components), 40)):
        at = np.concatenate([pads.components[k], pads.position[k], pads.half_widths[k], pads.turn[k : k + 1]])
        step = np.diag([1e-3] * 3 + [1e-6] * 4 + [1e-4])[:count]
        both = [
            tip.read(ss.Patch(components=x[:3], position=x[3:5], half_widths=x[5:7], turn=x[7])) / NOISE
            for x in np.concatenate([at + step, at - step])
        ]
        slopes = (np.array(both[:count]) - np.array(both[count:])).T / (2 * step.sum(axis=1))
        known = np.diag([0.0] * 7 + [48 / np.pi**2])[:count, :count]  # the bound of a square has an end
        out.append(np.sqrt(np.linalg.inv(slopes.T @ slopes + known)[0, 0]) / FORCE)
    return 100 * float(np.median(out))


def time_of(call: Callable[[], object], times: int = 400) -> float:
    """Median microseconds of a call."""
    spent = []
    for _ in range(9):
        start = perf_counter()
        for _ in range(times // 9 + 1):
            call()
        spent.append((perf_counter() - start) / (times // 9 + 1))
    return 1e6 * float(np.median(spent))


def main() -> None:
    """Print the tables."""
    told = arguments(__doc__, count=100, images=10)
    head = ["", "OK %", "N %", "N 90 %", "T %", "centre d", "N held", "T held", "centre held", "> 4 std %"]
    for sensors, pitch in ((4, 4e-3), (8, 3e-3)):
        tip, rng, rows = finger(sensors, pitch), np.random.default_rng(1), []
        half = np.abs(tip.array.points).max() + 4.5 * DEPTH
        line = np.arange(-half, half, 0.2 * DEPTH)
        at = np.stack(np.meshgrid(line, line, indexing="ij"), axis=-1).reshape(-1, 2)
        fields = at, tabulate_radial(tip, 4 * half)(at)
        every: list[tuple[np.ndarray, ...]] = [frames(tip, sort, told.count, rng, fields) for sort in SORTS]
        for sort, (readings, load, centre) in zip(SORTS, every, strict=True):
            rows.append([sort, *errors(tip.resultant(readings), load, centre)])
        readings, load, centre = (np.concatenate(parts) for parts in zip(*every, strict=True))
        rows.append(["all", *errors(tip.resultant(readings), load, centre)])
        some = [tuple(part[: told.images] for part in one) for one in every]
        few = [np.concatenate(parts) for parts in zip(*some, strict=True)]
        rows.append(["the same, fewer", *errors(tip.resultant(few[0]), *few[1:])])
        rows.append(["pressure image", *image_errors(tip, *few)])
        show(f"{sensors} x {sensors}", head, rows, told.json)
    tip, rng, rows = finger(4, 4e-3), np.random.default_rng(2), []
    for half in range(1, 10):
        dragging, azimuth = rng.uniform(0.0, 0.5, told.count), rng.uniform(0.0, 2 * np.pi, told.count)
        dragging[::2] = 0.0
        drags = [dragging * np.cos(azimuth), dragging * np.sin(azimuth)]
        load = FORCE * np.stack([np.ones(told.count), *drags], axis=-1)
        middle = rng.uniform(-3e-3, 3e-3, (told.count, 2))
        pads = ss.Patch(components=load, position=middle, half_widths=np.full((told.count, 2), half * 1e-3))
        readings = tip.read(pads, rng)
        signal = f"{np.median(np.abs(readings).max(axis=-1)) / NOISE:.0f}"
        rows.append([f"{half} mm", signal, f"{bound(tip, pads):.1f}", *errors(tip.resultant(readings), load, middle)])
    show("Pads on 4 x 4", ["half side", "signal/noise", "bound N %", *head[1:]], rows, told.json)
    rows = []
    friction = ss.decide.Friction.between(0.4, 0.8)
    for sensors, pitch in ((4, 4e-3), (8, 3e-3), (16, 2e-3)):
        tip = finger(sensors, pitch)
        touches = ss.Patch(
            force=np.full(30, FORCE), angle=np.full(30, 0.2), position=rng.uniform(-3e-3, 3e-3, (30, 2)),
            half_widths=rng.uniform(1e-3, 4e-3, (30, 2)),
        )  # fmt: skip
        readings = tip.read(touches, rng)
        start = perf_counter()
        reader = ss.estimate.ResultantReader(tip).warm_up()
        made, found = perf_counter() - start, [tip.resultant(r) for r in readings]
        ss.decide.slip(found[0], friction), ss.decide.least_force(found[0], friction)
        spent = [
            [time_of(partial(reader, r)) for r in readings],
            [time_of(partial(ss.decide.slip, f, friction)) for f in found],
            [time_of(partial(ss.decide.least_force, f, friction)) for f in found],
        ]
        image = ss.estimate.ImageMapper(tip)
        image(readings[0])
        spent.append([time_of(partial(image, r), 1) for r in readings[:3]])
        rows.append([f"{sensors} x {sensors}", *(f"{np.median(each):.0f}" for each in spent), f"{made:.1f}"])
    head = ["", "resultant", "slip", "least_force", "pressure image", "preparation [s]"]
    show("One frame, us", head, rows, told.json)


if __name__ == "__main__":
    main()
