"""Packages that only some ports need."""

from __future__ import annotations

from importlib import import_module
from typing import Any

from ...errors import SubskinError

__all__ = ["needed"]

_PACKAGES = {"serial": "pyserial"}


def needed(module: str, extra: str) -> Any:
    """The module, or an error that says how to install it.

    Raises
    ------
    SubskinError
        It is not installed.
    """
    try:
        return import_module(module)
    except (ImportError, RuntimeError):  # RuntimeError: of pylsl, without the library beneath it
        package = _PACKAGES.get(module.split(".")[0], module.split(".")[0])
        raise SubskinError(
            f"{package} is not installed", "this port needs it", f'pip install "subskin[{extra}]"'
        ) from None
