"""Calibrating without knowing the touches: what is left of errors in locating, beside what no method could better.

    python benchmarks/study_blind.py [--fingers 20] [--json FILE]

Real fingers differ from the drawing by 5 % (gains), 5 % (depth) and 2 % of the depth (each sensor's place), all of
them standard deviations. Touches are line loads anywhere over the row, of force 0.5 to 2, leaning within 40 degrees;
noise is 0.1 % of what a unit load reads straight above a sensor. On 2000 fresh touches, over those that are OK on
either finger: rms errors of angle and of place with the calibrated finger, over those with the finger known exactly.
Places up to a straight line, for a shift and on the half plane a scale are nowhere in the readings. `bound` is the same
ratio from the Fisher information at the real finger, by differences of the forward model alone, and `95 %` that of one
finger in twenty: on average over fingers no method that knows no more does better.

On an area touches are loads on a point anywhere over a grid of pressure sensors one depth apart, leaning within 34
degrees in any direction, or straight; fingers differ from the drawing by as much. Noise is 0.1 % of what a load of
1.25, their mean, reads straight above a sensor. "held" counts the 95 % intervals of all numbers of all fingers, and
chi2 is the Mahalanobis distance of the truth over the number of numbers: 95 and 1 where errors are stated well.
Positions of fresh touches are taken up to a shift, a turn and a scale, `told` is the ratio that the calibration itself
states.
"""

from __future__ import annotations

from dataclasses import replace
from time import perf_counter, process_time

import numpy as np

import subskin as ss
from _common import FULL_SCALE, arguments, show

GAIN, DEPTH, PLACE = 0.05, 0.05, 0.02
NOISE = 1e-3 * FULL_SCALE
FRESH = 2000
SKINS = {
    "half plane": ss.HalfPlane(ss.Material(1.0)),
    "layer of 2 d": ss.Layered(ss.Layer(ss.Material(1.0), 2.0)),
    "round, R = 6 d": ss.Round(ss.Material(1.0), 6.0, 4.0),
}


def fingers(skin: ss.Skin, sensors: int, pitch: float, rng: np.random.Generator) -> tuple[ss.Finger, ss.Finger]:
    """As drawn, and as made."""
    drawn = ss.SensorArray.line(sensors, pitch=pitch, depth=1.0, noise=NOISE)
    made = replace(
        drawn,
        y=np.asarray(drawn.y) + PLACE * rng.standard_normal(sensors),
        depth=1 + DEPTH * rng.standard_normal(),
        gain=np.exp(GAIN * rng.standard_normal(sensors)),
    )
    return ss.Finger(skin, drawn), ss.Finger(skin, made)


def touches(sensors: int, pitch: float, count: int, rng: np.random.Generator) -> ss.LineLoad:
    """Loads over the row."""
    half = 0.5 * (sensors - 1) * pitch
    lean = np.deg2rad(40)
    return ss.LineLoad(rng.uniform(0.5, 2, count), rng.uniform(-lean, lean, count), rng.uniform(-half, half, count))


def errors(found: ss.Estimate, truth: ss.LineLoad, rows: np.ndarray) -> np.ndarray:
    """RMS of angle and of place up to a straight line."""
    y = np.asarray(truth.position)[rows]
    line = np.stack([np.ones_like(y), y], axis=-1)
    off = found.position[rows] - line @ np.linalg.lstsq(line, found.position[rows], rcond=None)[0]
    angle = found.angle[rows] - np.asarray(truth.angle)[rows]
    return np.sqrt([(angle**2).mean(), (off**2).mean()])


def jacobian(finger: ss.Finger, load: ss.LineLoad) -> tuple[np.ndarray, np.ndarray]:
    """Whitened derivatives of readings by (place, N, T), and by gains, depth and places in prior units."""
    h, y = 1e-5, np.asarray(load.position)
    force = np.stack([load.normal_force, load.tangential_force], axis=-1)
    a, n = finger.array, len(finger.array)

    def read(at: np.ndarray, **change: np.ndarray) -> np.ndarray:
        field = ss.Finger(finger.skin, replace(a, **change)).receptive_field(at)
        return np.einsum("mnl,ml->mn", field, force)

    def slope(high: np.ndarray, low: np.ndarray) -> np.ndarray:
        return (high - low) / (2 * h)

    positions, depths = np.asarray(a.y), np.asarray(a.depth)
    own = np.concatenate([slope(read(y + h), read(y - h))[..., None], finger.receptive_field(y)], axis=-1)
    by = np.zeros((len(y), n, 2 * n + 1))
    each = np.arange(n)
    by[:, each, each] = GAIN * read(y)
    by[:, :, n] = DEPTH * slope(read(y, depth=depths + h), read(y, depth=depths - h))
    by[:, each, n + 1 + each] = PLACE * slope(read(y, y=positions + h), read(y, y=positions - h))
    return own / NOISE, by / NOISE


def bound(finger: ss.Finger, taught: ss.LineLoad, fresh: ss.LineLoad) -> np.ndarray:
    """Least ratios of rms errors of any method that knows the drawing's errors: (angle, place), and 95 % of each."""
    own, by = jacobian(finger, taught)
    q = np.linalg.qr(own)[0]
    free = by - q @ (np.swapaxes(q, 1, 2) @ by)
    covariance = np.linalg.inv(np.eye(by.shape[2]) + np.einsum("mnp,mnq->pq", free, free))
    own, by = jacobian(finger, fresh)
    noise = np.linalg.inv(np.swapaxes(own, 1, 2) @ own)
    moved = -noise @ (np.swapaxes(own, 1, 2) @ by)
    y, alpha = np.asarray(fresh.position), np.asarray(fresh.angle)
    turn = np.stack([0 * y, -np.sin(alpha), np.cos(alpha)], axis=-1) / np.asarray(fresh.force)[:, None]
    line = np.linalg.qr(np.stack([np.ones_like(y), y], axis=-1))[0]
    position = moved[:, 0] - line @ (line.T @ moved[:, 0])
    angle = np.einsum("mi,mip->mp", turn, moved)
    variances = np.einsum("mi,mij,mj->m", turn, noise, turn), noise[:, 0, 0]
    drawn = np.random.default_rng(0).multivariate_normal(np.zeros(len(covariance)), covariance, size=400)
    means, most = [], []
    for effect, variance in zip((angle, position), variances, strict=True):
        square = ((effect @ drawn.T) ** 2).mean(axis=0) / variance.mean()
        means.append(np.sqrt(1 + square.mean()))
        most.append(np.sqrt(1 + np.quantile(square, 0.95)))
    return np.array(means + most)


def one(skin: ss.Skin, sensors: int, pitch: float, count: int, seed: int) -> np.ndarray:
    """Ratios (angle, place) as calibrated, as drawn, and at best; seconds; share of fresh touches that are OK."""
    rng = np.random.default_rng(seed)
    drawn, made = fingers(skin, sensors, pitch, rng)
    taught = touches(sensors, pitch, count, rng)
    readings = made.read(taught, rng)
    start = perf_counter()
    found = ss.calibrate_blind(drawn, readings, gain_error=GAIN, depth_error=DEPTH, position_error=PLACE)
    seconds = perf_counter() - start
    fresh = touches(sensors, pitch, FRESH, rng)
    readings = made.read(fresh, rng)
    known, new = made.locate(readings), found.finger.locate(readings)
    # as drawn, no touch is explained to within the noise, and none would be located
    rough = ss.Finger(skin, replace(drawn.array, noise=50 * NOISE)).locate(readings)
    both = (known.status == ss.Status.OK) & (new.status == ss.Status.OK)
    placed = both & np.isfinite(rough.position)
    calibrated = errors(new, fresh, both) / errors(known, fresh, both)
    uncalibrated = errors(rough, fresh, placed) / errors(known, fresh, placed)
    return np.concatenate([calibrated, uncalibrated, bound(made, taught, fresh), [seconds, both.mean()]])


def area_fingers(skin: ss.Skin, shape: tuple[int, int], rng: np.random.Generator) -> tuple[ss.Finger, ss.Finger]:
    """As drawn, and as made: a grid of pressure sensors."""
    drawn = ss.Finger(skin, ss.SensorArray.grid(shape=shape, pitch=1.0, depth=1.0, transducer=ss.MeanPressure()))
    noise = 1e-3 * float(drawn.measure(ss.PointLoad(1.25, position=drawn.array.points[0]))[0])
    array, n = replace(drawn.array, noise=noise), len(drawn.array)
    made = replace(
        array,
        y=np.asarray(array.y) + PLACE * rng.standard_normal(n),
        z=np.asarray(array.z) + PLACE * rng.standard_normal(n),
        depth=1 + DEPTH * rng.standard_normal(),
        gain=np.exp(GAIN * rng.standard_normal(n)),
    )
    return ss.Finger(skin, array), ss.Finger(skin, made)


def area_touches(finger: ss.Finger, count: int, lean: float, rng: np.random.Generator) -> ss.PointLoad:
    """Loads over the grid as drawn."""
    points = finger.array.points
    at = rng.uniform(points.min(axis=0), points.max(axis=0), (count, 2))
    return ss.PointLoad(rng.uniform(0.5, 2, count), rng.uniform(0, lean, count), rng.uniform(-np.pi, np.pi, count), at)


def off_similar(found: np.ndarray, truth: np.ndarray) -> float:
    """RMS error of positions (m, 2) up to a shift, a turn and a scale: a complex straight line."""
    at, wanted = found @ [1, 1j], truth @ [1, 1j]
    line = np.stack([np.ones_like(at), at], axis=-1)
    return float(np.sqrt(np.mean(np.abs(line @ np.linalg.lstsq(line, wanted, rcond=None)[0] - wanted) ** 2)))


def one_area(skin: ss.Skin, shape: tuple[int, int], count: int, friction: float, seed: int) -> np.ndarray:
    """Share of intervals that hold [%], chi2 over its mean, error ratios of positions measured and told, seconds."""
    rng = np.random.default_rng(seed)
    drawn, made = area_fingers(skin, shape, rng)
    lean = 0.6 * (friction > 0)
    readings = made.read(area_touches(drawn, count, lean, rng), rng)
    start = process_time()
    found = ss.calibrate_blind(drawn, readings, friction=friction)
    seconds = process_time() - start
    truth = [float(np.asarray(getattr(made.array, p.name))[p.sensor or 0]) for p in found.parameters]
    off = np.array([p.value for p in found.parameters]) - truth
    held = np.abs(off) <= 1.959964 * np.array([p.std for p in found.parameters])
    chi2 = off @ np.linalg.solve(found.covariance, off) / off.size
    fresh = area_touches(drawn, FRESH // 4, lean, rng)
    readings, at = made.read(fresh, rng), np.asarray(fresh.position)
    new, known = (finger.locate(readings, friction=friction) for finger in (found.finger, made))
    both = (new.status == ss.Status.OK) & (known.status == ss.Status.OK)
    ratio = off_similar(new.position[both], at[both]) / off_similar(known.position[both], at[both])
    return np.array([100 * held.mean(), chi2, ratio, found.error_ratio().position, seconds])


def area_rows(fingers: int) -> list[list[str]]:
    """Rows of the table of areas."""
    skins = {"half space": ss.HalfSpace(ss.Material(1.0)), "layer of 2 d": SKINS["layer of 2 d"]}
    cases = [("half space", (4, 4), count, 1.0) for count in (50, 100, 500)] + [("half space", (4, 4), 100, 0.0)]
    cases += [("half space", (3, 3), 100, 1.0), ("half space", (2, 4), 100, 0.0)]
    cases += [
        ("layer of 2 d", (4, 4), 100, 1.0),
        ("layer of 2 d", (4, 4), 500, 1.0),
        ("layer of 2 d", (2, 4), 100, 0.0),
    ]
    rows = []
    for name, shape, count, friction in cases:
        seen = np.array([one_area(skins[name], shape, count, friction, seed) for seed in range(fingers)])
        middle = np.median(seen, axis=0)
        held, chi2 = seen[:, :2].mean(axis=0)
        row = [name, f"{shape[0]} x {shape[1]}", "drag" if friction else "straight", f"{count}", f"{fingers}"]
        row += [f"{held:.1f}", f"{chi2:.2f}", f"{middle[2]:.2f}", f"{seen[:, 2].max():.2f}", f"{middle[3]:.2f}"]
        rows.append([*row, f"{middle[4]:.1f}"])
    return rows


def main() -> None:
    """Run and print."""
    options = arguments(__doc__, fingers=20)
    cases = [("half plane", n, pitch, count) for n in (4, 8) for pitch in (0.5, 0.75, 1.0) for count in (50, 200)]
    cases += [("half plane", 4, 0.75, 1000), ("layer of 2 d", 4, 0.75, 200), ("layer of 2 d", 8, 0.75, 200)]
    cases += [("round, R = 6 d", 4, 0.75, 200), ("round, R = 6 d", 8, 0.75, 200)]
    rows = []
    for name, sensors, pitch, count in cases:
        fingers = options.fingers if name == "half plane" else max(options.fingers // 4, 1)
        seen = np.array([one(SKINS[name], sensors, pitch, count, seed) for seed in range(fingers)])
        middle, worst = np.median(seen, axis=0), seen.max(axis=0)
        row = [name, f"{sensors}", f"{pitch}", f"{count}", f"{fingers}"]
        for i in (0, 1):
            row += [f"{middle[i + 2]:.0f}", f"{middle[i]:.2f}", f"{worst[i]:.2f}"]
            row += [f"{middle[i + 4]:.2f}", f"{middle[i + 6]:.2f}"]
        rows.append([*row, f"{seen[:, 9].min():.3f}", f"{middle[8]:.2f}"])
    columns = ["skin", "sensors", "pitch/d", "touches", "fingers"]
    for what in ("angle", "position"):
        columns += [f"{what}: drawn", "median", "worst", "bound", "95 %"]
    title = "RMS errors over those of a finger known exactly"
    show(title, [*columns, "least OK", "s"], rows, options.json)
    columns = ["skin", "grid", "touches are", "touches", "fingers", "held [%]", "chi2", "position: median", "worst"]
    show("On an area", [*columns, "told", "CPU [s]"], area_rows(options.fingers), options.json)


if __name__ == "__main__":
    main()
