"""What a recording says about itself: the finger, the device, the chain, the versions, and the clock."""

from __future__ import annotations

import json
import platform
import zlib
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from importlib.metadata import PackageNotFoundError, version
from typing import Any

from ... import _check
from ..._frozen import Frozen
from ...errors import FileError, InvalidValueError
from ...io.finger_file import FingerFile

__all__ = ["About", "versions"]

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
    from ... import __version__

    found = {"subskin": __version__, "python": platform.python_version(), "machine": platform.machine()}
    for name in ("numpy", "scipy", "numba", "pyarrow"):
        try:
            found[name] = version(name)
        except PackageNotFoundError:
            continue
    return found
