"""Section 4 of the memo: the stress on the surface under a punch, a wedge and a cylinder (eqs. 14 to 17).

As printed, sigma_x(x = 0) is positive in compression here, against (1) to (8). Read it as the pressure. a
is half the width of the contact.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from .._check import FloatArray
from ..errors import InvalidValueError
from ._symbols import described, given

__all__ = ["eq14", "eq15", "eq15_constant", "eq16", "eq17", "eq17_corrected"]


@described
def eq14(P: ArrayLike, a: ArrayLike, y: ArrayLike) -> FloatArray:
    """Equation (14): pressure under a rectangular indenter, P / (pi sqrt(a^2 - y^2)) for abs(y) < a, else 0.

    In Pa; 0 at the very edges, as printed. Verdict: correct as a pressure; its sign is against (1) to (8).

    Examples
    --------
    >>> eq14(P=np.pi, a=5.0, y=[0.0, 3.0, 6.0]).tolist()
    [0.2, 0.25, 0.0]
    """
    P, a, y = given(P=P, a=a, y=y)
    return np.asarray(np.where(np.abs(y) < a, P / (np.pi * np.sqrt(_inside(a, y))), 0.0))


@described
def eq15(K: ArrayLike, theta: ArrayLike, a: ArrayLike, y: ArrayLike) -> FloatArray:
    """Equation (15): pressure under a wedge, K cot(theta/2) arccosh(a/abs(y)) for abs(y) < a, else 0.

    In Pa; infinite at the tip. Verdict: correct as a pressure, with the K of `eq15_constant`, which the memo leaves
    open. The flanks slope by cot(theta/2), which linear theory wants small: not so for the memo's wedge of 90 degrees.

    Examples
    --------
    >>> eq15(K=1.0, theta=np.pi / 2, a=np.cosh(2.0), y=[1.0, 4.0]).round(12).tolist()
    [2.0, 0.0]
    """
    K, theta, a, y = given(K=K, theta=theta, a=a, y=y)
    if not ((theta > 0) & (theta < np.pi)).all():
        raise InvalidValueError(f"theta = {theta}", "a vertex angle lies between 0 and pi [rad]", "np.deg2rad(90)")
    with np.errstate(divide="ignore"):
        ratio = np.maximum(a / np.abs(y), 1.0)
    return np.asarray(np.where(np.abs(y) < a, K / np.tan(theta / 2) * np.arccosh(ratio), 0.0))


@described
def eq15_constant(E: ArrayLike, nu: ArrayLike) -> FloatArray:
    """Equation (15)'s constant, K = E/(pi (1 - nu^2)) [Pa], which the memo leaves open.

    Examples
    --------
    >>> round(eq15_constant(E=np.pi, nu=0.5).item(), 12)
    1.333333333333
    """
    E, nu = given(E=E, nu=nu)
    return np.asarray(E / (np.pi * (1 - nu**2)))


@described
def eq16(P: ArrayLike, a: ArrayLike, y: ArrayLike) -> FloatArray:
    """Equation (16): pressure under a cylinder, 2 P/(pi a^2) sqrt(a^2 - y^2); 0 outside.

    In Pa. Verdict: correct as a pressure; its sign is against (1) to (8). a is the half width, so (17) does not go
    with it.

    Examples
    --------
    >>> eq16(P=np.pi, a=5.0, y=[0.0, 3.0, 6.0]).round(12).tolist()
    [0.4, 0.32, 0.0]
    """
    P, a, y = given(P=P, a=a, y=y)
    return np.asarray(np.where(np.abs(y) < a, 2 * P / (np.pi * a**2) * np.sqrt(_inside(a, y)), 0.0))


@described
def eq17(P: ArrayLike, R: ArrayLike, E: ArrayLike, nu: ArrayLike) -> FloatArray:
    """Equation (17) as printed, "half width of the contact": a = 2 [4 R P (1 - nu^2)/(pi E)]^(1/2).

    Verdict: **wrong**. This is the whole width; `eq17_corrected` is the half width that (16) needs.

    Examples
    --------
    >>> eq17(P=np.pi, R=1.0, E=4.0, nu=0.0).item(), eq17_corrected(P=np.pi, R=1.0, E=4.0, nu=0.0).item()
    (2.0, 1.0)
    """
    return 2 * eq17_corrected(P, R, E, nu)


@described
def eq17_corrected(P: ArrayLike, R: ArrayLike, E: ArrayLike, nu: ArrayLike) -> FloatArray:
    """Equation (17) mended: half the width of the contact, a = [4 R P (1 - nu^2)/(pi E)]^(1/2).

    Examples
    --------
    >>> eq17_corrected(P=np.pi, R=1.0, E=4.0, nu=0.0).item()
    1.0
    """
    P, R, E, nu = given(P=P, R=R, E=E, nu=nu)
    if not (P >= 0).all():
        raise InvalidValueError(f"P = {float(P.min()):.6g} N/m", "a cylinder touches only where it is pressed", "P > 0")
    return np.asarray(np.sqrt(4 * R * P * (1 - nu**2) / (np.pi * E)))


def _inside(a: FloatArray, y: FloatArray) -> FloatArray:
    """a^2 - y^2 inside the contact, 1 outside, where it is not used."""
    return np.where(np.abs(y) < a, (a - y) * (a + y), 1.0)
