"""What is pressed: the media in which sensors lie."""

from .base import Skin
from .half_plane import HalfPlane

__all__ = ["HalfPlane", "Skin"]
