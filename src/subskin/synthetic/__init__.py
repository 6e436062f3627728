"""Readings, and recordings with their faults, simulated: noise, drift, relaxation, dead sensors."""

from .readings import simulate_readings
from .recording import Recording, simulate_recording

__all__ = ["Recording", "simulate_readings", "simulate_recording"]
