"""Touches to learn from in a Zarr store, written shard by shard: what is stopped goes on, what is there is whole."""

from __future__ import annotations

import json
import shutil
import tempfile
import time
import warnings
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from .. import __version__, _check
from .._tasks import Executor, run_tasks
from ..errors import FileError, WorkersError
from ..synthetic import FAULTS, RandomTouches, TouchShard
from .files import check_target, needed, path_of, umask
from .tables import writing
from .touches_file import CHUNK, TouchesFile

__all__ = ["TouchesCost", "cost_of_touches", "save_touches", "shards_done", "write_touches"]

_ORDER = ("parameters", "labels", "readings")
"""In which the arrays of a shard are written."""
_SECONDS = 10.0
"""How long the first shard is measured for, at most, in CPU time."""


@dataclass(frozen=True)
class TouchesCost:
    """What touches will cost, from the first shard of them.

    Parameters
    ----------
    touches, shards : int
        How many.
    size : float
        Of the store [bytes].
    core_hours : float
        CPU time of all of them, on a core like this [h].
    measured : int
        How many touches of the first shard were computed and written for that.
    """

    touches: int
    shards: int
    size: float
    core_hours: float
    measured: int


def save_touches(
    file: TouchesFile,
    path: str | Path,
    *,
    executor: Executor | None = None,
    workers: int | None = None,
    progress: Callable[[int], object] | None = None,
) -> npt.NDArray[np.intp]:
    r"""Compute the touches of `file` into the Zarr store at `path`, or go on with it.

    The store has `readings` (touch, sensor), `parameters` (touch, parameter), `labels` (touch, label) and `done`
    (shard), with their names for xarray. Needs Zarr, `pip install "subskin[touches]"`.

    Parameters
    ----------
    file : TouchesFile
        The touches.
    path : path-like
        A folder, of which the parent exists.
    executor : executor, optional
        Computes and writes the shards, into the same folder: anything with `submit` (docs/scale.md).
    workers : int, optional
        How many threads do it without an executor; as many as there are cores if left out.
    progress : callable, optional
        Called with the number of touches that have been finished since the last call; first with those found there.

    Returns
    -------
    ndarray of int
        Numbers of the shards that were computed now.

    Raises
    ------
    FileError
        Zarr is not installed; `path` holds something else, or touches of another file; it cannot be written.
    WorkersError
        The executor has lost its workers, or they write into another folder. Finished shards are kept.

    Examples
    --------
    >>> import tempfile, subskin as ss
    >>> finger = ss.io.parse_finger("skin = {young = 4e5}\nsensors = {count = 4, pitch = 2e-3, depth = 2e-3}")
    >>> text = 'finger = "f"\ntouches = 3000\nshard = 2000\nload = {force = 40}\ncontact = [{family = "line"}]'
    >>> file = ss.io.parse_touches(text, finger=finger)
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     [save_touches(file, f"{folder}/touches.zarr").tolist() for _ in range(2)]  # the second finds all there
    [[0, 1], []]
    """
    _check.noun("file", file, TouchesFile, 'io.load_touches("touches.toml")')
    zarr, target, touches = _zarr(path), path_of(path).absolute(), file.touches
    if not target.exists():
        check_target(path)
        _make(zarr, target, file)
    about, done = _opened(zarr, path)
    _refuse_other(about, path, file)
    group = zarr.open_group(target, mode="r+")
    missing = np.flatnonzero(~done)
    if progress is not None:
        progress(sum(len(touches.rows(int(k))) for k in np.flatnonzero(done)))

    def keep(number: int, _: object) -> None:
        k = int(missing[number])
        if not _shard_file(target, "readings", k).is_file():
            seen, rule = (
                f"{target}: shard {k} is not there",
                "workers have to write into the same folder as this process",
            )
            raise WorkersError(seen, rule, "a folder that all machines share")
        done[k] = True
        group["done"][:] = done

    def passed(number: int, _: object) -> None:
        if progress is not None:
            progress(len(touches.rows(int(missing[number]))))

    tasks = [partial(_write, str(target), touches, int(k)) for k in missing]
    try:
        run_tasks(tasks, keep, executor=executor, workers=workers, passed=passed)
    except OSError as error:
        said = error.strerror or str(error)
        raise FileError(str(path), f"it cannot be written ({said})", "space on the disk; then the same again") from None
    for left in target.rglob("*.partial"):  # of a process that was killed
        left.unlink(missing_ok=True)
    return missing


def write_touches(
    file: TouchesFile, path: str | Path, *, workers: int | None = None, progress: Callable[[int], object] | None = None
) -> None:
    r"""Compute the touches of `file` into one table: Parquet (.parquet, .pq), or CSV (any other).

    A row for each touch: the readings by the names of the sensors, the parameters, and `contact`, `fault` and
    `faulty_sensor`, a name or empty. The table appears whole or not at all; what is stopped begins anew. The touches
    are those of `save_touches`.

    Parameters
    ----------
    file : TouchesFile
        The touches.
    path : path-like
        The table.
    workers : int, optional
        How many threads; as many as there are cores if left out.
    progress : callable, optional
        Called with the number of touches that have been written since the last call.

    Raises
    ------
    FileError
        The table cannot be written; Parquet without pyarrow.

    Examples
    --------
    >>> import tempfile, subskin as ss
    >>> finger = ss.io.parse_finger("skin = {young = 4e5}\nsensors = {count = 4, pitch = 2e-3, depth = 2e-3}")
    >>> text = 'finger = "f"\ntouches = 30\nload = {force = 40}\ncontact = [{family = "line"}]'
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     write_touches(ss.io.parse_touches(text, finger=finger), f"{folder}/touches.csv")
    ...     ss.io.read_table(f"{folder}/touches.csv").texts("contact")[:2]
    ['line', 'line']
    """
    _check.noun("file", file, TouchesFile, 'io.load_touches("touches.toml")')
    touches, waiting, names = file.touches, dict[int, TouchShard](), np.array([*file.finger.names, ""], dtype=object)
    families, faults = (np.array(each, dtype=object) for each in ([c.family for c in touches.contacts], FAULTS))
    number = np.float32 if file.precision == "single" else np.float64
    with writing(path) as table:
        written = 0

        def keep(k: int, shard: TouchShard) -> None:
            nonlocal written
            waiting[k] = shard
            while written in waiting:  # in their order
                readings, parameters, labels = waiting.pop(written)
                numbers = zip((*file.finger.names, *touches.parameters), (*readings.T, *parameters.T), strict=True)
                columns = {name: values.astype(number) for name, values in numbers}
                columns |= {"contact": families[labels[:, 0]], "fault": faults[labels[:, 1]]}
                table.write(columns | {"faulty_sensor": names[labels[:, 2]]})
                written += 1
                if progress is not None:
                    progress(len(labels))

        run_tasks([partial(touches.shard_of, k) for k in range(touches.shards)], keep, workers=workers)


def shards_done(path: str | Path) -> npt.NDArray[np.bool_]:
    """Which shards of the store at `path` are finished.

    Raises
    ------
    FileError
        Zarr is not installed, or there are no touches at `path`.

    Examples
    --------
    >>> shards_done("touches.zarr")
    Traceback (most recent call last):
    subskin.errors.FileError: touches.zarr: it holds no touches to learn from. Fix: name another folder.
    """
    return _opened(_zarr(path), path)[1]


def cost_of_touches(file: TouchesFile) -> TouchesCost:
    r"""What the touches of `file` will cost, from its first shard, or as much of it as can be computed in 10 s.

    Raises
    ------
    FileError
        Zarr is not installed.

    Examples
    --------
    >>> import subskin as ss
    >>> finger = ss.io.parse_finger("skin = {young = 4e5}\nsensors = {count = 4, pitch = 2e-3, depth = 2e-3}")
    >>> text = 'finger = "f"\ntouches = 5000\nshard = 2000\nload = {force = 40}\ncontact = [{family = "line"}]'
    >>> cost = cost_of_touches(ss.io.parse_touches(text, finger=finger))
    >>> cost.shards, cost.measured, 5e4 < cost.size < 5e5
    (3, 2000, True)
    """
    _check.noun("file", file, TouchesFile, 'io.load_touches("touches.toml")')
    zarr, touches = _zarr("--plan"), file.touches
    whole = len(touches.rows(0))
    touches.shard_of(0, 10)  # tables that are made once
    few, spent = min(whole, 100), 0.0
    while spent < _SECONDS / 20:
        start = time.process_time()
        touches.shard_of(0, few)
        spent = time.process_time() - start
        if few == whole:
            break
        few = min(whole, 4 * few)
    measured = few
    if few < whole:
        measured = min(whole, max(int(_SECONDS / spent * few / 4) // CHUNK, 1) * CHUNK)
    with tempfile.TemporaryDirectory() as folder:
        target = Path(folder) / "touches.zarr"
        _make(zarr, target, file, measured)
        start = time.process_time()
        _fill(zarr.open_group(target, mode="r+"), touches.shard_of(0, measured), slice(0, measured))
        spent = time.process_time() - start
        size = sum(part.stat().st_size for part in target.rglob("c/*/*") if part.is_file())
    count = touches.count
    return TouchesCost(count, touches.shards, size / measured * count, spent / measured * count / 3600, measured)


def _zarr(path: str | Path) -> Any:
    rule, fix = "touches need Zarr, which is not installed", 'pip install "subskin[touches]"'
    return needed(str(path), rule, fix, "zarr")


def _make(zarr: Any, target: Path, file: TouchesFile, count: int | None = None) -> None:
    """An empty store that appears whole; of `count` touches in one shard, if that is given."""
    touches = file.touches
    rows, shard = (touches.count, touches.shard) if count is None else (count, count)
    chunk = min(CHUNK, shard)
    number = "f4" if file.precision == "single" else "f8"
    names = {"sensor": file.finger.names, "parameter": touches.parameters, "label": touches.labels}
    table = {
        "readings": ("sensor", number, np.nan),
        "parameters": ("parameter", number, np.nan),
        "labels": ("label", "i2", -1),
    }
    part = Path(tempfile.mkdtemp(prefix=f".{target.name[:100]}.", suffix=".part", dir=target.parent))
    try:
        group = zarr.create_group(part, zarr_format=3, attributes=_about(file), overwrite=True)
        for name, (axis, kind, empty) in table.items():
            wide = len(names[axis])
            group.create_array(
                name, shape=(rows, wide), dtype=kind, chunks=(chunk, wide), shards=(shard, wide), fill_value=empty,
                dimension_names=("touch", axis),
            )  # fmt: skip
        for axis, each in names.items():
            own = group.create_array(axis, shape=(len(each),), dtype=str, dimension_names=(axis,))
            own[:] = np.array(each, dtype=object)
        group.create_array(
            "done", shape=(-(-rows // touches.shard),), dtype=bool, fill_value=False, dimension_names=("shard",)
        )
        group["parameters"].attrs["units"] = list(touches.units)
        group["labels"].attrs.update(contact=[c.family for c in touches.contacts], fault=list(FAULTS))
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # that this part of the format may change; xarray reads it
            zarr.consolidate_metadata(part)
        part.chmod(0o777 & ~umask())
        part.rename(target)
    except OSError as error:
        shutil.rmtree(part, ignore_errors=True)
        said = error.strerror or str(error)
        raise FileError(str(target), f"it cannot be written ({said})", "check the folder, or name another") from None
    except BaseException:
        shutil.rmtree(part, ignore_errors=True)
        raise


def _about(file: TouchesFile) -> dict[str, Any]:
    """What the store says of itself."""
    return {
        "title": file.title,
        "subskin": __version__,
        "touches": file.text,
        "finger": file.finger.text,
        "meaning": json.dumps(file.meaning, sort_keys=True, default=str),
    }


def _opened(zarr: Any, path: str | Path) -> tuple[dict[str, Any], npt.NDArray[np.bool_]]:
    """What the store at `path` says of itself, and which of its shards are finished."""
    at = path_of(path).absolute()
    try:
        group = zarr.open_group(at, mode="r")
    except Exception:  # of Zarr, of its codecs, of what reads JSON
        group = None
    if group is None or "meaning" not in group.attrs or "done" not in group:
        raise FileError(str(path), "it holds no touches to learn from", "name another folder")
    try:
        about = {**group.attrs, "meaning": json.loads(group.attrs["meaning"]), "subskin": group.attrs["subskin"]}
        for name in _ORDER:
            group[name].shards  # noqa: B018 - whether it can be opened
        done = np.array(group["done"][:], dtype=bool)
        for k in np.flatnonzero(done):  # files that were lost since, or cut to nothing
            done[k] = all(_is_there(_shard_file(at, name, int(k))) for name in _ORDER)
        return about, done
    except Exception as wrong:
        fix = "remove it, or name another folder, and compute it again"
        raise FileError(str(path), f"it is damaged ({str(wrong)[:80] or type(wrong).__name__})", fix) from None


def _refuse_other(about: Mapping[str, Any], path: str | Path, file: TouchesFile) -> None:
    """Refuse a store of anything but the touches of `file`."""
    fix = "another -o, or the file as it was, which the store keeps as its attribute touches"
    if about["subskin"] != __version__:
        raise FileError(str(path), f"subskin {about['subskin']} began it, and this is {__version__}", fix)
    before, now = about["meaning"], json.loads(_about(file)["meaning"])
    if before != now:
        raise FileError(str(path), f"it holds touches of another file: {_difference(before, now)}", fix)


def _difference(before: Any, now: Any, at: str = "") -> str:
    """The first key that is not the same."""
    if isinstance(before, Mapping) and isinstance(now, Mapping):
        for key in (*before, *(key for key in now if key not in before)):
            if before.get(key) != now.get(key):
                return _difference(before.get(key), now.get(key), f"{at}.{key}" if at else key)
    said = ["not there" if value is None else json.dumps(value)[:80] for value in (before, now)]
    return f"{at} was {said[0]} and is {said[1]}"


def _shard_file(target: Path, name: str, k: int) -> Path:
    return target / name / "c" / str(k) / "0"


def _is_there(file: Path) -> bool:
    return file.is_file() and file.stat().st_size > 0


def _write(path: str, touches: RandomTouches, k: int) -> None:
    """Compute shard k and write it; the readings come last, so that where they are all is."""
    group = _zarr(path).open_group(path, mode="r+")
    rows, shard = touches.rows(k), touches.shard_of(k)
    for name in reversed(_ORDER):  # of a machine that went down: Zarr would read what it replaces in part
        _shard_file(Path(path), name, k).unlink(missing_ok=True)
    _fill(group, shard, slice(rows.start, rows.stop))


def _fill(group: Any, shard: TouchShard, rows: slice) -> None:
    for name in _ORDER:
        group[name][rows] = getattr(shard, name)
