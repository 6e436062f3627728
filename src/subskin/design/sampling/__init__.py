"""How densely sensors have to lie: the pitch that a spectrum asks for, the error made, what sliding adds."""

from .aliasing import AliasingError, aliasing_error
from .density import SensorDensity, sensor_density
from .lattice import LatticeError
from .sliding import SlidingSamples, sliding_samples

__all__ = [
    "AliasingError",
    "LatticeError",
    "SensorDensity",
    "SlidingSamples",
    "aliasing_error",
    "sensor_density",
    "sliding_samples",
]
