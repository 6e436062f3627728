from . import drivers as drivers
from . import ports as ports
from .batch import Batch
from .chain import Chain, ChainState
from .clock import ClockMap, ClockState
from .events import Event
from .frames import DeviceFrames
from .record import Recorder
from .replay import Replay
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
    "Recorder",
    "Replay",
    "RingBuffer",
    "live",
]
