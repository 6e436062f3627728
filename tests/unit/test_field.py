from __future__ import annotations

import numpy as np
import pytest

import subskin as ss

RNG = np.random.default_rng(5)


def stress(shape=(6, 4)):
    return ss.tensor.Stress(*(RNG.normal(size=shape) for _ in range(4)))


def matrices(t):
    zero = np.zeros_like(t.xx)
    return np.stack([t.xx, t.xy, zero, t.xy, t.yy, zero, zero, zero, t.zz], axis=-1).reshape(*t.shape, 3, 3)


@pytest.mark.parametrize("shape", [(), (5,), (2, 3)])
def test_principal_values_are_the_eigenvalues(shape):
    s = stress(shape)
    assert s.principal.shape == (*shape, 3)
    np.testing.assert_allclose(s.principal, np.linalg.eigvalsh(matrices(s))[..., ::-1], atol=1e-14)
    np.testing.assert_allclose(s.principal.sum(axis=-1), s.trace, atol=1e-14)


def test_principal_values_do_not_turn():
    s = stress()
    c, d = np.cos(0.7), np.sin(0.7)
    turned = ss.tensor.Stress(
        xx=c * c * s.xx + d * d * s.yy + 2 * c * d * s.xy,
        yy=d * d * s.xx + c * c * s.yy - 2 * c * d * s.xy,
        zz=s.zz,
        xy=c * d * (s.yy - s.xx) + (c * c - d * d) * s.xy,
    )
    np.testing.assert_allclose(turned.principal, s.principal, atol=1e-14)
    np.testing.assert_allclose(turned.mean_pressure, s.mean_pressure, atol=1e-14)


def test_mean_pressure_presses():
    np.testing.assert_allclose(ss.tensor.Stress(*(np.array(v) for v in (-2.0, -2.0, -2.0, 1.0))).mean_pressure, 2.0)


def test_strain_names():
    e = ss.tensor.Strain(*(np.array(v) for v in (0.1, 0.2, -0.05, 0.03)))
    np.testing.assert_allclose([e.gamma_xy, e.volume], [0.06, 0.25])


@pytest.mark.parametrize("plane", ["strain", "stress"])
@pytest.mark.parametrize("nu", [0.0, 0.3, 0.5])
def test_energy_is_what_the_volume_and_the_shape_store(plane, nu):
    """p^2 / (2 K) + (deviator : deviator) / (4 G), by the other route of shape and volume."""
    material = ss.Material(2e5, nu)
    state = ss.HalfPlane(material, plane=plane).state(ss.Hertz(40.0, 0.4, half_width=1e-3), 1e-3, [0.0, 0.5e-3, 2e-3])
    s = state.stress
    deviator = matrices(s) + s.mean_pressure[:, None, None] * np.eye(3)
    stored = s.mean_pressure**2 / (2 * material.bulk) + (deviator**2).sum(axis=(1, 2)) / (4 * material.shear)
    np.testing.assert_allclose(state.energy_density, stored, rtol=1e-13)
