"""The least normal force that keeps a held object from slipping: what a gripper must do."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from .. import _check
from .._check import FloatArray
from ..errors import GeometryError, InvalidValueError
from ..estimate import Estimate
from ._cone import forces_of, levels
from .friction import Friction, density_of, friction_of

__all__ = ["least_force"]


def least_force(
    estimate: Estimate,
    friction: Friction | float,
    probability: float = 1e-3,
    *,
    rise: npt.ArrayLike = 0.0,
    rise_std: npt.ArrayLike = 0.0,
) -> FloatArray:
    """The least normal force at which the probability of slip is no more than a bound.

    The normal force alone is changed: the tangential load is the one estimated, or what it is predicted to be, and the
    errors of both are kept. Their covariance does not depend on how hard, readings being linear in the load. Source:
    docs/slip.md.

    Parameters
    ----------
    estimate : Estimate
        The load estimated, shape (...).
    friction : Friction or float
        What is known of the coefficient.
    probability : float, optional
        The largest probability of slip allowed, in (0, 1).
    rise : array_like, shape (...), optional
        What T changes by until the grip has followed [N/m]: its rate of rise times the time that this takes.
    rise_std : array_like, shape (...), optional
        Standard deviation of that [N/m].

    Returns
    -------
    ndarray, shape (...)
        Normal force [N/m], to 1e-10 of itself; on an area [N], to 1e-6. Infinite where friction may be 0
        with more than this probability; NaN where there is no load to hold, or none was estimated.

    Raises
    ------
    InvalidValueError, GeometryError
        A probability out of range, shapes that do not match.

    Examples
    --------
    Without errors to speak of it is |T| / mu:

    >>> import numpy as np, subskin as ss
    >>> skin = ss.HalfPlane(ss.Material(young=0.4e6))
    >>> finger = ss.Finger(skin, ss.SensorArray.line(count=6, pitch=1.5e-3, depth=2e-3, noise=1e-8))
    >>> found = finger.locate(finger.read(ss.LineLoad(force=40.0, angle=0.3, position=0.8e-3)))
    >>> round(float(ss.decide.least_force(found, 0.5)), 2), round(float(40 * np.sin(0.3) / 0.5), 2)
    (23.64, 23.64)
    """
    mu = friction_of(friction)
    bound = _check.scalar("probability", probability, above=0.0, fix="probability=1e-3")
    if not bound < 1:
        raise InvalidValueError(f"probability = {bound:.6g}", "has to be < 1", "probability=1e-3")
    change = _check.real("rise", rise, unit="N/m")
    spread = _check.real("rise_std", rise_std, unit="N/m", at_least=0.0)
    load, told, edge = forces_of(estimate)
    shape = estimate.shape
    _fits("rise", change, shape)
    _fits("rise_std", spread, shape)
    out = np.full(told.size, np.nan)
    index = np.flatnonzero(told & ~edge)
    if index.size:
        covariance = np.array(load.covariance)
        covariance[..., 1, 1] += spread**2
        load = load.with_(tangential=load.tangential + change)._replace(covariance=covariance).at(index)
        edges, masses = density_of(mu, shape, index)
        out[index] = levels(load, edges, masses, bound, by_ratio=False)
    return _check.read_only(out.reshape(shape))


def _fits(name: str, values: FloatArray, shape: tuple[int, ...]) -> None:
    if _check.broadcast(**{name: values, "estimate": np.empty(shape)}) != shape:
        seen = f"{name} of shape {values.shape}, frames of shape {shape}"
        raise GeometryError(seen, "one for each, or one for all", f"{name}=0.0")
