"""From what a designer knows to ranked fingers."""

from .goals import Accuracy, Effort, Goals, Room, Row, SensorKind, SkinChoice
from .grid import Criterion, DesignGrid, Store, search_grid
from .rank import Check, DesignedFinger, DesignStudy, rank_fingers

__all__ = [
    "Accuracy",
    "Check",
    "Criterion",
    "DesignGrid",
    "DesignStudy",
    "DesignedFinger",
    "Effort",
    "Goals",
    "Room",
    "Row",
    "SensorKind",
    "SkinChoice",
    "Store",
    "rank_fingers",
    "search_grid",
]
