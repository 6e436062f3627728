"""Contacts that say no more than their traction, support and spectrum: every skin answers them all the same."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pytest
from scipy.special import jv

import subskin as ss
from subskin.contact import Contact, SpreadContact, families

A = 1.25e-3
RUBBER = ss.Material(0.4e6, 0.4)
SKINS = {
    "half plane": ss.HalfPlane(RUBBER),
    "layer": ss.Layered(ss.Layer(RUBBER, 3 * A)),
    "round": ss.Round(RUBBER, 8e-3, 4e-3),
}


class Bare(Contact):
    """Another contact, without its closed form."""

    def __init__(self, of):
        self.of = of

    components = property(lambda self: self.of.components)
    support = property(lambda self: self.of.support)
    breaks = property(lambda self: self.of.breaks)

    def pressure(self, y):
        return self.of.pressure(y)

    def shear(self, y):
        return self.of.shear(y)

    def spectrum(self, k):
        return self.of.spectrum(k)

    def singular_points(self):
        return self.of.singular_points()

    def expand(self, axes=1):
        return Bare(self.of.expand(axes))


@dataclass(frozen=True, eq=False)
class Soft(SpreadContact):
    """(8 N / (3 pi a)) (1 - y^2/a^2)^(3/2), its two formulas and nothing else."""

    def unit_spectrum(self, k):
        s = k * np.asarray(self.half_width)
        near, far = 1 - s**2 / 12 + s**4 / 384, np.maximum(s, 0.01)
        return np.where(s < 0.01, near, 8 * jv(2, far) / far**2)

    def unit_pressure(self, y):
        a = np.asarray(self.half_width)
        return 8 / (3 * np.pi * a) * np.maximum(1 - (y / a) ** 2, 0) ** 1.5


def points():
    """Deep, close beneath the contact and its ends, and on the surface."""
    rng = np.random.default_rng(0)
    x = A * np.concatenate([10 ** rng.uniform(-8, 2, 120), np.zeros(20)])
    y = A * np.concatenate([rng.uniform(-3, 3, 60), rng.uniform(-1, 1, 60), rng.uniform(-1.5, 1.5, 20)])
    return x, y


CLOSED = {
    **{name: family(40.0, 0.4, 0.2e-3, half_width=A) for name, family in families().items() if name != "line"},
    "slip": ss.PartialSlip(40.0, 0.4, 0.2e-3, half_width=A, friction=0.6),
    "profile": ss.PressureProfile(A * np.array([-1.0, -0.4, 0.1, 1.0]), [2e3, 9e3, 4e3, 0.0], [0, 1e3, -4e3, 0]),
    "sum": ss.Strip(40.0, 0.3, -A, half_width=A) + ss.Hertz(10.0, -0.5, A, half_width=0.5 * A),
}


@pytest.mark.parametrize("skin", [SKINS["half plane"], SKINS["round"]], ids=["half plane", "round"])
@pytest.mark.parametrize("closed", CLOSED.values(), ids=CLOSED)
def test_quadrature_gives_what_the_closed_form_gives(closed, skin):
    """To rounding, of the stress of unit load at that distance; an infinite edge (the punch) costs eight digits."""
    x, y = points()
    inside = x <= skin.thickness
    x, y = x[inside], y[inside]
    parts = closed.parts if isinstance(closed, ss.contact.ContactSum) else (closed,)
    found, expected = skin.stress(sum(Bare(part) for part in parts), x, y), skin.stress(closed, x, y)
    singular = np.nanmin([np.abs(y - p) for p in (*closed.singular_points(), np.inf)], axis=0)
    scale = 40 / np.maximum(x, np.minimum(np.maximum(singular, 1e-3 * A), A))
    tolerance = 1e-6 if isinstance(closed, ss.FlatPunch) else 1e-12
    for name in ("xx", "yy", "xy"):
        assert (np.abs(getattr(found, name) - getattr(expected, name)) < tolerance * scale).all(), name


@pytest.mark.parametrize("skin", SKINS.values(), ids=SKINS)
def test_a_contact_of_ones_own_is_the_sum_of_line_loads(skin):
    """By Gauss's rule in an angle, without a root at the ends: from the pressure alone."""
    soft = Soft(40.0, 0.3, 0.2e-3, half_width=A)
    t, weight = np.polynomial.legendre.leggauss(200)
    phi = np.pi / 2 * (1 + t)
    y = 0.2e-3 + A * np.cos(phi)
    lines = ss.LineLoad(np.hypot(soft.pressure(y), soft.shear(y)) * A * np.sin(phi) * np.pi / 2 * weight, 0.3, y)
    x, at = A * np.array([[0.4], [1.0], [2.5]]), A * np.array([-2.0, -0.3, 0.2, 1.5])
    summed = skin.state(lines.expand(2), x, at)
    found = skin.state(soft, x, at)
    for name in ("xx", "yy", "xy"):
        expected = getattr(summed.strain, name).sum(axis=0)
        np.testing.assert_allclose(getattr(found.strain, name), expected, rtol=1e-9, atol=1e-12)


def test_a_batch_is_its_contacts_one_by_one():
    """Batches of widths, some points of which lie close beneath the contact and some do not."""
    array = ss.SensorArray(y=[-1e-3, 0.0, 2e-3], depth=[0.5e-3, 2e-3, 1e-3], width=[0.0, 0.4e-3, 0.0])
    tip = ss.Finger(SKINS["half plane"], array)
    many = Soft(40.0, [[0.3], [-0.2]], [0.0, 1e-3], half_width=[0.3e-3, 2e-3])
    readings = tip.read(many)
    assert readings.shape == (2, 2, 3)
    for i, j in np.ndindex(2, 2):
        one = Soft(40.0, [0.3, -0.2][i], [0.0, 1e-3][j], half_width=[0.3e-3, 2e-3][j])
        np.testing.assert_allclose(readings[i, j], tip.read(one), rtol=1e-11)


def test_far_away_no_digit_of_the_drag_is_lost():
    """Beneath the middle the drag's stress is a share (a/x)^2 of what cancels: T times the second moment, 3 a^2/16."""
    x = 1e4 * A
    drag = Soft.of_components([0.0, 40.0], half_width=A)
    stress = SKINS["half plane"].stress(drag, x, 0.0)
    second = A**2 / 6  # of (8/(3 pi)) (1 - t^2)^(3/2)
    assert float(stress.xy) == pytest.approx(-2 * 40 * second / (np.pi * x**3), rel=1e-7)


def test_a_batch_that_cannot_be_lengthened_is_told():
    class Two(Bare):
        expand = Contact.expand

    with pytest.raises(ss.errors.InvalidValueError, match="a batch of Two"):
        ss.Finger(SKINS["half plane"], ss.SensorArray(y=0.0, depth=A)).read(Two(ss.Strip([1, 2], half_width=A)))
