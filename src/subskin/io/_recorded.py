"""What a finger file makes of a raw recording: its table, and the presses in it."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ..errors import FileError, InvalidValueError

if TYPE_CHECKING:
    from .._check import FloatArray
    from ..array import SensorArray
    from ..stream import Presses
    from ..stream.presses import RecordingFormat
    from .tables import Table

__all__ = ["presses_of", "table_of"]


def table_of(given: object) -> Table | None:
    """The table that was given, by itself or by its path; None of anything else."""
    from .tables import Table, read_table

    return given if isinstance(given, Table) else read_table(given) if isinstance(given, str | Path) else None


def presses_of(
    given: object,
    how: RecordingFormat | None,
    array: SensorArray,
    frames: Callable[[Table], tuple[FloatArray, FloatArray]],
    name: str,
    changes: Mapping[str, float],
) -> Presses:
    """The presses of a raw recording as the file `name` describes it: readings and times by `frames`, in `array`."""
    from ..stream import segment

    table = table_of(given)
    if how is None:
        fix = 'add [recording] with sensors = ["s0", ...], time = {column = "time", unit = "s"}, position, press'
        raise FileError(name, "it has no table [recording] that says how to read one", fix)
    if table is None:
        raise InvalidValueError("recording", "a table with the columns of [recording] is needed", 'Path("raw.csv")')
    if not len(table):
        raise FileError(f"{table.name} has no rows below its header", "a recording needs frames", "record again")
    readings, time = frames(table)
    tracks = {
        key: table.numbers(column.name, finite=True, why=f"[recording] {key}") * column.scale
        for key in ("position", "press", "force")
        if (column := getattr(how, key)) is not None
    }
    options: dict[str, Any] = {key: getattr(how, key) for key in ("early", "before", "hold")} | dict(changes)
    values = readings * how.scale
    inside = array.inside(values)
    return segment(np.where(inside, values, np.nan), time, **tracks, **options)
