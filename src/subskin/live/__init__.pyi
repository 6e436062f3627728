from . import drivers as drivers
from . import ports as ports
from . import record as record
from . import replay as replay
from .batch import Batch, RingBuffer
from .bench import Bench
from .chain import Chain, ChainState
from .events import Event
from .frames import ClockMap, ClockState, DeviceFrames
from .record import Recorder
from .replay import Replay
from .run import Live, live
from .session import BenchState, Said

__all__ = [
    "Batch",
    "Bench",
    "BenchState",
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
    "Said",
    "live",
]
