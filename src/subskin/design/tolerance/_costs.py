"""What one source of error costs, and what all of them do together."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from statistics import NormalDist
from typing import Any

import numpy as np

from ..._check import FloatArray
from ...errors import InvalidValueError, SubskinError
from ...finger import Finger
from ._study import Located, Study
from .cost import Cost
from .sources import SOURCES, Source, as_made, of_each_sensor

_TRIES = 1000
_STEP = 1e-3
"""Of the differences by a sensor's position or depth, in amounts."""
_TOLD = ("position", "force", "angle")


class Costs:
    """Costs of sources on a study's touches, by as many drawn fingers or frames as `draws`.

    The worst errors hold for a `quantile` of these. Each source has its own random numbers from `root`, so that a row
    does not depend on the others.
    """

    def __init__(self, study: Study, draws: int, quantile: float, root: int) -> None:
        self.study, self.draws, self.quantile, self.root = study, draws, quantile, root
        self.drawn_readings = study.readings(study.finger)
        self.slope, self.singular = study.slope()
        self._far = NormalDist().inv_cdf(0.5 * (1 + quantile))

    def rng(self, name: str, *more: int) -> np.random.Generator:
        """Random numbers of a source's own."""
        return np.random.default_rng([self.root, [*SOURCES, "together"].index(name), *more])

    def cost(self, name: str, amount: float) -> Cost:
        """What the source costs if it is off by `amount`; refused where no finger can be off by as much."""
        spread = SOURCES[name].spread
        linear = np.sqrt((self.linear(name, amount) ** 2).mean(axis=(0, 1)))
        if spread in ("sensor", "reading"):
            found = self.study.locate(self._drawn({name: amount}, self.rng(name)))
            return summed_up(name, amount, found, self.largest(found.errors), linear)
        near = wide = self._beside(name, amount)
        if spread == "finger":
            wide = self._beside(name, self._far * amount)
        return summed_up(name, amount, near, np.abs(wide.errors).max(axis=0), linear)

    def together(self, amounts: Mapping[str, float]) -> Cost:
        """All sources at once, by drawing fingers and frames."""
        found = self.study.locate(self._drawn(amounts, self.rng("together")))
        return summed_up("together", np.nan, found, self.largest(found.errors))

    def _beside(self, name: str, amount: float) -> Located:
        return joined(self.study.locate(self.study.readings(made)) for made in self.sides(name, amount))

    def _drawn(self, amounts: Mapping[str, float], rng: np.random.Generator) -> FloatArray:
        """Readings of fingers and frames drawn at random, shape (draws, p, a, n); (1, p, a, n) if all are the same."""
        readings = self.drawn_readings[None]
        if any(SOURCES[name].spread != "reading" for name in amounts):
            readings = self.study.readings_of([self.finger(amounts, rng) for _ in range(self.draws)])
        return self.with_reading_errors(readings, amounts, rng)

    def with_reading_errors(
        self, readings: FloatArray, amounts: Mapping[str, float], rng: np.random.Generator
    ) -> FloatArray:
        """Readings with the noise and the steps that `amounts` name, shape (draws, p, a, n) where there is noise."""
        array = self.study.finger.array
        if "noise" in amounts:
            size = of_each_sensor(array.noise, amounts["noise"])
            readings = readings + size * rng.standard_normal((self.draws, *self.drawn_readings.shape))
        if "resolution" in amounts:
            step = of_each_sensor(array.resolution, amounts["resolution"])
            readings = np.round(readings / step) * step
        return readings

    def sides(self, name: str, amount: float) -> list[Finger]:
        """The finger off by the amount to either side; one of them where the other cannot be."""
        out: list[Finger] = []
        for value in (amount,) if SOURCES[name].spread == "fixed" else (amount, -amount):
            try:
                out.append(as_made(self.study.finger, {name: value}))
            except SubskinError as error:
                refused = error
        if not out:
            raise InvalidValueError(
                f"{name} off by {amount:.6g}", f"no such finger ({refused.seen}: {refused.rule})", "a smaller one"
            )
        return out

    def finger(self, amounts: Mapping[str, float], rng: np.random.Generator) -> Finger:
        """A finger drawn at random; drawn again where there is no such finger."""
        array = self.study.finger.array
        for _ in range(_TRIES):
            off: dict[str, Any] = {}
            for name, amount in amounts.items():
                spread = SOURCES[name].spread
                if spread == "fixed":
                    off[name] = amount
                elif spread == "finger":
                    off[name] = amount * rng.standard_normal()
                elif spread == "sensor":
                    each = of_each_sensor(array.noise, amount) if name == "offset" else amount
                    off[name] = each * rng.standard_normal(len(array))
            try:
                return as_made(self.study.finger, off)
            except SubskinError as error:
                refused = error
        raise InvalidValueError(
            ", ".join(f"{name} = {amount:.6g}" for name, amount in amounts.items()),
            f"hardly a finger is off like that ({refused.seen}: {refused.rule})",
            "smaller tolerances",
        )

    def largest(self, errors: FloatArray) -> FloatArray:
        """What the quantile of the draws stays within at each touch, shape (p, a, 3)."""
        size = np.sort(np.abs(errors), axis=0)  # frames without an answer last
        rank = np.ceil(self.quantile * np.isfinite(size).sum(axis=0)).astype(np.intp) - 1
        return np.asarray(np.take_along_axis(size, np.maximum(rank, 0)[None], axis=0)[0])

    def linear(self, name: str, amount: float) -> FloatArray:
        """RMS errors at each touch, (p, a, 3), to first order in the readings; infinite where singular."""
        study, array = self.study, self.study.finger.array
        spread, readings = SOURCES[name].spread, self.drawn_readings
        if spread in ("finger", "fixed"):
            changes = [study.readings(made) - readings for made in self.sides(name, amount)]
            square = np.mean([np.einsum("pakn,pan->pak", self.slope, c) ** 2 for c in changes], axis=0)
        else:
            if name in ("position", "depths"):
                step = _STEP * amount
                ends = [study.readings(as_made(study.finger, {name: s})) for s in (step, -step)]
                change = (ends[0] - ends[1]) * (0.5 / _STEP)
            elif name == "gains":
                change = amount * (readings - np.asarray(array.offset))
            elif name == "resolution":
                change = of_each_sensor(array.resolution, amount) / np.sqrt(12)
            else:
                change = of_each_sensor(array.noise, amount)
            changes = [np.broadcast_to(change, readings.shape)]
            square = np.einsum("pakn,pan->pak", self.slope**2, changes[0] ** 2)
        moved = np.any([np.abs(c).max(axis=-1) > 0 for c in changes], axis=0)
        square[self.singular & moved] = np.inf
        return np.asarray(np.sqrt(square))


def joined(parts: Iterable[Located]) -> Located:
    """Several located sets as one, along a new first axis."""
    located = list(parts)
    return Located(np.stack([e.errors for e in located]), np.stack([e.ok for e in located]))


def summed_up(name: str, amount: float, found: Located, worst: FloatArray, linear: FloatArray | None = None) -> Cost:
    """A row of the budget; `worst` (p, a, 3) is the error at each touch."""
    nothing = np.full(3, np.nan)
    errors, top = (e.reshape(-1, 3)[np.isfinite(e.reshape(-1, 3)).all(axis=1)] for e in (found.errors, worst))
    columns = {
        "rms": np.sqrt((errors**2).mean(axis=0)) if len(errors) else nothing,
        "worst": top.max(axis=0) if len(top) else nothing,
        "linear": nothing if linear is None else linear,
    }
    values = {
        f"{what}_{kind}": float(v) for kind, column in columns.items() for what, v in zip(_TOLD, column, strict=True)
    }
    source = SOURCES.get(name, Source("", "finger", ""))
    return Cost(name, amount, source.unit, source.spread, **values, lost=float(1 - found.ok.mean()))


def combined(rows: Sequence[Cost]) -> Cost:
    """The root of the sum of squares of each column; frames that are lost do not add up like that."""
    names = [f"{what}_{kind}" for what in _TOLD for kind in ("rms", "worst", "linear")]
    values = {name: float(np.sqrt(sum(getattr(row, name) ** 2 for row in rows))) for name in names}
    return Cost("total", np.nan, "", "finger", **values, lost=np.nan)
