"""Tools for who designs a finger: everything here rides on `Finger` alone.

What is public stands in `__init__.pyi`, and loads when it is first used; what the tools take and return is in
their rooms: `design.search`, `design.placement`, `design.tolerance` and so on.
"""

from .. import _lazy

__getattr__, __dir__, __all__ = _lazy.attach(__name__, __file__)
