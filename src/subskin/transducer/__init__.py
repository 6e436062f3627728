"""What a sensor reports of stress, strain and displacement at its position: one class a quantity, found by its name."""

from .base import Transducer, class_of, kind_of, kinds, transducer_of
from .components import EnergyDensity, MaxCompressiveStrain, MeanPressure, NormalStrain, NormalStress, VolumeResistance
from .directed import Displacement, LateralStrain, ShearStrain, rosette
from .magnet import MagnetDisplacement

__all__ = [
    "Displacement",
    "EnergyDensity",
    "LateralStrain",
    "MagnetDisplacement",
    "MaxCompressiveStrain",
    "MeanPressure",
    "NormalStrain",
    "NormalStress",
    "ShearStrain",
    "Transducer",
    "VolumeResistance",
    "class_of",
    "kind_of",
    "kinds",
    "rosette",
    "transducer_of",
]
