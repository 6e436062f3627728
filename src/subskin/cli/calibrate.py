"""`subskin calibrate`: touches at known places -> a finger with its own numbers."""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING, Any

from .blind import add_blind, refuse_blind_options, run_blind
from .common import add_rows, chosen_rows, describe, number, say, show, write_json

if TYPE_CHECKING:
    import numpy as np
    import numpy.typing as npt

    from ..calibration import Calibration, Score
    from ..io.finger_file import FingerFile

_EXAMPLES = """\
  subskin calibrate finger.toml presses.csv -o calibrated.toml --every 2
  subskin calibrate finger.toml presses.csv -o calibrated.toml --fit gain,depth,origin,position,poisson
  subskin calibrate calibrated.toml again.csv -o today.toml --fit origin --rows 10,30,50
  subskin calibrate --blind finger.toml readings.csv -o calibrated.toml --figure learnt.png
  subskin calibrate --blind finger.toml readings.csv -o calibrated.toml --gain-error "20 %" --position-error "0.1 mm"
"""
_NOTES = """\
Fits the finger to touches at known places, one a row, and writes the finger file with the fitted numbers in it;
comments stay. Rows that --every or --rows leaves out are held out, and scored. What can be fitted: gain, offset
(each sensor's), depth (all alike), depths (each sensor's), origin (where the row lies on the motor's axis), position
(each sensor's along the row), poisson, width (all alike), thickness (of a single layer, or of a round finger's skin).

With --blind, nothing is known of the touches but the readings, which are tared; what is fitted is known from the
drawing to within the errors given. What touches cannot tell, and how many would tell the rest, is said with the result.
"""


def add(parser: argparse.ArgumentParser) -> None:
    """Say what the command takes."""
    describe(parser, run, _EXAMPLES, _NOTES)
    parser.add_argument("finger", help="finger.toml as drawn, or as calibrated before")
    parser.add_argument("touches", help="table of touches, CSV or Parquet; - for standard input")
    parser.add_argument(
        "--fit", metavar="LIST", help="what to fit (gain,offset,depth,origin; gain,depth,position with --blind)"
    )
    parser.add_argument(
        "--position-column", metavar="NAME", default="position", help="column of positions [m] (position)"
    )
    parser.add_argument("--force-column", metavar="NAME", help="column of loads [N/m]; without it all are alike")
    parser.add_argument(
        "--angle-column", metavar="NAME", help="column of the loads' angles [rad]; without it they are 0"
    )
    add_rows(parser, "fit to")
    add_blind(parser)
    parser.add_argument("-o", "--out", metavar="FILE", help="the calibrated finger.toml; - for standard output")
    parser.add_argument("--json", action="store_true", help="print the result as JSON")


def run(options: argparse.Namespace) -> int:
    """Run the command."""
    import numpy as np

    if options.blind:
        return run_blind(options)
    refuse_blind_options(options)
    if options.fit is None:
        options.fit = "gain,offset,depth,origin"
    from ..calibration import calibrate
    from ..io.files import write_bytes
    from ..io.finger_file import load_finger
    from ..io.tables import read_table

    file = load_finger(options.finger)
    table = read_table(options.touches)
    readings = table.readings(file.names)
    loads = {
        name: table.numbers(column, finite=True, why=f"the touches' {name}")
        for name in ("force", "angle")
        if (column := getattr(options, f"{name}_column")) is not None
    }
    positions = table.numbers(options.position_column, finite=True, why="the touches' places")
    used = chosen_rows(options, len(table))
    fit = tuple(part.strip() for part in options.fit.split(",") if part.strip())
    found = calibrate(
        file.finger,
        readings[used],
        positions[used],
        fit=fit,
        origin=None if "origin" in fit else file.origin,
        **{name: values[used] for name, values in loads.items()},
    )
    held = ~used & np.isfinite(readings).any(axis=1)
    score = None
    if held.any():
        score = found.evaluate(readings[held], positions[held], **{name: v[held] for name, v in loads.items()})
    facts = _facts(options, file, found, score, fit)
    if options.out is not None:
        text = file.with_finger(found.finger, found.origin, facts).text
        write_bytes(options.out, text.encode())
    if options.json:
        write_json(_as_json(file, found, score))
    else:
        _show(options, file, found, score)
    return 0


def _facts(
    options: argparse.Namespace, file: FingerFile, found: Calibration, score: Score | None, fit: tuple[str, ...]
) -> dict[str, Any]:
    """What goes into [calibration] beside the origin."""
    from pathlib import Path

    from ..io.units import format_quantity

    facts: dict[str, Any] = {"source": Path(options.touches).name, "fit": list(fit), "touches": found.score.touches}
    facts["r2"] = float(found.r2)
    if score is not None:
        facts["r2_held_out"] = float(score.r2)
    for name in ("weak", "dead"):
        facts[name] = _sensors(file, found, name)
    std: dict[str, Any] = {}
    for parameter in found.parameters:
        error = float(f"{parameter.std:.3g}")
        value = format_quantity(error, parameter.unit) if parameter.unit else error
        if parameter.sensor is None:
            std[parameter.name] = value
        else:
            std.setdefault(parameter.name, {})[file.names[parameter.sensor]] = value
    return facts | {"std": std}


def _sensors(file: FingerFile, found: Calibration, health: str) -> list[str]:
    return [name for name, state in zip(file.names, found.health, strict=True) if state.name == health.upper()]


def _as_json(file: FingerFile, found: Calibration, score: Score | None) -> dict[str, Any]:
    parameters = [
        {
            "name": p.name,
            "sensor": None if p.sensor is None else file.names[p.sensor],
            "value": p.value,
            "std": p.std,
            "unit": p.unit,
        }
        for p in found.parameters
    ]
    return {
        "origin": found.origin,
        "parameters": parameters,
        "doubts": list(found.doubts),
        "touches": found.score.touches,
        "r2": found.r2,
        "held_out": None if score is None else score.touches,
        "r2_held_out": None if score is None else score.r2,
        "weak": _sensors(file, found, "weak"),
        "dead": _sensors(file, found, "dead"),
        "sensors": {
            name: {"state": state.name.lower(), "r2": found.score.r2_sensor[i], "residual": _noise(found)[i]}
            for i, (name, state) in enumerate(zip(file.names, found.health, strict=True))
        },
    }


def _noise(found: Calibration) -> npt.NDArray[np.float64]:
    import numpy as np

    return np.asarray(found.finger.array.noise, dtype=np.float64)


def _show(options: argparse.Namespace, file: FingerFile, found: Calibration, score: Score | None) -> None:
    out = say(options)
    rows = []
    for p in found.parameters:
        scale, unit = (1e3, "mm") if p.unit == "m" else (1.0, p.unit)
        where = "" if p.sensor is None else file.names[p.sensor]
        rows.append([p.name, where, number(p.value * scale, 6), number(p.std * scale, 2), unit])
    show(out, "parameters", ["name", "sensor", "value", "std. error", "unit"], rows, left=2)
    health = [
        [name, state.name.lower(), number(found.score.r2_sensor[i], 5), number(_noise(found)[i], 3)]
        for i, (name, state) in enumerate(zip(file.names, found.health, strict=True))
    ]
    show(out, "sensors", ["sensor", "state", "R^2", "residual"], health, left=2)
    print(f"R^2 {found.r2:.5f} on the {found.score.touches} touches used", file=out)
    if score is not None:
        print(f"R^2 {score.r2:.5f} on the {score.touches} held out", file=out)
    for name, what in (("weak", "below a fifth of the median gain"), ("dead", "left out from now on")):
        sensors = _sensors(file, found, name)
        if sensors:
            print(f"{name}: {', '.join(sensors)} ({what})", file=out)
    for doubt in found.doubts:
        print(doubt, file=out)
    if options.force_column is None and "gain" in options.fit:
        print("forces found with this finger are multiples of the touches' load (no --force-column)", file=out)
    if options.out not in (None, "-"):
        print(f"-> {options.out}", file=out)
