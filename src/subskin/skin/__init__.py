"""What is pressed: the media in which sensors lie."""

from .base import Skin
from .half_plane import HalfPlane
from .layered import Layer, Layered
from .round import Round

__all__ = ["HalfPlane", "Layer", "Layered", "Round", "Skin"]
