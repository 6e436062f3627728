"""How probable each kind of contact makes readings."""

from . import columns
from .evidence import Evidence, Kind

__all__ = ["Evidence", "Kind", "columns"]
