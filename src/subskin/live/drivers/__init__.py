"""What a device sends, understood: bytes in, frames out, without input or output. Found by name, in files too."""

from .base import Driver
from .checks import CHECKS
from .fields import Field
from .fixed import AnySkin, Fixed
from .lines import Lines, TakkTile
from .names import from_table, kinds, named

__all__ = ["CHECKS", "AnySkin", "Driver", "Field", "Fixed", "Lines", "TakkTile", "from_table", "kinds", "named"]
