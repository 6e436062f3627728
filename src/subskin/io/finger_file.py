"""`finger.toml`: a finger, how to search with it, how to read its recordings. Read, checked, and written again."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from .. import _check
from .._check import FloatArray
from ..array import SensorArray, even_row
from ..errors import InvalidValueError, SubskinError
from ..finger import Finger
from ..stream.presses import Column, RecordingFormat
from ..transducer import Transducer, VolumeResistance, transducer_of
from ._skin import Misplaced, about, build_skin
from ._toml_errors import misplaced, read_text, short, validated
from .files import write_bytes
from .units import quantity, si_unit, unit_scale

if TYPE_CHECKING:
    from ..estimate.locate import Locator
    from ..stream.pipeline import Pipeline
    from ..stream.relaxation import Relaxation
    from . import _schema
    from .tables import Table

__all__ = ["FingerFile", "load_finger", "parse_finger", "save_finger"]

_IN_READINGS = ("offset", "noise", "low", "high", "resolution")


@dataclass(frozen=True)
class FingerFile:
    """What a `finger.toml` says.

    Parameters
    ----------
    finger : Finger
        The skin and the sensors.
    names : tuple of str
        Name of each sensor's column in a table of readings: those of [recording], or s0, s1, ...
    search : (float, float) or None
        Where loads are looked for, on the finger's own axis [m]; None for the default of `Finger.locator`.
    options : mapping
        Further options of `Finger.locator` that the file sets: friction, false_alarm, ambiguity.
    recording : RecordingFormat or None
        How to read a raw recording; None where the file has no [recording].
    relaxation : Relaxation or None
        What the skin forgets of a touch that is held; None where the file has no [relaxation].
    drift : ndarray, shape () or (n,), or None
        Fastest drift of [tare] [reading/s]; None for the default of `Tare`.
    origin : float
        Where the finger's y = 0 lies on the axis of the positions in tables [m]: y = position - origin.
    text : str
        The file itself; `with_finger` changes it and keeps its comments.
    """

    finger: Finger
    names: tuple[str, ...]
    search: tuple[float, float] | None = None
    options: Mapping[str, float] = field(default_factory=dict)
    recording: RecordingFormat | None = None
    relaxation: Relaxation | None = None
    drift: npt.ArrayLike | None = None
    origin: float = 0.0
    text: str = ""

    def locator(self, **changes: Any) -> Locator:
        """`Finger.locator` with the options of the file; `changes` take the place of some.

        Raises
        ------
        InvalidValueError
            An option out of range, a sensor without noise.
        """
        options: dict[str, Any] = {"search": self.search, **self.options, **changes}
        return self.finger.locator(**options)

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
            What is made of readings: a locator, for one; without it the pipeline ends with readings that are tared.
        drift : array_like, shape () or (n,), optional
            In place of the file's [reading/s].

        Returns
        -------
        Pipeline
            Times are in s.

        Raises
        ------
        InvalidValueError, GeometryError
            As `Tare`: a sensor without noise, a drift below 0.

        Examples
        --------
        >>> text = "[skin]\nyoung = 4e5\n[sensors]\ncount = 4\npitch = 6e-3\ndepth = 5e-3\nnoise = 1e-4"
        >>> file = parse_finger(f"{text}\n[tare]\ndrift = 1e-5")
        >>> list(file.pipeline(file.locator()).stages)
        ['tare', 'found']
        """
        from ..stream import Pipeline, Tare

        stages: dict[str, Any] = {}
        if self.recording is not None:
            stages["units"] = partial(np.multiply, self.recording.scale)
        if self.relaxation is not None:
            stages["relaxation"] = self.relaxation.undo
        stages["tare"] = Tare(self.finger, drift=self.drift if drift is None else drift)
        return Pipeline(stages if answer is None else {**stages, "found": answer})

    def with_finger(self, finger: Finger, origin: float, facts: Mapping[str, Any] | None = None) -> FingerFile:
        """The same file with another finger's numbers in it, and `facts` in its [calibration].

        What does not change is left as it stands, comments are kept.
        """
        from ._toml_edit import edited

        text = edited(self.text, self.finger, finger, origin, facts or {})
        return replace(parse_finger(text, "the file as changed"), search=self.search)


def load_finger(path: str | Path) -> FingerFile:
    """Read a finger from `path`.

    Raises
    ------
    FileError
        A file that cannot be read, is no TOML, or holds a wrong key or value. The message names the file, the line,
        what was seen, the rule and the fix.

    Examples
    --------
    >>> load_finger("finger.toml")
    Traceback (most recent call last):
    subskin.errors.FileError: finger.toml: there is no such file. Fix: check the name and the folder.
    """
    return parse_finger(read_text(path), str(path))


def save_finger(file: FingerFile, path: str | Path) -> None:
    r"""Write `file` to `path`, whole or not at all.

    Raises
    ------
    FileError
        The file cannot be written.

    Examples
    --------
    >>> import tempfile
    >>> file = parse_finger("skin = {young = 4e5}\nsensors = {y = [0.0], depth = 2e-3}")
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     save_finger(file, f"{folder}/finger.toml")
    ...     load_finger(f"{folder}/finger.toml").names
    ('s0',)
    """
    write_bytes(path, file.text.encode("utf-8"))


def parse_finger(text: str, name: str = "finger.toml") -> FingerFile:
    """The finger that `text` describes; `name` is what messages call it.

    Raises
    ------
    FileError
        As `load_finger`.

    Examples
    --------
    >>> file = parse_finger('''
    ... [skin]
    ... young = "0.4 MPa"
    ...
    ... [sensors]
    ... count = 4
    ... pitch = "6 mm"
    ... depth = "5 mm"
    ... ''')
    >>> len(file.finger.array), file.names, round(float(file.finger.array.depth[0]), 6)
    (4, ('s0', 's1', 's2', 's3'), 0.005)
    """
    from ._schema import FingerDocument

    document = validated(text, name, FingerDocument, "it needs at least [skin] young and [sensors] count, pitch, depth")
    try:
        return _build(document, text)
    except Misplaced as wrong:
        raise misplaced(text, name, wrong.path, wrong.error) from None


def _build(document: _schema.FingerDocument, text: str) -> FingerFile:
    recording = document.recording
    skin, array = build_skin(document.skin), _array(document)
    with about("sensors"):
        finger = Finger(skin, array)
    names = tuple(f"s{i}" for i in range(len(array))) if recording is None else tuple(recording.sensors)
    if len(names) != len(array):
        seen = f"sensors names {len(names)} columns"
        rule = f"one for each of the {len(array)} sensors of [sensors] is needed"
        raise Misplaced(InvalidValueError(seen, rule), "recording", "sensors")
    given = document.locate
    options = {k: v for k in ("friction", "false_alarm", "ambiguity") if (v := getattr(given, k)) is not None}
    for key, value in options.items():
        if value < 0 or (key == "false_alarm" and not 0 < value <= 0.5):
            rule = "has to be >= 0" if key != "false_alarm" else "has to be in (0, 0.5]"
            raise Misplaced(InvalidValueError(f"{key} = {value:g}", rule), "locate", key)
    relaxation = None
    if document.relaxation is not None:
        from ..stream.relaxation import Relaxation

        with about("relaxation"):
            relaxation = Relaxation(document.relaxation.share, document.relaxation.time)
    return FingerFile(
        finger=finger,
        names=names,
        search=given.search,
        options=options,
        recording=_recording(recording),
        relaxation=relaxation,
        drift=_drift(document),
        origin=document.calibration.origin,
        text=text,
    )


def _array(document: _schema.FingerDocument) -> SensorArray:
    table = document.sensors
    with about("sensors"):
        positions = _positions(table)
        transducers = _transducers(table.kind, table.exact, len(positions))
        parameters = _in_readings(document, transducers)
        return SensorArray(y=positions, depth=table.depth, width=table.width, transducer=transducers, **parameters)


def _positions(table: _schema.SensorsTable) -> list[float]:
    """Positions of the sensors along the row [m]."""
    if table.y is not None:
        for key in ("count", "pitch", "centre"):
            if key in table.model_fields_set:
                fix = f"leave out y or {key}"
                raise InvalidValueError(f"{key} beside y", "y already says where the sensors are", fix)
        return table.y if isinstance(table.y, list) else [table.y]
    if table.count is None or table.pitch is None:
        fix = 'give count = 4 and pitch = "6 mm", or y = ["-3 mm", "3 mm"]'
        raise InvalidValueError("y, or count and pitch, is missing", "the sensors need a position", fix)
    return [float(y) for y in even_row(table.count, table.pitch, table.centre)]


def _transducers(kind: object, exact: bool, count: int) -> Transducer | tuple[Transducer, ...]:
    def one(name: object) -> Transducer:
        if not isinstance(name, str):
            rule = "the name of a kind of sensor is needed"
            raise InvalidValueError(f"kind = {short(name)}", rule, 'kind = "normal_strain"')
        return VolumeResistance(exact=exact) if name == "volume_resistance" else transducer_of(name)

    if isinstance(kind, list):
        if len(kind) != count:
            seen, rule = (f"kind lists {len(kind)}", f"one kind, or one for each of the {count} sensors, is needed")
            raise InvalidValueError(seen, rule)
        return tuple(one(name) for name in kind)
    return one(kind)


def _in_readings(document: _schema.FingerDocument, transducers: Transducer | tuple[Transducer, ...]) -> dict[str, Any]:
    """Gain, offset, noise, range and resolution: plain numbers, or with a unit where the readings have one."""
    from ._schema import reading_unit

    table, unit = document.sensors, reading_unit(document.recording) or ""
    measured = {t.unit for t in (transducers if isinstance(transducers, tuple) else (transducers,))}
    per = measured.pop() if len(measured) == 1 else unit
    units = {"gain": "" if unit == per else f"{unit or 1}/({per})" if per else unit}
    given = {key: _readings(getattr(table, key), units.get(key, unit), key) for key in ("gain", *_IN_READINGS)}
    return {key: value for key, value in given.items() if value is not None}


def _readings(value: Any, unit: str, name: str) -> Any:
    """A quantity, or a list of them; low and high may be infinite, as they are where they are not given."""
    if isinstance(value, list):
        return [_readings(item, unit, f"{name}[{i}]") for i, item in enumerate(value)]
    infinite = name.startswith(("low", "high")) and isinstance(value, float) and abs(value) == np.inf
    return value if value is None or infinite else quantity(value, unit, name)


def _recording(table: _schema.RecordingTable | None) -> RecordingFormat | None:
    if table is None:
        return None

    def column(key: str, unit: str) -> Column | None:
        entry = getattr(table, key)
        if entry is None:
            return None
        try:
            return Column(entry.column, 1.0 if entry.unit is None else unit_scale(entry.unit, unit, "unit"))
        except SubskinError as error:
            raise Misplaced(error, "recording", key, "unit") from None

    scale = 1.0 if table.unit is None else unit_scale(table.unit, si_unit(table.unit, "unit"), "unit")
    time, position, press = (column(k, u) for k, u in (("time", "s"), ("position", "m"), ("press", "m")))
    with about("recording"):
        return RecordingFormat(
            sensors=tuple(table.sensors), scale=scale, time=time or Column("time"), position=position, press=press,
            early=table.early, before=table.before, hold=table.hold,
        )  # fmt: skip


def _drift(document: _schema.FingerDocument) -> npt.ArrayLike | None:
    from ._schema import reading_unit

    with about("tare"):
        drift = _readings(document.tare.drift, f"{reading_unit(document.recording) or 1}/s", "drift")
        return None if drift is None else _check.real("drift", drift, at_least=0.0)
