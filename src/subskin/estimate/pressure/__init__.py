"""The pressure along the surface, from many sensors."""

from .map import PressureMap
from .mapper import PressureMapper, pressure_map

__all__ = ["PressureMap", "PressureMapper", "pressure_map"]
