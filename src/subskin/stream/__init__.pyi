from .presses import Column, Presses, RecordingFormat, segment
from .relaxation import Relaxation, RelaxationState, Relaxing, Undone
from .relaxation_fit import RelaxationFit, fit_relaxation
from .stage import Pipeline, Stage
from .tare import Tare, Tared, TareState

__all__ = [
    "Column",
    "Pipeline",
    "Presses",
    "RecordingFormat",
    "Relaxation",
    "RelaxationFit",
    "RelaxationState",
    "Relaxing",
    "Stage",
    "Tare",
    "TareState",
    "Tared",
    "Undone",
    "fit_relaxation",
    "segment",
]
