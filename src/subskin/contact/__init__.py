"""What presses on a skin: one small file a contact, found by itself.

A contact is its spectrum, its traction and its support (`Contact`); a class with a name is a family that fits,
decisions, simulations and commands take (`families`).
"""

from importlib import import_module
from pkgutil import iter_modules

from .axial import AxialContact
from .base import Contact, ContactSum, Spectrum, Transforms, transforms_of
from .families import contact_of, families, family_of
from .hertz import Hertz
from .line import LineLoad
from .local import LocalContact, LocalSpectrum, LocalSum, LocalTransforms, Potentials, RadialTerm
from .partial_slip import PartialSlip
from .point import PointLoad
from .profile import PressureProfile
from .proportional import ProportionalContact
from .punch import FlatPunch
from .shaped import ShapedContact
from .spread import SpreadContact
from .strip import Strip
from .wedge import Wedge

__all__ = [
    "AxialContact",
    "Contact",
    "ContactSum",
    "FlatPunch",
    "Hertz",
    "LineLoad",
    "LocalContact",
    "LocalSpectrum",
    "LocalSum",
    "LocalTransforms",
    "PartialSlip",
    "PointLoad",
    "Potentials",
    "PressureProfile",
    "ProportionalContact",
    "RadialTerm",
    "ShapedContact",
    "Spectrum",
    "SpreadContact",
    "Strip",
    "Transforms",
    "Wedge",
    "contact_of",
    "families",
    "family_of",
    "transforms_of",
]

for _module in iter_modules(__path__):  # a contact is registered when its file is imported
    if not _module.name.startswith("_"):
        import_module(f"{__name__}.{_module.name}")
