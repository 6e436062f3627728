"""What a device sends, understood: bytes in, frames out, without input or output. Found by name, in files too."""

from .base import Driver
from .checks import CHECKS
from .described import Described
from .fields import Field
from .fixed import AnySkin, Fixed
from .lines import Lines, TakkTile
from .names import kinds, named
from .pts import Contactile
from .tables import from_table, load
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
