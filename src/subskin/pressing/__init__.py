"""Contact of a skin with a rigid body: indenters, and the solver that finds pressure, shear, stick and slip."""

from .certificate import Certificate
from .indenter import Cylinder, Edge, Flat, Indenter, ParticleOnFlat, Profile, RoundedFlat, RoundedWedge, SineRidges
from .press import press
from .solution import ContactSolution, PressStatus

__all__ = [
    "Certificate",
    "ContactSolution",
    "Cylinder",
    "Edge",
    "Flat",
    "Indenter",
    "ParticleOnFlat",
    "PressStatus",
    "Profile",
    "RoundedFlat",
    "RoundedWedge",
    "SineRidges",
    "press",
]
