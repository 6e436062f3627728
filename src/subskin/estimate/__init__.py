"""From readings to the load that made them, with its uncertainty."""

from .calibrate import calibrate
from .calibration import Calibration, Health, Parameter, Score
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
