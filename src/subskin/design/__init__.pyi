from . import blind_spots as blind_spots
from . import compliance as compliance
from . import finger_table as finger_table
from . import half_plane as half_plane
from . import outside as outside
from . import placement as placement
from . import response as response
from . import ridges as ridges
from . import sampling as sampling
from . import search as search
from . import tip as tip
from . import tolerance as tolerance
from . import touches as touches
from . import two_point as two_point
from . import words as words
from .compliance import skin_compliance
from .half_plane import half_plane_error, half_plane_map
from .placement import placement_quality
from .response import spatial_response
from .ridges import Ridges, best_ridge_pitch, press_ridges, ridge_gain
from .sampling import aliasing_error, sensor_density, sliding_samples
from .search import Goals, rank_fingers, search_grid
from .tolerance import tolerance_budget, usual_tolerances
from .touches import Touches
from .two_point import metamers, two_point_limen, two_point_study

__all__ = [
    "Goals",
    "Ridges",
    "Touches",
    "aliasing_error",
    "best_ridge_pitch",
    "half_plane_error",
    "half_plane_map",
    "metamers",
    "placement_quality",
    "press_ridges",
    "rank_fingers",
    "ridge_gain",
    "search_grid",
    "sensor_density",
    "skin_compliance",
    "sliding_samples",
    "spatial_response",
    "tolerance_budget",
    "two_point_limen",
    "two_point_study",
    "usual_tolerances",
]
