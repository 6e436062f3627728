"""Readings -> the rectangle that presses: its sides, its turn, how its pressure leans."""

from .locator import PatchLocator

__all__ = ["PatchLocator"]
