"""What stands in a recording: one row a frame, a command, an event, or a step without frames, in the order of time.

No column has nulls: NaN, -1, 0 and "" say that there is nothing.
"""

from __future__ import annotations

import zlib
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from .about import About

if TYPE_CHECKING:
    import pyarrow as pa

__all__ = ["COMMAND", "DTYPE", "EMPTY", "EVENT", "FRAME", "STEP", "checksum", "columns_of", "contact_of", "described",
           "joined", "schema_of", "unknowns_of"]  # fmt: skip

FRAME, STEP, COMMAND, EVENT = "frame", "step", "command", "event"
_FLOAT, _INT, _TEXT = "double", "int64", "string"
EMPTY: dict[str, Any] = {_FLOAT: np.nan, _INT: -1, _TEXT: ""}
"""What says that there is nothing, by the kind of column."""
DTYPE: dict[str, Any] = {_FLOAT: np.float64, _INT: np.int64, _TEXT: object}


def columns_of(about: About) -> dict[str, str]:
    """The columns of a recording and what kind each is of: "double", "int64" or "string".

    Parameters
    ----------
    about : About
        What is recorded.

    Examples
    --------
    >>> about = About("", names=("s0",), channels=("p0",), axes="y", epoch=0.0)
    >>> list(columns_of(about))[:9]
    ['kind', 'step', 'frame', 'host_time', 'time', 'device_time', 'sequence', 'lost', 'bad']
    """
    unknown = unknowns_of(about.axes)
    found = [*contact_of(about.axes), "half_width", "beside", "point_probability", "residual", "second_chi2"]
    return {
        "kind": _TEXT, "step": _INT, "frame": _INT, "host_time": _FLOAT, "time": _FLOAT, "device_time": _FLOAT,
        "sequence": _INT, "lost": _INT, "bad": _INT,
        **{f"raw.{name}": _FLOAT for name in about.channels},
        **{f"reading.{name}": _FLOAT for name in about.names},
        "free": _INT, "load": _TEXT, "status": _TEXT,
        **dict.fromkeys(found, _FLOAT),
        **{f"cov.{a}.{b}": _FLOAT for i, a in enumerate(unknown) for b in unknown[i:]},
        "slip": _TEXT, "slip_ratio": _FLOAT, "slip_probability": _FLOAT,
        "name": _TEXT, "text": _TEXT, "values": _TEXT,
    }  # fmt: skip


def unknowns_of(axes: str) -> list[str]:
    """What the covariance is of, in its order: position, normal force and drag, by the names of the columns."""
    return [*axes, "n", *(f"t{axis}" for axis in axes)]


def contact_of(axes: str) -> list[str]:
    """The columns of a contact, in their order: position, normal force, drag."""
    return [*(f"position_{axis}" for axis in axes), "normal", *(f"drag_{axis}" for axis in axes)]


def described(about: About) -> list[str]:
    """Name and kind of each column, as checksums take them."""
    return [f"{name}: {kind}" for name, kind in columns_of(about).items()]


def schema_of(about: About) -> pa.Schema:
    """The Arrow schema of a recording, with all that it says about itself."""
    import pyarrow as pa

    types = {_FLOAT: pa.float64(), _INT: pa.int64(), _TEXT: pa.string()}
    fields = [pa.field(name, types[kind], nullable=False) for name, kind in columns_of(about).items()]
    told: Any = about.metadata(described(about))
    return pa.schema(fields, metadata=told)


def joined(batches: Sequence[pa.RecordBatch]) -> pa.RecordBatch:
    """Batches one after the other.

    Parameters
    ----------
    batches : sequence of pyarrow.RecordBatch
        At least one.
    """
    import pyarrow as pa

    parts = [] if len(batches) == 1 else pa.Table.from_batches(batches).combine_chunks().to_batches()
    return parts[0] if parts else batches[0]


def checksum(batch: pa.RecordBatch, number: int) -> str:
    """CRC-32 of all that stands in the rows of the batch with this number, whatever lies between them in a file."""
    crc = zlib.crc32(f"{number} {batch.num_rows}".encode())
    for column in batch.columns:
        _, *buffers = column.buffers()
        if len(buffers) == 1:  # numbers, 8 bytes each
            data = memoryview(buffers[0] or b"")[8 * column.offset : 8 * (column.offset + len(column))]
            crc = zlib.crc32(data, crc)
            continue
        ends = np.frombuffer(memoryview(buffers[0] or bytes(4)), np.int32)[
            column.offset : column.offset + len(column) + 1
        ]
        crc = zlib.crc32((ends - ends[0]).tobytes(), crc)
        crc = zlib.crc32(memoryview(buffers[1] or b"")[int(ends[0]) : int(ends[-1])], crc)
    return f"{crc:08x}"
