"""Skins on geoms of MuJoCo: contacts become pressures, and sensors read them."""

from .geom_skin import Felt, GeomSkin, Touch, contact_to_skin
from .sensing import SampledSkin, skins_of

__all__ = ["Felt", "GeomSkin", "SampledSkin", "Touch", "contact_to_skin", "skins_of"]
