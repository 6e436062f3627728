"""`subskin decide`: readings -> how probable each kind of contact is, and the kind, or "cannot tell"."""

from __future__ import annotations

import argparse
import math
import re
from collections import Counter
from functools import partial
from typing import TYPE_CHECKING, Any, TextIO

from .. import io
from .._axes import on_touches
from .._lazy import np
from ..errors import InvalidValueError
from .common import give, number, refuse_response, show
from .options import MEANING, command, frames, option, quantity_range

if TYPE_CHECKING:
    from ..decide import Kind, TypeDecision
    from .answers import Answers, Kept

_EXAMPLES = """\
  subskin decide finger.toml readings.csv -o kinds.csv
  subskin decide finger.toml readings.csv --kind "edge=wedge: 0.2..0.7 mm" --kind "can=hertz: 1..3 mm * 2" --sure 0.99
  subskin decide area.toml readings.csv --kind "coin=round_punch: 0.5..1.5 mm" --kind "ball=round_hertz: 0.5..2 mm"
  subskin decide area.toml readings.csv --kind "box=edge: 0..0.5 mm, 1..4 mm" --kind "tip=cone: 0.2..1 mm"
  subskin simulate finger.toml -o - --contact wedge --half-width "0.5 mm" | subskin decide finger.toml - --json
"""
_NOTES = """\
Without --kind: a line, a vertex (wedge), a flat and a round side (punch and hertz), all equally likely beforehand; two
touches (pair, 0.5 to 3 depths apart), a tenth as likely; none of these (none), a fifth as likely. A vertex is any
contact narrower than a roller of half width 0.4 depth, a flat bar of 0.28 or a wedge of 0.49. A side is any wider
contact, up to a roller of 2.4 or a bar of 1.7. A line is narrower than a wedge of 0.1. Where no kind is as probable as
--sure, the answer is "cannot tell". "spare" counts the readings beyond the unknowns: with 0, "none of these" cannot
be found. Of sensors on an area: a point, a vertex (cone), a flat and a round side (round_punch, round_hertz), an edge,
none of these, two touches among them. A vertex is narrower than a sphere of half width 0.45 depth or a disc of 0.35; a
side is wider, up to a sphere of 1.34 or a disc of 1.04. An edge is at least 1.4 times as long as wide, its half
length 0.6 to 2 depths; its "direction", from +y towards +z, comes with its standard error.
"""
_KIND = re.compile(r"\s*(?P<name>[^=]+?)\s*=\s*(?P<family>\w+)\s*(:\s*(?P<width>[^*]+?)\s*)?(\*\s*(?P<prior>\S+)\s*)?")
_HERE = {
    **MEANING,
    "ok": "one kind is probable enough",
    "ambiguous": "no kind is: the readings do not decide",
    "unexplained": "no kind explains the readings",
}


@command(
    _EXAMPLES,
    option(
        "--kind NAME=FAMILY[:WIDTH[,LENGTH]][*PRIOR]",
        "a kind to weigh: its family (as in fit, or edge), half widths, half lengths (edge, patch), prior (1); repeat",
        action="append",
    ),
    option("--sure P", "probability to decide from (0.95)", 0.95),
    frames("weigh", "table of probabilities", "draw the probabilities, frame by frame"),
    notes=_NOTES,
)
def run_decide(options: argparse.Namespace) -> int:
    """Run the command."""
    from ..stream.stage import join
    from .answers import Kept, answers_of

    if not 0.5 < options.sure < 1:
        raise InvalidValueError(f"--sure {options.sure:g}", "a probability in (0.5, 1) is needed", "--sure 0.95")
    kinds = None if options.kind is None else tuple(_kind(text) for text in options.kind)
    if kinds is not None and len({kind.name for kind in kinds}) < len(kinds):
        raise InvalidValueError("two --kind of one name", "each kind needs its own", "another name")

    def prepare(file: io.FingerFile) -> Any:
        refuse_response(file, "the fields of other kinds")
        answer = partial(file.decide, kinds=kinds, sure=options.sure)
        answer(np.empty((0, len(file.names))))  # what is wrong with the finger shows
        return answer

    drawn: list[TypeDecision] = []
    counts: Counter[str] = Counter()
    with Kept(options) as kept:
        for answers in answers_of(options, prepare):
            columns = _columns(answers)
            kept.add(columns, answers.found.status)
            said = answers.found
            counts.update(_counts(said))
            if options.figure is not None:
                drawn.append(said)
        kinds_counted = {name: counts[name] for name in said.names}
        return give(
            options,
            lambda: {"frames": kept.frames, "status": kept.status, "kinds": kinds_counted, "columns": kept.columns},
            lambda out: _show(out, said, kept, kinds_counted, usual=kinds is None, first=options.out is None),
            kept.files,
            lambda plot: plot.probability_strip(join(drawn)),
        )


def _kind(text: str) -> Kind:
    from ..decide import Kind

    match = _KIND.fullmatch(text)
    rule, fix = "a kind is NAME=FAMILY[:WIDTH[,LENGTH]][*PRIOR]", '--kind "edge=wedge: 0.2..0.7 mm * 2"'
    if match is None:
        raise InvalidValueError(f'--kind "{text}"', rule, fix)
    sizes = [quantity_range(part, "m", "--kind") for part in (match["width"] or "0 m").split(",")]
    if len(sizes) != 1 + (match["family"] in ("edge", "patch")):
        sized = "an edge, or a patch, has half widths, then half lengths; no other kind has lengths"
        raise InvalidValueError(f'--kind "{text}"', sized, '--kind "box=edge: 0..0.5 mm, 1..4 mm"')
    try:
        prior = float(match["prior"] or 1.0)
    except ValueError:
        raise InvalidValueError(f'--kind "{text}"', rule, fix) from None
    return Kind(match["name"], match["family"], sizes[0], prior, half_length=sizes[1] if len(sizes) > 1 else (0.0, 0.0))


def _counts(said: TypeDecision) -> dict[str, int]:
    """How many frames each kind was decided for."""
    decision = said.decision
    return {name: int((decision == i).sum()) for i, name in enumerate(said.names)}


def _columns(answers: Answers) -> dict[str, Any]:
    from .answers import status_names

    said: TypeDecision = answers.found
    probability = said.probability
    each = {f"p {name}".replace(" ", "_"): probability[:, i] for i, name in enumerate(said.names)}
    return {
        "row": answers.rows,
        "kind": said.name,
        **each,
        **_where(said, answers.file),
        "force": said.force,
        "angle": said.angle,
        "half_width": said.half_width,
        **_edge(said, answers.file),
        "spare": said.spare,
        "status": status_names(said.status),
        "residual": said.residual,
        "used": answers.used,
        **_unit(said, answers.file),
    }


def _unit(said: TypeDecision, file: io.FingerFile) -> dict[str, Any]:
    """The force in N where the contact's length is known; or what the force is in, where that is no newtons."""
    from ..estimate.estimate import unit_column

    if file.length is None or said.relative or file.finger.array.on_area:
        return unit_column(said.shape, said.relative)
    return {"newtons": said.force * file.length}


def _shown_at(columns: dict[str, Any]) -> list[str]:
    return [name for name in ("position", "position_y", "position_z") if name in columns]


def _where(said: TypeDecision, file: io.FingerFile) -> dict[str, Any]:
    """Positions, and on an area azimuths, on the axes of the tables."""
    if not file.finger.array.on_area:
        return {"position": said.position + file.origin}
    y, z = on_touches(said.position, file.origin, file.turn).T
    return {"position_y": y, "position_z": z, "azimuth": said.azimuth + file.turn}


def _edge(said: TypeDecision, file: io.FingerFile) -> dict[str, Any]:
    """Length and direction of edges on an area, on the axes of the tables."""
    if not file.finger.array.on_area:
        return {}
    direction = (said.direction + file.turn) % math.pi
    return {"half_length": said.half_length, "direction": direction, "direction_std": said.direction_std}


def _show(out: TextIO, said: TypeDecision, kept: Kept, counts: dict[str, int], *, usual: bool, first: bool) -> None:
    from .answers import show_first, show_statuses

    show_statuses(out, kept.status, _HERE)
    kinds = []
    for kind, count in zip(said.kinds, counts.values(), strict=True):
        family = kind.family if isinstance(kind.family, str) else kind.family.__name__
        low, high = (1e3 * width for width in kind.half_width)
        widths = f"{low:.3g} to {high:.3g}" if high > 0 else "-"
        short, long = (1e3 * length for length in kind.half_length)
        widths += f", half length {short:.3g} to {long:.3g}" if long > 0 else ""
        kinds.append([kind.name, family, widths, number(kind.prior), str(count)])
    title = f"decided where the probability is {said.sure:g} or more"
    show(out, title, ["kind", "family", "half width [mm]", "prior", "frames"], kinds, left=2)
    if usual:
        ball = next(kind for kind in said.kinds if kind.family in ("hertz", "round_hertz"))
        narrow, wide = (1e3 * width for width in ball.half_width)
        body = "roller" if ball.family == "hertz" else "sphere"
        print(f"vertex: any contact narrower than a {body} of half width {narrow:.3g} mm", file=out)
        print(f"side: any contact from there to a {body} of half width {wide:.3g} mm", file=out)
        if body == "sphere":
            print("edge: a contact at least 1.4 times as long as wide", file=out)
    if first:
        shares = {
            name: [f"{v:.3f}" if v >= 0 else "-" for v in values]
            for name, values in kept.first.items()
            if name[:2] == "p_"
        }
        turned = ["direction"] if any(math.isfinite(v) for v in kept.first.get("direction", ())) else []
        names = ["row", "kind", *shares, *_shown_at(kept.first), "half_width", *turned]
        show_first(out, {**kept.first, **shares}, names, left=2)
