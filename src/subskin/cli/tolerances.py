"""`subskin tolerances`: what each tolerance of a finger costs in millimetres, degrees and force."""

from __future__ import annotations

import argparse
import math
from dataclasses import asdict
from typing import Any, TextIO

from .. import design, io
from ..errors import InvalidValueError
from ..io.units import line_load, quantity
from .common import (
    add_figure,
    add_json,
    check_figure,
    describe,
    give,
    listed,
    number,
    progress_bar,
    quantity_range,
    show,
)

_EXAMPLES = """\
  subskin tolerances finger.toml --force "20 N/m"
  subskin tolerances finger.toml --force "20 N/m" --friction 0.8 --depth "0.05 mm" --gains "3 %" --poisson 0.05
  subskin tolerances finger.toml --force "20 N/m" --wanted-position "0.1 mm" --wanted-angle "2 deg"
  subskin tolerances finger.toml --force "20 N/m" --only position,gains --calibrate blind --figure tolerances.png
"""
_NOTES = """\
The finger as drawn locates readings of fingers that are off by one source each. An amount is a standard deviation,
except for --width (how much wider the sensors are than drawn) and --resolution (the step of a reading). An amount of 0
leaves a source out. The defaults are 2 % of the depth for positions and for each depth, 5 % for the depth of all and
for gains, 10 % for Young's modulus, 0.02 for Poisson's ratio.
"""
_HELP = {
    "position": "each sensor's position along the row",
    "depth": "depth of all sensors",
    "depths": "each sensor's depth",
    "young": "Young's modulus, a share",
    "poisson": "Poisson's ratio",
    "gain": "gain of all sensors, a share",
    "gains": "each sensor's gain, a share",
    "offset": "each sensor's offset, in readings",
    "width": "how much wider sensors are than drawn",
    "thickness": "thickness of the skin",
    "radius": "radius of a round finger",
    "resolution": "step of the readings",
    "noise": "noise of the readings",
}
_SCALES = {"position": 1e3, "angle": math.degrees(1.0), "force": 100.0}
_NAMES = {"total": "root sum of squares", "together": "all at once"}


def add(parser: argparse.ArgumentParser) -> None:
    """Say what the command takes."""
    describe(parser, run, _EXAMPLES, _NOTES)
    parser.add_argument("finger", help="finger.toml")
    parser.add_argument("--force", metavar="F", required=True, help='force of the touches, "20 N/m"')
    parser.add_argument("--friction", type=float, metavar="MU", help="friction of touches and search ([locate], or 1)")
    parser.add_argument("--span", metavar="RANGE", help='span of the touches, "-5..5 mm" or "12 mm" (the row)')
    group = parser.add_argument_group("tolerances")
    for name, text in _HELP.items():
        group.add_argument(f"--{name}", metavar="X", help=text)
    group.add_argument("--only", metavar="LIST", help="these sources alone: position,gains")
    parser.add_argument(
        "--wanted-position",
        metavar="LENGTH",
        help="wanted rms error of the position: say how tight each tolerance has to be",
    )
    parser.add_argument("--wanted-angle", metavar="ANGLE", help="wanted rms error of the angle")
    parser.add_argument(
        "--calibrate",
        metavar="KIND",
        nargs="?",
        const="known,blind",
        help="what self-calibration wins back: known, blind or both (both)",
    )
    parser.add_argument("--fingers", type=int, default=3, metavar="N", help="fingers calibrated for each source (3)")
    parser.add_argument("--draws", type=int, default=200, metavar="N", help="random fingers for each source (200)")
    parser.add_argument("--seed", type=int, default=0, metavar="N", help="seed of the random numbers (0)")
    add_figure(parser, "draw it")
    add_json(parser)


def run(options: argparse.Namespace) -> int:
    """Run the command."""
    check_figure(options.figure)
    file = io.load(options.finger)
    touches = _touches(options, file)
    amounts = _amounts(options, file)
    wanted = {name: _wanted(options, name, unit) for name, unit in (("position", "m"), ("angle", "rad"))}
    methods = listed(options.calibrate or "")
    off = sum(amount > 0 and design.tolerance.SOURCES[name].spread != "reading" for name, amount in amounts.items())
    steps = sum(amount > 0 for amount in amounts.values()) + 1
    steps += len(methods) * options.fingers * (off + 1 if off else 0)
    with progress_bar("sources", steps) as advance:
        how = {"draws": options.draws, "rng": options.seed, "progress": advance}
        how |= {"self_calibration": methods, "calibration_draws": options.fingers}
        budget = design.tolerance_budget(file.finger, touches, amounts, search=file.search, **how)
    needed = budget.needed(wanted["position"], wanted["angle"]) if any(wanted.values()) else ()
    return give(
        options,
        lambda: _as_json(budget, needed) | {"seed": options.seed},
        lambda out: _show(out, budget, needed),
        figure=lambda plot: plot.tolerance_figure(budget, **wanted),
    )


def _wanted(options: argparse.Namespace, name: str, unit: str) -> float | None:
    """A wanted accuracy, refused before the work begins."""
    text = getattr(options, f"wanted_{name}")
    if text is None:
        return None
    value = quantity(text, unit, f"--wanted-{name}")
    if not value > 0:
        raise InvalidValueError(
            f"--wanted-{name} {text}",
            f"has to be > 0 [{unit}]",
            f"--wanted-{name} " + ('"0.1 mm"' if unit == "m" else '"2 deg"'),
        )
    return value


def _touches(options: argparse.Namespace, file: io.FingerFile) -> design.Touches:
    import numpy as np

    friction = file.options.get("friction", 1.0) if options.friction is None else options.friction
    span = None
    if options.span is not None:
        low, high = quantity_range(options.span, "m", "--span")
        if low == high:  # a width, about the middle of the row
            y = np.asarray(file.finger.array.y)
            middle, half = 0.5 * float(y.min() + y.max()), 0.5 * abs(low)
            low, high = middle - half, middle + half
        span = (low, high)
    return design.Touches(line_load(options.force, file.length, "--force"), friction, span)


def _amounts(options: argparse.Namespace, file: io.FingerFile) -> dict[str, float]:
    amounts, sources = design.usual_tolerances(file.finger), design.tolerance.SOURCES
    for name in _HELP:
        text = getattr(options, name)
        if text is not None:
            amounts[name] = quantity(text, "m" if sources[name].unit == "m" else "", f"--{name}")
    if options.only is None:
        return amounts
    chosen = listed(options.only)
    for name in chosen:
        if name not in amounts:
            fix = f"--{name} says how large it is" if name in sources else ""
            raise InvalidValueError(f"--only {name}", f"there are {', '.join(amounts)}", fix)
    return {name: amounts[name] for name in chosen}


def _as_json(budget: design.tolerance.ToleranceBudget, needed: tuple[design.tolerance.Needed, ...]) -> dict[str, Any]:
    return {
        "rows": [asdict(row) for row in budget.rows],
        "total": asdict(budget.total),
        "together": asdict(budget.together),
        "needed": [asdict(row) for row in needed],
        "recovered": [asdict(row) | {"failed": dict(row.failed)} for row in budget.recovered],
        "quantile": budget.quantile,
        "draws": budget.draws,
    }


def _show(out: TextIO, budget: design.tolerance.ToleranceBudget, needed: tuple[design.tolerance.Needed, ...]) -> None:
    columns = ["", "amount", "position [mm]", "worst", "angle [deg]", "worst", "force [%]", "worst", "lost [%]"]
    rows = []
    for row in (*budget.rows, budget.total, budget.together):
        errors = [
            scale * getattr(row, f"{name}_{kind}") for name, scale in _SCALES.items() for kind in ("rms", "worst")
        ]
        cells = [_small(e) for e in errors] + [number(100 * row.lost, 3)]
        rows.append([_named(row.source), _amount(row.amount, row), *cells])
    title = f"rms errors, and at the worst touch what {100 * budget.quantile:g} % of the fingers stay within"
    show(out, title, columns, rows)
    print("lost: share of touches that are no longer OK: ambiguous, or no load explains them", file=out)
    if needed:
        rows = [[_named(n.source), *(_amount(a, n) for a in (n.amount, n.alone, n.shared))] for n in needed]
        show(out, "how tight each has to be", ["", "given", "by itself", "beside the others"], rows)
    if budget.recovered:
        _show_recovered(out, budget)


def _show_recovered(out: TextIO, budget: design.tolerance.ToleranceBudget) -> None:
    kinds = [kind for kind in ("drawn", "known", "blind") if getattr(budget.recovered[0], kind) is not None]
    columns = [""]
    for what in ("position [mm]", "angle [deg]", "force [%]"):
        columns += [f"{what} {kinds[0]}", *kinds[1:]]
    rows = []
    for r in budget.recovered:
        cells = [
            "-" if dict(r.failed).get(kind, 0) else _small(scale * getattr(getattr(r, kind), f"{name}_rms"))
            for name, scale in _SCALES.items()
            for kind in kinds
        ]
        rows.append([_named(r.source), *cells])
    show(out, "rms errors as drawn, and after self-calibration", columns, rows)
    for r in budget.recovered:
        for kind, count in r.failed:
            if count:
                print(f"{_named(r.source)}: {count} calibrations ({kind}) did not settle", file=out)


def _named(source: str) -> str:
    """A source in words, with the name of its option where the words are not that."""
    if source in _NAMES:
        return _NAMES[source]
    text = design.tolerance.SOURCES[source].text
    return text if text == source else f"{source}: {text}"


def _small(value: float) -> str:
    """A number of three digits; 0 for what rounding leaves."""
    return "0" if abs(value) < 1e-6 else number(value, 3)


def _amount(value: float, row: design.tolerance.Cost | design.tolerance.Needed) -> str:
    """An amount with its unit; one that need not be tight is any."""
    if value == float("inf"):
        return "any"
    if row.unit == "m":
        return f"{number(1e3 * value, 3)} mm"
    if row.unit or row.source not in design.tolerance.SOURCES or row.source == "poisson":
        return number(value, 3)
    return f"{number(100 * value, 3)} %"
