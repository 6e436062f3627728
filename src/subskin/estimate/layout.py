"""Which column of a table of results holds what: named once, for the compiled loops and for those who read them."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
import numpy.typing as npt

from .._frozen import Frozen

__all__ = ["AREA", "BESIDE", "LINE", "ROUND", "TWIST", "WIDE", "Layout"]


@dataclass(frozen=True)
class Layout(Frozen):
    """Columns of a row that an estimator fills for one frame.

    In this order: position, components of the force, half width, moment, their covariance (upper triangle, by rows),
    95 % interval of the half width, chi-square, the rival's position, components, half width and moment, how much
    larger its chi-square is, status. Without a width, or a moment, its columns are not there.

    Parameters
    ----------
    dim : int
        Coordinates of a position, d: 1 of long contacts, 2 of local ones.
    wide : bool
        Whether the contact has a half width.
    aside : bool
        Whether what stands there is instead how far a point load presses beside the row [m].
    twist : bool
        Whether a moment about the normal [N m] is among the unknowns.

    Examples
    --------
    >>> LINE.columns, WIDE.columns, LINE.status
    (15, 23, 14)
    """

    dim: int = 1
    wide: bool = False
    aside: bool = False
    twist: bool = False
    components: int = field(init=False)
    unknowns: int = field(init=False)
    """Columns of the contact itself, from 0: position, components, half width, moment."""
    covariance: int = field(init=False)
    interval: int = field(init=False)
    residual: int = field(init=False)
    rival: int = field(init=False)
    rival_chi2: int = field(init=False)
    status: int = field(init=False)
    columns: int = field(init=False)

    def __post_init__(self) -> None:
        k = 2 * self.dim + 1 + self.wide + self.twist
        sizes = {
            "components": self.dim, "unknowns": k - self.dim, "covariance": 0, "interval": k * (k + 1) // 2,
            "residual": 2 * self.wide, "rival": 1, "rival_chi2": k, "status": 1, "columns": 1,
        }  # fmt: skip
        at = 0
        for name, size in sizes.items():  # of what stands before
            at += size
            object.__setattr__(self, name, at)

    @property
    def half_width(self) -> int:
        """Column of the half width, where there is one."""
        return self.unknowns - 1 - self.twist

    @cached_property
    def square(self) -> npt.NDArray[np.intp]:
        """Columns of the covariance, as the square that they make."""
        k = self.unknowns
        out = np.zeros((k, k), dtype=np.intp)
        out[np.triu_indices(k)] = self.covariance + np.arange(k * (k + 1) // 2)
        square = np.maximum(out, out.T)
        square.flags.writeable = False
        return square


LINE, WIDE, AREA, BESIDE = Layout(), Layout(wide=True), Layout(dim=2), Layout(wide=True, aside=True)
ROUND, TWIST = Layout(dim=2, wide=True), Layout(dim=2, wide=True, twist=True)
"""Of a line load, of a long contact of some width, of a point load, of one beside a row, of a round contact, and of one
that twists as well."""
