"""Where to put the sensors: bounds and ambiguity."""

from .asked import AREA_MEASURES, AREA_SAMPLES, PLACEMENT_MEASURES
from .layout import PATTERNS, Arrangement, Channel, channels_of, layouts
from .study import PlacementQuality, placement_quality, study_at_depth

__all__ = [
    "AREA_MEASURES", "AREA_SAMPLES", "PATTERNS", "PLACEMENT_MEASURES", "Arrangement", "Channel", "PlacementQuality",
    "channels_of", "layouts", "placement_quality", "study_at_depth",
]  # fmt: skip
