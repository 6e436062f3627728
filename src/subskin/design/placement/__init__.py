"""Where to put the sensors: bounds, ambiguity, and the best row."""

from ._area import AREA_MEASURES, Channel
from ._table import PLACEMENT_MEASURES
from .area import AREA_SAMPLES, channels_of, study_area
from .area_quality import AreaQuality, area_quality
from .best import BestRow, best_row
from .layout import PATTERNS, Arrangement, layouts
from .positions import BestPositions, best_positions
from .quality import PlacementQuality, placement_quality
from .row import study_row
from .study import PlacementStudy, placement_study

__all__ = [
    "AREA_MEASURES",
    "AREA_SAMPLES",
    "PATTERNS",
    "PLACEMENT_MEASURES",
    "AreaQuality",
    "Arrangement",
    "BestPositions",
    "BestRow",
    "Channel",
    "PlacementQuality",
    "PlacementStudy",
    "area_quality",
    "best_positions",
    "best_row",
    "channels_of",
    "layouts",
    "placement_quality",
    "placement_study",
    "study_area",
    "study_row",
]
