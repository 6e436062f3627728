"""Solid mechanics for touch: from a pressed skin to what its sensors read, and back."""

from .contact import Contact, ContactSum, LineLoad
from .errors import (
    ConvergenceError,
    FileError,
    GeometryError,
    InvalidValueError,
    NotLinearError,
    SingularPointWarning,
    SubskinError,
    ValidityWarning,
)
from .field import State, Strain, Stress
from .material import Material
from .skin import HalfPlane, Skin

__version__ = "0.1.0"
