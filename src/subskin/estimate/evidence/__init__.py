"""How probable each kind of contact makes readings."""

from . import columns
from .area import AreaEvidence
from .evidence import Evidence
from .kind import Kind

__all__ = ["AreaEvidence", "Evidence", "Kind", "columns"]
