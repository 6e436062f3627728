"""`finger.toml`: a finger, how to search with it, how to read its recordings. Read, checked, and written again."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
import numpy.typing as npt

from .. import _check
from .._axes import on_finger, on_touches
from .._check import FloatArray
from .._shown import Tabled, span
from ..contact import LineLoad
from ..errors import FileError, SubskinError
from ..finger import Finger, finger_needed
from ..loads import force_unit
from ..measured import MeasuredResponse
from ._recorded import Given, LiveFormat, Recorded, table_of
from .files import write_bytes
from .kept_arrays import checksum, read_response, write_both
from .toml_errors import read_document, read_text

if TYPE_CHECKING:
    from ..decide import TypeDecision
    from ..estimate import Estimate
    from ..estimate.locate import AnyLocator
    from .tables import Table

__all__ = ["FingerFile", "load", "parse_finger", "save_finger"]

_SHOWN = 12
"""Names of columns that are shown; of more only the first and the last."""


@dataclass(frozen=True, eq=False, repr=False)
class FingerFile(Tabled, Recorded):
    r"""What a `finger.toml` says, with methods that follow all of it.

    Two kinds of readings go in. `locate`, `fit` and `decide` take readings as `segment` gives them and a finger
    reads them: in SI. `run`, `tare` and `segment` take a raw recording: in the units of [recording], with drift.

    Parameters
    ----------
    finger : Finger
        The skin and the sensors.
    names : tuple of str
        Name of each sensor's column in a table of readings: those of [recording], or s0, s1, ...
    search : (float, float) or ((float, float), (float, float)) or None
        Where loads are looked for, on the finger's own axis, or axes y and z [m]; None for the default of
        `Finger.locator`.
    load : {"line", "point", "either"} or None
        What presses, as in `Finger.locate`; None where the file does not say.
    beside : float or None
        The largest distance beside the row of a point load [m]; None for the default of `Finger.locator`.
    options : mapping
        Further options of `Finger.locator` that the file sets: friction, false_alarm, ambiguity.
    normal_force : (float, float) or None
        Least and largest normal force that `locate` and `fit` believe [N/m or N]; None where the file does not say.
    recording, live : RecordingFormat, LiveFormat or None
        How to read a raw recording, and a board; None where the file has no [recording], no [live].
    relaxation : Relaxation or None
        What the skin forgets of a touch that is held; None where the file has no [relaxation].
    drift : ndarray, shape () or (n,), or None
        Fastest drift of [tare] [reading/s]; None for the default of `Tare`.
    stirring : ndarray, shape () or (n,), or None
        How much readings stir while nothing changes: noise of [tare] [reading]; None for the finger's noise.
    origin : float, or ndarray of shape (2,)
        Where the finger's y = 0 lies on the axis of the positions in tables [m]: y = position - origin. On an area
        where its (0, 0) lies on the axes y and z of the tables.
    turn : float
        On an area, by how much the finger's y lies turned from the tables' y, towards z [rad].
    differences : bool
        The finger reads differences from the free skin, as `segment` writes them.
    limits : (ndarray, ndarray)
        Range of the raw readings, (low, high), each of shape (n,) [reading]; a finger of differences has none itself.
    length : float or None
        Length of the contacts [m]; None where the file has no [touch].
    tip : (float, {"cylinder", "sphere"} or None) or None
        Radius [m] and shape of the tip that flat layers are bent to, of which `subskin check` tells the cost; None
        where the file has no [tip].
    oriented : str or None
        The day on which presses confirmed how the sensors are connected; None where the file has no [oriented].
    text : str
        The file itself; `with_finger` changes it and keeps its comments.
    name : str
        What messages call the file.

    Examples
    --------
    >>> import subskin as ss
    >>> text = "[skin]\nyoung = 4e5\n[sensors]\ncount = 6\npitch = 2e-3\ndepth = 2e-3\nnoise = 1e-4"
    >>> file = ss.io.parse_finger(f"{text}\n[locate]\nfriction = 0")
    >>> readings = file.finger.read(ss.LineLoad(40.0, position=[0.8e-3, 2.1e-3]), np.random.default_rng(0))
    >>> found = file.locate(readings)  # loads press straight down, as [locate] says
    >>> (found.position * 1e3).round(1).tolist(), found.angle.tolist()
    ([0.8, 2.1], [0.0, 0.0])
    """

    search: Any = None
    load: Literal["line", "point", "either"] | None = None
    beside: float | None = None
    options: Mapping[str, float] = field(default_factory=dict)
    normal_force: tuple[float, float] | None = None
    live: LiveFormat | None = None
    origin: Any = 0.0
    turn: float = 0.0
    length: float | None = None
    tip: tuple[float, Literal["cylinder", "sphere"] | None] | None = None
    oriented: str | None = None
    text: str = ""

    def _title(self) -> str:
        return f"FingerFile {self.name}"

    def _shown(self) -> list[tuple[str, str]]:
        first = [(line[2:12].strip(), line[12:]) for line in repr(self.finger).splitlines()[1:]]
        options = [f"{name} = {value:g}" for name, value in self.options.items()]
        unit = force_unit(self.finger.array.on_area, self.finger.relative)
        options += [] if self.normal_force is None else [f"normal force {span(self.normal_force, unit)}"]
        options += [] if self.load is None else [f"load = {self.load}"]
        options += [] if self.beside is None else [f"to {1e3 * self.beside:g} mm beside the row"]
        options += [] if self.search is None else [f"search {span(1e3 * np.asarray(self.search), 'mm')}"]
        kind = "differences from the free skin" if self.differences else "as they come, offsets in them"
        columns = self.names if len(self.names) <= _SHOWN else (*self.names[:3], "...", self.names[-1])
        told = [("locate", ", ".join(options) or "as usual"), ("columns", ", ".join(columns)), ("readings", kind)]
        known = self.finger.measured
        return [*first, *told, *([] if known is None else [("response", repr(known))])]

    @property
    def one_force(self) -> float | None:
        """The normal force of every touch where the file leaves no other [N/m or N]; None if it does."""
        ends = self.normal_force
        return ends[0] if ends is not None and ends[0] == ends[1] and not self.finger.relative else None

    def _with(self, changes: Mapping[str, Any]) -> dict[str, Any]:
        return {"search": self.search, **self.options, **changes}

    def _load(self, changes: dict[str, Any]) -> dict[str, Any]:
        """The options with what presses, and how far beside a row, where the file or `changes` say so."""
        load = changes.pop("load", self.load)
        beside = None if load not in ("point", "either") or self.finger.array.on_area else self.beside
        more = {"beside": beside} if beside is not None else {}
        return {**more, **self._forced(changes), **({} if load is None else {"load": load})}

    def _forced(self, changes: Mapping[str, Any]) -> dict[str, Any]:
        force = {} if self.normal_force is None else {"normal_force": self.normal_force}
        return {**force, **self._with(changes)}

    def locator(self, **changes: Any) -> AnyLocator:
        """`Finger.locator` with the options of the file; `changes` override some, and `load` of `locate`.

        Raises
        ------
        InvalidValueError
            An option out of range, a sensor without noise.
        """
        options = self._load(changes)
        usual = options.pop("load", None)
        if usual == "line":
            self.finger.array.refuse_area()
        family = LineLoad if usual == "line" else usual
        return self.finger.locator(options.pop("family", family), **options)

    def locate(self, readings: Given, **changes: Any) -> Any:
        """`Finger.locate` with the options of the file.

        Parameters
        ----------
        readings : array_like, shape (..., n), or Table or pathlib.Path
            In SI [reading]; of a table, the file's columns.
        **changes
            Override options of the file; as in `Finger.locate`.

        Raises
        ------
        FileError, InvalidValueError, GeometryError
            As in `locator`; a table without the file's columns; readings of another number of sensors.
        """
        return self.finger.locate(self._readings(readings), **self._load(changes))

    def fit(self, readings: Given, family: Any = None, **changes: Any) -> Estimate:
        """`Finger.fit` with the options of the file.

        Parameters
        ----------
        readings, **changes
            As in `locate`.
        family : str or class of contacts, optional
            As in `Finger.fit`.
        """
        return self.finger.fit(self._readings(readings), family, **self._forced(changes))

    def decide(self, readings: Given, **changes: Any) -> TypeDecision:
        """`subskin.decide.contact_type` with the options of the file that it has: search, friction, false_alarm.

        Parameters
        ----------
        readings
            As in `locate`.
        **changes
            Override options of the file, and set `kinds` and `sure`; as in `contact_type`.
        """
        from ..decide import contact_type

        options = self._with(changes)
        if "ambiguity" not in changes:
            options.pop("ambiguity", None)  # of [locate]; a decision has `sure` instead
        return contact_type(self.finger, self._readings(readings), **options)

    def _readings(self, given: Given) -> Any:
        table = table_of(given)
        return given if table is None else table.readings(self.names)

    def run(
        self,
        recording: Given,
        time: npt.ArrayLike | None = None,
        answer: Callable[[Any], Any] | None = None,
        *,
        drift: npt.ArrayLike | None = None,
    ) -> dict[str, Any]:
        """What each stage of the `pipeline` makes of a whole raw recording, by its name; "found" is the answer.

        Parameters
        ----------
        recording : array_like, shape (m, n), or Table or pathlib.Path
            Raw readings, in the unit of [recording], in the order of time; it begins with the skin free.
        time : array_like, shape (m,)
            Time of each frame [s]; of a table, its column of times.
        answer, drift
            As in `pipeline`; the `locator` of the file if left out.

        Raises
        ------
        FileError, InvalidValueError, GeometryError
            As in `frames` and `pipeline`; a time that is missing, or goes back.
        """
        frames = self._raw(recording, time)
        return self.pipeline(self.locator() if answer is None else answer, drift=drift)(*frames)

    def for_touches(self, table: Table) -> FingerFile:
        """The file as touches in a `table` are read: as differences where `segment` made it (t_start, t_end).

        Differences have no range. The offsets of the raw readings are not theirs, and theirs are 0 until fitted.
        """
        if self.differences or not {"t_start", "t_end"} <= set(table.columns):
            return self
        return self.of_differences()

    def of_differences(self) -> FingerFile:
        """The file as differences from the free skin are read: without a range, and without offsets."""
        array = replace(self.finger.array, low=-np.inf, high=np.inf, offset=0.0)
        return replace(self, finger=replace(self.finger, array=array), differences=True)

    def to_fit(self, names: Sequence[str]) -> tuple[str, ...]:
        """What `calibrate` fits of `names`, as readings of this file are: of differences a lift, where they say offset.

        A free skin's difference is 0; what presses have in common at a sensor goes with their force.
        """
        names = _check.several("names", names, str, 'names=("gain", "depth")')
        return tuple(dict.fromkeys("lift" if name == "offset" and self.differences else name for name in names))

    def on_finger(self, positions: npt.ArrayLike) -> FloatArray:
        """Positions of the tables as they lie on the finger [m].

        Parameters
        ----------
        positions : array_like, shape (...), on an area (..., 2)
            On the axis of the tables, or on their axes y and z [m].
        """
        return on_finger(positions, self.origin, self.turn)

    def on_touches(self, positions: npt.ArrayLike) -> FloatArray:
        """Positions on the finger, as `locate` finds them, on the axes of the tables [m].

        Parameters
        ----------
        positions : array_like
            As in `on_finger`.
        """
        return on_touches(positions, self.origin, self.turn)

    def with_finger(
        self, finger: Finger, origin: npt.ArrayLike, facts: Mapping[str, Any] | None = None, *, turn: float = 0.0
    ) -> FingerFile:
        """The same file with another finger's numbers in it, and `facts` in its [calibration].

        The rest of the text stays, comments too.

        Raises
        ------
        InvalidValueError
            A skin of another kind; a finger with offsets where the file's readings are differences.
        """
        from ._toml_edit import edited, model_facts

        finger_needed(finger)
        if self.differences:
            finger.array.refuse_offset()
        told = ({"differences": True} if self.differences else {}) | model_facts(finger) | dict(facts or {})
        if finger.measured is not None:
            told["response"] = checksum(finger.measured)
        written = _parsed(self.text, self.name, lambda _: None).finger
        text = edited(self.text, written, finger, origin, turn, told, self.stirring is None)
        changed = _parsed(text, "the file as changed", lambda _: finger.measured)
        return replace(changed, search=self.search, name=self.name)


def load(path: str | Path) -> FingerFile:
    """Read a finger, and how to search with it, from the file at `path`; as `subskin.load(path)` too.

    Raises
    ------
    FileError
        A file that cannot be read, is no TOML, or holds a wrong key or value. The message names the file, the line,
        what was seen, the rule and the fix. The response that belongs to it is missing, damaged or another's.

    Examples
    --------
    >>> load("finger.toml")
    Traceback (most recent call last):
    subskin.errors.FileError: finger.toml: there is no such file. Fix: check the name and the folder.
    """
    return _parsed(read_text(path), str(path), lambda expected: read_response(str(path), expected))


def save_finger(file: FingerFile, path: str | Path) -> None:
    r"""Write `file` to `path`, and a response in place beside it (`NAME.response.npz`), whole or not at all.

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
    ...     load(f"{folder}/finger.toml").names
    ('s0',)
    """
    _check.noun("file", file, FingerFile, 'io.load("finger.toml")')
    if file.finger.measured is None:
        write_bytes(path, file.text.encode("utf-8"))
    else:
        write_both(path, file.text, file.finger.measured)


def parse_finger(text: str, name: str = "finger.toml") -> FingerFile:
    """The finger that `text` describes; `name` is what messages call it.

    Raises
    ------
    FileError
        As `load`.

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

    def nowhere(expected: str) -> MeasuredResponse:
        raise FileError(f"{name} has a response in a file beside it", "a text has no file beside it", "subskin.load")

    return _parsed(text, name, nowhere)


def _parsed(text: str, name: str, find: Callable[[str], MeasuredResponse | None]) -> FingerFile:
    """The finger that `text` describes; `find` gives the response in place that has a checksum."""
    from ._schema import FingerDocument

    needs = "it needs at least [skin] young and [sensors] count, pitch, depth"
    told = read_document(text, name, FingerDocument, needs, lambda document: document.told(Path(name).parent))
    expected = told.pop("response")
    file = FingerFile(**told, text=text, name=name)
    if expected is not None:
        known = find(expected)
        try:
            file = replace(file, finger=replace(file.finger, measured=known))
        except SubskinError as error:
            rule = f"it has {len(file.names)} sensors, and the response beside it is of {known and known.sensors}"
            raise FileError(name, rule, "calibrate again") from error
    return replace(file, finger=file._ranged(-np.inf, np.inf)) if file.differences else file
