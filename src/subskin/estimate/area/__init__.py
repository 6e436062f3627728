"""A touch on an area located: position (y, z) and components (N, Ty, Tz), of a round contact its half width too."""

from .in_place_locator import InPlaceLocator
from .locator import AreaLocator, RoundLocator
from .observable import Observable, observable

__all__ = ["AreaLocator", "InPlaceLocator", "Observable", "RoundLocator", "observable"]
