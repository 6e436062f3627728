"""Every skin's solved contact, checked by the fields beneath it; and a round finger on a table and on its edge."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

import subskin as ss

A = 1e-3  # the length scale [m]
SOFT, FIRM = ss.Material(0.4e6, 0.5), ss.Material(3e6, 0.3)
SKINS = {
    "half plane-0.5": ss.HalfPlane(SOFT),
    "half plane-0.2": ss.HalfPlane(ss.Material(0.4e6, 0.2)),
    "layer-0.5": ss.Layered(ss.Layer(SOFT, 2 * A)),
    "layer-0.3": ss.Layered(ss.Layer(ss.Material(0.4e6, 0.3), 2 * A)),
    "thin layer": ss.Layered(ss.Layer(SOFT, 0.3 * A)),
    "loose layer": ss.Layered(ss.Layer(SOFT, 2 * A, bond="frictionless")),
    "epidermis": ss.Layered([ss.Layer(FIRM, 0.4 * A), ss.Layer(SOFT, 3 * A)]),
    "sliding epidermis": ss.Layered([ss.Layer(FIRM, 0.4 * A, bond="frictionless"), ss.Layer(SOFT, 3 * A)]),
    "on a half plane": ss.Layered(ss.Layer(SOFT, A), base=FIRM),
    "loose on a half plane": ss.Layered(ss.Layer(SOFT, A, bond="frictionless"), base=FIRM),
    "round-0.5": ss.Round(SOFT, 8 * A, 4 * A),
    "round-0.3": ss.Round(ss.Material(0.4e6, 0.3), 8 * A, 2 * A),
}
LOADS = {
    "pressed": {"force": 20.0},
    "dragged": {"force": 20.0, "friction": 0.5, "tangential": 4.0},
    "turned": {"force": 20.0, "moment": 4e-3},
}
BODY = ss.pressing.Cylinder(4 * A)
FAR = 1e10 * A
NODE, WEIGHT = np.polynomial.legendre.leggauss(10)


@pytest.fixture(params=SKINS)
def skin(request):
    return SKINS[request.param]


def panels(ends):
    """Places and weights of a quadrature between each two of `ends`."""
    half = np.diff(ends)[:, None] / 2
    return (ends[:-1, None] + half * (1 + NODE)).ravel(), (half * WEIGHT).ravel()


def sunk(skin, contact, y, step):
    """u_x of the surface: minus the integral of strain.xx over the depth, less that at the first place if need be."""
    end = skin.thickness if skin.grounded else FAR
    ends = [0.0, step / 8]
    while ends[-1] < end:
        ends.append(min(end, 2 * ends[-1]))
    if isinstance(skin, ss.Layered):
        ends = np.union1d(ends, np.cumsum([layer.thickness for layer in skin.stack]))
    x, weight = panels(np.asarray(ends))
    u = -weight @ skin.strain(contact, x[:, None], y).xx
    return u if skin.grounded else u - u[0]


def moved_along(skin, contact, y):
    """u_y from one of the places `y` to the next, by the strain along the surface; on a round one also by u_x."""
    # the strain has a logarithm's kink at each node: t^2 (3 - 2 t) crowds the places there
    t, weight = 0.5 * (1 + NODE), 3 * WEIGHT
    at = (y[:-1, None] + np.diff(y)[:, None] * t**2 * (3 - 2 * t)).ravel()
    weight = (np.diff(y)[:, None] * t * (1 - t) * weight).ravel()
    moved = (weight * skin.strain(contact, 0.0, at).yy).reshape(y.size - 1, -1).sum(axis=1)
    if isinstance(skin, ss.Round):
        u = sunk(skin, contact, np.linspace(y[0], y[-1], 2 * y.size - 1), np.diff(y).min())
        moved += (u[:-1:2] + 4 * u[1::2] + u[2::2]) / 6 * np.diff(y) / skin.radius
    return moved


@pytest.mark.parametrize(
    ("skin", "load"),
    [(skin, load) for i, skin in enumerate(SKINS) for j, load in enumerate(LOADS) if (i + j) % 3],
    indirect=["skin"],
)
def test_the_surface_follows_the_body(skin, load):
    """At nodes to rounding and the tolerance, between them to what a straight line leaves; and never through it."""
    found = ss.press(skin, BODY, **LOADS[load], nodes=200, max_strain=None)
    assert found.status is ss.pressing.PressStatus.OK
    step, scale = np.diff(found.y[:2])[0], found.certificate.scale
    inside = np.flatnonzero(found.pressure > 0)
    nodes = found.y[inside[3:-3:17]]
    between = nodes + 0.37 * step
    beyond = np.concatenate(
        [found.edges[0, 0] - step * np.array([2.0, 5, 20]), found.edges[0, 1] + step * np.array([2.0, 5, 20])]
    )
    y = np.concatenate([nodes, between, beyond])
    body = -(BODY.height(y) + skin.surface_drop(y)) + found.tilt * y
    body = body + found.depth if skin.grounded else body - body[0]
    gap = sunk(skin, found.contact, y, step) - body
    assert np.abs(gap[: nodes.size]).max() < 1e-8 * scale
    assert np.abs(gap[nodes.size : 2 * nodes.size]).max() < 3e-4 * scale
    outside = gap[2 * nodes.size :]
    assert (outside > 0).all()
    assert (np.diff(outside[:3]) > 0).all()
    assert (np.diff(outside[3:]) > 0).all()
    # what the solution says of the gap is so
    at = np.flatnonzero(found.y > found.edges[0, 1] + step)[:30:7]
    y = np.concatenate([nodes[:1], found.y[at]])
    body = -(BODY.height(y) + skin.surface_drop(y)) + found.tilt * y
    body = body + found.depth if skin.grounded else body - body[0]
    assert (sunk(skin, found.contact, y, step) - body)[1:] == pytest.approx(found.gap[at], abs=1e-8 * scale)


@pytest.mark.parametrize("skin", [*SKINS][1::2], indirect=True)
def test_what_sticks_keeps_its_position(skin):
    """Where the contact sticks, the surface is moved along by the indenter's way alone; where it slips, against q."""
    load = {"force": 20.0, "friction": 0.4}
    states = [ss.press(skin, BODY, **load, nodes=100, max_strain=None)]
    for drag in (4.0, -1.0):
        states.append(ss.press(skin, BODY, **load, tangential=drag, after=states[-1], max_strain=None))
    touched = np.flatnonzero(np.any([state.pressure > 0 for state in states], axis=0))
    y, before = states[0].y[touched], np.zeros(touched.size - 1)
    for state in states:
        assert state.status is ss.pressing.PressStatus.OK
        scale = state.certificate.scale
        way = moved_along(skin, state.contact, y)
        slip = way - before
        assert np.diff(state.slip[touched]) == pytest.approx(slip, abs=1e-8 * scale)  # what the solution says
        sticks = (y[:-1] >= state.stick[0, 0]) & (y[1:] <= state.stick[-1, 1])
        assert sticks.sum() > 5
        assert np.abs(slip[sticks]).max() < 1e-8 * scale
        before = way
    # not because nothing slips at all
    assert np.abs(np.diff(states[1].slip[touched])).max() > 1e-4 * scale


def test_the_way_of_the_indenter():
    """`slide` counts from where the skin is at rest: far away, on a bonded layer."""
    skin = SKINS["layer-0.3"]
    found = ss.press(skin, BODY, force=20.0, friction=0.5, tangential=4.0, nodes=150)
    ends = np.concatenate([np.linspace(-40 * A, found.y[0] - 2e-5, 60), found.y[found.y <= 0]])
    stuck = found.stick[0, 0] < ends[-1] < found.stick[0, 1]
    assert stuck
    total = moved_along(skin, found.contact, ends).sum()
    assert total == pytest.approx(found.slide, rel=1e-5)


class TestHalfPlaneGradients:
    """The slope of the surface beneath the body is the body's own."""

    @pytest.mark.parametrize("load", LOADS.values(), ids=LOADS)
    @pytest.mark.parametrize("name", ["half plane-0.5", "half plane-0.2"])
    def test_slope(self, name, load):
        skin = SKINS[name]
        found = ss.press(skin, BODY, **load)
        y = np.linspace(*(found.edges[0] * 0.95), 41)
        wanted = found.tilt - y / BODY.radius
        error = np.abs(skin.surface_gradient(found.contact, y).ux - wanted)
        assert error.max() < 6e-3 * np.abs(wanted).max()

    def test_stretch_where_it_sticks(self):
        skin = SKINS["half plane-0.2"]
        start = ss.press(skin, BODY, force=20.0, friction=0.4)
        assert start.stick[0, 1] > 0.2 * start.half_width
        after = ss.press(skin, BODY, force=20.0, friction=0.4, tangential=2.0, after=start)
        low, high = after.stick[0]
        y = np.linspace(low + 0.1 * (high - low), high - 0.1 * (high - low), 31)
        one, two = (skin.surface_gradient(s.contact, y).uy for s in (start, after))
        size = np.abs(skin.surface_gradient(after.contact, np.linspace(*after.edges[0], 50)).uy).max()
        assert np.abs(two - one).max() < 5e-3 * size
        slips = 0.5 * (high + after.edges[0, 1])
        one, two = (skin.surface_gradient(s.contact, slips).uy for s in (start, after))
        assert abs(two - one) > 0.05 * size


class TestRoundFinger:
    """Radius R on a core, pressed on a rigid table: a small contact is Hertz's with the finger's own radius."""

    RADIUS = 8 * A

    @pytest.mark.parametrize("nu", [0.5, 0.3])
    def test_light_loads_on_a_thick_finger(self, nu):
        material = ss.Material(0.4e6, nu)
        skin = ss.Round(material, self.RADIUS, 0.3 * self.RADIUS)
        widths, errors = [], []
        for force in (2.0, 0.5, 0.125):
            a = np.sqrt(4 * force * self.RADIUS / (np.pi * material.plane_strain_modulus))
            found = ss.press(skin, ss.pressing.Flat(), force=force, window=2.5 * a)
            y = a * np.linspace(-0.8, 0.8, 9)
            wanted = ss.Hertz(force, half_width=a).pressure(y)
            widths.append(a)
            errors.append(np.abs(found.contact.pressure(y) / wanted - 1).max())
        # at nu = 1/2 a shear-free surface is stretched by a^2 only; else the stretch beneath is of first order
        rate = np.log(errors[0] / errors[-1]) / np.log(widths[0] / widths[-1])
        assert rate > (1.5 if nu == 0.5 else 0.85)
        assert errors[-1] < (1e-4 if nu == 0.5 else 1e-3)

    @pytest.mark.parametrize("core", [0.3, 0.8])
    def test_two_round_bodies(self, core):
        """Only the relative curvature counts, 1/R = 1/R1 + 1/R2: a finger and a cylinder, or a larger finger."""
        skin = ss.Round(SOFT, self.RADIUS, core * self.RADIUS)
        one = ss.press(skin, ss.pressing.Cylinder(3 * A), force=1.0)
        both = 1 / (1 / self.RADIUS + 1 / (3 * A))
        a = np.sqrt(4 * 1.0 * both / (np.pi * SOFT.plane_strain_modulus))
        assert one.half_width == pytest.approx(a, rel=5e-3)

    def test_beside_the_contact_the_gap_is_that_of_a_circle_and_a_line(self):
        """y is an arc: the surface is R (1 - cos(y / R)) beneath its tangent, and R at a quarter of the way round."""
        skin = ss.Round(SOFT, self.RADIUS, 4 * A)
        found = ss.press(skin, ss.pressing.Flat(), force=1e-3, window=26 * A, nodes=2**14)
        wanted = self.RADIUS * (1 - np.cos(found.y / self.RADIUS)) - found.depth
        assert wanted.max() > self.RADIUS
        beside = np.abs(found.y) > A
        assert np.abs(found.gap - wanted)[beside].max() < 1e-6 * A

    @pytest.mark.parametrize("share", [0.0, 0.5, -1.5])
    def test_edge(self, share):
        """Half on a table's edge: a parabola that ends at e, contact of half width c about e - c.

        p = (E* / (2 R)) (2 c - e - s) sqrt((c + s) / (c - s)), P = (pi E* / (2 R)) (3 c^2 / 2 - e c): from Johnson
        (1985), eqs. 2.45 and 2.64, for a rigid body of slope (s + e - c) / R; nothing beyond the end, where p grows
        as a punch's.
        """
        skin, stiff = ss.Round(SOFT, self.RADIUS, 0.3 * self.RADIUS), SOFT.plane_strain_modulus
        c = 0.01 * self.RADIUS
        end = share * c
        force = np.pi * stiff / (2 * self.RADIUS) * (1.5 * c**2 - end * c)
        found = ss.press(skin, ss.pressing.Edge(), force=force, position=end, nodes=2048)
        assert found.status is ss.pressing.PressStatus.OK
        assert found.force == pytest.approx(force, rel=1e-9)
        assert found.edges[0, 1] == pytest.approx(end, abs=1e-9 * c)
        assert found.edges[0, 0] == pytest.approx(end - 2 * c, abs=3e-3 * c)
        assert (found.pressure[found.y > end] == 0).all()
        s = found.y - (end - c)
        inside = np.abs(s) < 0.95 * c
        s = s[inside]
        wanted = stiff / (2 * self.RADIUS) * (2 * c - end - s) * np.sqrt((c + s) / (c - s))
        assert found.pressure[inside] == pytest.approx(wanted, abs=2e-3 * wanted.max())
        assert found.pressure.max() == found.pressure[found.y < end][-1] > 4 * wanted.mean()
        assert found.depth > ss.press(skin, ss.pressing.Flat(), force=force).depth

    def test_an_edge_far_away_is_a_table(self):
        skin = ss.Round(SOFT, self.RADIUS, 4 * A)
        table = ss.press(skin, ss.pressing.Flat(), force=10.0, window=3 * A)
        edge = ss.press(skin, ss.pressing.Edge(), force=10.0, position=1.45 * A, nodes=2048)
        y = np.linspace(-0.4, 0.4, 9) * A
        assert edge.contact.pressure(y) == pytest.approx(table.contact.pressure(y), rel=2e-4)
        assert edge.depth == pytest.approx(table.depth, rel=1e-5)


@pytest.mark.parametrize("friction", [None, 0.4])
def test_mirror(skin, friction):
    y = np.linspace(-2, 2, 81) * A
    height = (y - 0.3 * A) ** 2 / (6 * A) + 0.01 * A * np.sin(7 * y / A)
    drag = None if friction is None else 2.0
    one = ss.press(
        skin,
        ss.pressing.Profile(y, height),
        force=8.0,
        friction=friction,
        tangential=drag,
        position=0.2 * A,
        max_strain=None,
    )
    two = ss.press(
        skin,
        ss.pressing.Profile(-y[::-1], height[::-1]),
        force=8.0,
        friction=friction,
        tangential=drag and -drag,
        position=-0.2 * A,
        max_strain=None,
    )
    peak = one.pressure.max()
    assert np.abs(two.y[::-1] + one.y).max() < 1e-9 * A
    assert np.abs(two.pressure[::-1] - one.pressure).max() < 1e-5 * peak
    assert np.abs(two.shear[::-1] + one.shear).max() < 1e-5 * peak
    assert two.edges[::-1, ::-1] == pytest.approx(-one.edges, abs=1e-6 * A)
    assert two.moment == pytest.approx(-one.moment, abs=1e-6 * 8.0 * A)


def test_a_flat_skin_is_the_same_everywhere(skin):
    if isinstance(skin, ss.Round):
        pytest.skip("round: what is pressed beside its top meets a slope")
    here = ss.press(skin, BODY, force=10.0, nodes=256, max_strain=None)
    there = ss.press(skin, BODY, force=10.0, nodes=256, position=0.7 * A, max_strain=None)
    assert there.y == pytest.approx(here.y + 0.7 * A, abs=1e-15)
    assert there.pressure == pytest.approx(here.pressure, rel=1e-9, abs=1e-9 * here.pressure.max())
    assert there.moment == pytest.approx(0.0, abs=1e-9)
    support = np.array(there.contact.support) - np.array(here.contact.support)
    assert support == pytest.approx([0.7 * A, 0.7 * A])


def test_a_cylinder_beside_the_top_of_a_finger():
    """It touches where the slopes agree: y / R = (s - y) / r, for s the cylinder's place (small slopes)."""
    skin, radius, position = ss.Round(SOFT, 8 * A, 4 * A), 3 * A, 0.7 * A
    found = ss.press(skin, ss.pressing.Cylinder(radius), force=0.5, position=position)
    assert found.edges.mean() == pytest.approx(position * 8 / 11, rel=2e-3)
    top = ss.press(skin, ss.pressing.Cylinder(radius), force=0.5)
    assert found.depth - top.depth == pytest.approx(position**2 / (2 * 11 * A), rel=2e-3)


def test_stiffness_scales():
    """Twice as stiff, twice the pressure for the same depth; lengths do not change."""
    one = ss.press(ss.Layered(ss.Layer(SOFT, A)), BODY, depth=0.03 * A)
    two = ss.press(ss.Layered(ss.Layer(dataclasses.replace(SOFT, young=2 * SOFT.young), A)), BODY, depth=0.03 * A)
    assert two.pressure == pytest.approx(2 * one.pressure, rel=1e-6, abs=1e-6 * one.pressure.max())
