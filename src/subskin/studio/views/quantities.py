"""What a page can draw in the skin: its name, its letters, its unit, and how it is taken of a state."""

from __future__ import annotations

from collections.abc import Callable
from operator import attrgetter
from typing import NamedTuple

from ..._check import FloatArray
from ...tensor import State

__all__ = ["QUANTITIES", "FieldKind", "offered"]


class FieldKind(NamedTuple):
    """A field that can be drawn."""

    name: str
    label: str
    unit: str
    scale: float
    of: Callable[[State], FloatArray]


def _made() -> dict[str, FieldKind]:
    every = [FieldKind("mean_pressure", "mean pressure", "kPa", 1e-3, attrgetter("stress.mean_pressure"))]
    for what, letter, shear, unit, scale in (("strain", "ε", "ε", "%", 100.0), ("stress", "σ", "τ", "kPa", 1e-3)):
        for c in ("xx", "yy", "zz", "xy", "xz", "yz"):
            plain = c[0] == c[1]
            sign = f"{letter}{c[0]}" if plain else f"{shear}{c}"
            words = f"{what} {sign}" if plain else f"shear {what} {sign}"
            every.append(FieldKind(f"{what}.{c}", words, unit, scale, attrgetter(f"{what}.{c}")))
    for c in "xyz":
        every.append(FieldKind(f"displacement.{c}", f"displacement u{c}", "µm", 1e6, attrgetter(f"displacement.{c}")))
    return {quantity.name: quantity for quantity in every}


QUANTITIES = _made()
"""All of them, by name."""


def offered(*, local: bool) -> list[FieldKind]:
    """Those that differ from nothing: under a long contact there is no shear along z, and no displacement is known.

    Parameters
    ----------
    local : bool
        Whether the contact ends along z.
    """
    hidden = () if local else ("xz", "yz")
    return [q for q in QUANTITIES.values() if local or not (q.name.endswith(hidden) or q.name.startswith("displ"))]
