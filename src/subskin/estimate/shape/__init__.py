"""Contacts of some width: fitted, and weighed against each other."""

from .evidence import Evidence, Kind
from .fit import Fitter
from .shape import ShapeEstimate, ShapeRival
from .shape_field import ShapeField

__all__ = ["Evidence", "Fitter", "Kind", "ShapeEstimate", "ShapeField", "ShapeRival"]
