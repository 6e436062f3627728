"""`subskin pressure`: readings -> the pressure along the surface."""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING, Any

from .common import describe, number, say, show, write_json
from .frames import (
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

    from ..estimate.pressure.map import PressureMap
    from ..io.finger_file import FingerFile

_EXAMPLES = """\
  subskin pressure finger.toml readings.csv -o map.csv --figure map.png
  subskin pressure finger.toml readings.csv --shear none --totals forces.csv
  subskin pressure finger.toml readings.parquet -o map.parquet --rule discrepancy --rows 0-99
  subskin simulate finger.toml -o - --contact hertz --half-width "2 mm" | subskin pressure finger.toml - --json
"""
_NOTES = """\
The pressure is >= 0 and smooth; how smooth follows from each frame by a rule, and the resolution says how wide a narrow
load then looks. -o writes a row for each frame and each node along the surface, --totals a row for each frame. The
figure is of the first frame that has a contact.
"""
_MEANING = {
    "ok": "a pressure explains the readings",
    "ambiguous": "it reaches the edge of the search, or its angle may be any",
    "no_contact": "nothing beyond noise",
    "unexplained": "no pressure >= 0 explains the readings",
    "incomplete": "too few sensors could be used",
}
_SHOWN = ("normal_force", "normal_std", "centre", "angle", "resolution", "residual")


def add(parser: argparse.ArgumentParser) -> None:
    """Say what the command takes."""
    describe(parser, run, _EXAMPLES, _NOTES)
    parser.add_argument(
        "--rule",
        choices=("evidence", "discrepancy", "gcv"),
        default="evidence",
        help="by which the weight of smoothness is found (evidence)",
    )
    parser.add_argument(
        "--shear",
        choices=("none", "proportional", "free"),
        help="in proportion to the pressure; none; or free, for sensors of two kinds or depths (proportional; none "
        "where the finger has friction = 0)",
    )
    parser.add_argument("--totals", metavar="FILE", help="table of forces, a row a frame")
    add_frames(parser, "map", "table of pressures", "draw the pressure of the first frame")


def run(options: argparse.Namespace) -> int:
    """Run the command."""
    import numpy as np

    from ..estimate.pressure.map import PressureMap
    from ..estimate.pressure.mapper import PressureMapper
    from ..io.files import check_target
    from ..io.tables import write_table

    check_targets(options)
    if options.totals is not None:
        check_target(options.totals)
    file, _, rows, readings = read_frames(options)
    given = {k: v for k, v in (file.options or {}).items() if k in ("false_alarm", "friction")}
    shear = options.shear or ("none" if given.get("friction") == 0 else "proportional")
    if shear == "none":
        given.pop("friction", None)
    with told(options.finger):
        mapper = PressureMapper(file.finger, search=file.search, rule=options.rule, shear=shear, **given)
    parts = in_chunks(mapper, readings)
    found = PressureMap(
        np.concatenate([p.table for p in parts]), np.concatenate([p.used for p in parts]), mapper
    )
    totals = _totals(file, found, rows)
    if options.figure is not None:
        _draw(options, found, file.origin)
    if options.out is not None:
        write_table(options.out, _map(file, found, rows))
    if options.totals is not None:
        write_table(options.totals, totals)
    if options.json:
        write_json(
            {
                "frames": len(rows),
                "rule": options.rule,
                "shear": shear,
                "status": status_counts(found.status),
                "totals": totals,
                "y": found.y + file.origin,
                "pressure": found.pressure,
                "pressure_std": found.pressure_std,
                "shear_stress": found.shear,
                "resolution": found.resolution,
            }
        )
    else:
        _show(options, found, totals)
    return 0


def _totals(file: FingerFile, found: PressureMap, rows: npt.NDArray[np.intp]) -> dict[str, Any]:
    import numpy as np

    at = [np.interp(c, found.y, r) for c, r in zip(found.centre, found.resolution, strict=True)]
    return {
        "row": rows,
        "normal_force": found.normal_force,
        "tangential_force": found.tangential_force,
        "normal_std": found.normal_std,
        "tangential_std": found.tangential_std,
        "angle": found.angle,
        "angle_std": found.angle_std,
        "centre": found.centre + file.origin,
        "centre_std": found.centre_std,
        "resolution": np.array(at),
        "status": status_names(found.status),
        "residual": found.residual,
        "used": sensor_names(file, found.used),
    }


def _map(file: FingerFile, found: PressureMap, rows: npt.NDArray[np.intp]) -> dict[str, Any]:
    """A row for each node of each frame that has a contact."""
    import numpy as np

    there = np.flatnonzero(np.isfinite(found.normal_force))
    count = len(found.y)
    band = found.pressure_interval[there]
    return {
        "row": np.repeat(rows[there], count),
        "y": np.tile(found.y + file.origin, len(there)),
        "pressure": found.pressure[there].reshape(-1),
        "pressure_low": band[..., 0].reshape(-1),
        "pressure_high": band[..., 1].reshape(-1),
        "shear": found.shear[there].reshape(-1),
        "shear_std": found.shear_std[there].reshape(-1),
        "resolution": found.resolution[there].reshape(-1),
    }


def _draw(options: argparse.Namespace, found: PressureMap, origin: float) -> None:
    import numpy as np

    from ..errors import FileError
    from ..estimate.pressure.map import PressureMap
    from ..plot import pressure_figure, save

    there = np.flatnonzero(np.isfinite(found.normal_force))
    if not there.size:
        raise FileError(options.readings, "no frame has a contact to draw", "leave out --figure")
    one = PressureMap(found.table[there[0]], found.used[there[0]], found.mapper)
    save(pressure_figure(one, origin=origin), options.figure)


def _show(options: argparse.Namespace, found: PressureMap, totals: dict[str, Any]) -> None:
    out = say(options)
    show_statuses(options, found.status, _MEANING)
    if options.out is None and options.totals is None:
        first = [
            [str(totals["row"][i]), *(number(float(totals[n][i])) for n in _SHOWN), totals["status"][i]]
            for i in range(min(len(totals["row"]), 20))
        ]
        title = "the first frames, in SI; -o writes their pressures, --totals these"
        show(out, title, ["row", *_SHOWN, "status"], first)
    for target in (options.out, options.totals, options.figure):
        if target not in (None, "-"):
            print(f"-> {target}", file=out)
