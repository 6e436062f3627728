"""Live streams: devices, clocks, the chain from bytes to what touched, events, recordings.

The room can be called: `subskin.live(finger_file, port="demo")` is `subskin.live.run.live`.
"""

import sys
from types import ModuleType
from typing import Any

from .. import _lazy

__getattr__, __dir__, __all__ = _lazy.attach(__name__, __file__)


class _Room(ModuleType):
    """A module that is called as its function of the same name."""

    def __call__(self, *given: Any, **named: Any) -> Any:
        from .run import live

        return live(*given, **named)


sys.modules[__name__].__class__ = _Room
