"""Contact of a skin with a rigid body: indenters, and the solver that finds pressure, shear, stick and slip."""

from .area.solution import LocalSolution
from .body import Cone, Ellipsoid, LocalIndenter, Roller, Sphere
from .certificate import Certificate
from .indenter import Cylinder, Edge, Flat, Indenter, ParticleOnFlat, Profile, RoundedFlat, RoundedWedge, SineRidges
from .press import press
from .solution import ContactSolution, PressStatus

__all__ = [
    "Certificate",
    "Cone",
    "ContactSolution",
    "Cylinder",
    "Edge",
    "Ellipsoid",
    "Flat",
    "Indenter",
    "LocalIndenter",
    "LocalSolution",
    "ParticleOnFlat",
    "PressStatus",
    "Profile",
    "Roller",
    "RoundedFlat",
    "RoundedWedge",
    "SineRidges",
    "Sphere",
    "press",
]
