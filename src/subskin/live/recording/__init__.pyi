from .files import Recovered, recover
from .layout import About
from .source import OpenRecording, Step, opened

__all__ = ["About", "OpenRecording", "Recovered", "Step", "opened", "recover"]
