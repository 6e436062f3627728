"""Where the bytes of a device come from: serial ports, networks, files, pipes, simulations."""

from .base import Port, PortEnded, PortLost, opened, schemes
from .demo import Demo, Robot
from .local import FilePort, Log, PluggedIn, SerialPort, StandardInput, listed
from .network import LslPort, TcpPort, UdpPort, WebSocketPort
from .simulated import Faults, Simulated

__all__ = [
    "Demo",
    "Faults",
    "FilePort",
    "Log",
    "LslPort",
    "PluggedIn",
    "Port",
    "PortEnded",
    "PortLost",
    "Robot",
    "SerialPort",
    "Simulated",
    "StandardInput",
    "TcpPort",
    "UdpPort",
    "WebSocketPort",
    "listed",
    "opened",
    "schemes",
]
