"""What must be true of a half space under any local contact: one body for all of tests/_tables.py."""

from __future__ import annotations

from functools import cache
from inspect import signature

import numpy as np
import pytest

import subskin as ss
from subskin.contact import LocalContact, local_potentials_of, local_transforms_of

from .._tables import LOCAL, PLAIN, SOFT, A
from ._contract import FIRST, STEPS

FLAT = ss.HalfSpace(PLAIN)
COMPONENTS = ("xx", "yy", "zz", "xy", "xz", "yz")
TURNABLE = [name for name, build in LOCAL.items() if "turn" in signature(build).parameters]
SPREAD = [name for name in LOCAL if "point" not in name and name != "local sum"]

each = pytest.mark.parametrize("name", LOCAL)


def points(seed=3, count=8):
    """At depths of a third of a half width to three, beneath the contact and beside it; and far away."""
    rng = np.random.default_rng(seed)
    x, y, z = A * rng.uniform(0.3, 3.0, count), A * rng.uniform(-2.0, 2.0, count), A * rng.uniform(-2.0, 2.0, count)
    x[-2:], y[-2:], z[-2:] = A * np.array([[12.0, 3.0], [7.0, 40.0], [-5.0, 9.0]])
    return x, y, z


def tensor(found):
    """Its six components, shape (6, ...)."""
    return np.array([getattr(found, c) for c in COMPONENTS])


def vector(found):
    return np.array([found.x, found.y, found.z])


def close(seen, expected, share, size=None):
    """To a share of a size, that of the largest component at each point if there is none."""
    seen, expected = np.asarray(seen), np.asarray(expected)
    off = np.abs(seen - expected).max(axis=0) / (np.abs(expected).max(axis=0) if size is None else size)
    assert off.max() < share


class Stencil:
    """A function on the nine points along each axis about some points, for differences of the eighth order."""

    def __init__(self, function):
        self.x, self.y, self.z = points()
        self.step = np.minimum(self.x, A) / 24
        shift = self.step * STEPS[:, None]
        middle = (self.x, self.y, self.z)
        self.axes = [function(*(a + (i == k) * shift for i, a in enumerate(middle))) for k in range(3)]

    def by(self, axis, pick):
        return np.einsum("i,...in->...n", FIRST, pick(self.axes[axis])) / self.step

    def at(self, pick):
        return pick(self.axes[0])[..., 4, :]


@cache
def families(name):
    contact = LOCAL[name]()
    return Stencil(lambda x, y, z: (local_transforms_of(contact, x, y, z), local_potentials_of(contact, x, y, z)))


@cache
def states(name):
    return Stencil(lambda x, y, z: FLAT.state(LOCAL[name](), x, y, z))


@each
@pytest.mark.parametrize("which", ["p", "q", "r"])
def test_the_chain(name, which):
    """V_m' = -W_m, L V_m = W_{m+1}, L W_m = -W_{m+1}', L* W_{m+1} = W_m', with L = d/dy + i d/dz."""
    f = families(name)

    def w(pair):
        return getattr(pair[0], which)

    def dw(pair):
        return getattr(pair[0], f"d{which}")

    def v(pair):
        return getattr(pair[1], which)

    slopes, values, lifted = f.at(dw), f.at(w), f.at(v)
    size, slope_size = np.abs(values).max(axis=0), np.abs(slopes).max(axis=0)
    close(f.by(0, w), slopes, 5e-9, slope_size)
    close(f.by(0, v), -values[:3], 5e-9, size)
    up = f.by(1, w) + 1j * f.by(2, w)
    down = f.by(1, w) - 1j * f.by(2, w)
    close(up[:3], -slopes[1:], 5e-9, slope_size)
    close(down[1:], slopes[:3], 5e-9, slope_size)
    close(f.by(1, v) + 1j * f.by(2, v), values[1:], 5e-9, size)
    assert (np.abs(lifted) > 0).any()


@each
def test_the_core_is_what_it_says(name):
    f = families(name)
    q, dq, sq = (f.at(lambda pair, k=k: getattr(pair[0], k)) for k in ("q", "dq", "sq"))
    close(sq[None], (q[0] + 0.5 * f.x * dq[0])[None], 1e-11, np.abs(q[0]))


@each
def test_equilibrium(name):
    f = states(name)
    scale = np.abs(f.at(lambda s: tensor(s.stress))).max(axis=0) / np.minimum(f.x, A)

    def by(k, c):
        return f.by(k, lambda state: getattr(state.stress, c))

    xx, xy, xz = (by(0, c) for c in ("xx", "xy", "xz"))
    xy_y, yy, yz = (by(1, c) for c in ("xy", "yy", "yz"))
    xz_z, yz_z, zz = (by(2, c) for c in ("xz", "yz", "zz"))
    assert (np.abs(xx + xy_y + xz_z) < 2e-8 * scale).all()
    assert (np.abs(xy + yy + yz_z) < 2e-8 * scale).all()
    assert (np.abs(xz + yz + zz) < 2e-8 * scale).all()


@each
def test_strains_are_those_of_the_displacement(name):
    f = states(name)
    slopes = np.array([f.by(k, lambda s: vector(s.displacement)) for k in range(3)])  # d u_i / d x_k: [k, i]
    found = 0.5 * (slopes + np.swapaxes(slopes, 0, 1))
    e = f.at(lambda s: tensor(s.strain))
    seen = np.array([found[0, 0], found[1, 1], found[2, 2], found[0, 1], found[0, 2], found[1, 2]])
    close(seen, e, 1e-8)


@each
def test_hooke(name):
    state = FLAT.state(LOCAL[name](), *points())
    s, e = state.stress, state.strain
    young, nu = PLAIN.young, PLAIN.poisson
    expected = (1 + nu) / young * tensor(s)
    expected[:3] -= nu / young * s.trace
    close(tensor(e), expected, 1e-13)
    soft = ss.HalfSpace(SOFT).strain(LOCAL[name](), *points())
    assert (np.abs(soft.trace) < 1e-13 * np.abs(tensor(soft)).max(axis=0)).all()


@pytest.mark.parametrize("name", SPREAD)
def test_the_traction_comes_back_at_the_surface(name):
    contact = LOCAL[name]()
    rng = np.random.default_rng(0)
    y, z = A * rng.uniform(-1.0, 1.0, 12), A * rng.uniform(-0.8, 0.8, 12)
    y[-2:] *= 20
    p, q = contact.pressure(y, z), contact.shear(y, z)
    assert (p[:-2] > 0).any()
    assert not p[-2:].any()
    on, near = (FLAT.stress(contact, x, y, z) for x in (0.0, 1e-8 * A))
    size = np.abs(p).max()
    for s, share in ((on, 1e-10), (near, 3e-5)):
        close([s.xx, s.xy, s.xz], [-p, -q[..., 0], -q[..., 1]], share, size)
    close([near.yy, near.zz, near.yz], [on.yy, on.zz, on.yz], 3e-5, size)


def buried(contact, depth):
    """Forces and moments about the origin on a plane, by rings that reach to infinity."""
    t, w = np.polynomial.legendre.leggauss(30)
    share, turns = 0.5 * (1 + t), 2 * np.pi * np.arange(16) / 16
    r, dr = depth * share / (1 - share), 0.5 * depth * w / (1 - share) ** 2
    y, z = r[:, None] * np.cos(turns), r[:, None] * np.sin(turns)
    s = FLAT.stress(contact, depth, y, z)
    size = (r * dr)[:, None] * (2 * np.pi / 16)

    # the tails fall as the angles cancel: each ring is summed before all rings are
    def total(values):
        return float(((values * size).sum(axis=1)).sum())

    force = [total(s.xx), total(s.xy), total(s.xz)]
    turning = [total(y * s.xz - z * s.xy), total(z * s.xx - depth * s.xz), total(depth * s.xy - y * s.xx)]
    return -np.array(force), -np.array(turning)


@each
def test_a_buried_plane_carries_the_load(name):
    contact = LOCAL[name]()
    force, turning = buried(contact, 3.0 * A)
    close(force, contact.components, 1e-7, 1.0)
    y, z = contact.position
    _, ty, tz = contact.components
    h = 1e-3 / A
    first = [-contact.spectrum(*k).p.imag / h for k in ((h, 0.0), (0.0, h))]
    expected = [y * tz - z * ty + contact.torque, first[1], -first[0]]
    close(turning / A, np.array(expected) / A, 2e-6, 1.0)


@pytest.mark.parametrize("name", ["round hertz", "slip", "ellipse", "patch", "grid", "projections"])
def test_the_spectrum_is_that_of_the_field(name):
    """W_0 at a depth from the spectrum, by polar quadrature."""
    contact, depth = LOCAL[name](), 1.5 * A
    t, w = np.polynomial.legendre.leggauss(80)
    k, weight = 20 / depth * (1 + t), 20 / depth * w
    turns = 2 * np.pi * np.arange(64) / 64
    ky, kz = k[:, None] * np.cos(turns), k[:, None] * np.sin(turns)
    f = contact.spectrum(ky, kz)
    y, z = A * np.array([0.0, 0.7, -1.4]), A * np.array([0.0, -0.9, 0.3])
    kernel = np.exp(1j * (ky * y[:, None, None] + kz * z[:, None, None])) * np.exp(-np.hypot(ky, kz) * depth)
    measure = (k * weight)[:, None] * (2 * np.pi / 64) / (4 * np.pi**2)
    p, qy, qz = ((part * kernel * measure).sum(axis=(1, 2)).real for part in f)
    found = local_transforms_of(contact, np.full(3, depth), y, z)
    q = found.q[0] + found.t[0]
    close([found.p[0].real, q.real, q.imag], [p, qy, qz], 1e-10)


@each
def test_it_decays(name):
    contact = LOCAL[name]()
    r = A * np.logspace(3, 6, 4)
    for way in ((0.8, 0.5, -0.33), (0.1, -0.6, 0.79)):
        state = FLAT.state(contact, *(r * c for c in way))
        sizes = np.abs(tensor(state.stress)).max(axis=0)
        moved = np.abs(vector(state.displacement)).max(axis=0)
        assert np.polyfit(np.log(r), np.log(sizes), 1)[0] == pytest.approx(-2, abs=3e-3)
        assert np.polyfit(np.log(r), np.log(moved), 1)[0] == pytest.approx(-1, abs=3e-3)
        point = ss.PointLoad(components=contact.components)
        close(sizes[-1:], np.abs(tensor(FLAT.stress(point, *(r[-1:] * c for c in way)))).max(axis=0)[None], 1e-5)


@each
def test_mirror(name):
    x, y, z = points()
    here, there = (FLAT.state(LOCAL[name](side), x, y, side * z) for side in (1, -1))
    sign = np.array([1, 1, 1, 1, -1, -1])[:, None]
    close(tensor(there.stress), sign * tensor(here.stress), 1e-12)
    close(vector(there.displacement), sign[[0, 0, 5]] * vector(here.displacement), 1e-12)


@pytest.mark.parametrize("name", TURNABLE)
def test_rotation_by_any_angle(name):
    x, y, z = points()
    turn = 0.71
    c, s = np.cos(turn), np.sin(turn)
    q = np.array([[1.0, 0.0, 0.0], [0.0, c, -s], [0.0, s, c]])
    here = FLAT.state(LOCAL[name](), x, y, z)
    there = FLAT.state(LOCAL[name](turn=turn), x, c * y - s * z, s * y + c * z)
    turned = np.einsum("ij,njk,lk->iln", q, here.stress.matrix, q)
    close(np.moveaxis(there.stress.matrix, 0, -1).reshape(9, -1), turned.reshape(9, -1), 1e-11)
    close(vector(there.displacement), q @ vector(here.displacement), 1e-12)


@each
def test_superposition(name):
    where, build = points(), LOCAL[name]
    one, two = build(), LOCAL["patch"]()
    alone, beside, both = (FLAT.state(c, *where) for c in (one, two, one + two))
    close(tensor(both.stress), tensor(alone.stress) + tensor(beside.stress), 1e-13)
    close(vector(both.displacement), vector(alone.displacement) + vector(beside.displacement), 1e-13)
    close(tensor(FLAT.stress(build(p=3.0), *where)), 3 * tensor(alone.stress), 1e-12)
    assert sum([one, two]).components == pytest.approx(one.components + two.components)


class Bare(LocalContact):
    """Another contact, without its closed form."""

    def __init__(self, of, outline):
        self.of, self.OUTLINE = of, outline

    components, position = property(lambda self: self.of.components), property(lambda self: self.of.position)
    moment, support = property(lambda self: self.of.moment), property(lambda self: self.of.support)

    def pressure(self, y, z):
        return self.of.pressure(y, z)

    def shear(self, y, z):
        return self.of.shear(y, z)

    def spectrum(self, ky, kz):
        return self.of.spectrum(ky, kz)


@pytest.mark.parametrize(("name", "outline"), [("patch", "rectangle"), ("round hertz", "ellipse")])
def test_a_contact_without_a_closed_form(name, outline):
    """Deep, close beneath, and on the surface inside and outside."""
    known = LOCAL[name]()
    x, y, z = A * np.array([[1.2, 0.3, 0.6], [8.0, -2.0, 1.0], [1e-3, 0.4, -0.3], [0.0, 0.5, 0.1], [0.0, 1.9, -0.7]]).T
    seen, expected = (FLAT.state(c, x, y, z) for c in (Bare(known, outline), known))
    close(tensor(seen.stress), tensor(expected.stress), 1e-9)
    close(vector(seen.displacement), vector(expected.displacement), 1e-9)


def test_a_long_contact_is_the_limit_of_long_patches():
    """What the ends leave out is the field of what is missing, from a length on: it falls with the length."""
    n, t, x, y = 40.0, 12.0, A * np.array([0.4, 1.0, 2.0]), A * np.array([0.3, -1.2, 0.9])
    strip = FLAT.state(ss.Strip(np.hypot(n, t), np.arctan2(t, n), half_width=A), x, y, z=0.3 * A)
    assert strip.stress.is_plane
    lengths, off = A * np.array([30.0, 60.0, 120.0, 240.0]), []
    for half in lengths:
        patch = ss.Patch(components=2 * half * np.array([n, t, 0.0]), half_widths=(A, half))
        off.append(np.abs(tensor(FLAT.stress(patch, x, y, 0.3 * A)) - tensor(strip.stress)).max())
    assert np.polyfit(np.log(lengths), np.log(off), 1)[0] == pytest.approx(-1, abs=0.02)
    assert off[-1] < 2e-3 * np.abs(tensor(strip.stress)).max()


@pytest.mark.parametrize("components", [(1.0, 0.0, 0.0), (0.0, 0.6, 0.8), (0.7, 0.3, 0.0)])
def test_the_work_of_the_load_is_the_energy_in_the_skin(components):
    """Half of traction times displacement over the disc, and the energy density over the half space (Clapeyron)."""
    touch = ss.RoundHertz(components=components, half_width=A)
    t, w = np.polynomial.legendre.leggauss(40)
    share, size = 0.5 * (1 + t), 0.5 * w
    turns = 2 * np.pi * (np.arange(6) + 0.5) / 6  # squares of a field of harmonics 0 and 1, and their products
    r, dr = A * (1 - share**2), 2 * A * share * size
    y, z = r[:, None] * np.cos(turns), r[:, None] * np.sin(turns)
    moved, drag = FLAT.displacement(touch, 0.0, y, z), touch.shear(y, z)
    work = touch.pressure(y, z) * moved.x + drag[..., 0] * moved.y + drag[..., 1] * moved.z
    work = 0.5 * float(((r * dr)[:, None] * work).sum() * np.pi / 3)
    # oblate coordinates about the disc, in which the rim is smooth: r = a ch(u) sin(v), x = a sh(u) cos(v)
    u, du = 14 * share**2, 28 * share * size
    v, dv = 0.5 * np.pi * share, 0.5 * np.pi * size
    u, v = u[:, None, None], v[:, None]
    r, x = A * np.cosh(u) * np.sin(v), A * np.sinh(u) * np.cos(v)
    volume = A**2 * (np.sinh(u) ** 2 + np.cos(v) ** 2) * r * (du[:, None] * dv)[..., None]
    density = FLAT.state(touch, x + 0 * turns, r * np.cos(turns), r * np.sin(turns)).energy_density
    energy = float((volume * density).sum() * np.pi / 3)
    assert energy == pytest.approx(work, rel=2e-5)


@pytest.mark.parametrize("slopes", [(0.0, 0.0, 0.0), (150.0, -80.0, 2e4)])
def test_a_patch_that_is_turned_is_the_same_seen_from_turned_axes(slopes):
    turn = 0.4
    about = np.array([[np.cos(turn), -np.sin(turn)], [np.sin(turn), np.cos(turn)]])
    at, drag, sides = np.array([1e-3, -0.5e-3]), np.array([0.3, -0.4]), (3e-3, 1e-3)
    more = {"half_widths": sides, "slopes": slopes, "moment": 1e-4}
    straight = ss.Patch(components=(2.0, *drag), position=at, **more)
    turned = ss.Patch(components=(2.0, *(about @ drag)), position=about @ at, turn=turn, **more)
    skin = ss.HalfSpace(ss.Material(0.4e6, 0.45))
    for reach in (4e-3, 40e-3):
        seen = np.random.default_rng(1).uniform(-reach, reach, (12, 2))
        y, z = (seen @ about.T).T
        one, other = skin.stress(straight, 2e-3, *seen.T), skin.stress(turned, 2e-3, y, z)
        size = np.abs(one.xx).max()
        np.testing.assert_allclose(other.xx, one.xx, rtol=1e-9, atol=1e-12 * size)
        tensor, rotated = (np.array([[s.yy, s.yz], [s.yz, s.zz]]) for s in (one, other))
        wanted = np.einsum("ai,ij...,bj->ab...", about, tensor, about)
        np.testing.assert_allclose(rotated, wanted, rtol=0, atol=1e-9 * size)
    np.testing.assert_allclose(turned.torque, straight.torque, rtol=1e-12)
    inside = np.random.default_rng(2).uniform(-1, 1, (9, 2)) * sides + at
    np.testing.assert_allclose(turned.pressure(*(inside @ about.T).T), straight.pressure(*inside.T), rtol=1e-9)
    for one, other in zip(straight.shear(*inside.T), turned.shear(*(inside @ about.T).T), strict=True):
        np.testing.assert_allclose(other, about @ one, rtol=1e-9, atol=1e-9)
    waves = np.random.default_rng(3).uniform(-2e3, 2e3, (5, 2))
    k, r = waves.T, (waves @ about.T).T
    np.testing.assert_allclose(turned.unit_spectrum(*r), straight.unit_spectrum(*k), rtol=1e-9)
    low, high = turned.support
    corners = np.array([(a, b) for a in (-1, 1) for b in (-1, 1)]) * sides @ about.T + about @ at
    np.testing.assert_allclose([low, high], [corners.min(axis=0), corners.max(axis=0)], rtol=1e-12)
    tip = ss.SensorArray(y=y, z=z, depth=2e-3), ss.SensorArray(y=seen[:, 0], z=seen[:, 1], depth=2e-3)
    if not any(slopes):  # by the real form
        plain = [c.altered(moment=np.zeros(())) for c in (turned, straight)]
        reads = [ss.Finger(skin, array).read(c) for array, c in zip(tip, plain, strict=True)]
        np.testing.assert_allclose(*reads, rtol=1e-10)
