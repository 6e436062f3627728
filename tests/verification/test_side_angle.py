"""The angle on a side: against quadrature and reference values; the gradient rule; what misleads."""

from __future__ import annotations

import json
from functools import partial

import numpy as np
import pytest

import subskin as ss

from ._side_angle import (
    EXACT,
    FAMILIES,
    FULL_SCALE,
    OK,
    RUBBER,
    SKINS,
    gradients,
    integrals,
    row,
    slope,
    strain_xx,
    two_rows,
)


@pytest.mark.parametrize(("nu", "plane"), [(0.5, "strain"), (0.31, "strain"), (0.5, "stress"), (0.2, "stress")])
@pytest.mark.parametrize("shape", FAMILIES)
def test_slope_and_strain_by_quadrature_give_the_angle(shape, nu, plane):
    skin = ss.HalfPlane(ss.Material(3e5, nu), plane=plane)
    for depth in (0.1, 0.55, 2.0, 6.0):
        strain, rise = integrals(shape, depth, nu, plane)
        told = ss.estimate.side_angle_from_slope(
            rise * np.sin(0.4) / 3e5, strain * np.cos(0.4) / 3e5, skin, shape, depth=depth, half_width=1.0, **EXACT
        )
        assert told.status == OK
        assert told.angle == pytest.approx(0.4, abs=1e-9)


def test_reference_values(shared):
    """22 digits; the file keeps the memo's angle, which drags towards -y."""
    data = json.loads((shared / "reference" / "05b_hertz_centre_slope.json").read_text())
    p, points = data["parameters"], data["points"]
    x, rise, strain = (
        np.array([float(point[key]) for point in points])
        for key in ("x", "slope_deps_x_dy_at_centre", "eps_x_at_centre")
    )
    told = ss.estimate.side_angle_from_slope(
        rise, strain, ss.HalfPlane(ss.Material(p["E"], p["nu"])), depth=x, half_width=p["a"], **EXACT
    )
    assert (told.status == OK).all()
    assert told.angle == pytest.approx(np.full(x.shape, -p["alpha"]), abs=2e-10)


@pytest.mark.parametrize(
    ("nu", "strain", "stress"),
    [
        (0.5, 0.78615, 0.51440),
        (0.49, 0.76791, 0.50776),
        (0.45, 0.69804, 0.48051),
        (0.4, 0.61635, 0.44469),
        (0.3, 0.46542, 0.36579),
        (0.2, 0.32168, 0.27345),
    ],
)
def test_blind_depth_at_every_nu(nu, strain, stress):
    for plane, expected in (("strain", strain), ("stress", stress)):
        skin = ss.HalfPlane(ss.Material(1.0, nu), plane=plane)
        blind = ss.estimate.blind_depth(skin, [1.0, 2e-3])
        assert blind / [1.0, 2e-3] == pytest.approx(np.full(2, expected), abs=6e-6)
        assert abs(integrals("hertz", float(blind[0]), nu, plane)[1]) < 1e-10


def test_blind_depth_of_every_shape():
    skin = SKINS["half plane"]
    assert ss.estimate.blind_depth(skin, 1.0) == pytest.approx(np.sqrt((np.sqrt(5) - 1) / 2), abs=1e-10)
    assert ss.estimate.blind_depth(skin, 1.0, "punch") == pytest.approx(np.sqrt(2), abs=1e-10)
    assert ss.estimate.blind_depth(skin, 1.0, "strip") == pytest.approx(1.0, abs=1e-10)
    assert np.isnan(ss.estimate.blind_depth(skin, 1.0, "wedge"))
    x = np.geomspace(1e-3, 1e3, 50)
    line = ss.estimate.side_angle_from_slope(-1.0, -x, skin, "line", depth=x, **EXACT)
    assert line.angle == pytest.approx(np.full(50, np.pi / 4))  # slope / strain = tan(angle) / x
    # without a third dimension to give way to, a slice of nu = 0 and a block of it never lose the slope
    assert np.isnan(ss.estimate.blind_depth(ss.HalfPlane(ss.Material(1.0, 0.0)), 1.0))


def test_blind_depth_on_layers_goes_over_into_the_half_planes():
    thick = [float(ss.estimate.blind_depth(ss.Layered(ss.Layer(RUBBER, h)), 1.0)) for h in (2.0, 8.0, 32.0)]
    blind = float(ss.estimate.blind_depth(SKINS["half plane"], 1.0))
    off = np.abs(np.array(thick) - blind)
    assert (np.diff(off) < 0).all()
    assert off[2] < 1.5e-3 * blind
    assert off[0] > 0.05 * blind


@pytest.mark.parametrize("skin", [k for k in SKINS if k not in ("layer", "round")])
@pytest.mark.parametrize("shape", FAMILIES)
def test_the_gradient_rule_is_exact_on_a_half_plane(shape, skin):
    touch = FAMILIES[shape](1.0, 0.35, half_width=1.0)
    for depth in (0.2, 0.7, 1.9, 5.0):
        for quantity in (
            lambda x, y: SKINS[skin].strain(touch, x, y).xx,
            lambda x, y: SKINS[skin].stress(touch, x, y).xx,
            lambda x, y: SKINS[skin].stress(touch, x, y).mean_pressure,
        ):
            along, into = gradients(quantity, depth, 0.03 * depth)
            # differences lose what cancels in them, most near the depth where both vanish
            assert along / into == pytest.approx(-np.tan(0.35), rel=1e-5)


def test_the_gradient_rule_fails_on_a_bonded_layer():
    """A layer of twice the sensors' depth, half width = depth: 17.2 degrees come out as 11.5."""
    touch = ss.Hertz(1.0, 0.3, half_width=1.0)
    told = []
    for skin in (SKINS["half plane"], ss.Layered(ss.Layer(RUBBER, 2.0))):
        along, into = gradients(partial(strain_xx, skin, touch), 1.0, 0.02)
        told.append(np.rad2deg(np.arctan(-along / into)))
    assert told[0] == pytest.approx(17.19, abs=0.01)
    assert told[1] == pytest.approx(11.5, abs=0.1)
    for skin in ("layer", "round"):
        with pytest.raises(ss.errors.InvalidValueError, match="half plane alone"):
            ss.estimate.side_angle_from_gradients(two_rows(skin=SKINS[skin]), np.zeros(18), position=0.0)


@pytest.mark.parametrize("skin", SKINS.values(), ids=SKINS)
@pytest.mark.parametrize("shape", [*FAMILIES, "line"])
@pytest.mark.parametrize("transducer", [ss.NormalStrain(), ss.MeanPressure(), ss.ShearStrain()], ids=repr)
def test_exact_readings_give_the_angle_back(skin, shape, transducer):
    """Of any skin, contact and transducer, and with any number of sensors: the differences cut nothing off."""
    tip = row(skin=skin, transducer=transducer, gain=[1, 2, -3, 1, 0.5, 1, 1], offset=0.1)
    if shape == "line":
        touch, more = ss.LineLoad(40.0, 0.3, 0.13), {}
    else:
        touch, more = FAMILIES[shape](40.0, 0.3, 0.13, half_width=0.6), {"half_width": 0.6}
    for sensors in (3, 4, 5, 7):
        told = ss.side_angle(tip, tip.read(touch), shape, position=0.13, sensors=sensors, most_std=np.inf, **more)
        assert told.status == OK
        assert told.angle == pytest.approx(0.3, abs=1e-9)
        assert told.truncation == 0


def test_plain_differences_are_a_third_short():
    """What is allowed for: half a depth apart, five sensors see 0.64 of the slope beneath a line load."""
    y = 0.5 * np.arange(-2, 3)
    strain = SKINS["half plane"].strain(ss.LineLoad(1.0, np.pi / 2), 1.0, y).xx
    plain = np.array([1, -8, 0, 8, -1]) @ strain / 6
    assert plain / -FULL_SCALE == pytest.approx(0.64, rel=1e-12)  # (8 * 0.24 * 2 - 0) / 6


def test_the_position_of_the_largest_strain_tells_nothing():
    """Drag shifts it, by a sixth of its tangent in depths, and the slope there is 0: no drag, it says."""
    skin, y = SKINS["half plane"], np.linspace(-0.3, 0.3, 6001)
    strain = skin.strain(ss.LineLoad(1.0, 0.3), 1.0, y).xx
    peak = float(y[np.argmin(strain)])
    assert peak == pytest.approx(np.tan(0.3) / 6, rel=0.05)
    rise = slope(lambda s: float(skin.strain(ss.LineLoad(1.0, 0.3), 1.0, peak + s).xx), 0.02)
    told = ss.estimate.side_angle_from_slope(rise, strain.min(), skin, "line", depth=1.0, **EXACT)
    assert abs(told.angle) < 1e-3
