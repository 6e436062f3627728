"""Recordings simulated with their faults: noise, drift, relaxation, dead sensors."""

from .recording import Recording, simulate_recording

__all__ = ["Recording", "simulate_recording"]
