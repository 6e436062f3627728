"""`subskin calibrate --blind`: touches of which only the readings are known -> a finger with its own numbers."""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING, Any

from .common import check_figure, chosen_rows, number, say, show, write_json

if TYPE_CHECKING:
    from ..calibration import BlindCalibration, BlindParameter
    from ..io.finger_file import FingerFile

__all__ = ["add_blind", "refuse_blind_options", "run_blind"]

_ERRORS = {
    "gain": "of each gain (5 %%)",
    "depth": "of the depth, a share or a length (5 %%)",
    "position": "of each place, a share of the depth or a length (2 %%)",
    "poisson": "of Poisson's ratio; needed to fit it",
    "thickness": "of what lies beneath the deepest sensor, a share or a length; needed to fit it",
    "offset": "of each offset, in readings; needed to fit it",
}
_NEEDED = {"poisson": "0.02", "thickness": '"10 %"', "offset": "10"}
_WANTED = 1.3
_SAID = {"LEARNT": "learnt", "PARTLY": "partly", "AS_DRAWN": "as drawn"}
_LABELLED = ("force_column", "angle_column")


def add_blind(parser: argparse.ArgumentParser) -> None:
    """--blind and what goes with it."""
    group = parser.add_argument_group("without knowing the touches")
    group.add_argument("--blind", action="store_true", help="from the readings alone")
    for name, text in _ERRORS.items():
        group.add_argument(f"--{name}-error", metavar="X", help=f"standard deviation {text}")
    group.add_argument("--figure", metavar="FILE", help="draw what was learnt (.svg, .png or .pdf)")


def refuse_blind_options(options: argparse.Namespace) -> None:
    """Raise where an option of --blind is given without it.

    Raises
    ------
    InvalidValueError
        Such an option.
    """
    from ..errors import InvalidValueError

    for name in (*(f"{error}_error" for error in _ERRORS), "figure"):
        if getattr(options, name) is not None:
            raise InvalidValueError(f"--{name.replace('_', '-')}", "it goes with --blind", "add --blind")


def run_blind(options: argparse.Namespace) -> int:
    """Run the command."""
    import numpy as np

    from ..calibration import calibrate_blind
    from ..errors import FileError, InvalidValueError
    from ..io.files import check_target, write_bytes
    from ..io.finger_file import load_finger
    from ..io.tables import read_table

    for name in _LABELLED:
        if getattr(options, name) is not None:
            raise InvalidValueError(
                f"--{name.replace('_', '-')}", "with --blind nothing is known of the touches", "leave it out"
            )
    if options.figure is not None:
        check_figure(options.figure, "--figure")
    if options.out not in (None, "-"):
        check_target(options.out)
    file = load_finger(options.finger)
    table = read_table(options.touches)
    readings = table.readings(file.names)[chosen_rows(options, len(table))]
    fit = tuple(part.strip() for part in (options.fit or "gain,depth,position").split(",") if part.strip())
    errors = _errors(options, file, fit)
    friction = {k: v for k, v in file.options.items() if k == "friction"}
    silent = np.asarray(file.finger.array.noise) == 0
    if (silent & file.finger.array.live).any():
        raise FileError(
            f"{options.finger}: a sensor without noise", "touches are weighed by it", 'noise = "10 Pa" in [sensors]'
        )
    found = calibrate_blind(file.finger, readings, fit=fit, search=file.search, **errors, **friction)
    if options.figure is not None:
        from ..plot import blind_figure, save

        save(blind_figure(found, file.names), options.figure)
    if options.out is not None:
        text = file.with_finger(found.finger, file.origin, _facts(options, file, found, fit)).text
        write_bytes(options.out, text.encode())
    if options.json:
        write_json(_as_json(file, found))
    else:
        _show(options, file, found)
    return 0


def _errors(options: argparse.Namespace, file: FingerFile, fit: tuple[str, ...]) -> dict[str, float]:
    """The errors given, as `calibrate_blind` takes them."""
    import re

    import numpy as np

    from ..errors import InvalidValueError
    from ..io.units import quantity

    depths = np.asarray(file.finger.array.depth)
    below = file.finger.skin.thickness - float(depths.max())
    lengths = {"depth": float(depths.mean()), "position": float(depths.mean()), "thickness": below}
    given = {}
    for name in _ERRORS:
        text, option = getattr(options, f"{name}_error"), f"--{name}-error"
        if text is None:
            if name in fit and name in _NEEDED:
                rule = "how far the drawing can be off has to be said"
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


def _facts(
    options: argparse.Namespace, file: FingerFile, found: BlindCalibration, fit: tuple[str, ...]
) -> dict[str, Any]:
    """What goes into [calibration] beside the origin."""
    from pathlib import Path

    from ..io.units import format_quantity

    std: dict[str, Any] = {}
    for p in found.parameters:
        error = float(f"{p.std:.3g}")
        value = format_quantity(error, p.unit) if p.unit else error
        if p.sensor is None:
            std[p.name] = value
        else:
            std.setdefault(p.name, {})[file.names[p.sensor]] = value
    facts: dict[str, Any] = {
        "source": Path(options.touches).name,
        "blind": True,
        "fit": list(fit),
        "touches": int(found.used.sum()),
        "misfit": float(found.misfit),
    }
    for name in ("weak", "dead"):
        facts[name] = _sensors(file, found, name)
    return facts | {"std": std}


def _sensors(file: FingerFile, found: BlindCalibration, health: str) -> list[str]:
    return [n for n, state in zip(file.names, found.health, strict=True) if state.name == health.upper()]


def _half(found: BlindCalibration, index: int) -> float:
    """How many touches leave half of the standard deviation there is."""
    return found.touches_for(index, 0.5 * found.parameters[index].std)


def _as_json(file: FingerFile, found: BlindCalibration) -> dict[str, Any]:
    parameters = [
        {
            "name": p.name,
            "sensor": None if p.sensor is None else file.names[p.sensor],
            "drawn": p.drawn,
            "prior": p.prior,
            "value": p.value,
            "std": p.std,
            "limit": p.limit,
            "unit": p.unit,
            "known": p.known.name.lower(),
            "touches_for_half": _half(found, i),
        }
        for i, p in enumerate(found.parameters)
    ]
    ratio = found.error_ratio()
    return {
        "parameters": parameters,
        "unknown": list(found.unknown),
        "doubts": list(found.doubts),
        "touches": len(found.used),
        "used": int(found.used.sum()),
        "left_out": _left_out(found),
        "misfit": found.misfit,
        "error_ratio": {"position": ratio.position, "angle": ratio.angle},
        "touches_for_1.3": found.touches_for_ratio(1.3),
        "weak": _sensors(file, found, "weak"),
        "dead": _sensors(file, found, "dead"),
    }


def _left_out(found: BlindCalibration) -> dict[str, int]:
    import numpy as np

    from ..estimate.estimate import Status

    states = found.touches.status[~found.used]
    counts = np.bincount(states.astype(np.intp), minlength=len(Status))
    return {s.name.lower(): int(counts[s]) for s in Status if counts[s]}


def _show(options: argparse.Namespace, file: FingerFile, found: BlindCalibration) -> None:
    out = say(options)
    rows = []
    for i, p in enumerate(found.parameters):
        rows.append([p.name, "" if p.sensor is None else file.names[p.sensor], *_cells(p), _touches(_half(found, i))])
    columns = [
        "name",
        "sensor",
        "drawn",
        "give or take",
        "found",
        "give or take",
        "at best",
        "unit",
        "",
        "touches for half",
    ]
    show(out, "parameters", columns, rows, left=2)
    left = ", ".join(f"{count} {name.replace('_', ' ')}" for name, count in _left_out(found).items())
    print(
        f"{int(found.used.sum())} of {len(found.used)} touches used" + (f"; left out: {left}" if left else ""), file=out
    )
    ratio = found.error_ratio()
    angle = "" if ratio.angle != ratio.angle else f" and of angles {ratio.angle:.2f}"
    print(f"errors of places {ratio.position:.2f}{angle} times those of a finger known exactly", file=out)
    if max(ratio.position, ratio.angle if ratio.angle == ratio.angle else 1.0) > _WANTED:
        print(f"{_WANTED} times: with {_touches(found.touches_for_ratio(_WANTED))} touches like those used", file=out)
    for text in found.unknown:
        print(f"not to be known from touches: {text}", file=out)
    for name, what in (("weak", "gain below a fifth"), ("dead", "left out from now on")):
        sensors = _sensors(file, found, name)
        if sensors:
            print(f"{name}: {', '.join(sensors)} ({what})", file=out)
    for doubt in found.doubts:
        print(doubt, file=out)
    if options.out not in (None, "-"):
        print(f"-> {options.out}", file=out)
    if options.figure is not None:
        print(f"-> {options.figure}", file=out)


def _cells(p: BlindParameter) -> list[str]:
    scale, unit = (1e3, "mm") if p.unit == "m" else (1.0, p.unit)
    values = [number(p.drawn * scale, 5), number(p.prior * scale, 2), number(p.value * scale, 5)]
    best = "0" if p.limit < 1e-6 * p.prior else number(p.limit * scale, 2)
    return [*values, number(p.std * scale, 2), best, unit, _SAID[p.known.name]]


def _touches(count: float) -> str:
    return "never" if count == float("inf") else f"{float(f'{count:.2g}'):,.0f}"
