"""The angle of force on a side by quick ways: the slope beneath the centre, gradients at two depths."""

from .angle import SideAngle, side_angle
from .slope import blind_depth, side_angle_from_gradients, side_angle_from_slope

__all__ = ["SideAngle", "blind_depth", "side_angle", "side_angle_from_gradients", "side_angle_from_slope"]
