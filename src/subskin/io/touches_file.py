"""A file that says which touches to learn from: read and checked."""

from __future__ import annotations

import tomllib
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import Field, StrictInt, StrictStr

from ..errors import InvalidValueError
from ..synthetic import ContactShare, RandomTouches
from ._tables import Given, Name, Number, StrictTable, ends_of
from .finger_file import FingerFile, load
from .toml_errors import read_document, read_text, under

__all__ = ["CHUNK", "TouchesFile", "load_touches", "parse_touches"]

CHUNK = 1000
"""Rows that are read together: a row at random costs no more than its chunk. A shard is made of whole ones."""
_NEEDS = "it needs finger, touches, [load] with a force, and [[contact]] with a family"
_UNREAD = ("locate", "live", "tare", "relaxation")
"""Tables of a finger file that no simulated reading depends on."""


class LoadTable(StrictTable):
    """[load]: how the finger is touched."""

    force: Given
    position: Given = None
    across: Given = None
    angle: Given = None
    azimuth: Given = None
    noise: Given = None

    def told(self, local: bool, length: float | None) -> dict[str, tuple[float, float]]:
        """The ends of each quantity that is given; forces in N are divided by the `length` of long contacts [m]."""
        units = {"position": "m", "across": "m", "angle": "rad", "azimuth": "rad", "noise": ""}
        given = {name: value for name in units if (value := getattr(self, name)) is not None}
        ranges = {name: ends_of(value, units[name], name) for name, value in given.items()}
        return ranges | {"force": ends_of(self.force, "N" if local else "N/m", "force", length)}


class ContactShareTable(StrictTable):
    """[[contact]]: a family that touches."""

    family: StrictStr
    share: Number = 1.0
    half_width: Given = None

    def told(self) -> ContactShare:
        """The family and its share."""
        width = None if self.half_width is None else ends_of(self.half_width, "m", "half_width")
        return ContactShare(self.family, self.share, width)


class FaultTable(StrictTable):
    """[fault]: shares of the touches in which one sensor has it."""

    dead: Number = 0.0
    weak: Number = 0.0
    shifted: Number = 0.0


class _Document(StrictTable):
    """The whole file."""

    title: StrictStr = "Touches"
    finger: Name
    touches: Annotated[StrictInt, Field(ge=1, le=10**12)]
    shard: StrictInt = 100_000
    seed: StrictInt = 0
    precision: Literal["single", "double"] = "single"
    load: LoadTable
    contact: Annotated[list[ContactShareTable], Field(min_length=1)]
    fault: FaultTable = FaultTable()

    def told(self, finger: FingerFile) -> RandomTouches:
        """The touches of the finger."""
        contacts = []
        for i, table in enumerate(self.contact):
            with under("contact", str(i)):
                contacts.append(table.told())
        with under("load"):
            ranges = self.load.told(contacts[0].local, finger.length)
        keys = {name: ("load", name) for name in LoadTable.model_fields}
        keys |= {name: ("fault", name) for name in FaultTable.model_fields}
        with under(keys=keys | {"contacts": ("contact", "0"), "faults": ("fault",)}):
            if self.shard > CHUNK and self.shard % CHUNK:
                rule = f"has to be at most {CHUNK}, or a multiple of {CHUNK}"
                raise InvalidValueError(f"shard = {self.shard}", rule, "shard = 100_000")
            faults = {name: share for name, share in self.fault.model_dump().items() if share}
            return RandomTouches(
                finger.finger, tuple(contacts), self.touches, **ranges, faults=faults, shard=self.shard, seed=self.seed
            )


@dataclass(frozen=True)
class TouchesFile:
    """What a file of touches says.

    Parameters
    ----------
    touches : RandomTouches
        The touches.
    precision : {"single", "double"}
        Of readings and parameters.
    title : str
        What they are called.
    text : str
        The file itself.
    finger : FingerFile
        The finger that is touched.
    """

    touches: RandomTouches
    precision: Literal["single", "double"]
    title: str
    text: str
    finger: FingerFile

    @property
    def meaning(self) -> dict[str, Any]:
        """All that the readings depend on, key by key, without comments; the finger's tables in "its finger"."""
        finger = {key: value for key, value in tomllib.loads(self.finger.text).items() if key not in _UNREAD}
        said = {key: value for key, value in tomllib.loads(self.text).items() if key not in ("finger", "title")}
        return {**said, "its finger": finger}


def load_touches(path: str | Path) -> TouchesFile:
    """Read the file at `path`, and the finger beside it.

    Raises
    ------
    FileError
        A file that cannot be read, is no TOML, or holds a wrong key or value. The message names the file, the line,
        what was seen, the rule and the fix.

    Examples
    --------
    >>> load_touches("touches.toml")
    Traceback (most recent call last):
    subskin.errors.FileError: touches.toml: there is no such file. Fix: check the name and the folder.
    """
    return parse_touches(read_text(path), str(path))


def parse_touches(text: str, name: str = "touches.toml", finger: FingerFile | None = None) -> TouchesFile:
    r"""The touches that `text` describes; `name` is what messages call it, and its folder that of the finger.

    Parameters
    ----------
    text : str
        The file.
    name : str, optional
        Its name.
    finger : FingerFile, optional
        The finger; read from the file that the key `finger` names, if left out.

    Raises
    ------
    FileError
        As `load_touches`.

    Examples
    --------
    >>> import subskin as ss
    >>> finger = ss.io.parse_finger("skin = {young = 4e5}\nsensors = {count = 4, pitch = 2e-3, depth = 2e-3}")
    >>> text = 'finger = "finger.toml"\ntouches = 1000\nload = {force = "40 N/m"}\ncontact = [{family = "line"}]'
    >>> parse_touches(text, finger=finger).touches.parameters
    ('position', 'normal', 'tangential', 'half_width', 'noise')
    """

    def make(document: _Document) -> TouchesFile:
        touched = load(Path(name).parent / document.finger) if finger is None else finger
        return TouchesFile(document.told(touched), document.precision, document.title, text, touched)

    return read_document(text, name, _Document, _NEEDS, make)
