"""How a recording is laid out: what it says about itself, and what stands in its rows.

A row is a frame, a command, an event, or a step without frames, in the order of time. No column has nulls: NaN, -1, 0
and "" say that there is nothing.
"""

from __future__ import annotations

import json
import platform
import zlib
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from importlib.metadata import PackageNotFoundError, version
from typing import TYPE_CHECKING, Any

import numpy as np

from ... import __version__, _check
from ..._frozen import Frozen
from ...errors import FileError, InvalidValueError
from ...io.files import needed
from ...io.finger_file import FingerFile

if TYPE_CHECKING:
    import pyarrow as pa

__all__ = [
    "COMMAND",
    "DTYPE",
    "EMPTY",
    "EVENT",
    "FRAME",
    "STEP",
    "About",
    "checksum",
    "columns_of",
    "contact_of",
    "described",
    "joined",
    "need_pyarrow",
    "schema_of",
    "unknowns_of",
    "versions",
]

FORMAT = "subskin recording 1"
_MOST = 10_000
"""Channels or sensors that a recording has at most: a file that names more is not one."""


@dataclass(frozen=True, eq=False)
class About(Frozen):
    """What stands in the metadata of a recording, as text.

    Parameters
    ----------
    finger : str
        The finger file; "" of a bag that was read in without one.
    names : tuple of str
        The sensors, in the order of the readings.
    channels : tuple of str
        The channels of the device, in the order of the raw values.
    axes : str
        "y" of a row of sensors, "yz" of sensors on an area: which coordinates a position has.
    epoch : float
        Seconds since 1970 (UTC) at which the host's clock showed 0 [s].
    load : str
        What presses, [locate] of the finger file: "line", "point", "either", or "" where it does not say.
    length : float or None
        Length of the contacts, [touch] of the finger file [m].
    relative : bool
        Whether forces are multiples of the load of a calibration's touches, as of the finger.
    finger_name, driver : str
        What the finger file and the driver are called.
    options : mapping
        With which the chain was made: `Chain(file, **options)`.
    versions : mapping
        Version of subskin, of Python, and of what they stand on.

    Raises
    ------
    InvalidValueError
        No channel, too many, or one that is named twice.

    Examples
    --------
    >>> about = About("", names=("s0",), channels=("p0", "p1"), axes="y", epoch=0.0)
    >>> About.of(about.metadata(["time: double"]), ["time: double"], "touch.parquet").channels
    ('p0', 'p1')
    """

    finger: str
    names: tuple[str, ...]
    channels: tuple[str, ...]
    axes: str
    epoch: float
    load: str = ""
    length: float | None = None
    relative: bool = False
    finger_name: str = "finger.toml"
    driver: str = ""
    options: Mapping[str, Any] = field(default_factory=dict)
    versions: Mapping[str, str] = field(default_factory=dict)

    def __post_init__(self) -> None:
        for what, listed in (("sensors", self.names), ("channels", self.channels)):
            if len(set(listed)) != len(listed) or len(listed) > _MOST or (what == "channels" and not listed):
                seen = f"{len(listed)} {what} with {len(set(listed))} names"
                raise InvalidValueError(seen, f"1 to {_MOST}, each with its own name, are needed", "name each once")
        _check.choice("axes", self.axes, ("y", "yz"))

    @classmethod
    def for_finger(
        cls,
        file: FingerFile,
        channels: Iterable[str],
        epoch: float,
        driver: str,
        options: Mapping[str, Any] | None = None,
    ) -> About:
        """What is recorded with the finger of a file, by this version on this machine.

        Parameters
        ----------
        file : FingerFile
            The finger.
        channels, epoch, driver, options
            As of `About`.
        """
        return cls(
            finger=file.text,
            names=file.names,
            channels=tuple(map(str, channels)),
            axes="yz" if file.finger.array.on_area else "y",
            epoch=epoch,
            load=file.load or "",
            length=file.length,
            relative=file.finger.relative,
            finger_name=file.name,
            driver=driver,
            options=_plain(dict(options or {})),
            versions=versions(),
        )

    @property
    def newtons(self) -> bool:
        """Whether all forces can be said in N: those of a long contact need its length, and none may be relative."""
        return not self.relative and (self.axes == "yz" or self.load == "point" or self.length is not None)

    @cached_property
    def document(self) -> dict[str, Any]:
        """All of it, as JSON says it."""
        told = {name: getattr(self, name) for name in self.__dataclass_fields__}
        return told | {key: list(told[key]) for key in ("names", "channels")} | {"options": dict(self.options)}

    def metadata(self, columns: list[str]) -> dict[str, str]:
        """What goes into the metadata of a file with these `columns`, with a checksum over both.

        Parameters
        ----------
        columns : list of str
            Name and type of each column.
        """
        told = {key: value for key, value in self.document.items() if key != "finger"}
        text = json.dumps(told)
        crc = _checksum(FORMAT, text, self.finger, *columns)
        return {"subskin.format": FORMAT, "subskin.about": text, "subskin.finger": self.finger, "subskin.crc32": crc}

    @classmethod
    def of(cls, metadata: Mapping[str, str], columns: list[str], name: str) -> About:
        """What a file says about itself, checked.

        Parameters
        ----------
        metadata : mapping of str to str
            As `metadata` wrote it.
        columns : list of str
            Name and type of each column.
        name : str
            What messages call the file.

        Raises
        ------
        FileError
            It is no recording, of a later format, or damaged.
        """
        kind = metadata.get("subskin.format")
        if kind != FORMAT:
            seen = name if kind is None else f'{name} is a "{kind}"'
            fix = "name a file that subskin recorded" if kind is None else "read it with a newer version of subskin"
            raise FileError(seen, f'it is no "{FORMAT}"', fix)
        text, finger = metadata.get("subskin.about", ""), metadata.get("subskin.finger", "")
        if metadata.get("subskin.crc32") != _checksum(FORMAT, text, finger, *columns):
            raise FileError(name, "it is damaged: its head differs from its checksum", "copy it again")
        try:
            told = json.loads(text)
            listed = {key: tuple(map(str, told.pop(key))) for key in ("names", "channels")}
            return cls(**{**told, **listed, "finger": finger, "epoch": float(told["epoch"])})
        except (ValueError, TypeError, KeyError, AttributeError, RecursionError) as error:
            raise FileError(name, f"its head cannot be read ({error})", "record it again") from None


def _plain(options: Any) -> Any:
    """Options as JSON can say them."""
    if isinstance(options, Mapping):
        return {str(key): _plain(value) for key, value in options.items()}
    if hasattr(options, "tolist"):
        return options.tolist()
    if isinstance(options, list | tuple):
        return [_plain(value) for value in options]
    if options is None or isinstance(options, str | int | float):
        return options
    seen = f"options with a {type(options).__name__}"
    raise InvalidValueError(seen, "a recording holds numbers, texts and lists", "slip=(0.4, 0.8)")


def _checksum(*texts: str) -> str:
    crc = 0
    for text in texts:
        crc = zlib.crc32(text.encode("utf-8", "surrogatepass") + b"\0", crc)
    return f"{crc:08x}"


def versions() -> dict[str, str]:
    """Version of subskin, Python and what the numbers come from.

    Examples
    --------
    >>> sorted(versions())[:2]
    ['machine', 'numba']
    """
    found = {"subskin": __version__, "python": platform.python_version(), "machine": platform.machine()}
    for name in ("numpy", "scipy", "numba", "pyarrow"):
        try:
            found[name] = version(name)
        except PackageNotFoundError:
            continue
    return found


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


def need_pyarrow(name: str) -> None:
    """Refuse a recording, called `name`, where PyArrow is not installed: raises a FileError."""
    needed(name, "a recording needs PyArrow, which is not installed", 'pip install "subskin[log]"', "pyarrow")


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
