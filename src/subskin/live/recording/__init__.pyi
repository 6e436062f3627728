from .layout import About
from .source import OpenRecording, Recovered, Step, opened, recover

__all__ = ["About", "OpenRecording", "Recovered", "Step", "opened", "recover"]
