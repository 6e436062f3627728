"""What a device sends, understood: bytes in, frames out, without input or output. Found by name, in files too."""

from .base import Driver, from_table, kinds, load, named
from .fixed import AnySkin, Described, Fixed
from .framing import Field
from .lines import Lines, TakkTile
from .makers import Contactile, Xela
from .parts import CHECKS

__all__ = [
    "CHECKS",
    "AnySkin",
    "Contactile",
    "Described",
    "Driver",
    "Field",
    "Fixed",
    "Lines",
    "TakkTile",
    "Xela",
    "from_table",
    "kinds",
    "load",
    "named",
]
