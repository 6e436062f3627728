"""From what a designer knows to ranked fingers."""

from .choices import Effort, Mix, Room, SensorKind, SkinChoice
from .goals import Accuracy, Goals, Row
from .grid import Criterion, DesignGrid, Store, search_grid
from .look import Check, DesignedFinger
from .rank import DesignStudy, Remedy, rank_fingers

__all__ = [
    "Accuracy", "Check", "Criterion", "DesignGrid", "DesignStudy", "DesignedFinger", "Effort", "Goals", "Mix",
    "Remedy", "Room", "Row", "SensorKind", "SkinChoice", "Store", "rank_fingers", "search_grid",
]  # fmt: skip
