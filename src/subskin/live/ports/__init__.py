"""Where the bytes of a device come from: serial ports, networks, files, pipes, simulations."""

from .base import Port, PortEnded, PortLost
from .demo import Demo, Robot
from .files import FilePort, Log, StandardInput
from .network import LslPort, TcpPort, UdpPort, WebSocketPort
from .opening import opened, schemes
from .serial_port import PluggedIn, SerialPort, listed
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
