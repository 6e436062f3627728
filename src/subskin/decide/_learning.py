"""What slips and holds say of friction: the likelihood of each cell of its density."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from .._check import FloatArray
from ..errors import InvalidValueError
from ._cone import Forces, cells_beyond, widths

__all__ = ["check_possible", "posterior"]

_APART = 6.0
"""Standard deviations beyond all that was believed at which something seen is refused."""


def posterior(
    edges: FloatArray, before: FloatArray, loads: list[tuple[Forces, npt.NDArray[np.bool_], bool]]
) -> FloatArray:
    """Masses after the events, shape (frictions, k)."""
    with np.errstate(divide="ignore"):
        logs = np.log(before)
        for load, tells, slid in loads:
            for event in range(tells.shape[1]):
                here = Forces(*(np.where(tells[:, event], v[:, event], 1.0) for v in load))
                seen = _slip_density(here, edges) if slid else np.maximum(1 - cells_beyond(here, edges), 0.0)
                logs = logs + np.where(tells[:, event, None], np.log(seen), 0.0)
    top = logs.max(axis=-1, keepdims=True)
    if not np.isfinite(top).all():
        row = int(np.argmin(np.isfinite(top[:, 0])))
        raise InvalidValueError(
            f"slips and holds that no one friction from {edges[row, 0]:.3g} to {edges[row, -1]:.3g} would show",
            "what was seen has to be possible under what was believed",
            "a wider range, or the status and the noise of the estimates",
        )
    masses = np.exp(logs - top)
    return np.asarray(masses / masses.sum(axis=-1, keepdims=True))


def check_possible(load: Forces, tells: npt.NDArray[np.bool_], slid: bool, edges: FloatArray) -> None:
    """Raise where a slip or a hold lies more than _APART standard deviations from all that was believed."""
    for mu, steeper in ((edges[:, -1:], True), *([(edges[:, :1], False)] if slid else [])):
        away = np.abs(load.tangential) - mu * load.normal
        side = np.sign(load.tangential)
        spread = np.sqrt(np.maximum(load.tt - 2 * side * mu * load.nt + mu**2 * load.nn, 0.0))
        with np.errstate(invalid="ignore"):
            bad = tells & ((away if steeper else -away) > _APART * spread + 1e-9 * np.abs(load.tangential))
        if bad.any():
            row, event = (int(i) for i in np.argwhere(bad)[0])
            seen = abs(load.tangential[row, event]) / load.normal[row, event]
            raise InvalidValueError(
                f"a {'slip' if slid else 'hold'} at |T|/N = {seen:.3g}",
                f"no friction from {edges[row, 0]:.3g} to {edges[row, -1]:.3g} would show it, "
                f"to {_APART:g} standard deviations",
                "a wider range, or a look at the status and the noise of the estimates",
            )


def _slip_density(load: Forces, edges: FloatArray) -> FloatArray:
    """Mean over each cell of mu of the density of what was measured, had it slid: T = mu N to either side, any N."""
    from scipy.special import ndtr

    total: FloatArray = np.zeros(())
    for side in (1.0, -1.0):
        spread = widths(load, edges, side)
        z = (side * load.tangential[..., None] - edges * load.normal[..., None]) / spread
        low, high = z[..., 1:], z[..., :-1]
        # from the nearer tail, so that small differences keep their digits
        flip = np.where(low + high > 0, -1.0, 1.0)
        a, b = np.minimum(flip * low, flip * high), np.maximum(flip * low, flip * high)
        close = b - a < 1e-6
        bell = np.exp(-0.5 * np.minimum(np.abs(0.5 * (a + b)), 40.0) ** 2) / np.sqrt(2 * np.pi)
        mean = np.where(close, bell, (ndtr(b) - ndtr(a)) / np.where(close, 1.0, b - a))
        total = total + mean / (0.5 * (spread[..., 1:] + spread[..., :-1]))
    return np.asarray(total)
