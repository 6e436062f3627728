"""A recording in the Parquet layout of LeRobot, version 3.0: a folder of tables at a fixed rate."""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from ..._check import FloatArray
from ...errors import FileError, InvalidValueError
from ...io.files import making
from ..recording.layout import FRAME, About
from ..recording.source import RowSource
from .messages import STATUS

if TYPE_CHECKING:
    import pyarrow as pa

__all__ = ["write_lerobot"]

_GAP = 0.5
"""Seconds without a frame after which a new episode begins."""
_FILE = "chunk-{chunk_index:03d}/file-{file_index:03d}.parquet"
_COUNTED = ("frame_index", "episode_index", "index", "task_index")


def write_lerobot(recording: RowSource, path: Path, fps: float = 30.0, task: str = "touch") -> None:
    """Write it; the folder appears whole or not at all.

    Each tick takes the latest frame before it. Contacts that were not found are 0: their status says so.

    Parameters
    ----------
    recording : RowSource
        An open recording, or another source of its rows.
    path : Path
        The folder; there is none yet.
    fps : float, optional
        Ticks a second [1/s].
    task : str, optional
        What was done.

    Raises
    ------
    InvalidValueError
        A rate that is not above 0.
    FileError
        A recording without frames.
    """
    import pyarrow as pa
    import pyarrow.parquet as pq

    if not 0 < fps <= 1e5:
        raise InvalidValueError(f"fps = {fps}", "a rate above 0 is needed [1/s]", "fps=30")
    features = _features(recording.about)
    episodes, statistics = _Episodes(), _Statistics()
    with making(path) as part:
        data = part / "data" / _FILE.format(chunk_index=0, file_index=0)
        about = part / "meta" / "episodes" / _FILE.format(chunk_index=0, file_index=0)
        data.parent.mkdir(parents=True)
        about.parent.mkdir(parents=True)
        schema = pa.schema([(name, _type(feature)) for name, feature in features.items()])
        with pq.ParquetWriter(str(data), schema, compression="zstd", write_page_checksum=True) as writer:
            for values in _ticks(recording, fps, episodes):
                statistics.add(values)
                arrays = [_array(values[name], schema.field(name).type) for name in features]
                writer.write_table(pa.Table.from_arrays(arrays, schema=schema))
        if not episodes.lengths:
            raise FileError(recording.name, "it has no frames", "record again")
        pq.write_table(episodes.table(task), about)
        pq.write_table(_tasks(task), part / "meta" / "tasks.parquet")
        _json(part / "meta" / "stats.json", statistics.told())
        _json(part / "meta" / "info.json", _info(features, episodes, fps))


def _features(about: About) -> dict[str, dict[str, Any]]:
    """What each tick has: its shape, and the name of each number."""
    contact = [*(f"position_{axis}" for axis in about.axes), "normal", *(f"drag_{axis}" for axis in about.axes)]
    told = {"raw": list(about.channels), "readings": list(about.names), "contact": contact}
    found = {f"observation.tactile.{k}": _feature("float32", names) for k, names in told.items() if names}
    found["observation.tactile.status"] = _feature("int64", None)
    return {**found, "timestamp": _feature("float32", None), **{name: _feature("int64", None) for name in _COUNTED}}


def _feature(dtype: str, names: list[str] | None) -> dict[str, Any]:
    return {"dtype": dtype, "shape": [1 if names is None else len(names)], "names": names}


def _type(feature: dict[str, Any]) -> pa.DataType:
    import pyarrow as pa

    number = pa.float32() if feature["dtype"] == "float32" else pa.int64()
    return number if feature["names"] is None else pa.list_(number, feature["shape"][0])


def _array(values: npt.NDArray[Any], kind: pa.DataType) -> Any:
    import pyarrow as pa

    if values.ndim == 1:
        return pa.array(values, kind)
    return pa.FixedSizeListArray.from_arrays(pa.array(np.ascontiguousarray(values).reshape(-1)), values.shape[1])


class _Episodes:
    """Where each episode begins and ends."""

    def __init__(self) -> None:
        self.lengths: list[int] = []
        self.start = self.last = -np.inf

    def table(self, task: str) -> pa.Table:
        import pyarrow as pa

        ends = np.cumsum(self.lengths)
        zero = np.zeros(len(ends), dtype=np.int64)
        files = ("data/chunk_index", "data/file_index", "meta/episodes/chunk_index", "meta/episodes/file_index")
        return pa.table(
            {
                "episode_index": np.arange(len(ends)),
                "tasks": [[task]] * len(ends),
                "length": np.array(self.lengths),
                **dict.fromkeys(files, zero),
                "dataset_from_index": ends - self.lengths,
                "dataset_to_index": ends,
            }
        )


def _ticks(recording: RowSource, fps: float, episodes: _Episodes) -> Iterator[dict[str, npt.NDArray[Any]]]:
    """The ticks of the recording, some thousand at a time."""
    held: dict[str, npt.NDArray[Any]] | None = None
    for batch in recording.batches():
        columns = _columns(recording.about, batch)
        if not len(columns["time"]):
            continue
        if held is not None:  # the last frame before these may still be the latest of a tick
            columns = {name: np.concatenate([held[name], values]) for name, values in columns.items()}
        time = np.maximum.accumulate(columns["time"])
        held = {name: values[-1:] for name, values in columns.items()}
        held["time"] = time[-1:]
        for begin, end in _parts(time):
            if time[begin] - episodes.last > _GAP or not episodes.lengths:
                episodes.start = time[begin]
                episodes.lengths.append(0)
            episodes.last = time[end - 1]
            first = episodes.lengths[-1]
            count = int(np.floor((time[end - 1] - episodes.start) * fps + 1e-9)) + 1 - first
            if count > 0:
                yield _made(columns, time, slice(begin, end), first + np.arange(count), fps, episodes)


def _parts(time: FloatArray) -> Iterator[tuple[int, int]]:
    cuts = (np.flatnonzero(np.diff(time) > _GAP) + 1).tolist()
    yield from zip([0, *cuts], [*cuts, len(time)], strict=True)


def _made(
    columns: dict[str, Any], time: FloatArray, part: slice, tick: Any, fps: float, episodes: _Episodes
) -> dict[str, Any]:
    at = part.start + np.searchsorted(time[part], episodes.start + tick / fps + 1e-9 / fps, side="right") - 1
    total = sum(episodes.lengths)
    episodes.lengths[-1] += len(tick)
    numbers = {
        "timestamp": (tick / fps).astype(np.float32),
        "frame_index": tick,
        "episode_index": np.full(len(tick), len(episodes.lengths) - 1),
        "index": total + np.arange(len(tick)),
        "task_index": np.zeros(len(tick), dtype=np.int64),
    }
    return {name: values[np.maximum(at, 0)] for name, values in columns.items() if name != "time"} | numbers


def _columns(about: About, batch: pa.RecordBatch) -> dict[str, npt.NDArray[Any]]:
    """Time and features of the frames among some rows."""
    frames = np.array(batch.column("kind").to_pylist(), dtype=object) == FRAME
    time = batch.column("time").to_numpy()[frames]
    host = batch.column("host_time").to_numpy()[frames]
    found: dict[str, npt.NDArray[Any]] = {"time": np.where(np.isfinite(time), time, host)}
    contact = _features(about)["observation.tactile.contact"]["names"]
    lists = (("raw", [f"raw.{n}" for n in about.channels]), ("readings", [f"reading.{n}" for n in about.names]))
    for name, parts in (*lists, ("contact", contact)):
        if parts:
            table = np.column_stack([batch.column(p).to_numpy()[frames] for p in parts])
            table = np.nan_to_num(table, nan=0.0) if name == "contact" else table
            found[f"observation.tactile.{name}"] = table.astype(np.float32)
    texts = np.array(batch.column("status").to_pylist(), dtype=object)[frames]
    found["observation.tactile.status"] = np.array([STATUS.get(text, STATUS[""]) for text in texts], dtype=np.int64)
    keep = np.isfinite(found["time"])
    return {name: values[keep] for name, values in found.items()}


class _Statistics:
    """Least, largest, mean and standard deviation of each number, as they come."""

    def __init__(self) -> None:
        self._kept: dict[str, list[Any]] = {}

    def add(self, values: dict[str, npt.NDArray[Any]]) -> None:
        for name, column in values.items():
            table = column.reshape(len(column), -1).astype(np.float64)
            known = np.isfinite(table)
            count, total = known.sum(axis=0), np.where(known, table, 0.0).sum(axis=0)
            mean = total / np.maximum(count, 1)
            spread = np.where(known, (table - mean) ** 2, 0.0).sum(axis=0)
            least, most = np.where(known, table, np.inf).min(axis=0), np.where(known, table, -np.inf).max(axis=0)
            if name in self._kept:
                n, m, s, low, high = self._kept[name]
                both = np.maximum(n + count, 1)
                spread = s + spread + (mean - m) ** 2 * n * count / both
                mean = (n * m + count * mean) / both
                count, least, most = n + count, np.minimum(low, least), np.maximum(high, most)
            self._kept[name] = [count, mean, spread, least, most]

    def told(self) -> dict[str, dict[str, list[float]]]:
        out = {}
        for name, (count, mean, spread, least, most) in self._kept.items():
            std = np.sqrt(spread / np.maximum(count, 1))
            parts = {"min": least, "max": most, "mean": mean, "std": std}
            out[name] = {k: np.where(count > 0, v, 0.0).tolist() for k, v in parts.items()}
            out[name]["count"] = [int(count.max())]
        return out


def _tasks(task: str) -> pa.Table:
    """The table of tasks: its index, as pandas reads it, is the text."""
    import pyarrow as pa

    def column(name: str, kind: str, of: str) -> dict[str, Any]:
        return {"name": name, "field_name": name, "pandas_type": kind, "numpy_type": of, "metadata": None}

    told = {
        "index_columns": ["task"],
        "column_indexes": [],
        "columns": [column("task_index", "int64", "int64"), column("task", "unicode", "object")],
    }
    table = pa.table({"task_index": np.zeros(1, dtype=np.int64), "task": [task]})
    return table.replace_schema_metadata({"pandas": json.dumps(told)})


def _info(features: dict[str, Any], episodes: _Episodes, fps: float) -> dict[str, Any]:
    return {
        "codebase_version": "v3.0",
        "robot_type": "subskin",
        "total_episodes": len(episodes.lengths),
        "total_frames": sum(episodes.lengths),
        "total_tasks": 1,
        "chunks_size": 1000,
        "data_files_size_in_mb": 100,
        "video_files_size_in_mb": 500,
        "fps": int(fps) if float(fps).is_integer() else fps,
        "splits": {"train": f"0:{len(episodes.lengths)}"},
        "data_path": f"data/{_FILE}",
        "video_path": None,
        "features": features,
    }


def _json(path: Path, told: dict[str, Any]) -> None:
    path.write_text(json.dumps(told, indent=4) + "\n", "utf-8")
