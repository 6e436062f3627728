"""Readings -> the resultant of whatever presses, without its shape."""

from .resultant import Resultant, ResultantReader, resultant

__all__ = ["Resultant", "ResultantReader", "resultant"]
