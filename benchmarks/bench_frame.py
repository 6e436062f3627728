"""Time of reading, locating, fitting and judging slip, frame by frame and in batches, beside another version.

    python benchmarks/bench_frame.py [--beside SRC] [--rounds 15] [--frames 100000] [--json FILE]

SRC is the `src` of another checkout (`git worktree add ../before v0.1.0`). Each version has a process of its own; they
take turns, case by case, so that a busy machine slows both. Medians, and the median of the ratios. Asked for, of 8
sensors on a half plane: a single frame read in 60 us and judged in 60 us; a fit 5 times as fast as in 0.1.0. Of 16
barometers on an area with 1 % noise and a friction between 0.4 and 0.8: the interval of |T| / (mu N) ("ratio", with
`slip`) and the least force ("grip") of a frame in 300 us.
"""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import numpy as np

HERE = Path(__file__).resolve().parent
SKINS, CONTACTS, KINDS = ("half plane", "layer", "round"), ("line", "hertz"), ("strain", "pressure")
SHORTEST = 0.02  # seconds that a case takes a turn


Case = tuple[str, str, str, str, int]
"""Verb, skin, contact, transducer and number of frames."""


def cases(frames: int) -> list[Case]:
    """Readings of every kind, then what is made of them; one frame at a time is what a live loop does."""
    half = SKINS[0]
    single = [("read", s, c, k, 1) for s in SKINS for c in CONTACTS for k in KINDS if k == "strain" or s == half]
    many = {skin: frames if skin == half else frames // 20 for skin in SKINS}
    batches = [("read", s, c, "strain", n) for s in SKINS for c in CONTACTS for n in (100, many[s])]
    verbs = [(v, half, "hertz", "strain", n) for v in ("locate", "fit", "slip") for n in (1, 100, frames // 20)]
    verbs += [(v, half, "line", "strain", n) for v in ("ratio", "grip") for n in (1, 100)]
    area = [(v, "area", "point", "pressure", n) for v in ("slip", "ratio", "grip") for n in (1, 100)]
    return single + batches + verbs + area


def call(verb: str, skin: str, contact: str, kind: str, frames: int) -> Any:
    """What is timed: one call for a contact, or for a batch of contacts, and 8 sensors 2 mm deep, or 16 on an area."""
    import subskin as ss

    rubber = ss.Material(young=0.4e6)
    if skin == "area":
        array = ss.SensorArray.grid((4, 4), pitch=3e-3, depth=3e-3, transducer=ss.MeanPressure(), noise=180.0)
        finger, rng = ss.Finger(ss.HalfSpace(rubber), array), np.random.default_rng(0)
        angle = rng.uniform(0.2, 0.5, frames)
        touch = ss.PointLoad(1.0, angle=angle, azimuth=0.7, position=rng.uniform(-2e-3, 2e-3, (frames, 2)))
        found = finger.locate(finger.read(touch, rng))
        return judged(verb, found[0] if frames == 1 else found)
    medium = {
        "half plane": lambda: ss.HalfPlane(rubber),
        "layer": lambda: ss.Layered(ss.Layer(rubber, thickness=6e-3)),
        "round": lambda: ss.Round(rubber, radius=8e-3, core_radius=4e-3),
    }[skin]()
    transducer = ss.NormalStrain() if kind == "strain" else ss.MeanPressure()
    array = ss.SensorArray.line(8, pitch=1.5e-3, depth=2e-3, transducer=transducer, noise=5e-4)
    finger = ss.Finger(medium, array)
    rng = np.random.default_rng(0)
    shape = () if frames == 1 else (frames,)
    load = {"force": 40.0, "angle": rng.uniform(-0.6, 0.6, shape), "position": rng.uniform(-4e-3, 4e-3, shape)}
    touch = ss.LineLoad(**load) if contact == "line" else ss.Hertz(**load, half_width=0.4e-3)
    if verb == "read":
        return lambda: finger.read(touch)
    readings = finger.read(touch, rng=rng)
    if verb == "fit":
        return lambda: finger.fit(readings, "hertz")
    if verb == "locate":
        return lambda: finger.locate(readings)
    return judged(verb, finger.locate(readings))


def judged(verb: str, found: Any) -> Any:
    """One call for what is made of loads that were found."""
    import subskin as ss

    mu = ss.decide.Friction.between(0.4, 0.8)
    if verb == "slip":
        return lambda: ss.decide.slip(found, mu)
    if verb == "ratio":
        return lambda: ss.decide.slip(found, mu).ratio_interval
    return lambda: ss.decide.least_force(found, mu)


def serve() -> None:
    """Answer cases on standard input with the median time [s] of a turn."""
    made: dict[str, Any] = {}
    for line in sys.stdin:
        if line not in made:
            made[line] = call(*json.loads(line))
        read = made[line]
        times: list[float] = []
        while not times or sum(times) < SHORTEST:
            start = time.perf_counter_ns()
            read()
            times.append(1e-9 * (time.perf_counter_ns() - start))
        print(float(np.median(times)), flush=True)


def server(source: str) -> subprocess.Popen[str]:
    """A process that answers for the version in the folder `source`."""
    code = f"import sys; sys.path[:0] = [{source!r}, {str(HERE)!r}]; import bench_frame; bench_frame.serve()"
    pipe = subprocess.PIPE
    one = dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"), "1")
    env = {**os.environ, **one}
    return subprocess.Popen([sys.executable, "-c", code], stdin=pipe, stdout=pipe, text=True, env=env)


def ask(process: subprocess.Popen[str], case: Case) -> float:
    """The time of one turn."""
    assert process.stdin is not None
    assert process.stdout is not None
    print(json.dumps(case), file=process.stdin, flush=True)
    return float(process.stdout.readline())


def main() -> None:
    """Run and print."""
    from _common import show

    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--beside", type=Path, metavar="SRC", help="src of another version of subskin")
    parser.add_argument("--rounds", type=int, default=15, help="turns of each case (15)")
    parser.add_argument(
        "--frames", type=int, default=100_000, help="frames of the largest batch; a 20th on others (100000)"
    )
    parser.add_argument("--json", type=Path, help="append the table to this file")
    options = parser.parse_args()
    sources = [str(HERE.parent / "src"), *([str(options.beside.resolve())] if options.beside else [])]
    asked = cases(options.frames)
    servers = [server(source) for source in sources]
    for case in asked:  # the first time is not counted
        for process in servers:
            ask(process, case)
    turns = range(options.rounds)
    times = np.array([[[ask(process, case) for process in servers] for case in asked] for _ in turns])
    for process in servers:
        process.communicate()
    rows = []
    for (verb, skin, contact, kind, frames), seen in zip(asked, times.transpose(1, 0, 2)):
        unit, scale = ("us", 1e6) if frames == 1 else ("us a frame", 1e6 / frames)
        medians = [f"{scale * value:.3g}" for value in np.median(seen, axis=0)]
        ratio = [f"{np.median(seen[:, 1] / seen[:, 0]):.2f}"] if options.beside else []
        rows.append([verb, skin, contact, kind, f"{frames:,}", *medians, *ratio, unit])
    columns = [
        "verb",
        "skin",
        "contact",
        "sensors",
        "frames",
        "here",
        *(["beside", "as fast"] if options.beside else []),
        "",
    ]
    show("A frame of 8 sensors, and of 16 on an area", columns, rows, options.json)


if __name__ == "__main__":
    main()
