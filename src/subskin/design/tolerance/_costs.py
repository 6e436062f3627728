"""What one source of error costs, and what all of them do together."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from statistics import NormalDist
from typing import Any

import numpy as np

from ..._check import FloatArray
from ...errors import InvalidValueError, SubskinError
from ...finger import Finger
from .._common import widest
from ._study import Located, Study
from .sources import SOURCES, TOLD, Cost, Source, as_made, of_each_sensor

_TRIES = 1000
_STEP = 1e-3
"""Of the differences by a sensor's position or depth, in amounts."""


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
        spread, linear = SOURCES[name].spread, self.linear(name, amount)
        if spread in ("sensor", "reading"):
            found = self.study.locate(self._drawn({name: amount}, self.rng(name)))
            return self.summed_up(name, amount, found, self.largest(found.errors), linear)
        near = wide = self._beside(name, amount)
        if spread == "finger":
            wide = self._beside(name, self._far * amount)
        return self.summed_up(name, amount, near, self.sizes(wide.errors).max(axis=0), linear)

    def together(self, amounts: Mapping[str, float]) -> Cost:
        """All sources at once, by drawing fingers and frames."""
        found = self.study.locate(self._drawn(amounts, self.rng("together")))
        return self.summed_up("together", np.nan, found, self.largest(found.errors))

    def lost(self, amounts: Mapping[str, float], draws: int) -> float:
        """The share of frames that is not OK with all sources at once, of so many fingers drawn as in `together`."""
        return float(1 - self.study.ok(self._drawn(amounts, self.rng("together"), draws)).mean())

    def _beside(self, name: str, amount: float) -> Located:
        return joined(self.study.locate(self.study.readings(made)) for made in self.sides(name, amount))

    def _drawn(self, amounts: Mapping[str, float], rng: np.random.Generator, draws: int | None = None) -> FloatArray:
        """Readings of fingers and frames drawn at random, shape (draws, p, a, n); (1, p, a, n) if all are the same."""
        readings, count = self.drawn_readings[None], self.draws if draws is None else draws
        if any(SOURCES[name].spread != "reading" for name in amounts):
            readings = self.study.readings_of([self.finger(amounts, rng) for _ in range(count)])
        return self.with_reading_errors(readings, amounts, rng, count)

    def with_reading_errors(
        self, readings: FloatArray, amounts: Mapping[str, float], rng: np.random.Generator, draws: int
    ) -> FloatArray:
        """Readings with the noise and the steps that `amounts` name, shape (draws, p, a, n) where there is noise."""
        array = self.study.finger.array
        if "noise" in amounts:
            size = of_each_sensor(array.noise, amounts["noise"])
            readings = readings + size * rng.standard_normal((draws, *self.drawn_readings.shape))
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
            seen = f"{name} off by {amount:.6g}"
            raise InvalidValueError(seen, f"no such finger ({refused.seen}: {refused.rule})", "a smaller one")
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
                    off[name] = each * rng.standard_normal(self.size_of(name))
            try:
                return as_made(self.study.finger, off)
            except SubskinError as error:
                refused = error
        seen, fix = ", ".join(f"{name} = {amount:.6g}" for name, amount in amounts.items()), "smaller tolerances"
        raise InvalidValueError(seen, f"hardly a finger is off like that ({refused.seen}: {refused.rule})", fix)

    def size_of(self, name: str) -> tuple[int, ...]:
        """Shape of what each sensor has of its own of a source: on an area a position is off along y and along z."""
        n = len(self.study.finger.array)
        return (n, 2) if name == "position" and self.study.dim == 2 else (n,)

    def sizes(self, errors: FloatArray) -> FloatArray:
        """Magnitudes (..., t) of errors (..., k), in the order of `Study.told`."""
        every = [np.linalg.norm(errors[..., part], axis=-1) for part in self.study.told.values()]
        return np.stack(every, axis=-1)

    def largest(self, errors: FloatArray) -> FloatArray:
        """What the quantile of the draws stays within at each touch, shape (p, a, t)."""
        size = np.sort(self.sizes(errors), axis=0)  # frames without an answer last
        rank = np.ceil(self.quantile * np.isfinite(size).sum(axis=0)).astype(np.intp) - 1
        return np.asarray(np.take_along_axis(size, np.maximum(rank, 0)[None], axis=0)[0])

    def linear(self, name: str, amount: float) -> FloatArray:
        """Covariance of the errors at each touch, (p, a, k, k), to first order; infinite where singular.

        Of what is one number of the finger, the mean over both sides that it can be off to.
        """
        study, array = self.study, self.study.finger.array
        spread, readings = SOURCES[name].spread, self.drawn_readings
        if spread in ("finger", "fixed"):
            changes = [study.readings(made) - readings for made in self.sides(name, amount)]
            moved = [np.einsum("pakn,pan->pak", self.slope, c) for c in changes]
            square = np.mean([m[..., :, None] * m[..., None, :] for m in moved], axis=0)
        else:
            if name in ("position", "depths"):
                changes = []
                for along in np.eye(2)[:, None] if len(self.size_of(name)) == 2 else [1.0]:
                    ends = [study.readings(as_made(study.finger, {name: s * along})) for s in _to_sides(amount)]
                    changes.append((ends[0] - ends[1]) * (0.5 / _STEP))
            elif name == "gains":
                changes = [amount * (readings - np.asarray(array.offset))]
            elif name == "resolution":
                changes = [of_each_sensor(array.resolution, amount) / np.sqrt(12)]
            else:
                changes = [of_each_sensor(array.noise, amount)]
            changes = [np.broadcast_to(change, readings.shape) for change in changes]
            each = sum(np.square(change) for change in changes)  # sensors are off independently
            square = np.einsum("pakn,pajn,pan->pakj", self.slope, self.slope, each)
        moves = np.any([np.abs(c).max(axis=-1) > 0 for c in changes], axis=0)
        square[self.singular & moves] = np.inf
        return np.asarray(square)

    def spread(self, square: FloatArray) -> FloatArray:
        """Standard deviations (..., t) of covariances (..., k, k), of a position in its worst direction."""
        return np.stack([widest(square[..., part, part]) for part in self.study.told.values()], axis=-1)

    def summed_up(
        self, name: str, amount: float, found: Located, worst: FloatArray, linear: FloatArray | None = None
    ) -> Cost:
        """A row of the budget; `worst` (p, a, t) is the error at each touch, `linear` as from the method."""
        told, k = self.study.told, found.errors.shape[-1]
        errors, top = found.errors.reshape(-1, k), worst.reshape(-1, len(told))
        errors, top = (e[np.isfinite(e).all(axis=1)] for e in (errors, top))
        nothing = np.full(len(told), np.nan)
        columns = {
            "rms": np.sqrt((self.sizes(errors) ** 2).mean(axis=0)) if len(errors) else nothing,
            "worst": top.max(axis=0) if len(top) else nothing,
            "linear": nothing,
        }
        if linear is not None:
            each = np.diagonal(linear, axis1=-2, axis2=-1).mean(axis=(0, 1))
            columns["linear"] = np.sqrt([each[part].sum() for part in told.values()])
        values = {
            f"{what}_{kind}": float(v) for kind, column in columns.items() for what, v in zip(told, column, strict=True)
        }
        source = SOURCES.get(name, Source("", "finger", ""))
        return Cost(name, amount, source.unit, source.spread, **values, lost=float(1 - found.ok.mean()))


def _to_sides(amount: float) -> tuple[float, float]:
    """Steps of a difference by an amount."""
    return _STEP * amount, -_STEP * amount


def joined(parts: Iterable[Located]) -> Located:
    """Several located sets as one, along a new first axis."""
    located = list(parts)
    return Located(np.stack([e.errors for e in located]), np.stack([e.ok for e in located]))


def combined(rows: Sequence[Cost]) -> Cost:
    """The root of the sum of squares of each column; frames that are lost do not add up like that."""
    names = [f"{what}_{kind}" for what in TOLD for kind in ("rms", "worst", "linear")]
    values = {name: float(np.sqrt(sum(getattr(row, name) ** 2 for row in rows))) for name in names}
    return Cost("total", np.nan, "", "finger", **values, lost=np.nan)
