"""What the designer of a finger knows and wants: touches, accuracy, sensors, skins, space."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal

import numpy as np

from ... import _check
from ...array import SensorArray
from ...errors import GeometryError, InvalidValueError
from ...finger import Finger
from ...skin import Skin
from ...transducer import Transducer
from .._common import whole
from ..touches import Touches

__all__ = ["Accuracy", "Effort", "Goals", "Room", "Row", "SensorKind", "SkinChoice"]

WIDEST = 2.5
"""Pitches go up to this many times the largest depth, unless the room ends before."""
_FELT = 3.0
"""Depths beyond a row at which a touch is hardly felt."""


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
        if not isinstance(self.transducer, Transducer):
            raise InvalidValueError(
                f"transducer = {self.transducer!r}", "a Transducer is needed", "transducer=MeanPressure()"
            )
        self.transducer.linearise(np.zeros(0))  # refuses what cannot be made linear
        object.__setattr__(self, "noise", _check.scalar("noise", self.noise, above=0.0))
        for name in ("width", "resolution"):
            object.__setattr__(self, name, _check.scalar(name, getattr(self, name), at_least=0.0))
        if not self.largest > 0:
            raise InvalidValueError(f"largest = {self.largest:.6g}", "has to be > 0", "leave out largest")

    @property
    def error(self) -> float:
        """Standard deviation of a reading, that of rounding included."""
        return float(np.hypot(self.noise, self.resolution / np.sqrt(12)))


@dataclass(frozen=True)
class SkinChoice:
    """A `skin` that could be moulded, and the `name` of it in the report; `rank_fingers` has an example."""

    name: str
    skin: Skin


@dataclass(frozen=True)
class Accuracy:
    """The errors that 95 % of the weakest touches should keep, in one frame; None where an error does not matter.

    `rank_fingers` has an example.

    Parameters
    ----------
    position, angle : float, optional
        Standard error of the position [m] and of the angle [rad].
    force : float, optional
        Standard error of the force, relative to it.
    unsure : float, optional
        Largest share of touches that may be ambiguous, not noticed, or lost to tolerances, in (0, 1].
    feature : float, optional
        Distance at which two touches have to read as two, 95 % of pairs [m].
    blind_spots : float, optional
        Largest share of touches of one kind outside the model that may be OK and wrong, as in `blind_spots`, in (0, 1].
    calibrated : {"known", "blind", "none"}, optional
        Which finger is judged: calibrated on touches at known positions, blind, or as it was made.

    Raises
    ------
    InvalidValueError
        A value out of range; neither position, angle nor force.
    """

    position: float | None = None
    angle: float | None = None
    force: float | None = None
    unsure: float = 0.01
    feature: float | None = None
    blind_spots: float | None = None
    calibrated: Literal["known", "blind", "none"] = "known"

    def __post_init__(self) -> None:
        for name in ("position", "angle", "force", "feature"):
            if getattr(self, name) is not None:
                object.__setattr__(self, name, _check.scalar(name, getattr(self, name), above=0.0))
        for name in ("unsure", "blind_spots"):
            if getattr(self, name) is not None:
                share = _check.scalar(name, getattr(self, name), above=0.0, at_most=1.0)
                object.__setattr__(self, name, share)
        if self.calibrated not in ("known", "blind", "none"):
            rule = "it is known, blind or none"
            raise InvalidValueError(f'calibrated = "{self.calibrated}"', rule, 'calibrated = "known"')
        if self.position is None and self.angle is None and self.force is None:
            raise InvalidValueError(
                "no accuracy is wanted", "one of position, angle and force is needed", "state the position"
            )


@dataclass(frozen=True)
class Room:
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

    Raises
    ------
    InvalidValueError, GeometryError
        Counts or depths that do not ascend; a row too short for the fewest sensors.
    """

    count: tuple[int, int]
    depth: tuple[float, float]
    least_pitch: float
    longest_row: float = np.inf

    def __post_init__(self) -> None:
        low, high = self.count
        if int(low) != low or int(high) != high or not 3 <= low <= high:
            raise InvalidValueError(
                f"count = {list(self.count)!r}", "two whole numbers are needed, 3 <= fewest <= most", "3 and 12"
            )
        shallow, deep = self.depth
        if not (0 < shallow <= deep < np.inf):
            raise GeometryError(
                f"depth = {list(self.depth)!r} m", "0 < shallowest <= deepest is needed", "depth=(1e-3, 4e-3)"
            )
        object.__setattr__(self, "least_pitch", _check.scalar("least_pitch", self.least_pitch, above=0.0))
        if not (self.longest_row >= (low - 1) * self.least_pitch * (1 - 1e-9)):
            raise GeometryError(
                f"longest_row = {self.longest_row:.6g} m",
                f"{low} sensors at the least pitch take {(low - 1) * self.least_pitch:.6g} m",
                "fewer sensors, a smaller pitch, or a longer row",
            )


@dataclass(frozen=True)
class Row:
    """A row of equal sensors.

    Parameters
    ----------
    skin, sensor : int
        Which of the goals' skins and kinds of sensor.
    count : int
        How many sensors.
    depth, pitch : float
        [m].
    """

    skin: int
    sensor: int
    count: int
    depth: float
    pitch: float

    @property
    def length(self) -> float:
        """From the first sensor to the last [m]."""
        return (self.count - 1) * self.pitch

    def which(self, goals: Goals) -> tuple[int, int, int]:
        """Index of its skin, kind and count in the arrays of a `DesignGrid`."""
        return self.skin, self.sensor, self.count - goals.room.count[0]


@dataclass(frozen=True)
class Effort:
    """How finely designs are searched; `rank_fingers` has an example.

    Parameters
    ----------
    depths, pitches : int, optional
        How many of each are tried.
    touches : int, optional
        Touches by which each design is judged.
    seed : int, optional
        Seed of the touches: the same seed gives the same numbers.
    keep : int, optional
        How many fingers are returned at most.

    Raises
    ------
    InvalidValueError
        What is no whole number, or too small.
    """

    depths: int = 20
    pitches: int = 30
    touches: int = 10_000
    seed: int = 0
    keep: int = 5

    def __post_init__(self) -> None:
        for name, least in (("depths", 1), ("pitches", 1), ("touches", 100), ("seed", 0), ("keep", 1)):
            whole(name, getattr(self, name), least)


@dataclass(frozen=True)
class Goals:
    """All that a search needs to know; `rank_fingers` has an example.

    Parameters
    ----------
    touches : Touches
        The weakest touch to notice, the friction, and the span of skin that is touched; the span is needed.
    strongest : float
        The strongest force to bear [N/m].
    accuracy : Accuracy
    sensors : tuple of SensorKind
    skins : tuple of SkinChoice
    room : Room
    largest_strain : float, optional
        Largest compressive strain at the sensors under the strongest force [-]: the theory is one of small strains.
    tolerances : mapping, optional
        Tolerances of making the finger, as in `tolerance_budget`; those of `usual_tolerances` if left out. With {},
        only noise counts.
    effort : Effort, optional
    title : str, optional

    Raises
    ------
    InvalidValueError, GeometryError
        Touches without a span, a strongest force below the weakest, nothing to choose from.
    """

    touches: Touches
    strongest: float
    accuracy: Accuracy
    sensors: tuple[SensorKind, ...]
    skins: tuple[SkinChoice, ...]
    room: Room
    largest_strain: float = 0.1
    tolerances: Mapping[str, float] | None = None
    effort: Effort = Effort()
    title: str = "Finger"

    def __post_init__(self) -> None:
        low, high = self.touches.span_on()
        if not self.touches.force <= self.strongest < np.inf:
            raise InvalidValueError(
                f"strongest = {self.strongest!r} N/m",
                f"has to be at least the weakest force, {self.touches.force:.6g} N/m",
                "swap the two forces",
            )
        room, deep = self.room, self.room.depth[1]
        longest = min(room.longest_row, (room.count[1] - 1) * max(room.least_pitch, WIDEST * deep))
        felt = longest + 2 * _FELT * deep
        if high - low > felt:  # most often one in the wrong unit
            raise GeometryError(
                f"span = {high - low:.6g} m",
                f"the longest row, {longest:.6g} m, reads {felt:.6g} m at most",
                'a shorter span, with its unit: "12 mm"',
            )
        for name, amount in (self.tolerances or {}).items():
            _check.scalar(name, amount, at_least=0.0)
        strain = _check.scalar("largest_strain", self.largest_strain, above=0.0, at_most=1.0)
        object.__setattr__(self, "largest_strain", strain)
        for name in ("sensors", "skins"):
            choices = tuple(getattr(self, name))
            object.__setattr__(self, name, choices)
            if not choices:
                raise InvalidValueError(f"{name} = ()", "one at least is needed", f"{name}=[...]")
            called = [choice.name for choice in choices]
            twice = [c for c in called if called.count(c) > 1]
            if twice:
                raise InvalidValueError(
                    f'two {name} called "{twice[0]}"', "each needs a name of its own in the report", "another name"
                )

    def finger(self, row: Row) -> Finger:
        """The finger of one `row`."""
        kind = self.sensors[row.sensor]
        array = SensorArray.line(
            row.count, row.pitch, row.depth, transducer=kind.transducer, noise=kind.noise, width=kind.width,
            low=-kind.largest, high=kind.largest, resolution=kind.resolution,
        )  # fmt: skip
        return Finger(self.skins[row.skin].skin, array)
