"""What each transducer reports, against Flamant's radial stress worked out by hand."""

from __future__ import annotations

import numpy as np
import pytest

import subskin as ss

from .._tables import SKINS

E, P, ALPHA, F = 0.4e6, 40.0, 0.4, 0.3e-3
X = np.array([0.5e-3, 1e-3, 2e-3, 3e-3])
Y = np.array([0.0, 2e-3, -1e-3, 0.3e-3])
LOAD = ss.LineLoad(P, ALPHA, F)
N, T = P * np.cos(ALPHA), P * np.sin(ALPHA)
R2 = X**2 + (Y - F) ** 2
RADIAL = -2 * (N * X + T * (Y - F)) / (np.pi * R2)  # sigma_r, the only stress (DESIGN.md; memo eq. 2)
COS2, SIN2, SINCOS = X**2 / R2, (Y - F) ** 2 / R2, X * (Y - F) / R2
HALF_PLANES = [skin for skin in SKINS.values() if isinstance(skin, ss.HalfPlane)]


@pytest.fixture(params=HALF_PLANES, ids=lambda s: f"{s.plane}-{s.material.poisson}")
def skin(request):
    return request.param


def strains(skin):
    """eps_r, eps_theta and eps_z of a uniaxial sigma_r."""
    nu = skin.material.poisson
    if skin.plane == "strain":
        return (1 - nu**2) * RADIAL / E, -nu * (1 + nu) * RADIAL / E, 0 * RADIAL
    return RADIAL / E, -nu * RADIAL / E, -nu * RADIAL / E


def test_normal_strain_is_memo_eq_8():
    """eps_x = -3/(2 pi E) [N x + T (y - f)] [x^2 - (y - f)^2] / [x^2 + (y - f)^2]^2 at nu = 1/2 in plane strain."""
    skin = ss.HalfPlane(ss.Material(E, 0.5))
    d = Y - F
    eq8 = -3 / (2 * np.pi * E) * (N * X + T * d) * (X**2 - d**2) / (X**2 + d**2) ** 2
    state = skin.state(LOAD, X, Y)
    np.testing.assert_allclose(ss.NormalStrain().measure(state), eq8, rtol=1e-13)
    np.testing.assert_allclose(ss.LateralStrain().measure(state), -eq8, rtol=1e-13)


def test_strains_and_stresses(skin):
    state = skin.state(LOAD, X, Y)
    r, t, z = strains(skin)
    scale = {"atol": 1e-15 * np.abs(RADIAL).max() / E, "rtol": 1e-13}
    np.testing.assert_allclose(ss.NormalStrain().measure(state), COS2 * r + SIN2 * t, **scale)
    np.testing.assert_allclose(ss.LateralStrain().measure(state), SIN2 * r + COS2 * t, **scale)
    np.testing.assert_allclose(ss.ShearStrain().measure(state), 2 * SINCOS * (r - t), **scale)
    np.testing.assert_allclose(state.strain.zz, z, **scale)
    np.testing.assert_allclose(ss.NormalStress().measure(state), COS2 * RADIAL, rtol=1e-13)


def test_mean_pressure(skin):
    nu = skin.material.poisson
    share = (1 + nu) / 3 if skin.plane == "strain" else 1 / 3
    np.testing.assert_allclose(ss.MeanPressure().measure(skin.state(LOAD, X, Y)), -share * RADIAL, rtol=1e-13)


def test_energy_density(skin):
    nu = skin.material.poisson
    stiffness = E / (1 - nu**2) if skin.plane == "strain" else E
    energy = ss.EnergyDensity().measure(skin.state(LOAD, X, Y))
    np.testing.assert_allclose(energy, RADIAL**2 / (2 * stiffness), rtol=1e-13)


def test_max_compressive_strain(skin):
    state = skin.state(LOAD, X, Y)
    worst = np.max(-np.array(strains(skin)), axis=0)
    np.testing.assert_allclose(ss.MaxCompressiveStrain().measure(state), worst, rtol=1e-12, atol=1e-18)
    pulled = skin.state(ss.LineLoad(P, np.pi - 0.2, F), X, Y)
    assert (ss.MaxCompressiveStrain().measure(pulled) >= 0).all()


class TestVolumeResistance:
    def test_exact_is_a_block_stretched(self, skin):
        """R = rho L / A of a block L x W x H whose sides stretch by the strains along its axes."""
        state = skin.state(LOAD, X, Y)
        e = state.strain
        length, area = 1 + e.xx, (1 + e.yy) * (1 + e.zz)
        exact = ss.VolumeResistance(exact=True).measure(state)
        # the class takes the volume to change by the trace: equal to the block's to second order
        np.testing.assert_allclose(exact, length / area - 1, atol=4 * np.abs(e.xx).max() ** 2)

    def test_incompressible_in_both_planes(self):
        """(1 + eps_x)^2 - 1, and 2 eps_x to first order: memo eqs. (9) to (11) with the volume kept."""
        for plane in ("strain", "stress"):
            state = ss.HalfPlane(ss.Material(E, 0.5), plane=plane).state(LOAD, X, Y)
            e = state.strain.xx
            exact, first = (ss.VolumeResistance(exact=True).measure(state), ss.VolumeResistance().measure(state))
            np.testing.assert_allclose(exact, (1 + e) ** 2 - 1, rtol=1e-11)
            np.testing.assert_allclose(first, 2 * e, rtol=1e-11, atol=1e-17)

    def test_first_order_is_the_slope(self, skin):
        """(R - 1) / load tends to the first order with the load itself: halve the load, halve the gap."""
        gaps = []
        for scale in (1.0, 0.5, 0.25, 0.125):
            state = skin.state(ss.LineLoad(P * scale, ALPHA, F), X, Y)
            gap = ss.VolumeResistance(exact=True).measure(state) - ss.VolumeResistance().measure(state)
            gaps.append(np.abs(gap).max() / scale)
        np.testing.assert_allclose(np.diff(np.log2(gaps)), -1.0, atol=0.1)

    def test_linearise_undoes_the_exact_law(self):
        skin = ss.HalfPlane(ss.Material(E, 0.5))
        state = skin.state(LOAD, X, Y)
        exact = ss.VolumeResistance(exact=True)
        np.testing.assert_allclose(exact.linearise(exact.measure(state)), 2 * state.strain.xx, rtol=1e-11)
        assert np.isnan(exact.linearise(np.array([-1.5]))).all()
        assert exact.linear_part == ss.VolumeResistance()


def test_units():
    assert {k().unit for k in (ss.NormalStress, ss.MeanPressure)} == {"Pa"}
    assert ss.EnergyDensity().unit == "J/m^3"
    assert {k().unit for k in (ss.NormalStrain, ss.ShearStrain, ss.LateralStrain, ss.VolumeResistance)} == {""}
