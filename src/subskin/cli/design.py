"""`subskin design`: from what the designer knows to ranked fingers and a report."""

from __future__ import annotations

import argparse
import sys
import textwrap
from dataclasses import replace
from importlib.resources import files
from pathlib import Path
from typing import Any, TextIO

from .. import design, io
from ..errors import FileError, InvalidValueError
from ..io.files import write_bytes
from .cluster import DASK, cluster
from .common import give, progress_bar, show
from .options import JSON, command, option

_EXAMPLES = """\
  subskin design --example > goals.toml          # a file to begin with; every key is explained in it
  subskin design goals.toml -o design            # design/report.html, finger_1.toml, ...
  subskin simulate design/finger_1.toml --help   # the fingers are files like any other
"""
_NOTES = """\
Searches skins, kinds of sensor, depths, pitches and counts for rows of sensors that meet goals.toml, on all cores;
with [touch] area, layouts for grids and hexagonal arrays.
The same command goes on with a search that was stopped. Finished parts are in DIR/search.
"""


@command(
    _EXAMPLES,
    option("goals?", "goals.toml"),
    option("-o --out DIR", "folder of the result (design)", "design"),
    option("--seed N", "seed of the touches (that of the file)", type=int),
    option("--workers N", "rows computed at a time (one for each core)", type=int),
    DASK,
    option("--no-report", "write fingers and table only"),
    option("--example", "print an example of goals.toml and stop"),
    JSON,
    notes=_NOTES,
)
def run_design(options: argparse.Namespace) -> int:
    """Run the command."""
    if options.example:
        sys.stdout.write(files("subskin.io").joinpath("goals_example.toml").read_text(encoding="utf-8"))
        return 0
    if options.goals is None:
        raise InvalidValueError("no goals", "a goals.toml is needed", "subskin design --example > goals.toml")
    if options.workers is not None and options.workers < 1:
        raise InvalidValueError(f"--workers {options.workers}", "has to be >= 1", "--workers 1")
    file = io.load_goals(options.goals)
    if options.seed is not None:
        file = replace(file, goals=replace(file.goals, effort=replace(file.goals.effort, seed=options.seed)))
    goals = file.goals
    folder = Path(options.out)
    if folder.exists() and not folder.is_dir():
        raise FileError(options.out, "it is a file", "name a folder: -o design")
    store = io.FolderStore(folder / "search")
    looks = len(goals.skins) * len(goals.choices)
    rows = len(goals.skins) * len(goals.choices) * goals.effort.depths
    try:
        with cluster(options) as executor, progress_bar("rows of designs", rows, uneven=True) as advance:
            grid = design.search_grid(goals, store=store, workers=options.workers, executor=executor, progress=advance)
        with progress_bar("close looks at skins and sensors", looks, uneven=True) as advance:
            study = design.rank_fingers(grid, workers=options.workers, progress=advance)
    except KeyboardInterrupt:
        kept = f"{len(list(store.folder.glob('*.npz')))} rows are kept in {store.folder}"
        print(f"subskin: stopped; {kept}, the same command goes on from there", file=sys.stderr)
        return 130
    written = _write(folder, file, study, report=not options.no_report)
    return give(options, lambda: _as_json(study, written), lambda out: _show(out, options, study, written))


def _write(folder: Path, file: io.GoalsFile, study: design.search.DesignStudy, *, report: bool) -> list[Path]:
    """The fingers, the table of all designs, and the report."""
    page = folder / "report.html"
    page.unlink(missing_ok=True)  # of an earlier search: it would tell of other fingers
    written = []
    for rank, finger in enumerate(study.fingers, start=1):
        remarks = [f"{study.goals.title}: finger {rank} of subskin design", *design.words.reasons_of(study, finger.row)]
        path = folder / f"finger_{rank}.toml"
        write_bytes(path, io.finger_text(file, finger.row, finger.quality.search, remarks).encode())
        written.append(path)
    for old in folder.glob("finger_*.toml"):  # of an earlier search that kept more
        if old not in written and old.stem.removeprefix("finger_").isdigit():
            old.unlink()
    written.append(folder / "designs.csv")
    io.write_table(written[-1], study.grid.columns())
    if report:
        from ..report import as_html, design_report

        with progress_bar("report", 2) as advance:
            text = design_report(study, file.text)
            advance()
            write_bytes(page, as_html(text).encode())
            advance()
        written.append(page)
    return written


def _show(out: TextIO, options: argparse.Namespace, study: design.search.DesignStudy, written: list[Path]) -> None:
    columns, rows, left = design.finger_table.finger_table(study)
    show(out, study.goals.title, columns, rows, left=left)
    words = design.words
    best = study.fingers[0]
    verdict = words.verdict_of(study)
    first = (
        f"Finger 1: {verdict}" if best.meets else f"No finger within the limits meets every goal. Finger 1: {verdict}"
    )
    outside = "" if best.unopposed is None else best.unopposed.sentence
    said = [first, words.tolerances_of(study), words.usual_goals_of(study), outside]
    for sentence in (*filter(None, said), *words.remedies_of(study)):
        print(_wrapped(sentence), file=out)
    print(_wrapped(f"Columns: {design.finger_table.legend_of(study)}"), file=out)
    print(file=out)
    for reason in design.words.reasons_of(study, study.fingers[0].row):
        print(_wrapped(reason), file=out)
    print(file=out)
    names = ", ".join(path.name for path in written)
    print(textwrap.fill(f"written to {options.out}: {names}", 88, subsequent_indent="  "), file=out)


def _wrapped(sentence: str) -> str:
    """A sentence in lines, none broken between a number and its unit."""
    lines = textwrap.fill(design.words.held(sentence), 88, initial_indent="  ", subsequent_indent="    ")
    return lines.replace("\xa0", " ")


def _as_json(study: design.search.DesignStudy, written: list[Path]) -> dict[str, Any]:
    def one(finger: design.search.DesignedFinger) -> dict[str, Any]:
        return {
            "skin": study.goals.skins[finger.row.skin].name,
            "sensor": study.goals.choices[finger.row.sensor].name,
            **{name: getattr(finger.row, name) for name in ("count", "depth", "pitch")},
            **({"layout": finger.row.layout.text} if study.goals.on_area else {}),
            "meets": finger.meets,
            **{name: checked(getattr(finger, name)) for name in ("checks", "as_made", "calibrated")},
            "values": finger.values,
            **({} if study.goals.on_area else {"told_from_point": finger.point, "told_from_wide": finger.wide}),
            "reasons": list(design.words.reasons_of(study, finger.row)),
            "blind_spots": None if finger.unopposed is None else finger.unopposed.to_dict(),
        }

    def checked(checks: tuple[design.search.Check, ...]) -> dict[str, Any]:
        return {c.criterion.name: {"value": c.value, "wanted": c.criterion.wanted} for c in checks}

    best = study.fingers[0]
    return {
        "verdict": design.words.verdict_of(study),
        "remedies": {r.what: _remedy(study, r) for r in study.remedies},
        "judged": study.goals.accuracy.calibrated,
        "tolerances": {} if best.outcome is None else dict(best.outcome.amounts),
        "tolerances_stated": study.goals.tolerances is not None,
        "blind_spots_stated": study.goals.accuracy.blind_spots is not None,
        "fingers": [one(f) for f in study.fingers],
        "files": [str(path) for path in written],
    }


def _remedy(study: design.search.DesignStudy, remedy: design.search.Remedy) -> dict[str, Any]:
    row, goals = remedy.row, study.goals
    if row is None:
        return {"value": None}
    names = {"skin": goals.skins[row.skin].name, "sensor": goals.choices[row.sensor].name}
    return {"value": remedy.value, **names, "count": row.count, "depth": row.depth, "pitch": row.pitch}
