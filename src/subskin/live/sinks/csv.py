"""A recording as CSV: the same rows and columns."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from ...io.tables import TableWriter
from ..recording.source import RowSource
from ..recording.table import columns_of

__all__ = ["write_csv"]


def write_csv(recording: RowSource, path: Path) -> None:
    """Write it; what is not known is an empty cell.

    Parameters
    ----------
    recording : RowSource
        An open recording, or another source of its rows.
    path : Path
        The file.
    """
    kinds = columns_of(recording.about)
    empty = {name: np.empty(0, dtype="U1" if kind == "string" else kind) for name, kind in kinds.items()}
    table = TableWriter(path, parquet=False)
    try:
        table.write(empty)
        for batch in recording.batches():
            columns = {}
            for name, kind in kinds.items():
                column = batch.column(name)
                texts = kind == "string"
                columns[name] = np.array(column.to_pylist(), dtype=object) if texts else column.to_numpy()
            table.write(columns)
    finally:
        table.close()
