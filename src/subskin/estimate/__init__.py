"""From readings to the load that made them, with its uncertainty."""

from .calibrate import calibrate
from .calibration import Calibration, Health, Parameter, Score
from .estimate import Estimate, Rival, Status
from .fit import Fitter
from .locate import Locator
from .shape import ShapeEstimate, ShapeRival
from .shape_field import ShapeField
from .three_sensor import Degeneracy, ThreeSensorSolution, Verdict, three_sensor

__all__ = [
    "Calibration",
    "Degeneracy",
    "Estimate",
    "Fitter",
    "Health",
    "Locator",
    "Parameter",
    "Rival",
    "Score",
    "ShapeEstimate",
    "ShapeField",
    "ShapeRival",
    "Status",
    "ThreeSensorSolution",
    "Verdict",
    "calibrate",
    "three_sensor",
]
