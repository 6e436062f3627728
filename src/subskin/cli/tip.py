"""What `subskin check` says of flat layers that are bent to a round tip."""

from __future__ import annotations

import math
import textwrap
from dataclasses import asdict
from typing import TYPE_CHECKING, Any, TextIO

from .common import number
from .text_table import show

if TYPE_CHECKING:
    from ..design.tip import TipError

__all__ = ["as_json", "draw", "people"]

_LITTLE = 0.02
"""Errors, in depths and in rad, that nobody minds."""

_NAMES = {"sphere": "ball", "cylinder": "cylinder"}
_PEOPLE = {"normal_strain": "normal strain", "mean_pressure": "pressure"}


def as_json(found: TipError) -> dict[str, Any]:
    """The numbers, in SI."""
    return {"tip": asdict(found)}


def people(out: TextIO, found: TipError) -> None:
    """A table, and the sentence that sums it up."""
    name = _NAMES[found.shape]
    row = [
        *(number(1e3 * v) for v in (found.radius, found.thickness, found.depth)),
        f"{100 * found.reading:.1f}", number(1e3 * found.position, 2), f"{100 * found.force:.1f}",
        number(math.degrees(found.angle), 2),
    ]  # fmt: skip
    columns = ["tip [mm]", "skin [mm]", "depth [mm]", "reading [%]", "position [mm]", "force [%]", "angle [deg]"]
    show(out, f"flat layers on a {name}: worst errors", columns, [row])
    sensors = " or ".join(_PEOPLE[kind] for kind in found.kinds)
    loads = "touches" if found.shape == "sphere" else "long contacts"
    print(
        textwrap.fill(
            f"looked up for sensors of {sensors}, one depth apart, in one incompressible layer on a rigid core", 110
        ),
        file=out,
    )
    print(textwrap.fill(f"-> {_sentence(found, name, loads)}", 110, subsequent_indent="   "), file=out)


def _sentence(found: TipError, name: str, loads: str) -> str:
    size = f"{number(1e3 * found.radius)} mm"
    if found.position < _LITTLE * found.depth and max(found.angle, found.force) < _LITTLE:
        return f"the flat layers will do: on a {name} of {size} they misplace {loads} by less than 0.02 depths"
    said = (
        f"on a {name} of {size} flat layers misplace {loads} by up to {number(1e3 * found.position, 2)} mm, with "
        f"forces off by up to {100 * found.force:.0f} % and angles by up to {math.degrees(found.angle):.0f} deg"
    )
    if found.shape == "cylinder":
        return f'{said}: take kind = "round", the same layers on a round core'
    return f"{said}: no skin here is a ball, so calibrate with touches at known positions, which finds its response"


def draw(path: str, found: TipError) -> None:
    """The table's map, with this tip ringed."""
    from ..design.tip import tip_map
    from ..plot import save, tip_map_figure

    at = found.radius / found.thickness, found.depth / found.thickness
    save(tip_map_figure(tip_map(found.shape, found.kinds[0]), at), path)
