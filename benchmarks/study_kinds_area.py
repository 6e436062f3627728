"""`decide.contact_type` on an area: how right it is, and how often it is sure of a kind and wrong.

    python benchmarks/study_kinds_area.py [--frames 400] [--part kinds|edges] [--json FILE]

Grids of sensors at unit depth and pitch in a half space (nu = 1/2), unit forces, noise in shares of the reading of a
normal point load straight above; touches over the array, leaning within 40 degrees; the kinds, the search and the
friction are the usual ones. Lengths are in depths. A frame is sure and wrong where a kind that is not the contact's is
decided for (probability 0.95); "none of these" is never wrong here. The contact's kind follows the stated edges: what
is narrower than a sphere of 0.45 is a vertex, whatever the profile; what has the second moments of an edge as long and
as narrow as the kind, or longer, is an edge; an ellipse less than 1.4 times as long as wide is a round side, other
rectangles and ellipses are none. Named contacts have the half widths of the kinds. Calibration: the mean of
|confidence - accuracy| of the most probable kind; over all with as many frames of the named contacts as of all others,
right being the contact's own kind, or "none of these".

Edges, the second table: each length, in half lengths, has a third of the contacts at each of three half widths, in any
direction; readings are those of the closed form. "Direction" is the root mean square of its errors,
over all edges and, of standardised errors, over those of known direction (a standard error below 20 degrees); "hold" is
how many of these the 95 % interval holds. The errors are those of contacts whose most probable kind is the edge.
"""

from __future__ import annotations

import argparse
import itertools
import time
from collections.abc import Callable

import numpy as np

import subskin as ss
from _common import arguments, show
from bench_round import finger
from bench_shape import calibration_error

SURE = 0.95
LENGTHS, WIDTHS, NARROW = (0.6, 1.0, 1.5, 2.0), (0.0, 0.2, 0.4), 0.6 / 2**0.5
"""Of edges, in depths: half lengths and half widths of the second table, and the largest half width."""
Readings = np.ndarray
Draw = Callable[[ss.Finger, np.random.Generator, int], Readings | tuple[Readings, np.ndarray]]
"""Readings, and perhaps the name of each contact's kind."""


def drawn(tip: ss.Finger, rng: np.random.Generator, size: int) -> dict[str, np.ndarray]:
    """Unit forces over the array."""
    half = float(np.asarray(tip.array.y).max())
    angle, azimuth = rng.uniform(0, np.deg2rad(40), size), rng.uniform(-np.pi, np.pi, size)
    return {"force": np.ones(size), "angle": angle, "azimuth": azimuth, "position": rng.uniform(-half, half, (size, 2))}


def of(family: type, low: float = 0.0, high: float = 0.0, skin: ss.Skin | None = None, **more: object) -> Draw:
    """Contacts of a family, of half widths from low to high, perhaps on another skin than the finger's."""

    def draw(tip: ss.Finger, rng: np.random.Generator, size: int) -> np.ndarray:
        width = {"half_width": rng.uniform(low, high, size)} if high else {}
        own = tip if skin is None else ss.Finger(skin, tip.array)
        return own.read(family(**drawn(tip, rng, size), **width, **more))

    return draw


def patches(first: tuple[float, float], second: tuple[float, float] | None = None, family: type = ss.Patch) -> Draw:
    """Rectangles, or ellipses, of two half widths; squares if there is no second."""

    def draw(tip: ss.Finger, rng: np.random.Generator, size: int) -> tuple[Readings, np.ndarray]:
        one = rng.uniform(*first, size)
        widths = np.stack([one, one if second is None else rng.uniform(*second, size)], axis=-1)
        along, across = (np.sort(widths)[:, ::-1] ** 2 / (3 if family is ss.Patch else 5)).T
        edge = (3 * along > LENGTHS[0] ** 2) & (3 * across < NARROW**2)
        ball = (along < 2 * across) & (family is ss.EllipticHertz)
        name = np.where(edge, "edge", np.where(ball, "round side", ""))
        return tip.read(family(**drawn(tip, rng, size), half_widths=widths)), name

    return draw


def edges(length: tuple[float, float], width: tuple[float, float]) -> Draw:
    """Edges in any direction: narrow rectangles."""

    def draw(tip: ss.Finger, rng: np.random.Generator, size: int) -> Readings:
        return edges_and_turns(tip, rng, size, length, width)[0]

    return draw


def edges_and_turns(
    tip: ss.Finger, rng: np.random.Generator, size: int, length: tuple[float, float], width: tuple[float, float]
) -> tuple[Readings, np.ndarray]:
    """Readings of edges, and their directions."""
    load, turn = drawn(tip, rng, size), rng.uniform(0, np.pi, size)
    sides = np.stack([rng.uniform(*length, size), np.maximum(rng.uniform(*width, size), 1e-3)], axis=-1)
    return tip.read(ss.Patch(**load, half_widths=sides, turn=turn)), turn


def two(tip: ss.Finger, rng: np.random.Generator, size: int) -> np.ndarray:
    """Two points, 0.5 to 3 apart."""
    one = drawn(tip, rng, size) | {"force": rng.uniform(0.3, 1.0, size)}
    other = drawn(tip, rng, size) | {"force": rng.uniform(0.3, 1.0, size)}
    apart, turn = rng.uniform(0.5, 3.0, size), rng.uniform(-np.pi, np.pi, size)
    other["position"] = one["position"] + apart[:, None] * np.stack([np.cos(turn), np.sin(turn)], axis=-1)
    return tip.read(ss.PointLoad(**one)) + tip.read(ss.PointLoad(**other))


def sticks(tip: ss.Finger, rng: np.random.Generator, size: int) -> np.ndarray:
    """Spheres that stick in their middle, friction 1."""
    load, width = drawn(tip, rng, size), rng.uniform(0.45, 1.34, size)
    stick = width * np.cbrt(np.maximum(1 - np.tan(load["angle"]), 0.0))
    return tip.read(ss.RoundHertz(**load, half_width=width, stick=stick))


def faulty(gain: float) -> Draw:
    """Points, one sensor at another gain."""

    def draw(tip: ss.Finger, rng: np.random.Generator, size: int) -> np.ndarray:
        readings = np.array(of(ss.PointLoad)(tip, rng, size))
        readings[np.arange(size), rng.integers(0, len(tip.array), size)] *= gain
        return readings

    return draw


NAMED: dict[str, Draw] = {
    "point": of(ss.PointLoad),
    "vertex": of(ss.Cone, 0.1, 0.49),
    "flat side": of(ss.RoundPunch, 0.35, 1.04),
    "round side": of(ss.RoundHertz, 0.45, 1.34),
    "edge": edges((0.6, 2.0), (0.0, NARROW)),
}
_LAYER = ss.Layered(ss.Layer(ss.Material(young=1.0), thickness=2.0))
OTHERS: dict[str, tuple[Draw, str]] = {
    "narrow sphere, 0.1 to 0.45": (of(ss.RoundHertz, 0.1, 0.45), "vertex"),
    "narrow disc, 0.1 to 0.35": (of(ss.RoundPunch, 0.1, 0.35), "vertex"),
    "wide cone, 0.49 to 0.8": (of(ss.Cone, 0.49, 0.8), ""),
    "beyond the end, sphere, 1.34 to 1.9": (of(ss.RoundHertz, 1.34, 1.9), "round side"),
    "beyond the end, disc, 1.04 to 1.6": (of(ss.RoundPunch, 1.04, 1.6), "flat side"),
    "beyond the end, edge, 2 to 3": (edges((2.0, 3.0), (0.0, NARROW)), "edge"),
    "short edge, 0.3 to 0.6": (edges((0.3, 0.6), (0.0, 0.2)), ""),
    "even square, 0.3 to 1.2": (patches((0.3, 1.2)), ""),
    "oblong, 0.8 to 1.5 by 0.1 to 0.4": (patches((0.8, 1.5), (0.1, 0.4)), ""),
    "ellipse, 0.6 to 1.2 by 0.2 to 0.5": (patches((0.6, 1.2), (0.2, 0.5), ss.EllipticHertz), ""),
    "ellipse, 0.8 to 1.2 by 0.7 to 1": (patches((0.8, 1.2), (0.7, 1.0), ss.EllipticHertz), ""),
    "two points, 0.5 to 3 apart": (two, ""),
    "sticks in its middle, friction 1": (sticks, "round side"),
    "bonded layer, 2 thick": (of(ss.PointLoad, skin=_LAYER), "point"),
    "skin of nu = 0.4": (of(ss.PointLoad, skin=ss.HalfSpace(ss.Material(young=1.0, poisson=0.4))), "point"),
    "a sensor stuck at nothing": (faulty(0.0), "point"),
    "a sensor at 0.6 of its gain": (faulty(0.6), "point"),
}


def asked(tip: ss.Finger, draw: Draw, name: str, frames: int, seed: int) -> dict[str, float | np.ndarray]:
    """How a batch of one sort of contact is answered."""
    rng = np.random.default_rng(seed)
    got = draw(tip, rng, frames)
    readings, own_name = got if isinstance(got, tuple) else (got, np.full(frames, name))
    frames_read = readings + np.asarray(tip.array.noise) * rng.standard_normal(readings.shape)
    start = time.process_time()
    said = ss.decide.contact_type(tip, frames_read)
    took = (time.process_time() - start) / frames
    top, named = np.nan_to_num(said.probability).max(-1), np.array(said.names)[said.best]
    answered = said.best >= 0
    sure, none = said.decision >= 0, answered & (named == "none of these")
    own = answered & (named == own_name)
    wrong = sure & ~own & ~none
    names, times = np.unique(named[wrong], return_counts=True)
    return {
        "row": [
            f"{wrong.mean():.1%}", names[times.argmax()] if times.size else "", f"{(own & sure).mean():.1%}",
            f"{(none & sure).mean():.1%}", f"{(~answered).mean():.1%}", f"{own.mean():.1%}",
        ],
        "wrong": float(wrong.mean()), "sure": float((own & sure).mean()), "best": float(own.mean()),
        "took": took,
        "top": top[answered], "right": (own | (none & (own_name == "")))[answered],
    }  # fmt: skip


def kinds(options: argparse.Namespace) -> None:
    """The first table."""
    rows = []
    for kind, side, noise in (("pressure", 3, 1e-3), ("pressure", 4, 1e-3), ("pressure", 4, 1e-2), ("strain", 4, 1e-3)):
        tip = finger(side, noise, kind)
        head = f"{kind}, {side} x {side}, {noise:.1%}"
        ss.decide.contact_type(tip, tip.read(ss.PointLoad(force=1.0)))
        half = [asked(tip, draw, name, options.frames, 100 + i) for i, (name, draw) in enumerate(NAMED.items())]
        other = [asked(tip, *each, options.frames, 200 + i) for i, each in enumerate(OTHERS.values())]
        rows += [[head, name, *got["row"]] for name, got in zip([*NAMED, *OTHERS], half + other, strict=True)]
        tops, rights = ([np.concatenate([g[key] for g in part]) for part in (half, other)] for key in ("top", "right"))
        pick = np.random.default_rng(0).permutation(tops[1].size)[: tops[0].size]
        every = [np.concatenate([a, b[pick]]) for a, b in (tops, rights)]
        best, sure, took = (np.mean([g[key] for g in half]) for key in ("best", "sure", "took"))
        rows.append(
            [
                head, "ALL", f"{np.mean([g['wrong'] for g in other]):.1%}", "", f"{best:.1%}, {sure:.1%} sure",
                f"ECE {calibration_error(*every):.3f}", f"of named {calibration_error(tops[0], rights[0]):.3f}",
                f"{1e3 * took:.2f} ms",
            ]
        )  # fmt: skip
        print(rows[-1], flush=True)
    columns = ["finger", "contact", "sure and wrong", "mostly", "sure and right", "sure of none", "unexplained", "best"]
    show("kinds of contact on an area", columns, rows, options.json)


def directions(options: argparse.Namespace) -> None:
    """The second table."""
    rows = []
    for kind, side, noise in itertools.product(("pressure", "strain"), (4, 8), (1e-3, 1e-2)):
        tip = finger(side, noise, kind)
        size = np.asarray(tip.array.noise)
        for i, length in enumerate(LENGTHS):
            rng, found = np.random.default_rng(300 + i), []
            for width in WIDTHS:
                felt, turn = edges_and_turns(tip, rng, options.frames // 3, (length, length), (width, width))
                said = ss.decide.contact_type(tip, felt + size * rng.standard_normal(felt.shape))
                name = np.array([*said.names, ""])
                off = (said.direction - turn + np.pi / 2) % np.pi - np.pi / 2
                found.append([name[said.decision] == "edge", name[said.best] == "edge", off, said.direction_std])
            sure, best, off, std = np.concatenate(found, axis=1)
            known = (best == 1) & (std < np.deg2rad(20))
            off, ratio = np.rad2deg(off[best == 1]), (off / std)[known]
            rows.append(
                [
                    f"{kind}, {side} x {side}, {noise:.1%}", f"{length:g}", f"{sure.mean():.1%}", f"{best.mean():.1%}",
                    f"{np.median(np.abs(off)):.2f}", f"{np.sqrt((off**2).mean()):.2f}",
                    f"{np.sqrt((ratio**2).mean()):.2f}", f"{(np.abs(ratio) < 1.96).mean():.1%}",
                ]
            )  # fmt: skip
            print(rows[-1], flush=True)
    columns = ["finger", "half length", "sure", "best", "median [deg]", "rms [deg]", "over its error", "hold"]
    show("edges and their direction", columns, rows, options.json)


def main() -> None:
    """Run and print."""
    options = arguments(__doc__, frames=400, part="kinds")
    {"kinds": kinds, "edges": directions}[options.part](options)


if __name__ == "__main__":
    main()
