"""From readings to the load that made them, with its uncertainty."""

from .calibrate import Calibration, Health, Parameter, Score, calibrate
from .estimate import Estimate, Rival, Status
from .locate import Locator
from .three_sensor import Degeneracy, ThreeSensorSolution, Verdict, three_sensor

__all__ = [
    "Calibration",
    "Degeneracy",
    "Estimate",
    "Health",
    "Locator",
    "Parameter",
    "Rival",
    "Score",
    "Status",
    "ThreeSensorSolution",
    "Verdict",
    "calibrate",
    "three_sensor",
]
