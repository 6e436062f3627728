"""`subskin locate`: readings -> where, how hard, at what angle."""

from __future__ import annotations

import argparse
import sys
from typing import TYPE_CHECKING, Any

from .common import describe, number, say, show, write_json
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
    from ..io.tables import Table

    FloatArray = npt.NDArray[np.float64]

_EXAMPLES = """\
  subskin locate finger.toml readings.csv -o located.csv
  subskin locate finger.toml readings.parquet -o located.parquet --truth position --figure truth.png
  subskin locate calibrated.toml presses.csv -o located.csv --every 2 --skip-used --truth position
  subskin locate finger.toml stream.csv -o located.csv --tare --outliers 1
  subskin simulate finger.toml -o - | subskin locate finger.toml - --json
"""
_NOTES = """\
Each row is a frame of raw readings. A missing reading (an empty cell) costs that sensor in that frame. Positions are
on the axis of the calibration's touches: the finger's own y plus the origin in [calibration]. With --tare the rows
are a stream that begins with the skin free: offsets are followed while nothing touches it, and taken off.
"""


def add(parser: argparse.ArgumentParser) -> None:
    """Say what the command takes."""
    describe(parser, run, _EXAMPLES, _NOTES)
    parser.add_argument("--truth", metavar="NAME", help="column of true positions [m] to compare with")
    parser.add_argument(
        "--tare",
        nargs="?",
        const="",
        metavar="DRIFT",
        help="take off the drift of a stream with a column of times; the fastest believed, reading/s "
        "(0.3 noise a second). A finger calibrated on presses that `segment` cut out: see docs/robust.md",
    )
    parser.add_argument(
        "--outliers",
        type=int,
        default=0,
        metavar="N",
        help="1: try unexplained frames without each one reading (0)",
    )
    parser.add_argument(
        "--skip-used", action="store_true", help="locate the rows that --every or --rows does not name"
    )
    add_frames(parser, "locate", "table of loads", "draw truth against estimate")


def run(options: argparse.Namespace) -> int:
    """Run the command."""
    import numpy as np

    from ..errors import InvalidValueError
    from ..io.tables import write_table

    if options.skip_used and options.every is None and options.rows is None:
        raise InvalidValueError("--skip-used", "it needs --every or --rows to say what was used", "--every 2")
    if options.figure is not None and options.truth is None:
        raise InvalidValueError("--figure", "it needs the true positions", "--truth position")
    check_targets(options)
    file, table, rows, readings = read_frames(options)
    with told(options.finger):
        locator = file.locator(outliers=options.outliers)
    if options.tare is not None:
        readings = _tared(options, file, table)[rows]
    truth = None
    if options.truth is not None:
        truth = table.numbers(options.truth, finite=True, why="the true position")[rows]
    parts = in_chunks(locator, readings)
    found = type(parts[0]).join(parts)
    columns = _columns(file, found, rows, truth)
    score = None
    if truth is not None:
        score = _score(columns["position"] - truth, columns["status"])
        y = truth - file.origin
        score["beyond_search"] = int(((y < locator.response.start) | (y > locator.response.stop)).sum())
    if options.figure is not None:
        _draw(options.figure, truth, columns, np.asarray(found.status))
    if options.out is not None:
        write_table(options.out, columns)
    if options.json:
        counts = status_counts(found.status)
        write_json({"frames": len(rows), "status": counts, "against_truth": score, "columns": columns})
    else:
        _show(options, found, columns, score)
    return 0


def _tared(options: argparse.Namespace, file: FingerFile, table: Table) -> FloatArray:
    """All readings with their drift off; rows that are not to be located are part of the stream too."""
    import numpy as np

    from ..errors import FileError, InvalidValueError, SubskinError
    from ..stream import Tare
    from ..stream.presses import Column

    column = file.recording.time if file.recording is not None else Column("time")
    time = table.numbers(column.name, finite=True, why="--tare: the time") * column.scale
    drift = None
    if options.tare:
        try:
            drift = float(options.tare)
        except ValueError:
            raise InvalidValueError(
                f'--tare "{options.tare}"', "a reading per second is needed, in the table's unit", "--tare 2"
            ) from None
    try:
        tared = Tare(file.finger, drift=drift)(table.readings(file.names), time)
    except SubskinError as error:
        raise FileError(f"{table.name}: {error.seen}", error.rule, error.fix) from None
    array = file.finger.array
    free, drawn = np.nanmedian(tared.offset, axis=0), np.asarray(array.offset)
    if (np.abs(free - drawn) > np.maximum(0.5 * np.abs(free), 100 * np.asarray(array.noise))).all():
        print(
            f"subskin: warning: the free skin reads {free[0]:.4g}, and the finger's offset is {drawn[0]:.4g}: a finger "
            "calibrated on presses cut out by segment knows differences, and misreads a stream (docs/robust.md)",
            file=sys.stderr,
        )
    return tared.readings


def _columns(
    file: FingerFile, found: Estimate, rows: npt.NDArray[np.intp], truth: FloatArray | None
) -> dict[str, Any]:
    std = found.std
    columns: dict[str, Any] = {
        "row": rows,
        "position": found.position + file.origin,
        "force": found.force,
        "angle": found.angle,
        "position_std": std[:, 0],
        "force_std": std[:, 1],
        "angle_std": std[:, 2],
        "status": status_names(found.status),
        "residual": found.residual,
        "second_position": found.second.position + file.origin,
        "second_chi2": found.second.chi2,
        "used": sensor_names(file, found.used),
    }
    if truth is not None:
        columns |= {"truth": truth, "error": columns["position"] - truth}
    return columns


def _score(error: FloatArray, status: npt.NDArray[np.object_]) -> dict[str, Any]:
    """Errors of position over the frames that are ok, and over all that were given a place."""
    import numpy as np

    placed = np.isfinite(error)
    score: dict[str, Any] = {"frames": len(error)}
    for name, chosen in (("ok", placed & (status == "ok")), ("placed", placed)):
        size, e = np.abs(error[chosen]), error[chosen]
        values: dict[str, float] = {"count": int(chosen.sum())}
        if size.size:
            values |= {
                "median": float(np.median(size)),
                "percentile_95": float(np.quantile(size, 0.95)),
                "mean": float(e.mean()),
                "worst": float(size.max()),
            }
        score[name] = values
    return score


def _draw(path: str, truth: FloatArray | None, columns: dict[str, Any], status: npt.NDArray[np.int8]) -> None:
    from ..plot import save, truth_against_estimate

    if truth is not None:
        std = columns["position_std"]
        save(truth_against_estimate(truth, columns["position"], std=std, status=status), path)


def _show(
    options: argparse.Namespace, found: Estimate, columns: dict[str, Any], score: dict[str, Any] | None
) -> None:
    out = say(options)
    show_statuses(options, found.status, MEANING)
    if score is not None:
        rows = [
            [
                label,
                str(score[key]["count"]),
                *(number(score[key].get(k, float("nan")) * 1e3, 3) for k in _ERRORS),
            ]
            for key, label in (("ok", "status ok"), ("placed", "all with a place"))
        ]
        show(out, "error of position [mm]", ["frames", "count", "median", "95 %", "mean", "worst"], rows)
        if score["beyond_search"]:
            print(f"{score['beyond_search']} true places lie beyond the search and cannot be found", file=out)
    count = len(columns["row"])
    if options.out is None:
        names = ["row", "position", "force", "angle", "position_std", "status"]
        first = [
            [columns[n][i] if n == "status" else number(float(columns[n][i])) for n in names]
            for i in range(min(count, 20))
        ]
        show(out, "the first frames, in SI; -o writes them all", names, first)
    elif options.out != "-":
        print(f"-> {options.out}", file=out)
    if options.figure is not None:
        print(f"-> {options.figure}", file=out)


_ERRORS = ("median", "percentile_95", "mean", "worst")
