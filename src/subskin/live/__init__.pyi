from . import drivers as drivers
from . import ports as ports
from . import record as record
from . import replay as replay
from .batch import Batch
from .chain import Chain, ChainState
from .clock import ClockMap, ClockState
from .events import Event
from .frames import DeviceFrames
from .ring import RingBuffer
from .run import Live, live

__all__ = [
    "Batch",
    "Chain",
    "ChainState",
    "ClockMap",
    "ClockState",
    "DeviceFrames",
    "Event",
    "Live",
    "RingBuffer",
    "live",
]
