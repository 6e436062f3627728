"""From readings to the load that made them, with its uncertainty."""

from .estimate import Estimate, Rival, Status
from .locate import Locator
from .pressure import PressureMap, PressureMapper, pressure_map
from .shape import Fitter, ShapeEstimate, ShapeField, ShapeRival
from .side import SideAngle, blind_depth, side_angle, side_angle_from_gradients, side_angle_from_slope

__all__ = [
    "Estimate",
    "Fitter",
    "Locator",
    "PressureMap",
    "PressureMapper",
    "Rival",
    "ShapeEstimate",
    "ShapeField",
    "ShapeRival",
    "SideAngle",
    "Status",
    "blind_depth",
    "pressure_map",
    "side_angle",
    "side_angle_from_gradients",
    "side_angle_from_slope",
]
