"""`goals.toml`: what the designer of a finger knows and wants, read and checked; and a design as a `finger.toml`."""

from __future__ import annotations

import difflib
import tomllib
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any

import numpy as np
from pydantic import Field, StrictBool, StrictInt, StrictStr

from .. import _check
from ..design import Goals, Touches
from ..design.search import Accuracy, Effort, Mix, Room, Row, SensorKind, SkinChoice
from ..design.tolerance import SOURCES
from ..errors import InvalidValueError
from ..finger import LARGEST, SOFTEST
from ._parts import SkinTable, build_skin, said_of, transducer_said
from ._tables import (
    LONGEST,
    RIDGE,
    Angle,
    Doubt,
    Given,
    Length,
    Lengths,
    Name,
    Number,
    StrictTable,
    doubt_sizes,
    ends_of,
    one,
)
from .toml_errors import Misplaced, read_document, read_text, under
from .units import format_quantity, quantity, rounded

__all__ = ["GoalsFile", "finger_text", "load_goals", "parse_goals"]

_TOLERANCES = {name: source for name, source in SOURCES.items() if source.unit != "reading"}
"""What making a finger leaves open; what a reading is off by is said of each kind of sensor."""
_WIDEST = 1.6
"""An error of an angle that leaves nothing known [rad]."""
_Counts = StrictInt | Annotated[list[StrictInt], Field(min_length=2, max_length=2)]
_Contact = Annotated[float, one("m", above=0.0, fix='length = "20 mm"')]
_NEEDS = "it needs [touch], [accuracy], [room], [[sensor]] and [[skin]]"


class TouchTable(StrictTable):
    """[touch]: what the finger is to feel."""

    force: Given
    length: Annotated[_Contact | None, Doubt(LONGEST, "length of [touch]")] = None
    friction: Number = 1.0
    span: Length | None = None
    area: Lengths | None = None
    half_width: Length | None = None
    edge: Length | None = None
    feature: Annotated[Length | None, Doubt(RIDGE)] = None
    largest_strain: Number = 0.1

    def told(self) -> tuple[Touches, float]:
        """What the finger is to feel, and the strongest force [N/m, on an area N]."""
        forces = ends_of(self.force, "N/m" if self.area is None else "N", "force", self.length)
        if (self.span is None) == (self.area is None):
            seen = "neither span nor area" if self.span is None else "span and area"
            rule = "a row of sensors serves a span, an array on an area serves an area"
            raise InvalidValueError(seen, rule, 'span = "12 mm", or area = ["12 mm", "12 mm"]')
        if self.area is not None:
            y, z = _sides(self.area, "area")
            area = ((-y / 2, y / 2), (-z / 2, z / 2))
            wide = self.half_width
            return Touches(forces[0], self.friction, length=self.length, area=area, half_width=wide), forces[1]
        span = self.span or 0.0
        if not span > 0:
            raise InvalidValueError(f"span = {self.span:g}", "has to be > 0", 'span = "12 mm"')
        ends = (-span / 2, span / 2)
        return Touches(forces[0], self.friction, ends, self.length, half_width=self.half_width), forces[1]


class AccuracyTable(StrictTable):
    """[accuracy]: the errors that 95 % of the weakest touches keep."""

    position: Annotated[Length | None, Doubt(RIDGE, "position of [accuracy]")] = None
    angle: Angle | None = None
    force: Number | None = None
    radius: Length | None = None
    edge: Angle | None = None
    unsure: Number = 0.01
    blind_spots: Number | None = None
    calibrated: StrictStr = "known"


class RoomTable(StrictTable):
    """[room]: where sensors can be put."""

    count: _Counts
    depth: Annotated[Lengths, Doubt(LARGEST, "the largest depth")]
    least_pitch: Annotated[Length, Doubt(RIDGE)]
    longest_row: Annotated[Length | None, Doubt(LONGEST)] = None
    area: Lengths | None = None
    layouts: list[StrictStr] | None = None

    def told(self) -> Room:
        """The room."""
        counts = self.count if isinstance(self.count, list) else [self.count, self.count]
        depths = self.depth if isinstance(self.depth, list) else [self.depth, self.depth]
        if len(depths) != 2:
            rule, fix = "one depth or two are needed", 'depth = ["1 mm", "4 mm"]'
            raise InvalidValueError(f"depth lists {len(depths)}", rule, fix)
        where = {} if self.layouts is None else {"layouts": tuple(self.layouts)}
        longest = np.inf if self.longest_row is None else self.longest_row
        sides = None if self.area is None else _sides(self.area, "area")
        return Room((counts[0], counts[1]), (depths[0], depths[1]), self.least_pitch, longest, sides, **where)


class SensorTable(StrictTable):
    """[[sensor]]: a kind of sensor that is at hand."""

    name: Name
    kind: Any
    noise: Given
    width: Annotated[Length, Doubt(RIDGE, "width of [[sensor]]")] = 0.0
    largest: Given = None
    resolution: Given = 0.0

    def told(self) -> SensorKind:
        """The kind, its numbers in the unit of what it measures."""
        transducer = transducer_said(self.kind, False, "kind")
        given = {key: value for key in ("noise", "largest", "resolution") if (value := getattr(self, key)) is not None}
        values = {key: quantity(value, transducer.unit, key) for key, value in given.items()}
        return SensorKind(self.name, transducer, width=self.width, **values)


class MixTable(StrictTable):
    """[[mix]]: several of the kinds in one array on an area."""

    name: Name
    kinds: list[StrictStr]
    together: StrictBool = True


class SkinChoiceTable(SkinTable):
    """[[skin]]: a skin that could be moulded, with the keys of [skin] in a finger.toml."""

    name: Name


class EffortTable(StrictTable):
    """[search]: how finely."""

    depths: StrictInt = 20
    pitches: StrictInt = 30
    touches: StrictInt | None = None
    seed: StrictInt = 0
    keep: StrictInt = 5


class _Document(StrictTable):
    """The whole file."""

    title: StrictStr = "Finger"
    touch: TouchTable
    accuracy: AccuracyTable
    room: RoomTable
    sensor: Annotated[list[SensorTable], Field(min_length=1)]
    skin: Annotated[list[SkinChoiceTable], Field(min_length=1)]
    mix: list[MixTable] = Field(default_factory=list)
    tolerances: dict[str, Any] | None = None
    search: EffortTable = EffortTable()

    def told(self) -> Goals:
        """The goals."""
        touch = self.touch
        with under("touch"):
            touches, strongest = touch.told()
        with under("accuracy"):
            wanted = Accuracy(**self.accuracy.model_dump(), feature=touch.feature, edge_length=touch.edge)
        with under("room"):
            room = self.room.told()
        sensors, mixes = [], []
        for i, table in enumerate(self.sensor):
            with under("sensor", str(i)):
                sensors.append(table.told())
        for i, mixed in enumerate(self.mix):
            with under("mix", str(i)):
                mixes.append(Mix(mixed.name, tuple(_named(sensors, name) for name in mixed.kinds), mixed.together))
        skins = tuple(SkinChoice(table.name, build_skin(table, ("skin", str(i)))) for i, table in enumerate(self.skin))
        with under("search"):
            effort = Effort(**self.search.model_dump())
        with under("tolerances"):
            tolerances = _tolerances(self.tolerances)
        keys = {name: ("touch", name) for name in ("span", "largest_strain", "area", "half_width", "feature")}
        keys |= {name: ("accuracy", name) for name in ("radius", "edge", "blind_spots")}
        keys |= {name: ("tolerances", name) for name in self.tolerances or ()}
        with under(keys=keys):
            goals = Goals(
                touches=touches, strongest=strongest, accuracy=wanted, sensors=tuple(sensors), skins=skins, room=room,
                largest_strain=touch.largest_strain, tolerances=tolerances, effort=effort, title=self.title,
                mixes=tuple(mixes),
            )  # fmt: skip
        self._doubt()
        return goals

    def _doubt(self) -> None:
        """Warn of values whose unit was probably forgotten."""
        for skin in self.skin:
            for young in (skin.young, *(layer.young for layer in skin.layers or ())):
                if young is not None and young < SOFTEST and young != 1.0:
                    _check.doubt("young", young, "Pa", 1e6, "MPa")
        doubt_sizes(self)
        angle = self.accuracy.angle
        if angle is not None and angle > _WIDEST:
            _check.doubt("angle of [accuracy]", angle, "rad", np.pi / 180, "deg")


@dataclass(frozen=True)
class GoalsFile:
    """What a `goals.toml` says.

    Parameters
    ----------
    goals : Goals
        What is wanted.
    skins : tuple of dict
        The tables of the skins as they stand in the file, for the files of the fingers.
    text : str
        The file itself.
    """

    goals: Goals
    skins: tuple[Mapping[str, Any], ...]
    text: str


def load_goals(path: str | Path) -> GoalsFile:
    """Read goals from `path`.

    Raises
    ------
    FileError
        A file that cannot be read, is no TOML, or holds a wrong key or value. The message names the file, the line,
        what was seen, the rule and the fix.

    Examples
    --------
    >>> load_goals("goals.toml")
    Traceback (most recent call last):
    subskin.errors.FileError: goals.toml: there is no such file. Fix: check the name and the folder.
    """
    return parse_goals(read_text(path), str(path))


def parse_goals(text: str, name: str = "goals.toml") -> GoalsFile:
    """The goals that `text` describes; `name` is what messages call it.

    Raises
    ------
    FileError
        As `load_goals`.

    Examples
    --------
    >>> parse_goals("")
    Traceback (most recent call last):
    subskin.errors.FileError: goals.toml is empty: it needs [touch], [accuracy], [room], [[sensor]] and [[skin]].
    """
    goals = read_document(text, name, _Document, _NEEDS, _Document.told)
    raw = tomllib.loads(text)["skin"]
    skins = tuple({key: value for key, value in table.items() if key != "name"} for table in raw)
    return GoalsFile(goals, skins, text)


def _sides(given: Any, name: str) -> tuple[float, float]:
    sides = np.atleast_1d(given)
    if sides.shape not in ((1,), (2,)) or not (sides > 0).all():
        rule = "one side of a square, or the sides along y and z, each > 0, are needed"
        raise InvalidValueError(f"{name} lists {sides.size} sides", rule, f'{name} = ["12 mm", "10 mm"]')
    return float(sides[0]), float(sides[-1])


def _named(sensors: list[SensorKind], name: str) -> SensorKind:
    for kind in sensors:
        if kind.name == name:
            return kind
    known = ", ".join(f'"{kind.name}"' for kind in sensors)
    raise InvalidValueError(f'kinds name "{name}"', "a mix is of kinds that have a [[sensor]]", f"one of {known}")


def _tolerances(table: Mapping[str, Any] | None) -> dict[str, float] | None:
    """Amounts of the sources of error, each in its unit; nothing where the usual ones are meant."""
    if not table:
        return None
    if table.get("none") is True and len(table) == 1:
        return {}
    if "none" in table:
        rule, fix = "it stands alone, and is true", "[tolerances] none = true, or the amounts without it"
        raise InvalidValueError(f"none = {table['none']!r}", rule, fix)
    for name in table:
        if name not in _TOLERANCES:
            close = difflib.get_close_matches(name, list(_TOLERANCES), n=1)
            fix = f'did you mean "{close[0]}"' if close else f"known: {', '.join(_TOLERANCES)}"
            wrong = InvalidValueError(f'key "{name}"', "no such tolerance is known", fix)
            raise Misplaced(wrong, "tolerances", name)
    return {name: quantity(value, _TOLERANCES[name].unit, name) for name, value in table.items()}


def finger_text(file: GoalsFile, row: Row, search: Any, remarks: list[str]) -> str:
    """The `finger.toml` of the design `row` for the goals of `file`.

    It looks for loads within `search`, on an area its ends along y and along z [m]; `remarks` stand on top as comments.

    Examples
    --------
    >>> file = parse_goals('''
    ... touch = {force = "20 N/m", span = "10 mm"}
    ... accuracy = {position = "0.5 mm"}
    ... room = {count = 4, depth = "2 mm", least_pitch = "2 mm"}
    ... sensor = [{name = "gauge", kind = "normal_strain", noise = 1e-4}]
    ... skin = [{name = "soft", young = "0.4 MPa"}]
    ... ''')
    >>> row = Row(skin=0, sensor=0, layout=file.goals.layouts[0], depth=2e-3, pitch=2e-3)
    >>> finger_text(file, row, (-5e-3, 5e-3), ["tried"]).splitlines()[2:4]
    ['[skin]', 'young = "0.4 MPa"']
    """
    import tomlkit

    goals = file.goals
    document = tomlkit.document()
    for line in remarks:
        document.add(tomlkit.comment(line))
    document.add("skin", tomlkit.item({**file.skins[row.skin]}))
    document.add("sensors", tomlkit.item(_sensors_of(goals, row)))
    if goals.touches.length is not None:
        document.add("touch", tomlkit.item({"length": format_quantity(goals.touches.length, "m")}))
    ends: list[Any] = [[format_quantity(end, "m") for end in side] if goals.on_area else format_quantity(side, "m")
                       for side in search]  # fmt: skip
    document.add("locate", tomlkit.item({"friction": goals.touches.friction, "search": ends}))
    return tomlkit.dumps(document)


def _sensors_of(goals: Goals, row: Row) -> dict[str, Any]:
    """[sensors] of the design."""
    choice, layout = goals.choices[row.sensor], row.layout
    table: dict[str, Any] = {}
    if not goals.on_area:
        table |= {"count": row.count, "pitch": format_quantity(row.pitch, "m")}
    elif layout.pattern == "grid":
        table |= {"layout": "grid", "shape": [*layout.rows], "pitch": format_quantity(row.pitch, "m")}
        table |= {"centre": [format_quantity(side, "m") for side in goals.middle]} if any(goals.middle) else {}
    else:
        at = np.round(layout.points(row.pitch, goals.middle), 7)
        table |= {key: [format_quantity(v, "m") for v in at[:, i].tolist()] for i, key in enumerate("yz")}
    table["depth"] = format_quantity(row.depth, "m")
    kinds = list(choice.kinds)
    if len(kinds) > 1 and not choice.together:
        kinds = [kinds[i] for i in layout.colours(len(kinds))]
    said = [said_of(kind.transducer) for kind in kinds]
    table |= {"kind": said[0]} if len(kinds) == 1 else {"channels" if choice.together else "kind": said}
    each_of: dict[str, list[Any]] = {
        "noise": [rounded(kind.noise) for kind in kinds],
        "width": [format_quantity(kind.width, "m") for kind in kinds] if any(kind.width for kind in kinds) else [],
        "low": [rounded(-kind.largest) for kind in kinds],
        "high": [rounded(kind.largest) for kind in kinds],
        "resolution": [rounded(kind.resolution) for kind in kinds] if any(kind.resolution for kind in kinds) else [],
    }
    if not any(np.isfinite(kind.largest) for kind in kinds):
        del each_of["low"], each_of["high"]
    return table | {key: values if len(set(values)) > 1 else values[0] for key, values in each_of.items() if values}
