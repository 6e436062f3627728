"""From readings to the load that made them, with its uncertainty."""

from .calibration import (
    BlindCalibration,
    BlindParameter,
    Calibration,
    ErrorRatio,
    Health,
    Known,
    Parameter,
    Score,
    SensorHealth,
    calibrate,
    calibrate_blind,
    sensor_health,
)
from .estimate import Estimate, Rival, Status
from .locate import Locator
from .pressure import PressureMap, PressureMapper, pressure_map
from .shape import Fitter, ShapeEstimate, ShapeField, ShapeRival
from .side import SideAngle, blind_depth, side_angle, side_angle_from_gradients, side_angle_from_slope
from .three_sensor import Degeneracy, ThreeSensorSolution, Verdict, three_sensor

__all__ = [
    "BlindCalibration",
    "BlindParameter",
    "Calibration",
    "Degeneracy",
    "ErrorRatio",
    "Estimate",
    "Fitter",
    "Health",
    "Known",
    "Locator",
    "Parameter",
    "PressureMap",
    "PressureMapper",
    "Rival",
    "Score",
    "SensorHealth",
    "ShapeEstimate",
    "ShapeField",
    "ShapeRival",
    "SideAngle",
    "Status",
    "ThreeSensorSolution",
    "Verdict",
    "blind_depth",
    "calibrate",
    "calibrate_blind",
    "pressure_map",
    "sensor_health",
    "side_angle",
    "side_angle_from_gradients",
    "side_angle_from_slope",
    "three_sensor",
]
