"""What the commands take that answer frame by frame, and what their statuses mean."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from ..errors import InvalidValueError
from .common import add_figure, add_rows, add_shared, number

if TYPE_CHECKING:
    import numpy as np
    import numpy.typing as npt

    from .. import io

__all__ = [
    "AREA_COLUMNS",
    "MEANING",
    "add_frames",
    "forces_said",
    "refuse_response",
    "warn_of_depths",
    "warn_of_raw",
    "warn_of_spread",
]

AREA_COLUMNS = ("position_y", "position_z")
"""Positions on an area, in tables."""

_ALIKE = 0.05  # presses whose depths differ by less are alike

MEANING = {
    "ok": "one load explains the readings",
    "ambiguous": "another load explains them nearly as well, or the position is at the edge of the search",
    "no_contact": "nothing beyond noise",
    "unexplained": "no pressing load within the friction cone explains the readings",
    "incomplete": "too few sensors could be used",
}
"""What each status says, in words."""


def add_frames(parser: argparse.ArgumentParser, verb: str, what: str, figure: str) -> None:
    """The finger, the readings, --tare, --figure, --every and --rows, -o and --json."""
    parser.add_argument("finger", help="finger.toml, best as calibrated")
    parser.add_argument("readings", help="table of readings, CSV or Parquet; - for standard input")
    parser.add_argument(
        "--tare",
        nargs="?",
        const="",
        metavar="DRIFT",
        help="the rows are a raw stream, with a column of times: convert the units of [recording], undo "
        "[relaxation], and subtract drift; DRIFT is the fastest believed, reading/s ([tare], or 0.3 noise a second)",
    )
    add_figure(parser, figure)
    add_rows(parser, f"{verb} only")
    add_shared(parser, what)


def refuse_response(file: io.FingerFile, what: str) -> None:
    """Raise where the finger of the file has a response in place, which does not know `what`.

    Raises
    ------
    InvalidValueError
        It has one.
    """
    if file.finger.measured is not None:
        rule = f"a response in place knows the contact of its touches alone, and not {what}"
        fix = "remove the line response = ... of [calibration]: the skin's field then answers; or subskin locate"
        raise InvalidValueError("[calibration] response", rule, fix)


def forces_said(file: io.FingerFile, loads: Mapping[str, Any], column: str | None) -> str:
    """What forces found with a finger calibrated on touches with these `loads` are in; "" where a `column` said it."""
    from ..loads import force_unit

    if "force" not in loads:
        return "forces found with this finger are multiples of the touches' load (no --force-column)"
    force = file.one_force
    if column or force is None:
        return ""
    return f"every touch carries {number(force)} {force_unit(file.finger.array.on_area)} (normal_force under [locate])"


def warn_of_depths(table: io.Table, fix: str) -> None:
    """Warn where presses have several approaches, and no force says how hard each was."""
    if "depth" in table.columns and len(table):
        depth = table.numbers("depth")
        warn_of_spread(table.name, depth, fix)


def warn_of_spread(name: str, depth: npt.NDArray[np.float64], fix: str) -> None:
    """The same, of the presses' depths [m]."""
    low, high = 1e3 * float(depth.min()), 1e3 * float(depth.max())
    if high - low > _ALIKE * high:
        what = f"presses of {low:.3g} to {high:.3g} mm, and no force"
        rule = "presses without a force are all taken to be alike, and a deeper press is harder"
        print(f"subskin: warning: {name}: {what}: {rule}. Fix: {fix}", file=sys.stderr)


def warn_of_raw(options: argparse.Namespace, file: io.FingerFile, table: io.Table | io.TableReader) -> None:
    """Say where a raw recording is read without --tare, though its unit or its offsets are not the finger's."""
    how = file.recording
    if options.tare is not None or how is None or (how.scale == 1 and not file.differences):
        return
    if {column.name for column in (how.time, how.press) if column is not None} <= set(table.columns):
        what = "it has the columns of a raw recording, and the finger reads SI units without offsets"
        print(f"subskin: warning: {table.name}: {what}. Fix: --tare reads it by [recording]", file=sys.stderr)
