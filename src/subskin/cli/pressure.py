"""`subskin pressure`: readings -> the pressure along the surface, or on an area."""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING, Any, TextIO

from .. import io
from .._lazy import np
from ..errors import FileError
from .common import give, refuse_response
from .options import MEANING, command, frames, option

if TYPE_CHECKING:
    import numpy.typing as npt

    from .answers import Answers

_EXAMPLES = """\
  subskin pressure finger.toml readings.csv -o map.csv --figure map.png
  subskin pressure finger.toml readings.csv --shear none --totals forces.csv
  subskin pressure finger.toml readings.parquet -o map.parquet --rule discrepancy --rows 0-99
  subskin pressure pad.toml readings.csv --totals forces.csv --movie press.gif --every 10
  subskin simulate finger.toml -o - --contact hertz --half-width "2 mm" | subskin pressure finger.toml - --json
"""
_NOTES = """\
The pressure is >= 0 and smooth. A rule finds from each frame how smooth. The resolution says how wide a narrow load
then looks. -o writes a row for each frame and each node along the surface, --totals a row for each frame. The figure
shows the first frame with a contact. Sensors on an area make an image of each frame, and --movie shows them all.
"""
_HERE = {
    **MEANING,
    "ok": "a pressure explains the readings",
    "ambiguous": "it reaches the edge of the search, or its angle is not determined",
    "unexplained": "no pressure >= 0 explains the readings",
}
_SHEAR = (
    "in proportion to the pressure; none; or free, in a row of sensors of two kinds or depths, on an area of "
    "three channels a position (proportional; none where the finger has friction = 0)"
)
_AT_ONCE = 1000  # frames: a map of each is held
_SHOWN = ("row", "normal_force", "normal_std", "centre", "angle", "resolution", "residual", "status")
_SHOWN_ON_AREA = ("row", "normal_force", "normal_std", "centre_y", "centre_z", "angle", "resolution", "status")


@command(
    _EXAMPLES,
    option("--rule {evidence,discrepancy,gcv}", "rule that finds the weight of smoothness (evidence)", "evidence"),
    option("--shear {none,proportional,free}", _SHEAR),
    option("--totals FILE", "table of forces, a row for each frame"),
    option("--movie FILE", "of sensors on an area, the images of up to 500 frames; .gif"),
    frames("map", "table of pressures", "draw the pressure of the first frame"),
    notes=_NOTES,
)
def run_pressure(options: argparse.Namespace) -> int:
    """Run the command."""
    from ..estimate.pressure import ImageMapper, PressureMapper, pressure_mapper
    from ..stream.stage import join
    from .answers import Kept, answers_of, show_first, show_statuses

    if options.movie is not None and not options.movie.lower().endswith(".gif"):
        raise FileError(f"--movie {options.movie}", "a movie is .gif", "--movie press.gif")

    def prepare(file: io.FingerFile) -> PressureMapper | ImageMapper:
        if options.movie is not None and not file.finger.array.on_area:
            raise FileError(f"--movie {options.movie}", "sensors in a row make no image", "--figure map.png")
        refuse_response(file, "the field of a pressure")
        given: dict[str, Any] = {k: v for k, v in file.options.items() if k in ("false_alarm", "friction")}
        shear = options.shear or ("none" if given.get("friction") == 0 else "proportional")
        if shear == "none":
            given.pop("friction", None)
        return pressure_mapper(file.finger, search=file.search, rule=options.rule, shear=shear, **given)

    maps, first, origin = [], None, 0.0
    mapper: Any = None
    answers_file: Any = None
    with Kept(options) as kept:
        table = None if options.totals is None else kept.enter_context(io.writing(options.totals))
        for answers in answers_of(options, prepare, at_once=_AT_ONCE):
            totals, found = _totals(answers), answers.found
            kept.add(totals, found.status, None if options.out is None else _map(answers))
            mapper, origin, answers_file = found.mapper, answers.file.origin, answers.file
            there = np.flatnonzero(np.isfinite(found.normal_force))
            if first is None and there.size:
                first = found[there[0]]
            if options.json or options.movie is not None:
                maps.append(found)
            if table is not None:
                table.write(totals)

        def data() -> dict[str, Any]:
            found = join(maps)
            return {
                "frames": kept.frames,
                "rule": options.rule,
                "shear": mapper.shear,
                "status": kept.status,
                "totals": kept.columns,
                **_nodes(found, answers_file),
                "pressure": found.pressure,
                "pressure_std": found.pressure_std,
                "shear_stress": _turned(found.shear, answers_file.turn) if mapper.array.on_area else found.shear,
                "resolution": found.resolution,
            }

        def people(out: TextIO) -> None:
            show_statuses(out, kept.status, _HERE)
            if not mapper.array.on_area:
                print("some pressure explains nearly any readings of a row: ok says nothing of whether the finger's "
                      "model is right; subskin locate and fit object to more", file=out)  # fmt: skip
            if options.out is None and options.totals is None:
                shown = _SHOWN_ON_AREA if mapper.array.on_area else _SHOWN
                show_first(
                    out,
                    kept.first,
                    (*shown, *(["force_unit"] if mapper.relative else [])),
                    "the first frames, in SI; -o writes their pressures, --totals these",
                )

        def drawn(plot: Any) -> Any:
            if first is None:
                raise FileError(options.readings, "no frame has a contact to draw", "leave out --figure")
            if mapper.array.on_area:
                return plot.pressure_image_figure(first, origin=origin, turn=answers_file.turn)
            return plot.pressure_figure(first, origin=origin)

        if options.movie is not None:
            from ..plot import pressure_movie

            pressure_movie(join(maps), options.movie, origin=origin, turn=answers_file.turn)
        done: dict[str | None, Any] = dict.fromkeys((options.out, options.totals), lambda _: kept.close())
        done[options.movie] = lambda _: None  # written above; named with the others
        return give(options, data, people, done, drawn)


def _totals(answers: Answers) -> dict[str, Any]:
    """A row for each frame."""
    from .answers import status_names

    found, file = answers.found, answers.file

    def told(*names: str) -> dict[str, Any]:
        return {name: getattr(found, name) for name in names}

    if not found.mapper.array.on_area:
        at = [np.interp(c, found.y, r) for c, r in zip(found.centre, found.resolution, strict=True)]
        forces = ("normal_force", "tangential_force", "normal_std", "tangential_std", "angle", "angle_std")
        own = told(*forces) | {"centre": found.centre + file.origin} | told("centre_std") | {"resolution": np.array(at)}
    else:
        force, centre = _turned(found.tangential_force, file.turn), file.on_touches(found.centre)
        own = {
            **told("normal_force", "normal_std"), "tangential_y": force[..., 0], "tangential_z": force[..., 1],
            **told("angle", "angle_std"), "azimuth": np.arctan2(force[..., 1], force[..., 0]),
            **told("azimuth_std", "moment", "moment_std"), "centre_y": centre[..., 0], "centre_z": centre[..., 1],
            "centre_std": np.hypot(*np.moveaxis(found.centre_std, -1, 0)) / np.sqrt(2),
            "resolution": _resolution_at_centre(found),
        }  # fmt: skip
    last = {"status": status_names(found.status), **told("residual"), "used": answers.used}
    return {"row": answers.rows, **own, **last, **_unit(found, len(answers.rows))}


def _resolution_at_centre(found: Any) -> npt.NDArray[np.float64]:
    """Of each image that at the node next to its centre, or at the first node where there is none."""
    y, z = np.meshgrid(found.y, found.z, indexing="ij")
    every, at = found.resolution.reshape(len(found.centre), -1), np.zeros(len(found.centre), dtype=np.intp)
    there = np.isfinite(found.normal_force)
    away = np.hypot(y - found.centre[there, 0, None, None], z - found.centre[there, 1, None, None])
    at[there] = away.reshape(int(there.sum()), -1).argmin(axis=1)
    return np.asarray(every[np.arange(len(every)), at])


def _unit(found: Any, rows: int) -> dict[str, Any]:
    """The column that says what forces are in, and pressures per area, where that is no newtons."""
    from ..estimate.estimate import unit_column

    return unit_column((rows,), found.mapper.relative)


def _nodes(found: Any, file: io.FingerFile) -> dict[str, Any]:
    """Where the nodes are on the axes of the tables: y, or y and z of each."""
    if not found.mapper.array.on_area:
        return {"y": found.y + file.origin}
    at = file.on_touches(np.stack(np.meshgrid(found.y, found.z, indexing="ij"), axis=-1))
    return {"y": at[..., 0], "z": at[..., 1]}


def _turned(drag: Any, turn: float) -> Any:
    """Drags (..., 2) on the finger, on the axes of the tables."""
    c, s = np.cos(turn), np.sin(turn)
    return drag @ np.array([[c, s], [-s, c]])


def _map(answers: Answers) -> dict[str, Any]:
    """A row for each node of each frame that has a contact."""
    there = np.flatnonzero(np.isfinite(answers.found.normal_force))
    found, band = answers.found[there], answers.found[there].pressure_interval
    nodes = _nodes(found, answers.file)
    count = nodes["y"].size
    each = {"pressure": found.pressure, "pressure_low": band[..., 0], "pressure_high": band[..., 1]}
    if found.mapper.array.on_area:
        drags = _turned(found.shear, answers.file.turn)
        each |= {"shear_y": drags[..., 0], "shear_z": drags[..., 1]}
        each["shear_std"] = np.sqrt((found.shear_std**2).mean(axis=-1))
    else:
        each |= {"shear": found.shear, "shear_std": found.shear_std}
    return {
        "row": np.repeat(answers.rows[there], count),
        **{axis: np.tile(at.reshape(-1), len(there)) for axis, at in nodes.items()},
        **{name: values.reshape(-1) for name, values in (each | {"resolution": found.resolution}).items()},
        **_unit(found, count * len(there)),
    }
