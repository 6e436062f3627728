"""Where the bytes of a device come from: serial ports, networks, files, pipes, simulations."""

from .base import Port, PortEnded, PortLost
from .demo import Demo
from .descriptors import FilePort, StandardInput
from .listing import PluggedIn, listed
from .log import Log
from .lsl import LslPort
from .network import TcpPort, UdpPort
from .opening import opened, schemes
from .robot import Robot
from .serial_port import SerialPort
from .simulated import Faults, Simulated
from .websocket import WebSocketPort

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
