"""The package of MuJoCo, where it is installed."""

from __future__ import annotations

from importlib import import_module
from typing import Any

__all__ = ["engine"]


def engine() -> Any:
    """The module `mujoco`."""
    try:
        return import_module("mujoco")
    except ModuleNotFoundError:
        said = 'skins in a simulation need mujoco. Fix: pip install "subskin[mujoco]"'
        raise ModuleNotFoundError(said, name="mujoco") from None
