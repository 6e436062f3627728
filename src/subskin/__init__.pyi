from . import afferents as afferents
from . import array as array
from . import calibration as calibration
from . import contact as contact
from . import decide, design
from . import errors as errors
from . import estimate as estimate
from . import faults as faults
from . import finger as finger
from . import grasp as grasp
from . import io as io
from . import lattice as lattice
from . import live as live
from . import loads as loads
from . import material as material
from . import measured as measured
from . import memo as memo
from . import mujoco as mujoco
from . import plot as plot
from . import prepared as prepared
from . import pressing as pressing
from . import radial as radial
from . import radial_round as radial_round
from . import reader as reader
from . import report as report
from . import response as response
from . import skin as skin
from . import spread as spread
from . import stream as stream
from . import studio as studio
from . import synthetic as synthetic
from . import tensor as tensor
from . import tolerances as tolerances
from . import transducer as transducer
from .array import SensorArray
from .calibration import calibrate, calibrate_blind
from .contact import (
    Cone,
    Contact,
    EllipticHertz,
    FlatPunch,
    FromProjections,
    Hertz,
    LineLoad,
    LocalContact,
    PartialSlip,
    Patch,
    PointLoad,
    PressureGrid,
    PressureProfile,
    RoundHertz,
    RoundPunch,
    Strip,
    Wedge,
)
from .design.blind_spots import blind_spots
from .errors import SubskinError
from .estimate import Estimate, Status, fit, locate, locator, pressure_map, side_angle
from .finger import Finger
from .io import load
from .loads import Load
from .material import Material
from .pressing import press
from .response import tabulate
from .skin import HalfPlane, HalfSpace, Layer, Layered, Round, Skin
from .stream import Pipeline, Relaxation, Tare
from .tolerances import Tolerances
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

__version__: str

__all__ = [
    "Cone",
    "Contact",
    "EllipticHertz",
    "EnergyDensity",
    "Estimate",
    "Finger",
    "FlatPunch",
    "FromProjections",
    "HalfPlane",
    "HalfSpace",
    "Hertz",
    "LateralStrain",
    "Layer",
    "Layered",
    "LineLoad",
    "Load",
    "LocalContact",
    "Material",
    "MaxCompressiveStrain",
    "MeanPressure",
    "NormalStrain",
    "NormalStress",
    "PartialSlip",
    "Patch",
    "Pipeline",
    "PointLoad",
    "PressureGrid",
    "PressureProfile",
    "Relaxation",
    "Round",
    "RoundHertz",
    "RoundPunch",
    "SensorArray",
    "ShearStrain",
    "Skin",
    "Status",
    "Strip",
    "SubskinError",
    "Tare",
    "Tolerances",
    "Transducer",
    "VolumeResistance",
    "Wedge",
    "blind_spots",
    "calibrate",
    "calibrate_blind",
    "decide",
    "design",
    "fit",
    "load",
    "locate",
    "locator",
    "press",
    "pressure_map",
    "side_angle",
    "tabulate",
]
