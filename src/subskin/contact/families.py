"""Families of contacts by name: those of one half width, or none, that fits and simulations choose among."""

from __future__ import annotations

from ..errors import InvalidValueError
from .hertz import Hertz
from .line import LineLoad
from .punch import FlatPunch
from .spread import SpreadContact
from .strip import Strip
from .wedge import Wedge

__all__ = ["FAMILIES", "Family", "family_of"]

Family = type[SpreadContact] | type[LineLoad]

FAMILIES: dict[str, Family] = {
    "line": LineLoad, "wedge": Wedge, "hertz": Hertz, "strip": Strip, "punch": FlatPunch,
}  # fmt: skip
"""Contact families by name, from the narrowest."""


def family_of(family: str | Family) -> Family:
    """The class of a named family, or one's own.

    Raises
    ------
    InvalidValueError
        An unknown name, something that is no contact of one width.
    """
    if isinstance(family, str):
        if family not in FAMILIES:
            raise InvalidValueError(f'family = "{family}"', f"has to be one of {', '.join(FAMILIES)}")
        return FAMILIES[family]
    if isinstance(family, type) and issubclass(family, SpreadContact | LineLoad):
        return family
    raise InvalidValueError(
        f"family = {family!r}",
        "a name or a subclass of SpreadContact is needed",
        f"one of {', '.join(FAMILIES)}",
    )
