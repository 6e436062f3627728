"""From what a designer knows to ranked fingers."""

from .choices import Mix, SensorKind, SkinChoice
from .designed import Check, DesignedFinger, DesignStudy
from .goals import Accuracy, Goals, Row
from .grid import Criterion, DesignGrid, Store, search_grid
from .rank import rank_fingers
from .remedy import Remedy
from .room import Effort, Room

__all__ = [
    "Accuracy",
    "Check",
    "Criterion",
    "DesignGrid",
    "DesignStudy",
    "DesignedFinger",
    "Effort",
    "Goals",
    "Mix",
    "Remedy",
    "Room",
    "Row",
    "SensorKind",
    "SkinChoice",
    "Store",
    "rank_fingers",
    "search_grid",
]
