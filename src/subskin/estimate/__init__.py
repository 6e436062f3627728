"""From readings to the contact that made them, with its uncertainty."""

from .answer import Status
from .either import Either
from .estimate import Estimate, Rival
from .layout import Layout
from .locate import fit, locate, locator
from .patches import PatchLocator
from .pressure import ImageMapper, PressureImage, PressureMap, PressureMapper, pressure_map
from .resultants import Resultant, ResultantReader, resultant
from .search import Locator
from .several import TouchSet
from .side import SideAngle, blind_depth, side_angle, side_angle_from_gradients, side_angle_from_slope

__all__ = [
    "Either",
    "Estimate",
    "ImageMapper",
    "Layout",
    "Locator",
    "PatchLocator",
    "PressureImage",
    "PressureMap",
    "PressureMapper",
    "Resultant",
    "ResultantReader",
    "Rival",
    "SideAngle",
    "Status",
    "TouchSet",
    "blind_depth",
    "fit",
    "locate",
    "locator",
    "pressure_map",
    "resultant",
    "side_angle",
    "side_angle_from_gradients",
    "side_angle_from_slope",
]
