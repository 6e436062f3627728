"""What the tolerances of a finger cost in locating, how tight they have to be, what self-calibration wins back."""

from .budget import ToleranceBudget, tolerance_budget
from .outcome import ErrorsKept, Outcome, tolerance_outcome
from .sources import SOURCES, Cost, Needed, Recovery, Source, usual_tolerances

__all__ = [
    "SOURCES", "Cost", "ErrorsKept", "Needed", "Outcome", "Recovery", "Source", "ToleranceBudget",
    "tolerance_budget", "tolerance_outcome", "usual_tolerances",
]  # fmt: skip
