"""Two points or one: what a row of sensors can tell apart (memo section 7, Figs. 18 and 19)."""

from .limen import TwoPointLimen, two_point_limen
from .metamers import Metamers, metamers
from .study import TwoPointStudy, two_point_study

__all__ = ["Metamers", "TwoPointLimen", "TwoPointStudy", "metamers", "two_point_limen", "two_point_study"]
