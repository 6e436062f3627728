"""Touches -> the finger's own numbers: from known positions, from touches of which nothing is known, from daily use."""

from .blind import calibrate_blind
from .blind_calibration import BlindCalibration, BlindParameter, ErrorRatio, Known
from .calibration import Calibration, Health, Parameter, Score
from .choice import Choice, Trial, choose
from .health import SensorHealth, sensor_health
from .known import calibrate
from .misfit import Misfit
from .planning import NextTouch, next_touch

__all__ = [
    "BlindCalibration",
    "BlindParameter",
    "Calibration",
    "Choice",
    "ErrorRatio",
    "Health",
    "Known",
    "Misfit",
    "NextTouch",
    "Parameter",
    "Score",
    "SensorHealth",
    "Trial",
    "calibrate",
    "calibrate_blind",
    "choose",
    "next_touch",
    "sensor_health",
]
