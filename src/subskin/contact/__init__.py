"""What presses on a skin: one small file a contact, found by itself.

A contact is its spectrum, its traction and its support: a long one, which does not change along z (`Contact`), or a
local one (`LocalContact`). A class of long contacts with a name is a family that fits, decisions, simulations and
commands take (`families`).
"""

from importlib import import_module
from pkgutil import iter_modules

from .axial import AxialContact
from .base import Contact, ContactSum, Spectrum, Transforms
from .cone import Cone
from .elliptic_hertz import EllipticHertz
from .families import contact_of, families, family_of, local_families, local_family_of
from .from_projections import FromProjections
from .hertz import Hertz
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
from .partial_slip import PartialSlip
from .patch import Patch
from .point import PointLoad
from .pressure_grid import PressureGrid
from .profile import PressureProfile
from .proportional import ProportionalContact
from .punch import FlatPunch
from .round_contact import RoundContact
from .round_hertz import RoundHertz
from .round_punch import RoundPunch
from .shaped import ShapedContact
from .spread import SpreadContact
from .strip import Strip
from .wedge import Wedge

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
