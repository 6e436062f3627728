"""What a calibrated finger leaves unexplained: noise, a model that does not quite fit, or no such skin."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from .._check import FloatArray

__all__ = ["Misfit", "misfit_of", "neighbours"]

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
