"""What presses on a skin: contacts, whose files are found by themselves.

A contact is its spectrum, its traction and its support: a long one, which does not change along z (`Contact`), or a
local one (`LocalContact`). A class of long contacts with a name is a family that fits, decisions, simulations and
commands take (`families`).
"""

from importlib import import_module
from pkgutil import iter_modules

from .base import Contact, ContactSum, Spectrum, Transforms
from .elliptic_hertz import EllipticHertz
from .families import contact_of, families, family_of, local_families, local_family_of
from .from_projections import FromProjections
from .hertz import Hertz, PartialSlip
from .line import LineLoad
from .local import (
    LocalContact,
    LocalSpectrum,
    LocalSum,
    LocalTransforms,
    Potentials,
    RadialTerm,
    local_potentials_of,
    local_transforms_of,
)
from .patch import Patch
from .pressure_grid import PressureGrid
from .profile import PressureProfile
from .punch import FlatPunch, Strip, Wedge
from .round_contact import AxialContact, PointLoad, RoundContact
from .round_hertz import Cone, RoundHertz, RoundPunch
from .shaped import ShapedContact
from .spread import ProportionalContact, SpreadContact

__all__ = [
    "AxialContact",
    "Cone",
    "Contact",
    "ContactSum",
    "EllipticHertz",
    "FlatPunch",
    "FromProjections",
    "Hertz",
    "LineLoad",
    "LocalContact",
    "LocalSpectrum",
    "LocalSum",
    "LocalTransforms",
    "PartialSlip",
    "Patch",
    "PointLoad",
    "Potentials",
    "PressureGrid",
    "PressureProfile",
    "ProportionalContact",
    "RadialTerm",
    "RoundContact",
    "RoundHertz",
    "RoundPunch",
    "ShapedContact",
    "Spectrum",
    "SpreadContact",
    "Strip",
    "Transforms",
    "Wedge",
    "contact_of",
    "families",
    "family_of",
    "local_families",
    "local_family_of",
    "local_potentials_of",
    "local_transforms_of",
]

for _module in iter_modules(__path__):  # a contact is registered when its file is imported
    if not _module.name.startswith("_"):
        import_module(f"{__name__}.{_module.name}")
