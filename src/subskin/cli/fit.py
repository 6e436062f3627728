"""`subskin fit`: readings -> a contact of some width: where, how hard, at what angle, how wide."""

from __future__ import annotations

import argparse
from contextlib import ExitStack
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
  subskin fit finger.toml readings.csv --stick 0.4..0.8
  subskin simulate finger.toml -o - --contact hertz --half-width "2 mm" | subskin fit finger.toml - --json
"""
_NOTES = """\
A contact has four unknowns: position, force, angle and half width. Any family explains four readings; only more
sensors can speak against it. Half widths below about a twentieth of the depth are lost: their interval begins at 0.
A contact that holds sticks in its middle: without --stick its drag is found too small.
"""


def add(parser: argparse.ArgumentParser) -> None:
    """Say what the command takes."""
    describe(parser, run, _EXAMPLES, _NOTES)
    parser.add_argument("--family", choices=tuple(families()), default="hertz", help="family of the contact (hertz)")
    parser.add_argument("--width", metavar="RANGE", help='range of half widths (default: "0..1.5" depths)')
    stick = "the coefficient of friction by which a hertz contact sticks in its middle, or a range of it"
    parser.add_argument("--stick", metavar="MU", help=f"{stick} (default: it slides)")
    add_frames(parser, "fit", "table of contacts", "draw the contacts along the skin, frame by frame")


def run(options: argparse.Namespace) -> int:
    """Run the command."""
    from ..stream.stage import join
    from .answers import Kept, answers_of, estimate_columns, show_first, show_statuses

    width = None if options.width is None else quantity_range(options.width, "m", "--width")
    stick = None if options.stick is None else quantity_range(options.stick, "", "--stick")
    kept, drawn, spare, origin = Kept(None if options.json else ()), [], False, 0.0
    with ExitStack() as outputs:
        table = None if options.out is None else outputs.enter_context(io.writing(options.out))
        chosen = {"family": options.family, "half_width": width, "stick": stick}
        for answers in answers_of(options, lambda file: file.locator(**chosen)):
            columns = estimate_columns(answers, width=True)
            kept.add(columns, answers.found.status)
            spare, origin = spare or bool(answers.found.spare.any()), answers.file.origin
            if options.figure is not None:
                drawn.append(answers.found)
            if table is not None:
                table.write(columns)

        def people(out: TextIO) -> None:
            show_statuses(out, kept.status, _HERE)
            if not spare:
                what = "any family would explain these as well (subskin decide weighs them)"
                print(f"no reading to spare: {what}", file=out)
            if options.out is None:
                widths = ("half_width", "half_width_low", "half_width_high")
                show_first(out, kept.first, ["row", "position", "force", "angle", *widths, "status"])

        return give(
            options,
            lambda: {"frames": kept.frames, "family": options.family, "status": kept.status, "columns": kept.columns},
            people,
            {options.out: lambda _: outputs.close()},
            lambda plot: plot.contact_strip(join(drawn), origin=origin),
        )
