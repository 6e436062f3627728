from .frames import DeviceFrames

__all__ = ["DeviceFrames"]
