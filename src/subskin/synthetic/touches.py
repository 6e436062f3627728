"""Touches to learn from: random contacts of all kinds that a finger may meet, each shard drawn by its own seed."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Annotated, Any, ClassVar, NamedTuple

import numpy as np
import numpy.typing as npt

from .. import _check
from .._check import FloatArray
from .._declared import Fix, Noun, Positive, Whole
from ..contact import LineLoad, PointLoad, families, local_families
from ..errors import GeometryError, InvalidValueError
from ..finger import Finger, finger_needed
from .recording import measured

__all__ = ["FAULTS", "ContactShare", "RandomTouches", "TouchShard"]

FAULTS = ("none", "dead", "weak", "shifted")
"""What may be wrong with one sensor: nothing; it reads only offset and noise; less gain; another offset."""
_WEAK = (0.3, 0.9)
"""What is left of the gain of a weak sensor."""
_SHIFT = (3.0, 20.0)
"""How far the offset of a shifted sensor has moved, in noises, to either side."""


class TouchShard(NamedTuple):
    """Touches of one shard: `readings` (m, n), `parameters` (m, p) and `labels` (m, 3), in the order of their names."""

    readings: FloatArray
    parameters: FloatArray
    labels: npt.NDArray[np.int16]


@dataclass(frozen=True)
class ContactShare(Noun):
    """A family of contacts, and how often it touches.

    Parameters
    ----------
    family : str
        A name of `subskin.contact.families`, or of `local_families`.
    share : float, optional
        How often, relative to the others, > 0.
    half_width : (float, float), optional
        Least and largest half width [m]; a line or a point has none, all others need it.

    Raises
    ------
    InvalidValueError
        A family that is not known; a share or a half width not > 0; half widths that do not go with the family.

    Examples
    --------
    >>> ContactShare("hertz", half_width=(0.2e-3, 2e-3)).local
    False
    """

    family: str
    share: Positive = 1.0
    half_width: tuple[float, float] | None = None

    EXAMPLE: ClassVar[str] = 'ContactShare("hertz", ...)'

    def __post_init__(self) -> None:
        super().__post_init__()
        known = {**families(), **local_families()}
        _check.choice("family", self.family, known, 'family="hertz"')
        if (self.half_width is None) != (known[self.family] in (LineLoad, PointLoad)):
            seen = f"half_width = {_check.shown(self.half_width)} of a {self.family}"
            rule = "it has none" if self.half_width is not None else "it needs one"
            raise InvalidValueError(seen, rule, "half_width=(0.2e-3, 2e-3) for all but a line and a point")
        if self.half_width is not None:
            object.__setattr__(self, "half_width", _range("half_width", self.half_width, "m", above=0.0))

    @property
    def local(self) -> bool:
        """Whether it is local, with forces in N, or long, with forces in N/m."""
        return self.family in local_families()

    @property
    def kind(self) -> Any:
        """The class of its contacts."""
        return {**families(), **local_families()}[self.family]


@dataclass(frozen=True, eq=False)
class RandomTouches(Noun):
    """`count` touches of a finger, each number drawn evenly from its range.

    Shard k is drawn by `numpy.random.default_rng([seed, k])` alone: its bits do not depend on the others, nor on who
    computes it.

    Parameters
    ----------
    finger : Finger
        What is touched.
    contacts : sequence of ContactShare
        What touches: all long, or all local.
    count : int
        Number of touches.
    force : (float, float)
        Least and largest force, > 0 [N/m], of local contacts [N].
    position : (float, float), optional
        Ends of the positions y [m]; over the sensors, if left out.
    across : (float, float), optional
        Of local contacts, ends of the positions z [m]; over the sensors, if left out.
    angle : (float, float), optional
        Ends of the angle to the inward normal [rad].
    azimuth : (float, float), optional
        Of local contacts, ends of the azimuth, from +y towards +z [rad].
    noise : (float, float), optional
        Ends of the noise of a touch, relative to that of the finger.
    faults : mapping of str to float, optional
        Share of the touches in which one sensor, any live one, has a fault: of `FAULTS` by name.
    shard : int, optional
        Touches in a shard.
    seed : int, optional
        Of all shards.

    Raises
    ------
    InvalidValueError, GeometryError
        A value out of range; long and local contacts together; what the finger does not take.

    Examples
    --------
    >>> import subskin as ss
    >>> skin = ss.HalfPlane(ss.Material(young=0.4e6))
    >>> finger = ss.Finger(skin, ss.SensorArray.line(count=4, pitch=2e-3, depth=2e-3, noise=1e-4))
    >>> kinds = (ContactShare("line"), ContactShare("hertz", half_width=(0.2e-3, 2e-3)))
    >>> touches = RandomTouches(finger, kinds, 1000, force=(5.0, 60.0), angle=(-0.5, 0.5), shard=400)
    >>> touches.shards, touches.parameters
    (3, ('position', 'normal', 'tangential', 'half_width', 'noise'))
    >>> readings, parameters, labels = touches.shard_of(2)
    >>> readings.shape, parameters.shape, labels.shape
    ((200, 4), (200, 5), (200, 3))
    """

    finger: Finger
    contacts: tuple[ContactShare, ...]
    count: Annotated[int, Whole(1, 10**12)]
    force: tuple[float, float]
    position: tuple[float, float] | None = None
    across: tuple[float, float] | None = None
    angle: tuple[float, float] = (0.0, 0.0)
    azimuth: tuple[float, float] = (0.0, 0.0)
    noise: tuple[float, float] = (1.0, 1.0)
    faults: Annotated[Mapping[str, float], Fix('faults={"dead": 0.01}')] = field(default_factory=dict)
    shard: Annotated[int, Whole(1, 10**7)] = 100_000
    seed: Annotated[int, Whole(0, 2**63 - 1)] = 0

    def __post_init__(self) -> None:
        finger_needed(self.finger)
        super().__post_init__()
        if len({contact.local for contact in self.contacts}) != 1:
            seen = f"contacts {', '.join(contact.family for contact in self.contacts) or 'of no family'}"
            rule = "all have to be long, with forces in N/m, or all local, with forces in N"
            raise InvalidValueError(seen, rule, "one set of touches for each")
        array = self.finger.array
        if not self.local:
            array.refuse_area()
        elif not self.finger.skin.takes_local:
            seen = f"{self.contacts[0].family} contacts on {self.finger.skin}"
            raise InvalidValueError(seen, "it is solved in a plane and takes long contacts", "line, hertz, ...")
        for name in ("across", "azimuth") if not self.local else ():
            given = getattr(self, name)
            if given is not None and _check.real(name, given).any():
                rule = "a long contact is the same at every z"
                raise InvalidValueError(f"{name} = {_check.shown(given)}", rule, f"leave out {name}")
        for name in ("position", "across"):
            if getattr(self, name) is None:
                ends = np.asarray(array.y if name == "position" else array.z)
                object.__setattr__(self, name, (float(ends.min()), float(ends.max())))
        lowest = 0.0 if self.local else -np.pi / 2
        limits: dict[str, dict[str, Any]] = {
            "position": {"unit": "m"},
            "across": {"unit": "m"},
            "force": {"unit": "N" if self.local else "N/m", "above": 0.0},
            "angle": {"unit": "rad", "at_least": lowest, "at_most": np.pi / 2},
            "azimuth": {"unit": "rad"},
            "noise": {"unit": "", "at_least": 0.0},
        }
        for name, limit in limits.items():
            object.__setattr__(self, name, _range(name, getattr(self, name), **limit))
        for name, share in self.faults.items():
            if name not in FAULTS[1:]:
                seen = f"{_check.shown(name)} = {_check.shown(share)}"
                raise InvalidValueError(seen, f"the faults are {', '.join(FAULTS[1:])}", "dead = 0.01")
            _check.scalar(name, share, at_least=0.0, at_most=1.0)
        if sum(self.faults.values()) > 1:
            raise InvalidValueError(f"faults {dict(self.faults)}", "their shares are at most 1 together", "dead = 0.01")
        noisy = np.asarray(array.noise)[array.live]
        if self.faults.get("shifted") and not noisy.all():
            seen = f"shifted = {self.faults['shifted']:g} of a finger with sensors without noise"
            raise InvalidValueError(seen, "an offset moves by 3 to 20 noises", "give [sensors] a noise")
        if self.faults and not array.live.any():
            raise GeometryError("faults of a finger whose sensors are all dead", "one has to be live", "no faults")

    @property
    def local(self) -> bool:
        """Whether the contacts are local, with forces in N."""
        return self.contacts[0].local

    @property
    def shards(self) -> int:
        """How many shards there are; the last may be smaller."""
        return -(-self.count // self.shard)

    @property
    def parameters(self) -> tuple[str, ...]:
        """Names of the columns of `TouchShard.parameters`."""
        if self.local:
            where: tuple[str, ...] = ("position_y", "position_z", "normal", "tangential_y", "tangential_z")
        else:
            where = ("position", "normal", "tangential")
        return (*where, "half_width", "noise")

    @property
    def units(self) -> tuple[str, ...]:
        """SI unit of each column of `TouchShard.parameters`; "" of the noise, which is relative."""
        d = 1 + self.local
        return (*("m",) * d, *("N" if self.local else "N/m",) * (d + 1), "m", "")

    labels = ("contact", "fault", "faulty_sensor")
    """Columns of `TouchShard.labels`: numbers of a contact, of one of `FAULTS`, and of a sensor, -1 for none."""

    def rows(self, shard: int) -> range:
        """Numbers of the touches of a shard.

        Raises
        ------
        InvalidValueError
            There is no such shard.
        """
        k = _check.whole("shard", shard, at_least=0, at_most=self.shards - 1)
        return range(k * self.shard, min((k + 1) * self.shard, self.count))

    def shard_of(self, shard: int, most: int | None = None) -> TouchShard:
        """The touches of a shard, or the first `most` of them.

        Parameters
        ----------
        shard : int
            Its number, from 0.
        most : int, optional
            How many touches; all if left out.

        Raises
        ------
        InvalidValueError
            There is no such shard; what is no number of touches.
        """
        m, rng = len(self.rows(shard)), np.random.default_rng([self.seed, int(shard)])
        kept = slice(None if most is None else _check.whole("most", most, at_least=0, at_most=10**12))
        shares = np.array([contact.share for contact in self.contacts])
        which = rng.choice(len(shares), m, p=shares / shares.sum())
        width = np.zeros(m)
        for i, contact in enumerate(self.contacts):  # all draw alike, so that one's range does not move another's
            low, high = contact.half_width or (0.0, 0.0)
            drawn = rng.uniform(low, high, m)
            width = np.where(which == i, drawn, width)
        y, z = (rng.uniform(*ends, m) for ends in (self.position, self.across) if ends is not None)
        ranges = {"force": self.force, "angle": self.angle, "azimuth": self.azimuth}
        loads: dict[str, FloatArray] = {name: rng.uniform(low, high, m) for name, (low, high) in ranges.items()}
        if self.local:
            loads["position"] = np.stack([y, z], axis=-1)
        else:
            loads["position"] = y
            del loads["azimuth"]
        point: Any = (PointLoad if self.local else LineLoad)(**loads)
        noise = rng.uniform(*self.noise, m)
        fault, sensor, weak, shift = self._faults(rng, m)
        normal = rng.standard_normal((m, len(self.finger.array)))[kept]
        values = self._measured(which[kept], {name: v[kept] for name, v in (*loads.items(), ("half_width", width))})
        readings = self._read(
            values, point.normal_force[kept], noise[kept], normal, (fault[kept], sensor[kept], weak[kept], shift[kept])
        )
        columns = [loads["position"].reshape(m, -1), point.components, width[:, None], noise[:, None]]
        labels = np.stack([which, fault, np.where(fault > 0, sensor, -1)], axis=-1).astype(np.int16)
        return TouchShard(readings, np.concatenate(columns, axis=-1)[kept], labels[kept])

    def _faults(self, rng: np.random.Generator, m: int) -> tuple[Any, Any, FloatArray, FloatArray]:
        """Of each touch the fault, the sensor that would have it, what is left of its gain, and its shift [noises]."""
        ends = np.cumsum([self.faults.get(name, 0.0) for name in FAULTS[1:]])
        u = rng.random(m)
        fault = np.where(u < ends[-1], 1 + np.searchsorted(ends, u, side="right"), 0)
        live = np.flatnonzero(self.finger.array.live)
        sensor = live[rng.integers(live.size, size=m)] if live.size else np.full(m, -1)
        weak = rng.uniform(*_WEAK, m)
        shift = rng.uniform(*_SHIFT, m) * rng.choice([-1.0, 1.0], m)
        return fault, sensor, weak, shift

    def _measured(self, which: Any, loads: Mapping[str, FloatArray]) -> FloatArray:
        """What the transducers measure, the families one by one."""
        out = np.empty((len(which), len(self.finger.array)))
        for i, contact in enumerate(self.contacts):
            own = which == i
            names = [name for name in loads if name != "half_width" or contact.half_width is not None]
            if own.any():
                out[own] = measured(self.finger, contact.kind, {name: loads[name][own] for name in names})
        return out

    def _read(
        self, values: FloatArray, force: FloatArray, noise: FloatArray, normal: FloatArray, faults: tuple[Any, ...]
    ) -> FloatArray:
        """Readings with the noise of each touch and its fault; range and resolution come last."""
        array, rows = self.finger.array, np.arange(len(values))
        fault, sensor, weak, shift = faults
        left = np.where(fault == 1, 0.0, np.where(fault == 2, weak, 1.0))
        readings = replace(array, low=-np.inf, high=np.inf, offset=0.0, resolution=0.0).digitise(values, None, force)
        readings[rows, sensor] *= left
        readings += np.asarray(array.offset)
        moved = np.where(fault == 3, shift, 0.0) * np.asarray(array.noise)[sensor]
        readings[rows, sensor] += moved
        readings += noise[:, None] * np.asarray(array.noise) * normal
        return replace(array, gain=1.0, lift=0.0, offset=0.0).digitise(readings)


def _range(name: str, ends: Any, unit: str, **limits: Any) -> tuple[float, float]:
    """Two numbers within the limits, the first at most the second."""
    values = _check.real(name, ends, unit=unit, **limits)
    if values.shape != (2,) or values[0] > values[1]:
        rule = "the least and the largest are needed"
        raise InvalidValueError(f"{name} = {_check.shown(ends)}", rule, f"{name}=(0.0, 1.0)")
    return float(values[0]), float(values[1])
