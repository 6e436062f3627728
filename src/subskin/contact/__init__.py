"""What presses on a skin: one small module a contact, each two formulas long."""

from .base import Contact, ContactSum, ProportionalContact, Transforms
from .hertz import Hertz
from .line import LineLoad
from .partial_slip import PartialSlip
from .profile import PressureProfile
from .punch import FlatPunch
from .spread import SpreadContact
from .strip import Strip
from .wedge import Wedge

__all__ = [
    "Contact",
    "ContactSum",
    "FlatPunch",
    "Hertz",
    "LineLoad",
    "PartialSlip",
    "PressureProfile",
    "ProportionalContact",
    "SpreadContact",
    "Strip",
    "Transforms",
    "Wedge",
]
