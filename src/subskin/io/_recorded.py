"""What a finger file makes of a raw recording, or of a board: frames, a pipeline, and the presses in it."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np
import numpy.typing as npt

from .._frozen import Frozen
from ..errors import FileError, InvalidValueError
from ..stream.presses import Column, RecordingFormat, segment

if TYPE_CHECKING:
    from .._check import FloatArray
    from ..array import SensorArray
    from ..finger import Finger
    from ..stream import Pipeline, Presses, Relaxation, Tared
    from .tables import Table

__all__ = ["Given", "LiveFormat", "Recorded", "check_held", "table_of"]

Given: TypeAlias = "npt.ArrayLike | Table | Path"


def table_of(given: object) -> Table | None:
    """The table that was given, by itself or by its path; None of anything else."""
    from .tables import Table, read_table

    return given if isinstance(given, Table) else read_table(given) if isinstance(given, str | Path) else None


@dataclass(frozen=True, eq=False)
class LiveFormat(Frozen):
    r"""How the sensors of a finger are read as they feel: what [live] of its file says.

    Parameters
    ----------
    port : str
        As `subskin.live.ports.opened` takes it; "" where the file does not say.
    driver : mapping
        The driver's name, under "name", and its options; empty where the file does not say. A name that ends with
        .toml is a file that describes a board.
    channels : tuple of str
        The driver's channel for each sensor, in the order of the sensors; empty for the driver's own, in their order.
    scale : ndarray, shape (n,)
        What one count of each sensor's channel is worth, relative to the SI unit of its reading.

    Examples
    --------
    >>> import subskin as ss
    >>> text = "[skin]\nyoung = 4e5\n[sensors]\ncount = 2\npitch = 2e-3\ndepth = 2e-3\n[live]\nunit = 'hPa'\n"
    >>> live = ss.io.parse_finger(text + "driver = {name = 'lines', sensors = 2}").live
    >>> live.driver["name"], live.scale.tolist()
    ('lines', [100.0, 100.0])
    """

    port: str = ""
    driver: Mapping[str, Any] = field(default_factory=dict)
    channels: tuple[str, ...] = ()
    scale: FloatArray = None  # type: ignore[assignment]


@dataclass(frozen=True, eq=False, repr=False)
class Recorded:
    """A finger and how its raw recordings are read: the part of a `FingerFile` that does so; fields as there."""

    finger: Finger
    names: tuple[str, ...]
    recording: RecordingFormat | None = None
    relaxation: Relaxation | None = None
    drift: npt.ArrayLike | None = None
    stirring: npt.ArrayLike | None = None
    differences: bool = False
    limits: tuple[npt.ArrayLike, npt.ArrayLike] = (-np.inf, np.inf)
    name: str = "finger.toml"

    def frames(self, table: Table) -> tuple[FloatArray, FloatArray]:
        """Raw readings of a `table`, shape (m, n), and the time of each frame [s], by the columns of [recording].

        Raises
        ------
        FileError
            A column that is missing, or a cell that is no number.
        """
        column = Column("time") if self.recording is None else self.recording.time
        time = table.numbers(column.name, finite=True, why="the time of each frame")
        return table.readings(self.names), time * column.scale

    def pipeline(self, answer: Callable[[Any], Any] | None = None, *, drift: npt.ArrayLike | None = None) -> Pipeline:
        r"""From raw frames, as [recording] describes them, to an answer: what live streams and commands run.

        Readings in SI units ("units"), relaxation undone where the file has [relaxation] ("relaxation"), drift taken
        off ("tare"), and the answer ("found").

        Parameters
        ----------
        answer : callable, optional
            A callable that takes readings, such as a locator; without it the pipeline ends with tared readings.
        drift : array_like, shape () or (n,), optional
            Overrides the file's drift [reading/s].

        Raises
        ------
        InvalidValueError, GeometryError
            As `Tare`: a sensor without noise, a drift below 0.

        Examples
        --------
        >>> import subskin as ss
        >>> text = "[skin]\nyoung = 4e5\n[sensors]\ncount = 4\npitch = 6e-3\ndepth = 5e-3\nnoise = 1e-4"
        >>> file = ss.io.parse_finger(f"{text}\n[tare]\ndrift = 1e-5")
        >>> list(file.pipeline(file.locator()).stages)
        ['tare', 'found']
        """
        from ..stream import Pipeline, Tare

        stages: dict[str, Any] = {}
        if self.recording is not None:
            stages["units"] = partial(np.multiply, self.recording.scale)
        if self.relaxation is not None:
            doubted = np.any(self.relaxation.doubt)
            stages["relaxation"] = self.relaxation.undoing if doubted else self.relaxation.undo
        fastest = self.drift if drift is None else drift
        finger = self._ranged(*self.limits)
        stages["tare"] = Tare(finger, drift=fastest, noise=self.stirring, differences=self.differences)
        return Pipeline(stages if answer is None else {**stages, "found": answer})

    def tare(self, recording: Given, time: npt.ArrayLike | None = None, *, drift: npt.ArrayLike | None = None) -> Tared:
        """A raw recording as given to `run`, without its drift: `locate` takes its `readings` and its `doubt`."""
        tared: Tared = self.pipeline(drift=drift)(*self._raw(recording, time))["tare"]
        return tared

    def _raw(self, given: Any, time: npt.ArrayLike | None) -> tuple[npt.ArrayLike, npt.ArrayLike | None]:
        table = table_of(given)
        return (given, time) if table is None else self.frames(table)

    def segment(self, recording: Table | Path, **changes: float) -> Presses:
        """The presses of a raw recording, as [recording] describes it; `subskin.stream.segment` finds them.

        Relaxation is undone where the file has [relaxation]: what is calibrated on presses reads a stream as it does.

        Parameters
        ----------
        recording : Table or pathlib.Path
            One row a frame.
        **changes : float
            Override `early` [-], `before` [s] and `hold` [s] of [recording].

        Raises
        ------
        FileError, InvalidValueError
            A file without [recording], a table without its columns, a recording without a press.
        """
        how, table = self.recording, table_of(recording)
        if how is None:
            fix = 'add [recording] with sensors = ["s0", ...], time = {column = "time", unit = "s"}, position, press'
            raise FileError(self.name, "it has no table [recording] that says how to read one", fix)
        if table is None:
            raise InvalidValueError("recording", "a table with the columns of [recording] is needed", 'Path("raw.csv")')
        if not len(table):
            raise FileError(f"{table.name} has no rows below its header", "a recording needs frames", "record again")
        values, time = self.in_range(table)
        if self.relaxation is not None:
            values = self.relaxation.undo(values, time)
        tracks: dict[str, Any] = {key: _track(table, columns, key) for key, columns in how.tracks.items()}
        options: dict[str, Any] = {key: getattr(how, key) for key in ("early", "before", "hold")} | dict(changes)
        return segment(values, time, **tracks, **options)

    def in_range(self, table: Table) -> tuple[FloatArray, FloatArray]:
        """`frames` in SI, NaN where a reading is out of range [reading], [s].

        Raises
        ------
        FileError
            As `frames`.
        """
        readings, time = self.frames(table)
        values = readings * (1.0 if self.recording is None else self.recording.scale)
        inside = self._ranged(*self.limits).array.inside(values)
        return np.where(inside, values, np.nan), time

    def _ranged(self, low: npt.ArrayLike, high: npt.ArrayLike) -> Finger:
        array = self.finger.array
        if np.all(np.asarray(array.low) == low) and np.all(np.asarray(array.high) == high):
            return self.finger
        return replace(self.finger, array=replace(array, low=low, high=high))


def check_held(relaxation: Relaxation, array: SensorArray) -> None:
    """Raise where a relaxation does not go with the sensors.

    Raises
    ------
    GeometryError, InvalidValueError
        Shares of another number of sensors; a doubt of sensors on an area.
    """
    relaxation.of_sensors(len(array))
    if array.on_area and np.any(relaxation.doubt):
        rule = "only the search on a row weighs each frame by noise of its own"
        raise InvalidValueError("doubt of sensors on an area", rule, "leave out doubt")


def _track(table: Table, columns: tuple[Column, ...], key: str) -> FloatArray:
    """One column in SI, or two side by side, shape (m, 2)."""
    each = [table.numbers(c.name, finite=True, why=f"[recording] {key}") * c.scale for c in columns]
    return each[0] if len(each) == 1 else np.stack(each, axis=-1)
