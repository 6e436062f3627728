"""How probable each kind of contact makes readings."""

from .area import AreaEvidence
from .evidence import Evidence
from .kind import RECTANGLES, Kind
from .shapes import EDGE, END

__all__ = ["EDGE", "END", "RECTANGLES", "AreaEvidence", "Evidence", "Kind"]
