"""From readings to the load that made them, with its uncertainty."""

from .estimate import Estimate, Rival, Status
from .locate import Locator

__all__ = ["Estimate", "Locator", "Rival", "Status"]
