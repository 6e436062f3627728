"""Solid mechanics for touch: from a pressed skin to what its sensors read, and back.

What is public stands in `__init__.pyi`, and loads when it is first used.
"""

from . import _lazy

__version__ = "0.2.0"

__getattr__, __dir__, __all__ = _lazy.attach(__name__, __file__)
