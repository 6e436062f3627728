"""What presses on a skin: one small module a contact, each two formulas long."""

from .base import Contact, ContactSum, ProportionalContact, Transforms
from .line import LineLoad

__all__ = ["Contact", "ContactSum", "LineLoad", "ProportionalContact", "Transforms"]
