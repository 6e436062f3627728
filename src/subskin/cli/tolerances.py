"""`subskin tolerances`: what each tolerance of a finger costs in millimetres, degrees and force."""

from __future__ import annotations

import argparse
import math
from dataclasses import asdict
from typing import Any, TextIO

import numpy as np

from .. import design, io
from ..errors import InvalidValueError
from ..io.units import line_load, quantity
from .common import give, number, progress_bar, show
from .options import JSON, command, figure, group, listed, option, quantity_range

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
_SCALES = {"position": 1e3, "angle": math.degrees(1.0), "force": 100.0, "radius": 1e3}
_HEADS = {"position": "position [mm]", "angle": "angle [deg]", "force": "force [%]", "radius": "radius [mm]"}
_WON_BACK = "what self-calibration wins back: known, blind or both (both; on an area known)"
_NAMES = {"total": "root sum of squares", "together": "all at once"}


@command(
    _EXAMPLES,
    option("finger", "finger.toml"),
    option("--force F", 'force of the touches, "20 N/m"; on an area "1 N"', required=True),
    option("--friction MU", "friction of touches and search ([locate], or 1)", type=float),
    option("--span RANGE", 'span of the touches, "-5..5 mm" or "12 mm" (the row)'),
    option("--area SIDES", 'on an area: sides of what is touched, "8 mm, 6 mm"'),
    option("--half-width LENGTH", "on an area: radius of the touches, to be found as well"),
    group(
        "tolerances",
        "",
        *(option(f"--{name} X", text) for name, text in _HELP.items()),
        option("--only LIST", "these sources alone: position,gains"),
    ),
    option("--wanted-position LENGTH", "wanted rms error of the position: say how tight each tolerance has to be"),
    option("--wanted-angle ANGLE", "wanted rms error of the angle"),
    option("--calibrate KIND", _WON_BACK, nargs="?", const="both"),
    option("--fingers N", "fingers calibrated for each source (3)", 3),
    option("--draws N", "random fingers for each source (200)", 200),
    option("--seed N", "seed of the random numbers (0)", 0),
    figure("draw it"),
    JSON,
    notes=_NOTES,
)
def run_tolerances(options: argparse.Namespace) -> int:
    """Run the command."""
    file = io.load(options.finger)
    touches = _touches(options, file)
    amounts = _amounts(options, file)
    wanted = {name: _wanted(options, name, unit) for name, unit in (("position", "m"), ("angle", "rad"))}
    methods = listed(options.calibrate or "")
    if methods == ("both",):
        methods = ("known",) if file.finger.array.on_area else ("known", "blind")
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
    friction = file.options.get("friction", 1.0) if options.friction is None else options.friction
    array = file.finger.array
    for name in ("span",) if array.on_area else ("area", "half_width"):
        if getattr(options, name) is not None:
            where = "on an area" if array.on_area else "in a row"
            fix = '--area "8 mm, 6 mm"' if array.on_area else "--span"
            raise InvalidValueError(f"--{name.replace('_', '-')} of sensors {where}", "they have none", fix)
    if array.on_area:
        return design.Touches(quantity(options.force, "N", "--force"), friction, **_area(options, array.points))
    span = None
    if options.span is not None:
        low, high = quantity_range(options.span, "m", "--span")
        if low == high:  # a width, about the middle of the row
            y = np.asarray(array.y)
            middle, half = 0.5 * float(y.min() + y.max()), 0.5 * abs(low)
            low, high = middle - half, middle + half
        span = (low, high)
    return design.Touches(line_load(options.force, file.length, "--force"), friction, span)


def _area(options: argparse.Namespace, points: Any) -> dict[str, Any]:
    """What is touched on an area: about the middle of the sensors, or all from the first of them to the last."""
    low, high = points.min(axis=0), points.max(axis=0)
    if options.area is not None:
        sides = [quantity(side, "m", "--area") for side in listed(options.area)]
        if len(sides) not in (1, 2) or not min(sides) > 0:
            rule = "one side of a square, or the sides along y and z, each > 0, are needed"
            raise InvalidValueError(f'--area "{options.area}"', rule, '--area "8 mm, 6 mm"')
        middle, half = 0.5 * (low + high), 0.5 * np.array(sides) * np.ones(2)
        low, high = middle - half, middle + half
    wide = None if options.half_width is None else quantity(options.half_width, "m", "--half-width")
    return {"area": tuple(zip(low.tolist(), high.tolist(), strict=True)), "half_width": wide}


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
        "rows": [_row(row) for row in budget.rows],
        "total": _row(budget.total),
        "together": _row(budget.together),
        "needed": [asdict(row) for row in needed],
        "recovered": [_recovery(row) for row in budget.recovered],
        "quantile": budget.quantile,
        "draws": budget.draws,
    }


def _row(row: design.tolerance.Cost | None) -> dict[str, Any] | None:
    """A row; without the radius where touches have none."""
    if row is None:
        return None
    return {name: v for name, v in asdict(row).items() if not (name.startswith("radius") and v != v)}


def _recovery(row: design.tolerance.Recovery) -> dict[str, Any]:
    kinds = {kind: _row(getattr(row, kind)) for kind in ("drawn", "known", "blind")}
    return {"source": row.source, **kinds, "failed": dict(row.failed)}


def _show(out: TextIO, budget: design.tolerance.ToleranceBudget, needed: tuple[design.tolerance.Needed, ...]) -> None:
    told = _told(budget)
    columns = ["", "amount", *(head for name in told for head in (_HEADS[name], "worst")), "lost [%]"]
    rows = []
    for row in (*budget.rows, budget.total, budget.together):
        errors = [_SCALES[name] * getattr(row, f"{name}_{kind}") for name in told for kind in ("rms", "worst")]
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
    told = _told(budget)
    for name in told:
        columns += [f"{_HEADS[name]} {kinds[0]}", *kinds[1:]]
    rows = []
    for r in budget.recovered:
        cells = [
            "-" if dict(r.failed).get(kind, 0) else _small(_SCALES[name] * getattr(getattr(r, kind), f"{name}_rms"))
            for name in told
            for kind in kinds
        ]
        rows.append([_named(r.source), *cells])
    show(out, "rms errors as drawn, and after self-calibration", columns, rows)
    for r in budget.recovered:
        for kind, count in r.failed:
            if count:
                print(f"{_named(r.source)}: {count} calibrations ({kind}) did not settle", file=out)


def _told(budget: design.tolerance.ToleranceBudget) -> list[str]:
    """What the tables show: a radius where touches have one."""
    return [name for name in _SCALES if name != "radius" or budget.touches.half_width is not None]


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
