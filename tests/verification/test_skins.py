"""What only layers and round fingers know: long waves, and how the surface gives way to each wave and to hats."""

from __future__ import annotations

import numpy as np
import pytest

import subskin as ss

from .._tables import SKINS, A
from ._contract import interfaces, points, slides

each_skin = pytest.mark.parametrize("skin", SKINS.values(), ids=SKINS)
FLAT = [name for name, skin in SKINS.items() if not skin.curvature and (skin.interfaces or skin.thickness < np.inf)]


def test_a_round_finger_repeats_and_turns():
    skin = SKINS["round-0.5"]
    x, y, _ = points(skin)
    at, turned = (ss.Hertz(40.0, 0.4, f, half_width=A) for f in (0.0, 2.3 * A))
    one = skin.strain(at, x, y).xx
    size = 1e-12 * np.abs(one).max()
    assert np.allclose(skin.strain(at, x, y + skin.period).xx, one, rtol=0, atol=size)
    assert np.allclose(skin.strain(turned, x, y + 2.3 * A).xx, one, rtol=0, atol=size)
    far = ss.Hertz(40.0, 0.4, 0.49 * skin.period, half_width=A)  # across the seam
    assert np.allclose(skin.strain(far, x, y + 0.49 * skin.period).xx, one, rtol=0, atol=size)


def test_limits_of_long_waves_do_not_commute():
    """FORMULAS 3.4: k -> 0 at nu = 1/2 gives -(3/2E) k^2 (H^2 - d^2), at nu < 1/2 a constant."""
    young, height, depth = 0.4e6, 4 * A, 1.5 * A
    for nu in (0.5, 0.4999, 0.3):
        layer = ss.Layered(ss.Layer(ss.Material(young, nu), height))
        k = 1e-6 / height
        y = layer.modes.amplitudes(np.array([k]), np.array([depth]))[0, 0, :, 0]
        double = young / (1 + nu)
        strain = (1 - 2 * nu) / (1 - nu) * y[2] / double - nu / (1 - nu) * k * y[1] / double
        if nu == 0.5:
            assert strain == pytest.approx(-1.5 / young * k**2 * (height**2 - depth**2), rel=1e-6)
        else:
            assert strain == pytest.approx(-(1 + nu) * (1 - 2 * nu) / (young * (1 - nu)), rel=1e-6)


@pytest.mark.parametrize("width", [1e2, 1e1, 1e-1, 1e-3])
def test_a_uniform_press_on_a_thin_or_a_thick_layer(width):
    """Contact from a hundred layers wide to a thousandth: beneath the middle of a wide one all is one-dimensional."""
    nu, height = 0.3, 1.0
    skin = ss.Layered(ss.Layer(ss.Material(1e6, nu), height))
    strip = ss.Strip(1e3, half_width=0.5 * width)
    s = skin.state(strip, np.array([0.0, 0.5, 1.0]), 0.0)
    p = 1e3 / width
    if width >= 10:
        assert s.stress.xx == pytest.approx(-p, rel=10 / width**2 if width > 50 else 2e-2)
        assert s.strain.xx == pytest.approx(-(1 + nu) * (1 - 2 * nu) / (1 - nu) * p / 1e6, rel=3e-2)
    else:
        line = skin.state(ss.LineLoad(1e3), np.array([0.5, 1.0]), 0.0)
        assert s.stress.xx[1:] == pytest.approx(line.stress.xx, rel=width**2)


@each_skin
def test_reciprocity_and_stiffness(skin):
    k = np.arange(1, 60) * skin.curvature if skin.curvature else np.geomspace(1e-2, 1e3, 60) / A
    c = skin.surface_compliance(k)
    assert np.allclose(c[..., 0, 1], c[..., 1, 0], rtol=1e-9, atol=1e-12 * np.abs(c).max(axis=(-2, -1)))
    assert (np.linalg.eigvalsh(0.5 * (c + np.swapaxes(c, -1, -2))) > 0).all()


def test_compliance_is_what_the_strain_integrates_to():
    """u_x at the surface is minus the integral of eps_x over the depth: by quadrature, wave by wave."""
    for skin in (SKINS["layer-0.5"], SKINS["layer-0.3"], SKINS["epidermis"]):
        for k in np.array([0.3, 1.0, 4.0]) / A:
            ends, total = interfaces(skin), np.zeros(2)
            for layer, a, b in zip(skin.stack, ends, ends[1:], strict=False):
                t, w = np.polynomial.legendre.leggauss(40)
                depth = a + 0.5 * (b - a) * (1 + t)
                y = skin.modes.amplitudes(np.array([k]), depth)[:, 0]
                nu, double = layer.material.poisson, 2 * layer.material.shear
                along = k * y[:, 1] / (2 * skin.stack[0].material.shear)
                strain = (1 - 2 * nu) / (1 - nu) * y[:, 2] / double - nu / (1 - nu) * along
                total += 0.5 * (b - a) * w @ strain
            expected = skin.surface_compliance(k)
            assert -total == pytest.approx(expected[0], abs=1e-12 * abs(expected).max())


@pytest.mark.parametrize("name", ["round-0.3", "round layers"])
def test_influence_on_a_round_finger_is_the_sum_of_its_waves(name):
    skin, step, count = SKINS[name], 0.2 * A, 100
    seen = skin.surface_influence(step, count)
    n = np.arange(1.0, 75e3)
    k = n / skin.radius
    share = step * np.sinc(0.5 * k * step / np.pi) ** 2 / (np.pi * skin.radius)
    c, mean = skin.surface_compliance(k) * share[:, None, None], skin.surface_compliance(np.zeros(1))[0]
    scale = np.abs(seen).max()
    for j in (0, 1, 9, 60, 99):
        cos, sin = np.cos(k * j * step), np.sin(k * j * step)
        waves = [[c[:, 0, 0] @ cos, -c[:, 0, 1] @ sin], [c[:, 1, 0] @ sin, c[:, 1, 1] @ cos]]
        expected = np.array(waves) + mean * np.eye(2) * step / (2 * np.pi * skin.radius)
        assert np.abs(seen[:, :, j] - expected).max() < (1e-10 if j > 1 else 1e-7) * scale  # the sum's end


@pytest.mark.parametrize("name", FLAT)
def test_influence_on_layers_is_the_integral_of_their_waves(name):
    """By the trapezoidal rule in log k, which shares nothing with the panels; differences where there is no datum."""
    skin, step = SKINS[name], 0.2 * A
    seen = skin.surface_influence(step, 61)
    k = np.exp(np.linspace(np.log(1e-7 / A), np.log(600 / A), 100_001))
    weight = k * (np.log(k[1]) - np.log(k[0])) * step * np.sinc(0.5 * k * step / np.pi) ** 2 / np.pi
    c = skin.surface_compliance(k) * weight[:, None, None]

    def expected(j):
        cos, sin = np.cos(k * j * step), np.sin(k * j * step)
        return np.array([[c[:, 0, 0] @ cos, -c[:, 0, 1] @ sin], [c[:, 1, 0] @ sin, c[:, 1, 1] @ cos]])

    scale = np.abs(seen[:, :, 1:] - seen[:, :, :1]).max()
    absolute = np.array([[skin.grounded, True], [True, skin.grounded and not slides(skin)]])
    for j in (9, 20, 60):
        difference = seen[:, :, j] - seen[:, :, 4] - expected(j) + expected(4)
        assert np.abs(difference).max() < 2e-6 * scale
        assert np.abs((seen[:, :, j] - expected(j))[absolute]).max() < 2e-6 * scale
