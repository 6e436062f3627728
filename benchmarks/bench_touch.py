"""What a touch tells, in one table: accuracy and time of each way, beside what else one would use.

    python benchmarks/bench_touch.py [--frames 5000] [--peer 20] [--train 50000] [--json FILE]

Small runs of the cases asked for, at sensors one depth deep and noise in shares of the full scale; bench_shape,
bench_side_angle, bench_pressure and study_blind have more cases of each. Needs the extra `bench` (scikit-learn).
"""

from __future__ import annotations

import time
from collections.abc import Callable

import numpy as np

import bench_pressure
import bench_shape
import bench_side_angle
import study_blind
import subskin as ss
from _common import arguments, finger, show
from subskin.decide import Friction, least_force, slip


def timed(work: Callable[[], object], frames: int) -> float:
    """Best time of three, in microseconds a frame."""
    spent = []
    for _ in range(3):
        start = time.perf_counter()
        work()
        spent.append(time.perf_counter() - start)
    return 1e6 * min(spent) / frames


def shape(frames: int, peer: int) -> list[str]:
    """A contact of some width."""
    row = bench_shape.fits(frames, peer, cases=((6, 0.5, 1e-3),))[0]
    ours = f"width to {row[2]} of the bound"
    return ["half width, Hertz, 6 sensors, 0.1 %", ours, row[6], "least_squares, 24 starts", f"{row[8]}", row[10]]


def kinds(frames: int, train: int) -> list[list[str]]:
    """What touched."""
    out = []
    for case in (bench_shape.CASES[0], bench_shape.CASES[3]):
        row = bench_shape.types(frames, train, cases=(case,))[0]
        label = f"kind, of {len(case[3])}, {case[0]} sensors, {case[2]:.1%}".replace("%", " %")
        ours = f"{row[1]} right, ECE {row[2]}"
        out.append([label, ours, row[6], "random forest", f"{row[7]} right, ECE {row[8]}", row[9]])
    return out


def side(frames: int, peer: int) -> list[str]:
    """The angle on a side, centre and width known."""
    tip, rng = bench_side_angle.row(9, 1e-3), np.random.default_rng(0)
    lean = rng.uniform(-0.7, 0.7, frames)
    readings = tip.read(ss.Hertz(np.ones(frames), lean, 0.1, half_width=0.7), rng)
    told = ss.side_angle(tip, readings, position=0.1, half_width=0.7)
    spent = timed(lambda: ss.side_angle(tip, readings, position=0.1, half_width=0.7), frames)
    start = time.perf_counter()
    theirs = np.array([bench_side_angle.peer(tip, frame) for frame in readings[:peer]])
    slow = 1e6 * (time.perf_counter() - start) / peer
    ours, other = (np.degrees(np.sqrt(np.mean(e**2))) for e in (told.angle - lean, theirs - lean[:peer]))
    return [
        "angle on a side by the slope, 9 sensors, 0.1 %", f"{ours:.2f} degrees", f"{spent:.1f}",
        "least_squares, 9 starts", f"{other:.2f} degrees", f"{slow:.0f}",
    ]  # fmt: skip


def slips(frames: int, peer: int) -> list[list[str]]:
    """Probability of slip, and the least grip, beside drawing at random."""
    tip, rng = finger(6, 0.5, 1e-2), np.random.default_rng(1)
    lean = rng.uniform(0.1, 0.6, frames)
    found = tip.locate(tip.read(ss.LineLoad(np.ones(frames), lean, 0.2), rng), friction=2.0)
    mu, draws = Friction.between(0.4, 0.8), 20_000
    said, spent = slip(found, mu), timed(lambda: slip(found, mu), frames)
    few = np.flatnonzero(found.status == ss.Status.OK)[:peer]
    coefficient = rng.uniform(0.4, 0.8, draws)
    start = time.perf_counter()
    drawn = np.empty(few.size)
    for i, f in enumerate(few):
        load = [said.normal[f], said.tangential[f]]
        normal, tangential = rng.multivariate_normal(load, said.covariance[f], draws).T
        drawn[i] = (np.abs(tangential) > coefficient * normal).mean()
    slow = 1e6 * (time.perf_counter() - start) / few.size
    scatter = np.sqrt(np.maximum(drawn * (1 - drawn), 1e-5) / draws)
    apart = np.abs(said.probability[few] - drawn)
    grip, taken = least_force(found, mu, 1e-3), timed(lambda: least_force(found, mu, 1e-3), frames)
    again = said.probability_at(int(few[0]), grip[few[0]], said.tangential[few[0]])
    return [
        [
            "probability of slip, friction a range", f"{apart.max():.4f} from the draws'", f"{spent:.0f}",
            f"{draws} random draws", f"scatter {scatter.max():.4f}", f"{slow:.0f}",
        ],
        ["least grip for a probability of 1e-3", f"there it is {float(again):.6f}", f"{taken:.0f}", "", "", ""],
    ]  # fmt: skip


def pressure(frames: int, peer: int) -> list[str]:
    """The pressure along the surface."""
    tip, touch = finger(25, 0.25, 1e-3), bench_pressure.touches(frames, 1.0, 30)
    readings = tip.read(touch, np.random.default_rng(1))
    mapper = ss.estimate.PressureMapper(tip)
    found = mapper(readings)
    spent = 1e6 * bench_pressure.best_of(3, lambda: mapper(readings)) / frames
    theirs, answers = bench_pressure.peer(mapper, readings[:peer], mapper(readings[:peer]))
    error = np.sqrt((bench_pressure.errors(found, touch) ** 2).mean())
    apart = np.abs(answers - found.pressure[:peer]).max() / found.pressure.max()
    return [
        "pressure, 25 sensors, 0.1 %, drag 30 degrees", f"{error:.3f} relative L2", f"{spent:.0f}",
        "a loop over nnls, told our weight", f"the same to {apart:.0e}", f"{1e6 * theirs:.0f}",
    ]  # fmt: skip


def blind() -> list[list[str]]:
    """Self-calibration from 200 touches: errors over those of the finger known exactly."""
    out = []
    for sensors in (4, 8):
        runs = np.array(
            [study_blind.one(study_blind.SKINS["half plane"], sensors, 0.75, 200, seed) for seed in range(5)]
        )
        ours, drawn, best = (np.median(runs[:, k], axis=0) for k in ((0, 1), (2, 3), (4, 5)))
        out.append(
            [
                f"blind calibration, 200 touches, {sensors} sensors",
                f"angle {ours[0]:.2f}, place {ours[1]:.2f} of a known finger's",
                f"{1e6 * np.median(runs[:, 8]) / 200:.0f} a touch",
                "none (as drawn); the bound",
                f"{drawn[0]:.0f}, {drawn[1]:.0f}; {best[0]:.2f}, {best[1]:.2f}",
                "",
            ]
        )
    return out


def main() -> None:
    """Run and print."""
    options = arguments(__doc__, frames=5000, peer=20, train=50_000)
    rows = [
        shape(options.frames, options.peer),
        *kinds(options.frames, options.train),
        side(options.frames, options.peer),
        *slips(options.frames, options.peer),
        pressure(min(options.frames, 1000), options.peer),
        *blind(),
    ]
    columns = ["asked", "accuracy", "us a frame", "beside", "its accuracy", "us a frame"]
    show(f"What a touch tells, {options.frames} frames", columns, rows, options.json)


if __name__ == "__main__":
    main()
