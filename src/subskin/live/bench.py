"""Calibrating at the bench, touch by touch: what is asked of the person, and what comes of it. No input, no output."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import numpy.typing as npt

from .. import _check
from .._check import FloatArray
from ..calibration import Calibration, calibrate, next_touch
from ..calibration.known import explained, fitted
from ..errors import ConvergenceError, GeometryError, InvalidValueError
from ..estimate import Status
from ..finger import Finger
from ..io.finger_file import FingerFile
from .session import BenchState, Said

__all__ = ["Bench"]

_TOUCHED, _FREE = 8.0, 5.0
"""Noises of the strongest sensor beyond which the skin is touched, and within which it is free."""
_SURE = 3
"""Frames one after the other that say so."""
_STEADY, _BACK = 0.02, 0.1
"""Share of a touch's strongest reading: by which its halves may differ, and within which the skin has come back."""
_RESTLESS = 3.0
"""How much larger than from frame to frame a deviation may be at rest."""
_FEWEST = 20
"""Frames from which a noise is measured."""
_DOUBT = 2.0
"""Spare readings a sensor before the accuracy counts."""


class Bench:
    r"""A calibration as it is made: at rest for the noise, then one touch after the other, each where it helps most.

    The bench never changes: what it knows of a session is the state that goes in and comes out of `step`.

    Parameters
    ----------
    file : FingerFile
        The finger as drawn, and how it locates.
    candidates : array_like, shape (k,) or (k, 2)
        Where touches can be made, on their own axis [m]; (y, z) of sensors on an area.
    force : float, optional
        Load of each touch [N/m or N]; without it all are taken as alike, and forces found are multiples of it.
    fit : sequence of str, optional
        What is fitted, as in `calibrate`; by default gain, depth and origin.
    accuracy : float
        Error of positions that is wanted [m].
    rest : float
        Time at rest, for the noise [s].
    hold : float
        Time that a touch has to be held [s].
    most : int
        Touches after which the session ends.

    Raises
    ------
    InvalidValueError, GeometryError
        No candidate, numbers that are not positive, candidates of another shape.

    Examples
    --------
    >>> import numpy as np, subskin as ss
    >>> text = "[skin]\nyoung = 4e5\n[sensors]\ncount = 5\npitch = 3e-3\ndepth = 3e-3\nnoise = 1e-4"
    >>> file = ss.io.parse_finger(text)
    >>> bench = Bench(file, np.linspace(-6e-3, 6e-3, 13), force=40.0, rest=0.3, hold=0.1, accuracy=0.2e-3)
    >>> state, said = bench.start()
    >>> rng, time = np.random.default_rng(0), 0.0
    >>> while state.phase != "done":
    ...     load = 40.0 if state.phase in ("touch", "hold") else 0.0
    ...     frames = file.finger.read(ss.LineLoad(np.full(10, load), position=state.asked or 0.0), rng)
    ...     state, more = bench.step(state, frames, time + 0.01 * np.arange(10))
    ...     said, time = said + more, time + 0.1
    >>> said[0].kind, said[-1].kind, state.error < 0.2e-3
    ('rest', 'reached', True)
    """

    def __init__(
        self,
        file: FingerFile,
        candidates: npt.ArrayLike,
        *,
        force: float | None = None,
        fit: Sequence[str] | None = None,
        accuracy: float = 0.2e-3,
        rest: float = 2.0,
        hold: float = 0.5,
        most: int = 60,
    ) -> None:
        array = file.finger.array
        self.candidates = _check.real("candidates", candidates, unit="m")
        shape = (2,) if array.on_area else ()
        if not self.candidates.size or self.candidates.ndim != 1 + len(shape) or self.candidates.shape[1:] != shape:
            rule = "positions (y, z), one a row, are needed" if shape else "a list of positions is needed"
            raise GeometryError(
                f"candidates of shape {self.candidates.shape}", rule, "candidates=np.linspace(-6e-3, 6e-3, 13)"
            )
        self.file, self.fit = file, file.of_differences().to_fit(("gain", "depth", "origin") if fit is None else fit)
        self.force = None if force is None else _check.scalar("force", force, above=0.0)
        limits = {"accuracy": accuracy, "rest": rest, "hold": hold, "most": most}
        for name, value in limits.items():
            _check.scalar(name, value, above=0.0)
        self.accuracy, self.rest, self.hold, self.most = accuracy, rest, hold, int(most)
        self._live = np.asarray(array.live)
        # readings are differences from the free skin: without a range, and without offsets
        free = replace(array, low=-np.inf, high=np.inf, offset=0.0)
        self._drawn = replace(file.finger, array=free)

    def start(self) -> tuple[BenchState, tuple[Said, ...]]:
        """The state of a session that begins, and what is said first."""
        n = len(self._live)
        positions = np.empty((0, 2) if self.candidates.ndim == 2 else 0)
        state = BenchState("rest", np.empty((0, n)), positions, kept=np.empty((0, n)))
        return state, (Said("rest", f"hands off for {self.rest:g} s: the noise is measured", {"rest": self.rest}),)

    def step(
        self, state: BenchState, readings: npt.ArrayLike, time: npt.ArrayLike
    ) -> tuple[BenchState, tuple[Said, ...]]:
        """Take the next frames.

        Parameters
        ----------
        state : BenchState
            What the frames before left.
        readings : array_like, shape (m, n)
            Frames in SI, their offsets in them [reading]; frames with a missing reading are left out.
        time : array_like, shape (m,)
            Time of each [s].

        Returns
        -------
        state : BenchState
            For the next frames.
        said : tuple of Said
            What the person is told now, in order.

        Raises
        ------
        GeometryError
            Frames of another number of sensors.
        InvalidValueError
            A sensor without noise, where none is measured either.
        """
        frames = _check.real("readings", readings, finite=False)
        clock = _check.real("time", time, unit="s")
        if frames.ndim != 2 or frames.shape[1] != self._live.size or clock.shape != frames.shape[:1]:
            rule = f"frames of the {self._live.size} sensors, and a time for each, are needed"
            raise GeometryError(f"readings of shape {frames.shape}", rule, "readings (m, n), time (m,)")
        said: list[Said] = []
        whole = np.isfinite(frames[:, self._live]).all(axis=-1)
        for frame, now in zip(frames[whole], clock[whole].tolist(), strict=True):
            if state.phase == "done":
                break
            state = getattr(self, f"_{state.phase}")(state, frame, now, said)
        return state, tuple(said)

    def again(self, state: BenchState) -> tuple[BenchState, tuple[Said, ...]]:
        """Take the last touch back, and ask for it once more.

        Parameters
        ----------
        state : BenchState
            Of the session.
        """
        if not len(state.positions):
            return state, (Said("again", "there is no touch to take back"),)
        last = state.positions[-1]
        left = replace(state, readings=state.readings[:-1], positions=state.positions[:-1])
        found, error = self._fitted(left)
        where = last if self.candidates.ndim == 2 else float(last)
        left = replace(left, found=found, error=error, redo=where)
        if state.phase == "touch":
            return self._ask(left)
        text = f"touch {len(left.positions) + 1} is taken back: lift"
        return replace(left, phase="lift", run=0, time=np.empty(0), kept=state.kept[:0]), (Said("again", text),)

    def skip(self, state: BenchState) -> tuple[BenchState, tuple[Said, ...]]:
        """Ask for another position: the one asked for cannot be reached.

        Parameters
        ----------
        state : BenchState
            Of the session.
        """
        if state.asked is None or state.phase not in ("touch", "hold"):
            return state, (Said("skip", "no touch is asked for now: nothing to skip"),)
        left = replace(state, skipped=(*state.skipped, state.asked), redo=None)
        if len(left.skipped) >= len(self.candidates):
            return self.end(left)
        if state.phase == "touch":
            return self._ask(left)
        left = replace(left, phase="lift", run=0, time=np.empty(0), kept=state.kept[:0])
        return left, (Said("skip", f"{_where(state.asked)} is left out: lift"),)

    def end(self, state: BenchState) -> tuple[BenchState, tuple[Said, ...]]:
        """End the session with the touches that there are.

        Parameters
        ----------
        state : BenchState
            Of the session.
        """
        count = len(state.positions)
        text = f"ended after {count} touches: positions are off by {_size(state.error)}; wanted {_size(self.accuracy)}"
        return replace(state, phase="done"), (Said("ended", text, {"touches": count, "error": state.error}),)

    def result(self, state: BenchState, *, accept_misfit: bool = False) -> Calibration:
        """The calibration on all touches taken.

        Parameters
        ----------
        state : BenchState
            Of the session.
        accept_misfit : bool, optional
            As in `calibrate`.

        Raises
        ------
        ConvergenceError
            As `calibrate`: too few touches, or touches that are not those of such a finger.
        """
        count = len(state.positions)
        if count < 2:
            raise ConvergenceError(f"{count} touches", "a calibration needs at least two", "run it again, and go on")
        return calibrate(
            self._measured(state),
            state.readings,
            state.positions,
            fit=self.fit,
            force=self.force,
            load=self.file.load,
            accept_misfit=accept_misfit,
        )

    def _rest(self, state: BenchState, frame: FloatArray, now: float, said: list[Said]) -> BenchState:
        state = _longer(state, frame, now)
        if now - state.time[0] < self.rest or len(state.time) < _FEWEST:
            return state
        from_frame_to_frame = np.diff(state.kept, axis=0).std(axis=0) / np.sqrt(2)
        noise, live = state.kept.std(axis=0, ddof=1), self._live
        if (noise[live] > _RESTLESS * from_frame_to_frame[live] + 1e-12 * np.abs(state.kept[0, live])).any():
            worst = self.file.names[int(np.argmax(np.where(live, noise / (from_frame_to_frame + 1e-300), 0)))]
            said.append(Said("restless", f"the skin is not at rest ({worst} moves): hands off, once more"))
            return replace(state, time=np.empty(0), kept=state.kept[:0])
        stated = np.asarray(self.file.finger.array.noise)
        still = live & (noise == 0)
        if (still & ~(stated > 0)).any():
            name = self.file.names[int(np.argmax(still))]
            rule = "it does not move at rest, and the file states no noise"
            raise InvalidValueError(f"sensor {name}", rule, "noise = ... under [sensors]: half a step of its converter")
        noise = np.where(still, stated, noise)
        values = {"noise": noise.tolist(), "stated": np.broadcast_to(stated, noise.shape).tolist()}
        with np.errstate(divide="ignore"):
            ratio = float(np.median((noise / stated)[live]))
        known = f", {ratio:.2g} times what the file states" if np.isfinite(ratio) else ""
        said.append(Said("noise", f"noise measured in {len(state.time)} frames{known}", values))
        state = replace(state, noise=noise, zero=state.kept.mean(axis=0), phase="touch", run=0)
        state, more = self._ask(state)
        said += more
        return state

    def _touch(self, state: BenchState, frame: FloatArray, now: float, said: list[Said]) -> BenchState:
        run = state.run + 1 if self._level(state, frame) > _TOUCHED else 0
        if run < _SURE:
            return replace(state, run=run)
        said.append(Said("hold", f"hold it for {self.hold:g} s"))
        return replace(state, phase="hold", run=0, time=np.empty(0), kept=state.kept[:0], peak=0.0)

    def _hold(self, state: BenchState, frame: FloatArray, now: float, said: list[Said]) -> BenchState:
        level = self._level(state, frame)
        run = state.run + 1 if level < _FREE else 0
        if run >= _SURE:
            said.append(Said("short", f"too short, or not steady: touch {_where(state.asked)} again"))
            return replace(state, phase="touch", run=0)
        state = replace(_longer(state, frame, now), run=run, peak=max(level, state.peak))
        if now - state.time[0] < self.hold or len(state.time) < 2 * _SURE:
            return state
        if not self._steady(state):
            quarter = len(state.time) // 4
            return replace(state, time=state.time[quarter:], kept=state.kept[quarter:])
        assert state.zero is not None
        reading = state.kept.mean(axis=0) - state.zero
        state = replace(
            state, readings=np.vstack([state.readings, reading]), time=np.empty(0), kept=state.kept[:0],
            positions=np.concatenate([state.positions, np.asarray(state.asked)[None]]), phase="lift", run=0,
        )  # fmt: skip
        found, error = self._fitted(state)
        count = len(state.positions)
        text = f"touch {count} at {_where(state.asked)} taken: lift"
        said.append(Said("taken", text, {"readings": reading.tolist()}))
        if found is not None:
            values = {"r2": found.r2, "error": error, "touches": count, "doubts": list(found.doubts)}
            text = f"R^2 {found.r2:.5f}; positions are off by {_size(error)}, wanted {_size(self.accuracy)}"
            said.append(Said("calibrated", text, values))
        return replace(state, found=found, error=error)

    def _lift(self, state: BenchState, frame: FloatArray, now: float, said: list[Said]) -> BenchState:
        if self._level(state, frame) > max(_FREE, _BACK * state.peak):
            return replace(state, time=np.empty(0), kept=state.kept[:0])
        state = _longer(state, frame, now)
        if now - state.time[0] < self.hold or len(state.time) < 2 * _SURE or not self._steady(state):
            return state
        state = replace(state, zero=state.kept.mean(axis=0), phase="touch", run=0)
        if self._reached(state):
            values = {"touches": len(state.positions), "error": state.error}
            text = f"reached: positions are off by {_size(state.error)} after {len(state.positions)} touches"
            said.append(Said("reached", text, values))
            return replace(state, phase="done")
        state, more = self._ask(state) if len(state.positions) < self.most else self.end(state)
        said += more
        return state

    def _ask(self, state: BenchState) -> tuple[BenchState, tuple[Said, ...]]:
        """Where the next touch helps most, or the one that is to be made again."""
        if state.redo is not None:
            text = f"touch {len(state.positions) + 1} once more: at {_where(state.redo)}"
            values = {"position": np.asarray(state.redo).tolist()}
            return replace(state, asked=state.redo, redo=None), (Said("touch", text, values),)
        left = [p for p in self.candidates if not any(np.array_equal(p, s) for s in state.skipped)]
        finger, origin = (self._measured(state), self._origin()) if state.found is None else (
            self._alive(state.found), state.found.origin
        )  # fmt: skip
        chosen = next_touch(
            finger, state.positions, left, fit=self.fit, force=self.force or 1.0, origin=origin, targets=self.candidates
        )
        at = chosen.position
        text = f"touch {len(state.positions) + 1}: at {_where(at)}"
        return replace(state, asked=at), (Said("touch", text, {"position": np.asarray(at).tolist()}),)

    def _fitted(self, state: BenchState) -> tuple[Calibration | None, float]:
        """The finger as the touches so far make it, and the error of positions that is left."""
        try:
            touches = (self._measured(state), state.readings, state.positions)
            solution = fitted(*touches, fit=self.fit, force=self.force, load=self.file.load)
            found = explained(solution, accept_misfit=True)
        except ConvergenceError:  # too few touches for so many numbers
            return None, float("nan")
        options: dict[str, Any] = {"fit": self.fit, "force": self.force or 1.0, "origin": found.origin}
        ahead = next_touch(self._alive(found), state.positions, self.candidates, **options)
        located = replace(self.file, finger=found.finger, origin=found.origin).locate(state.readings)
        fine = np.asarray(located.status) == Status.OK
        off = np.asarray(located.position)[fine] - found.on_finger(state.positions)[fine]
        own = float(np.sqrt(np.mean(np.sum(np.atleast_2d(off.T) ** 2, axis=0)))) if fine.any() else np.inf
        return found, float(np.hypot(ahead.error, own))

    def _alive(self, found: Calibration) -> Finger:
        """What was found, for the next proposal: a sensor that seemed dead is given another chance."""
        array = found.finger.array
        gain = np.where(np.asarray(array.gain) == 0, np.asarray(self._drawn.array.gain), np.asarray(array.gain))
        plain = Finger(found.finger.skin, replace(array, gain=gain, low=-np.inf, high=np.inf))
        return plain

    def _reached(self, state: BenchState) -> bool:
        found = state.found
        enough = found is not None and state.redo is None and found.spare >= _DOUBT * int(self._live.sum())
        return enough and state.error <= self.accuracy

    def _measured(self, state: BenchState) -> Finger:
        """The finger as drawn, with the noise that was measured."""
        assert state.noise is not None
        noise = np.where(self._live, state.noise, np.asarray(self._drawn.array.noise))
        return replace(self._drawn, array=replace(self._drawn.array, noise=noise))

    def _origin(self) -> Any:
        return np.zeros(2) if self.candidates.ndim == 2 and not np.ndim(self.file.origin) else self.file.origin

    def _level(self, state: BenchState, frame: FloatArray) -> float:
        """How far the strongest sensor is from the free skin, in noises."""
        assert state.zero is not None
        assert state.noise is not None
        return float(np.abs((frame - state.zero) / state.noise)[self._live].max())

    def _steady(self, state: BenchState) -> bool:
        """Whether both halves of what is kept are alike."""
        assert state.noise is not None
        half = len(state.time) // 2
        moved = np.abs(state.kept[half:].mean(axis=0) - state.kept[:half].mean(axis=0)) / state.noise
        return bool((moved[self._live] < max(4 * 2 / np.sqrt(len(state.time)), _STEADY * state.peak)).all())


def _longer(state: BenchState, frame: FloatArray, now: float) -> BenchState:
    return replace(state, time=np.append(state.time, now), kept=np.vstack([state.kept, frame]))


def _where(at: Any) -> str:
    """A position as a person reads it."""
    return ", ".join(f"{name} = {1e3 * value:.2f} mm" for name, value in zip("yz", np.atleast_1d(at), strict=False))


def _size(error: float) -> str:
    return "an unknown amount" if not np.isfinite(error) else f"{1e3 * error:.3f} mm"
