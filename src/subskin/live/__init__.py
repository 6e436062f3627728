"""Live streams: devices, clocks, the chain from bytes to what touched, events, recordings."""

from .. import _lazy

__getattr__, __dir__, __all__ = _lazy.attach(__name__, __file__)
