"""Contact of a skin with a rigid body: indenters, and the solver that finds pressure, shear, stick and slip."""

from .body import ConeTip, Ellipsoid, LocalIndenter, Roller, Sphere
from .certificate import Certificate
from .indenter import Cylinder, Edge, Flat, Indenter, ParticleOnFlat, RoundedFlat, RoundedWedge, SineRidges
from .press import press
from .scanned import HeightMap, Profile
from .shapes import Box, BoxCorner, BoxEdge, Pin, RidgedBody, Together
from .solution import ContactSolution, LocalSolution, PressStatus, Solution

__all__ = [
    "Box",
    "BoxCorner",
    "BoxEdge",
    "Certificate",
    "ConeTip",
    "ContactSolution",
    "Cylinder",
    "Edge",
    "Ellipsoid",
    "Flat",
    "HeightMap",
    "Indenter",
    "LocalIndenter",
    "LocalSolution",
    "ParticleOnFlat",
    "Pin",
    "PressStatus",
    "Profile",
    "RidgedBody",
    "Roller",
    "RoundedFlat",
    "RoundedWedge",
    "SineRidges",
    "Solution",
    "Sphere",
    "Together",
    "press",
]
