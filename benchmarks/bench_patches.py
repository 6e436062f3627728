"""Fits of patches: force, drag and sides of rectangles, of a known outline, and of boxes that are pressed in.

    python benchmarks/bench_patches.py [--count 200] [--boxes 60] [--json FILE]

Strain gauges 2.5 mm deep in a half space, 4 mm apart, E = 0.4 MPa, noise 2e-4; 4 N; every other pad drags at 0.3 rad.
Squares lie straight, rectangles have sides of a ratio up to 1.8 and any turn. Middles lie up to 4 mm from that of the
sensors, less where the pad would pass the outermost ones by more than 2 mm. Beside them stand the Cramer-Rao bound of a
rectangle whose sides and turn are not known, and the resultant of the same frames. Boxes of sides 3 to 10 mm, with
edges of radius 0.2 to 1.5 mm, are pressed by `press`, whose pressure is no family's.
"""

from __future__ import annotations

import warnings
from time import perf_counter

import numpy as np

import subskin as ss
from _common import arguments, show
from bench_resultant import FORCE, bound, finger
from subskin.pressing import Box


def pads(half: float, count: int, turned: bool, rng: np.random.Generator) -> ss.Patch:
    """Rectangles of about one half side [m]."""
    reach = float(np.clip(8e-3 - half, 1e-3, 4e-3))
    ratio = np.exp(rng.uniform(-0.3, 0.3, count)) if turned else np.ones(count)
    return ss.Patch(
        force=np.full(count, FORCE), angle=np.where(np.arange(count) % 2, 0.3, 0.0),
        azimuth=rng.uniform(0, 2 * np.pi, count), position=rng.uniform(-reach, reach, (count, 2)),
        half_widths=half * np.stack([ratio, 1 / ratio], axis=-1),
        turn=rng.uniform(-np.pi / 4, np.pi / 4, count) if turned else np.zeros(count),
    )  # fmt: skip


def errors(found: ss.Estimate, load: np.ndarray, middle: np.ndarray) -> list[str]:
    """Shares OK, ambiguous and unexplained; of those OK errors of N and T [% of N], what intervals hold, gross ones."""
    ok = found.status == ss.Status.OK
    shares = [f"{100 * np.mean(found.status == s):.0f}" for s in (0, ss.Status.AMBIGUOUS, ss.Status.UNEXPLAINED)]
    if not ok.any():
        return [*shares, *7 * ["-"]]
    deviation = np.sqrt(np.diagonal(found.load.covariance, axis1=-2, axis2=-1))
    off = np.concatenate([found.position - middle, found.components - load], axis=-1)
    z, normal, drag = np.abs(off / deviation)[ok], np.abs(off[ok, 2]) / FORCE, np.hypot(*off[ok, 3:].T) / FORCE
    return [
        *shares, f"{100 * np.median(normal):.2f}", f"{100 * np.quantile(normal, 0.95):.1f}",
        f"{100 * np.median(drag):.2f}",
        *(f"{100 * (z[:, p] < 1.96).mean():.0f}" for p in (slice(2, 3), slice(3, 5), slice(0, 2))),
        f"{100 * np.mean(np.where(ok, np.abs(off[:, 2] / deviation[:, 2]), 0) > 5):.1f}",
    ]  # fmt: skip


def main() -> None:
    """Print the tables."""
    told = arguments(__doc__, count=200, boxes=60)
    head = [
        "",
        "OK %",
        "ambiguous",
        "unexplained",
        "N %",
        "N 95 %",
        "T %",
        "N held",
        "T held",
        "middle held",
        "> 5 std",
    ]
    tip, rng = finger(4, 4e-3), np.random.default_rng(1)
    for turned, title in ((False, "Squares on 4 x 4"), (True, "Rectangles, turned, on 4 x 4")):
        rows = []
        for half in range(1, 10):
            some = pads(1e-3 * half, told.count, turned, rng)
            readings = tip.read(some, rng)
            tip.fit(readings[0], "patch")
            start = perf_counter()
            found = tip.fit(readings, "patch")
            spent = 1e3 * (perf_counter() - start) / told.count
            peer = errors(tip.resultant(readings), some.components, some.position)
            rows.append([
                f"{half} mm", f"{bound(tip, some, turns=True):.1f}", *errors(found, some.components, some.position),
                f"{spent:.1f}", peer[0], peer[3],
            ])  # fmt: skip
        more = ["a frame [ms]", "resultant OK %", "resultant N %"]
        show(title, [head[0], "bound N %", *head[1:], *more], rows, told.json)
    rows = []
    for half in range(6, 11):
        some = pads(1e-3 * half, told.count, False, rng)
        sides = (1e-3 * half, 1e-3 * half)
        found = tip.fit(tip.read(some, rng), "patch", half_width=sides, turn=0.0)
        rows.append([f"{half} mm", *errors(found, some.components, some.position)])
    show("Squares of a known outline on 4 x 4", head, rows, told.json)
    rows, wide = [], finger(8, 4e-3)
    for half in (2, 4, 6, 8, 10):
        some = pads(1e-3 * half, told.count // 4, True, rng)
        readings = wide.read(some, rng)
        wide.fit(readings[0], "patch")
        start = perf_counter()
        found = wide.fit(readings, "patch")
        spent = 1e3 * (perf_counter() - start) / len(readings)
        rows.append([f"{half} mm", *errors(found, some.components, some.position), f"{spent:.1f}"])
    show("Rectangles, turned, on 8 x 8, 4 mm apart", [*head, "a frame [ms]"], rows, told.json)
    frames, sizes = [], []
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # strains of a fifth
        for _ in range(told.boxes):
            half, azimuth = rng.uniform(1.5e-3, 5e-3, 2), rng.uniform(0, np.pi / 2)
            box = Box(*half, edge_radius=rng.uniform(0.2e-3, 1.5e-3), azimuth=azimuth)
            frames.append(tip.read(ss.press(tip.skin, box, force=FORCE).contact, rng))
            sizes.append(half.max())
    readings, longest, rows = np.array(frames), np.array(sizes), []
    answers = {
        **{f"patch, {name}": tip.fit(readings, "patch", pressure=name) for name in ("even", "linear", "punch")},
        "resultant": tip.resultant(readings),
    }
    for low, high in ((0.0, 3e-3), (3e-3, 4e-3), (4e-3, 5e-3)):
        part = (longest > low) & (longest <= high)
        load = np.tile([FORCE, 0.0, 0.0], (int(part.sum()), 1))
        for name, found in answers.items():
            rows.append([f"to {1e3 * high:.0f} mm: {name}", *errors(found[part], load, np.zeros((len(load), 2)))])
    show("Boxes that are pressed in, on 4 x 4", head, rows, told.json)


if __name__ == "__main__":
    main()
