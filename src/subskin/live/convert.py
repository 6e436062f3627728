"""A recording made into another file: Parquet, CSV, MCAP, rosbag2, LeRobot; and bags made into recordings."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import closing
from pathlib import Path
from typing import Any

import numpy as np

from ..errors import FileError, UnknownOptionError
from ..io.files import apart, check_target, path_of, replacing
from ..io.tables import TableWriter
from .recording.files import write_parquet
from .recording.layout import columns_of
from .recording.source import RowSource, opened
from .sinks.lerobot import write_lerobot
from .sinks.messages import write_bag, write_mcap

__all__ = ["FOLDERS", "KINDS", "check_kind", "convert", "write"]


def _parquet(recording: RowSource, target: Path) -> None:
    with replacing(target) as part:
        write_parquet(part, recording.about, recording.batches(), "yes")


def _csv(recording: RowSource, target: Path) -> None:
    """The same rows and columns; what is not known is an empty cell."""
    kinds = columns_of(recording.about)
    empty = {name: np.empty(0, dtype="U1" if kind == "string" else kind) for name, kind in kinds.items()}
    with replacing(target) as part, closing(TableWriter(part, parquet=False)) as table:
        table.write(empty)
        for batch in recording.batches():
            columns = {}
            for name, kind in kinds.items():
                column = batch.column(name)
                texts = kind == "string"
                columns[name] = np.array(column.to_pylist(), dtype=object) if texts else column.to_numpy()
            table.write(columns)


def _mcap(recording: RowSource, target: Path, **options: Any) -> None:
    with replacing(target) as part:
        write_mcap(recording, part, **options)


KINDS: dict[str, Callable[..., object]] = {
    "parquet": _parquet, "csv": _csv, "mcap": _mcap, "rosbag2": write_bag, "lerobot": write_lerobot,
}  # fmt: skip
"""What a recording can be made into."""
FOLDERS = {"rosbag2", "lerobot"}
"""Those that are folders."""
_OPTIONS = {"mcap": {"topic"}, "rosbag2": {"topic"}, "lerobot": {"fps", "task"}}


def check_kind(target: str | Path, kind: str | None = None) -> str:
    """What a file of this name is to be: what was asked for, or by its ending.

    Parameters
    ----------
    target : path-like
        The file, or folder.
    kind : str, optional
        One of `KINDS`.

    Raises
    ------
    FileError, UnknownOptionError
        Neither says what it is to be.

    Examples
    --------
    >>> check_kind("touch.csv"), check_kind("touch", "lerobot")
    ('csv', 'lerobot')
    """
    if kind is not None:
        if kind not in KINDS:
            raise UnknownOptionError(
                f'"{kind}"', f"a recording can be made into {', '.join(KINDS)}", "name one of them"
            )
        return kind
    ending = path_of(target).suffix.lower().removeprefix(".")
    if ending not in KINDS:
        rule = f"its ending has to say what it is: {', '.join('.' + name for name in KINDS)}"
        raise FileError(str(target), rule, "name it touch.parquet, or say --to")
    return ending


def convert(path: str | Path, target: str | Path, kind: str | None = None, **options: Any) -> None:
    """Make a recording into another file, or a folder, whole or not at all; memory holds some thousand frames of it.

    Parameters
    ----------
    path : path-like
        The recording.
    target : path-like
        What is written.
    kind : str, optional
        One of `KINDS`; by the ending of `target` if left out.
    **options
        Of the kind: `topic` of mcap and rosbag2; `fps` and `task` of lerobot.

    Raises
    ------
    FileError, UnknownOptionError
        The recording is damaged, the target cannot be written, or its kind is not known.

    Examples
    --------
    >>> convert("touch.parquet", "touch.csv")
    Traceback (most recent call last):
    subskin.errors.FileError: touch.parquet: there is no such file. Fix: check the name and the folder.
    """
    chosen = check_kind(target, kind)
    with opened(path, whole=True) as recording:
        apart({"the recording": str(path)}, {"-o": str(target)})
        write(recording, target, chosen, **options)


def write(rows: RowSource, target: str | Path, kind: str, **options: Any) -> None:
    """Write rows of a recording, as `convert`.

    Parameters
    ----------
    rows : RowSource
        An open recording, or another source of its rows.
    target, kind, **options
        As of `convert`.

    Raises
    ------
    FileError, UnknownOptionError
        As `convert`.
    """
    if str(target) == "-":
        raise FileError("standard output", "a recording is written to a file", "name a file")
    if kind not in FOLDERS:
        check_target(target)
    unknown = set(options) - _OPTIONS.get(kind, set())
    if unknown:
        raise UnknownOptionError(f"{', '.join(sorted(unknown))}", f"{kind} has no such option", "leave it out")
    KINDS[kind](rows, Path(target), **options)
