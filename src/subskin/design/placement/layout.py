"""What sensors there are and how they stand, but for the pitch: in a row, on a grid, in rows that make hexagons."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Annotated, Literal, NamedTuple, TypeAlias

import numpy as np
import numpy.typing as npt

from ... import _check
from ..._check import FloatArray
from ..._declared import Fix, Length, Noun, Positive, Whole, checked
from ...errors import GeometryError, InvalidValueError
from ...lattice import even_grid
from ...transducer import Transducer

__all__ = ["PATTERNS", "Arrangement", "Channel", "channels_of", "layouts"]

Pattern = Literal["row", "grid", "hexagonal", "free"]
PATTERNS: tuple[Pattern, ...] = ("row", "grid", "hexagonal")
"""Those that a pitch makes positions of."""
_Names: TypeAlias = Annotated[Iterable[str], Fix('patterns=("grid",)')]
_MOST_POSITIONS = 1000
_SLENDER = 2.0
"""A layout's sides may be so much more, or less, slender than those of the area it is for."""


class Channel(NamedTuple):
    """What one channel of an array measures.

    Parameters
    ----------
    transducer : Transducer
        One with a linear part.
    noise : float
        Standard deviation of a reading [unit of the transducer], > 0.
    width : float, optional
        Width along y over which it averages [m].
    """

    transducer: Transducer
    noise: float
    width: float = 0.0


@dataclass(frozen=True)
class Arrangement(Noun):
    """Positions of sensors in units of their pitch, about their middle.

    Parameters
    ----------
    pattern : {"row", "grid", "hexagonal", "free"}
        How they are set out. Hexagonal rows lie sqrt(3)/2 pitches apart, each sensor half a pitch beside its
        neighbours in the next row.
    rows : tuple of int
        Sensors in each row along y; of a grid how many there are along y, and along z, as of `SensorArray.grid`.
    at : tuple of (float, float), optional
        The positions (y, z) themselves, where they are free [pitches].

    Raises
    ------
    InvalidValueError, GeometryError
        Hexagonal rows whose counts do not differ by one; free positions that are not there.

    Examples
    --------
    >>> Arrangement("hexagonal", (2, 3, 2)), Arrangement("hexagonal", (1, 2)).points(1.0).round(3).tolist()
    (2+3+2 hexagonal, [[0.0, -0.433], [-0.5, 0.433], [0.5, 0.433]])
    """

    pattern: Pattern
    rows: Annotated[tuple[Annotated[int, Whole(0, 10**9)], ...], Fix("rows=(4, 4, 4)")]
    at: tuple[tuple[float, float], ...] = ()

    def __post_init__(self) -> None:
        super().__post_init__()
        if not self.rows:
            raise InvalidValueError("rows = ()", "a whole number of sensors in each row is needed", "rows=(4, 4, 4)")
        steps = set(np.abs(np.diff(self.rows)).tolist())
        if self.pattern == "hexagonal" and steps - {1}:
            rule = "each row has one sensor more, or one less, than the next"
            raise InvalidValueError(f"hexagonal rows of {self.rows}", rule, "(2, 3, 2)")
        if self.pattern == "grid" and len(self.rows) != 2:
            rule = "a grid has so many sensors along y and so many along z"
            raise InvalidValueError(f"a grid of {self.rows}", rule, f"({self.rows[0]}, {len(self.rows)})")
        if (self.pattern == "free") != bool(self.at) or (self.at and len(self.at) != sum(self.rows)):
            rule = "free positions are listed, others follow from their rows"
            seen = f"{self.pattern} with {len(self.at)} positions"
            raise InvalidValueError(seen, rule, 'Arrangement("grid", (3, 3))')

    def __repr__(self) -> str:
        return self.text

    @property
    def count(self) -> int:
        """Number of positions."""
        return math.prod(self.rows) if self.pattern == "grid" else sum(self.rows)

    @property
    def text(self) -> str:
        """What a person calls it: "4 x 3 grid" is four along y, three along z."""
        if self.pattern == "grid":
            return f"{self.rows[0]} x {self.rows[1]} grid"
        if self.pattern == "hexagonal":
            return f"{'+'.join(map(str, self.rows))} hexagonal"
        return f"row of {self.count}" if self.pattern == "row" else f"{self.count} free"

    @property
    def unit(self) -> FloatArray:
        """Positions (y, z) in pitches about the middle, shape (count, 2); of a grid in the order of `even_grid`."""
        if self.at:
            return np.array(self.at)
        if self.pattern == "grid":
            return even_grid((self.rows[0], self.rows[1]), 1.0)
        apart = np.sqrt(0.75) if self.pattern == "hexagonal" else 1.0
        out = [
            np.stack([np.arange(n) - (n - 1) / 2, np.full(n, apart * (j - (len(self.rows) - 1) / 2))], axis=-1)
            for j, n in enumerate(self.rows)
        ]
        return np.concatenate(out)

    @property
    def size(self) -> FloatArray:
        """Sides along y and z of what holds them, in pitches, shape (2,)."""
        return np.asarray(np.ptp(self.unit, axis=0))

    @checked
    def points(self, pitch: Length, centre: tuple[float, float] = (0.0, 0.0)) -> FloatArray:
        """Positions (y, z) [m], shape (count, 2).

        Parameters
        ----------
        pitch : float
            Distance of neighbours [m].
        centre : (float, float), optional
            Where the middle is (y, z) [m].

        Raises
        ------
        InvalidValueError, GeometryError
            A pitch that is not > 0; a middle that is no position.
        """
        middle = _check.real("centre", centre, unit="m")
        if middle.shape != (2,):
            raise GeometryError(f"centre of shape {middle.shape}", "y and z are needed", "centre=(0.0, 0.0)")
        return np.asarray(middle + pitch * self.unit)

    def colours(self, kinds: int) -> npt.NDArray[np.intp]:
        """Which of so many kinds stands at each position where they take turns, shape (count,).

        Along a row one after the other; each row begins one further, so that kinds are mixed along both sides.

        Parameters
        ----------
        kinds : int
            How many there are.
        """
        if self.pattern == "grid":
            return np.add.outer(*map(np.arange, self.rows)).reshape(-1) % kinds
        return np.concatenate([(np.arange(n) + j) % kinds for j, n in enumerate(self.rows)])


def channels_of(layout: Arrangement, kinds: int, together: bool) -> tuple[npt.NDArray[np.intp], npt.NDArray[np.intp]]:
    """Position and kind of each channel of a layout, (n,) both.

    Parameters
    ----------
    layout : Arrangement
        How the positions are set out.
    kinds : int
        How many kinds of channel there are.
    together : bool
        Whether all are at each position; else they take turns.

    Examples
    --------
    >>> [v.tolist() for v in channels_of(Arrangement("row", (2,)), 2, True)]
    [[0, 0, 1, 1], [0, 1, 0, 1]]
    """
    if together:
        return np.repeat(np.arange(layout.count), kinds), np.tile(np.arange(kinds), layout.count)
    return np.arange(layout.count), layout.colours(kinds)


@checked
def layouts(patterns: _Names, counts: tuple[int, int], slender: Positive = 1.0) -> tuple[Arrangement, ...]:
    """Arrangements with so many positions: of each pattern and count that whose sides are nearest to the area's.

    Parameters
    ----------
    patterns : iterable of str
        Names from `PATTERNS`.
    counts : (int, int)
        Fewest and most positions.
    slender : float, optional
        Side of the area along y over that along z. Grids and hexagonal rows more than twice as slender, or half as
        slender, are left out.

    Raises
    ------
    InvalidValueError
        A pattern of another name; counts that are not whole, or too large.

    Examples
    --------
    >>> layouts(("grid", "hexagonal"), (6, 7))
    (3 x 2 grid, 2+3+2 hexagonal)
    """
    ends = _check.pair("counts", counts, "counts=(4, 16)")
    low, high = (_check.whole("counts", n, at_least=1, at_most=_MOST_POSITIONS, fix="counts=(4, 16)") for n in ends)
    every = []
    for pattern in patterns:
        if pattern == "row":
            every += [Arrangement("row", (n,)) for n in range(low, high + 1)]
        elif pattern == "grid":
            every += [Arrangement("grid", (m, n)) for n in range(2, high // 2 + 1) for m in range(2, high // n + 1)]
        elif pattern == "hexagonal":
            for n in range(2, high + 1):
                for m in range(1, high // n + 2):  # of longer rows there would be too many positions
                    for other in (m - 1, m + 1):
                        every.append(Arrangement("hexagonal", tuple(m if j % 2 == 0 else other for j in range(n))))
        else:
            _check.choice("layout", pattern, PATTERNS)

    def off(layout: Arrangement) -> float:
        along, across = layout.size
        return abs(float(np.log(along / across / slender))) if layout.pattern != "row" else 0.0

    best: dict[tuple[str, int], Arrangement] = {}
    for layout in every:
        if low <= layout.count <= high and min(layout.rows) > 0 and off(layout) <= np.log(_SLENDER) + 1e-9:
            key = layout.pattern, layout.count
            if key not in best or off(layout) < off(best[key]) - 1e-9:
                best[key] = layout
    return tuple(sorted(best.values(), key=lambda layout: (layout.count, PATTERNS.index(layout.pattern))))
