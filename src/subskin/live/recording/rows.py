"""Batches of a chain as rows of a recording."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from ...decide import Slip, SlipVerdict
from ...estimate.answer import Status
from ...estimate.either import Either
from ...estimate.estimate import Estimate
from ...io.files import plain
from ..batch import Batch
from .layout import COMMAND, DTYPE, EMPTY, EVENT, FRAME, STEP, About, columns_of, contact_of, schema_of, unknowns_of

if TYPE_CHECKING:
    import pyarrow as pa

__all__ = ["Counted", "decided_columns", "found_columns", "rows_of", "table_of"]

Columns = dict[str, npt.NDArray[Any]]

_STATUS: npt.NDArray[np.object_] = np.array([status.name.lower() for status in Status], dtype=object)
_SLIP: Mapping[int, str] = {int(verdict): verdict.name.lower() for verdict in SlipVerdict}


def found_columns(axes: str, parts: list[Any]) -> Columns:
    """The columns of estimates, one after the other.

    Parameters
    ----------
    axes : str
        "y" or "yz".
    parts : list of Estimate or Either
        All of one kind.
    """
    whole = type(parts[0]).join(parts) if len(parts) > 1 else parts[0]
    columns = _either(whole, axes) if isinstance(whole, Either) else _estimate(whole, axes)
    return {**columns, "status": _STATUS[whole.status]}


def _estimate(found: Estimate, axes: str) -> Columns:
    layout, position = found.layout, found.position
    position = position[:, None] if layout.dim == 1 else position
    columns: Columns = dict(zip(contact_of(axes), np.hstack([position, found.components]).T, strict=True))
    unknown, covariance = unknowns_of(axes), found.table[:, layout.square]
    for i, a in enumerate(unknown):
        for j in range(i, len(unknown)):
            columns[f"cov.{a}.{unknown[j]}"] = covariance[:, i, j]
    kind = "point" if layout.dim == 2 or layout.aside else "line"
    columns["load"] = np.where(np.isfinite(columns["normal"]), kind, "").astype(object)
    columns |= {name: getattr(found, name) for name in ("half_width", "beside", "residual")}
    return {**columns, "second_chi2": found.second.chi2}


def _either(found: Either, axes: str) -> Columns:
    """Of the likeliest contact; the position is that of all together."""
    parts = [_estimate(part, axes) for part in (found.line, found.on_row, found.point)]
    which = [found.likeliest == k for k in range(len(parts))]
    columns: Columns = {
        name: np.select(which, [part[name] for part in parts], np.nan) for name in parts[0] if name != "load"
    }
    columns |= {"position_y": found.position, "cov.y.y": found.position_std**2}
    columns["load"] = np.select(which, [part["load"] for part in parts], "").astype(object)
    return {**columns, "point_probability": found.point_probability}


def decided_columns(parts: list[Slip]) -> Columns:
    """The columns of decisions about slip, one after the other.

    Parameters
    ----------
    parts : list of Slip
        Each of shape (n,).
    """
    ratio, told = (np.concatenate([getattr(part, name) for part in parts]) for name in ("ratio", "probability"))
    verdict = np.concatenate([part.verdict for part in parts])
    names = np.array([_SLIP[int(v)] for v in verdict], dtype=object)
    return {"slip": names, "slip_ratio": ratio, "slip_probability": told}


class Counted:
    """Numbers the steps and frames of a recording while they are written.

    Parameters
    ----------
    about : About
        What is recorded.
    """

    def __init__(self, about: About) -> None:
        self.about, self.steps, self.frames = about, 0, 0

    def rows(self, batches: Sequence[Batch]) -> pa.RecordBatch:
        """The rows of the next batches of a chain."""
        made = rows_of(self.about, batches, self.steps, self.frames)
        self.steps += len(batches)
        self.frames += sum(len(batch.raw) for batch in batches)
        return made


def rows_of(about: About, batches: Sequence[Batch], step: int = 0, frame: int = 0) -> pa.RecordBatch:
    """The rows of some batches of a chain, as Arrow holds them.

    Parameters
    ----------
    about, batches, step, frame
        As of `table_of`.
    """
    import pyarrow as pa

    kinds, columns = columns_of(about), table_of(about, batches, step, frame)
    arrays = [
        pa.array(columns[name], pa.string()) if kind == "string" else pa.array(np.ascontiguousarray(columns[name]))
        for name, kind in kinds.items()
    ]
    return pa.RecordBatch.from_arrays(arrays, schema=schema_of(about))


def table_of(about: About, batches: Sequence[Batch], step: int = 0, frame: int = 0) -> dict[str, npt.NDArray[Any]]:
    """The columns of the rows of some batches of a chain.

    Parameters
    ----------
    about : About
        What is recorded.
    batches : sequence of Batch
        What came out of the chain, in its order.
    step, frame : int, optional
        Number of the first step and of the first frame.
    """
    frames = _frames([b for b in batches if len(b.raw)], about)
    counts = np.array([len(b.raw) for b in batches], dtype=np.int64)
    steps = step + np.arange(len(batches))
    total = int(counts.sum())
    frames |= {"step": np.repeat(steps, counts), "frame": frame + np.arange(total)}
    frames["kind"] = np.full(total, FRAME, dtype=object)
    bare = [_bare(int(steps[i]), batch) for i, batch in enumerate(batches) if not counts[i]]
    told = [_told(int(steps[i]), event) for i, batch in enumerate(batches) for event in batch.events]
    extra = [*bare, *told]
    order = None
    if extra:
        key = [*(2 * frames["step"]), *(2 * row["step"] for row in bare), *(2 * row["step"] + 1 for row in told)]
        order = np.argsort(np.array(key), kind="stable")
    columns = {}
    for name, kind in columns_of(about).items():
        values = frames.get(name)
        if values is None:
            values = np.full(total, EMPTY[kind], dtype=DTYPE[kind])
        if order is not None:
            more = np.array([row.get(name, EMPTY[kind]) for row in extra], dtype=DTYPE[kind])
            values = np.concatenate([values, more])[order]
        columns[name] = values
    return columns


def _bare(step: int, batch: Batch) -> dict[str, Any]:
    """The row of a step without frames: a command, or nothing that came in time."""
    row = {"kind": COMMAND if batch.command else STEP, "step": step, "host_time": batch.host_time}
    row |= {"lost": batch.lost, "bad": batch.bad}
    if batch.command:
        row |= {"name": batch.command, "values": _json(batch.values)}
    return row


def _told(step: int, event: Any) -> dict[str, Any]:
    told = {"name": event.kind, "text": event.text, "values": _json(event.values)}
    return {"kind": EVENT, "step": step, "time": event.time, "frame": event.frame, **told}


def _json(values: Mapping[str, Any]) -> str:
    """Values as JSON; what is no number there is null."""
    return json.dumps(plain(values), allow_nan=False) if values else ""


def _frames(batches: Sequence[Batch], about: About) -> dict[str, Any]:
    """The columns of the frames of batches, each of which has some."""
    if not batches:
        return {}
    counts = np.array([len(b.raw) for b in batches])
    first = np.concatenate([[0], np.cumsum(counts)[:-1]])
    columns: dict[str, Any] = {"host_time": np.repeat([b.host_time for b in batches], counts)}
    for name in ("time", "device_time", "sequence"):
        columns[name] = np.concatenate([getattr(b, name) for b in batches])
    for name in ("lost", "bad"):  # of a step: on its first row
        values = np.zeros(counts.sum(), dtype=np.int64)
        values[first] = [getattr(b, name) for b in batches]
        columns[name] = values
    columns["free"] = np.concatenate([b.free for b in batches]).astype(np.int64)
    for prefix, names, tables in (
        ("raw", about.channels, [b.raw for b in batches]),
        ("reading", about.names, [b.readings for b in batches]),
    ):
        table = np.concatenate(tables)
        columns |= {f"{prefix}.{name}": table[:, i] for i, name in enumerate(names)}
    columns |= _runs([b.found for b in batches], counts, partial(found_columns, about.axes))
    return columns | _runs([b.decision for b in batches], counts, decided_columns)


def _runs(
    given: Sequence[Any], counts: npt.NDArray[np.int64], columns: Callable[[list[Any]], dict[str, npt.NDArray[Any]]]
) -> dict[str, npt.NDArray[Any]]:
    """`columns` of what was given with each batch, joined before they are made; batches without any stay empty."""
    have = [i for i, one in enumerate(given) if one is not None]
    if not have:
        return {}
    joined = columns([given[i] for i in have])
    if len(have) == len(given):
        return joined
    first = np.concatenate([[0], np.cumsum(counts)[:-1]])
    rows = np.concatenate([first[i] + np.arange(counts[i]) for i in have])
    out = {}
    for name, values in joined.items():
        out[name] = np.full(int(counts.sum()), "" if values.dtype == object else np.nan, dtype=values.dtype)
        out[name][rows] = values
    return out
