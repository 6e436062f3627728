"""Section 6 of the memo: the elastic medium as a filter, and the density of sensors (eqs. 23 to 26)."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import ArrayLike

from .._check import FloatArray
from ..errors import InvalidValueError
from ._symbols import described, given
from .sections4_5 import eq19

__all__ = ["eq23", "eq24", "eq25", "eq25_corrected", "eq26", "eq26_corrected"]


@described
def eq23(
    pressure: Callable[[FloatArray], FloatArray],
    d: ArrayLike,
    y0: ArrayLike,
    E: ArrayLike,
    a1: float,
    a2: float,
    kinks: Sequence[float] = (),
) -> FloatArray:
    """Equation (23): strain beneath a pressure, the integral of P(y)/E h(y0 - y) over y.

    Verdict: correct; it is (19) without a tangential load, where `eq19` says what `pressure` and `kinks` are.

    Examples
    --------
    >>> strain = eq23(lambda y: np.ones_like(y), d=100.0, y0=20.0, E=1.0, a1=-0.5, a2=0.5)
    >>> round(float(strain / eq24(d=100.0, y=20.0)), 4)
    1.0
    """
    d, y0, E = given(d=d, y0=y0, E=E)
    return eq19(pressure, d, y0, 0.0, E, a1, a2, kinks)


@described
def eq24(d: ArrayLike, y: ArrayLike) -> FloatArray:
    """Equation (24): strain times E under a unit normal line load, -3 d (d^2 - y^2)/(2 pi (d^2 + y^2)^2).

    Examples
    --------
    >>> round(eq24(d=1.0, y=0.0).item() * 2 * np.pi, 12), eq24(d=1.0, y=1.0).item()
    (-3.0, -0.0)
    """
    d, y = given(d=d, y=y)
    return np.asarray(-3 * d * (d**2 - y**2) / (2 * np.pi * (d**2 + y**2) ** 2))


@described
def eq25(s: ArrayLike, d: ArrayLike) -> FloatArray:
    """Equation (25) as printed: spectrum of h(y), H(s) = -3 pi d s exp(-d abs(2 pi s)).

    Verdict: **wrong for s < 0**: h(y) is even, so its spectrum is; `eq25_corrected` has abs(s).

    Examples
    --------
    >>> eq25(s=[0.1, -0.1], d=1.0).round(4).tolist()
    [-0.5028, 0.5028]
    """
    s, d = given(s=s, d=d)
    return np.asarray(-3 * np.pi * d * s * np.exp(-d * np.abs(2 * np.pi * s)))


@described
def eq25_corrected(s: ArrayLike, d: ArrayLike) -> FloatArray:
    """Equation (25) for either sign of s: H(s) = -3 pi d abs(s) exp(-2 pi d abs(s)).

    Examples
    --------
    >>> eq25_corrected(s=[0.1, -0.1], d=1.0).round(4).tolist()
    [-0.5028, -0.5028]
    """
    s, d = given(s=s, d=d)
    return np.asarray(-3 * np.pi * d * np.abs(s) * np.exp(-2 * np.pi * d * np.abs(s)))


@described
def eq26(f: ArrayLike) -> FloatArray:
    """Equation (26), left side as printed: the attenuation exp(-1)/(f exp(-f)) against the peak at f = 1.

    Verdict: the formula is right, the printed root f = 10.2 of "attenuation = 10^3" is rounded down, and the
    sensor density s d > 3.2 that follows falls short; see `eq26_corrected`.

    Examples
    --------
    >>> round(eq26(10.2).item())
    970
    """
    (f,) = given(f=f)
    return np.asarray(np.exp(f - 1) / f)


@described
def eq26_corrected(attenuation: ArrayLike = 1e3) -> FloatArray:
    """Equation (26) solved without rounding: f = -W_{-1}(-1/(e attenuation)), W_{-1} being Lambert's function.

    Samples at twice f make the sensor density s d = f/pi.

    Examples
    --------
    >>> round(eq26_corrected().item(), 6), round(eq26_corrected().item() / np.pi, 6)
    (10.233413, 3.257397)
    """
    from scipy.special import lambertw

    (ratio,) = given(attenuation=attenuation)
    if not (ratio >= 1).all():
        seen = f"attenuation = {float(ratio.min()):.6g}"
        raise InvalidValueError(seen, "has to be >= 1, the value at the peak", "attenuation=1000")
    return np.asarray(-lambertw(-1 / (math.e * ratio), k=-1).real)
