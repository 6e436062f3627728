"""What there is to choose from: kinds of sensor, mixes, skins; where sensors can be put, how finely is searched."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, ClassVar

import numpy as np

from ... import _check
from ..._declared import Extent, Fix, Length, Noun, Positive, Real, Whole
from ...errors import GeometryError, InvalidValueError
from ...skin import Skin
from ...transducer import Transducer
from ..placement import PATTERNS

__all__ = ["Effort", "Mix", "Room", "SensorKind", "SkinChoice"]


@dataclass(frozen=True)
class SensorKind(Noun):
    """A kind of sensor that is at hand; `rank_fingers` has an example.

    Parameters
    ----------
    name : str
        What it is called in the report.
    transducer : Transducer
        What it measures.
    noise : float
        Standard deviation of a reading [unit of the transducer], > 0.
    width : float, optional
        Width over which it averages [m].
    largest : float, optional
        Largest magnitude that it can read [unit of the transducer].
    resolution : float, optional
        Step to which a reading is rounded [unit of the transducer]; its rounding error adds to the noise.
    """

    name: str
    transducer: Annotated[Transducer, Fix("transducer=MeanPressure()")]
    noise: Positive
    width: Extent = 0.0
    largest: Annotated[float, Real(above=0.0, finite=False, fix="leave out largest")] = np.inf
    resolution: Annotated[float, Real(at_least=0.0)] = 0.0

    def __post_init__(self) -> None:
        super().__post_init__()
        self.transducer.linearise(np.zeros(0))  # refuses what cannot be made linear

    @property
    def error(self) -> float:
        """Standard deviation of a reading, that of rounding included."""
        return float(np.hypot(self.noise, self.resolution / np.sqrt(12)))

    @property
    def kinds(self) -> tuple[SensorKind, ...]:
        """Itself: a `Mix` has several."""
        return (self,)

    @property
    def together(self) -> bool:
        """Whether all its kinds are at each position."""
        return True


@dataclass(frozen=True)
class Mix(Noun):
    """Several kinds of sensor in one array on an area, such as strain beside shear; docs/designing.md has an example.

    Parameters
    ----------
    name : str
        What it is called in the report.
    kinds : sequence of SensorKind
        Two or more.
    together : bool, optional
        Whether all of them are at each position, as channels; else they take turns from one position to the next.

    Raises
    ------
    InvalidValueError
        Fewer than two kinds.
    """

    name: str
    kinds: tuple[SensorKind, ...]
    together: bool = True

    def __post_init__(self) -> None:
        super().__post_init__()
        if len(self.kinds) < 2:
            rule = "two kinds of sensor or more are needed"
            raise InvalidValueError(f"{len(self.kinds)} kinds in a mix", rule, 'kinds = ["gauge", "shear"]')


@dataclass(frozen=True)
class SkinChoice(Noun):
    """A `skin` that could be moulded, and the `name` of it in the report; `rank_fingers` has an example."""

    name: str
    skin: Skin


_MOST = 10_000
"""Sensors, at most."""
_DEEPEST = 1000
"""Times the shallowest depth that a search goes to at most: it steps by shares of a depth."""


@dataclass(frozen=True)
class Room(Noun):
    """Where sensors can be put; `rank_fingers` has an example.

    Parameters
    ----------
    count : (int, int)
        Fewest and most sensors; at least 3.
    depth : (float, float)
        Shallowest and deepest [m].
    least_pitch : float
        Least distance between sensors, their wiring included [m].
    longest_row : float, optional
        Largest distance from the first sensor to the last [m].
    area : (float, float), optional
        Sides along y and z of where sensors may stand, for touches on an area [m]; half as large again as what is
        touched, or two depths beyond it, if left out.
    layouts : sequence of str, optional
        On an area: which of "row", "grid", "hexagonal" are tried. "free" moves the sensors of the best of them, and
        those of the best row where rows are searched.

    Raises
    ------
    InvalidValueError, GeometryError
        Counts or depths that do not ascend; a row too short for the fewest sensors; an unknown layout.
    """

    count: tuple[int, int]
    depth: Annotated[tuple[float, float], Real("m", fix="depth=(1e-3, 4e-3)")]
    least_pitch: Length
    longest_row: Annotated[float, Real("m", above=0.0, finite=False)] = np.inf
    area: Annotated[tuple[float, float] | None, Real("m", above=0.0, fix="area=(12e-3, 12e-3)")] = None
    layouts: Annotated[tuple[str, ...], Fix('layouts=["grid"]')] = ("grid", "hexagonal")

    EXAMPLE: ClassVar = "Room(count=(4, 8), depth=(1e-3, 4e-3), least_pitch=1e-3)"

    def __post_init__(self) -> None:
        low, high = _check.pair("count", self.count, "count=(3, 12)")
        if low % 1 or high % 1 or not 3 <= low <= high <= _MOST:
            rule = f"two whole numbers are needed, 3 <= fewest <= most <= {_MOST}"
            raise InvalidValueError(f"count = {list(self.count)!r}", rule, "3 and 12")
        object.__setattr__(self, "count", (int(low), int(high)))
        super().__post_init__()
        shallow, deep = self.depth
        if not 0 < shallow <= deep <= _DEEPEST * shallow:
            rule = f"0 < shallowest <= deepest <= {_DEEPEST} times the shallowest is needed"
            raise GeometryError(f"depth = {list(self.depth)!r} m", rule, "depth=(1e-3, 4e-3)")
        if not (self.longest_row >= (low - 1) * self.least_pitch * (1 - 1e-9)):
            seen, size = f"longest_row = {self.longest_row:.6g} m", (low - 1) * self.least_pitch
            rule = f"{low:.0f} sensors at the least pitch take {size:.6g} m"
            raise GeometryError(seen, rule, "fewer sensors, a smaller pitch, or a longer row")
        unknown = [name for name in self.layouts if name not in (*PATTERNS, "free")]
        if unknown or not set(self.layouts) & set(PATTERNS):
            seen = f'layout "{unknown[0]}"' if unknown else f"layouts = {list(self.layouts)}"
            rule = f'some of {", ".join(PATTERNS)} are needed, and perhaps "free"'
            raise InvalidValueError(seen, rule, 'layouts = ["grid", "hexagonal"]')


@dataclass(frozen=True)
class Effort(Noun):
    """How finely designs are searched; `rank_fingers` has an example.

    Parameters
    ----------
    depths, pitches : int, optional
        How many of each are tried.
    touches : int, optional
        Touches by which each design is judged; 10,000 of a row and 300 on an area if left out.
    seed : int, optional
        Seed of the touches: the same seed gives the same numbers.
    keep : int, optional
        How many fingers are returned at most.
    """

    depths: Annotated[int, Whole(1, 1000)] = 20
    pitches: Annotated[int, Whole(1, 1000)] = 30
    touches: Annotated[int, Whole(100, 10**8)] | None = None
    seed: Annotated[int, Whole(0, 2**63)] = 0
    keep: Annotated[int, Whole(1, 1000)] = 5
