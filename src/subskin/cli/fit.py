"""`subskin fit`: readings -> a contact of some width: where, how hard, at what angle, how wide."""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING, Any

from ..contact import families
from .common import describe, number, quantity_range, say, show, write_json
from .frames import (
    MEANING,
    add_frames,
    check_targets,
    in_chunks,
    read_frames,
    sensor_names,
    show_statuses,
    status_counts,
    status_names,
    told,
)

if TYPE_CHECKING:
    import numpy as np
    import numpy.typing as npt

    from ..estimate.estimate import Estimate
    from ..io.finger_file import FingerFile

_HERE = {
    **MEANING,
    "ok": "one contact of the family explains the readings",
    "ambiguous": "another explains them nearly as well, or it is at an end of place, width or angle",
    "unexplained": "no contact of the family, within the friction cone, explains the readings",
}
_EXAMPLES = """\
  subskin fit finger.toml readings.csv --family hertz -o fitted.csv
  subskin fit finger.toml readings.csv --family wedge --width "0.1..1 mm" --figure contacts.png
  subskin simulate finger.toml -o - --contact hertz --half-width "2 mm" | subskin fit finger.toml - --json
"""
_NOTES = """\
Four unknowns: place, force, angle and half width. As many readings are explained by any family; what more sensors say
can speak against it. Below about a twentieth of the depth only the square of the width shows, and the interval begins
at 0.
"""


def add(parser: argparse.ArgumentParser) -> None:
    """Say what the command takes."""
    describe(parser, run, _EXAMPLES, _NOTES)
    parser.add_argument("--family", choices=tuple(families()), default="hertz", help="what presses (hertz)")
    parser.add_argument("--width", metavar="RANGE", help='half widths to look at (default: "0..1.5" depths)')
    add_frames(parser, "fit", "table of contacts", "draw the contacts along the skin, frame by frame")


def run(options: argparse.Namespace) -> int:
    """Run the command."""
    from ..io.tables import write_table

    check_targets(options)
    width = None if options.width is None else quantity_range(options.width, "m", "--width")
    file, _, rows, readings = read_frames(options)
    with told(options.finger):
        parts = in_chunks(
            lambda frames: file.finger.fit(
                frames, options.family, search=file.search, half_width=width, **(file.options or {})
            ),
            readings,
        )
    found = type(parts[0]).join(parts)
    columns = _columns(file, found, rows)
    if options.figure is not None:
        from ..plot import contact_strip, save

        save(contact_strip(found, origin=file.origin), options.figure)
    if options.out is not None:
        write_table(options.out, columns)
    if options.json:
        counts = status_counts(found.status)
        write_json({"frames": len(rows), "family": options.family, "status": counts, "columns": columns})
    else:
        _show(options, found, columns)
    return 0


def _columns(file: FingerFile, found: Estimate, rows: npt.NDArray[np.intp]) -> dict[str, Any]:
    std, interval = found.std, found.half_width_interval
    return {
        "row": rows,
        "position": found.position + file.origin,
        "force": found.force,
        "angle": found.angle,
        "half_width": found.half_width,
        "position_std": std[:, 0],
        "force_std": std[:, 1],
        "angle_std": std[:, 2],
        "half_width_low": interval[:, 0],
        "half_width_high": interval[:, 1],
        "status": status_names(found.status),
        "residual": found.residual,
        "spare": found.spare,
        "second_position": found.second.position + file.origin,
        "second_half_width": found.second.half_width,
        "second_chi2": found.second.chi2,
        "used": sensor_names(file, found.used),
    }


def _show(options: argparse.Namespace, found: Estimate, columns: dict[str, Any]) -> None:
    out = say(options)
    show_statuses(options, found.status, _HERE)
    if not found.spare.any():
        print(
            "no reading to spare: any family would explain these as well (subskin decide weighs them)",
            file=out,
        )
    if options.out is None:
        names = ["position", "force", "angle", "half_width", "half_width_low", "half_width_high"]
        first = [
            [str(columns["row"][i]), *(number(float(columns[n][i])) for n in names), columns["status"][i]]
            for i in range(min(len(columns["row"]), 20))
        ]
        show(out, "the first frames, in SI; -o writes them all", ["row", *names, "status"], first)
    elif options.out != "-":
        print(f"-> {options.out}", file=out)
    if options.figure is not None:
        print(f"-> {options.figure}", file=out)
