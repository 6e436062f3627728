"""What must be true of any half plane: one test body for all contacts, both planes and all Poisson's ratios."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.optimize import brentq

import subskin as ss
from subskin.contact import contact_of, families

A = 1.25e-3  # half width [m], the length scale of every test
MU = 0.6
SKINS = {
    f"{plane}-{nu}": ss.HalfPlane(ss.Material(young=0.4e6, poisson=nu), plane=plane)
    for plane in ("strain", "stress")
    for nu in (0.0, 0.3, 0.5)
}
SYMMETRIC = {
    name: lambda angle, position=0.0, a=A, name=name: contact_of(name, None if name == "line" else a)(
        40.0, angle, position
    )
    for name in families()
}
SHAPE = A * np.array([-1.0, -0.4, 0.1, 1.0]), np.array([2e3, 9e3, 4e3, 0.0]), np.array([0.0, 1e3, -4e3, 0.0])
CONTACTS = {
    **{name: build(0.4, 0.2e-3) for name, build in SYMMETRIC.items()},
    "pull": ss.Hertz(40.0, 2.6, half_width=A),
    "tilted": ss.FlatPunch(40.0, -0.3, 0.2e-3, half_width=A, moment=0.4 * 20 * A),
    "slip": ss.PartialSlip(40.0, 0.4, 0.2e-3, half_width=A, friction=MU),
    "profile": ss.PressureProfile(*SHAPE),
    "sum": ss.Strip(40.0, 0.3, -A, half_width=A) + ss.Hertz(10.0, -0.5, A, half_width=0.5 * A),
}
FIRST = np.array([1 / 280, -4 / 105, 1 / 5, -4 / 5, 0.0, 4 / 5, -1 / 5, 4 / 105, -1 / 280])
SECOND = np.array([-1 / 560, 8 / 315, -1 / 5, 8 / 5, -205 / 72, 8 / 5, -1 / 5, 8 / 315, -1 / 560])
STEPS = np.arange(-4, 5)


@pytest.fixture(params=SKINS.values(), ids=SKINS)
def skin(request):
    return request.param


@pytest.fixture(params=CONTACTS.values(), ids=CONTACTS)
def contact(request):
    return request.param


def stencil(x, y, share):
    """Points (9, 9, n) about (x, y), along x and along y, and the step: a share of the depth."""
    h = share * x
    return x + h * STEPS[:, None, None], y + h * STEPS[:, None], h


def points(count=40, seed=1):
    rng = np.random.default_rng(seed)
    return A * rng.uniform(0.2, 4.0, count), A * rng.uniform(-4.0, 4.0, count)


def test_equilibrium(skin, contact):
    x, y = points()
    xs, ys, h = stencil(x, y, 1 / 32)
    s = skin.stress(contact, xs, ys)

    def by_x(f):
        return np.einsum("i,i...->...", FIRST, f[:, 4]) / h

    def by_y(f):
        return np.einsum("i,i...->...", FIRST, f[4]) / h

    scale = np.max([np.abs(c[4, 4]) for c in (s.xx, s.yy, s.xy)], axis=0) / x
    assert (np.abs(by_x(s.xx) + by_y(s.xy)) < 2e-8 * scale).all()
    assert (np.abs(by_x(s.xy) + by_y(s.yy)) < 2e-8 * scale).all()


def test_compatibility(skin, contact):
    x, y = points()
    xs, ys, h = stencil(x, y, 1 / 32)
    e = skin.strain(contact, xs, ys)
    xx_yy = np.einsum("j,jn->n", SECOND, e.xx[4]) / h**2
    yy_xx = np.einsum("i,in->n", SECOND, e.yy[:, 4]) / h**2
    xy_xy = np.einsum("i,j,ijn->n", FIRST, FIRST, e.gamma_xy) / h**2
    scale = np.max([np.abs(c[4, 4]) for c in (e.xx, e.yy, e.xy)], axis=0) / x**2
    assert (np.abs(xx_yy + yy_xx - xy_xy) < 5e-7 * scale).all()


def test_strain_and_stress_obey_hooke(skin, contact):
    x, y = points()
    state = skin.state(contact, x, y)
    s, e, m = state.stress, state.strain, skin.material
    scale = np.abs([s.xx, s.yy, s.xy]).max() / m.young
    for one, two, three, strain in (
        (s.xx, s.yy, s.zz, e.xx),
        (s.yy, s.zz, s.xx, e.yy),
        (s.zz, s.xx, s.yy, e.zz),
    ):
        np.testing.assert_allclose(
            strain, (one - m.poisson * (two + three)) / m.young, rtol=0, atol=1e-14 * scale
        )
    np.testing.assert_allclose(2 * m.shear * e.xy, s.xy, rtol=1e-14)
    assert (s.zz == 0).all() if skin.plane == "stress" else (e.zz == 0).all()


def positions():
    """Surface points off every node, edge and tip of the contacts above."""
    return A * np.array([-30.0, -2.13, -0.97, -0.61, -0.23, -0.07, 0.31, 0.47, 0.83, 1.21, 3.7])


def test_surface_traction_comes_back(skin, contact):
    y = positions()
    p, q = contact.pressure(y), contact.shear(y)
    peak = 40.0 / A
    on = skin.stress(contact, 0.0, y)
    np.testing.assert_allclose(on.xx, -p, rtol=0, atol=1e-14 * peak)
    np.testing.assert_allclose(on.xy, -q, rtol=0, atol=1e-14 * peak)
    near = skin.stress(contact, 1e-9 * A, y)
    np.testing.assert_allclose(near.xx, -p, rtol=0, atol=1e-6 * peak)
    np.testing.assert_allclose(near.xy, -q, rtol=0, atol=1e-6 * peak)
    np.testing.assert_allclose(near.yy, on.yy, rtol=0, atol=1e-6 * peak)


def integral(traction, centre, r, kinks):
    """In theta, y = centre + r sin(theta), which takes a punch's edges and a wedge's tip in its stride."""
    cuts = sorted([-np.pi / 2, np.pi / 2, *np.arcsin(kinks)])

    def slice_of(theta):
        return traction(centre + r * np.sin(theta)) * r * np.cos(theta)

    return sum(quad(slice_of, a, b, epsabs=1e-10, epsrel=1e-12)[0] for a, b in pairwise(cuts))


def test_pressure_and_shear_add_up_to_the_load(contact):
    if isinstance(contact, ss.LineLoad):
        pytest.skip("a line load's pressure is not a function")
    normal = tangential = 0.0
    for part in contact.parts if isinstance(contact, ss.contact.ContactSum) else (contact,):
        kinks = [-0.4, 0.0, 0.1]
        if isinstance(part, ss.PartialSlip):
            kinks += [side * part.stick_half_width / part.half_width for side in (-1, 1)]
        centre, r = float(getattr(part, "position", 0.0)), float(getattr(part, "half_width", A))
        normal += integral(part.pressure, centre, r, kinks)
        tangential += integral(part.shear, centre, r, kinks)
    np.testing.assert_allclose(
        [normal, tangential], [contact.normal_force, contact.tangential_force], rtol=1e-9
    )


def first_moment(contact):
    """Of the pressure about y = 0, by means other than the contact's own."""
    if isinstance(contact, ss.contact.ContactSum):
        return sum(first_moment(part) for part in contact.parts)
    if isinstance(contact, ss.PressureProfile):
        y, p, _ = SHAPE
        return sum(
            (b - a) * (pa * (2 * a + b) + pb * (a + 2 * b)) / 6
            for a, b, pa, pb in zip(y, y[1:], p, p[1:], strict=False)
        )
    return contact.normal_force * contact.position + getattr(contact, "moment", 0.0)


@pytest.mark.parametrize("depth", [0.3 * A, 2.0 * A])
def test_resultant_on_a_buried_plane(skin, contact, depth):
    """The midpoint rule in theta, y = depth tan(theta), converges geometrically: the integrand is analytic there."""
    theta = (np.arange(1200) + 0.5) * np.pi / 1200 - np.pi / 2
    y, dy = depth * np.tan(theta), depth / np.cos(theta) ** 2 * np.pi / 1200
    s = skin.stress(contact, depth, y)
    n, t = contact.normal_force, contact.tangential_force
    np.testing.assert_allclose((s.xx * dy).sum(), -n, atol=1e-11 * 40)
    np.testing.assert_allclose((s.xy * dy).sum(), -t, atol=1e-11 * 40)
    moment = -(first_moment(contact) + depth * t)
    np.testing.assert_allclose((y * s.xx * dy).sum(), moment, atol=1e-11 * 40 * depth)


def test_superposition_and_linearity(skin):
    x, y = points()
    one, two = CONTACTS["tilted"], CONTACTS["profile"]
    alone, beside, both = (skin.stress(c, x, y) for c in (one, two, one + two))
    thrice = skin.stress(ss.Hertz(120.0, 0.4, half_width=A), x, y)
    once = skin.stress(ss.Hertz(40.0, 0.4, half_width=A), x, y)
    for name in ("xx", "yy", "zz", "xy"):
        expected = getattr(alone, name) + getattr(beside, name)
        np.testing.assert_allclose(
            getattr(both, name), expected, rtol=0, atol=1e-14 * np.abs(expected).max() + 1e-300
        )
        np.testing.assert_allclose(getattr(thrice, name), 3 * getattr(once, name), rtol=1e-13, atol=1e-9)


def mirrored(contact):
    if isinstance(contact, ss.contact.ContactSum):
        return sum(mirrored(part) for part in contact.parts)
    if isinstance(contact, ss.PressureProfile):
        y, p, q = SHAPE
        return ss.PressureProfile(-y[::-1], p[::-1], -q[::-1])
    extra = {"half_width": contact.half_width} if hasattr(contact, "half_width") else {}
    if hasattr(contact, "moment"):
        extra["moment"] = -contact.moment
    if hasattr(contact, "friction"):
        extra["friction"] = contact.friction
    return type(contact)(contact.force, -contact.angle, -contact.position, **extra)


def test_mirror_symmetry(skin, contact):
    x, y = points()
    here, there = skin.stress(contact, x, y), skin.stress(mirrored(contact), x, -y)
    scale = np.abs([here.xx, here.yy, here.xy]).max()
    for name, sign in (("xx", 1), ("yy", 1), ("zz", 1), ("xy", -1)):
        np.testing.assert_allclose(
            getattr(here, name), sign * getattr(there, name), rtol=0, atol=1e-14 * scale
        )
    along = (
        skin.surface_gradient(contact, positions()),
        skin.surface_gradient(mirrored(contact), -positions()),
    )
    np.testing.assert_allclose(along[0].ux, -along[1].ux, rtol=0, atol=1e-14)
    np.testing.assert_allclose(along[0].uy, along[1].uy, rtol=0, atol=1e-14)


def largest(stress):
    return np.max([np.abs(stress.xx), np.abs(stress.yy), np.abs(stress.xy)], axis=0)


def slope(h, error):
    return np.polyfit(np.log(h), np.log(error), 1)[0]


def test_stress_decays_as_one_over_distance(skin, contact):
    r = A * np.logspace(3, 5, 9)
    for direction in (-1.1, 0.2, 0.7):
        sizes = largest(skin.stress(contact, r * np.cos(direction), r * np.sin(direction)))
        assert abs(slope(r, sizes) + 1) < 2e-3


@pytest.mark.parametrize("name", [name for name in SYMMETRIC if name != "line"])
@pytest.mark.parametrize("angle", [0.0, 0.4, np.pi / 2])
def test_narrow_contacts_tend_to_the_line_load(skin, name, angle):
    """Saint-Venant: what a symmetric contact adds to its resultant falls with the square of its width."""
    x, y = A * np.array([1.0, 0.6, 1.3]), A * np.array([0.3, -1.5, 0.0])
    widths = A * np.array([0.1, 0.05, 0.025, 0.0125])
    line = skin.stress(ss.LineLoad(40.0, angle), x, y)
    for k in range(3):
        wide = SYMMETRIC[name](angle, 0.0, widths)
        s = skin.stress(wide, x[k], y[k])
        off = [np.abs(getattr(s, c) - getattr(line, c)[k]) for c in ("xx", "yy", "xy")]
        assert abs(slope(widths, np.max(off, axis=0)) - 2) < 0.01


def test_profile_tends_to_the_line_load():
    x, y = 1.0 * A, 0.3 * A
    skin = SKINS["strain-0.5"]
    sizes = np.array([0.1, 0.05, 0.025, 0.0125])
    errors = []
    for size in sizes:
        bump = ss.PressureProfile(
            [-size * A, 0.0, size * A], [0.0, 40 / (size * A), 0.0], [0.0, 9 / (size * A), 0.0]
        )
        line = ss.LineLoad(np.hypot(40.0, 9.0), np.arctan2(9.0, 40.0))
        errors.append(abs(skin.strain(bump, x, y).xx - skin.strain(line, x, y).xx))
    assert abs(slope(sizes, errors) - 2) < 0.01


@pytest.mark.parametrize("name", SYMMETRIC)
def test_gradient_rule(skin, name):
    """d/dy eps_x of a shear f(y) is - d/dx eps_x of the pressure f(y) (FORMULAS.md section 2), for every nu."""
    x, y = points()
    h = x / 32
    press = skin.strain(SYMMETRIC[name](0.0), x + h * STEPS[:, None], y)
    drag = skin.strain(SYMMETRIC[name](np.pi / 2), x, y + h * STEPS[:, None])
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
        np.testing.assert_allclose(
            skin.surface_gradient(punch, A * np.linspace(-0.98, 0.98, 9)).ux, tilt, rtol=1e-12
        )


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
        skin, c = SKINS["strain-0.5"], float(self.TOUCH.stick_half_width)
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
        skin = SKINS["strain-0.3"]
        slides, sticks = (
            ss.Hertz(40.0, angle, half_width=A),
            ss.PartialSlip(40.0, angle, half_width=A, friction=MU),
        )
        np.testing.assert_allclose(skin.stress(sticks, x, y).xy, skin.stress(slides, x, y).xy, rtol=1e-7)
        assert float(sticks.stick_half_width) < 1e-7 * A


def test_profile_converges_to_hertz_with_the_square_of_the_pitch():
    """Nodes closer together towards the edges (y = a sin), where the pressure's slope is infinite."""
    skin, x, y = SKINS["strain-0.5"], A * np.array([0.3, 1.0, 2.0]), A * np.array([0.2, -0.9, 1.5])
    hertz = ss.Hertz(40.0, 0.4, half_width=A)
    exact, counts = skin.strain(hertz, x, y).xx, np.array([9, 17, 33, 65, 129])
    errors = []
    for count in counts:
        nodes = A * np.sin(np.linspace(-np.pi / 2, np.pi / 2, count))
        sampled = ss.PressureProfile(nodes, hertz.pressure(nodes), hertz.shear(nodes))
        errors.append(np.abs(skin.strain(sampled, x, y).xx - exact).max())
    assert abs(slope(1 / (counts - 1), errors) - 2) < 0.05
    assert errors[-1] < 3e-4 * np.abs(exact).max()


def test_a_profile_of_two_nodes_is_a_strip(skin):
    x, y = points()
    strip = ss.Strip(40.0, 0.4, 0.2e-3, half_width=A)
    p, q = strip.normal_force / (2 * A), strip.tangential_force / (2 * A)
    profile = ss.PressureProfile([0.2e-3 - A, 0.2e-3 + A], [p, p], [q, q])
    for name in ("xx", "yy", "xy"):
        seen, expected = getattr(skin.stress(profile, x, y), name), getattr(skin.stress(strip, x, y), name)
        np.testing.assert_allclose(seen, expected, rtol=0, atol=1e-13 * 40 / A)


def test_surface_gradient_is_the_strain_along_the_surface(skin, contact):
    """du_y/dy at the surface is eps_y there: two routes from the same transforms, one through Hooke's law."""
    y = positions()
    np.testing.assert_allclose(
        skin.surface_gradient(contact, y).uy, skin.strain(contact, 0.0, y).yy, rtol=0, atol=1e-14
    )


def test_tilt_of_the_surface_from_the_strain_within(skin, contact):
    """d/dx (du_x/dy) = d eps_x/dy and there is no tilt far below: the integral of the latter over depth is the tilt."""
    for y in (2.3 * A, -2.6 * A):

        def bend(log_x, y=y):
            x = np.exp(log_x)
            h = np.hypot(x, 0.5 * A) / 32  # outside the contact the field is smooth up to the surface
            return x * (FIRST @ skin.strain(contact, x, y + h * STEPS).xx) / h

        cuts = np.log(A) + np.array([-28.0, -6.0, 6.0, 28.0])
        total = sum(quad(bend, a, b, epsrel=1e-10, epsabs=1e-14)[0] for a, b in pairwise(cuts))
        np.testing.assert_allclose(skin.surface_gradient(contact, y).ux, -total, rtol=1e-7, atol=1e-9)
