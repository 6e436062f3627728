"""Where to put the sensors: bounds, ambiguity, and the best row."""

from ._area import AREA_MEASURES, Kind
from ._table import PLACEMENT_MEASURES
from .area import study_area
from .best import BestRow, best_row
from .layout import Layout, layouts
from .positions import BestPositions, best_positions
from .quality import PlacementQuality, placement_quality
from .row import study_row
from .study import PlacementStudy, placement_study

__all__ = [
    "AREA_MEASURES",
    "PLACEMENT_MEASURES",
    "BestPositions",
    "BestRow",
    "Kind",
    "Layout",
    "PlacementQuality",
    "PlacementStudy",
    "best_positions",
    "best_row",
    "layouts",
    "placement_quality",
    "placement_study",
    "study_area",
    "study_row",
]
