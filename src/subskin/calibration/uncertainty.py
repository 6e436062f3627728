"""How far the numbers of a fit are off, and the positions that its finger finds."""

from __future__ import annotations

from functools import cached_property
from typing import Any

import numpy as np
import numpy.typing as npt

from .._check import FloatArray
from .._frozen import Frozen
from .correlated import Correlated, Residuals, correlated, scatter

__all__ = ["Uncertainty"]

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
        values, vectors = np.linalg.eigh(self.jacobian.T @ self.jacobian)
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
            covariance = covariance @ scatter(self.process, self.residuals, self.jacobian) @ covariance
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
                square = process.noise**2 * (to_position @ to_position + of_fit @ of_fit)
                square += to_position @ own @ to_position + 2 * to_position @ between @ of_fit + of_fit @ among @ of_fit
                out[i, k] = np.sqrt(max(square, 0.0) / (to_position @ to_position))
        return out
