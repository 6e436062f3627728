"""Sections 4 and 5 of the memo: pressures of punch, wedge and cylinder, and the strain beneath (eqs. 14 to 22).

As printed, sigma_x(x = 0) in (14) to (16) is positive in compression, against (1) to (8). Read it as the pressure; a is
half the width of the contact. From (18) on the memo's a is the width a2 - a1, which makes (18), (20), (21) and (22)
wrong. What takes their place has `_corrected` after its name, and a `half_width`. The axis is that of (1) to (8): a
positive alpha drags the skin towards -y.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import ArrayLike

from .._check import FloatArray
from ..errors import GeometryError, InvalidValueError
from ._symbols import described, given, over_contact

__all__ = [
    "eq14", "eq15", "eq15_constant", "eq16", "eq17", "eq17_corrected", "eq18", "eq18_corrected", "eq19", "eq20",
    "eq20_corrected", "eq21", "eq21_corrected", "eq22", "eq22_corrected",
]  # fmt: skip


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


@described
def eq18(P: ArrayLike, a1: ArrayLike, a2: ArrayLike, y: ArrayLike) -> FloatArray:
    """Equation (18) as printed: the pressure between the edges a1 and a2.

    2P/(pi a^2) [a^2 - (y - (a1 + a2)/2)^2]^(1/2) for a1 < y < a2, with a = a2 - a1.

    Verdict: **wrong**. With a twice too large it does not fall to zero at the edges and carries 0.609 P.

    Examples
    --------
    >>> eq18(P=np.pi, a1=-0.5, a2=0.5, y=[0.0, 0.4999999]).round(4).tolist()
    [2.0, 1.7321]
    """
    return _semi_ellipse(P, a1, a2, y, widths=1.0)


@described
def eq18_corrected(P: ArrayLike, a1: ArrayLike, a2: ArrayLike, y: ArrayLike) -> FloatArray:
    """Equation (18) with a = (a2 - a1)/2: the pressure (16) from a1 to a2.

    Examples
    --------
    >>> eq18_corrected(P=np.pi, a1=-1.0, a2=1.0, y=[0.0, 1.0]).tolist()
    [2.0, 0.0]
    """
    return _semi_ellipse(P, a1, a2, y, widths=0.5)


@described
def eq19(
    pressure: Callable[[FloatArray], FloatArray],
    x: ArrayLike,
    y: ArrayLike,
    alpha: ArrayLike,
    E: ArrayLike,
    a1: float,
    a2: float,
    kinks: Sequence[float] = (),
) -> FloatArray:
    """Equation (19): strain beneath any pressure, nu = 1/2, plane strain.

    The integral of -3 [x cos(alpha) - y0 sin(alpha)] [x^2 - y0^2] P(y - y0)/(2 pi E r^4) over y0, with r^2 =
    x^2 + y0^2.

    Evaluated by quadrature, to about 1e-12 of the largest value. `pressure` is a function that gives
    the pressure [Pa] at positions [m], zero outside (a1, a2), and the shear is its tan(alpha)-fold; `kinks` are
    positions between these edges where it is not smooth [m], e.g. the tip of a wedge.

    Examples
    --------
    Deep beneath, any contact is a line load.

    >>> from subskin.memo import eq8
    >>> strain = eq19(lambda s: np.ones_like(s), x=100.0, y=20.0, alpha=0.3, E=1.0, a1=-0.5, a2=0.5)
    >>> round(float(strain / eq8(P=1.0, alpha=0.3, x=100.0, y=20.0, E=1.0)), 4)
    1.0
    """
    x, y, alpha, E = given(x=x, y=y, alpha=alpha, E=E)
    left, right = (float(v) for v in given(a1=a1, a2=a2))

    def at(x: float, y: float, alpha: float) -> float:
        def integrand(s: FloatArray) -> FloatArray:
            y0 = y - s
            kernel = -3 * (x * np.cos(alpha) - y0 * np.sin(alpha)) * (x**2 - y0**2)
            return np.asarray(kernel * pressure(s) / (2 * np.pi * (x**2 + y0**2) ** 2))

        closest = min(x, 1e-12 * abs(right - left)) if len(kinks) else x
        return over_contact(integrand, left, right, (y, *kinks), closest)

    return _each(at, x, y, alpha) / E


@described
def eq20(
    P: ArrayLike, x: ArrayLike, y: ArrayLike, alpha: ArrayLike, E: ArrayLike, a1: ArrayLike, a2: ArrayLike
) -> FloatArray:
    """Equation (20) as printed: strain beneath the pressure (18), by quadrature; a = a2 - a1.

    eps_x = -3P/(pi^2 a^2 E) times the integral from y - a2 to y - a1 of [x cos(alpha) - y0 sin(alpha)]/(x^2 +
    y0^2)^2 [x^2 - y0^2] [a^2 - (y - y0 - (a1 + a2)/2)^2]^(1/2) dy0. Verdict: **wrong**, as (18) is.

    Examples
    --------
    Deep beneath it is the strain of a line load of 0.609 P.

    >>> from subskin.memo import eq8
    >>> line = eq8(P=1.0, alpha=0.3, x=100.0, y=20.0, E=1.0)
    >>> round(float(eq20(P=1.0, x=100.0, y=20.0, alpha=0.3, E=1.0, a1=-0.5, a2=0.5) / line), 4)
    0.609
    """
    return _strain(1.0, P=P, x=x, y=y, alpha=alpha, E=E, a1=a1, a2=a2)


@described
def eq20_corrected(
    P: ArrayLike, x: ArrayLike, y: ArrayLike, alpha: ArrayLike, E: ArrayLike, a1: ArrayLike, a2: ArrayLike
) -> FloatArray:
    """Equation (20) with a = (a2 - a1)/2: strain beneath a sliding cylinder.

    Examples
    --------
    >>> strain = eq20_corrected(P=1.0, x=0.5, y=0.0, alpha=0.0, E=1.0, a1=-1.0, a2=1.0)
    >>> round(strain.item(), 6), round(-3 / np.pi * 0.5 * (1 - 0.5 / np.sqrt(1.25)), 6).item()
    (-0.263936, -0.263936)
    """
    return _strain(0.5, P=P, x=x, y=y, alpha=alpha, E=E, a1=a1, a2=a2)


@described
def eq21(P: ArrayLike, a: ArrayLike, x: ArrayLike, alpha: ArrayLike, E: ArrayLike) -> FloatArray:
    """Equation (21) as printed: slope of the strain beneath the centre of the contact.

    d eps_x/dy = -3 sqrt(3) P/(2 pi^2 a E) [x^2 - (a/2)^2] [x^2 + (a/2)^2]^(-2) sin(alpha). Verdict: **wrong**
    in four ways, see `ERRATA`; its unit is not that of a slope of strain, 1/m, but 1/m^2. Use `eq21_corrected`.

    Examples
    --------
    >>> round(eq21(P=np.pi**2, a=2.0, x=0.0, alpha=np.pi / 2, E=1.0).item() / 3**0.5, 12)
    0.75
    """
    P, a, x, alpha, E = given(P=P, a=a, x=x, alpha=alpha, E=E)
    h2 = (a / 2) ** 2
    return np.asarray(-3 * np.sqrt(3) * P / (2 * np.pi**2 * a * E) * (x**2 - h2) * (x**2 + h2) ** -2.0 * np.sin(alpha))


@described
def eq21_corrected(P: ArrayLike, half_width: ArrayLike, x: ArrayLike, alpha: ArrayLike, E: ArrayLike) -> FloatArray:
    """Equation (21) mended: slope of the strain beneath the centre of a sliding cylinder, nu = 1/2, plane strain.

    d eps_x/dy = -3 P sin(alpha)/(pi E a^2) [1 - x (x^2 + 2 a^2)/s^3], s^2 = x^2 + a^2, a the half width. It
    vanishes for every alpha at x = 0.786 a, a depth to keep the sensors away from.

    Examples
    --------
    >>> round(eq21_corrected(P=np.pi, half_width=1.0, x=0.0, alpha=np.pi / 2, E=1.0).item(), 12)
    -3.0
    """
    P, a, x, alpha, E = given(P=P, half_width=half_width, x=x, alpha=alpha, E=E)
    s = np.hypot(x, a)
    # 1 - x (x^2 + 2 a^2)/s^3 with s^2 - x^2 = a^2 put in, so that nothing cancels at great depth
    bracket = a**2 / s**2 * (s**2 - x * s - x**2) / (s * (s + x))
    return np.asarray(-3 * P * np.sin(alpha) / (np.pi * E * a**2) * bracket)


@described
def eq22(P: ArrayLike, a: ArrayLike, alpha: ArrayLike, E: ArrayLike) -> FloatArray:
    """Equation (22) as printed: the slope (21) where the contact is wide.

    -6 sqrt(3) P sin(alpha)/(pi^2 a^3 E), a = a2 - a1.

    Verdict: **wrong**: (21) itself tends to the opposite sign, and both have the wrong dimension and
    magnitude. Use `eq22_corrected`.

    Examples
    --------
    >>> round(eq22(P=np.pi**2, a=2.0, alpha=np.pi / 2, E=1.0).item() / 3**0.5, 12)
    -0.75
    """
    P, a, alpha, E = given(P=P, a=a, alpha=alpha, E=E)
    return np.asarray(-6 * np.sqrt(3) * P * np.sin(alpha) / (np.pi**2 * a**3 * E))


@described
def eq22_corrected(P: ArrayLike, half_width: ArrayLike, alpha: ArrayLike, E: ArrayLike) -> FloatArray:
    """Equation (22) mended, the slope `eq21_corrected` under a wide contact: -3 P sin(alpha)/(pi E half_width^2) [1/m].

    Examples
    --------
    >>> round(eq22_corrected(P=np.pi, half_width=1.0, alpha=np.pi / 2, E=1.0).item(), 12)
    -3.0
    """
    P, a, alpha, E = given(P=P, half_width=half_width, alpha=alpha, E=E)
    return np.asarray(-3 * P * np.sin(alpha) / (np.pi * E * a**2))


def _semi_ellipse(P: ArrayLike, a1: ArrayLike, a2: ArrayLike, y: ArrayLike, widths: float) -> FloatArray:
    """2P/(pi a^2) [a^2 - (y - centre)^2]^(1/2) between the edges, with a = widths * (a2 - a1)."""
    P, left, right, y = given(P=P, a1=a1, a2=a2, y=y)
    if not (right > left).all():
        seen = f"a1 = {left}, a2 = {right}"
        raise GeometryError(seen, "the right edge has to lie right of the left one", "swap them")
    a = widths * (right - left)
    inside = (left < y) & (y < right)
    square = np.maximum(a**2 - (y - (left + right) / 2) ** 2, 0.0)
    return np.asarray(np.where(inside, 2 * P / (np.pi * a**2) * np.sqrt(square), 0.0))


def _strain(widths: float, **values: ArrayLike) -> FloatArray:
    """The integral of (20), with a = widths * (a2 - a1)."""
    P, x, y, alpha, E, left, right = given(**values)

    def at(x: float, y: float, alpha: float, a1: float, a2: float) -> float:
        a = widths * (a2 - a1)

        def integrand(y0: FloatArray) -> FloatArray:
            square = np.maximum(a**2 - (y - y0 - (a1 + a2) / 2) ** 2, 0.0)
            tilted = (x * np.cos(alpha) - y0 * np.sin(alpha)) / (x**2 + y0**2) ** 2
            return np.asarray(tilted * (x**2 - y0**2) * np.sqrt(square) / a**2)

        return over_contact(integrand, y - a2, y - a1, (0.0,), x)

    return _each(at, x, y, alpha, left, right) * -3 * P / (np.pi**2 * E)


def _each(at: Callable[..., float], x: FloatArray, *others: FloatArray) -> FloatArray:
    """`at` for each point of the broadcast arrays; the depth comes first and has to be positive."""
    if not (x > 0).all():
        raise GeometryError(f"x = {float(x.min()):.6g} m", "the strain is asked for beneath the surface", "take x > 0")
    points = np.broadcast(x, *others)
    values = np.array([at(*map(float, point)) for point in points], dtype=np.float64)
    return values.reshape(points.shape)
