"""Frames in the order of time: what drifts is followed, what relaxes is undone."""

from .. import _lazy

__getattr__, __dir__, __all__ = _lazy.attach(__name__, __file__)
