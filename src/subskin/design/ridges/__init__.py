"""Ridges on the skin or on what touches it (memo section 6.1)."""

from .gain import Gains, RidgeGain, RidgePitch, best_ridge_pitch, read_ridged, ridge_gain
from .pressed import PressedRidges, closing_pressure, press_ridges
from .shape import Ridges

__all__ = [
    "Gains", "PressedRidges", "RidgeGain", "RidgePitch", "Ridges", "best_ridge_pitch", "closing_pressure",
    "press_ridges", "read_ridged", "ridge_gain",
]  # fmt: skip
