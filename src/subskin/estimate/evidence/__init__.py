"""How probable each kind of contact makes readings."""

from . import columns
from .evidence import Evidence
from .kind import Kind

__all__ = ["Evidence", "Kind", "columns"]
