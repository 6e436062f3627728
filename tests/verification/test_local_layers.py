"""What must be true of layers under local contacts; the laws of test_local_contacts.py, and those of interfaces."""

from __future__ import annotations

from itertools import cycle, pairwise

import numpy as np
import pytest

import subskin as ss
from subskin.errors import GeometryError, InvalidValueError
from subskin.skin._layer_modes import Sheet, Stack, antiplane

from .._tables import FIRM, LOCAL, PLAIN, SKINS, SOFT, A
from ._contract import FIRST, STEPS, bonds, interfaces
from .test_local_contacts import close, tensor, vector

LAYERED = {name: skin for name, skin in SKINS.items() if isinstance(skin, ss.Layered)}
LAYER = LAYERED["layer-0.5"]
ROUND = ["twisted", "point torque", "slip", "round punch", "cone", "local sum"]
PAIRS = list(zip(LAYERED, cycle(ROUND)))
OUTLINED = ["ellipse", "patch", "grid", "projections"]

pairs = pytest.mark.parametrize(("skin", "name"), PAIRS)


def contact(skin, name):
    """Without drag where that would move a layer for ever."""
    built = LOCAL[name]()
    loose = "frictionless" in bonds(LAYERED[skin])
    return ss.RoundHertz(components=(1.0, 0.0, 0.0), half_width=A, moment=0.3 * A) if loose else built


def middles(skin):
    """A point in each layer, off its middle, and how far its ends are."""
    ends = interfaces(skin)
    ends = ends if np.isfinite(skin.thickness) else np.append(ends, ends[-1] + 2 * A)
    x = ends[:-1] + 0.4 * np.diff(ends)
    return x, A * np.linspace(-1.1, 1.7, x.size), A * np.linspace(0.9, -0.6, x.size), 0.4 * np.diff(ends)


class Cross:
    """A state on nine points along each axis about some points."""

    def __init__(self, skin, contact):
        self.x, self.y, self.z, room = middles(skin)
        self.step = np.minimum(room, 0.5 * A) / 5
        where = (self.x, self.y, self.z)
        shift = self.step * STEPS[:, None]
        self.states = [skin.state(contact, *(a + (i == k) * shift for i, a in enumerate(where))) for k in range(3)]

    def by(self, axis, pick):
        return np.einsum("i,...in->...n", FIRST, pick(self.states[axis])) / self.step


@pairs
def test_equilibrium_and_strains(skin, name):
    f = Cross(LAYERED[skin], contact(skin, name))
    here = f.states[0]
    stress, strain = tensor(here.stress)[:, 4], tensor(here.strain)[:, 4]

    def by(k, c):
        return f.by(k, lambda state: getattr(state.stress, c))

    left = [
        by(0, "xx") + by(1, "xy") + by(2, "xz"),
        by(0, "xy") + by(1, "yy") + by(2, "yz"),
        by(0, "xz") + by(1, "yz") + by(2, "zz"),
    ]
    close(left, np.zeros((3, f.x.size)), 1e-6, np.abs(stress).max(axis=0) / f.step)
    slopes = np.array([f.by(k, lambda s: vector(s.displacement)) for k in range(3)])
    found = 0.5 * (slopes + np.swapaxes(slopes, 0, 1))
    seen = [found[0, 0], found[1, 1], found[2, 2], found[0, 1], found[0, 2], found[1, 2]]
    close(seen, strain, 1e-6)


@pairs
def test_hooke(skin, name):
    skin = LAYERED[skin]
    x, y, z, _ = middles(skin)
    state = skin.state(LOCAL[name](), x, y, z)
    for i, depth in enumerate(x):
        m = skin.material_at(depth)
        s, e = tensor(state.stress)[:, i], tensor(state.strain)[:, i]
        expected = (1 + m.poisson) / m.young * s
        expected[:3] -= m.poisson / m.young * s[:3].sum()
        close(e[:, None], expected[:, None], 1e-12)


@pytest.mark.parametrize("skin", LAYERED)
def test_the_traction_comes_back_at_the_surface(skin):
    touch = LOCAL["slip"]()
    rng = np.random.default_rng(0)
    y, z = A * rng.uniform(-1.0, 1.0, 12), A * rng.uniform(-0.8, 0.8, 12)
    y[-2:] *= 5
    p, q = touch.pressure(y, z), touch.shear(y, z)
    assert (p[:-2] > 0).any()
    s = LAYERED[skin].stress(touch, 0.0, y, z)
    close([s.xx, s.xy, s.xz], [-p, -q[..., 0], -q[..., 1]], 1e-11, p.max())


def buried(skin, touch, depth):
    """Forces on a plane, by rings about the origin that reach to infinity or as far as anything is felt."""
    t, w = np.polynomial.legendre.leggauss(40)
    share, turns = 0.5 * (1 + t), 2 * np.pi * np.arange(12) / 12
    r, dr = 3 * A * share / (1 - share), 1.5 * A * w / (1 - share) ** 2
    near = r < 60 * A
    r, dr = r[near], dr[near]
    s = skin.stress(touch, depth, r[:, None] * np.cos(turns), r[:, None] * np.sin(turns))
    size = (r * dr)[:, None] * (np.pi / 6)
    return -np.array([float((c * size).sum(axis=1).sum()) for c in (s.xx, s.xy, s.xz)])


@pytest.mark.parametrize("skin", ["layer-0.5", "layer-0.3", "loose layer"])
def test_a_buried_plane_carries_the_load(skin):
    """Where nothing slides above it; beneath, the pressure."""
    medium, touch = LAYERED[skin], ss.RoundHertz(components=(1.0, 0.375, -0.25), half_width=A)
    force = buried(medium, touch, medium.thickness)
    held = [1.0, 0.0, 0.0] if skin == "loose layer" else touch.components
    # how far off a stack on a rigid base still feels a touch, the rings tell to five digits
    close(force, held, 3e-5, 1.0)


@pytest.mark.parametrize("skin", LAYERED)
def test_interfaces_hold_or_slide(skin):
    medium, touch = LAYERED[skin], contact(skin, "slip")
    y, z = A * np.array([0.3, -1.2, 2.0]), A * np.array([0.5, 0.4, -1.0])
    for depth, bond in zip(interfaces(medium)[1:], bonds(medium), strict=False):
        above = medium.state(touch, depth, y, z)
        size, far = np.abs(tensor(above.stress)).max(), np.abs(vector(medium.displacement(touch, 0.0, y, z))).max()
        over, u = above.stress, above.displacement
        if bond == "frictionless":
            close([over.xy, over.xz], np.zeros((2, 3)), 1e-11, size)
        if depth == medium.thickness:
            close(vector(u) if bond == "bonded" else u.x[None], np.zeros((1, 3)), 1e-12, far)
            continue
        below = medium.state(touch, depth * (1 + 1e-9), y, z)
        under, v = below.stress, below.displacement
        close([over.xx, over.xy, over.xz], [under.xx, under.xy, under.xz], 1e-7, size)
        close(vector(u)[: 3 if bond == "bonded" else 1], vector(v)[: 3 if bond == "bonded" else 1], 1e-7, far)


@pytest.mark.parametrize("name", ["slip", "twisted"])
def test_layers_of_one_material_are_one_layer(name):
    x, y, z = (
        A * np.array([0.3, 1.0, 2.5, 4.0]),
        A * np.array([0.1, -2.0, 1.0, 0.7]),
        A * np.array([0.6, 0.0, -1.0, 3.0]),
    )
    parts = [ss.Layer(PLAIN, A), ss.Layer(PLAIN, 0.7 * A), ss.Layer(PLAIN, 2.3 * A)]
    one, many = (s.state(LOCAL[name](), x, y, z) for s in (LAYERED["layer-0.3"], ss.Layered(parts)))
    close(tensor(many.stress), tensor(one.stress), 1e-11)
    close(vector(many.displacement), vector(one.displacement), 1e-11, np.abs(vector(one.displacement)).max())
    flat, same = (s.state(LOCAL[name](), x, y, z) for s in (ss.HalfSpace(PLAIN), ss.Layered(parts, base=PLAIN)))
    close(tensor(same.stress), tensor(flat.stress), 1e-11)
    close(vector(same.displacement), vector(flat.displacement), 1e-11)


def test_a_thick_layer_is_a_half_space():
    """What is left of the base falls as the square of its depth for stress, and as its depth for displacement."""
    x, y, z = A * np.array([0.5, 1.5]), A * np.array([0.3, -1.0]), A * np.array([0.2, 0.8])
    touch, flat = LOCAL["slip"](), ss.HalfSpace(PLAIN).state(LOCAL["slip"](), x, y, z)
    depths, off, moved = A * np.array([100.0, 200.0, 400.0]), [], []
    for h in depths:
        state = ss.Layered(ss.Layer(PLAIN, h)).state(touch, x, y, z)
        off.append(np.abs(tensor(state.stress) - tensor(flat.stress)).max())
        moved.append(np.abs(vector(state.displacement) - vector(flat.displacement)).max())
    assert np.polyfit(np.log(depths), np.log(off), 1)[0] == pytest.approx(-2, abs=0.05)
    assert np.polyfit(np.log(depths), np.log(moved), 1)[0] == pytest.approx(-1, abs=0.05)


class Unround(ss.RoundHertz):
    """A round contact that does not say that it is one."""

    radial_terms = None


@pytest.mark.parametrize("skin", ["layer-0.5", "loose layer", "epidermis", "on a half plane"])
def test_harmonics_and_radial_tables_agree(skin):
    medium = LAYERED[skin]
    x = A * np.array([0.0, 0.3, 0.9, 0.9])
    y, z = A * np.array([[0.4, 2.5, 0.3, -3.0], [-0.1, 1.0, -0.15, 2.0]])
    how = {"position": (0.3 * A, -0.15 * A), "half_width": A, "moment": 0.3 * A}
    load = (1.0, 0.0, 0.0) if skin == "loose layer" else (1.0, 0.375, -0.25)
    one, two = (medium.state(kind(components=load, **how), x, y, z) for kind in (ss.RoundHertz, Unround))
    close(tensor(two.stress), tensor(one.stress), 1e-12)
    close(tensor(two.strain), tensor(one.strain), 1e-12)
    close(vector(two.displacement), vector(one.displacement), 1e-12)
    leans = [[state.tilt.y, state.tilt.z] for state in (two, one)]
    close(*leans, 1e-12, np.abs(leans[1]).max())


@pytest.mark.parametrize("name", OUTLINED)
def test_a_contact_of_any_outline_is_a_sum_of_point_loads(name):
    """By Gauss's rule over the traction: what the base sends back is smooth."""
    touch = LOCAL[name]() if name != "ellipse" else ss.EllipticHertz(1.0, 0.3, 0.4, half_widths=(A, 0.4 * A), turn=0.5)
    x, y, z = A * np.array([1.2, 1.2]), A * np.array([0.4, -2.0]), A * np.array([0.2, 0.7])
    seen, flat = (skin.state(touch, x, y, z) for skin in (LAYER, ss.HalfSpace(SOFT)))
    grid = getattr(touch, "nodes_y", None), getattr(touch, "nodes_z", None)
    low, high = touch.support
    t, w = np.polynomial.legendre.leggauss(16)
    if name in ("ellipse", "projections"):
        share, turn = 0.5 * (1 + t), 2 * np.pi * np.arange(20) / 20
        rho, size = np.sqrt(1 - share**2)[:, None], (0.5 * w * share)[:, None] * (np.pi / 10)
        half, c = 0.5 * (high - low), 0.5 * (high + low)
        if name == "ellipse":
            along = rho * (A * np.cos(turn) + 0.4j * A * np.sin(turn)) * np.exp(0.5j)
            half = np.array([A, 0.4 * A])
        else:
            along = rho * (half[0] * np.cos(turn) + 1j * half[1] * np.sin(turn))
        at, zt, size = (c[0] + along.real).ravel(), (c[1] + along.imag).ravel(), (size * half.prod() + 0 * turn).ravel()
    else:
        edges = [
            np.asarray(e if e is not None else [low[i], high[i]]) for i, e in enumerate(grid)
        ]  # a map is smooth between its nodes
        nodes = [np.concatenate([0.5 * (a + b) + 0.5 * (b - a) * t for a, b in pairwise(e)]) for e in edges]
        sizes = [np.concatenate([0.5 * (b - a) * w for a, b in pairwise(e)]) for e in edges]
        at, zt = (a.ravel() for a in np.meshgrid(*nodes, indexing="ij"))
        size = np.outer(*sizes).ravel()
    load = np.concatenate([touch.pressure(at, zt)[:, None], touch.shear(at, zt)], axis=1) * size[:, None]
    close(load.sum(axis=0), touch.components, 1e-6, 1.0)
    each = ss.PointLoad(components=load, position=np.stack([at, zt], axis=1)).expand(1)
    many, plain = (skin.state(each, x, y, z) for skin in (LAYER, ss.HalfSpace(SOFT)))
    for pick in (lambda s: tensor(s.stress), lambda s: tensor(s.strain), lambda s: vector(s.displacement)):
        added = pick(seen) - pick(flat)
        expected = (pick(many) - pick(plain)).sum(axis=1)
        close(added, expected, 1e-9, np.abs(pick(seen)).max(axis=0))


def test_a_long_contact_is_the_limit_of_long_patches():
    """What the ends leave out fades as K_0(s r / H), s = cos s: the slowest wave that a soft bonded layer carries."""
    n, t, x, y = 40.0, 12.0, A * np.array([0.4, 1.5]), A * np.array([0.3, -1.2])
    strip = LAYER.stress(ss.Strip(np.hypot(n, t), np.arctan2(t, n), half_width=A), x, y, z=0.0)
    assert strip.is_plane
    lengths, off = A * np.array([14.0, 18.0, 22.0]), []
    for half in lengths:
        patch = ss.Patch(components=2 * half * np.array([n, t, 0.0]), half_widths=(A, half))
        off.append(np.abs(tensor(LAYER.stress(patch, x, y, 0.0)) - tensor(strip)).max() / np.abs(strip.xx).max())
    assert -np.polyfit(lengths / LAYER.thickness, np.log(off * np.sqrt(lengths)), 1)[0] == pytest.approx(
        0.739085, abs=0.01
    )
    assert off[-1] < 5e-3


class TestAntiplane:
    """The wave across, alone."""

    k = np.array([1e-3, 0.1, 1.0, 7.0, 60.0])

    def test_a_bonded_layer(self):
        x = np.array([0.0, 0.3, 0.9, 1.0])
        found = antiplane(Stack((Sheet(0.3, 2.0, 1.0, True),), None), self.k, x)
        k, x = self.k, x[:, None]
        whole = found + np.exp(-k * x)[..., None] * np.array([-1.0, 1.0])
        np.testing.assert_allclose(whole[..., 0], -np.cosh(k * (1 - x)) / np.cosh(k), atol=1e-15)
        np.testing.assert_allclose(whole[..., 1], np.sinh(k * (1 - x)) / np.cosh(k), atol=1e-15)

    @pytest.mark.parametrize("bonded", [True, False])
    def test_two_layers_on_a_half_space(self, bonded):
        """Displacement a cosh + b sinh in each, joined by a system of equations."""
        g1, g2, g3, h1, h2 = 2.0, 0.3, 5.0, 0.4, 1.1
        stack = Stack((Sheet(0.3, g1, h1, bonded), Sheet(0.5, g2, h2, True)), ss.Material(2 * 1.2 * g3, 0.2))
        x = np.array([0.2, 0.9, 2.0])
        for k in (0.1, 1.0, 6.0):
            c1, s1, c2, s2 = np.cosh(k * h1), np.sinh(k * h1), np.cosh(k * h2), np.sinh(k * h2)
            # unknown: a1, b1, a2, b2, a3; in units of the drag over G1 k
            joint = [c1, s1, -1, 0, 0] if bonded else [0, 0, 0, g2, 0]
            rows = [
                [0, 1, 0, 0, 0],
                joint,
                [g1 * s1, g1 * c1, 0, -g2 * bonded, 0],
                [0, 0, c2, s2, -1],
                [0, 0, g2 * s2, g2 * c2, g3],
            ]
            a1, b1, a2, b2, a3 = np.linalg.solve(rows, [-1, 0, 0, 0, 0])
            cosh, sinh = np.cosh(k * np.array([0.2, 0.5])), np.sinh(k * np.array([0.2, 0.5]))
            fall = np.exp(-0.5 * k)
            u = [a1 * cosh[0] + b1 * sinh[0] - np.exp(-0.2 * k), a2 * cosh[1] + b2 * sinh[1], a3 * fall]
            tau = [
                a1 * sinh[0] + b1 * cosh[0] + np.exp(-0.2 * k),
                g2 / g1 * (a2 * sinh[1] + b2 * cosh[1]),
                -g3 / g1 * a3 * fall,
            ]
            found = antiplane(stack, np.array([k]), x)[:, 0]
            np.testing.assert_allclose(found, np.stack([tau, u], axis=1), rtol=1e-10, atol=1e-13)


class TestDoors:
    def test_a_drag_on_what_slides_has_no_displacement(self):
        loose = LAYERED["loose layer"]
        with pytest.raises(InvalidValueError, match="moves without end"):
            loose.displacement(ss.PointLoad(1.0, 0.2), A, 0.0, 0.0)
        assert loose.state(ss.PointLoad(1.0, 0.2), A, 0.0, 0.0).displacement is None
        assert loose.displacement(ss.PointLoad(1.0), A, 0.0, 0.0).x > 0

    def test_points_outside(self):
        with pytest.raises(GeometryError, match="thick"):
            LAYER.stress(ss.PointLoad(1.0), 5 * A, 0.0, 0.0)
        assert LAYER.stress(ss.PointLoad(1.0), A, np.zeros((0, 2)), 0.0).xx.shape == (0, 2)

    @pytest.mark.parametrize("name", ["slip", "patch"])
    def test_batches_broadcast_as_one_by_one(self, name):
        one, x = LOCAL[name](), A * np.array([0.5, 2.0])
        widths = {"half_width": A * np.array([1.0, 0.8]), "stick": 0.6 * A} if name == "slip" else {}
        size = {"half_widths": A * np.array([[1.0, 0.6], [0.8, 0.7]])} if name == "patch" else {}
        at = np.array([[0.0, 0.0], [A, -A]])
        kind = type(one)
        batch = kind(components=one.components, position=at, **widths, **size)
        found = LAYER.state(batch.expand(1), x, 0.3 * A, 0.2 * A)
        for i in range(2):
            more = (
                {"half_width": widths["half_width"][i], "stick": 0.6 * A}
                if name == "slip"
                else {"half_widths": size["half_widths"][i]}
            )
            single = LAYER.state(kind(components=one.components, position=at[i], **more), x, 0.3 * A, 0.2 * A)
            close(tensor(found.stress)[:, i], tensor(single.stress), 1e-12)
            close(vector(found.displacement)[:, i], vector(single.displacement), 1e-12)

    def test_sensors_feel_a_touch_on_an_area(self):
        finger = ss.Finger(LAYER, ss.SensorArray.line(5, pitch=A, depth=A))
        touch = ss.PointLoad(components=(1.0, 0.2, 0.1), position=(0.5 * A, A))
        np.testing.assert_allclose(finger.read(touch), LAYER.strain(touch, A, finger.array.y, 0.0).xx, rtol=1e-13)

    def test_many_points_are_as_few(self):
        """By pieces of polynomials, or each by itself."""
        y = A * np.linspace(-9, 9, 101)
        many, few = (LAYER.state(LOCAL["patch"](), A, at, 0.2 * A) for at in (y, y[::25]))
        close(tensor(many.stress)[:, ::25], tensor(few.stress), 1e-12)


def test_a_stiff_base_changes_little_and_a_soft_one_much():
    """A half space as stiff as rigid, beneath."""
    x, y, z = A * np.array([0.5, 2.0]), A * np.array([0.3, -1.0]), A * np.array([0.2, 0.8])
    rigid, stiff, soft = (
        ss.Layered(ss.Layer(SOFT, 4 * A), base=base).stress(LOCAL["slip"](), x, y, z)
        for base in (None, ss.Material(4e13, 0.3), FIRM)
    )
    close(tensor(stiff), tensor(rigid), 1e-7)
    assert np.abs(tensor(soft) - tensor(rigid)).max() > 1e-3 * np.abs(tensor(rigid)).max()
