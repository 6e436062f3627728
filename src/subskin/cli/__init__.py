"""The command line, `subskin`: files in, files out. No physics in here."""

from .main import main

__all__ = ["main"]
