"""`subskin calibrate --blind`: touches of which only the readings are known -> a finger with its own numbers."""

from __future__ import annotations

import argparse
import re
from pathlib import Path
from typing import TYPE_CHECKING, Any, TextIO

from .. import io
from .._lazy import np
from ..errors import FileError, InvalidValueError
from ..io.files import check_target, write_bytes
from ..io.units import quantity
from .common import give, known_to, number, show
from .options import chosen_rows, figure, group, listed, option

if TYPE_CHECKING:
    from ..calibration import BlindCalibration, BlindParameter, Calibration, Parameter

__all__ = ["BLIND", "errors_of", "learnt", "named", "refuse_blind_options", "run_blind", "sensors_of", "show_health"]

_ERRORS = {
    "gain": "of each gain (5 %%; without --blind 25 %%)",
    "depth": "of the depth, a share or a length (5 %%)",
    "position": "of each position, a share of the depth or a length (2 %%)",
    "poisson": "of Poisson's ratio; needed to fit it",
    "thickness": "of the skin beneath the deepest sensor, a share or a length; needed to fit it",
    "offset": "of each offset, in readings; needed to fit it",
}
_NEEDED = {"poisson": "0.02", "thickness": '"10 %"', "offset": "10"}
_WANTED = 1.3
_SAID = {"LEARNT": "learnt", "PARTLY": "partly", "AS_DRAWN": "as drawn"}
_LABELLED = ("load", "position_column", "force_column", "angle_column", "azimuth_column")


BLIND = group(
    "without knowing the touches",
    "",
    option("--blind", "calibrate from the readings alone"),
    *(option(f"--{name}-error X", f"standard deviation {text}") for name, text in _ERRORS.items()),
    option("--half-width X", "half width of every touch, a Hertz contact (0: a line, on an area a point)"),
    figure("draw what was learnt"),
)


def refuse_blind_options(options: argparse.Namespace) -> None:
    """Raise where an option of --blind is given without it.

    Raises
    ------
    InvalidValueError
        Such an option.
    """
    for name in (*(f"{error}_error" for error in _ERRORS if error != "gain"), "half_width", "figure"):
        if getattr(options, name) is not None:
            raise InvalidValueError(f"--{name.replace('_', '-')}", "it goes with --blind", "add --blind")


def run_blind(options: argparse.Namespace) -> int:
    """Run the command."""
    from ..calibration import calibrate_blind

    for name in _LABELLED:
        if getattr(options, name) is not None:
            rule = "with --blind positions, forces and angles of the touches are unknown"
            raise InvalidValueError(f"--{name.replace('_', '-')}", rule, "leave it out")
    for name, usual in (("choose", False), ("accept_misfit", False), ("response", "field")):
        if getattr(options, name) != usual:
            rule = "it goes with touches at known positions"
            raise InvalidValueError(f"--{name.replace('_', '-')}", rule, "leave it or --blind out")
    if options.out not in (None, "-"):
        check_target(options.out)
    file, table = io.load(options.finger), io.read_table(options.touches)
    file = file.for_touches(table)
    readings = table.readings(file.names)[chosen_rows(options, len(table))]
    fit = listed(options.fit or "gain,depth,position")
    if file.differences and "offset" in fit:
        rule = "presses that `segment` wrote are less the free skin's reading, and have none"
        raise InvalidValueError("--fit offset", rule, "leave it out")
    errors = errors_of(options, file, fit)
    touch = {k: v for k, v in file.options.items() if k == "friction"}
    if options.half_width is not None:
        touch["half_width"] = quantity(options.half_width, "m", "--half-width")
    silent = np.asarray(file.finger.array.noise) == 0
    if (silent & file.finger.array.live).any():
        seen = f"{options.finger}: a sensor without noise"
        raise FileError(seen, "touches are weighed by it", 'noise = "10 Pa" in [sensors]')
    found = calibrate_blind(file.finger, readings, fit=fit, search=file.search, **errors, **touch)
    facts: dict[str, Any] = {"source": Path(options.touches).name, "blind": True, "fit": list(fit)}
    facts |= {"touches": int(found.used.sum()), "misfit": float(found.misfit)}
    facts |= learnt(file, found)

    def written() -> str:
        return file.with_finger(found.finger, file.origin, facts, turn=file.turn).text

    return give(
        options,
        lambda: _as_json(file, found),
        lambda out: _show(out, file, found),
        {options.out: lambda to: write_bytes(to, written().encode())},
        lambda plot: plot.blind_figure(found, file.names),
    )


def learnt(file: io.FingerFile, found: Calibration | BlindCalibration) -> dict[str, Any]:
    """What [calibration] says of the sensors, and how well each number is known."""
    std: dict[str, Any] = {}
    for p in found.parameters:
        error = float(f"{p.std:.3g}")
        value = io.format_quantity(error, p.unit) if p.unit else error
        if p.sensor is None:
            std[p.name] = value
        else:
            std.setdefault(p.name, {})[file.names[p.sensor]] = value
    return {name: sensors_of(file, found, name) for name in ("weak", "dead")} | {"std": std}


def sensors_of(file: io.FingerFile, found: Calibration | BlindCalibration, health: str) -> list[str]:
    """Names of the sensors that are weak, or dead."""
    return [name for name, state in zip(file.names, found.health, strict=True) if state.name == health.upper()]


def named(file: io.FingerFile, p: BlindParameter | Parameter, missing: Any = "") -> Any:
    """The sensor of a fitted number, or `missing` where it is of all."""
    return missing if p.sensor is None else file.names[p.sensor]


def show_health(out: TextIO, file: io.FingerFile, found: Calibration | BlindCalibration, weak: str) -> None:
    """Sensors that are weak or dead."""
    for name, what in (("weak", weak), ("dead", "left out from now on")):
        sensors = sensors_of(file, found, name)
        if sensors:
            print(f"{name}: {', '.join(sensors)} ({what})", file=out)


def errors_of(options: argparse.Namespace, file: io.FingerFile, fit: tuple[str, ...]) -> dict[str, float]:
    """The errors given, as `calibrate_blind` takes them."""
    depths = np.asarray(file.finger.array.depth)
    below = file.finger.skin.thickness - float(depths.max())
    lengths = {"depth": float(depths.mean()), "position": float(depths.mean()), "thickness": below}
    given = {}
    for name in _ERRORS:
        text, option = getattr(options, f"{name}_error"), f"--{name}-error"
        if text is None:
            if name in fit and name in _NEEDED:
                rule = "it has to be known how far the drawing can be off"
                raise InvalidValueError(f"--fit {name} without {option}", rule, f"{option} {_NEEDED[name]}")
            continue
        share = re.fullmatch(r"\s*[-+.\deE]+\s*%?\s*", text)
        if share or name not in lengths:
            value = quantity(text, "", option)
        else:
            value = quantity(text, "m", option) / lengths[name]
        if not value > 0:
            raise InvalidValueError(f"{option} {text}", "has to be > 0", f"leave {name} out of --fit")
        given[f"{name}_error"] = value
    return given


def _half(found: BlindCalibration, index: int) -> float:
    """How many touches leave half of the standard deviation there is."""
    return found.touches_for(index, 0.5 * found.parameters[index].std)


def _as_json(file: io.FingerFile, found: BlindCalibration) -> dict[str, Any]:
    parameters = [
        {
            "name": p.name,
            "sensor": named(file, p, missing=None),
            **{name: getattr(p, name) for name in ("drawn", "prior", "value", "std", "limit", "unit")},
            "known": p.known.name.lower(),
            "touches_for_half": _half(found, i),
        }
        for i, p in enumerate(found.parameters)
    ]
    ratio = found.error_ratio()
    return {
        "parameters": parameters,
        "rank": found.rank,
        "unknown": list(found.unknown),
        "doubts": list(found.doubts),
        "touches": len(found.used),
        "used": int(found.used.sum()),
        "left_out": _left_out(found),
        "misfit": found.misfit,
        "error_ratio": {"position": ratio.position, "angle": ratio.angle},
        "touches_for_1.3": found.touches_for_ratio(1.3),
        "weak": sensors_of(file, found, "weak"),
        "dead": sensors_of(file, found, "dead"),
    }


def _left_out(found: BlindCalibration) -> dict[str, int]:
    from ..estimate.answer import Status

    states = found.touches.status[~found.used]
    counts = np.bincount(states.astype(np.intp), minlength=len(Status))
    return {s.name.lower(): int(counts[s]) for s in Status if counts[s]}


def _show(out: TextIO, file: io.FingerFile, found: BlindCalibration) -> None:
    rows = [[p.name, named(file, p), *_cells(p), _touches(_half(found, i))] for i, p in enumerate(found.parameters)]
    heads = ["drawn", "give or take", "found", "give or take", "at best", "unit", "", "touches for half"]
    show(out, "parameters", ["name", "sensor", *heads], rows, left=2)
    left = ", ".join(f"{count} {name.replace('_', ' ')}" for name, count in _left_out(found).items())
    print(f"{int(found.used.sum())} of {len(found.used)} touches used" + (f"; left out: {left}" * bool(left)), file=out)
    ratio = found.error_ratio()
    angle = "" if ratio.angle != ratio.angle else f" and of angles {ratio.angle:.2f}"
    print(f"errors of positions {ratio.position:.2f}{angle} times those of a finger known exactly", file=out)
    if max(ratio.position, ratio.angle if ratio.angle == ratio.angle else 1.0) > _WANTED:
        print(f"{_WANTED} times: with {_touches(found.touches_for_ratio(_WANTED))} touches like those used", file=out)
    print(f"touches like these determine {found.rank} of {len(found.parameters)} numbers or combinations", file=out)
    for text in found.unknown:
        print(f"no touches determine {text}", file=out)
    show_health(out, file, found, "gain below half of the drawn gain, relative to the median sensor")
    for doubt in found.doubts:
        print(doubt, file=out)


def _cells(p: BlindParameter) -> list[str]:
    scale, unit = (1e3, "mm") if p.unit == "m" else (1.0, p.unit)
    values = [number(p.drawn * scale, 5), number(p.prior * scale, 2), known_to(p.value * scale, p.std * scale)]
    best = "0" if p.limit < 1e-6 * p.prior else number(p.limit * scale, 2)
    return [*values, known_to(p.std * scale, p.std * scale), best, unit, _SAID[p.known.name]]


def _touches(count: float) -> str:
    return "never" if count == float("inf") else f"{float(f'{count:.2g}'):,.0f}"
