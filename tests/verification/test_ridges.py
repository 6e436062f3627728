"""Ridges against what must be true: exact contacts, Fourier series, Westergaard's ridges, and the memo's numbers."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.optimize import minimize_scalar
from scipy.special import j1

import subskin as ss
from subskin.contact.line import line_loads
from subskin.design import Ridges, best_ridge_pitch, press_ridges, ridge_gain, spatial_response
from subskin.design.ridges import closing_pressure, read_ridged
from subskin.design.ridges.gain import _readings
from subskin.response import Response

DEPTH, YOUNG = 0.5e-3, 0.4e6
BEST = 2 * np.pi * DEPTH
RUBBER = ss.Material(YOUNG, 0.5)
SOFT = ss.Material(YOUNG, 0.45)
SKINS = {
    "half plane": ss.HalfPlane(SOFT),
    "layer": ss.Layered(ss.Layer(SOFT, 2e-3)),
    "round": ss.Round(SOFT, 8e-3, 4e-3),
}
CONTACTS = {
    "line": ss.LineLoad(40.0, 0.3, 0.2e-3),
    "hertz": ss.Hertz(40.0, 0.3, 0.2e-3, half_width=1.7e-3),
    "strip": ss.Strip(40.0, 0.3, 0.2e-3, half_width=1.7e-3),
    "punch": ss.FlatPunch(40.0, 0.3, 0.2e-3, half_width=1.7e-3, moment=4e-3),
    "wedge": ss.Wedge(40.0, 0.3, 0.2e-3, half_width=1.7e-3),
    "slip": ss.PartialSlip(40.0, 0.3, 0.2e-3, half_width=1.7e-3, friction=0.5),
    "profile": ss.PressureProfile([-1e-3, 0.1e-3, 2e-3], [0.0, 2e4, 1e3], [0.0, 5e3, 0.0]),
}
CONTACTS["sum"] = CONTACTS["hertz"] + CONTACTS["line"] + CONTACTS["profile"]


def finger(skin=None, **array):
    return ss.Finger(skin or ss.HalfPlane(RUBBER), ss.SensorArray(**{"y": [0.0], "depth": DEPTH, **array}))


def hertz(a, **more):
    return ss.Hertz(40.0, half_width=a, **more)


@pytest.mark.parametrize(
    ("skin", "contact"),
    [*(("half plane", c) for c in CONTACTS), ("layer", "slip"), ("round", "slip"), ("round", "sum")],
)
def test_ridges_without_valleys_are_the_smooth_contact(skin, contact):
    tip = finger(
        SKINS[skin],
        y=[-1.3e-3, 0.4e-3, 0.0],
        depth=[DEPTH, 0.8e-3, 0.6e-3],
        width=[0.0, 0.0, 0.7e-3],
        transducer=[ss.NormalStrain(), ss.ShearStrain(), ss.MeanPressure()],
        gain=[1.0, -2.0, 1e-6],
        offset=[0.0, 0.1, 0.0],
    )
    whole = Ridges(0.9e-3, "square", duty=1.0, crest=0.123e-3)
    np.testing.assert_allclose(read_ridged(tip, CONTACTS[contact], whole), tip.read(CONTACTS[contact]), rtol=3e-8)


def test_a_pressure_of_many_straight_lines():
    y = np.linspace(-1.7e-3, 1.7e-3, 301)
    fine = ss.PressureProfile(y, 1e4 * np.cos(700 * y) ** 2 + 1e3, 3e3 * np.sin(1500 * y))
    tip = finger(y=[-1.3e-3, 0.4e-3, 0.0])
    whole = Ridges(0.9e-3, "square", duty=1.0)
    np.testing.assert_allclose(read_ridged(tip, fine, whole), tip.read(fine), rtol=1e-8)


def test_half_round_a_finger():
    """Places beyond the ends of the contact are nearer the other way round."""
    skin, wide, depth = SKINS["round"], 0.25 * 2 * np.pi * 8e-3, 3e-3
    touch = ss.Strip(40.0, half_width=wide)
    positions = np.linspace(-wide - 2.5 * depth, wide + 2.5 * depth, 2001)
    tip = finger(skin, y=positions, depth=depth, transducer=ss.LateralStrain())
    found = ridge_gain(tip, touch, Ridges(BEST, "square", duty=1.0))
    assert found.smooth == pytest.approx(np.abs(tip.read(touch)).max(), rel=1e-5)
    assert found.equal_peak.peak == pytest.approx(1.0, rel=1e-9)
    assert found.equal_peak.ripple == pytest.approx(0.0, abs=1e-9)
    lines = line_loads(touch, np.array([0.0]), depth)
    alone, half = finger(skin, depth=depth, transducer=ss.LateralStrain()), 0.5 * skin.period
    field = Response.from_function(alone.receptive_field, -half, half, step=depth / 16)
    readings = _readings(field, skin.period, lines, np.ones((1, lines.y.size)), positions)[0]
    np.testing.assert_allclose(readings, tip.read(touch), rtol=0, atol=1e-7 * found.smooth)


def test_a_square_ridge_is_its_strips():
    tip = finger(y=[-0.4e-3, 0.0, 1.1e-3])
    strip = ss.Strip(40.0, 0.3, half_width=2e-3)
    pitch, duty, crest = 1.1e-3, 0.4, 0.2e-3
    ends = [(crest + (m - duty / 2) * pitch, crest + (m + duty / 2) * pitch) for m in range(-4, 5)]
    parts = [(max(a, -2e-3), min(b, 2e-3)) for a, b in ends if b > -2e-3 and a < 2e-3]
    strips = sum(ss.Strip(40.0 * (b - a) / 4e-3, 0.3, 0.5 * (a + b), half_width=0.5 * (b - a)) for a, b in parts)
    ridged = read_ridged(tip, strip, Ridges(pitch, "square", duty=duty, crest=crest))
    np.testing.assert_allclose(ridged, tip.read(strips), rtol=1e-8)


@pytest.mark.parametrize("shape", ["abs_cos", "cos_squared", "raised_cosine"])
def test_a_wide_strip_reads_as_the_fourier_series(shape):
    """Far from its ends every harmonic is answered by its own wave: |cos| has them all, the others but one."""
    series = {
        "abs_cos": [4 / np.pi * (-1) ** (n + 1) / (4 * n**2 - 1) for n in range(1, 30)],
        "cos_squared": [0.5],
        "raised_cosine": [1 / 3],
    }[shape]
    n = np.arange(1, len(series) + 1)
    mean = {"abs_cos": 2 / np.pi, "cos_squared": 0.5, "raised_cosine": 2 / 3}[shape]
    pitch = 4.1 * DEPTH
    a, crest = 10 * pitch, 0.3 * pitch  # it ends on crests, where the harmonics' sums are 0
    for angle, load in ((0.0, 0), (np.pi / 2, 1)):
        strip = ss.Strip(2 * a, angle, crest, half_width=a)  # 1 Pa
        tip = finger(ss.HalfPlane(SOFT), transducer=ss.NormalStrain())
        alone = read_ridged(tip, strip, Ridges(pitch, shape, crest=crest)) - mean * tip.read(strip)
        waves = spatial_response(tip, 2 * np.pi * n / pitch).amplitude[:, 0, load]
        expected = (series * waves * np.exp(-2j * np.pi * n * crest / pitch)).real.sum()
        assert alone[0] == pytest.approx(expected, abs=2e-4 * np.abs(waves).max())


def test_the_memos_load_and_strain():
    """Hertz over 10 depths, pitch 2 pi depths: loads in closed form, strains by straight lines and a half plane."""
    a = 10 * DEPTH

    def under(y):
        return 0.5 * (y * np.sqrt(a**2 - y**2) + a**2 * np.arcsin(y / a))

    ka = 2 * np.pi * a / BEST
    third = BEST / 3
    loads = {
        "abs_cos": None,
        "raised_cosine": 1 / (2 / 3 + 2 * j1(ka) / ka / 3),
        "square": under(a) / (under(third) - under(2 * third) + under(4 * third)),
    }
    printed = {"abs_cos": (1.564, 2.017), "raised_cosine": (1.494, 1.893), "square": (1.4905, 2.026)}
    y = a * np.sin(np.linspace(-np.pi / 2, np.pi / 2, 6001))
    positions = np.concatenate([np.linspace(-0.7, 0.7, 57), np.linspace(9, 11, 81)]) * DEPTH
    skin = ss.HalfPlane(RUBBER)
    smooth = ss.PressureProfile(y, np.sqrt(np.maximum(a**2 - y**2, 0.0)))
    before = np.abs(skin.strain(smooth, DEPTH, positions).xx).max()
    for shape, load in loads.items():
        found = ridge_gain(finger(), hertz(a), Ridges(BEST, shape))
        if load is not None:
            assert found.load_ratio == pytest.approx(load, rel=1e-9)
        assert found.load_ratio == pytest.approx(printed[shape][0], abs=6e-4)
        assert found.equal_peak.peak == pytest.approx(printed[shape][1], abs=6e-4)
        assert found.equal_load.peak == pytest.approx(found.load_ratio * found.equal_peak.peak, rel=1e-14)
        share = {
            "abs_cos": np.abs(np.cos(np.pi * y / BEST)),
            "raised_cosine": (2 + np.cos(2 * np.pi * y / BEST)) / 3,
            "square": 1.0 * (np.abs(y / BEST - np.round(y / BEST)) < 1 / 3),
        }[shape]
        ridged = ss.PressureProfile(y, smooth.node_pressure * share)
        after = np.abs(skin.strain(ridged, DEPTH, positions).xx).max()
        limit = 2e-3 if shape == "square" else 1e-4  # straight lines cut a jump's corners
        assert found.equal_peak.peak == pytest.approx(after / before, rel=limit)
    wide = ridge_gain(finger(), hertz(DEPTH * np.array([5.0, 30.0])), Ridges(BEST))
    np.testing.assert_allclose(wide.equal_peak.peak, [1.49, 2.24], atol=6e-3)


def test_a_contact_narrower_than_a_ridge_gains_nothing():
    narrow = hertz(0.05 * DEPTH * np.ones(2))
    found = ridge_gain(finger(), narrow, Ridges(BEST, crest=[0.0, 0.5e-3]))
    np.testing.assert_allclose(found.equal_load.peak, 1.0, rtol=2e-3)
    np.testing.assert_allclose(found.equal_peak.peak, [1.0, np.cos(np.pi * 0.5e-3 / BEST)], rtol=2e-3)
    line = ridge_gain(finger(), ss.LineLoad(40.0), Ridges(BEST, crest=0.3 * BEST))
    assert line.equal_peak.peak == pytest.approx(np.cos(0.3 * np.pi), rel=1e-12)
    assert line.equal_load.peak == pytest.approx(1.0, rel=1e-12)
    assert line.half_width == 0


def test_shear_is_not_felt_at_the_best_pitch():
    """The harmonic's answer is 0; what is left comes from the contact's ends, and falls as it widens."""
    shares = []
    for a in np.array([5.0, 20.0, 80.0]) * DEPTH:
        pressed, dragged = (
            ridge_gain(finger(), hertz(a, angle=angle), Ridges(BEST, "raised_cosine")) for angle in (0.0, np.pi / 2)
        )
        parts = [g.equal_peak.ripple * g.smooth for g in (pressed, dragged)]
        shares.append(float(parts[1] / parts[0]))
    assert shares[0] > shares[1] > shares[2]
    assert shares[2] < 0.1
    # beneath the middle the ends are far, and there is as good as nothing
    row = finger(y=np.linspace(-1, 1, 41) * BEST)
    touch = hertz(45 * DEPTH)
    drag = ss.Hertz(40.0, np.pi / 2, half_width=45 * DEPTH)
    for ridges, least, most in (
        (Ridges(BEST, "raised_cosine"), 0.0, 0.01),
        (Ridges(BEST / 2, "raised_cosine"), 0.4, 1),
    ):
        normal, shear = (read_ridged(row, c, ridges) - 2 / 3 * row.read(c) for c in (touch, drag))
        assert least <= np.abs(shear).max() / np.abs(normal).max() < most


@pytest.mark.parametrize("poisson", [0.5, 0.4, 0.3])
def test_best_pitch_of_a_half_plane(poisson):
    tip = finger(ss.HalfPlane(ss.Material(YOUNG, poisson)), y=[0.0, 0.0], depth=[DEPTH, 1.7e-3])
    np.testing.assert_allclose(best_ridge_pitch(tip).pitch, np.pi / poisson * np.array([DEPTH, 1.7e-3]), rtol=1e-6)


def test_best_pitch_elsewhere():
    wide = best_ridge_pitch(finger(width=1.5 * DEPTH))
    size = minimize_scalar(lambda k: -k * np.exp(-k) * np.sinc(0.75 * k / np.pi), bracket=(0.5, 1.0)).x
    assert wide.pitch == pytest.approx(2 * np.pi * DEPTH / size, rel=1e-6)
    assert wide.normal == pytest.approx(1.5 / YOUNG * size * np.exp(-size) * np.sinc(0.75 * size / np.pi), rel=1e-9)
    # a pressure gauge feels uniform pressure most
    assert np.isinf(best_ridge_pitch(finger(transducer=ss.NormalStress())).pitch)
    # H = 20 depths: squeezing the layer is left out, and the depth's own maximum is that of the half plane
    thick = finger(ss.Layered(ss.Layer(RUBBER, 20 * DEPTH)))
    assert best_ridge_pitch(thick).pitch == pytest.approx(BEST, rel=2e-3)
    tip = ss.Round(RUBBER, 8e-3, 4e-3)
    number = 2 * np.pi * 8e-3 / best_ridge_pitch(finger(tip)).pitch[0]
    assert number == pytest.approx(round(number), abs=1e-9)
    around = spatial_response(finger(tip), np.array([-1, 0, 1]) / 8e-3 + round(number) / 8e-3).magnitude[:, 0, 0]
    assert around.argmax() == 1


@pytest.mark.parametrize("skin", ["half plane", "layer"])
def test_ridges_close_at_the_closing_pressure(skin):
    body, pitch, amplitude = SKINS[skin], 1.3e-3, 20e-6
    limit = float(closing_pressure(body, pitch, amplitude))
    if skin == "half plane":
        assert limit == pytest.approx(np.pi * SOFT.plane_strain_modulus * amplitude / pitch, rel=1e-12)
    for share in (0.98, 1.02):
        pressed = ss.press(
            body, ss.pressing.SineRidges(pitch, amplitude), force=share * limit * pitch, period=pitch, nodes=256
        )
        assert (pressed.pressure > 0).all() == (share > 1)


def test_a_whole_number_of_ridges_closes_round_a_finger():
    body = SKINS["round"]
    for number, pitch in ((31, 30.7), (31, 31.4), (2, 1.1)):
        around = closing_pressure(body, 2 * np.pi * 8e-3 / pitch, 20e-6)
        assert around == pytest.approx(20e-6 / body.surface_compliance(number / 8e-3)[0, 0], rel=1e-12)


def test_pressed_ridges_obey_westergaard():
    """Just closed: p = p0 cos^2, twice the smooth pressure at the crests; closed: a ripple that no load changes."""
    r, force = 500e-3, 200.0
    peak = np.sqrt(force * RUBBER.plane_strain_modulus / (np.pi * r))  # Hertz
    amplitude = np.array([0.33, 1.0]) * peak / (np.pi * RUBBER.plane_strain_modulus / BEST)
    found = press_ridges(finger(), BEST, amplitude, force=force, radius=r, shape="cos_squared")
    assert (found.status == ss.pressing.PressStatus.OK).all()
    assert found.filling[1] == pytest.approx(1.0, abs=0.01)
    assert found.crest[1] == pytest.approx(2.0, rel=0.01)
    assert found.valley[1] < 0.01
    assert found.solved.peak[1] == pytest.approx(found.assumed.peak[1], rel=0.02)
    # p + p* cos: valley over crest (f - 1)/(f + 1), the valley's own pressure being a little lower than the middle's
    f = found.filling[0]
    assert found.valley[0] == pytest.approx((f - 1) / (f + 1), rel=0.03)
    assert found.touching[0] == 1
    twice = press_ridges(finger(), BEST, amplitude[0], force=2 * force, radius=r)
    middle = []
    for load in (force, 2 * force):
        p = ss.press(ss.HalfPlane(RUBBER), ss.pressing.SineRidges(BEST, float(amplitude[0]), r), force=load).contact
        q = ss.press(ss.HalfPlane(RUBBER), ss.pressing.Cylinder(r), force=load).contact
        middle.append(float(finger().read(p)[0] - finger().read(q)[0]))
    ripple = -1.5 / np.e / YOUNG * float(closing_pressure(ss.HalfPlane(RUBBER), BEST, amplitude[0]))
    np.testing.assert_allclose(middle, ripple, rtol=0.02)
    assert twice.solved.peak < found.solved.peak[0]
