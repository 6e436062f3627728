"""The skin as a filter against transforms of the receptive field, against amplitudes of 22 digits, and limits."""

from __future__ import annotations

import json

import numpy as np
import pytest
from scipy.special import erfc

import subskin as ss
from subskin.design import spatial_response
from subskin.memo import eq24, eq25_corrected

RUBBER = ss.Material(1.0, 0.47)
SENSORS = ss.SensorArray(
    y=[0.15, -0.5, 1.0, 0.3],
    depth=[1.0, 0.5, 0.75, 1.0],
    width=[0.0, 0.0, 1.5, 0.4],
    gain=[1.0, -2.0, 1.0, 3.0],
    transducer=[ss.NormalStrain(), ss.ShearStrain(), ss.MeanPressure(), ss.VolumeResistance(exact=True)],
)
FLAT = {
    "half plane": ss.HalfPlane(RUBBER),
    "plane stress": ss.HalfPlane(RUBBER, "stress"),
    "incompressible": ss.HalfPlane(ss.Material(1.0, 0.5)),
    "bonded": ss.Layered(ss.Layer(RUBBER, 2.5)),
    "epidermis": ss.Layered([ss.Layer(ss.Material(5.0, 0.48), 0.6), ss.Layer(RUBBER, 1.9)]),
    "on a half plane": ss.Layered(ss.Layer(RUBBER, 1.5), base=ss.Material(3.0, 0.3)),
}
WAVES = np.array([1.7, 2.3, 3.1])


@pytest.mark.parametrize("skin", FLAT.values(), ids=FLAT)
def test_it_is_the_transform_of_the_receptive_field(skin):
    """By the trapezoidal rule, exact to rounding for what is analytic, with an end so smooth that no wave sees it."""
    finger = ss.Finger(skin, SENSORS)
    step, reach, width = 0.1, 27.0, 5.8
    count = np.ceil((reach + 4.7 * width) / step)
    y = np.arange(-count, count + 1) * step
    weight = step * 0.5 * erfc((np.abs(y) - reach) / width)
    field = finger.receptive_field(y)
    summed = np.einsum("ky,ynl->knl", np.exp(1j * WAVES[:, None] * y) * weight, field)
    found = spatial_response(finger, WAVES).amplitude
    assert (np.abs(found - summed).max(axis=(0, 2)) < 1e-9 * np.abs(found).max(axis=(0, 2))).all()


@pytest.mark.parametrize("poisson", [0.5, 0.3])
def test_it_is_the_series_of_the_receptive_field_round_a_finger(poisson):
    skin = ss.Round(ss.Material(1.0, poisson), radius=4.0, core_radius=2.0)
    finger = ss.Finger(skin, SENSORS)
    n, count = np.array([0, 1, 2, 3, 7, 20]), 800
    y = skin.period / count * np.arange(count)
    field = finger.receptive_field(y)
    waves = np.exp(1j * n[:, None] / skin.radius * y) * (skin.period / count)
    summed = np.einsum("ky,ynl->knl", waves, field)
    found = spatial_response(finger, n / skin.radius).amplitude
    assert np.abs(found - summed).max() < 1e-12 * np.abs(found).max()


def test_it_is_equation_25_and_that_the_transform_of_equation_24():
    s, d, young = np.array([0.01, 0.05, 0.2, 0.7]), 1.3, 2.5
    finger = ss.Finger(ss.HalfPlane(ss.Material(young)), ss.SensorArray(y=[0.0], depth=d))
    found = spatial_response(finger, 2 * np.pi * s).amplitude[:, 0, 0] * young
    assert found == pytest.approx(eq25_corrected(s, d), rel=1e-13)
    assert not found.imag.any()
    y = 0.05 * np.arange(-40000, 40001)
    taper = 0.5 * erfc((np.abs(y) - 1200.0) / 120.0)
    summed = 0.05 * np.cos(2 * np.pi * s[:, None] * y) @ (eq24(d, y) * taper)
    assert found.real == pytest.approx(summed, abs=2e-11)


QUANTITIES = {
    "ex": (ss.NormalStrain(), "even"),
    "ey": (ss.LateralStrain(), "even"),
    "sx": (ss.NormalStress(), "even"),
    "gxy": (ss.ShearStrain(), "odd"),
}


def expected(point, load):
    """Complex amplitudes of `QUANTITIES` under exp(i k y), from those of cos and sin."""
    values = {name: float(point[name]) for name in QUANTITIES}
    turn = {"p": {"even": 1, "odd": -1j}, "q": {"even": 1j, "odd": 1}}[load]
    return np.array([turn[QUANTITIES[name][1]] * value for name, value in values.items()])


def test_bonded_layer_of_22_digits(shared):
    points = json.loads((shared / "reference" / "09a_bonded_layer_transfer.json").read_text())["points"]
    kinds = [kind for kind, _ in QUANTITIES.values()]
    compared = 0
    for point in points:
        nu, k, height, depth = (float(point[name]) for name in ("nu", "k", "H", "d"))
        if depth > 0:
            skin = ss.Layered(ss.Layer(ss.Material(2.0, nu), height))
            array = ss.SensorArray(y=[0.0] * 4, depth=depth, transducer=kinds)
            found = spatial_response(ss.Finger(skin, array), k).amplitude
            for load, name in enumerate(("normal_p_cos", "tangential_q_sin")):
                want = expected(point[name], "pq"[load])
                assert np.abs(found[:, load] - want).max() < 1e-10 * np.abs(want).max(), point
                compared += 1
    assert compared > 150


@pytest.mark.filterwarnings("ignore::subskin.errors.ValidityWarning")  # units of its own
def test_annulus_of_22_digits(shared):
    points = json.loads((shared / "reference" / "10a_annulus_modes.json").read_text())["points"]
    kinds = [kind for kind, _ in QUANTITIES.values()]
    names = {"ex": "err", "ey": "ett", "sx": "srr", "gxy": "grt"}
    compared = 0
    for point in points:
        nu, n, radius, core, r = (float(point[name]) for name in ("nu", "n", "R", "Rc", "r"))
        if r < radius and n > 0:
            skin = ss.Round(ss.Material(2.0, nu), radius, core)
            array = ss.SensorArray(y=[0.0] * 4, depth=radius - r, transducer=kinds)
            found = spatial_response(ss.Finger(skin, array), n / radius).amplitude
            for load, name in enumerate(("p_cos", "q_sin")):
                # depth points inwards: the shear strain changes its sign
                own = {k: float(point[name][v]) * (-1 if k == "gxy" else 1) for k, v in names.items()}
                scale = max(abs(float(v)) for v in point[name].values())
                assert np.abs(found[:, load] - expected(own, "pq"[load])).max() < 1e-10 * scale, point
                compared += 1
    assert compared > 80


@pytest.mark.parametrize("count", [1, 3])
def test_width_takes_the_mean_over_it(count):
    """The mean of narrow sensors spread over the width, by Gauss's rule, is the wide sensor."""
    skin = ss.HalfPlane(RUBBER)
    k, width = np.array([0.0, 0.4, 2.0, 2 * np.pi / 1.5, 9.0])[:: 1 if count > 1 else 2], 1.5
    t, w = np.polynomial.legendre.leggauss(24)
    many = ss.Finger(skin, ss.SensorArray(y=0.3 + 0.5 * width * t, depth=1.0))
    one = ss.Finger(skin, ss.SensorArray(y=[0.3], depth=1.0, width=width))
    mean = np.einsum("knl,n->kl", spatial_response(many, k).amplitude, 0.5 * w)
    assert np.abs(spatial_response(one, k).amplitude[:, 0] - mean).max() < 1e-14


def one(skin, depth=1.0, **more):
    return ss.Finger(skin, ss.SensorArray(y=[0.0], depth=depth, **more))


def test_a_uniform_pressure_is_felt_by_a_compressible_half_plane_alone():
    def felt(skin):
        return spatial_response(one(skin), 0.0).amplitude[0, 0]

    assert felt(ss.HalfPlane(ss.Material(2.0, 0.5))) == 0
    for nu in (0.0, 0.3, 0.49):
        uniaxial = -(1 + nu) * (1 - 2 * nu) / 2.0
        assert felt(ss.HalfPlane(ss.Material(2.0, nu))) == pytest.approx(uniaxial, rel=1e-14)
        # bonded to a rigid base it cannot widen, and gives a different share of that
        layer = ss.Layered(ss.Layer(ss.Material(2.0, nu), 3.0))
        assert felt(layer) == pytest.approx(uniaxial / (1 - nu), rel=1e-9)
    assert abs(felt(ss.Layered(ss.Layer(ss.Material(2.0, 0.5), 3.0)))) < 1e-15
    # a layer that slides on its base can widen as it is pressed, incompressible or not: 3/(4G) in plane strain
    loose = ss.Layered(ss.Layer(ss.Material(2.0, 0.5), 3.0, "frictionless"))
    assert spatial_response(one(loose), 1e-7).amplitude[0, 0] == pytest.approx(-(1 - 0.25) / 2.0, rel=1e-6)


def test_long_waves_and_incompressibility_do_not_commute():
    """At nu = 1/2 the bonded layer answers as -(3/2E) k^2 (H^2 - d^2), else not at all so."""
    height, depth, young = 3.0, 1.0, 2.0
    k = np.array([1e-4, 1e-3, 1e-2]) / height
    found = spatial_response(one(ss.Layered(ss.Layer(ss.Material(young, 0.5), height)), depth), k)
    limit = -1.5 / young * k**2 * (height**2 - depth**2)
    assert found.amplitude[:, 0, 0].real / limit == pytest.approx(1.0, abs=2 * (0.01) ** 2)
    nearly = ss.Layered(ss.Layer(ss.Material(young, 0.4999), height))
    confined = -(1.4999 * 0.0002) / (young * 0.5001)
    assert spatial_response(one(nearly, depth), 0.0).amplitude[0, 0] == pytest.approx(confined, rel=1e-8)
    assert abs(confined) > 1e3 * abs(limit[0])


def test_shear_of_long_waves_reaches_a_half_plane_and_not_through_a_bonded_layer():
    half = one(ss.HalfPlane(ss.Material(2.0, 0.5)))
    assert spatial_response(half, 0.0).magnitude[0, 1] == pytest.approx(1.5 / 2.0, rel=1e-14)
    layer = one(ss.Layered(ss.Layer(ss.Material(2.0, 0.5), 3.0)))
    assert spatial_response(layer, 0.0).magnitude[0, 1] < 1e-8


def test_peak_and_zero_lie_at_a_wave_of_2_pi_depths():
    young, depth = 0.4e6, 2e-3
    finger = one(ss.HalfPlane(ss.Material(young, 0.5)), depth)
    k = np.linspace(0.2, 3.0, 2801) / depth
    found = spatial_response(finger, k)
    at = np.argmax(found.magnitude[:, 0, 0])
    assert found.wavelength[at] == pytest.approx(2 * np.pi * depth, rel=1e-12)
    assert found.magnitude[at, 0, 0] * young == pytest.approx(3 / (2 * np.e), rel=1e-13)
    assert found.magnitude[at, 0, 1] < 1e-15 * found.magnitude[0, 0, 1]
    # and the shear changes its side there
    shear = found.phase[[at - 1, at + 1], 0, 1]
    assert shear == pytest.approx([-np.pi / 2, np.pi / 2], abs=1e-12)


@pytest.mark.parametrize("skin", FLAT.values(), ids=FLAT)
def test_readings_under_a_contact_follow_from_it(skin):
    """Its spectrum times the amplitudes, summed over wavenumbers, is what the finger reads."""
    finger = ss.Finger(skin, SENSORS)
    touch = ss.Hertz(2.0, 0.4, 0.35, half_width=0.8)
    nodes, weights = np.polynomial.legendre.leggauss(12)
    edges = np.concatenate([[0.0], np.geomspace(1e-6, 0.1, 12), np.linspace(0.1, 90.0, 400)[1:]])
    half = 0.5 * np.diff(edges)[:, None]
    k = (edges[:-1, None] + half * (1 + nodes)).reshape(-1)
    spectrum = np.stack(touch.spectrum(k), axis=-1) * (half * weights).reshape(-1, 1)
    # the pressure is the sum of spectrum exp(i k y) / 2 pi over k of either sign
    summed = np.einsum("kl,knl->n", spectrum, spatial_response(finger, k).amplitude).real / np.pi
    seen = np.asarray(SENSORS.gain) * finger.measure(touch, linear=True)
    assert summed == pytest.approx(seen, abs=1e-9 * np.abs(seen).max())
