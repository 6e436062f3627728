"""What is left of a recording that was not closed, or was damaged, made into one that is whole."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from ..._frozen import Frozen
from ..._path import path_of
from ...errors import FileError
from ...io.files import apart, check_target, replacing
from .parquet import write_parquet
from .source import opened
from .stream import ENDING

if TYPE_CHECKING:
    import pyarrow as pa

__all__ = ["Recovered", "recover"]


@dataclass(frozen=True)
class Recovered(Frozen):
    """What was found.

    Parameters
    ----------
    path : Path
        The recording that was written.
    rows, frames : int
        Its rows, and the frames among them.
    seconds : float
        From its first frame to its last [s].
    left : str
        What could not be read; "" where all could.
    closed : bool
        The recording had been closed, and nothing was wrong with it.
    """

    path: Path
    rows: int
    frames: int
    seconds: float
    left: str
    closed: bool


def recover(path: str | Path, target: str | Path | None = None) -> Recovered:
    """Write all that can be read of a recording to a new file, Parquet; the old one stays as it is.

    A stream that was cut off anywhere gives all batches up to the cut. A batch whose checksum is wrong is left out.

    Parameters
    ----------
    path : path-like
        What is left: a file that ends in .arrows.
    target : path-like, optional
        The new file; the name of the old one without .arrows if left out.

    Raises
    ------
    FileError
        Nothing can be read, or the new file cannot be written.

    Examples
    --------
    >>> recover("touch.parquet.arrows")
    Traceback (most recent call last):
    subskin.errors.FileError: touch.parquet.arrows: there is no such file. Fix: check the name and the folder.
    """
    new = path_of(_named(path) if target is None else target)
    with opened(path) as recording:
        apart({"the recording": str(path)}, {"-o": str(new)})
        if target is None and new.exists():
            raise FileError(str(new), "there is such a file already", "name another one with -o")
        check_target(new)
        counts = _Counts()
        with replacing(new) as part:
            batches = counts.passed(recording.batches())
            first = next(batches, None)
            if first is None:
                raise FileError(str(path), f"no frame can be read{_because(recording.left)}", "record again")

            def rest() -> Iterator[pa.RecordBatch]:
                yield first
                yield from batches

            rows = write_parquet(part, recording.about, rest(), "recovered")
        whole = recording.closed and not recording.left
        return Recovered(new, rows, counts.frames, counts.seconds, recording.left, whole)


def _because(left: str) -> str:
    return f" ({left})" if left else ""


def _named(path: str | Path) -> str:
    name = str(path)
    if not name.endswith(ENDING):
        return f"{name}.recovered.parquet"
    name = name.removesuffix(ENDING)
    return name if name.endswith(".parquet") else f"{name}.parquet"


class _Counts:
    """Counts what passes."""

    def __init__(self) -> None:
        self.frames, self._first, self._last = 0, float("nan"), float("nan")

    def passed(self, batches: Iterator[pa.RecordBatch]) -> Iterator[pa.RecordBatch]:
        for batch in batches:
            kinds = batch.column("kind").to_pylist()
            time = batch.column("time").to_numpy()[[i for i, kind in enumerate(kinds) if kind == "frame"]]
            self.frames += len(time)
            if time.size:
                self._first = time[0] if self._first != self._first else self._first
                self._last = time[-1]
            yield batch

    @property
    def seconds(self) -> float:
        return float(self._last - self._first) if self.frames else 0.0
