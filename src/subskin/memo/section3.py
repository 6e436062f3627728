"""Section 3 of the memo: a line load found from three strain sensors (eqs. 12 and 13, Fig. 6).

Here y is the load's position on our axis, with the sensors 1, 2, 3 at -b, 0 and +b, and alpha is the project's
`angle`: positive where the load drags the skin towards +y. `subskin.memo.three_sensor` solves these equations.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.polynomial import polynomial
from numpy.typing import ArrayLike

from .. import _check
from .._check import FloatArray
from .._declared import Length, checked
from ..errors import GeometryError
from ._symbols import described, given

__all__ = ["FIGURE_6", "Figure6", "eq12", "eq13", "eq13_coefficients"]


class Figure6(NamedTuple):
    """The example of Fig. 6, lengths in one unit and forces in units of E times that length.

    `depth` and `pitch` of the sensors; the readings as `printed`, positive in compression: the negative of what (12)
    gives; position `y`, inclination `alpha` [rad] and `P` / E of the load whose readings, rounded, are printed.

    Examples
    --------
    >>> FIGURE_6.pitch / FIGURE_6.depth
    0.8333333333333334
    """

    depth: float
    pitch: float
    printed: tuple[float, float, float]
    y: float
    alpha: float
    P: float


FIGURE_6 = Figure6(3.0, 2.5, (-0.048, 0.18, 0.19), y=1.5, alpha=-np.pi / 8, P=2 * np.pi / 3)
"""Fig. 6 as printed, and the round numbers behind it: found by reconstruction, not given in the memo."""


@described
def eq12(P: ArrayLike, alpha: ArrayLike, y: ArrayLike, x: ArrayLike, b: ArrayLike, E: ArrayLike) -> FloatArray:
    """Equation (12): what three sensors at depth x and pitch b read under a line load.

    With t = y + b, y, y - b for the sensors 1, 2, 3: eps = -3 P [x cos(alpha) - t sin(alpha)] [x^2 - t^2] /
    (2 pi E [x^2 + t^2]^2), shape (..., 3), tension positive.

    Examples
    --------
    The example of Fig. 6, with its sign turned.

    >>> six = FIGURE_6
    >>> eq12(six.P, six.alpha, six.y, six.depth, six.pitch, E=1.0).round(5).tolist()
    [0.04819, -0.17844, -0.19112]
    """
    P, alpha, y, x, b, E = given(P=P, alpha=alpha, y=y, x=x, b=b, E=E)
    if not (x > 0).all():
        seen = f"x = {float(x.min()):.6g}"
        raise GeometryError(seen, "the sensors lie beneath the surface", "x > 0 is their depth")
    readings = []
    for t in (y + b, y, y - b):
        top = -3 * P * (x * np.cos(alpha) - t * np.sin(alpha)) * (x**2 - t**2)
        readings.append(top / (2 * np.pi * E * (x**2 + t**2) ** 2))
    return np.stack(np.broadcast_arrays(*readings), axis=-1)


@described
def eq13(eps_x: ArrayLike, y: ArrayLike, x: ArrayLike, b: ArrayLike) -> FloatArray:
    """Equation (13): the polynomial in the load's position that vanishes where three readings agree, as printed.

    f(y) = 2 eps_2 [x^2 + y^2]^2 [x^2 - (y-b)^2] [x^2 - (y+b)^2] - eps_1 [x^2 + (y+b)^2]^2 [x^2 - y^2] [x^2 - (y-b)^2]
    - eps_3 [x^2 + (y-b)^2]^2 [x^2 - y^2] [x^2 - (y+b)^2], in m^8. Verdict: correct, with caveats: see `ERRATA`.

    `eps_x` holds the three readings, shape (..., 3).

    Examples
    --------
    >>> readings = eq12(P=1.0, alpha=0.2, y=0.3, x=1.0, b=0.8, E=1.0)
    >>> abs(eq13(readings, y=[0.3, 0.0], x=1.0, b=0.8)).round(3).tolist()
    [0.0, 0.137]
    """
    e = _readings(eps_x)
    e1, e2, e3 = e[..., 0], e[..., 1], e[..., 2]
    y, x, b = given(y=y, x=x, b=b)
    right, left, middle = (y + b) ** 2, (y - b) ** 2, y**2
    x2 = x**2
    return np.asarray(
        2 * e2 * (x2 + middle) ** 2 * (x2 - left) * (x2 - right)
        - e1 * (x2 + right) ** 2 * (x2 - middle) * (x2 - left)
        - e3 * (x2 + left) ** 2 * (x2 - middle) * (x2 - right)
    )


@checked
def eq13_coefficients(eps_x: ArrayLike, x: Length, b: Length) -> FloatArray:
    """The polynomial (13) multiplied out: coefficients of y^8 down to y^0, as `numpy.roots` takes them.

    The first is 2 eps_2 - eps_1 - eps_3, the second -2 b (eps_1 - eps_3): the degree is below 8 where they
    vanish. Roots of the product form, every one and with a verdict, are found by
    `subskin.memo.three_sensor`.

    Parameters
    ----------
    eps_x : array_like, shape (..., 3)
        Readings of the sensors [-].
    x, b : float
        Depth and pitch of the sensors [m].

    Returns
    -------
    ndarray, shape (..., 9)
        Coefficients [m^0 to m^8].

    Examples
    --------
    >>> eq13_coefficients([1.0, 3.0, 2.0], x=1.0, b=0.5)[:2].tolist()
    [3.0, 1.0]
    """
    e = _readings(eps_x)

    def plus(t: float) -> FloatArray:  # [x^2 + (y + t)^2]^2
        square = [x**2 + t**2, 2 * t, 1.0]
        return np.asarray(polynomial.polymul(square, square))

    def minus(t: float) -> list[float]:  # x^2 - (y + t)^2
        return [x**2 - t**2, -2 * t, -1.0]

    def product(t: float, u: float, v: float) -> FloatArray:
        return np.asarray(polynomial.polymul(plus(t), polynomial.polymul(minus(u), minus(v))))

    terms = (-product(b, 0.0, -b), 2 * product(0.0, -b, b), -product(-b, 0.0, b))
    return np.asarray((e @ np.stack(terms))[..., ::-1])


def _readings(eps_x: ArrayLike) -> FloatArray:
    e = _check.real("eps_x", eps_x)
    if e.ndim == 0 or e.shape[-1] != 3:
        seen = f"eps_x of shape {e.shape}"
        raise GeometryError(seen, "three readings are needed, shape (..., 3)", "np.stack([e1, e2, e3], axis=-1)")
    return e
