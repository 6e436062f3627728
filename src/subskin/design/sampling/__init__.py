"""How densely sensors have to lie: the pitch that a spectrum asks for, the error made, what sliding adds."""

from .aliasing import AliasingError, LatticeError, aliasing_error
from .density import SensorDensity, SlidingSamples, sensor_density, sliding_samples

__all__ = [
    "AliasingError", "LatticeError", "SensorDensity", "SlidingSamples", "aliasing_error", "sensor_density",
    "sliding_samples",
]  # fmt: skip
