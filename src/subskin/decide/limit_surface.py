"""What friction holds of a drag and a moment about the normal together, on a round contact.

A contact that is about to slip turns about a point at the distance c from its middle, in its own half widths; there it
slides everywhere, and friction mu p points against each point's own motion (Goyal, Ruina, Papadopoulos, Wear 143
(1991) 307). With the pressure p of unit load on the disc of radius 1, and K and E the complete elliptic integrals of
the parameter 4 r c / (r + c)^2,

    T / (mu N)   = (2 / c) integral from 0 to 1 of p r [(r + c) E - (r - c) K] dr
    M / (mu N a) =      2 integral from 0 to 1 of p r [(r + c) E + (r - c) K] dr

are the ends of what is held. All c make a curve; every drag and moment within it is held (docs/slip.md).
"""

from __future__ import annotations

from functools import lru_cache
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from .. import _check
from .._check import FloatArray

__all__ = ["drag_held", "effective_drag", "friction_arm", "moment_held", "slipping_about"]

_NODES, _GRADE = 40, 3
"""Gauss and Legendre's nodes of a stretch, and the power by which they crowd to an end where a logarithm stands."""
_POINTS = 1500


class _Curve(NamedTuple):
    """The curve of one pressure; drag and moment in shares of what is held of each alone."""

    arm: float
    turn: FloatArray  # angle of (drag, moment), ascending, on [0, pi / 2]
    reach: FloatArray  # the distance from (0, 0) there
    drag: FloatArray  # over sqrt(1 - moment^2), at even steps of the moment
    moment: FloatArray  # over sqrt(1 - drag^2), at even steps of the drag


# of p r dr with r = sin u, the loads being 1: the rim's root goes with dr
_PRESSURES = {
    "hertz": lambda u: 1.5 / np.pi * np.sin(u) * np.cos(u) ** 2,
    "punch": lambda u: 0.5 / np.pi * np.sin(u),
    "wedge": lambda u: np.arccosh(1 / np.sin(u)) / np.pi * np.sin(u) * np.cos(u),
}
_ARMS = {"hertz": 3 * np.pi / 16, "punch": np.pi / 4, "wedge": np.pi / 6}


def friction_arm(contact: str = "hertz") -> float:
    """The largest moment that friction holds without a drag, over mu N a, a being the half width.

    Parameters
    ----------
    contact : {"hertz", "punch", "wedge"}, optional
        The pressure of a round body, of a flat disc, or of a cone.

    Raises
    ------
    InvalidValueError
        Another contact.

    Examples
    --------
    >>> from subskin.decide import friction_arm
    >>> round(friction_arm("hertz"), 4), round(friction_arm("punch"), 4)
    (0.589, 0.7854)
    """
    _check.choice("contact", contact, _ARMS)  # of some width: a line holds no moment
    return float(_ARMS[contact])


def slipping_about(centre: npt.ArrayLike, contact: str = "hertz") -> FloatArray:
    """Drag over mu N and moment over mu N a of a contact that slips while it turns about a point, shape (..., 2).

    Parameters
    ----------
    centre : array_like, shape (...)
        Distance of that point from the middle, in half widths [-], > 0.
    contact : {"hertz", "punch", "wedge"}, optional
        As in `friction_arm`.

    Raises
    ------
    InvalidValueError
        A distance that is not > 0, another contact.

    Examples
    --------
    >>> from subskin.decide import slipping_about
    >>> slipping_about(0.5).round(4).tolist()
    [0.5522, 0.4556]
    """
    from scipy.special import ellipe, ellipk

    friction_arm(contact)
    c = _check.real("centre", centre, above=0.0)[..., None]
    s, w = np.polynomial.legendre.leggauss(_NODES)
    s, w = 0.5 * (1 + s), 0.5 * w
    centre_at = np.arcsin(np.minimum(c, 1.0))
    near, share = s**_GRADE, _GRADE * w * s ** (_GRADE - 1)
    # stretches from the middle, where a cone's pressure is infinite, and to both sides of the centre
    half, rest = 0.5 * centre_at, np.pi / 2 - centre_at
    u = np.concatenate([half * near, centre_at - half * near, centre_at + rest * near], axis=-1)
    weight = np.concatenate([half * share, half * share, rest * share], axis=-1)
    r = np.sin(u)
    k = np.minimum(4 * r * c / (r + c) ** 2, 1 - 1e-16)
    first, second = (r + c) * ellipe(k), (r - c) * ellipk(k)
    load = 2 * _PRESSURES[contact](np.maximum(u, 1e-300)) * weight
    drag, moment = (load * (first - second)).sum(axis=-1) / c[..., 0], (load * (first + second)).sum(axis=-1)
    return _check.read_only(np.stack([drag, moment], axis=-1))


@lru_cache(maxsize=4)
def _curve(contact: str) -> _Curve:
    t = np.linspace(0.0, 1.0, _POINTS)[1:-1]
    ends = slipping_about((t / (1 - t)) ** 2, contact)
    x = np.concatenate([[0.0], np.minimum(ends[:, 0], 1.0), [1.0]])
    m = np.concatenate([[1.0], np.minimum(ends[:, 1] / _ARMS[contact], 1.0), [0.0]])
    even = np.linspace(0.0, 1.0, _POINTS)

    def over(at: FloatArray, values: FloatArray) -> FloatArray:
        """The ratio values / sqrt(1 - at^2), of ascending `at`, at even steps; at the end as just before it."""
        inside = at < 1 - 1e-9
        ratio = values[inside] / np.sqrt((1 - at[inside]) * (1 + at[inside]))
        return np.asarray(np.interp(even, at[inside], ratio))

    turn, reach = np.arctan2(m, x), np.hypot(x, m)
    return _Curve(_ARMS[contact], turn[::-1].copy(), reach[::-1].copy(), over(m[::-1], x[::-1]), over(x, m))


def effective_drag(tangential: FloatArray, turning: FloatArray, contact: str) -> FloatArray:
    """The drag alone that is as near to slipping: mu N reaches it where friction gives way.

    tangential: |T| [N]; turning: |M| / (arm a) [N].
    """
    curve = _curve(contact)
    size = np.hypot(tangential, turning)
    return np.asarray(size / np.interp(np.arctan2(turning, tangential), curve.turn, curve.reach))


def drag_held(hold: FloatArray, turning: FloatArray, contact: str) -> FloatArray:
    """The largest |T| [N] that is held beside a moment, |M| / (arm a) = `turning` [N], where `hold` is mu N."""
    return _held(hold, turning, _curve(contact).drag)


def moment_held(hold: FloatArray, tangential: FloatArray, contact: str) -> FloatArray:
    """The largest |M| / (arm a) [N] that is held beside a drag |T| = `tangential` [N], where `hold` is mu N."""
    return _held(hold, tangential, _curve(contact).moment)


def _held(hold: FloatArray, other: FloatArray, ratio: FloatArray) -> FloatArray:
    share = np.divide(
        other, hold, out=np.full(np.broadcast_shapes(np.shape(hold), np.shape(other)), 2.0), where=hold > 0
    )
    at = np.minimum(share, 1.0) * (_POINTS - 1)
    cell = np.minimum(at.astype(np.intp), _POINTS - 2)
    rise = ratio[cell] + (at - cell) * (ratio[cell + 1] - ratio[cell])
    return np.asarray(hold * rise * np.sqrt(np.maximum((1 - share) * (1 + share), 0.0)))
