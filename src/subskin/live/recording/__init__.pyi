from .about import About
from .recovery import Recovered, recover
from .source import OpenRecording, Step, opened

__all__ = ["About", "OpenRecording", "Recovered", "Step", "opened", "recover"]
