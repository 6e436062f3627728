"""Where to put the sensors: bounds, ambiguity, and the best row."""

from .asked import AREA_MEASURES, AREA_SAMPLES, PLACEMENT_MEASURES
from .best import BestPositions, BestRow, best_positions, best_row
from .layout import PATTERNS, Arrangement, Channel, channels_of, layouts
from .quality import PlacementQuality, placement_quality
from .study import PlacementStudy, placement_study, study_at_depth

__all__ = [
    "AREA_MEASURES",
    "AREA_SAMPLES",
    "PATTERNS",
    "PLACEMENT_MEASURES",
    "Arrangement",
    "BestPositions",
    "BestRow",
    "Channel",
    "PlacementQuality",
    "PlacementStudy",
    "best_positions",
    "best_row",
    "channels_of",
    "layouts",
    "placement_quality",
    "placement_study",
    "study_at_depth",
]
