"""From a device's frames to what touches, how surely, and what happened: one read, one batch."""

from __future__ import annotations

import time as timing
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from .. import _check
from .._check import FloatArray
from .._cold import at_once
from .._frozen import Frozen
from ..decide import Friction, slip
from ..errors import GeometryError, InvalidValueError
from ..finger import Finger
from ..io.finger_file import FingerFile
from ..stream import Pipeline, Tare, Tared
from ..stream.stage import join
from .batch import Batch
from .events import Event, Watch, WatchState
from .frames import ClockMap, ClockState, DeviceFrames, columns_of, factor_of

__all__ = ["COMMANDS", "Chain", "ChainState", "file_of"]

_GAP, _SILENCE = 4.5, 0.25
"""A gap is longer than so many periods of a device with a clock, or so many seconds of one without."""
_STRONG = 200.0
"""Noises that the strongest sensor reads under the touch that a chain is warmed up with."""
_SAID = {
    "zero": "zeroed: nothing touches",
    "mark": "",
    "port_lost": "the port is lost",
    "port_back": "the port is back",
}
"""What is said of a command that comes without a text."""
COMMANDS = tuple(_SAID)
"""What a chain can be asked."""


@dataclass(frozen=True, eq=False)
class ChainState(Frozen):
    """All that is carried from one step of a chain to the next.

    Parameters
    ----------
    pipeline : mapping or None
        State of each stage; None before the first frame.
    clock : ClockState or None
        What is known of the clocks.
    watch : WatchState
        What is known of the events.
    frames : int
        How many there have been.
    period : float
        Time between two of them [s]; NaN before there are two.
    """

    pipeline: dict[str, Any] | None
    clock: ClockState | None
    watch: WatchState
    frames: int = 0
    period: float = np.nan


class Chain(Frozen):
    """What live streams, recordings that are replayed, and robots run: a pipeline with clocks, events and decisions.

    A chain never changes: what it remembers of a stream is the state that goes in and comes out of `step`. The same
    steps give the same bits. The pipeline is the one that `FingerFile.pipeline` makes, of long and local contacts
    alike.

    Parameters
    ----------
    file : FingerFile or Finger
        The finger, how to search with it, and the units of its channels.
    channels : sequence of str, optional
        What the device calls its values, in their order (`driver.channels`). The finger's sensors are found among them
        by their names; without these, or where no name is the same, as many as the finger has are taken in their order.
    fit : str, optional
        Family of contacts whose half width is found too, as in `Finger.fit`; a grip needs "hertz" or "punch". Without
        it `locate` finds lines or points.
    slip : float or (float, float) or Friction, optional
        What is known of the coefficient of friction, a value or a range: slip is then decided frame by frame.
    overload : float, optional
        Force from which a load is an overload [N/m of a line, N of a point].
    drift : float, optional
        Fastest drift, as in `FingerFile.pipeline` [reading/s].
    **options
        Of the locator, as in `FingerFile.locator`: friction, search, load, half_width, outliers, ...

    Raises
    ------
    InvalidValueError, GeometryError
        Channels among which the sensors are not; an option out of range; slip of loads whose drag is not found.

    Examples
    --------
    >>> import numpy as np, subskin as ss
    >>> skin = ss.HalfPlane(ss.Material(young=0.4e6))
    >>> finger = ss.Finger(skin, ss.SensorArray.line(count=6, pitch=1.5e-3, depth=2e-3, noise=1e-4))
    >>> time = np.arange(0.0, 2.0, 0.01)
    >>> raw = finger.read(ss.LineLoad(40.0 * (time > 1.0), position=0.4e-3), np.random.default_rng(0)) + 0.07
    >>> chain, state, events = Chain(finger, slip=(0.4, 0.8)), None, []
    >>> for k, host in enumerate(time):
    ...     state, batch = chain.step(state, DeviceFrames(raw[k : k + 1], device_time=[host]), host + 0.001)
    ...     events += batch.events
    >>> [event.kind for event in events], f"{1e3 * batch.found.position[-1]:.2f} mm"
    (['contact_on'], '0.40 mm')
    """

    def __init__(
        self,
        file: FingerFile | Finger,
        *,
        channels: Sequence[str] | None = None,
        fit: str | None = None,
        slip: float | tuple[float, float] | Friction | None = None,
        overload: float | None = None,
        drift: npt.ArrayLike | None = None,
        **options: Any,
    ) -> None:
        self.file = file = file_of(file)
        given = {"fit": fit, "slip": _plain(slip), "overload": overload, "drift": _plain(drift), **options}
        self.options: Mapping[str, Any] = {name: value for name, value in given.items() if value is not None}
        most = None if overload is None else _check.scalar("overload", overload, above=0.0)
        asked = {} if fit is None else {"family": fit}
        if slip is not None and not {"load", "family"} & {*options, *asked} and file.load is None:
            asked = {"family": "line"}  # whose drag is known; an area takes points for it
        locator = file.locator(**asked, **options)
        self._mu = None if slip is None else _friction(slip)
        if self._mu is not None:
            told = getattr(locator, "layout", None)
            if told is None or told.aside:
                rule = "a row does not tell the drag of a point beside it"
                raise InvalidValueError(f"slip = {slip!r}", rule, 'load="line", or SensorArray.grid(...)')
        self.pipeline: Pipeline = file.pipeline(locator, drift=drift)
        tare = self.pipeline.stages["tare"]
        assert isinstance(tare, Tare)
        self._tare, self._clock = tare, ClockMap()
        self._watch = Watch(tare.finger.array, file.names, most)
        self.channels = file.names if channels is None else _check.several("channels", channels, str, '["p0", "p1"]')
        self._index = columns_of(file, self.channels)
        self._factor = factor_of(file)

    def step(
        self,
        state: ChainState | None,
        frames: DeviceFrames,
        host_time: float,
        command: str = "",
        values: Mapping[str, Any] | None = None,
    ) -> tuple[ChainState, Batch]:
        """Take what one read of a device gave, or a command.

        Parameters
        ----------
        state : ChainState or None
            What the steps before left; None at the beginning.
        frames : DeviceFrames
            What a driver found in the bytes; of a command, no frames.
        host_time : float
            When the last byte arrived, by the host's clock [s].
        command : {"", "zero", "mark", "port_lost", "port_back"}, optional
            "zero": nothing touches, and what is read now are the offsets. "mark": an event with a text. The port's:
            the device is gone, or there again, and its clock may have begun again.
        values : mapping, optional
            With the command: `text`, what the event says.

        Returns
        -------
        state : ChainState
            For the next step; the one that was given is left as it was.
        batch : Batch
            What came of it.

        Raises
        ------
        InvalidValueError, GeometryError
            An unknown command, a command with frames, frames of other channels.
        """
        before = ChainState(None, None, self._watch.start) if state is None else state
        if command:
            return self._commanded(before, frames, host_time, command, dict(values or {}))
        count = len(frames)
        if frames.values.shape[1] != len(self.channels) and count:
            seen, rule = f"frames of {frames.values.shape[1]} values", f"there are {len(self.channels)} channels"
            raise GeometryError(seen, rule, "Chain(file, channels=driver.channels)")
        device = frames.device_time
        clock, pipeline, events = before.clock, before.pipeline, []
        parts = []
        breaks = self._clock.breaks(clock, device, host_time) if count else []
        edges = [0, *(frame for frame, _ in breaks), count]
        for number in range(len(edges) - 1):
            if number:
                clock, pipeline = _again(clock), self.pipeline.resumed(pipeline)
            part = slice(edges[number], edges[number + 1])
            clock, time = self._clock.step(clock, device[part], host_time)
            if number:
                events.append(_reset(breaks[number - 1], device, before, time))
            if time.size:
                picked = frames.values[part] if self._index is None else frames.values[part][:, self._index]
                picked = picked if self._factor is None else picked * self._factor
                pipeline, out = self.pipeline.step(pipeline, picked, time)
                parts.append((time, picked, out["tare"], out["found"]))
        if not parts:
            told = self._lost(frames, before, before.clock, host_time, np.nan)
            empty = self._empty(frames, host_time, before.frames, told)
            return before, empty
        time, picked, tared, found = parts[0] if len(parts) == 1 else _joined(parts)
        decision = None if self._mu is None else slip(found, self._mu)
        watch, happened = self._watch.step(before.watch, picked, tared, found, decision, time, before.frames)
        period, gap = self._paced(before, time, device, bool(breaks))
        events += self._lost(frames, before, clock, float(time[0]), gap)
        events += happened
        left = ChainState.filled(
            {"pipeline": pipeline, "clock": clock, "watch": watch, "frames": before.frames + count, "period": period}
        )
        return left, Batch.filled({
            "time": time, "device_time": device, "sequence": frames.sequence, "raw": frames.values,
            "readings": tared.readings, "free": tared.free, "lost": frames.lost, "bad": frames.bad, "found": found,
            "decision": decision, "events": tuple(events), "host_time": host_time, "first": before.frames,
            "command": "", "values": {},
        })  # fmt: skip

    def prepare(self) -> float:
        """Tabulate and compile all that a stream would otherwise wait for; the seconds that it took."""
        began = timing.perf_counter()
        with at_once():
            self._prepare()
        return timing.perf_counter() - began

    def _prepare(self) -> None:
        self.pipeline.prepare()
        finger, scale = self._tare.finger, 1.0 if self.file.recording is None else self.file.recording.scale
        array = finger.array
        own: FloatArray = np.asarray(array.offset)
        noise = np.where(array.live, np.asarray(self._tare.noise), 1.0)
        middle = array.points.mean(axis=0)
        field = finger.receptive_field(middle if array.on_area else middle[0])[..., 0]
        touch = field * (_STRONG / max(float(np.abs(field / noise)[array.live].max()), 1e-300))
        frames: FloatArray = np.tile(own, (8, 1)) + noise * np.random.default_rng(0).standard_normal((8, own.size))
        frames[3:] += touch
        wide: FloatArray = np.zeros((8, len(self.channels)))
        wide[:, slice(None) if self._index is None else self._index] = np.asarray(
            frames / scale / (1.0 if self._factor is None else self._factor), dtype=np.float64
        )
        # a sensor that is missing: on an area what all of them read is kept then, and another set takes half as long
        wide[7, 0 if self._index is None else self._index[0]] = np.nan
        state: ChainState | None = None
        for first, last in ((0, 1), (1, 3), (3, 4), (4, 8)):
            at = np.linspace(1e-3 * first, 1e-3 * last, last - first, endpoint=False)
            state, _ = self.step(state, DeviceFrames(wide[first:last], at), 1e-3 * last)
        if getattr(self.pipeline.stages.get("relaxation"), "doubted", False):
            answer: Any = self.pipeline.stages["found"]
            if getattr(answer, "takes_doubt", False):
                answer(frames, doubt=np.broadcast_to(noise, frames.shape))

    def _commanded(
        self, before: ChainState, frames: DeviceFrames, host: float, command: str, values: dict[str, Any]
    ) -> tuple[ChainState, Batch]:
        _check.choice("command", command, COMMANDS)
        if len(frames):
            raise InvalidValueError(
                f'"{command}" with {len(frames)} frames', "a command is a step of its own", "first the command"
            )
        text = str(values.get("text", ""))
        pipeline, clock, watch, events = before.pipeline, before.clock, before.watch, []
        if command == "zero":
            changed = None
            if pipeline is not None:
                after = self._tare.zeroed(pipeline["tare"])
                changed = after.offset - pipeline["tare"].offset if after is not None else None
                pipeline = {**pipeline, "tare": after}
            if watch.contact.on:
                events.append(Event("contact_off", host, before.frames, "contact has ended: zeroed"))
            watch = WatchState(sensors=watch.sensors)
            told = {} if changed is None else {"changed": changed.tolist()}
            events.append(Event("zeroed", host, before.frames, text or _SAID[command], told))
        else:
            events.append(Event(command, host, before.frames, text or _SAID[command], values))
        if command == "port_back":
            clock, pipeline = _again(clock), self.pipeline.resumed(pipeline)
        left = ChainState(pipeline, clock, watch, before.frames, before.period)
        return left, self._empty(frames, host, before.frames, events, command, values)

    def _empty(
        self,
        frames: DeviceFrames,
        host: float,
        first: int,
        events: Sequence[Event],
        command: str = "",
        values: Any = None,
    ) -> Batch:
        none, no = np.empty(0), np.empty((0, len(self.file.names)))
        raw = np.empty((0, len(self.channels)))
        return Batch(
            none, none, np.empty(0, dtype=np.int64), raw, no, np.empty(0, dtype=bool), frames.lost, frames.bad,
            events=tuple(events), host_time=host, first=first, command=command, values=values or {},
        )  # fmt: skip

    def _paced(self, before: ChainState, time: FloatArray, device: FloatArray, broken: bool) -> tuple[float, float]:
        """The time between frames, and the longest gap before one of these, NaN where there is none [s]."""
        last = np.nan if before.clock is None else before.clock.time
        period, own = before.period, bool(device[-1] == device[-1])
        if time.size == 1:
            longest = usual = time.item(0) - last
        else:
            longest = max(float((time[1:] - time[:-1]).max()), float(time[0]) - last if last == last else 0.0)
            usual = float(time[-1] - time[0]) / (time.size - 1)
        if broken or longest != longest:
            return period, np.nan
        if longest > (_GAP * period if own and period == period else _SILENCE):
            return period, longest
        share = min(0.5, time.size / 100)
        return (period + share * (min(usual, 4 * period) - period) if period == period else usual), np.nan

    def _lost(
        self, frames: DeviceFrames, before: ChainState, clock: ClockState | None, time: float, gap: float
    ) -> list[Event]:
        """What is missing, in words."""
        values: dict[str, Any] = {"lost": frames.lost, "bad": frames.bad}
        if gap == gap:
            values["seconds"] = gap
        if frames.lost or frames.bad:
            count = f"{frames.lost} frames are" if frames.lost > 1 else "1 frame is"
            parts = [f"{count} lost"] if frames.lost else []
            parts += [f"{frames.bad} came broken"] if frames.bad else []
            return [Event("lost_frames", time, before.frames, ", ".join(parts), values)]
        if gap == gap:
            return [Event("gap", time, before.frames, f"no frame for {gap:.3g} s", values)]
        return []


def file_of(finger: FingerFile | Finger) -> FingerFile:
    """A finger as if it came from a file; its sensors are s0, s1, ...

    Raises
    ------
    InvalidValueError
        Something that is neither.
    """
    if isinstance(finger, FingerFile):
        return finger
    if not isinstance(finger, Finger):
        raise InvalidValueError(f"file = {finger!r}", "a FingerFile or a Finger is needed", 'ss.load("finger.toml")')
    array = finger.array
    return FingerFile(finger, tuple(f"s{i}" for i in range(len(array))), limits=(array.low, array.high))


def _again(clock: ClockState | None) -> ClockState | None:
    return None if clock is None else clock.again()


def _reset(found: tuple[int, float], device: FloatArray, before: ChainState, time: FloatArray) -> Event:
    frame, jump = found
    now = float(device[frame])
    values = {"from": now - jump, "to": now}
    how = "began again" if jump < 0 else "was set"
    text = f"the device's clock {how}: from {now - jump:.3f} s to {now:.3f} s; offsets are kept"
    return Event("reset", float(time[0]), before.frames + frame, text, values)


def _joined(parts: Sequence[tuple[Any, ...]]) -> tuple[FloatArray, FloatArray, Tared, Any]:
    """The parts of a batch in which a device began again, as one."""
    time, picked, tared, found = (join([part[k] for part in parts]) for k in range(4))
    return time, picked, tared, found


def _plain(value: Any) -> Any:
    """An option as a recording can keep it."""
    if isinstance(value, Friction):
        return {"edges": np.asarray(value.edges).tolist(), "masses": np.asarray(value.masses).tolist()}
    return value.tolist() if isinstance(value, np.ndarray) else value


def _friction(given: Any) -> Friction:
    """What is known of the friction, from a value, a range or a density."""
    if isinstance(given, Mapping):
        if set(given) != {"edges", "masses"}:
            rule = "edges and masses make a density"
            raise InvalidValueError(f"slip = {_check.shown(given)}", rule, "slip=(0.4, 0.8)")
        return Friction(**given)
    if isinstance(given, Friction):
        return given
    values = _check.real("slip", given, at_least=0.0, fix="slip=(0.4, 0.8)")
    if values.shape == (2,):
        return Friction.between(float(values[0]), float(values[1]))
    if values.shape != ():
        raise InvalidValueError(
            f"slip = {given!r}", "a coefficient of friction or a range is needed", "slip=(0.4, 0.8)"
        )
    return Friction.known(float(values))
