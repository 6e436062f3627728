"""`decide.contact_type` on contacts that are none of its kinds: how often it is sure of a kind and wrong.

    python benchmarks/study_kinds.py [--frames 1000] [--json FILE]

Sensors at unit depth, unit forces, noise in shares of the reading of a normal line load straight above; touches over
the array, leaning within 40 degrees; the kinds, the search and the friction are the usual ones. Lengths are in depths.
A frame is sure and wrong where a kind that is not the contact's is decided for (probability 0.95); "none of these" is
never wrong here. The contact's kind follows the stated edges: narrower than a roller of 0.4 is a vertex, whatever the
profile. Named contacts are those that 0.1 knew: right is the most probable kind. Calibration over all: as many frames
of the named contacts as of all others, right being the contact's own kind, or "none of these".
"""

from __future__ import annotations

import time
import warnings
from collections.abc import Callable

import numpy as np

import subskin as ss
from _common import arguments, finger, show
from bench_shape import KINDS, calibration_error

warnings.simplefilter("ignore", ss.errors.ValidityWarning)
SURE = 0.95
Draw = Callable[[ss.Finger, np.random.Generator, int], np.ndarray]


def drawn(tip: ss.Finger, rng: np.random.Generator, size: int) -> dict[str, np.ndarray]:
    """Unit forces over the array."""
    half = float(np.asarray(tip.array.y).max())
    angle = rng.uniform(-np.deg2rad(40), np.deg2rad(40), size)
    return {"force": np.ones(size), "angle": angle, "position": rng.uniform(-half, half, size)}


def of(family: type, low: float = 0.0, high: float = 0.0) -> Draw:
    """Contacts of a family, of half widths from low to high."""

    def draw(tip: ss.Finger, rng: np.random.Generator, size: int) -> np.ndarray:
        width = {"half_width": rng.uniform(low, high, size)} if high else {}
        return tip.read(family(**drawn(tip, rng, size), **width))

    return draw


def lines(count: int, least: float = 0.5, most: float = 3.0) -> Draw:
    """Several lines, neighbours `least` to `most` apart, within the array where it is long enough."""

    def draw(tip: ss.Finger, rng: np.random.Generator, size: int) -> np.ndarray:
        half = float(np.asarray(tip.array.y).max())
        gaps = rng.uniform(least, most / (count - 1), (count - 1, size))
        start = rng.uniform(-half, np.maximum(half - gaps.sum(0), -half), size)
        total = np.zeros((size, len(tip.array)))
        for i in range(count):
            load = drawn(tip, rng, size) | {"force": rng.uniform(0.3, 1.0, size)}
            total += tip.read(ss.LineLoad(**load | {"position": start + gaps[:i].sum(0)}))
        return total

    return draw


def tilted(tip: ss.Finger, rng: np.random.Generator, size: int) -> np.ndarray:
    """Flats whose one edge bears more, the other less, down to none."""
    load, width = drawn(tip, rng, size), rng.uniform(0.5, 1.5, size)
    moment = rng.choice([-1, 1], size) * rng.uniform(0.4, 1.0, size) * np.cos(load["angle"]) * width / 2
    return tip.read(ss.FlatPunch(**load, half_width=width, moment=moment))


def stuck(tip: ss.Finger, rng: np.random.Generator, size: int) -> np.ndarray:
    """Rollers, one sensor of the finger reading nothing."""
    readings = of(ss.Hertz, 0.5, 1.2)(tip, rng, size)
    readings[np.arange(size), rng.integers(0, len(tip.array), size)] = 0.0
    return readings


def weak(tip: ss.Finger, rng: np.random.Generator, size: int) -> np.ndarray:
    """Lines, one sensor at 0.6 of its gain."""
    readings = of(ss.LineLoad)(tip, rng, size)
    readings[np.arange(size), rng.integers(0, len(tip.array), size)] *= 0.6
    return readings


def on(skin: ss.Skin) -> Draw:
    """Lines on another skin than the one that the finger is taken for."""

    def draw(tip: ss.Finger, rng: np.random.Generator, size: int) -> np.ndarray:
        return ss.Finger(skin, tip.array).read(ss.LineLoad(**drawn(tip, rng, size)))

    return draw


def sliding_middle(tip: ss.Finger, rng: np.random.Generator, size: int) -> np.ndarray:
    """Rollers that stick in their middle, friction 1."""
    load = drawn(tip, rng, size)
    return tip.read(ss.contact.PartialSlip(**load, half_width=rng.uniform(0.5, 1.2, size), friction=1.0))


_RUBBER = ss.Material(young=1.0)
_LAYER = ss.Layer(_RUBBER, thickness=2.0)
OTHERS: dict[str, tuple[Draw, str]] = {
    "narrow round, 0.1 to 0.4": (of(ss.Hertz, 0.1, 0.4), "vertex"),
    "narrow flat, 0.1 to 0.28": (of(ss.FlatPunch, 0.1, 0.28), "vertex"),
    "round at the edge, 0.4 to 0.5": (of(ss.Hertz, 0.4, 0.5), "round side"),
    "flat at the edge, 0.28 to 0.5": (of(ss.FlatPunch, 0.28, 0.5), "flat side"),
    "wide wedge, 0.49 to 0.8": (of(ss.Wedge, 0.49, 0.8), ""),
    "wide round, 1.2 to 2": (of(ss.Hertz, 1.2, 2.0), "round side"),
    "wide flat, 1.2 to 1.7": (of(ss.FlatPunch, 1.2, 1.7), "flat side"),
    "beyond the end, round, 2.4 to 3.5": (of(ss.Hertz, 2.4, 3.5), ""),
    "beyond the end, flat, 1.7 to 3.5": (of(ss.FlatPunch, 1.7, 3.5), ""),
    "even pressure, 0.5 to 1.5": (of(ss.Strip, 0.5, 1.5), ""),
    "tilted flat, 0.5 to 1.5": (tilted, ""),
    "sticks in its middle, friction 1": (sliding_middle, "round side"),
    "two lines, 0.5 to 3 apart": (lines(2), "two touches"),
    "three lines, 0.5 to 1.5 apart": (lines(3), ""),
    "bonded layer, 2 thick": (on(ss.Layered(_LAYER)), "line"),
    "skin of nu = 0.4": (on(ss.HalfPlane(ss.Material(young=1.0, poisson=0.4))), "line"),
    "a sensor stuck at nothing": (stuck, "round side"),
    "a sensor at 0.6 of its gain": (weak, "line"),
}


def noisy(readings: np.ndarray, tip: ss.Finger, rng: np.random.Generator) -> np.ndarray:
    """Readings with the sensors' noise."""
    return readings + np.asarray(tip.array.noise) * rng.standard_normal(readings.shape)


def asked(tip: ss.Finger, draw: Draw, name: str, frames: int, seed: int) -> dict[str, float | np.ndarray]:
    """How a batch of one sort of contact is answered."""
    rng = np.random.default_rng(seed)
    said = ss.decide.contact_type(tip, noisy(draw(tip, rng, frames), tip, rng), sure=SURE)
    share = np.nan_to_num(said.probability)
    named = np.array(said.names)[said.best]
    answered = said.best >= 0
    none = named == "none of these"
    own = answered & ((named == name) | (none if name not in KINDS or not name else False))
    top = share.max(-1)
    return {
        "wrong": float(((said.decision >= 0) & (named != name) & ~none).mean()),
        "unexplained": float((~answered).mean()),
        "none": float((none & (top >= SURE)).mean()),
        "own": float((own & (said.decision >= 0)).mean()),
        "best": float((answered & (named == name)).mean()),
        "top": top[answered],
        "right": (own | (none & (name in ("", "two touches"))))[answered],
        "names": named[(said.decision >= 0) & (named != name) & ~none],
    }


def main() -> None:
    """Run and print."""
    options = arguments(__doc__, frames=1000)
    rows = []
    cases = [(n, pitch, noise) for pitch in (0.5, 0.75) for n in (4, 6, 8) for noise in (1e-3, 1e-2)]
    for sensors, pitch, noise in cases:
        tip = finger(sensors, pitch, noise)
        half, other = [], []
        head = f"{sensors} sensors, {pitch} depth, {noise:.1%}"
        start, count = time.perf_counter(), 0
        for i, (name, (family, _, width)) in enumerate(KINDS.items()):
            got = asked(tip, of(family, *width), name, options.frames, 100 + i)
            half.append(got)
            rows.append([head, name, f"{got['wrong']:.1%}", "", f"{got['own']:.1%}", f"{got['none']:.1%}",
                         f"{got['unexplained']:.1%}", f"{got['best']:.1%}"])  # fmt: skip
        for i, (name, (draw, kind)) in enumerate(OTHERS.items()):
            got = asked(tip, draw, kind, options.frames, 200 + i)
            other.append(got)
            names, times = np.unique(got["names"], return_counts=True)
            most = names[times.argmax()] if times.size else ""
            rows.append([head, name, f"{got['wrong']:.1%}", most, f"{got['own']:.1%}", f"{got['none']:.1%}",
                         f"{got['unexplained']:.1%}", f"{got['best']:.1%}"])  # fmt: skip
            count += options.frames
        took = (time.perf_counter() - start) / (count + len(KINDS) * options.frames)
        rng = np.random.default_rng(0)
        pick = rng.permutation(len(OTHERS) * options.frames)[: len(KINDS) * options.frames]
        tops = [np.concatenate([g["top"] for g in part]) for part in (half, other)]
        rights = [np.concatenate([g["right"] for g in part]) for part in (half, other)]
        pick = pick[pick < tops[1].size]
        tops[1], rights[1] = tops[1][pick], rights[1][pick]
        error = calibration_error(np.concatenate(tops), np.concatenate(rights))
        named = calibration_error(tops[0], rights[0])
        best = np.mean([g["best"] for g in half])
        wrong = np.mean([g["wrong"] for g in other])
        sure = np.mean([g["own"] for g in half])
        rows.append([head, "ALL", f"{wrong:.1%}", "", f"{best:.2%}, {sure:.2%} named right, sure", f"ECE {error:.4f}",
                     f"of named {named:.4f}", f"{1e6 * took:.0f} us"])  # fmt: skip
    columns = ["finger", "contact", "sure and wrong", "mostly", "sure and right", "sure of none", "unexplained", "best"]
    show("Contacts that are none of the kinds", columns, rows, options.json)


if __name__ == "__main__":
    main()
