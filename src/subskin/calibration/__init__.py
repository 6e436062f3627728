"""Touches -> the finger's own numbers: from known positions, from touches of which nothing is known, from daily use."""

from .blind import BlindCalibration, BlindParameter, ErrorRatio, Known, calibrate_blind
from .calibration import Calibration, Health, Parameter, Score
from .choice import Choice, Trial, choose
from .health import SensorHealth, sensor_health
from .known import calibrate
from .orient import Orientation, orient, telling
from .planning import NextTouch, next_touch
from .uncertainty import Misfit

__all__ = [
    "BlindCalibration", "BlindParameter", "Calibration", "Choice", "ErrorRatio", "Health", "Known", "Misfit",
    "NextTouch", "Orientation", "Parameter", "Score", "SensorHealth", "Trial", "calibrate", "calibrate_blind", "choose",
    "next_touch", "orient", "sensor_health", "telling",
]  # fmt: skip
