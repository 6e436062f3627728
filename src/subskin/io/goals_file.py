"""`goals.toml`: what the designer of a finger knows and wants, read and checked; and a design as a `finger.toml`."""

from __future__ import annotations

import difflib
import tomllib
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ..design import Goals, Touches
from ..design.search import Accuracy, Effort, Mix, Room, Row, SensorKind, SkinChoice
from ..design.tolerance import SOURCES
from ..errors import InvalidValueError, SubskinError
from ._sensors import said_of, transducer_said
from ._sizes import doubt_goals
from ._skin import Misplaced, build_skin, key_of
from ._toml_errors import misplaced, read_text, validated
from .units import format_quantity, line_load, quantity, rounded

if TYPE_CHECKING:
    from . import _goals_schema

__all__ = ["GoalsFile", "finger_text", "load_goals", "parse_goals"]

_TOLERANCES = {name: source for name, source in SOURCES.items() if source.unit != "reading"}
"""What making a finger leaves open; what a reading is off by is said of each kind of sensor."""
_NEEDS = "it needs [touch], [accuracy], [room], [[sensor]] and [[skin]]"


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
    from ._goals_schema import GoalsDocument

    document = validated(text, name, GoalsDocument, _NEEDS)
    try:
        goals = _build(document)
    except Misplaced as wrong:
        raise misplaced(text, name, wrong.path, wrong.error) from None
    doubt_goals(document)
    raw = tomllib.loads(text)["skin"]
    skins = tuple({key: value for key, value in table.items() if key != "name"} for table in raw)
    return GoalsFile(goals, skins, text)


def _build(document: _goals_schema.GoalsDocument) -> Goals:
    touch, accuracy, room = document.touch, document.accuracy, document.room
    counts = room.count if isinstance(room.count, list) else [room.count, room.count]
    depths = room.depth if isinstance(room.depth, list) else [room.depth, room.depth]
    longest = np.inf if room.longest_row is None else room.longest_row
    keys: dict[str, tuple[str, ...]] = {}  # of the goals as a whole, where they are
    at: tuple[str, ...] = ("touch",)
    try:
        if touch.length is not None and not touch.length > 0:
            raise InvalidValueError(f"length = {touch.length:g} m", "has to be > 0", 'length = "20 mm"')
        touches, strongest = _touches(touch)
        at = ("accuracy",)
        wanted = Accuracy(**accuracy.model_dump(), feature=touch.feature, edge_length=touch.edge)
        at = ("room",)
        if len(depths) != 2:
            rule, fix = "one depth or two are needed", 'depth = ["1 mm", "4 mm"]'
            raise InvalidValueError(f"depth lists {len(depths)}", rule, fix)
        where = {} if room.layouts is None else {"layouts": tuple(room.layouts)}
        sides = None if room.area is None else _sides(room.area, "area")
        space = Room((counts[0], counts[1]), (depths[0], depths[1]), room.least_pitch, longest, sides, **where)
        sensors = []
        for i, table in enumerate(document.sensor):
            at = ("sensor", str(i))
            sensors.append(_sensor(table))
        mixes = []
        for i, mixed in enumerate(document.mix):
            at = ("mix", str(i))
            mixes.append(Mix(mixed.name, tuple(_named(sensors, name) for name in mixed.kinds), mixed.together))
        skins = [SkinChoice(table.name, build_skin(table, ("skin", str(i)))) for i, table in enumerate(document.skin)]
        at = ("search",)
        effort = Effort(**document.search.model_dump())
        at = ("tolerances",)
        tolerances = _tolerances(document.tolerances)
        at = ()
        keys = {name: ("touch", name) for name in ("span", "largest_strain", "area", "half_width", "feature")}
        keys |= {name: ("accuracy", name) for name in ("radius", "edge", "blind_spots")}
        keys |= {name: ("tolerances", name) for name in document.tolerances or ()}
        return Goals(
            touches=touches, strongest=strongest, accuracy=wanted, sensors=tuple(sensors), skins=tuple(skins),
            room=space, largest_strain=touch.largest_strain, tolerances=tolerances, effort=effort,
            title=document.title, mixes=tuple(mixes),
        )  # fmt: skip
    except SubskinError as error:
        key = key_of(error)
        raise Misplaced(error, *keys.get(key, (*at, key))) from None


def _touches(touch: _goals_schema.TouchTable) -> tuple[Touches, float]:
    """What the finger is to feel, and the strongest force [N/m, on an area N]."""
    given = touch.force if isinstance(touch.force, list) else [touch.force, touch.force]
    unit = "N/m" if touch.area is None else "N"
    forces = [
        line_load(value, touch.length, "force") if touch.area is None else quantity(value, "N", "force")
        for value in given
    ]
    if len(forces) != 2:
        rule, fix = "one force or two are needed", f'force = ["20 {unit}", "100 {unit}"]'
        raise InvalidValueError(f"force lists {len(forces)}", rule, fix)
    if forces[0] > forces[1]:
        raise InvalidValueError(f"force = {forces} {unit}", "the weakest comes first", "swap them")
    if (touch.span is None) == (touch.area is None):
        seen = "neither span nor area" if touch.span is None else "span and area"
        rule = "a row of sensors serves a span, an array on an area serves an area"
        raise InvalidValueError(seen, rule, 'span = "12 mm", or area = ["12 mm", "12 mm"]')
    if touch.area is not None:
        y, z = _sides(touch.area, "area")
        area = ((-y / 2, y / 2), (-z / 2, z / 2))
        wide = touch.half_width
        return Touches(forces[0], touch.friction, length=touch.length, area=area, half_width=wide), forces[1]
    span = touch.span or 0.0
    if not span > 0:
        raise InvalidValueError(f"span = {touch.span:g}", "has to be > 0", 'span = "12 mm"')
    ends = (-span / 2, span / 2)
    return Touches(forces[0], touch.friction, ends, touch.length, half_width=touch.half_width), forces[1]


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


def _sensor(table: _goals_schema.SensorTable) -> SensorKind:
    transducer = transducer_said(table.kind, False, "kind")
    values = {
        key: quantity(getattr(table, key), transducer.unit, key)
        for key in ("noise", "largest", "resolution")
        if getattr(table, key) is not None
    }
    return SensorKind(table.name, transducer, width=table.width, **values)


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
    >>> row = Row(skin=0, sensor=0, count=4, depth=2e-3, pitch=2e-3)
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
    if layout is None:
        table |= {"count": row.count, "pitch": format_quantity(row.pitch, "m")}
    elif layout.pattern == "grid":
        shape = [layout.rows[0], len(layout.rows)]
        table |= {"layout": "grid", "shape": shape, "pitch": format_quantity(row.pitch, "m")}
        table |= {"centre": [format_quantity(side, "m") for side in goals.middle]} if any(goals.middle) else {}
    if layout is not None and layout.pattern != "grid":
        at = np.round(layout.points(row.pitch, goals.middle), 7)
        table |= {key: [format_quantity(v, "m") for v in at[:, i].tolist()] for i, key in enumerate("yz")}
    table["depth"] = format_quantity(row.depth, "m")
    kinds = list(choice.kinds)
    if len(kinds) > 1 and not choice.together and layout is not None:
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
