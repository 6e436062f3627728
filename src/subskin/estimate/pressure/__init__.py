"""The pressure along the surface, or on an area, from many sensors."""

from .image import PressureImage
from .map import PressureMap
from .mapper import ImageMapper, PressureMapper
from .pressure_map import pressure_map, pressure_mapper

__all__ = ["ImageMapper", "PressureImage", "PressureMap", "PressureMapper", "pressure_map", "pressure_mapper"]
