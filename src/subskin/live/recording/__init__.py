"""Recordings of live streams: how they are laid out, written, read again, saved from a crash, and converted."""

from ... import _lazy

__getattr__, __dir__, __all__ = _lazy.attach(__name__, __file__)
