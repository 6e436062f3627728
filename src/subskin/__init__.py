"""Solid mechanics for touch: from a pressed skin to what its sensors read, and back."""

from . import design
from .array import SensorArray
from .contact import (
    Contact,
    ContactSum,
    FlatPunch,
    Hertz,
    LineLoad,
    PartialSlip,
    PressureProfile,
    Strip,
    Wedge,
)
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
from .estimate import (
    Calibration,
    Estimate,
    Health,
    Locator,
    Rival,
    Status,
    ThreeSensorSolution,
    Verdict,
    calibrate,
    three_sensor,
)
from .field import State, Strain, Stress
from .finger import Finger
from .material import Material
from .receptive_field import ReceptiveField
from .skin import HalfPlane, Layer, Layered, Round, Skin
from .transducer import (
    EnergyDensity,
    LateralStrain,
    MaxCompressiveStrain,
    MeanPressure,
    NormalStrain,
    NormalStress,
    ShearStrain,
    Transducer,
    VolumeResistance,
)

__version__ = "0.1.0"

__all__ = [
    "Calibration",
    "Contact",
    "ContactSum",
    "ConvergenceError",
    "EnergyDensity",
    "Estimate",
    "FileError",
    "Finger",
    "FlatPunch",
    "GeometryError",
    "HalfPlane",
    "Health",
    "Hertz",
    "InvalidValueError",
    "LateralStrain",
    "Layer",
    "Layered",
    "LineLoad",
    "Locator",
    "Material",
    "MaxCompressiveStrain",
    "MeanPressure",
    "NormalStrain",
    "NormalStress",
    "NotLinearError",
    "PartialSlip",
    "PressureProfile",
    "ReceptiveField",
    "Rival",
    "Round",
    "SensorArray",
    "ShearStrain",
    "SingularPointWarning",
    "Skin",
    "State",
    "Status",
    "Strain",
    "Stress",
    "Strip",
    "SubskinError",
    "ThreeSensorSolution",
    "Transducer",
    "ValidityWarning",
    "Verdict",
    "VolumeResistance",
    "Wedge",
    "calibrate",
    "design",
    "three_sensor",
]
