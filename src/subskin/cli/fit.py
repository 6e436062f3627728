"""`subskin fit`: readings -> a contact of some width: where, how hard, at what angle, how wide; on a row or an area."""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING, Any, TextIO

from .. import io
from ..contact import families, local_families
from .common import give, refuse_response
from .options import MEANING, command, frames, option, quantity_range

if TYPE_CHECKING:
    from ..estimate import Estimate
    from .answers import Answer

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
  subskin fit area.toml readings.csv --family round_punch --width "0..3 mm" -o fitted.csv
  subskin simulate finger.toml -o - --contact hertz --half-width "2 mm" | subskin fit finger.toml - --json
"""
_NOTES = """\
A contact has four unknowns: position, force, angle and half width. With four readings a pull or nonsense is
unexplained, but only more sensors can speak against the family. Half widths below about a twentieth of the depth are
lost: their interval begins at 0.
A contact that holds sticks in its middle: without --stick its drag is found too small. Sensors on an area fit round
contacts, which have six unknowns: two of position, three of force, and the radius; a seventh is the moment about the
normal, where the sensors see it: those of shear and displacement do; normal strain, pressure and normal stress do not.
"""

_STICK = (
    "the coefficient of friction by which a hertz contact sticks in its middle, or a range of it (default: it slides)"
)
_SHOWN = (
    "row", "position", "position_y", "position_z", "force", "angle", "azimuth", "half_width", "half_width_low",
    "half_width_high", "half_width_y", "half_width_z", "turn", "moment", "force_unit", "status",
)  # fmt: skip


def _families() -> tuple[str, ...]:
    """Those that there are now, one's own among them."""
    return (*families(), *local_families(), "patch")


@command(
    _EXAMPLES,
    option("--family", "family of the contact (hertz; of sensors on an area round_hertz)", choices=_families),
    option("--width RANGE", 'range of half widths (default: "0..1.5" depths)'),
    option("--turn RANGE", 'of a patch: by how much it is turned, "0 deg", or "-20..20 deg" (any)'),
    option("--pressure {even,linear,punch}", "of a patch: how it presses (even)"),
    option("--stick MU", _STICK),
    frames("fit", "table of contacts", "draw the contacts along the skin, frame by frame"),
    notes=_NOTES,
)
def run_fit(options: argparse.Namespace) -> int:
    """Run the command."""
    from ..stream.stage import join
    from .answers import Kept, answers_of, estimate_columns, show_first, show_statuses

    width = None if options.width is None else quantity_range(options.width, "m", "--width")
    stick = None if options.stick is None else quantity_range(options.stick, "", "--stick")
    turn = None if options.turn is None else quantity_range(options.turn, "rad", "--turn")
    drawn, spare, origin, blind = [], False, 0.0, False
    family = options.family
    with Kept(options) as kept:
        chosen = {"half_width": width, "stick": stick, "turn": turn, "pressure": options.pressure}

        def prepare(file: io.FingerFile) -> Answer:
            nonlocal family
            family = family or ("round_hertz" if file.finger.array.on_area else "hertz")
            if family != "point":
                refuse_response(file, "another contact's field")
            return file.locator(family=family, **chosen)

        for answers in answers_of(options, prepare):
            columns = estimate_columns(answers, width=True)
            kept.add(columns, answers.found.status)
            spare, origin = spare or bool(answers.found.spare.any()), answers.file.origin
            at = answers.found.layout
            blind = at.dim == 2 and not (at.twist or at.sides)
            if options.figure is not None:
                drawn.append(answers.found)

        def people(out: TextIO) -> None:
            show_statuses(out, kept.status, _HERE)
            if not spare and any(kept.status.values()):
                what = "any family would explain these as well (subskin decide weighs them)"
                print(f"no reading to spare: {what}", file=out)
            if blind:
                print("no moment about the normal is fitted: these sensors do not tell it", file=out)
            if options.out is None:
                show_first(out, kept.first, [name for name in _SHOWN if name in kept.first])

        return give(
            options,
            lambda: {"frames": kept.frames, "family": family, "status": kept.status, "columns": kept.columns},
            people,
            kept.files,
            lambda plot: _drawn(plot, join(drawn), origin),
        )


def _drawn(plot: Any, found: Estimate, origin: float) -> Any:
    """The contacts along the skin, or from above."""
    return plot.contact_strip(found, origin=origin) if found.layout.dim == 1 else plot.estimate_figure(found)
