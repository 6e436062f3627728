"""How probable each kind of contact makes readings."""

from . import columns
from .area import AreaEvidence
from .evidence import Evidence
from .kind import Kind
from .shapes import EDGE, END

__all__ = ["EDGE", "END", "AreaEvidence", "Evidence", "Kind", "columns"]
