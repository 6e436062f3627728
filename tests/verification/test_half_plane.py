"""What only a half plane knows: closed forms for the bodies that press it, and how its surface tilts and stretches."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import brentq

import subskin as ss

from .._tables import CONTACTS, MU, SKINS, A
from ._contract import FIRST, PAIRS, STEPS, panels, slope

HALF_PLANES = {name: skin for name, skin in SKINS.items() if isinstance(skin, ss.HalfPlane)}
SURFACE = A * np.array([-30.0, -2.13, -0.97, -0.61, -0.23, -0.07, 0.31, 0.47, 0.83, 1.21, 3.7])
"""Off every node, edge and tip of the contacts."""

each_skin = pytest.mark.parametrize("skin", HALF_PLANES.values(), ids=HALF_PLANES)
both = pytest.mark.parametrize(("skin", "contact"), [pair for pair in PAIRS if pair[0] in HALF_PLANES])


def points(count=40, seed=1):
    rng = np.random.default_rng(seed)
    return A * rng.uniform(0.2, 4.0, count), A * rng.uniform(-4.0, 4.0, count)


def is_proportional(contact):
    """Whether the shear is a multiple of the pressure."""
    c = CONTACTS[contact]()
    return contact != "sum" and np.allclose(c.shear(SURFACE) * c.normal_force, c.pressure(SURFACE) * c.tangential_force)


@pytest.mark.parametrize("contact", [*filter(is_proportional, CONTACTS)])
@pytest.mark.parametrize("skin", HALF_PLANES)
def test_gradient_rule(skin, contact):
    """d/dy eps_x of a shear f(y) is - d/dx eps_x of the pressure f(y) (FORMULAS.md section 2), for every nu."""
    x, y = points()
    h = x / 32
    press, drag = (replace(CONTACTS[contact](), angle=angle) for angle in (0.0, np.pi / 2))
    skin = SKINS[skin]
    press = skin.strain(press, x + h * STEPS[:, None], y)
    drag = skin.strain(drag, x, y + h * STEPS[:, None])
    by_x = np.einsum("i,in->n", FIRST, press.xx) / h
    by_y = np.einsum("j,jn->n", FIRST, drag.xx) / h
    scale = np.max([np.abs(press.xx[4]), np.abs(drag.xx[4])], axis=0) / x
    assert (np.abs(by_x + by_y) < 2e-8 * scale).all()


class TestHertz:
    @pytest.mark.parametrize("nu", [0.0, 0.3, 0.5])
    def test_surface_takes_the_cylinders_curvature(self, nu):
        """Independent of the law for the half width: the surface of a skin pressed straight has to follow y^2/(2R)."""
        material, radius = ss.Material(young=0.4e6, poisson=nu), 8e-3
        touch = ss.Hertz.from_radius(40.0, radius, material, position=1e-3)
        y = 1e-3 + float(touch.half_width) * np.linspace(-0.99, 0.99, 11)
        gradient = ss.HalfPlane(material).surface_gradient(touch, y)
        np.testing.assert_allclose(gradient.ux, -(y - 1e-3) / radius, rtol=0, atol=1e-14)

    def test_outside_the_surface_leaves_the_cylinder(self):
        material = ss.Material(young=0.4e6)
        touch = ss.Hertz.from_radius(40.0, 8e-3, material)
        y = float(touch.half_width) * np.array([1.01, 1.5, 3.0])
        assert (ss.HalfPlane(material).surface_gradient(touch, y).ux > -y / 8e-3).all()

    @pytest.mark.parametrize(
        ("plane", "nu", "depth"),
        [
            ("strain", 0.49, 0.76791),
            ("strain", 0.45, 0.69804),
            ("strain", 0.4, 0.61635),
            ("strain", 0.3, 0.46542),
            ("strain", 0.2, 0.32168),
            ("stress", 0.5, 0.51440),
            ("stress", 0.49, 0.50776),
            ("stress", 0.45, 0.48051),
            ("stress", 0.4, 0.44469),
            ("stress", 0.3, 0.36579),
            ("stress", 0.2, 0.27345),
        ],
    )
    def test_blind_depth(self, plane, nu, depth):
        """Where the slope of eps_x beneath the middle vanishes for every angle (FORMULAS.md section 2)."""
        assert abs(self.blind(plane, nu) - depth) < 5.1e-6

    def test_blind_depth_of_incompressible_skin(self):
        np.testing.assert_allclose(self.blind("strain", 0.5), np.sqrt((np.sqrt(5) - 1) / 2), rtol=1e-9)

    @staticmethod
    def blind(plane, nu):
        skin = ss.HalfPlane(ss.Material(1.0, nu), plane=plane)
        drag = ss.Hertz(1.0, np.pi / 2, half_width=1.0)
        h = 1 / 64
        return brentq(lambda x: FIRST @ skin.strain(drag, x, h * STEPS).xx, 0.1, 1.5, xtol=1e-13)

    @pytest.mark.parametrize("x", [0.1, 0.5, 2.0])
    def test_angle_from_two_depths(self, x):
        """tan(angle) = -(d eps_x/dy) / (d eps_x/dx) beneath the middle: no modulus, width or force needed."""
        touch, h = ss.Hertz(3.0, 0.5, half_width=1.0), x / 32
        skin = ss.HalfPlane(ss.Material(1.0, 0.3))
        by_y = FIRST @ skin.strain(touch, x, h * STEPS).xx
        by_x = FIRST @ skin.strain(touch, x + h * STEPS, 0.0).xx
        np.testing.assert_allclose(-by_y / by_x, np.tan(0.5), rtol=1e-8)


class TestPunch:
    @each_skin
    def test_stays_flat(self, skin):
        y = A * np.linspace(-0.98, 0.98, 9)
        for position in (0.0, 3 * A):
            punch = ss.FlatPunch(40.0, position=position, half_width=A)
            np.testing.assert_allclose(skin.surface_gradient(punch, position + y).ux, 0.0, atol=1e-13)

    @pytest.mark.parametrize("nu", [0.0, 0.3, 0.5])
    def test_moment_tilts_it(self, nu):
        """By 4 (1 - nu^2) M / (pi E a^2): Johnson (1985), section 2.8."""
        skin = ss.HalfPlane(ss.Material(0.4e6, nu))
        moment = 10 * A
        punch = ss.FlatPunch(40.0, half_width=A, moment=moment)
        tilt = 4 * (1 - nu**2) * moment / (np.pi * 0.4e6 * A**2)
        np.testing.assert_allclose(skin.surface_gradient(punch, A * np.linspace(-0.98, 0.98, 9)).ux, tilt, rtol=1e-12)


@pytest.mark.parametrize("nu", [0.0, 0.3, 0.5])
@pytest.mark.parametrize("vertex_angle", [2.8, 3.1])
def test_wedge_pushes_the_surface_to_its_flanks(nu, vertex_angle):
    material = ss.Material(0.4e6, nu)
    wedge = ss.Wedge.from_angle(40.0, vertex_angle, material, position=1e-3)
    share = np.array([-0.99, -0.4, -1e-3, 1e-3, 0.2, 0.99])
    gradient = ss.HalfPlane(material).surface_gradient(wedge, 1e-3 + float(wedge.half_width) * share)
    np.testing.assert_allclose(gradient.ux, -np.sign(share) / np.tan(vertex_angle / 2), rtol=1e-12)


class TestPartialSlip:
    TOUCH = ss.PartialSlip(40.0, 0.3, half_width=A, friction=MU)

    def test_sticks_inside_and_slips_outside(self):
        """At nu = 1/2 the pressure moves no point along the surface, so what sticks must not be stretched either."""
        skin, c = SKINS["half plane-0.5"], float(self.TOUCH.stick_half_width)
        inside = skin.surface_gradient(self.TOUCH, c * np.linspace(-0.99, 0.99, 9)).uy
        slips = skin.surface_gradient(self.TOUCH, np.linspace(1.05 * c, 0.99 * A, 9)).uy
        np.testing.assert_allclose(inside, 0.0, atol=1e-16 + 1e-12 * np.abs(slips).max())
        assert (slips < -1e-3 * 40 / (A * 0.4e6)).all()  # the skin lags behind what drags it

    def test_shear_is_held_by_friction(self):
        y = A * np.linspace(-0.999, 0.999, 201)
        p, q = self.TOUCH.pressure(y), self.TOUCH.shear(y)
        sticks = np.abs(y) < self.TOUCH.stick_half_width
        np.testing.assert_allclose(q[~sticks], MU * p[~sticks], rtol=1e-12)
        assert (q[sticks] < MU * p[sticks]).all()
        assert (q > 0).all()

    @pytest.mark.parametrize("angle", [np.arctan(MU), -np.arctan(MU)])
    def test_on_the_edge_of_the_cone_it_is_a_sliding_hertz(self, angle):
        x, y = points()
        skin = SKINS["half plane-0.3"]
        slides, sticks = (ss.Hertz(40.0, angle, half_width=A), ss.PartialSlip(40.0, angle, half_width=A, friction=MU))
        np.testing.assert_allclose(skin.stress(sticks, x, y).xy, skin.stress(slides, x, y).xy, rtol=1e-7)
        assert float(sticks.stick_half_width) < 1e-7 * A


def test_profile_converges_to_hertz_with_the_square_of_the_pitch():
    """Nodes closer together towards the edges (y = a sin), where the pressure's slope is infinite."""
    skin, x, y = SKINS["half plane-0.5"], A * np.array([0.3, 1.0, 2.0]), A * np.array([0.2, -0.9, 1.5])
    hertz = ss.Hertz(40.0, 0.4, half_width=A)
    exact, counts = skin.strain(hertz, x, y).xx, np.array([9, 17, 33, 65, 129])
    errors = []
    for count in counts:
        nodes = A * np.sin(np.linspace(-np.pi / 2, np.pi / 2, count))
        sampled = ss.PressureProfile(nodes, hertz.pressure(nodes), hertz.shear(nodes))
        errors.append(np.abs(skin.strain(sampled, x, y).xx - exact).max())
    assert abs(slope(1 / (counts - 1), errors) - 2) < 0.05
    assert errors[-1] < 3e-4 * np.abs(exact).max()


@each_skin
def test_a_profile_of_two_nodes_is_a_strip(skin):
    x, y = points()
    strip = ss.Strip(40.0, 0.4, 0.2e-3, half_width=A)
    p, q = strip.normal_force / (2 * A), strip.tangential_force / (2 * A)
    profile = ss.PressureProfile([0.2e-3 - A, 0.2e-3 + A], [p, p], [q, q])
    for name in ("xx", "yy", "xy"):
        seen, expected = getattr(skin.stress(profile, x, y), name), getattr(skin.stress(strip, x, y), name)
        np.testing.assert_allclose(seen, expected, rtol=0, atol=1e-13 * 40 / A)


@both
def test_surface_gradient_is_the_strain_along_the_surface(skin, contact):
    """du_y/dy at the surface is eps_y there: two routes from the same transforms, one through Hooke's law."""
    skin, build = SKINS[skin], CONTACTS[contact]
    gradient, mirrored = (skin.surface_gradient(build(side), side * SURFACE) for side in (1, -1))
    np.testing.assert_allclose(gradient.uy, skin.strain(build(), 0.0, SURFACE).yy, rtol=0, atol=1e-14)
    np.testing.assert_allclose(mirrored.uy, gradient.uy, rtol=0, atol=1e-14)
    np.testing.assert_allclose(mirrored.ux, -gradient.ux, rtol=0, atol=1e-14)


@both
def test_tilt_of_the_surface_from_the_strain_within(skin, contact):
    """d/dx (du_x/dy) = d eps_x/dy and there is no tilt far below: the integral of the latter over depth is the tilt."""
    skin, contact = SKINS[skin], CONTACTS[contact]()
    y = A * np.array([2.3, -2.6])[:, None]
    log_x, weight = panels(np.log(A) + np.linspace(-28.0, 28.0, 57))
    x = np.exp(log_x)
    h = np.hypot(x, 0.5 * A) / 32  # outside the contact the field is smooth up to the surface
    bend = np.einsum("j,jyn->yn", FIRST, skin.strain(contact, x, y + h * STEPS[:, None, None]).xx) / h
    np.testing.assert_allclose(skin.surface_gradient(contact, y[:, 0]).ux, -bend @ (x * weight), rtol=1e-7, atol=1e-9)
