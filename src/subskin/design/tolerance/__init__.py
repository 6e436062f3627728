"""What the tolerances of a finger cost in locating, how tight they have to be, what self-calibration wins back."""

from .budget import ToleranceBudget, tolerance_budget
from .cost import Cost, Needed, Recovery
from .outcome import ErrorsKept, Outcome, tolerance_outcome
from .sources import SOURCES, Source, usual_tolerances

__all__ = [
    "SOURCES",
    "Cost",
    "ErrorsKept",
    "Needed",
    "Outcome",
    "Recovery",
    "Source",
    "ToleranceBudget",
    "tolerance_budget",
    "tolerance_outcome",
    "usual_tolerances",
]
