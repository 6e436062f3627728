"""Tools for who designs a finger: everything here rides on `Finger` alone."""

from .compliance import Regime, SkinCompliance, skin_compliance
from .half_plane_error import (
    MAP_RADIUS,
    MAP_THICKNESS,
    HalfPlaneError,
    LocatingError,
    half_plane_error,
    half_plane_map,
)
from .touches import Touches

__all__ = [
    "MAP_RADIUS",
    "MAP_THICKNESS",
    "HalfPlaneError",
    "LocatingError",
    "Regime",
    "SkinCompliance",
    "Touches",
    "half_plane_error",
    "half_plane_map",
    "skin_compliance",
]
