"""Which column of a table of results holds what: named once, for the compiled loops and for those who read them."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
import numpy.typing as npt

from .._check import FloatArray
from .._frozen import Frozen

__all__ = [
    "AREA",
    "BESIDE",
    "HOLLOW",
    "LEANING",
    "LINE",
    "ON_ROW",
    "PATCH",
    "ROUND",
    "SIZED",
    "SIZED_BESIDE",
    "SIZED_LINE",
    "SIZED_ON_ROW",
    "TWIST",
    "WIDE",
    "Layout",
]


@dataclass(frozen=True)
class Layout(Frozen):
    """Columns of a row that an estimator fills for one frame.

    In this order: position (y, or y and z), components of the force (n and t, or n, ty and tz), half width, moment,
    of a rectangle half sides, turn and what its pressure has of its own; their covariance (upper triangle, by rows),
    95 % interval of the half width (low, high), chi-square (residual), the same of the rival (rival_y and so on), how
    much larger its chi-square is, status. What a contact has not has no columns.

    Parameters
    ----------
    dim : int
        Coordinates of a position, d: 1 of long contacts, 2 of local ones.
    wide : bool
        Whether the contact has a half width.
    aside : bool
        Whether it is a point load, and what stands there is instead how far beside the row it presses [m].
    twist : bool
        Whether a moment about the normal [N m] is among the unknowns.
    sized : bool
        Whether the last column is the half width [m] of the touch that was taken, 0 of a point.
    sides : bool
        Whether it is a rectangle: with half its sides, nearest y and nearest z, and its turn.
    leaning : bool
        Whether its slopes along these are among the unknowns.
    hollow : bool
        Whether by how much less it presses in the middle is among them.

    Examples
    --------
    >>> LINE.columns, WIDE.columns, LINE.status
    (15, 23, 14)
    """

    dim: int = 1
    wide: bool = False
    aside: bool = False
    twist: bool = False
    sized: bool = False
    sides: bool = False
    leaning: bool = False
    hollow: bool = False
    record: np.dtype[np.void] = field(init=False)
    """The same columns as fields, which compiled loops fill by name: `layout.named(table)`."""
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
        contact = ["y", "n", "t"] if self.dim == 1 else ["y", "z", "n", "ty", "tz"]
        contact += ["half_width"] * self.wide + ["moment"] * self.twist
        contact += ["half_y", "half_z", "turn"] * self.sides + ["slope_y", "slope_z"] * self.leaning
        contact += ["hollow"] * self.hollow
        k = len(contact)
        fields = [*contact, "covariance", *["low", "high"] * self.wide, "residual"]
        fields += [*(f"rival_{name}" for name in contact), "rival_chi2", "status", *["size"] * self.sized]
        parts = [(name, float, (k * (k + 1) // 2,) if name == "covariance" else ()) for name in fields]
        record = np.dtype((np.record, parts))  # whose parts plain Python reads by name too
        at = {name: record.fields[name][1] // 8 for name in fields}  # type: ignore[index]
        columns = {
            "components": at["n"], "unknowns": k, "covariance": k, "interval": at.get("low", at["residual"]),
            "residual": at["residual"], "rival": at["rival_y"], "rival_chi2": at["rival_chi2"], "status": at["status"],
            "columns": record.itemsize // 8, "record": record,
        }  # fmt: skip
        for name, value in columns.items():
            object.__setattr__(self, name, value)

    def named(self, table: FloatArray) -> npt.NDArray[np.void]:
        """The rows of a table as records: a view, in which the columns have names.

        Parameters
        ----------
        table : ndarray, shape (f, columns)
            What a loop fills.

        Examples
        --------
        >>> rows = LINE.named(np.zeros((2, LINE.columns)))
        >>> rows.shape, rows.dtype.names[:5], rows["covariance"].shape
        ((2,), ('y', 'n', 't', 'covariance', 'residual'), (2, 6))
        """
        return np.ndarray(len(table), self.record, table, 0, table.strides[:1])  # `view` takes twice as long

    @property
    def size(self) -> int:
        """Column of the half width that was taken, where there is one."""
        return self.columns - 1

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
SIZED, SIZED_LINE = Layout(dim=2, sized=True), Layout(sized=True)
ON_ROW, SIZED_ON_ROW = Layout(aside=True), Layout(aside=True, sized=True)
SIZED_BESIDE = Layout(wide=True, aside=True, sized=True)
PATCH, LEANING = Layout(dim=2, sides=True), Layout(dim=2, sides=True, leaning=True)
HOLLOW = Layout(dim=2, sides=True, hollow=True)
"""Of a line load, of a long contact of some width, of a point load, of one beside a row, of a round contact, of one
that twists as well; of a point load or a round touch where a point does not explain the readings, and of a line load or
a roller's contact likewise; of a point load on a row, and of a ball's contact there, or beside it,
likewise; of a patch, of one whose pressure is linear, and of one that may be hollow."""
