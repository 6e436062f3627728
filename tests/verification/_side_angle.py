"""What the tests of the angle on a side share: fingers, and slope and strain by quadrature."""

from __future__ import annotations

import numpy as np
from scipy.integrate import quad

import subskin as ss
from subskin.contact import families

OK, AMBIGUOUS, UNEXPLAINED = ss.Status.OK, ss.Status.AMBIGUOUS, ss.Status.UNEXPLAINED
RUBBER = ss.Material(1.0, 0.5)
FULL_SCALE = 3 / (2 * np.pi)  # strain beneath a unit line load at unit depth, E = 1
FAMILIES = {name: family for name, family in families().items() if name != "line"}
SKINS = {
    "half plane": ss.HalfPlane(RUBBER),
    "soft": ss.HalfPlane(ss.Material(1.0, 0.4)),
    "slice": ss.HalfPlane(ss.Material(1.0, 0.3), plane="stress"),
    "layer": ss.Layered(ss.Layer(ss.Material(1.0, 0.45), 2.0)),
    "round": ss.Round(RUBBER, 6.0, 3.0),
}
EXACT = {"slope_std": 0.0, "strain_std": 0.0}


def row(count=7, pitch=0.5, skin=SKINS["half plane"], noise=1e-3, **more):
    array = ss.SensorArray.line(count, pitch=pitch, depth=1.0, noise=noise * FULL_SCALE, **more)
    return ss.Finger(skin, array)


def two_rows(count=9, pitch=0.25, depths=(0.75, 1.0), skin=SKINS["half plane"], noise=1e-3, **more):
    y = np.tile(pitch * (np.arange(count) - (count - 1) / 2), 2)
    array = ss.SensorArray(y=y, depth=np.repeat(depths, count), noise=noise * FULL_SCALE, **more)
    return ss.Finger(skin, array)


def slope(function, h):
    """Derivative at 0, by differences of the eighth order."""
    weights = (4 / 5, -1 / 5, 4 / 105, -1 / 280)
    return sum(w * (function(k * h) - function(-k * h)) for k, w in enumerate(weights, 1)) / h


def gradients(quantity, depth, h):
    """d/dy and d/dx of quantity(x, y) beneath the centre."""
    return slope(lambda y: quantity(depth, y), h), slope(lambda x: quantity(depth + x, 0.0), h)


def strain_xx(skin, touch, x, y):
    return skin.strain(touch, x, y).xx


def integrals(shape, x, nu, plane):
    """Strain per N and its slope per T beneath the centre, half width 1, E = 1: line loads added up over the pressure.

    From the radial stress of a line load and Hooke's law; nothing of the package's transforms.
    """
    if plane == "strain":
        radial, across = (1 + nu) * (1 - nu), (1 + nu) * nu
    else:
        radial, across = 1.0, nu
    # t = sin(psi) or its like takes the roots at the ends; a wedge is logarithmic at its tip
    pressure = {
        "hertz": lambda psi: 2 / np.pi * np.cos(psi) ** 2,
        "strip": lambda psi: np.cos(psi) / 2,
        "punch": lambda psi: 1 / np.pi,
        "wedge": lambda psi: np.arccosh(1 / np.abs(np.sin(psi))) / np.pi * np.cos(psi),
    }.get(shape, lambda psi: FAMILIES[shape](1.0, half_width=1.0).pressure(np.sin(psi)) * np.cos(psi))

    def strain(psi):
        t = np.sin(psi)
        return x * (radial * x**2 - across * t**2) / (x**2 + t**2) ** 2 * pressure(psi)

    def rise(psi):
        t = np.sin(psi)
        q = radial * x**2 - across * t**2
        return ((q - 2 * across * t**2) * (x**2 + t**2) - 4 * t**2 * q) / (x**2 + t**2) ** 3 * pressure(psi)

    marks = [0.0] if shape == "wedge" else sorted({-min(x, 1.5), 0.0, min(x, 1.5)})
    return [
        -2 / np.pi * quad(f, -np.pi / 2, np.pi / 2, points=marks, limit=400, epsabs=1e-12, epsrel=1e-11)[0]
        for f in (strain, rise)
    ]
