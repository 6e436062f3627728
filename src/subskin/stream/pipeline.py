"""Stages one after the other: from raw frames to what touched."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy.typing as npt

from .. import _check
from ..errors import InvalidValueError
from .stage import Stage, both_of, check_state

__all__ = ["Pipeline"]


@dataclass(frozen=True, eq=False)
class Pipeline(Stage[dict[str, Any], dict[str, Any]]):
    """Stages, each of which takes what the one before it makes of the frames.

    The usual order is: readings in SI units, relaxation undone, drift taken off, and an answer (a `Locator`, say).
    `subskin.io.FingerFile.pipeline` makes one from a finger file. A pipeline is a stage itself: `step` goes on with a
    stream, a call takes a whole recording. Both give what came out of each stage, by its name.

    Where a stage gives each reading a doubt, as `Undoing` does, what follows takes it as `doubt` if its `takes_doubt`
    says so, as of `Tare` and of a `Locator` of a row; other answers get the readings alone.

    Parameters
    ----------
    stages : mapping of str to Stage or callable
        The stages by their names, in their order. What is called with readings alone is a stage without a state.

    Raises
    ------
    InvalidValueError
        No stage, or something that is none.

    Examples
    --------
    >>> import numpy as np, subskin as ss
    >>> skin = ss.HalfPlane(ss.Material(young=0.4e6))
    >>> finger = ss.Finger(skin, ss.SensorArray.line(count=5, pitch=1.5e-3, depth=2e-3, noise=1e-4))
    >>> time = np.arange(0.0, 4.0, 0.01)
    >>> raw = finger.read(ss.LineLoad(40.0 * (time > 2.0), position=0.3e-3), np.random.default_rng(0)) + 0.07
    >>> pipeline = ss.Pipeline({"tare": ss.Tare(finger), "found": finger.locator()})
    >>> out = pipeline(raw, time)
    >>> out["tare"].free[[0, -1]].tolist(), f"{1e3 * np.median(out['found'].position[-100:]):.2f} mm"
    ([True, False], '0.30 mm')
    >>> state, first = pipeline.step(None, raw[:150], time[:150])  # the same, as the frames come
    >>> state, second = pipeline.step(state, raw[150], time[150])
    >>> bool(second["tare"].offset[0] == out["tare"].offset[150, 0])
    True
    """

    stages: Mapping[str, Stage[Any, Any] | Callable[[Any], Any]]

    def __post_init__(self) -> None:
        if not isinstance(self.stages, Mapping) or not self.stages:
            raise InvalidValueError(
                f"stages = {_check.shown(self.stages)}",
                "stages by their names are needed",
                'Pipeline({"found": locator})',
            )
        for name, stage in self.stages.items():
            if not callable(stage):
                raise InvalidValueError(
                    f'stage "{name}" = {_check.shown(stage)}',
                    "a Stage, or a call on readings, is needed",
                    "finger.locator()",
                )
        object.__setattr__(self, "stages", dict(self.stages))

    def step(
        self, state: dict[str, Any] | None, readings: npt.ArrayLike, time: npt.ArrayLike | None
    ) -> tuple[dict[str, Any], dict[str, Any]]:
        """Take the next frames of a stream through all stages; as `Stage.step`, by the names of the stages."""
        self._check(state)
        left: dict[str, Any] = {}
        out: dict[str, Any] = {}
        given: Any = readings
        doubt: Any = None
        for name, stage in self.stages.items():
            more = {"doubt": doubt} if doubt is not None and getattr(stage, "takes_doubt", False) else {}
            if isinstance(stage, Stage):
                stepped = stage.step(None if state is None else state[name], given, time, **more)
                left[name], out[name] = both_of(stage, stepped)
            else:
                left[name], out[name] = None, stage(given, **more)
            made = given = out[name]
            left_over = getattr(made, "readings", None)
            if left_over is not None:
                given, doubt = left_over, getattr(made, "doubt", doubt)
        return left, out

    def _check(self, state: dict[str, Any] | None) -> None:
        """Refuse what is no state of these stages."""
        check_state(state, dict)
        if state is not None and state.keys() != self.stages.keys():
            seen, rule = f"a state of {', '.join(map(str, state))}", f"this pipeline has {', '.join(self.stages)}"
            raise InvalidValueError(seen, rule, "a state of this pipeline, or None to start")

    def prepare(self) -> None:
        """Prepare each stage; as `Stage.prepare`."""
        for stage in self.stages.values():
            if isinstance(stage, Stage):
                stage.prepare()

    def resumed(self, state: dict[str, Any] | None) -> dict[str, Any] | None:
        """The state of each stage for a stream that begins anew; as `Stage.resumed`."""
        self._check(state)
        if state is None:
            return None
        left: dict[str, Any] = {}
        for name, stage in self.stages.items():
            left[name] = stage.resumed(state[name]) if isinstance(stage, Stage) else None
        return left
