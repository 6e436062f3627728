"""`subskin design`: from what the designer knows to ranked fingers and a report."""

from __future__ import annotations

import argparse
import sys
import textwrap
from pathlib import Path
from typing import TYPE_CHECKING, Any

from .common import describe, progress_bar, say, show, write_json

if TYPE_CHECKING:
    from ..design.search import DesignedFinger, DesignStudy
    from ..io.goals_file import GoalsFile

_EXAMPLES = """\
  subskin design --example > goals.toml          # a file to begin with; every key is explained in it
  subskin design goals.toml -o design            # design/report.html, report.pdf, finger_1.toml, ...
  subskin simulate design/finger_1.toml --help   # the fingers are files like any other
"""
_NOTES = """\
Searches skins, kinds of sensor, depths, pitches and counts for rows of sensors that do what goals.toml wants, on all
cores. A search that was stopped goes on where it was when the same command is given again; what is finished lies in
DIR/search.
"""


def add(parser: argparse.ArgumentParser) -> None:
    """Say what the command takes."""
    describe(parser, run, _EXAMPLES, _NOTES)
    parser.add_argument("goals", nargs="?", help="goals.toml")
    parser.add_argument("-o", "--out", metavar="DIR", default="design", help="folder of the result (design)")
    parser.add_argument("--seed", type=int, metavar="N", help="of the touches, instead of that in the file")
    parser.add_argument("--workers", type=int, metavar="N", help="rows worked on at a time (one a core)")
    parser.add_argument("--no-report", action="store_true", help="fingers and table only")
    parser.add_argument("--example", action="store_true", help="print an example of goals.toml and stop")
    parser.add_argument("--json", action="store_true", help="print the result as JSON")


def run(options: argparse.Namespace) -> int:
    """Run the command."""
    from dataclasses import replace

    from ..errors import FileError, InvalidValueError

    if options.example:
        sys.stdout.write(_example())
        return 0
    if options.goals is None:
        raise InvalidValueError("no goals", "a goals.toml is needed", "subskin design --example > goals.toml")
    if options.workers is not None and options.workers < 1:
        raise InvalidValueError(f"--workers {options.workers}", "has to be >= 1")
    from ..design import rank_fingers, search_grid
    from ..io.goals_file import load_goals
    from ..io.search_store import FolderStore

    file = load_goals(options.goals)
    if options.seed is not None:
        file = replace(file, goals=replace(file.goals, effort=replace(file.goals.effort, seed=options.seed)))
    goals = file.goals
    folder = Path(options.out)
    if folder.exists() and not folder.is_dir():
        raise FileError(options.out, "it is a file", "name a folder: -o design")
    store = FolderStore(folder / "search")
    rows = len(goals.skins) * len(goals.sensors) * goals.effort.depths
    try:
        with progress_bar("designs", rows) as advance:
            grid = search_grid(goals, store=store, workers=options.workers, progress=advance)
        with progress_bar("close looks", len(goals.skins) * len(goals.sensors)) as advance:
            study = rank_fingers(grid, workers=options.workers, progress=advance)
    except KeyboardInterrupt:
        kept = len(list(store.folder.glob("*.npz")))
        print(
            f"subskin: stopped; {kept} rows are kept in {store.folder}, the same command goes on from there",
            file=sys.stderr,
        )
        return 130
    written = _write(folder, file, study, options)
    if options.json:
        write_json(_as_json(study, written))
    else:
        _show(options, study, written)
    return 0


def _example() -> str:
    from importlib.resources import files

    return files("subskin.io").joinpath("goals_example.toml").read_text(encoding="utf-8")


def _write(folder: Path, file: GoalsFile, study: DesignStudy, options: argparse.Namespace) -> list[Path]:
    """The fingers, the table of all designs, and the report."""
    from ..design.words import reasons_of
    from ..io.files import write_bytes
    from ..io.goals_file import finger_text
    from ..io.tables import write_table

    for stale in ("report.html", "report.pdf"):  # of an earlier search: it would tell of other fingers
        (folder / stale).unlink(missing_ok=True)
    written = []
    for rank, finger in enumerate(study.fingers, start=1):
        remarks = [f"{study.goals.title}: finger {rank} of subskin design", *reasons_of(study, finger.row)]
        path = folder / f"finger_{rank}.toml"
        write_bytes(path, finger_text(file, finger.row, finger.quality.search, remarks).encode())
        written.append(path)
    for old in folder.glob("finger_*.toml"):  # of an earlier search that kept more
        if old not in written and old.stem.removeprefix("finger_").isdigit():
            old.unlink()
    written.append(folder / "designs.csv")
    write_table(written[-1], study.grid.columns())
    if not options.no_report:
        from ..report import as_html, as_pdf, design_report

        with progress_bar("report", 3) as advance:
            report = design_report(study, file.text)
            advance()
            write_bytes(folder / "report.html", as_html(report).encode())
            advance()
            write_bytes(folder / "report.pdf", as_pdf(report))
            advance()
        written += [folder / "report.html", folder / "report.pdf"]
    return written


def _show(options: argparse.Namespace, study: DesignStudy, written: list[Path]) -> None:
    from ..design.words import finger_table, reasons_of

    out = say(options)
    columns, rows, left = finger_table(study)
    show(out, study.goals.title, columns, rows, left=left)
    print(file=out)
    for reason in reasons_of(study, study.fingers[0].row):
        print(_wrapped(reason), file=out)
    print(file=out)
    names = ", ".join(path.name for path in written)
    print(textwrap.fill(f"written to {options.out}: {names}", 88, subsequent_indent="  "), file=out)


def _wrapped(sentence: str) -> str:
    """A sentence in lines, none broken between a number and its unit."""
    from ..design.words import held

    lines = textwrap.fill(held(sentence), 88, initial_indent="  ", subsequent_indent="    ")
    return lines.replace("\xa0", " ")


def _as_json(study: DesignStudy, written: list[Path]) -> dict[str, Any]:
    from ..design.words import reasons_of

    def one(finger: DesignedFinger) -> dict[str, Any]:
        return {
            "skin": study.goals.skins[finger.row.skin].name,
            "sensor": study.goals.sensors[finger.row.sensor].name,
            "count": finger.row.count,
            "depth": finger.row.depth,
            "pitch": finger.row.pitch,
            "meets": finger.meets,
            "checks": {c.criterion.name: {"value": c.value, "wanted": c.criterion.wanted} for c in finger.checks},
            "values": finger.values,
            "told_from_point": finger.point,
            "told_from_wide": finger.wide,
            "reasons": list(reasons_of(study, finger.row)),
        }

    return {"fingers": [one(f) for f in study.fingers], "files": [str(path) for path in written]}
