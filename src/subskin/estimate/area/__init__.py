"""A touch on an area located: position (y, z) and components (N, Ty, Tz)."""

from .in_place_locator import InPlaceLocator
from .locator import AreaLocator
from .observable import Observable, observable

__all__ = ["AreaLocator", "InPlaceLocator", "Observable", "observable"]
