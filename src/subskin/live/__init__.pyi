from .batch import Batch
from .chain import Chain, ChainState
from .clock import Clock, ClockState
from .events import Event
from .frames import DeviceFrames
from .ring import RingBuffer

__all__ = ["Batch", "Chain", "ChainState", "Clock", "ClockState", "DeviceFrames", "Event", "RingBuffer"]
