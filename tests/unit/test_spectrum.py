"""Spectra of the contacts against quadrature of their pressure and shear."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest

import subskin as ss
from subskin.contact import contact_of, families

A = 1.25e-3
CONTACTS = {
    **{name: contact_of(name, A)(40.0, 0.4, 0.2e-3) for name in families() if name != "line"},
    "punch": ss.FlatPunch(40.0, -0.3, 0.2e-3, half_width=A, moment=0.4 * 20 * A),
    "slip": ss.PartialSlip(40.0, 0.4, 0.2e-3, half_width=A, friction=0.6),
    "almost sticks": ss.PartialSlip(40.0, 1e-6, 0.2e-3, half_width=A, friction=0.6),
    "profile": ss.PressureProfile(
        A * np.array([-1.0, -0.4, 0.1, 1.0]), [2e3, 9e3, 4e3, 0.0], [0, 1e3, -4e3, 0]
    ),
}
WAVES = np.array([0.0, 1e-3, 0.05, 0.7, 3.0, 21.0, 60.0]) / A


def breaks(contact):
    """Places where pressure or shear are not smooth."""
    if isinstance(contact, ss.PressureProfile):
        return contact.nodes
    centre, ends = float(contact.position), [-A, 0.0, A]
    if isinstance(contact, ss.PartialSlip):
        c = float(contact.stick_half_width)
        ends = [-A, -c, 0.0, c, A]
    return centre + np.array(ends)


def by_quadrature(contact, k):
    """Gauss-Legendre in an angle that is smooth at the ends of each stretch, square roots and logarithms included."""
    t, w = np.polynomial.legendre.leggauss(400)
    total = np.zeros(2, dtype=complex)
    ends = breaks(contact)
    for a, b in pairwise(ends):
        u = 0.5 * (1 + t)
        share = u**5 * (126 - 420 * u + 540 * u**2 - 315 * u**3 + 70 * u**4)  # flat at both ends
        slope = 630 * u**4 * (1 - u) ** 4
        y = a + (b - a) * share
        weight = 0.5 * w * slope * (b - a) * np.exp(-1j * k * y)
        inside = (y > a) & (y < b)
        for i, traction in enumerate((contact.pressure, contact.shear)):
            total[i] += (weight[inside] * traction(y[inside])).sum()
    return total


@pytest.mark.parametrize("contact", CONTACTS.values(), ids=CONTACTS)
def test_spectrum(contact):
    seen = contact.spectrum(WAVES)
    expected = np.array([by_quadrature(contact, k) for k in WAVES])
    tolerance = 2e-7 if isinstance(contact, ss.FlatPunch) else 1e-10  # a punch is infinite at its edges
    assert np.abs(seen.p - expected[:, 0]).max() < tolerance * 40
    assert np.abs(seen.q - expected[:, 1]).max() < tolerance * 40
    assert seen.p[0] == pytest.approx(float(contact.normal_force), rel=1e-12)
    assert seen.q[0] == pytest.approx(float(contact.tangential_force), rel=1e-12)


def test_spectrum_of_a_line_load_and_of_a_sum():
    line = ss.LineLoad(2.0, 0.3, 1e-3)
    assert np.allclose(line.spectrum(WAVES).p, 2 * np.cos(0.3) * np.exp(-1e-3j * WAVES), rtol=1e-14)
    whole = (line + CONTACTS["hertz"]).spectrum(WAVES)
    assert np.allclose(whole.q, line.spectrum(WAVES).q + CONTACTS["hertz"].spectrum(WAVES).q, rtol=1e-14)


@pytest.mark.parametrize("contact", CONTACTS.values(), ids=CONTACTS)
def test_support_is_where_it_presses(contact):
    low, high = contact.support
    outside = np.array([low - 1e-9, high + 1e-9])
    assert (contact.pressure(outside) == 0).all()
    assert (contact.pressure(np.array([low + 1e-6, high - 1e-6])) != 0).all()


def test_batches():
    batch = ss.Hertz(np.array([1.0, 2.0]), 0.1, np.array([0.0, 1e-3]), half_width=A)
    seen = batch.expand(1).spectrum(WAVES).p
    assert seen.shape == (2, WAVES.size)
    assert np.allclose(seen[1], ss.Hertz(2.0, 0.1, 1e-3, half_width=A).spectrum(WAVES).p)
    low, high = (batch + ss.LineLoad(1.0, position=5e-3)).support
    assert low.tolist() == pytest.approx([-A, -A + 1e-3])
    assert high.tolist() == [5e-3, 5e-3]
