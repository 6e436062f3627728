"""Skins on geoms of MuJoCo: contacts become pressures, and sensors read them."""

from .geom_skin import Felt, GeomSkin, GeomTouch, contact_to_skin
from .sensing import SampledSkin, skins_of

__all__ = ["Felt", "GeomSkin", "GeomTouch", "SampledSkin", "contact_to_skin", "skins_of"]
