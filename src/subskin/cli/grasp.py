"""`subskin grasp`: lifts of things of unknown weight and friction, in simulation."""

from __future__ import annotations

import argparse
from concurrent.futures import ProcessPoolExecutor
from dataclasses import replace
from typing import Any, TextIO

import numpy as np

from .. import io
from ..errors import InvalidValueError
from ..io.units import quantity
from ..mujoco.installed import engine
from .common import give, number, progress_bar, show
from .options import JSON, command, figure, listed, option

_EXAMPLES = """\
  subskin grasp
  subskin grasp --lifts 100 --seed 7 --hands skin,force,cone,fixed -o lifts.csv
  subskin grasp --lifts 20 --finger pad.toml --off "5 mm" --figure lift.png --movie lift.gif
"""
_NOTES = """\
Boxes, bottles, balls and eggs of 45 to 600 g and a friction of 0.4 to 0.9 are gripped, lifted, shaken, filled by half
their weight, and put down. The hand "skin" knows what its skins tell; "force" is told the true forces; "cone" is told
the true friction too; "fixed" grips with one force. It needs MuJoCo: pip install "subskin[mujoco]".
"""
_HEADS = {
    "dropped": "dropped", "slid_2mm": "slid <= 2 mm [%]", "slid": "slid [mm]", "slid_95": "19 in 20 [mm]",
    "grip": "grip / least", "friction": "friction learnt / true", "real_time": "x real time", "slowest": "p99 [ms]",
}  # fmt: skip
_SCALES = {"slid_2mm": 100.0, "slid": 1e3, "slid_95": 1e3, "slowest": 1e3}


@command(
    _EXAMPLES,
    option("--lifts N", "how many (20)", 20),
    option("--seed N", "which things (0)", 0),
    option("--hands LIST", "skin, force, cone, fixed (skin)", "skin"),
    option("--finger FILE", "finger.toml of both pads, 16 mm square (4 x 4 magnets read along 3 axes)"),
    option("--off LENGTH", "how far from its middle a thing is gripped", "0 mm"),
    option("--grip FORCE", "of the fixed grip", "13.8 N"),
    option("--workers N", "processes; the speeds are right with one (1)", 1),
    option("-o --out FILE", "a row for each lift; CSV, or Parquet for .parquet"),
    figure("draw the first lift over time"),
    option("--movie FILE", "film of the first lift (.gif)"),
    JSON,
    notes=_NOTES,
)
def run_grasp(options: argparse.Namespace) -> int:
    """Run the command."""
    from .. import grasp

    finger = None if options.finger is None else io.load(options.finger).finger
    hands = listed(options.hands)
    if not hands or not set(hands) <= set(grasp.HANDS):
        raise InvalidValueError(f'--hands "{options.hands}"', f"any of {', '.join(grasp.HANDS)}", "--hands skin,fixed")
    if not 1 <= options.lifts <= 10**5:
        raise InvalidValueError(f"--lifts {options.lifts}", "1 to 100000", "--lifts 100")
    for name, least in (("seed", 0), ("workers", 1)):
        if getattr(options, name) < least:
            seen, rule = f"--{name} {getattr(options, name)}", f"has to be >= {least}"
            raise InvalidValueError(seen, rule, f"--{name} {least}")
    if options.movie is not None and not options.movie.lower().endswith(".gif"):
        raise InvalidValueError(f"--movie {options.movie}", "a film is written as .gif", "--movie lift.gif")
    try:
        engine()
    except ModuleNotFoundError:
        rule, fix = "it needs mujoco, which is not installed", 'pip install "subskin[mujoco]"'
        raise InvalidValueError("subskin grasp", rule, fix) from None
    off, grip = quantity(options.off, "m", "--off"), quantity(options.grip, "N", "--grip")
    things = [replace(thing, off=off) for thing in grasp.things(options.lifts, options.seed)]
    found: dict[str, Any] = {}
    with progress_bar("lifts", len(hands) * len(things)) as advance:
        for name in hands:
            if options.workers > 1:
                with ProcessPoolExecutor(options.workers) as pool:
                    found[name] = grasp.lifts(things, name, finger, grip=grip, executor=pool, progress=advance)
            else:
                found[name] = grasp.lifts(things, name, finger, grip=grip, progress=advance)
    sums = {name: grasp.summary(lifted) for name, lifted in found.items()}
    if options.movie is not None:
        from .. import plot

        plot.lift_movie(things[0], grasp.hand_of(hands[0], finger, grip=grip), options.movie)

    def people(out: TextIO) -> None:
        rows = [[n, *(number(_SCALES.get(k, 1.0) * s[k], 3) for k in _HEADS)] for n, s in sums.items()]
        show(out, f"{len(things)} lifts", ["hand", *_HEADS.values()], rows)

    files = {options.out: lambda path: io.write_table(path, _table(found))}
    if options.movie is not None:
        files[options.movie] = lambda _path: None
    return give(options, lambda: {"hands": sums}, people, files, lambda plot: plot.lift_figure(found[hands[0]][0]))


def _table(found: dict[str, Any]) -> dict[str, Any]:
    every = [(name, i, lifted) for name, lifts in found.items() for i, lifted in enumerate(lifts)]
    columns: dict[str, Any] = {"hand": [name for name, _, _ in every], "number": [i for _, i, _ in every]}
    columns |= {key: [getattr(each.thing, key) for *_, each in every] for key in ("shape", "mass", "friction")}
    sizes = np.array([np.asarray(each.thing.size) for *_, each in every])
    columns |= {f"half_{axis}": sizes[:, i] for i, axis in enumerate("xyz")}
    columns |= {"dropped": [int(each.dropped) for *_, each in every]}
    names = {"slid": "slid", "waste": "grip_over_least", "friction": "friction_learnt", "seconds": "seconds"}
    return columns | {name: [getattr(each, key) for *_, each in every] for key, name in names.items()}
