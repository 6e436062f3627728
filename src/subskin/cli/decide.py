"""`subskin decide`: readings -> what kind of contact, how probable each is, or that they cannot tell."""

from __future__ import annotations

import argparse
import re
from typing import TYPE_CHECKING, Any

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

    from ..decide import Kind, TypeDecision
    from ..io.finger_file import FingerFile

_EXAMPLES = """\
  subskin decide finger.toml readings.csv -o kinds.csv
  subskin decide finger.toml readings.csv --kind "edge=wedge: 0.2..0.7 mm" --kind "can=hertz: 1..3 mm * 2" --sure 0.99
  subskin simulate finger.toml -o - --contact wedge --half-width "0.5 mm" | subskin decide finger.toml - --json
"""
_NOTES = """\
Without --kind: a line, a vertex (wedge of half width 0.1 to 0.35 depth), a flat and a round side (punch and hertz, 0.5
to 1.2 depth), alike likely beforehand. Where no kind is as probable as --sure, the answer is "cannot tell".
"""
_KIND = re.compile(
    r"\s*(?P<name>[^=]+?)\s*=\s*(?P<family>\w+)\s*(:\s*(?P<width>[^*]+?)\s*)?(\*\s*(?P<prior>\S+)\s*)?"
)
_HERE = {
    **MEANING,
    "ok": "one kind is probable enough",
    "ambiguous": "no kind is: the readings cannot tell",
    "unexplained": "no kind explains the readings",
}


def add(parser: argparse.ArgumentParser) -> None:
    """Say what the command takes."""
    describe(parser, run, _EXAMPLES, _NOTES)
    parser.add_argument(
        "--kind",
        action="append",
        metavar="NAME=FAMILY[:WIDTH][*PRIOR]",
        help="a kind to weigh: its family (as of fit), its half widths, how likely beforehand (1); repeat",
    )
    parser.add_argument(
        "--sure", type=float, default=0.95, metavar="P", help="probability to decide from (0.95)"
    )
    add_frames(parser, "weigh", "table of probabilities", "draw the probabilities, frame by frame")


def run(options: argparse.Namespace) -> int:
    """Run the command."""
    import numpy as np

    from ..decide import TypeDecision, contact_type
    from ..errors import InvalidValueError
    from ..io.tables import write_table

    check_targets(options)
    if not 0.5 < options.sure < 1:
        raise InvalidValueError(
            f"--sure {options.sure:g}", "a probability in (0.5, 1) is needed", "--sure 0.95"
        )
    kinds = None if options.kind is None else tuple(_kind(text) for text in options.kind)
    if kinds is not None and len({kind.name for kind in kinds}) < len(kinds):
        raise InvalidValueError("two --kind of one name", "each kind needs its own", "another name")
    file, _, rows, readings = read_frames(options)
    given = {k: v for k, v in (file.options or {}).items() if k in ("friction", "false_alarm")}
    with told(options.finger):
        parts = in_chunks(
            lambda frames: contact_type(
                file.finger, frames, kinds, sure=options.sure, search=file.search, **given
            ),
            readings,
        )
    said = TypeDecision(
        parts[0].kinds,
        options.sure,
        np.concatenate([p.table for p in parts]),
        np.concatenate([p.used for p in parts]),
    )
    columns = _columns(file, said, rows)
    if options.figure is not None:
        from ..plot import probability_strip, save

        save(probability_strip(said), options.figure)
    if options.out is not None:
        write_table(options.out, columns)
    if options.json:
        counts = {"status": status_counts(said.status), "kinds": _counts(said)}
        write_json({"frames": len(rows), **counts, "columns": columns})
    else:
        _show(options, said, columns)
    return 0


def _kind(text: str) -> Kind:
    from ..decide import Kind
    from ..errors import InvalidValueError

    match = _KIND.fullmatch(text)
    rule, fix = "a kind is NAME=FAMILY[:WIDTH][*PRIOR]", '--kind "edge=wedge: 0.2..0.7 mm * 2"'
    if match is None:
        raise InvalidValueError(f'--kind "{text}"', rule, fix)
    width = (0.0, 0.0) if match["width"] is None else quantity_range(match["width"], "m", "--kind")
    try:
        prior = float(match["prior"] or 1.0)
    except ValueError:
        raise InvalidValueError(f'--kind "{text}"', rule, fix) from None
    return Kind(match["name"], match["family"], width, prior)


def _counts(said: TypeDecision) -> dict[str, int]:
    """How many frames each kind was decided for."""
    decision = said.decision
    return {name: int((decision == i).sum()) for i, name in enumerate(said.names)}


def _columns(file: FingerFile, said: TypeDecision, rows: npt.NDArray[np.intp]) -> dict[str, Any]:
    probability = said.probability
    each = {f"p {name}".replace(" ", "_"): probability[:, i] for i, name in enumerate(said.names)}
    return {
        "row": rows,
        "kind": said.name,
        **each,
        "position": said.position + file.origin,
        "force": said.force,
        "angle": said.angle,
        "half_width": said.half_width,
        "status": status_names(said.status),
        "residual": said.residual,
        "used": sensor_names(file, said.used),
    }


def _show(options: argparse.Namespace, said: TypeDecision, columns: dict[str, Any]) -> None:
    out = say(options)
    show_statuses(options, said.status, _HERE)
    kinds = [
        [
            kind.name,
            kind.family if isinstance(kind.family, str) else kind.family.__name__,
            f"{1e3 * kind.half_width[0]:.3g} to {1e3 * kind.half_width[1]:.3g}"
            if kind.half_width[1] > 0
            else "-",
            number(kind.prior),
            str(count),
        ]
        for kind, count in zip(said.kinds, _counts(said).values(), strict=True)
    ]
    title = f"decided where the probability is {said.sure:g} or more"
    show(out, title, ["kind", "family", "half width [mm]", "prior", "frames"], kinds, left=2)
    if options.out is None:
        names = [name for name in columns if name.startswith("p_")]
        first = [
            [
                str(columns["row"][i]),
                str(columns["kind"][i]),
                *(f"{columns[n][i]:.3f}" if columns[n][i] >= 0 else "-" for n in names),
                *(number(float(columns[n][i])) for n in ("position", "half_width")),
            ]
            for i in range(min(len(columns["row"]), 20))
        ]
        heads = ["row", "kind", *(n[2:].replace("_", " ") for n in names), "position", "half_width"]
        show(out, "the first frames, in SI; -o writes them all", heads, first, left=2)
    elif options.out != "-":
        print(f"-> {options.out}", file=out)
    if options.figure is not None:
        print(f"-> {options.figure}", file=out)
