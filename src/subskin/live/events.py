"""What happens in a stream, reported once and with its time: contact, slip, overload, sensors that are lost."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
import numpy.typing as npt
from scipy.special import chdtri

from .._check import FloatArray
from .._frozen import Frozen
from ..array import SensorArray
from ..decide import SlipVerdict
from ..estimate.answer import Status

if TYPE_CHECKING:
    from ..stream import Tared

__all__ = ["Event", "Switch", "Watch", "WatchState"]

BoolArray = npt.NDArray[np.bool_]

_CONTACT, _SLIP_RISK, _SLIP, _OVERLOAD, _SENSOR = (2, 1), (3, 25), (4, 25), (2, 10), (3, 5)
"""Frames one after the other until it is reported that something began, and that it ended."""
_NOTHING, _INCOMPLETE = int(Status.NO_CONTACT), int(Status.INCOMPLETE)
_HOLDS, _AT_RISK, _SLIPS = int(SlipVerdict.HOLDS), int(SlipVerdict.AT_RISK), int(SlipVerdict.SLIPS)
_FIRM = 1e-2
"""A contact has ended where noise is left of the mean of three frames: all but so rarely it departs less from the
offsets. A touch so light that every second frame is called one departs by four times as much."""


@dataclass(frozen=True, eq=False)
class Event(Frozen):
    """One thing that happened.

    Parameters
    ----------
    kind : str
        "contact_on", "contact_off", "slip_risk", "slip", "overload", "sensor_lost", "sensor_back", "gap",
        "lost_frames", "reset", "port_lost", "port_back", "zeroed" or "mark".
    time : float
        Host time of the frame at which it was certain [s].
    frame : int
        Number of that frame in the stream, from 0.
    text : str
        What a person reads.
    values : mapping
        Its numbers in SI; `since` is the host time of its first frame [s], where it took several to be certain.
    """

    kind: str
    time: float
    frame: int
    text: str
    values: Mapping[str, Any] = field(default_factory=dict)


class Switch(NamedTuple):
    """On or off, with hysteresis: it takes some frames one after the other to turn it.

    Parameters
    ----------
    on : bool
        How it stands.
    run : int
        Frames that speak for the other way, one after the other, up to now.
    since : float
        Host time of the first of them [s].
    """

    on: bool = False
    run: int = 0
    since: float = np.nan

    def turned(
        self, begins: Sequence[bool], ends: Sequence[bool], time: FloatArray, patience: tuple[int, int]
    ) -> tuple[Switch, list[tuple[int, bool, float]]]:
        """How it stands after more frames, and when it turned: frame, which way, and since when.

        Parameters
        ----------
        begins, ends : sequence of bool, m of them
            Which frames speak for on, and which for off.
        time : ndarray, shape (m,)
            Host time of each [s].
        patience : (int, int)
            Frames one after the other that turn it on, and off.

        Examples
        --------
        >>> import numpy as np
        >>> felt = [False, True, False, True, True, True]
        >>> Switch().turned(felt, [not one for one in felt], np.arange(6.0), (2, 3))[1]
        [(4, True, 3.0)]
        """
        on, run, since = self
        if not any(ends if on else begins):
            return (self if not run else Switch(on)), []
        turns = []
        for k, (begin, end) in enumerate(zip(begins, ends, strict=True)):
            if not (end if on else begin):
                run = 0
                continue
            since = float(time[k]) if not run else since
            run += 1
            if run >= patience[on]:
                on, run = not on, 0
                turns.append((k, on, since))
        return Switch(on, run, since), turns


class WatchState(NamedTuple):
    """What a `Watch` carries from batch to batch."""

    contact: Switch = Switch()
    risk: Switch = Switch()
    slip: Switch = Switch()
    overload: Switch = Switch()
    tail: FloatArray | None = None
    """Readings of the last two frames of a contact."""
    held: bool = False
    """Whether `Tare` knows of the contact too."""
    sensors: tuple[Switch, ...] = ()
    watched: bool = False
    """Whether some sensor is lost, or may be."""


class _Said(NamedTuple):
    """The events of some frames: their times, the number of the first, and what has happened."""

    time: FloatArray
    first: int
    events: list[Event]

    def add(self, frame: int, kind: str, text: str, **values: Any) -> None:
        self.events.append(Event(kind, float(self.time[frame]), self.first + frame, text, values))


class Watch:
    """Tells events from what the chain makes of each frame.

    Contact is known by the status of the tared frames, and does not wait until `Tare` is sure that the skin is free:
    on after 2 frames that no noise makes, off after 3 whose mean is noise. Where the offsets have drifted under a long
    touch, noise is not what is left, and contact ends with `Tare`.

    Parameters
    ----------
    array : SensorArray
        Noise and number of the sensors.
    names : sequence of str
        What the sensors are called.
    most : float, optional
        Force from which a load is an overload [N/m of a line, N of a point]; without it only a reading beyond its range
        is one.
    """

    def __init__(self, array: SensorArray, names: Sequence[str], most: float | None = None) -> None:
        self.names, self.most = tuple(names), most
        self._live = np.asarray(array.live)
        noise = np.where(self._live, np.asarray(array.noise), np.inf)
        self._weight = 1 / np.where(noise > 0, noise, np.inf)
        count = int(self._live.sum())
        self._firm = float(chdtri(max(count, 1), _FIRM)) / 3
        self.start = WatchState(sensors=(Switch(),) * len(self.names))

    def step(
        self,
        state: WatchState,
        values: FloatArray,
        tared: Tared,
        found: Any,
        decision: Any,
        time: FloatArray,
        first: int,
    ) -> tuple[WatchState, list[Event]]:
        """Events of the next frames, in their order.

        Parameters
        ----------
        state : WatchState
            What the frames before left; `start` at the beginning.
        values : ndarray, shape (m, n)
            Readings as they came.
        tared, found, decision
            What the pipeline made of them, and whether they slip; None where that is not asked.
        time : ndarray, shape (m,)
            Host time of each [s].
        first : int
            Number of the first of them in the stream.
        """
        said = _Said(time, first, [])
        total = np.add.reduce(tared.readings, axis=None)
        wide, some = None, bool(total != total)
        if some:  # a reading that is there, and was taken out for its size
            wide = (np.isnan(tared.readings) & np.isfinite(values) & ~tared.frozen)[:, self._live]
        sensors, watched = state.sensors, state.watched
        if some or watched:
            gone = (~np.isfinite(values) | tared.frozen) & self._live
            sensors = self._sensors(sensors, gone, tared.frozen, said)
            watched = any(one.on or one.run for one in sensors)
        overload = self._overload(state.overload, wide, found, said)
        contact, ended = self._contact(state, tared, found, decision, said)
        risk, slip = state.risk, state.slip
        if decision is not None:
            if ended and not contact.on:
                risk = slip = Switch()
            risk, slip = self._slip(risk, slip, decision, said)
        if len(said.events) > 1:
            said.events.sort(key=lambda event: event.frame)
        tail, held = None, False
        if contact.on:
            held = state.held or not tared.free.all()
            tail = tared.readings[-2:]
            if len(tail) < 2 and state.tail is not None:
                tail = np.concatenate([state.tail[-1:], tail])
        return WatchState(contact, risk, slip, overload, tail, held, sensors, watched), said.events

    def _contact(self, state: WatchState, tared: Tared, found: Any, decision: Any, said: _Said) -> tuple[Switch, bool]:
        contact, tail = state.contact, state.tail
        status: list[int] = (found if decision is None else decision).status.tolist()
        felt = [one not in (_NOTHING, _INCOMPLETE) for one in status]
        left = [one == _NOTHING for one in status]
        if any(left) and (contact.on or any(felt)):
            before = np.full((2, self._weight.size), np.nan)
            if tail is not None:
                before[2 - len(tail) :] = tail
            away = (np.concatenate([before, tared.readings]) - tared.own) * self._weight
            mean = (away[2:] + away[1:-1] + away[:-2]) / 3
            noise = np.isfinite(mean).any(axis=-1) & (np.nansum(mean * mean, axis=-1) < self._firm)
            freed = tared.free & (state.held | np.logical_or.accumulate(~tared.free))
            left = [one and fine for one, fine in zip(left, (noise | freed).tolist(), strict=True)]
        contact, turns = contact.turned(felt, left, said.time, _CONTACT)
        for k, on, since in turns:
            if not on:
                said.add(k, "contact_off", "contact has ended", since=since)
                continue
            position, force = np.asarray(found[k].position).tolist(), float(found[k].force)
            text = f"contact: {Status(status[k]).name.lower()}"
            said.add(k, "contact_on", text, since=since, position=position, force=force)
        return contact, bool(turns)

    def _slip(self, risk: Switch, slip: Switch, decision: Any, said: _Said) -> tuple[Switch, Switch]:
        verdict = decision.verdict.tolist()
        if not (risk.on or slip.on or _AT_RISK in verdict or _SLIPS in verdict):
            return (risk if not risk.run else Switch()), (slip if not slip.run else Switch())
        slides, holds = [one == _SLIPS for one in verdict], [one == _HOLDS for one in verdict]
        doubtful = [one in (_SLIPS, _AT_RISK) for one in verdict]
        risk, risks = risk.turned(doubtful, holds, said.time, _SLIP_RISK)
        slip, slips = slip.turned(slides, [one in (_HOLDS, _AT_RISK) for one in verdict], said.time, _SLIP)
        for kind, text, turns in (("slip_risk", "it may slip", risks), ("slip", "it slips", slips)):
            for k, on, since in turns:
                if on:
                    ratio, chance = float(decision.ratio[k]), float(decision.probability[k])
                    told = f"{text}, probability {chance:.2g}: the drag is {100 * ratio:.0f} % of what friction holds"
                    said.add(k, kind, told, since=since, ratio=ratio, probability=chance)
        return risk, slip

    def _overload(self, overload: Switch, wide: BoolArray | None, found: Any, said: _Said) -> Switch:
        if wide is None and self.most is None and not (overload.on or overload.run):
            return overload
        much: BoolArray = np.zeros(said.time.size, dtype=bool)
        if wide is not None:
            much = np.asarray(wide.any(axis=-1))
        if self.most is not None:
            much = much | (found.force > self.most)
        overload, turns = overload.turned(much.tolist(), (~much).tolist(), said.time, _OVERLOAD)
        for k, on, since in turns:
            if not on:
                continue
            beyond = [] if wide is None else [self.names[i] for i in np.flatnonzero(self._live)[wide[k]]]
            what = f"beyond the range of {', '.join(beyond)}" if beyond else f"more than {self.most:g}"
            said.add(k, "overload", f"overload: {what}", since=since, sensors=beyond)
        return overload

    def _sensors(
        self, sensors: tuple[Switch, ...], gone: BoolArray, frozen: BoolArray, said: _Said
    ) -> tuple[Switch, ...]:
        left = []
        for i, one in enumerate(sensors):
            missing = gone[:, i].tolist()
            switch, turns = one.turned(missing, [not lost for lost in missing], said.time, _SENSOR)
            for k, on, since in turns:
                why = ("stands still" if frozen[k, i] else "no reading") if on else "reads again"
                kind = "sensor_lost" if on else "sensor_back"
                said.add(k, kind, f"sensor {self.names[i]}: {why}", since=since, sensor=self.names[i])
            left.append(switch)
        return tuple(left)
