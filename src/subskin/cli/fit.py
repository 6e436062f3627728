"""`subskin fit`: readings -> a contact of some width: where, how hard, at what angle, how wide."""

from __future__ import annotations

import argparse
from typing import TextIO

from .. import io
from ..contact import families
from .common import describe, give, quantity_range
from .frames import MEANING, add_frames

_HERE = {
    **MEANING,
    "ok": "one contact of the family explains the readings",
    "ambiguous": "another explains them nearly as well, or it is at an end of position, width or angle",
    "unexplained": "no contact of the family, within the friction cone, explains the readings",
}
_EXAMPLES = """\
  subskin fit finger.toml readings.csv --family hertz -o fitted.csv
  subskin fit finger.toml readings.csv --family wedge --width "0.1..1 mm" --figure contacts.png
  subskin simulate finger.toml -o - --contact hertz --half-width "2 mm" | subskin fit finger.toml - --json
"""
_NOTES = """\
Four unknowns: position, force, angle and half width. As many readings are explained by any family; what more sensors
say can speak against it. Below about a twentieth of the depth only the square of the width shows, and the interval
begins at 0.
"""


def add(parser: argparse.ArgumentParser) -> None:
    """Say what the command takes."""
    describe(parser, run, _EXAMPLES, _NOTES)
    parser.add_argument("--family", choices=tuple(families()), default="hertz", help="what presses (hertz)")
    parser.add_argument("--width", metavar="RANGE", help='half widths to look at (default: "0..1.5" depths)')
    add_frames(parser, "fit", "table of contacts", "draw the contacts along the skin, frame by frame")


def run(options: argparse.Namespace) -> int:
    """Run the command."""
    from .answers import answers_of, estimate_columns, show_first, show_statuses, status_counts

    width = None if options.width is None else quantity_range(options.width, "m", "--width")
    answers = answers_of(options, lambda file: file.locator(family=options.family, half_width=width))
    found, columns = answers.found, estimate_columns(answers, width=True)

    def people(out: TextIO) -> None:
        show_statuses(out, found.status, _HERE)
        if not found.spare.any():
            what = "any family would explain these as well (subskin decide weighs them)"
            print(f"no reading to spare: {what}", file=out)
        if options.out is None:
            widths = ("half_width", "half_width_low", "half_width_high")
            show_first(out, columns, ["row", "position", "force", "angle", *widths, "status"])

    data = {"frames": len(answers.rows), "family": options.family, "status": status_counts(found.status)}
    return give(
        options,
        lambda: {**data, "columns": columns},
        people,
        {options.out: lambda to: io.write_table(to, columns)},
        lambda plot: plot.contact_strip(found, origin=answers.file.origin),
    )
