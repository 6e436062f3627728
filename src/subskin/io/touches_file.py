"""A file that says which touches to learn from: read and checked."""

from __future__ import annotations

import tomllib
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

from .. import _check
from ..errors import InvalidValueError, SubskinError
from ..synthetic import ContactShare, RandomTouches
from ._skin import Misplaced, key_of
from ._toml_errors import misplaced, read_text, validated
from .finger_file import FingerFile, load
from .units import line_load, quantity

if TYPE_CHECKING:
    from . import _touches_schema

__all__ = ["CHUNK", "TouchesFile", "load_touches", "parse_touches"]

CHUNK = 1000
"""Rows that are read together: a row at random costs no more than its chunk. A shard is made of whole ones."""
_NEEDS = "it needs finger, touches, [load] with a force, and [[contact]] with a family"
_UNREAD = ("locate", "live", "tare", "relaxation")
"""Tables of a finger file that no simulated reading depends on."""


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
    from ._touches_schema import TouchesDocument

    document = validated(text, name, TouchesDocument, _NEEDS)
    touched = load(Path(name).parent / document.finger) if finger is None else finger
    try:
        touches = _build(document, touched)
    except Misplaced as wrong:
        raise misplaced(text, name, wrong.path, wrong.error) from None
    return TouchesFile(touches, document.precision, document.title, text, touched)


def _build(document: _touches_schema.TouchesDocument, finger: FingerFile) -> RandomTouches:
    given = document.load
    keys: dict[str, tuple[str, ...]] = {}
    at: tuple[str, ...] = ()
    try:
        contacts = []
        for i, table in enumerate(document.contact):
            at = ("contact", str(i))
            width = None if table.half_width is None else _ends(table.half_width, "m", "half_width")
            contacts.append(ContactShare(table.family, table.share, width))
        local = contacts[0].local
        at = ("load",)
        units = {"position": "m", "across": "m", "angle": "rad", "azimuth": "rad", "noise": ""}
        told = {name: value for name in units if (value := getattr(given, name)) is not None}
        ranges = {name: _ends(value, units[name], name) for name, value in told.items()}
        ranges["force"] = _ends(given.force, "N" if local else "N/m", "force", finger.length)
        at = ()
        _check.whole("touches", document.touches, at_least=1, at_most=10**12)
        if document.shard > CHUNK and document.shard % CHUNK:
            rule = f"has to be at most {CHUNK}, or a multiple of {CHUNK}"
            raise InvalidValueError(f"shard = {document.shard}", rule, "shard = 100_000")
        keys = {name: ("load", name) for name in type(given).model_fields}
        keys |= {name: ("fault", name) for name in type(document.fault).model_fields}
        keys |= {"contacts": ("contact", "0"), "faults": ("fault",)}
        faults = {name: share for name, share in document.fault.model_dump().items() if share}
        return RandomTouches(
            finger.finger, tuple(contacts), document.touches, **ranges, faults=faults, shard=document.shard,
            seed=document.seed,
        )  # fmt: skip
    except SubskinError as error:
        key = key_of(error)
        raise Misplaced(error, *keys.get(key, (*at, key))) from None


def _ends(value: object, unit: str, name: str, length: float | None = None) -> tuple[float, float]:
    """One value, or the two ends of a range, in SI; forces in N are divided by the `length` of the contact [m]."""
    each = value if isinstance(value, list) else [value, value]
    if len(each) != 2:
        rule, example = (
            "one value, or the two ends of a range, are needed",
            f'"1 {unit}", "2 {unit}"' if unit else "1, 2",
        )
        raise InvalidValueError(f"{name} lists {len(each)}", rule, f"{name} = [{example}]")
    low, high = (line_load(v, length, name) if unit == "N/m" else quantity(v, unit, name) for v in each)
    if low > high:
        raise InvalidValueError(f"{name} = {value!r}", "the first has to be <= the second", "swap them")
    return low, high
