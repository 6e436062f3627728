"""What is pressed: the media in which sensors lie."""

from collections.abc import Mapping

from .base import Skin
from .half_plane import HalfPlane
from .layered import Layer, Layered
from .round import Round

__all__ = ["KINDS", "HalfPlane", "Layer", "Layered", "Round", "Skin"]

KINDS: Mapping[str, type[Skin]] = {"half_plane": HalfPlane, "layers": Layered, "round": Round}
"""Names of the skins in a file."""
