"""Section 2 of the memo: stress and strain beneath a line load, and a resistor as the sensor (eqs. 1 to 11).

The load acts at the origin; (x, y) = (r cos theta, r sin theta) is the field point. A positive alpha drags the skin
towards -y: the resultant is (P cos alpha, -P sin alpha). The memo's y axis thus runs against the project's, y_memo =
position - y, and tau_xy changes its sign with it; sigma_x, sigma_y and the strains do not.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from .._check import FloatArray
from ._symbols import described, given, off_origin

__all__ = [
    "PlaneStrain", "PlaneStress", "PolarStress", "Resistance", "Strains",
    "eq1", "eq2", "eq3", "eq4", "eq5", "eq6", "eq7", "eq8", "eq9", "eq10", "eq10_corrected", "eq11", "eq11_corrected",
]  # fmt: skip


class PolarStress(NamedTuple):
    """Stresses `sigma_r`, `sigma_theta`, `tau_r_theta` [Pa] in polar coordinates about the load."""

    sigma_r: FloatArray
    sigma_theta: FloatArray
    tau_r_theta: FloatArray


class PlaneStress(NamedTuple):
    """Stresses `sigma_x`, `sigma_y`, `tau_xy` [Pa] in the plane, tension positive."""

    sigma_x: FloatArray
    sigma_y: FloatArray
    tau_xy: FloatArray


class Strains(NamedTuple):
    """Strains `eps_x`, `eps_y`, `eps_z` [-] along the axes, tension positive."""

    eps_x: FloatArray
    eps_y: FloatArray
    eps_z: FloatArray


class PlaneStrain(NamedTuple):
    """What follows in plane strain: the stress `sigma_z` [Pa] along the contact, the strains `eps_x`, `eps_y` [-]."""

    sigma_z: FloatArray
    eps_x: FloatArray
    eps_y: FloatArray


class Resistance(NamedTuple):
    """A chain of approximations as printed: its first member, `ratio`, and its last, `first_order` [ohm]."""

    ratio: FloatArray
    first_order: FloatArray


@described
def eq1(P: ArrayLike, r: ArrayLike, theta: ArrayLike) -> PolarStress:
    """Equation (1): stress under a normal line load, sigma_r = -2 P cos(theta) / (pi r), the others zero.

    Examples
    --------
    >>> eq1(P=np.pi, r=2.0, theta=0.0).sigma_r.item()
    -1.0
    """
    return eq2(P, 0.0, r, theta)


@described
def eq2(P: ArrayLike, alpha: ArrayLike, r: ArrayLike, theta: ArrayLike) -> PolarStress:
    """Equation (2): stress under an inclined line load, sigma_r = -2 P cos(alpha + theta) / (pi r).

    Note the sign: the load drags the skin towards -y for alpha > 0.

    Examples
    --------
    Nothing at right angles to the load.

    >>> bool(abs(eq2(P=1.0, alpha=0.5, r=1.0, theta=np.pi / 2 - 0.5).sigma_r) < 1e-15)
    True
    """
    P, alpha, r, theta = given(P=P, alpha=alpha, r=r, theta=theta)
    sigma_r = np.asarray(-2 * P / (np.pi * r) * np.cos(alpha + theta))
    return PolarStress(sigma_r, np.zeros_like(sigma_r), np.zeros_like(sigma_r))


@described
def eq3(sigma_r: ArrayLike, theta: ArrayLike) -> PlaneStress:
    """Equation (3): the radial stress in cartesian coordinates.

    sigma_x = sigma_r cos^2, sigma_y = sigma_r sin^2, tau_xy = sigma_r sin cos (of theta).

    Examples
    --------
    >>> [round(float(s), 12) for s in eq3(sigma_r=-2.0, theta=np.pi / 4)]
    [-1.0, -1.0, -1.0]
    """
    sigma_r, theta = given(sigma_r=sigma_r, theta=theta)
    c, s = np.cos(theta), np.sin(theta)
    return PlaneStress(*(np.asarray(sigma_r * part) for part in (c**2, s**2, s * c)))


@described
def eq4(P: ArrayLike, alpha: ArrayLike, x: ArrayLike, y: ArrayLike) -> PlaneStress:
    """Equation (4): stress under a line load in cartesian coordinates.

    sigma_x = -2 P/(pi r) cos(alpha + theta) cos^2(theta), sigma_y with sin^2 and tau_xy with sin cos, where r^2 = x^2 +
    y^2, cos(theta) = x/r, sin(theta) = y/r and cos(alpha + theta) = (x cos(alpha) - y sin(alpha))/r.

    Examples
    --------
    >>> eq4(P=np.pi, alpha=0.0, x=2.0, y=0.0).sigma_x.item()
    -1.0
    """
    P, alpha, x, y = given(P=P, alpha=alpha, x=x, y=y)
    r = np.sqrt(off_origin(x, y))
    cos, sin, tilted = x / r, y / r, x / r * np.cos(alpha) - y / r * np.sin(alpha)
    sigma_r = -2 * P / (np.pi * r) * tilted
    return PlaneStress(*(np.asarray(sigma_r * part) for part in (cos**2, sin**2, sin * cos)))


@described
def eq5(sigma_x: ArrayLike, E: ArrayLike) -> FloatArray:
    """Equation (5): Hooke's law as first given, eps_x = sigma_x / E.

    Verdict: incomplete. It holds for stress along one axis alone, and the memo does not use it: (6) takes its place.

    Examples
    --------
    >>> eq5(sigma_x=-2.0, E=4.0).item()
    -0.5
    """
    sigma_x, E = given(sigma_x=sigma_x, E=E)
    return np.asarray(sigma_x / E)


@described
def eq6(sigma_x: ArrayLike, sigma_y: ArrayLike, sigma_z: ArrayLike, E: ArrayLike, nu: ArrayLike = 0.5) -> Strains:
    """Equation (6): Hooke's law, eps_x = [sigma_x - nu (sigma_y + sigma_z)]/E and so on around.

    Examples
    --------
    Equal pressure from all sides does not change an incompressible body.

    >>> [float(e) for e in eq6(-1.0, -1.0, -1.0, E=2.0)]
    [0.0, 0.0, 0.0]
    """
    sx, sy, sz, E, nu = given(sigma_x=sigma_x, sigma_y=sigma_y, sigma_z=sigma_z, E=E, nu=nu)
    return Strains(*(np.asarray((s - nu * (t + u)) / E) for s, t, u in ((sx, sy, sz), (sy, sx, sz), (sz, sx, sy))))


@described
def eq7(sigma_x: ArrayLike, sigma_y: ArrayLike, E: ArrayLike) -> PlaneStrain:
    """Equation (7): plane strain at nu = 1/2.

    sigma_z = (sigma_x + sigma_y)/2, eps_x = 3/(4E) (sigma_x - sigma_y), eps_y = 3/(4E) (sigma_y - sigma_x).

    Examples
    --------
    >>> [float(v) for v in eq7(sigma_x=-3.0, sigma_y=-1.0, E=1.5)]
    [-2.0, -1.0, 1.0]
    """
    sx, sy, E = given(sigma_x=sigma_x, sigma_y=sigma_y, E=E)
    eps_x = np.asarray(3 / (4 * E) * (sx - sy))
    return PlaneStrain(np.broadcast_to((sx + sy) / 2, eps_x.shape), eps_x, np.asarray(-eps_x))


@described
def eq8(P: ArrayLike, alpha: ArrayLike, x: ArrayLike, y: ArrayLike, E: ArrayLike) -> FloatArray:
    """Equation (8): strain along the depth under a line load, nu = 1/2, plane strain.

    eps_x = -3 P/(2 pi E r^4) [x cos(alpha) - y sin(alpha)] [x^2 - y^2].

    Examples
    --------
    >>> round(eq8(P=40.0, alpha=0.0, x=2e-3, y=0.0, E=0.4e6).item(), 6)
    -0.023873
    """
    P, alpha, x, y, E = given(P=P, alpha=alpha, x=x, y=y, E=E)
    r2 = off_origin(x, y)
    return np.asarray(-3 * P / (2 * np.pi * E * r2**2) * (x * np.cos(alpha) - y * np.sin(alpha)) * (x**2 - y**2))


@described
def eq9(rho: ArrayLike, x: ArrayLike, y: ArrayLike, z: ArrayLike) -> FloatArray:
    """Equation (9): resistance of a block with electrodes above and below, R = rho L/A = rho x/(y z).

    Examples
    --------
    >>> eq9(rho=6.0, x=2.0, y=3.0, z=4.0).item()
    1.0
    """
    rho, x, y, z = given(rho=rho, x=x, y=y, z=z)
    return np.asarray(rho * x / (y * z))


@described
def eq10(rho: ArrayLike, eps_x: ArrayLike) -> Resistance:
    """Equation (10): resistance of a unit block in plane strain.

    R = rho (1 + eps_x)/(1 - eps_x), about rho (1 + 2 eps_x).

    Verdict: correct to first order only. It takes eps_y = -eps_x, which keeps the volume to first order; see
    `eq10_corrected`.

    Examples
    --------
    >>> [round(float(v), 4) for v in eq10(rho=1.0, eps_x=0.1)]
    [1.2222, 1.2]
    """
    rho, e = given(rho=rho, eps_x=eps_x)
    return Resistance(np.asarray(rho * (1 + e) / (1 - e)), np.asarray(rho * (1 + 2 * e)))


@described
def eq10_corrected(rho: ArrayLike, eps_x: ArrayLike) -> FloatArray:
    """Equation (10) for a body that keeps its volume: R = rho (1 + eps_x)^2, its section being 1/(1 + eps_x).

    It holds in plane stress too, where it takes the place of (11).

    Examples
    --------
    >>> round(eq10_corrected(rho=1.0, eps_x=0.1).item(), 4)
    1.21
    """
    rho, e = given(rho=rho, eps_x=eps_x)
    return np.asarray(rho * (1 + e) ** 2)


@described
def eq11(rho: ArrayLike, eps_x: ArrayLike, eps_y: ArrayLike, eps_z: ArrayLike) -> Resistance:
    """Equation (11): the same in plane stress.

    R = rho (1 + eps_x)/((1 + eps_y)(1 + eps_z)), about rho (1 + eps_x - eps_y - eps_z), which is rho (1 + 2
    eps_x) at nu = 1/2. Verdict: correct to first order only; see `eq11_corrected`.

    Examples
    --------
    >>> [round(float(v), 4) for v in eq11(rho=1.0, eps_x=0.1, eps_y=-0.05, eps_z=-0.05)]
    [1.2188, 1.2]
    """
    rho, ex, ey, ez = given(rho=rho, eps_x=eps_x, eps_y=eps_y, eps_z=eps_z)
    return Resistance(np.asarray(rho * (1 + ex) / ((1 + ey) * (1 + ez))), np.asarray(rho * (1 + ex - ey - ez)))


@described
def eq11_corrected(rho: ArrayLike, eps_x: ArrayLike) -> FloatArray:
    """Equation (11) for a body that keeps its volume: as `eq10_corrected`, whatever each side's strain.

    Examples
    --------
    >>> round(eq11_corrected(rho=1.0, eps_x=0.1).item(), 4)
    1.21
    """
    return eq10_corrected(rho, eps_x)
