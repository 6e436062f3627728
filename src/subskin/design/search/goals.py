"""What the designer of a finger knows and wants: touches, accuracy, sensors, skins, space."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property
from typing import Annotated, ClassVar, Literal

import numpy as np

from ... import _check
from ..._check import FloatArray
from ..._declared import Fix, Noun, Positive, Real, Whole, checked
from ...array import SensorArray
from ...errors import GeometryError, InvalidValueError
from ...finger import Finger
from ..placement import AREA_SAMPLES, Arrangement, Channel, channels_of, layouts
from ..tolerance.sources import Amounts
from ..touches import Touches
from .choices import Effort, Mix, Room, SensorKind, SkinChoice

__all__ = ["Accuracy", "Goals", "Row"]

WIDEST = 2.5
"""Pitches go up to this many times the largest depth, unless the room ends before."""
_FELT = 3.0
"""Depths beyond a row at which a touch is hardly felt."""
_OUTSIDE = 0.2
"""Share of touches outside the model that may be OK and wrong where no goal says so."""


@dataclass(frozen=True)
class Accuracy(Noun):
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
    radius : float, optional
        Standard error of the radius of touches on an area that have one [m].
    edge, edge_length : float, optional
        On an area: standard error of the direction of an edge [rad], and its length [m]; both or neither.
    feature : float, optional
        Distance at which two touches have to read as two, 95 % of pairs [m].
    blind_spots : float, optional
        Largest share of touches of one kind outside the model that may be OK and wrong, as in `blind_spots`, in (0, 1];
        0.2 if left out. With 1 they are not looked at.
    calibrated : {"known", "blind", "none"}, optional
        Which finger is judged: calibrated on touches at known positions, blind, or as it was made.

    Raises
    ------
    InvalidValueError
        A value out of range; neither position, angle nor force.
    """

    position: Positive | None = None
    angle: Positive | None = None
    force: Positive | None = None
    radius: Positive | None = None
    edge: Positive | None = None
    edge_length: Positive | None = None
    unsure: Annotated[float, Real(above=0.0, at_most=1.0)] = 0.01
    feature: Positive | None = None
    blind_spots: Annotated[float | None, Real(above=0.0, at_most=1.0)] = None
    calibrated: Literal["known", "blind", "none"] = "known"

    EXAMPLE: ClassVar = "Accuracy(position=0.2e-3)"

    def __post_init__(self) -> None:
        super().__post_init__()
        if (self.edge is None) != (self.edge_length is None):
            rule = "the direction of an edge, and the edge's length, go together"
            raise InvalidValueError(f"edge = {self.edge!r}", rule, "edge=0.1, edge_length=6e-3")
        if self.position is None and self.angle is None and self.force is None:
            rule = "one of position, angle and force is needed"
            raise InvalidValueError("no accuracy is wanted", rule, "state the position")

    @property
    def outside(self) -> float:
        """`blind_spots`, or the usual goal where none is stated."""
        return _OUTSIDE if self.blind_spots is None else self.blind_spots


@dataclass(frozen=True)
class Row:
    """A row of equal sensors, or an array on an area.

    Parameters
    ----------
    skin, sensor : int
        Which of the goals' skins, and of their `choices` of kinds.
    layout : Arrangement
        How the positions are set out.
    depth, pitch : float
        [m].
    """

    skin: int
    sensor: int
    layout: Arrangement
    depth: float
    pitch: float

    @property
    def count(self) -> int:
        """How many positions."""
        return self.layout.count

    @property
    def free(self) -> bool:
        """Whether its sensors have left their even layout."""
        return self.layout.pattern == "free"

    @property
    def length(self) -> float:
        """From the first sensor to the last [m]; on an area the longer side."""
        return float(self.layout.size.max()) * self.pitch

    def which(self, goals: Goals) -> tuple[int, int, int]:
        """Index of its skin, kind and layout in the arrays of a `DesignGrid`.

        That of free positions is the first layout of as many.
        """
        counts = [layout.count for layout in goals.layouts]
        known = self.layout in goals.layouts
        return self.skin, self.sensor, goals.layouts.index(self.layout) if known else counts.index(self.count)


@dataclass(frozen=True)
class Goals(Noun):
    """All that a search needs to know; `rank_fingers` has an example.

    Parameters
    ----------
    touches : Touches
        The weakest touch to notice, the friction, and the span or the area of skin that is touched; one is needed.
        With an area arrays on an area are searched, else rows.
    strongest : float
        The strongest force to bear [N/m], on an area [N].
    accuracy : Accuracy
    sensors : tuple of SensorKind
    skins : tuple of SkinChoice
    room : Room
    largest_strain : float, optional
        Largest compressive strain at the sensors under the strongest force [-]: the theory is one of small strains.
    tolerances : mapping, optional
        Tolerances of making the finger, as in `tolerance_budget`; those of `usual_tolerances` if left out. With {} only
        noise counts.
    effort : Effort, optional
    title : str, optional
    mixes : sequence of Mix, optional
        On an area: arrays of several kinds, tried beside those of one.

    Raises
    ------
    InvalidValueError, GeometryError
        Touches without a span, what is not worked out on an area (docs/designing.md), a strongest force below the
        weakest, nothing to choose from.
    """

    touches: Annotated[Touches, Fix("Touches(force=20.0, span=(-5e-3, 5e-3))")]
    strongest: float
    accuracy: Accuracy
    sensors: tuple[SensorKind, ...]
    skins: tuple[SkinChoice, ...]
    room: Room
    largest_strain: Annotated[float, Real(above=0.0, at_most=1.0)] = 0.1
    tolerances: Amounts = None
    effort: Effort = field(default_factory=Effort)
    title: str = "Finger"
    mixes: tuple[Mix, ...] = ()

    def __post_init__(self) -> None:
        super().__post_init__()
        if not self.touches.force <= self.strongest < np.inf:
            unit, weakest = self.touches.unit, self.touches.force
            rule = f"has to be at least the weakest force, {weakest:.6g} {unit}"
            raise InvalidValueError(f"strongest = {self.strongest!r} {unit}", rule, "swap the two forces")
        self._check_area() if self.on_area else self._check_span()
        for name, amount in (self.tolerances or {}).items():
            _check.scalar(name, amount, at_least=0.0)
        for name, choices in (("sensors", self.sensors), ("skins", self.skins)):
            if not choices:
                raise InvalidValueError(f"{name} = ()", "one at least is needed", f"{name}=[...]")
            called = [choice.name for choice in (choices if name == "skins" else self.choices)]
            twice = [c for c in called if called.count(c) > 1]
            if twice:
                rule = "each needs a name of its own in the report"
                raise InvalidValueError(f'two {name} called "{twice[0]}"', rule, "another name")

    def _check_span(self) -> None:
        low, high = self.touches.span_on()
        room, deep = self.room, self.room.depth[1]
        longest = min(room.longest_row, (room.count[1] - 1) * max(room.least_pitch, WIDEST * deep))
        felt = longest + 2 * _FELT * deep
        if high - low > felt:  # most often one in the wrong unit
            rule = f"the longest row, {longest:.6g} m, reads {felt:.6g} m at most"
            raise GeometryError(f"span = {high - low:.6g} m", rule, 'a shorter span, with its unit: "12 mm"')
        if self.mixes:
            rule = "rows are of one kind of sensor"
            raise InvalidValueError(f'the mix "{self.mixes[0].name}"', rule, "touches on an area, or no mixes")
        for name in ("radius", "edge"):
            if getattr(self.accuracy, name) is not None:
                rule = "it is found of touches on an area"
                raise InvalidValueError(f"{name} = {getattr(self.accuracy, name)!r}", rule, f"leave out the {name}")

    def _check_area(self) -> None:
        if self.accuracy.radius is not None and self.touches.half_width is None:
            rule = "touches without a half width are points"
            raise InvalidValueError(f"radius = {self.accuracy.radius!r} m", rule, "Touches(..., half_width=1e-3)")
        for choice in self.skins:
            if not choice.skin.takes_local:
                rule = "it is solved in a plane and takes no touch on an area"
                raise InvalidValueError(f'the skin "{choice.name}"', rule, "half_space or layers")
        if not self.layouts:
            low, high = self.room.count
            seen = f"{low} to {high} sensors"
            raise GeometryError(seen, f"no {' or '.join(self.room.layouts)} has so many", "more sensors, or layouts")

    @property
    def on_area(self) -> bool:
        """Whether arrays on an area are searched, not rows."""
        return self.touches.area is not None

    @property
    def choices(self) -> tuple[SensorKind | Mix, ...]:
        """What an array can be made of: the kinds of sensor, then the mixes."""
        return (*self.sensors, *self.mixes)

    @property
    def extent(self) -> FloatArray:
        """Sides along y and z of where sensors may stand [m], shape (2,); a row has no other side."""
        if not self.on_area:
            return np.array([self.room.longest_row, np.inf])
        if self.room.area is not None:
            return np.array(self.room.area)
        touched = np.ptp(np.asarray(self.touches.area), axis=1)
        return np.asarray(np.minimum(1.5 * touched, touched + 4 * self.room.depth[1]))

    @property
    def middle(self) -> tuple[float, float]:
        """The middle of what is touched, (y, z) [m], about which rows and arrays stand."""
        return self.touches.middle

    @cached_property
    def layouts(self) -> tuple[Arrangement, ...]:
        """How the positions can be set out: rows of each count, or on an area those of `layouts`."""
        low, high = self.room.count
        if not self.on_area:
            return tuple(Arrangement("row", (n,)) for n in range(low, high + 1))
        most = max(len(choice.kinds) if choice.together else 1 for choice in self.choices)
        y, z = self.extent.tolist()
        patterns = [name for name in self.room.layouts if name != "free"]
        return layouts(patterns, (max(-(-low // most), 2), high), y / z)

    @property
    def counted(self) -> int:
        """Touches by which each design is judged."""
        usual = AREA_SAMPLES if self.on_area else 10_000
        return usual if self.effort.touches is None else self.effort.touches

    @checked
    def readings(self, sensor: int, count: Annotated[int, Whole(0, 10**9, "count=9")]) -> int:
        """Readings of an array: each kind of a mix that is together has one at each position.

        Parameters
        ----------
        sensor : int
            Which of the `choices`.
        count : int
            How many positions.
        """
        choice = self.choices[self._which(sensor)]
        return count * (len(choice.kinds) if choice.together else 1)

    def channels(self, sensor: int) -> tuple[Channel, ...]:
        """The kinds of one of the `choices`, as `study_at_depth` takes them.

        Parameters
        ----------
        sensor : int
            Which of them.
        """
        return tuple(
            Channel(kind.transducer, kind.error, kind.width) for kind in self.choices[self._which(sensor)].kinds
        )

    def _which(self, sensor: object) -> int:
        return _check.whole("sensor", sensor, at_least=0, at_most=len(self.choices) - 1, fix="sensor=0")

    @checked
    def finger(self, row: Annotated[Row, Fix("goals.finger(study.rows[0])")]) -> Finger:
        """The finger of one `row`."""
        choice, skin = self.choices[row.sensor], self.skins[row.skin].skin
        at, which = channels_of(row.layout, len(choice.kinds), choice.together)
        points, kinds = row.layout.points(row.pitch, self.middle)[at], [choice.kinds[i] for i in which.tolist()]
        each = {name: [getattr(kind, name) for kind in kinds] for name in ("noise", "width", "resolution")}
        largest = np.array([kind.largest for kind in kinds])
        array = SensorArray(
            points[:, 0], row.depth, [kind.transducer for kind in kinds], z=points[:, 1], low=-largest, high=largest,
            **each,
        )  # fmt: skip
        return Finger(skin, array)
