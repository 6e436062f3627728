"""What a driver is: bytes of a device in, its frames out; drivers by the names that files use, with their options."""

from __future__ import annotations

import difflib
import inspect
import json
import tomllib
from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, TypeVar
from urllib.parse import parse_qsl

import numpy as np
import numpy.typing as npt

from ..._frozen import Named
from ...errors import FileError, GeometryError, InvalidValueError, SubskinError, UnknownOptionError
from ...io.toml_errors import read_text, wrong_in
from ..frames import DeviceFrames
from .parts import Counter

__all__ = ["Driver", "from_table", "kinds", "load", "made", "named", "named_among", "written"]

_Kind = TypeVar("_Kind")
_TEXTS = {str: "a text", bool: "true or false", int: "a number", float: "a number"}
_READ = {"int": (int, "a whole number"), "float": (float, "a number")}


def named_among(
    kinds: Mapping[str, type[_Kind]], name: str, seen: str, what: str, fix: str = "", form: str = '"{}"'
) -> type[_Kind]:
    """The class of a name.

    Parameters
    ----------
    kinds : mapping
        The classes by their names.
    name, seen : str
        What was asked for, and what an error shows of it.
    what : str
        What it is none of.
    fix : str, optional
        Where no name is like it; all names if left out.
    form : str, optional
        How a name is written.

    Raises
    ------
    InvalidValueError
        There is none of this name.
    """
    if name not in kinds:
        close = difflib.get_close_matches(str(name), list(kinds), n=1)
        meant = f"did you mean {form.format(close[0])}" if close else fix or f"known: {', '.join(kinds)}"
        raise InvalidValueError(seen, f"no such {what} is known", meant)
    return kinds[name]


def made(
    kind: type[_Kind],
    name: str,
    options: Mapping[str, Any],
    fixed: Mapping[str, Any] | None = None,
    texts: bool = False,
) -> _Kind:
    """One of a class, with options: those that it has not got, of another type, and those that are missing are refused.

    Parameters
    ----------
    kind : type
        The class.
    name : str
        What errors call it.
    options : mapping
        Arguments by their names.
    fixed : mapping, optional
        Arguments that are no options.
    texts : bool, optional
        The options are texts: numbers are read from them.

    Raises
    ------
    InvalidValueError, UnknownOptionError
        An option that cannot be.
    """
    takes, values = dict(inspect.signature(kind).parameters), dict(fixed or {})
    for argument in values:
        del takes[argument]
    for option, value in options.items():
        if option not in takes:
            known = f"known: {', '.join(takes) or 'none'}"
            raise UnknownOptionError(f'option "{option}"', f"{name} has no such option", known)
        values[option] = _read(name, takes[option], value) if texts else _right(name, takes[option], value)
    missing = [key for key, one in takes.items() if one.default is one.empty and key not in values]
    if missing:
        raise InvalidValueError(f"{name} without {missing[0]}", "it is needed", f"{missing[0]} = ...")
    return kind(**values)


def written(text: str) -> tuple[str, dict[str, str]]:
    """What stands before a question mark, and the options after it: `lines?sensors=4`.

    Examples
    --------
    >>> written("lines?sensors=4&check=xor8")
    ('lines', {'sensors': '4', 'check': 'xor8'})
    """
    head, _, query = text.partition("?")
    return head, dict(parse_qsl(query, keep_blank_values=True))


def _right(name: str, one: inspect.Parameter, value: Any) -> Any:
    """The value of an option, which has the type of the usual one."""
    usual = one.default
    if isinstance(usual, str | bool | int | float) and type(value) is not type(usual):
        fix = f"{one.name} = {json.dumps(usual)}"
        raise InvalidValueError(f"{one.name} = {value!r} of {name}", f"{_TEXTS[type(usual)]} is needed", fix)
    return value


def _read(name: str, one: inspect.Parameter, text: str) -> Any:
    """The value of an option that is annotated as a number, or the text itself."""
    kind = getattr(one.annotation, "__name__", str(one.annotation)).partition(" |")[0]
    reads, rule = _READ.get(kind, (str, ""))
    try:
        return reads(text)
    except ValueError:
        raise InvalidValueError(f"{name}?{one.name}={text}", f"{rule} is needed", f"{name}?{one.name}=1") from None


class Driver(Named, ABC):
    r"""Finds the frames of a device in its bytes, however they are cut; what is unfinished is kept inside.

    Any bytes may come: noise, frames with bytes lost or changed, the output of another device. None of them makes a
    driver raise, and what it keeps is bounded. The same bytes give the same frames to the last bit, in pieces or at
    once.

    Examples
    --------
    A driver of one's own is found by its name, in files too. Frames of this one are single bytes.

    >>> import numpy as np
    >>> class Bytes(Driver, name="single_bytes"):
    ...     channels = ("level",)
    ...     def feed(self, data):
    ...         return DeviceFrames(np.frombuffer(bytes(data), np.uint8)[:, None])
    ...     def reset(self):
    ...         pass
    ...     def encode(self, values, device_time=None, sequence=None):
    ...         return np.asarray(values, np.uint8).tobytes()
    >>> from subskin.live.drivers import named
    >>> named("single_bytes").feed(b"\x05\x07").values.tolist()
    [[5.0], [7.0]]
    """

    channels: tuple[str, ...]
    """Names of the values of a frame, in their order."""

    start: bytes = b""
    """What is written to the device before it is read."""

    stop: bytes = b""
    """What is written to the device when reading ends."""

    @abstractmethod
    def feed(self, data: bytes) -> DeviceFrames:
        """Frames that are complete with `data`, the bytes that came after those given before.

        Parameters
        ----------
        data : bytes
            As many as there are, at any cut.
        """

    @abstractmethod
    def reset(self) -> None:
        """Forget what is unfinished: the bytes that come next do not follow those that came."""

    @abstractmethod
    def encode(
        self, values: npt.ArrayLike, device_time: npt.ArrayLike | None = None, sequence: npt.ArrayLike | None = None
    ) -> bytes:
        """Bytes that a device sends for frames: what simulations and tests read.

        Parameters
        ----------
        values : array_like, shape (n, c)
            In the units of the device; a row for each frame.
        device_time : array_like, shape (n,), optional
            Time of each frame by the clock of the device [s], where its frames have one.
        sequence : array_like of int, shape (n,), optional
            Number of each frame, where its frames have one.

        Raises
        ------
        GeometryError
            Values of another number of channels.
        """

    def counted(self, found: Sequence[tuple[list[float], float, int]], counter: Counter, bad: int) -> DeviceFrames:
        """Frames of which each was found as its values, its time [s] and its number.

        Parameters
        ----------
        found : sequence of (list of float, float, int)
            Values, time and number of each.
        counter : Counter
            What finds the lost ones.
        bad : int
            How many were broken.
        """
        values = np.array([row for row, _, _ in found], dtype=np.float64).reshape(-1, len(self.channels))
        time = np.array([time for _, time, _ in found], dtype=np.float64)
        number = np.array([number for _, _, number in found], dtype=np.int64)
        return DeviceFrames.made(values, time, number, counter.lost(number), bad)

    def rows(self, values: npt.ArrayLike) -> npt.NDArray[np.float64]:
        """`values` as by `encode`, checked.

        Raises
        ------
        GeometryError
            Values of another number of channels.
        """
        table = np.asarray(values, dtype=np.float64)
        if table.ndim != 2 or table.shape[1] != len(self.channels):
            rule = f"a row of {len(self.channels)} values for each frame is needed"
            raise GeometryError(f"values of shape {table.shape}", rule, f"shape (n, {len(self.channels)})")
        return table


def kinds() -> dict[str, type[Driver]]:
    """The drivers by the names that files use, one's own among them.

    Examples
    --------
    >>> kinds()["anyskin"].__name__
    'AnySkin'
    """
    return dict(Driver._by_name)


def named(name: str, **options: Any) -> Driver:
    """The driver of a name of `kinds`.

    Parameters
    ----------
    name : str
        Such as "anyskin" or "lines".
    **options
        What the driver takes: number of sensors, names of columns.

    Raises
    ------
    InvalidValueError
        An unknown name; an option out of range, or one that is missing.
    UnknownOptionError
        An option that the driver has not got.

    Examples
    --------
    >>> named("anyskin", sensors=2).channels[-1]
    'z1_uT'
    """
    kind = named_among(kinds(), name, f'driver "{name}"', "driver")
    return made(kind, f"driver {name}", options)


def from_table(table: Mapping[str, Any]) -> Driver:
    """The driver that a table of a file describes: its `name`, and its options.

    Parameters
    ----------
    table : mapping
        The driver's name under "name"; the rest as in `named`. A name that ends with .toml is a file, as by `load`.

    Raises
    ------
    InvalidValueError, UnknownOptionError, FileError
        As `named` and `load`; a table without a name; a file with options beside it.

    Examples
    --------
    >>> len(from_table({"name": "anyskin", "sensors": 2}).channels)
    8
    """
    options = dict(table)
    name = options.pop("name", None)
    if not isinstance(name, str):
        raise InvalidValueError("a driver without a name", "a name is needed", 'name = "anyskin"')
    if name.endswith(".toml"):
        if options:
            rule = "the file has all that the driver takes"
            raise InvalidValueError(f"{next(iter(options))} beside {name}", rule, f'driver = "{name}"')
        return load(name)
    return named(name, **options)


def load(path: str | Path) -> Driver:
    r"""The driver that a file describes: a table with the driver's `name` and its options.

    Parameters
    ----------
    path : str or pathlib.Path
        A TOML file.

    Raises
    ------
    FileError
        A file that cannot be read, is no TOML, or describes no driver.

    Examples
    --------
    >>> import tempfile
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     file = Path(folder, "board.toml")
    ...     _ = file.write_text('name = "lines"\ncolumns = ["p0", "p1"]')
    ...     load(file).channels
    ('p0', 'p1')
    """
    text = read_text(path)
    try:
        table = tomllib.loads(text)
    except (ValueError, RecursionError) as error:
        raise FileError(str(path), f"not TOML: {str(error)[:100]}", 'write key = "value"') from None
    if str(table.get("name", "")).endswith(".toml"):
        raise FileError(f'{path}: name = "{table["name"]}"', "a file cannot name another", 'name = "fixed"')
    try:
        return from_table(table)
    except SubskinError as error:
        raise wrong_in(text, str(path), (), table, error) from None
