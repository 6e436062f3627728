"""`Finger.fit` and `decide.contact_type`: how right, how sure, how fast, beside what else one would use.

    python benchmarks/bench_shape.py [--frames 20000] [--peer 20] [--train 50000] [--json FILE]

Sensors at unit depth; unit forces; noise in shares of the reading of a normal line load straight above; touches over
the array, leaning within 40 degrees; wedges of half width 0.1 to 0.35 depth, punches and Hertz contacts of 0.5 to 1.2.
The peer of `fit` is scipy's least squares from eight places and three widths, told all the forward model knows; that
of `contact_type` a random forest of 100 trees trained on as many simulated frames as --train says (scikit-learn, of the
extra `bench`), with the same noise. Asked for: four types at 0.1 % noise, 94 % with five sensors, 95 % with six; 99 %
at 0.01 %; vertex against side 99.5 % with four sensors at 1 %; expected calibration error 0.02; 100 us a frame.
"""

from __future__ import annotations

import time
from collections.abc import Sequence
from typing import Any

import numpy as np
from scipy.optimize import least_squares

import subskin as ss
from _common import arguments, finger, search, show

KINDS = {
    "line": (ss.LineLoad, "line", (0.0, 0.0)),
    "vertex": (ss.Wedge, "wedge", (0.1, 0.35)),
    "flat side": (ss.FlatPunch, "punch", (0.5, 1.2)),
    "round side": (ss.Hertz, "hertz", (0.5, 1.2)),
}
CASES = (
    (4, 0.35, 1e-2, ("vertex", "round side")),
    (4, 0.5, 1e-2, ("vertex", "round side")),
    (5, 0.5, 1e-3, tuple(KINDS)),
    (6, 0.5, 1e-3, tuple(KINDS)),
    (5, 0.5, 1e-4, tuple(KINDS)),
    (6, 0.5, 1e-4, tuple(KINDS)),
)

FITS = ((5, 0.5, 1e-3), (6, 0.5, 1e-3), (8, 0.5, 1e-3), (8, 0.5, 1e-2))


def touches(tip: ss.Finger, names: tuple[str, ...], count: int, seed: int) -> tuple[np.ndarray, np.ndarray]:
    """Readings (count, n) and the number of each one's kind."""
    rng = np.random.default_rng(seed)
    half = float(np.asarray(tip.array.y).max())
    truth = np.arange(count) % len(names)
    readings = np.empty((count, len(tip.array)))
    for i, name in enumerate(names):
        family, _, width = KINDS[name]
        size = int((truth == i).sum())
        load = {
            "force": np.ones(size),
            "angle": rng.uniform(-np.deg2rad(40), np.deg2rad(40), size),
            "position": rng.uniform(-half, half, size),
        }
        if width[1]:
            load["half_width"] = rng.uniform(*width, size)
        readings[truth == i] = tip.read(family(**load), rng)
    return readings, truth


def calibration_error(probability: np.ndarray, right: np.ndarray, bins: int = 15) -> float:
    """Expected calibration error of the most probable kind: mean |confidence - accuracy| over bins."""
    group = np.minimum((probability * bins).astype(int), bins - 1)
    return float(
        sum(
            abs(probability[group == b].mean() - right[group == b].mean()) * (group == b).mean()
            for b in np.unique(group)
        )
    )


def forest(tip: ss.Finger, names: tuple[str, ...], train: int, frames: np.ndarray) -> tuple[np.ndarray, float]:
    """Probabilities (m, kinds) by a random forest on readings over their norm, and its time a frame [s]."""
    from sklearn.ensemble import RandomForestClassifier

    def features(readings: np.ndarray) -> np.ndarray:
        return readings / np.linalg.norm(readings, axis=1, keepdims=True)

    readings, truth = touches(tip, names, train, seed=99)
    model = RandomForestClassifier(100, random_state=0).fit(features(readings), truth)
    start = time.perf_counter()
    said = model.predict_proba(features(frames))
    return said, (time.perf_counter() - start) / len(frames)


def types(frames: int, train: int, cases: Sequence[Any] = CASES) -> list[list[str]]:
    """Rows of the table of `contact_type`."""
    rows = []
    for sensors, pitch, noise, names in cases:
        tip = finger(sensors, pitch, noise)
        readings, truth = touches(tip, names, frames, seed=sensors)
        half = float(np.asarray(tip.array.y).max())
        kinds = tuple(ss.decide.Kind(n, *KINDS[n][1:]) for n in names)
        ss.decide.contact_type(tip, readings[:1], kinds, search=(-half, half))
        start = time.perf_counter()
        said = ss.decide.contact_type(tip, readings, kinds, search=(-half, half))
        took = (time.perf_counter() - start) / frames
        share = np.nan_to_num(said.probability)
        theirs, slow = forest(tip, names, train, readings)
        row = [f"{len(names)} kinds, {sensors} sensors, {pitch} depth, {noise:.2%}"]
        for p in (share, theirs):
            best, top = p.argmax(1), p.max(1)
            row += [f"{(best == truth).mean():.2%}", f"{calibration_error(top, best == truth):.4f}"]
        unsure = (said.decision < 0).mean()
        wrong = ((said.decision >= 0) & (said.decision != truth)).mean()
        row[3:3] = [f"{share.max(1).mean():.2%}", f"{unsure:.2%}", f"{wrong:.2%}", f"{1e6 * took:.0f}"]
        rows.append([*row, f"{1e6 * slow:.0f}"])
    return rows


def multi_start(tip: ss.Finger, frame: np.ndarray, ends: tuple[float, float]) -> np.ndarray:
    """The peer of `fit`: position, half width, normal and tangential force, the best of 24 starts."""
    sigma = np.asarray(tip.array.noise)

    def residual(p: np.ndarray) -> np.ndarray:
        size, lean = np.hypot(p[2], p[3]), np.arctan2(p[3], p[2])
        touch = ss.Hertz(force=size, angle=lean, position=p[0], half_width=min(max(abs(p[1]), 1e-3), 5.0))
        return (tip.read(touch) - frame) / sigma

    starts = [(y, a) for y in np.linspace(*ends, 8) for a in (0.3, 0.7, 1.2)]
    found = [least_squares(residual, [y, a, 1.0, 0.0], method="lm", max_nfev=200) for y, a in starts]
    best = min(found, key=lambda r: r.cost + 1e9 * (r.x[2] <= 0 or abs(r.x[3]) > r.x[2])).x
    return np.array([best[0], abs(best[1]), *best[2:]])


def bound(tip: ss.Finger, truth: np.ndarray) -> np.ndarray:
    """Cramer-Rao bound on the variances of (position, half width), (m, 2), by differences of the forward model."""
    h = 1e-5
    columns = []
    for k in range(4):
        ends = [truth.copy(), truth.copy()]
        ends[0][:, k] += h
        ends[1][:, k] -= h
        up, down = (
            tip.read(
                ss.Hertz(
                    force=np.hypot(e[:, 2], e[:, 3]), angle=np.arctan2(e[:, 3], e[:, 2]),
                    position=e[:, 0], half_width=e[:, 1],
                )
            )
            for e in ends
        )  # fmt: skip
        columns.append((up - down) / (2 * h))
    jacobian = np.stack(columns, -1) / np.asarray(tip.array.noise)[:, None]
    return np.diagonal(np.linalg.inv(np.einsum("mni,mnj->mij", jacobian, jacobian)), axis1=1, axis2=2)[:, :2]


def fits(frames: int, peer: int, cases: Sequence[Any] = FITS) -> list[list[str]]:
    """Rows of the table of `fit`."""
    rows = []
    for sensors, pitch, noise in cases:
        tip, ends = finger(sensors, pitch, noise), search(sensors, pitch)
        rng = np.random.default_rng(sensors)
        half = 0.5 * (sensors - 1) * pitch
        lean = rng.uniform(-np.deg2rad(40), np.deg2rad(40), frames)
        y, a = rng.uniform(-half, half, frames), rng.uniform(0.5, 1.2, frames)
        truth = np.stack([y, a, np.cos(lean), np.sin(lean)], -1)
        readings = tip.read(ss.Hertz(force=1.0, angle=lean, position=y, half_width=a), rng)
        tip.fit(readings[:1], "hertz", search=ends)
        start = time.perf_counter()
        found = tip.fit(readings, "hertz", search=ends)
        took = (time.perf_counter() - start) / frames
        ok = found.status == ss.Status.OK
        error = np.stack([found.position, found.half_width], -1) - truth[:, :2]
        variance = bound(tip, truth)
        ratio = np.sqrt((error[ok] ** 2).mean(0) / variance[ok].mean(0))
        inside = (found.half_width_interval[:, 0] <= a) & (a <= found.half_width_interval[:, 1])
        few = np.flatnonzero(ok[:peer])
        start = time.perf_counter()
        theirs = np.array([multi_start(tip, frame, ends) for frame in readings[few]])
        slow = (time.perf_counter() - start) / few.size
        off = np.abs(theirs[:, 0] - y[few]) > 0.1
        rest = np.sqrt(((theirs[~off, :2] - truth[few[~off], :2]) ** 2).mean(0) / variance[few[~off]].mean(0))
        rows.append(
            [
                f"{sensors} sensors, {pitch} depth, {noise:.1%}",
                *(f"{r:.3f}" for r in ratio),
                f"{inside[ok].mean():.2%}",
                f"{ok.mean():.2%}",
                f"{((np.abs(error[:, 0]) > 0.1) & (np.abs(error[:, 0]) > 6 * found.std[:, 0]) & ok).mean():.1e}",
                f"{1e6 * took:.0f}",
                *(f"{r:.3f}" for r in rest),
                f"{off.mean():.1%}",
                f"{1e6 * slow:.0f}",
            ]
        )
    return rows


def main() -> None:
    """Run and print."""
    options = arguments(__doc__, frames=20_000, peer=20, train=50_000)
    columns = [
        "contact_type", "right", "ECE", "said", "cannot tell", "decided wrongly", "us a frame",
        "forest: right", "ECE", "us a frame",
    ]  # fmt: skip
    show(f"Kinds of contact, {options.frames} frames each", columns, types(options.frames, options.train), options.json)
    columns = [
        "fit, Hertz", "position / bound", "width / bound", "width in 95 %", "OK", "gross, unflagged", "us a frame",
        "24 starts: position", "width", "off by > 0.1 depth", "us a frame",
    ]  # fmt: skip
    show(
        f"Contacts of some width, {options.frames} frames each",
        columns,
        fits(options.frames, options.peer),
        options.json,
    )


if __name__ == "__main__":
    main()
