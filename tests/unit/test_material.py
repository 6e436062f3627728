from __future__ import annotations

import numpy as np
import pytest

import subskin as ss


@pytest.mark.parametrize("nu", [0.0, 0.2, 0.3, 0.45])
def test_moduli_fit_together(nu):
    """E = 9 K G / (3 K + G), nu = (3 K - 2 G) / (6 K + 2 G): the inverse relations, from K and G alone."""
    m = ss.Material(young=3e5, poisson=nu)
    k, g = m.bulk, m.shear
    np.testing.assert_allclose(9 * k * g / (3 * k + g), 3e5, rtol=1e-14)
    np.testing.assert_allclose((3 * k - 2 * g) / (6 * k + 2 * g), nu, atol=1e-15)
    np.testing.assert_allclose(1 / m.plane_strain_modulus, (1 - nu) / (2 * g), rtol=1e-14)


def test_incompressible():
    m = ss.Material(young=3e5)
    assert (m.poisson, m.bulk, m.shear, m.plane_strain_modulus) == (0.5, np.inf, 1e5, 4e5)


def test_ints_mean_floats():
    m = ss.Material(young=300, poisson=0)
    assert (m.young, m.poisson) == (300.0, 0.0)
    assert isinstance(m.young, float)
    assert isinstance(m.poisson, float)


@pytest.mark.parametrize("young", [0.0, -1.0, np.nan, np.inf, "soft", None, [1.0, 2.0]])
def test_modulus_refused(young):
    with pytest.raises(ss.errors.InvalidValueError, match=r"young.*Fix: a soft silicone"):
        ss.Material(young=young)


@pytest.mark.parametrize("poisson", [-0.1, 0.5001, 0.6, np.nan, "half"])
def test_poisson_refused(poisson):
    with pytest.raises(ss.errors.InvalidValueError, match="poisson"):
        ss.Material(young=1.0, poisson=poisson)


def test_errors_are_value_errors_and_carry_their_parts():
    with pytest.raises(ValueError, match=r"poisson = 0\.6: has to be <= 0\.5") as caught:
        ss.Material(young=1.0, poisson=0.6)
    assert caught.value.seen == "poisson = 0.6"
    assert caught.value.rule == "has to be <= 0.5"
    assert "rubber" in caught.value.fix


def test_frozen():
    with pytest.raises(AttributeError):
        ss.Material(1.0).young = 2.0
