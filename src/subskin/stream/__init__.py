"""Frames in the order of time: what drifts is followed, what relaxes is undone."""

from .fit_relaxation import RelaxationFit, fit_relaxation
from .relaxation import Relaxation, RelaxationState, Relaxed
from .tare import Tare, Tared, TareState

__all__ = [
    "Relaxation",
    "RelaxationFit",
    "RelaxationState",
    "Relaxed",
    "Tare",
    "TareState",
    "Tared",
    "fit_relaxation",
]
