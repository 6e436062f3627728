"""Where to put the sensors: bounds, ambiguity, and the best row."""

from ._table import PLACEMENT_MEASURES
from .best import BestRow, best_row
from .positions import BestPositions, best_positions
from .quality import PlacementQuality, placement_quality
from .row import study_row
from .study import PlacementStudy, placement_study

__all__ = [
    "PLACEMENT_MEASURES",
    "BestPositions",
    "BestRow",
    "PlacementQuality",
    "PlacementStudy",
    "best_positions",
    "best_row",
    "placement_quality",
    "placement_study",
    "study_row",
]
