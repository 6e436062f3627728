"""What is pressed: the media in which sensors lie."""

from collections.abc import Mapping

from .base import Skin
from .half_plane import HalfPlane
from .half_space import HalfSpace, in_space
from .layered import Layer, Layered
from .ridged import Ridged
from .round import Round

__all__ = ["KINDS", "HalfPlane", "HalfSpace", "Layer", "Layered", "Ridged", "Round", "Skin", "in_space"]

KINDS: Mapping[str, type[Skin]] = {"half_plane": HalfPlane, "half_space": HalfSpace, "layers": Layered, "round": Round}
"""Names of the skins in a file."""
