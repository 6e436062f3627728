"""Two points or one: when two touches read as two on a row of sensors (memo section 7, Figs. 18 and 19)."""

from .area import AreaLimen, edge_direction, two_point_area
from .limen import TwoPointLimen, two_point_limen
from .study import Metamers, TwoPointStudy, metamers, two_point_study

__all__ = [
    "AreaLimen", "Metamers", "TwoPointLimen", "TwoPointStudy", "edge_direction", "metamers", "two_point_area",
    "two_point_limen", "two_point_study",
]  # fmt: skip
