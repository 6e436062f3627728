"""What the tolerances of a finger cost in locating, how tight they have to be, what self-calibration wins back."""

from .budget import ToleranceBudget, tolerance_budget
from .cost import Cost, Needed, Recovery
from .sources import SOURCES, Source, usual_tolerances

__all__ = ["SOURCES", "Cost", "Needed", "Recovery", "Source", "ToleranceBudget", "tolerance_budget", "usual_tolerances"]
