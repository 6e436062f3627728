"""Where to put the sensors: bounds, ambiguity, and free positions."""

from .asked import AREA_MEASURES, AREA_SAMPLES, PLACEMENT_MEASURES
from .best import BestPositions, best_positions
from .layout import PATTERNS, Arrangement, Channel, channels_of, layouts
from .study import PlacementQuality, placement_quality, study_at_depth

__all__ = [
    "AREA_MEASURES",
    "AREA_SAMPLES",
    "PATTERNS",
    "PLACEMENT_MEASURES",
    "Arrangement",
    "BestPositions",
    "Channel",
    "PlacementQuality",
    "best_positions",
    "channels_of",
    "layouts",
    "placement_quality",
    "study_at_depth",
]
