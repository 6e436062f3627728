"""What a device sends, understood: bytes in, frames out, without input or output. Found by name, in files too."""

from .base import Driver
from .fields import Field
from .fixed import AnySkin, Described, Fixed
from .lines import Lines, TakkTile
from .names import from_table, kinds, load, named
from .parts import CHECKS
from .pts import Contactile
from .xela import Xela

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
