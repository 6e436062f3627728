"""A touch on an area located: position (y, z) and components (N, Ty, Tz)."""

from .locator import AreaLocator
from .observable import Observable, observable

__all__ = ["AreaLocator", "Observable", "observable"]
