"""What a calibrated finger leaves unexplained, and how far its numbers, and the positions that it finds, are off."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
import numpy.typing as npt

from .._check import FloatArray
from .._frozen import Frozen
from .correlated import Correlated, Residuals, correlated, scatter

__all__ = ["Misfit", "Uncertainty", "misfit_of", "neighbours"]

_SIGMA = 4.0
"""Standard errors by which a correlation has to differ from that of noise: by chance, one calibration in 15 000."""
_LOST = 1 / 3
"""A misfit of a share s of the readings' own spread moves a position by about s depths, for readings change within a
depth. At a third, three standard errors are a whole depth: positions are lost."""
_SLIGHT = 0.1
"""Below a tenth of the readings' spread the positions are good to a tenth of a depth, whatever the model."""
_STRETCH = 2.0
"""A drawing knows the depth at least to this factor."""
_TIMES = 3.0
"""Residuals as many times as large as the stated noise are none, structured or not."""
_UNEQUAL = 0.5
"""Share of the squared misfit that a load of its own for each touch has to take away, to be what is wrong."""


@dataclass(frozen=True)
class Misfit:
    """What the fitted finger does not explain of the touches used.

    Parameters
    ----------
    share : float
        Standard deviation of the residuals over that of the readings about each sensor's mean [-]: sqrt(1 - R^2).
    over_noise : float
        Size of the residuals over the noise that the finger had before [-]; NaN where it had none.
    along : float
        Correlation of each sensor's residuals at neighbouring touches [-]; of noise, about 0.
    across : float
        Root mean square of the correlations between neighbouring sensors' residuals [-].
    structured : bool
        Whether either is larger than noise makes it, by 4 standard errors: then it is the model that does not fit.
    unequal : float
        Spread of the loads, as a share of their mean, where every touch was taken to carry the same load and a load of
        its own for each touch would take away more than half of the misfit; else 0.
    stretched : str
        Which length of the finger has gone to an end of its range or to twice or half the drawn one; "" for none.
    """

    share: float
    over_noise: float
    along: float
    across: float
    structured: bool
    unequal: float
    stretched: str

    @property
    def wrong(self) -> bool:
        """Whether the model is not that of the touches: no noise, and of a third of the readings' spread.

        Residuals are no noise where they are structured, or more than 3 times as large as the noise that is stated.

        A tenth is enough where a length of the finger has been stretched, or where loads are not alike.
        """
        limit = _SLIGHT if self.stretched or self.unequal else _LOST
        return (self.structured or self.unequal > 0 or self.over_noise > _TIMES) and self.share > limit

    @property
    def verdict(self) -> str:
        """One sentence on how far the model is the skin's."""
        size = f"the residuals are {100 * self.share:.2g} % of the readings' spread"
        if self.over_noise > 0:
            size += f" and {self.over_noise:.2g} times the stated noise"
        if self.wrong and self.unequal:
            return f"the touches do not carry the same load (it varies by {100 * self.unequal:.0f} %): {size}"
        if self.wrong:
            stretched = f", and {self.stretched}" * bool(self.stretched)
            return f"this is no elastic skin like the one drawn: {size}, and they are not noise{stretched}"
        if self.structured:
            return (
                f"the model does not quite fit: {size}, and those of neighbouring touches are correlated "
                f"({self.along:.2f}); the standard errors allow for it"
            )
        return f"the model fits: {size}, and they look like noise"


def misfit_of(
    rest: FloatArray,
    model: FloatArray,
    positions: FloatArray,
    noise: FloatArray,
    *,
    share: float,
    over_noise: float,
    stretched: str,
    alike: bool,
) -> Misfit:
    """Judge residuals `rest` of the `model` without its offsets, both (m, n) and NaN where there is no reading.

    `noise` (n,) is the size of each sensor's residuals. `alike` says that every touch was taken to carry the same load.
    """
    scaled = rest / noise
    one, next_ = neighbours(positions)
    along, sigma = _together(scaled[one], scaled[next_])
    pairs = [_together(a, b) for a, b in zip(scaled.T[:-1], scaled.T[1:], strict=True)]
    pairs = [pair for pair in pairs if np.isfinite(pair[0])]
    across = float(np.sqrt(np.mean([r**2 for r, _ in pairs]))) if pairs else 0.0
    # a sum of squares of as many standard normal numbers, by its mean and standard deviation
    excess = (sum(s**2 for _, s in pairs) - len(pairs)) / np.sqrt(2 * len(pairs)) if pairs else 0.0
    structured = sigma > _SIGMA or excess > _SIGMA**2 / np.sqrt(2)
    unequal = _unequal(rest, model, noise) if alike else 0.0
    return Misfit(share, over_noise, float(along), across, bool(structured), unequal, stretched)


def neighbours(positions: FloatArray) -> tuple[npt.NDArray[np.intp], npt.NDArray[np.intp]]:
    """Touches that are neighbours: one after the other along a row; on an area each and the nearest, once."""
    if positions.ndim == 1:
        order = np.argsort(positions, kind="stable")
        return order[:-1], order[1:]
    from scipy.spatial import KDTree

    nearest = np.asarray(KDTree(positions).query(positions, k=2)[1])[:, 1]
    pairs = np.unique(np.sort(np.stack([np.arange(len(positions)), nearest], axis=-1), axis=1), axis=0)
    return pairs[:, 0], pairs[:, 1]


def stretched(name: str, drawn: float, found: float, at_end: bool) -> str:
    """In words, whether the length `name` has left what the drawing may mean; "" where it has not."""
    if at_end:
        return f"{name} ends at {found:.3g} m, the end of its range"
    if not drawn / _STRETCH < found < drawn * _STRETCH:
        return f"{name} ends at {found:.3g} m, drawn as {drawn:.3g} m"
    return ""


def _together(a: FloatArray, b: FloatArray) -> tuple[float, float]:
    """The correlation of residuals of mean 0, and how many standard errors of noise that is."""
    both: npt.NDArray[np.bool_] = np.isfinite(a) & np.isfinite(b)
    a, b = a[both], b[both]
    size = float(np.sqrt((a @ a) * (b @ b)))
    if not size > 0:
        return 0.0, 0.0
    r = float(a @ b) / size
    return r, r * np.sqrt(a.size)


def _unequal(rest: FloatArray, model: FloatArray, noise: FloatArray) -> float:
    """Spread of the loads that fit each touch best, where they take away most of the misfit; else 0."""
    seen = np.isfinite(rest) & np.isfinite(model)
    e, h = (np.where(seen, values / noise, 0.0) for values in (rest, model))
    power = (h * h).sum(axis=1)
    told = power > (h * h).sum() / len(h) / 16  # a touch out of the sensors' reach says nothing of its load
    if told.sum() < 3:
        return 0.0
    change = (e * h).sum(axis=1)[told] / power[told]
    gained, all_of_it = float((change**2 * power[told]).sum()), float((e[told] ** 2).sum())
    # a fitted load takes one of each touch's readings away even where there is only noise
    expected = 1 / np.maximum(seen[told].sum(axis=1).mean(), 1)
    spread = float(np.std(change))
    return spread if gained > (expected + (1 - expected) * _UNEQUAL) * all_of_it and spread > _SLIGHT else 0.0


_CHANCE = 1e-3
"""With which noise alone leaves larger residuals."""
_MOST = 2000
"""Residuals from which errors of positions are worked out, at most."""
_STEP = 1e-3
"""Of a depth, by which a load is moved to see the readings change."""
_ROUNDING = 1e-9
"""Of the largest reading, up to which what a fit leaves is rounding."""


class Uncertainty(Frozen):
    """Covariance of what was fitted: of the residuals' noise, or of a process where they are more than that.

    Residuals are noise unless a process explains them much better. Where they are few and larger than the stated noise,
    they are what the model misses, and a field's misfit is smooth: a process even where too few touches show it.

    `fit` is a `fit.Fit` that is solved; it makes this, so its file is not imported here.
    """

    def __init__(self, fit: Any) -> None:
        self._fit = fit
        self.array = fit.forward.apply(fit.p).array
        jacobian = fit.jacobian(fit.positions, fit.load)[fit.seen]
        self.size = np.linalg.norm(jacobian, axis=0)
        self.size[self.size == 0] = 1.0
        self.jacobian = jacobian / self.size
        # of what is known beforehand: how it changes with the numbers fitted, and how far they are off it
        self.known, self.known_rest = np.zeros((0, self.size.size)), np.zeros(0)
        if "gain" in fit.names:
            slopes, first = fit.alike.slopes(fit.gain), fit.forward.size
            self.known, self.known_rest = np.zeros((len(slopes), self.size.size)), fit.alike.rest(fit.gain)
            self.known[:, first : first + fit.gain.size] = slopes
            self.known /= self.size
        self.prior = self.known.T @ self.known
        values, vectors = np.linalg.eigh(self.jacobian.T @ self.jacobian + self.prior)
        known = values > 1e-13 * values[-1]
        # what the readings say nothing of has an infinite variance, not none
        self._blind = (vectors[:, ~known] ** 2).sum(axis=1) > 1e-6
        self._inverse = (vectors[:, known] / values[known]) @ vectors[:, known].T

    @cached_property
    def _on_finger(self) -> tuple[FloatArray, FloatArray]:
        """The touches' positions and loads on the finger."""
        fit = self._fit
        at, load = fit.forward.moved(fit.p, fit.origin, fit.positions, fit.load)
        return np.asarray(at), np.asarray(load)

    @property
    def moved(self) -> FloatArray:
        """The touches' positions on the finger, (m,) or (m, 2)."""
        return self._on_finger[0]

    @cached_property
    def residuals(self) -> Residuals:
        """Of all readings of the fit, in noises."""
        fit = self._fit
        touch, sensor = np.nonzero(fit.seen)
        rest = (fit.rest / fit.noise)[fit.seen]
        slopes = self.slopes(*self._on_finger)[touch, sensor]
        return self.of_model(rest, self.moved[touch], sensor, slopes, touch)

    def slopes(self, positions: FloatArray, load: FloatArray) -> FloatArray:
        """What `Residuals` call slopes, of all sensors under touches on the finger, (m, n, 5); of a row, 0."""
        fit = self._fit
        out = np.zeros((len(positions), fit.noise.size, 5))
        if positions.ndim == 2:
            out[..., :4] = (fit.gain / fit.noise)[:, None] * fit.forward.slopes(fit.p, positions, load)
            out[..., 4] = self.level / fit.noise
        return out

    @property
    def level(self) -> FloatArray:
        """Errors that sensors have in common go with their stated noise, (n,); without one, with their residuals."""
        fit = self._fit
        return np.asarray(np.where((fit.stated > 0).all(), fit.stated, fit.noise))

    def of_model(
        self,
        value: FloatArray,
        y: FloatArray,
        sensor: npt.NDArray[np.intp],
        slopes: FloatArray | None = None,
        touch: npt.NDArray[np.intp] | None = None,
    ) -> Residuals:
        """Residuals `value` (k,) of the sensors `sensor` (k,) at touches at `y` (k,), or (k, 2), on the finger.

        Without `touch` they are those of touches to come, each of another.
        """
        touch = -1 - np.arange(len(value)) if touch is None else touch
        slopes = np.zeros((len(value), 5)) if slopes is None else slopes
        sensors = np.asarray(self.array.y) if y.ndim == 1 else self.array.points
        depth = float(np.mean(np.asarray(self.array.depth)))
        at = (y - sensors[sensor]) / depth
        weight = self._fit.gain / self._fit.noise
        weight = weight / max(float(np.sqrt(np.mean(weight**2))), 1e-300)
        return Residuals(value, sensor, at, weight[sensor], touch, slopes, sensors[sensor] / depth)

    @cached_property
    def noise_like(self) -> bool:
        """Whether the residuals are no larger than the noise that was stated; True where none was."""
        from scipy.special import chdtri

        fit = self._fit
        stated = np.where(fit.stated > 0, fit.stated, np.inf)
        rest = (fit.rest / stated)[fit.seen]
        return bool(rest @ rest <= chdtri(fit.spare, _CHANCE))

    @cached_property
    def process(self) -> Correlated | None:
        """How residuals go together over neighbouring touches; None where they are noise, or but rounding."""
        fit = self._fit
        if (fit.noise <= _ROUNDING * np.abs(np.where(fit.seen, fit.data, 0.0)).max(axis=0)).all():
            return None
        return correlated(self.residuals, self.jacobian, noise_like=self.noise_like)

    @cached_property
    def covariance(self) -> FloatArray:
        """Of all parameters, (p, p): those of the forward model, then gains, offsets and lifts."""
        covariance = self._inverse
        if self.process is not None:
            seen = scatter(self.process, self.residuals, self.jacobian)
            covariance = covariance @ (seen + self.prior) @ covariance
        covariance = np.array(covariance)
        covariance[self._blind, self._blind] = np.inf
        return np.asarray(covariance / np.outer(self.size, self.size))

    def of_positions(self, y: FloatArray) -> FloatArray:
        """Standard errors of positions at `y` (k,) [m] over those of independent noise, (2, k): straight, leaning.

        Of loads as large as those of the touches, whose misfit is no larger and no smaller.

        A position's error is linear in the misfit of the new touch and in that of the touches of the fit, which have
        moved the parameters. Both are of one process: in a gap of the calibration they do not go together.
        """
        fit, process = self._fit, self.process
        if process is None:
            return np.ones((2, len(y)))
        rows = self.residuals.thinned(_MOST)
        old, n = self.residuals[rows], fit.noise.size
        # parameters change by this of each residual of the fit
        gained = self._inverse @ self.jacobian[rows].T * (len(self.jacobian) / len(rows))
        among = process.misfit(old, old)
        step = _STEP * float(np.mean(np.asarray(fit.finger.array.depth)))
        force = float(np.median(np.hypot(*fit.load.T)))
        normal, tangential = (np.tile(load, (len(y), 1)) for load in ([force, 0.0], [0.0, force]))
        origin, scale = fit.forward.origin(fit.p, fit.origin), fit.gain / fit.noise
        new = fit.jacobian(y + origin, normal) / self.size
        down, along = (fit.forward.unit(fit.p, y, load) * scale for load in (normal, tangential))
        moved = [fit.forward.unit(fit.p, y + h, normal) * scale for h in (step, -step)]
        out = np.empty((2, len(y)))
        for k, at in enumerate(y):
            here = self.of_model(np.zeros(n), np.full(n, at), np.arange(n))
            between, own = process.misfit(here, old), process.misfit(here, here)
            columns = [(moved[0][k] - moved[1][k]) / (2 * step), down[k], along[k]]
            for i, count in enumerate((2, 3)):
                unknown = np.stack(columns[:count], axis=-1)
                unknown = unknown / np.maximum(np.linalg.norm(unknown, axis=0), 1e-300)
                to_position = np.linalg.pinv(unknown)[0]
                of_fit = -(to_position @ new[k]) @ gained
                beforehand = to_position @ new[k] @ self._inverse @ self.known.T
                square = process.noise**2 * (to_position @ to_position + of_fit @ of_fit) + beforehand @ beforehand
                square += to_position @ own @ to_position + 2 * to_position @ between @ of_fit + of_fit @ among @ of_fit
                out[i, k] = np.sqrt(max(square, 0.0) / (to_position @ to_position))
        return out
