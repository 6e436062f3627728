"""Tools for who designs a finger: everything here rides on `Finger` alone."""

from .half_plane_error import HalfPlaneError, LocatingError, half_plane_error, half_plane_map

__all__ = ["HalfPlaneError", "LocatingError", "half_plane_error", "half_plane_map"]
