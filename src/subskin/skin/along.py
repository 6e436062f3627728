"""What sensors along the depth of a half space read, from a contact's real functions (docs/local_contacts.md).

Of arrays of any namespace: W_0 of the pressure and its derivative, and h = Re W_1 of the drag.
"""

from __future__ import annotations

from typing import Any

__all__ = ["strain_along", "stress_along", "trace_of"]


def stress_along(w: Any, xw: Any, xh: Any) -> Any:
    """s_xx [Pa] from W_0, x W_0' of the pressure and x h' of the drag."""
    return xw - w - xh


def strain_along(w: Any, xw: Any, h: Any, xh: Any, nu: float) -> Any:
    """2 G eps_xx [Pa], h = Re W_1 of the drag."""
    return xw - (1 - 2 * nu) * w - 2 * nu * h - xh


def trace_of(w: Any, h: Any, nu: float) -> Any:
    """The sum of the normal stresses [Pa]."""
    return 2 * (1 + nu) * (h - w)
