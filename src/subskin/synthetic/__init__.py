"""Simulated: readings, recordings with their faults (noise, drift, relaxation, dead sensors), touches to learn from."""

from .recording import Recording, simulate_readings, simulate_recording
from .touches import FAULTS, ContactShare, RandomTouches, TouchShard

__all__ = [
    "FAULTS", "ContactShare", "RandomTouches", "Recording", "TouchShard", "simulate_readings", "simulate_recording",
]  # fmt: skip
