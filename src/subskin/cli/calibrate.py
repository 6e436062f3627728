"""`subskin calibrate`: touches at known positions -> a finger with its own numbers."""

from __future__ import annotations

import argparse
import dataclasses
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, TextIO

from .. import io
from .._lazy import np
from ..errors import ConvergenceError, InvalidValueError
from .blind import BLIND, errors_of, learnt, named, refuse_blind_options, run_blind, sensors_of, show_health
from .calibrate_more import CHOOSE, RESPONSE, choice_as_json, chosen, run_table, save_apart, show_choice
from .common import AREA_COLUMNS, forces_said, give, known_to, number, show, warn_of_depths
from .options import JSON, chosen_rows, command, listed, option, rows

if TYPE_CHECKING:
    import numpy.typing as npt

    from ..calibration import Calibration, Score
    from ..finger import Finger

_EXAMPLES = """\
  subskin calibrate finger.toml presses.csv -o calibrated.toml --every 2
  subskin calibrate finger.toml presses.csv -o calibrated.toml --fit gain,depth,origin,position,poisson
  subskin calibrate finger.toml presses.csv -o calibrated.toml --choose
  subskin calibrate calibrated.toml again.csv -o today.toml --fit origin --rows 10,30,50
  subskin calibrate area.toml touches.csv -o calibrated.toml --position-column y,z --force-column force
  subskin calibrate magnets.toml touches.csv -o calibrated.toml --response table --every 2
  subskin calibrate --blind finger.toml readings.csv -o calibrated.toml --figure learnt.png
  subskin calibrate --blind finger.toml readings.csv -o calibrated.toml --gain-error "20 %" --position-error "0.1 mm"
"""
_NOTES = """\
Fits the finger to touches at known positions, one in each row, and writes the finger file with the fitted numbers;
comments stay. Rows that --every or --rows leaves out are held out, and scored. --fit takes: gain, offset or lift (each
sensor's), depth (all alike), depths (each sensor's), origin (where the row lies on the motor's axis), position (each
sensor's along the row), poisson, width (all alike), thickness (of a single layer, or of a round finger's skin). A lift
is what a load adds to a reading wherever it presses. Presses that `segment` wrote have no offset: their lift is fitted.

On an area touches have two columns of positions, y and z, and forces are in N. There --fit also takes turn (how far the
finger's y is turned from the touches'), and no width. Where the field of the skin is not that of the touches, the
finger gets a response measured in place, in a file NAME.response.npz beside NAME.toml. --response table takes no field
at all: the response is made of the touches alone.

--choose fits a half plane (on an area a half space) and a layer, each with sensors of strain, stress and pressure. It
compares them by the positions of touches held out: how far off, how far at worst, and how many are OK.

Touches that the model cannot explain end with an error, and no finger is written unless --accept-misfit is given.

With --blind only the readings of the touches are known, of a row or of an area. They have to be tared. The drawing is
known to within the errors given. The result says what touches cannot determine, and how many touches would determine
the rest.
"""
_USUAL = "gain,offset,depth,origin"
_REFUSED = "check the kind of sensor, the skin, the positions and the loads (--force-column); or --accept-misfit"


@command(
    _EXAMPLES,
    option("finger", "finger.toml as drawn, or as calibrated before"),
    option("touches", "table of touches, CSV or Parquet; - for standard input"),
    option(
        "--fit LIST", "what to fit (gain,offset,depth,origin, on an area also turn; gain,depth,position with --blind)"
    ),
    option("--position-column NAME", "column of positions [m] (position); on an area two (position_y,position_z)"),
    option(
        "--load {line,point,either}", "what pressed on a row; either: what fits better ([locate], or as the skin says)"
    ),
    option("--force-column NAME", "column of loads [N/m], of points [N]; without it all loads are alike"),
    option("--angle-column NAME", "column of the loads' angles [rad]; without it they are 0"),
    option("--azimuth-column NAME", "on an area, column of where loads lean, from +y towards +z [rad]; or 0"),
    rows("fit to"),
    option("--accept-misfit", "write the finger even where its model cannot explain the touches"),
    CHOOSE,
    RESPONSE,
    BLIND,
    option("-o --out FILE", "the calibrated finger.toml; - for standard output"),
    JSON,
    notes=_NOTES,
)
def run_calibrate(options: argparse.Namespace) -> int:
    """Run the command."""
    if options.blind:
        return run_blind(options)
    refuse_blind_options(options)
    from ..calibration import calibrate

    file = io.load(options.finger)
    area = file.finger.array.on_area
    table = io.read_table(options.touches)
    file, readings = file.for_touches(table), table.readings(file.names)
    if options.force_column is None and file.recording is not None and file.recording.force is not None:
        options.force_column = "force"  # the recording has one, which `segment` keeps under this name
    loads = {
        name: table.numbers(column, finite=True, why=f"the touches' {name}")
        for name in ("force", "angle", "azimuth")
        if (column := getattr(options, f"{name}_column")) is not None
    }
    if "force" not in loads and file.one_force is not None:
        loads["force"] = file.one_force / np.cos(loads.get("angle", np.zeros(len(table))))
    if "force" not in loads:
        warn_of_depths(table, "[recording] force, or --force-column with the load of each press")
    positions = _positions(options.position_column, table, area)
    used = chosen_rows(options, len(table))
    if options.response == "table":
        return run_table(options, file, readings, positions, used, loads)
    fit = file.to_fit(listed(_USUAL + ",turn" * area if options.fit is None else options.fit))
    touches = (readings[used], positions[used])
    loaded = {name: values[used] for name, values in loads.items()}
    more: dict[str, Any] = {**errors_of(options, file, ()), **loaded}  # the error of gains: others are refused
    choice = None
    if options.choose:
        file, fit, choice = chosen(file, fit, *touches, **loaded)
    more |= {"origin": None if "origin" in fit else file.origin, "turn": file.turn, "load": options.load or file.load}
    found = calibrate(file.finger, *touches, fit=fit, accept_misfit=True, **more)  # said, and refused, below
    held = ~used & np.isfinite(readings).any(axis=1)
    score = None
    if held.any():
        score = found.evaluate(readings[held], positions[held], **{name: v[held] for name, v in loads.items()})
    facts: dict[str, Any] = {"source": Path(options.touches).name, "fit": list(fit), "touches": found.score.touches}
    facts["r2"] = float(found.r2)
    if not area:
        facts["load"] = found.load
    if score is not None:
        facts["r2_held_out"] = float(score.r2)
    facts |= learnt(file, found)
    refused = found.misfit.wrong and not options.accept_misfit
    warned = (*_spare(file, found), *found.doubts)

    def people(out: TextIO) -> None:
        if choice is not None:
            show_choice(out, choice)
        _show(out, file, found, score, warned)
        if "gain" in fit and (said := forces_said(file, loads, options.force_column)):
            print(said, file=out)

    def write(to: str) -> None:
        save_apart(options, io.with_calibration(file, found, facts), to)

    def as_json() -> dict[str, Any]:
        return _as_json(file, found, score, warned) | ({} if choice is None else {"choice": choice_as_json(choice)})

    give(options, as_json, people, {} if refused else {options.out: write})
    if refused:
        fix = _REFUSED
        try:
            calibrate(file.finger, *touches, fit=fit, **more)
        except ConvergenceError as wrong:  # channels in another order?
            fix = wrong.fix if "order" in wrong.fix else fix
        raise ConvergenceError("no finger is written", found.misfit.verdict, fix)
    return 0


def _positions(names: str | None, table: io.Table, area: bool) -> npt.NDArray[np.float64]:
    """Each touch's position, shape (m,), on an area (m, 2) [m]."""
    usual = AREA_COLUMNS if area else ("position",)
    columns = usual if names is None else listed(names)
    if len(columns) != len(usual):
        rule = "sensors on an area need two columns, y and z" if area else "a row needs one column"
        fix = f"--position-column {'y,z' if area else 'position'}"
        raise InvalidValueError(f'--position-column "{names}"', rule, fix)
    each = [table.numbers(name, finite=True, why="each touch's position") for name in columns]
    return np.stack(each, axis=-1) if area else each[0]


def _spare(file: io.FingerFile, found: Calibration) -> list[str]:
    """What is said of a finger of which frames can hardly be found to be no load."""
    spare, live = found.spare_readings(file.options.get("friction", 1.0)), int(found.finger.array.live.sum())
    if spare >= 2:
        return []
    left = "no spare reading" if spare <= 0 else f"{spare} spare reading"
    few = f"{live} live sensors leave a frame {left}, and at least 2 are wanted"
    return [f"{few}: `locate` can hardly notice that a frame is no single load"]


def _as_json(file: io.FingerFile, found: Calibration, score: Score | None, warned: Sequence[str]) -> dict[str, Any]:
    return {
        "origin": found.origin,
        "turn": found.turn,
        "parameters": [
            {"name": p.name, "sensor": named(file, p, missing=None), "value": p.value, "std": p.std, "unit": p.unit}
            for p in found.parameters
        ],
        "doubts": list(warned),
        "misfit": dataclasses.asdict(found.misfit) | {"wrong": found.misfit.wrong, "verdict": found.misfit.verdict},
        "spread": _spread_as_json(found.finger),
        "spread_held_out": list(found.held_out),
        "measured": found.finger.measured is not None,
        "spare": found.spare,
        "load": found.load,
        "touches": found.score.touches,
        "r2": found.r2,
        "held_out": None if score is None else score.touches,
        "r2_held_out": None if score is None else score.r2,
        "weak": sensors_of(file, found, "weak"),
        "dead": sensors_of(file, found, "dead"),
        "sensors": {
            name: {"state": state.name.lower(), "r2": found.score.r2_sensor[i], "residual": _noise(found)[i]}
            for i, (name, state) in enumerate(zip(file.names, found.health, strict=True))
        },
    }


def _spread_as_json(finger: Finger) -> dict[str, list[float]] | None:
    """`Finger.spread` by name."""
    return None if finger.spread is None else {k: v.tolist() for k, v in vars(finger.spread).items()}


def _noise(found: Calibration) -> npt.NDArray[np.float64]:
    return np.asarray(found.finger.array.noise, dtype=np.float64)


def _show(out: TextIO, file: io.FingerFile, found: Calibration, score: Score | None, warned: Sequence[str]) -> None:
    for text in warned:
        print(text, file=out)
    rows = []
    for p in found.parameters:
        scale, unit = (1e3, "mm") if p.unit == "m" else (1.0, p.unit)
        value, std = p.value * scale, p.std * scale
        rows.append([p.name, named(file, p), known_to(value, std), known_to(std, std), unit])
    show(out, "parameters", ["name", "sensor", "value", "std. error", "unit"], rows, left=2)
    health = [
        [name, state.name.lower(), number(found.score.r2_sensor[i], 5), number(_noise(found)[i], 3)]
        for i, (name, state) in enumerate(zip(file.names, found.health, strict=True))
    ]
    show(out, "sensors", ["sensor", "state", "R^2", "residual"], health, left=2)
    print(f"R^2 {found.r2:.5f} on the {found.score.touches} touches used", file=out)
    if score is not None:
        print(f"R^2 {score.r2:.5f} on the {score.touches} held out", file=out)
    print(found.misfit.verdict, file=out)
    if found.finger.measured is not None:
        told = f"; its standard errors rest on {found.held_out[0]} touches held out" if found.held_out[0] else ""
        print(f"the finger has a response in place, which allows for what the field misses{told}", file=out)
    for load, held in zip(("straight", "leaning"), found.held_out, strict=True):
        if found.finger.spread is not None and held:
            ratio = getattr(found.finger.spread, load)
            times = f"{ratio.min():.2g} to {ratio.max():.2g} times those of noise along the row"
            print(f"standard errors of {load} loads are {times}, by {held} positions of touches held out", file=out)
    show_health(out, file, found, "below half of the median gain")
