"""What there is to choose from: kinds of sensor, mixes of them, skins."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ... import _check
from ...errors import InvalidValueError
from ...skin import Skin
from ...transducer import Transducer

__all__ = ["Mix", "SensorKind", "SkinChoice"]


@dataclass(frozen=True)
class SensorKind:
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

    Raises
    ------
    InvalidValueError
        What is no transducer; a value out of range.
    """

    name: str
    transducer: Transducer
    noise: float
    width: float = 0.0
    largest: float = np.inf
    resolution: float = 0.0

    def __post_init__(self) -> None:
        _check.noun("transducer", self.transducer, Transducer, "transducer=MeanPressure()")
        self.transducer.linearise(np.zeros(0))  # refuses what cannot be made linear
        object.__setattr__(self, "noise", _check.scalar("noise", self.noise, above=0.0))
        for name in ("width", "resolution"):
            object.__setattr__(self, name, _check.scalar(name, getattr(self, name), at_least=0.0))
        largest = _check.scalar("largest", self.largest, above=0.0, finite=False, fix="leave out largest")
        object.__setattr__(self, "largest", largest)

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
class Mix:
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
        kinds = tuple(self.kinds)
        object.__setattr__(self, "kinds", kinds)
        if len(kinds) < 2 or not all(isinstance(kind, SensorKind) for kind in kinds):
            rule = "two kinds of sensor or more are needed"
            raise InvalidValueError(f"{len(kinds)} kinds in a mix", rule, 'kinds = ["gauge", "shear"]')


@dataclass(frozen=True)
class SkinChoice:
    """A `skin` that could be moulded, and the `name` of it in the report; `rank_fingers` has an example."""

    name: str
    skin: Skin
