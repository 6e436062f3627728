"""Recordings simulated with their faults: noise, drift, relaxation, dead sensors."""

from .recording import Recording, contact_of, simulate_recording

__all__ = ["Recording", "contact_of", "simulate_recording"]
