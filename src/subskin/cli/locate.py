"""`subskin locate`: readings -> where, how hard, at what angle."""

from __future__ import annotations

import argparse
import sys
from typing import TYPE_CHECKING, Any, TextIO

from .. import io
from .._lazy import np
from ..errors import InvalidValueError, SubskinError
from .common import give, note_orientation, number, refuse_response, show
from .options import MEANING, command, frames, option

if TYPE_CHECKING:
    import numpy.typing as npt

_EXAMPLES = """\
  subskin locate finger.toml readings.csv -o located.csv
  subskin locate finger.toml readings.parquet -o located.parquet --truth position --figure truth.png
  subskin locate calibrated.toml presses.csv -o located.csv --every 2 --skip-used --truth position
  subskin locate finger.toml stream.csv -o located.csv --tare --outliers 1
  subskin locate pad.toml readings.csv -o touches.csv --touches 2
  subskin locate pad.toml readings.csv -o loads.csv --load resultant
  subskin simulate finger.toml -o - | subskin locate finger.toml - --json
"""
_NOTES = """\
Each row is a frame of raw readings. A missing reading (an empty cell) leaves its sensor out of that frame. Positions
are on the axis of the calibration's touches: the finger's own y plus the origin in [calibration]; on an area on their
axes y and z, and so are drags. With --tare the rows are a stream that begins with the skin free: offsets are followed
while nothing touches the skin, and subtracted.
"""


_LOAD = (
    "what presses on a row ([locate]; else either of a skin in space, or line); on an area a point, or a patch; "
    "resultant, on both: the force and the centre of whatever presses"
)
_LOOKED_AT = 50
"""Unexplained frames in which two touches are looked for, at most."""
_DRAWN = (("truth", ""), ("position", ""), ("position", "_std"))
_SHOWN = (
    "row", "touches", "position", "position_y", "position_z", "force", "angle", "azimuth",
    "half_width", "beside", "force_unit", "point_probability", "position_std", "position_y_std", "position_z_std",
    *(f"{name}_{t}" for t in (1, 2, 3) for name in ("position_y", "position_z", "force", "force_unit")), "status",
)  # fmt: skip


@command(
    _EXAMPLES,
    option("--load {line,point,either,patch,resultant}", _LOAD),
    option("--beside M", "largest distance beside the row of a point (default: 3 depths)"),
    option("--touches N", "the most touches at once on an area, up to 3 (1)", 1),
    option("--truth NAME", "column of true positions [m] to compare with; on an area two, y,z"),
    option("--outliers N", "1: try unexplained frames without each reading in turn (0)", 0),
    option("--skip-used", "locate the rows that --every or --rows does not name"),
    frames("locate", "table of loads", "draw truth against estimate"),
    notes=_NOTES,
)
def run_locate(options: argparse.Namespace) -> int:
    """Run the command."""
    from .answers import Kept, against, answers_of, estimate_columns, show_first, show_statuses

    if options.skip_used and options.every is None and options.rows is None:
        raise InvalidValueError("--skip-used", "it needs --every or --rows to say what was used", "--every 2")
    if options.figure is not None and options.truth is None:
        raise InvalidValueError("--figure", "it needs the true positions", "--truth position")
    if options.touches != 1 and options.truth is not None:
        seen = f"--truth with --touches {options.touches}"
        raise InvalidValueError(seen, "a true position is that of one touch", "leave one of both out")
    axes = ("",) if options.truth is None or "," not in options.truth else ("_y", "_z")
    names = [f"{name}{axis}{more}" for name, more in _DRAWN for axis in axes]
    drawn = names if options.figure is not None else []
    sensors: Any = None
    beyond, score = 0, None
    with Kept(options, () if options.truth is None else ("error", "status", *drawn)) as kept:
        single = _Single(_chosen(options))
        for answers in answers_of(options, single.of):
            columns, array = estimate_columns(answers), answers.file.finger.array
            sensors = answers.file.on_touches(array.points) if array.on_area else None
            if options.truth is not None:
                columns |= against(columns, answers, options.truth)
                beyond += int(columns.pop("beyond").sum())
            kept.add(columns, answers.found.status)
        note_orientation(answers.file)
        single.note()
        if options.truth is not None:
            score = {**_score(kept.columns["error"], kept.columns["status"]), "beyond_search": beyond}

        def people(out: TextIO) -> None:
            said = (
                MEANING
                if options.touches == 1
                else {**MEANING, "ok": "so many loads explain the readings, and no other number"}
            )
            show_statuses(out, kept.status, said)
            if score is not None:
                _show_score(out, score)
            if options.out is None:
                show_first(out, kept.first, [name for name in _SHOWN if name in kept.first])

        return give(
            options,
            lambda: {"frames": kept.frames, "status": kept.status, "against_truth": score, "columns": kept.columns},
            people,
            kept.files,
            lambda plot: _drawn(plot, kept.columns, sensors),
        )


class _Single:
    """The locator of the options; of one touch on an area it keeps some frames that no touch explains."""

    def __init__(self, chosen: dict[str, Any]) -> None:
        self.chosen, self.left = chosen, list[Any]()

    def of(self, file: io.FingerFile) -> Any:
        """What answers the frames of a file."""
        if self.chosen.get("load") == "resultant":
            return _resultants(file, self.chosen)
        self.file, self.answer = file, file.locator(**self.chosen)
        self.takes_doubt = getattr(self.answer, "takes_doubt", False)
        return self if file.finger.array.on_area and self.chosen["touches"] == 1 else self.answer

    def __call__(self, readings: Any, **more: Any) -> Any:
        from ..estimate.answer import Status

        found = self.answer(readings, **more)
        if len(self.left) < _LOOKED_AT:
            self.left += list(readings[found.status == Status.UNEXPLAINED][: _LOOKED_AT - len(self.left)])
        return found

    def note(self) -> None:
        """Say where two touches explain what one does not."""
        from ..estimate.answer import Status

        if not self.left:
            return
        try:
            two = self.file.locator(touches=2)(np.array(self.left)).status
        except SubskinError:  # of a finger that knows no two
            return
        if count := int(np.isin(two, (Status.OK, Status.AMBIGUOUS)).sum()):
            what = f"two touches at once explain {count} of {len(self.left)} unexplained frames that were looked at"
            print(f"subskin: note: {what}. Fix: --touches 2", file=sys.stderr)


def _resultants(file: io.FingerFile, chosen: dict[str, Any]) -> Any:
    """What answers with resultants."""
    from ..estimate import ResultantReader

    others = {"outliers": 0, "touches": 1, "load": "resultant"}
    if chosen != others:
        said = ", ".join(f"--{name} {value}" for name, value in chosen.items() if value != others.get(name))
        raise InvalidValueError(
            f"{said} with --load resultant", "it takes whatever presses for one load", "leave it out"
        )
    refuse_response(file, "a resultant")
    return ResultantReader(file.finger)


def _chosen(options: argparse.Namespace) -> dict[str, Any]:
    """The options of the locator that the command line sets."""
    chosen: dict[str, Any] = {"outliers": options.outliers, "touches": options.touches}
    if options.load is not None:
        chosen["load"] = options.load
    if options.beside is not None:
        chosen["beside"] = io.quantity(options.beside, "m", "--beside")
    return chosen


def _drawn(plot: Any, columns: dict[str, Any], sensors: Any) -> Any:
    from ..estimate.answer import Status

    status = np.array([Status[name.upper()] for name in columns["status"]], dtype=np.int8)
    if "truth" in columns:
        std = columns["position_std"]
        return plot.truth_against_estimate(columns["truth"], columns["position"], std=std, status=status)
    truth, found, std = (np.stack([columns[f"{name}_{axis}{more}"] for axis in "yz"], axis=-1) for name, more in _DRAWN)
    covariance = std[..., None] ** 2 * np.eye(2)
    return plot.truth_above(found, truth, status=status, covariance=covariance, sensors=sensors)


def _score(error: npt.NDArray[np.float64], status: npt.NDArray[np.str_]) -> dict[str, Any]:
    """Errors of position over the frames that are ok, and over all that were given a position."""
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


def _show_score(out: TextIO, score: dict[str, Any]) -> None:
    shown = ("median", "percentile_95", "mean", "worst")
    rows = [
        [label, str(score[key]["count"]), *(number(score[key].get(k, float("nan")) * 1e3, 3) for k in shown)]
        for key, label in (("ok", "status ok"), ("placed", "all with a position"))
    ]
    show(out, "error of position [mm]", ["frames", "count", "median", "95 %", "mean", "worst"], rows)
    if score["beyond_search"]:
        print(f"{score['beyond_search']} true positions lie beyond the search and cannot be found", file=out)
