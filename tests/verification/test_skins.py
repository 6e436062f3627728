"""What must be true of any skin: one test body for layers, stacks and round fingers, and for all contacts."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest

import subskin as ss
from subskin.contact import contact_of, families

A = 1.25e-3  # half width [m], the length scale of every test
SOFT, FIRM = ss.Material(0.4e6, 0.5), ss.Material(3e6, 0.3)
SKINS = {
    "layer-0.5": ss.Layered(ss.Layer(SOFT, 4 * A)),
    "layer-0.3": ss.Layered(ss.Layer(ss.Material(0.4e6, 0.3), 4 * A)),
    "loose layer": ss.Layered(ss.Layer(SOFT, 4 * A, bond="frictionless")),
    "epidermis": ss.Layered([ss.Layer(FIRM, 0.4 * A), ss.Layer(SOFT, 3 * A)]),
    "sliding epidermis": ss.Layered([ss.Layer(FIRM, 0.4 * A, bond="frictionless"), ss.Layer(SOFT, 3 * A)]),
    "three on a half plane": ss.Layered(
        [ss.Layer(FIRM, 0.4 * A), ss.Layer(SOFT, 2 * A), ss.Layer(ss.Material(1e6, 0.45), A)], base=FIRM
    ),
    "round-0.5": ss.Round(SOFT, 8 * A, 4 * A),
    "round-0.3": ss.Round(ss.Material(0.4e6, 0.3), 8 * A, 1.5 * A),
    "thin round": ss.Round(SOFT, 8 * A, 7 * A),
}
CONTACTS = {
    **{name: contact_of(name, None if name == "line" else A)(40.0, 0.4, 0.2e-3) for name in families()},
    "punch": ss.FlatPunch(40.0, -0.3, 0.2e-3, half_width=A, moment=0.4 * 20 * A),
    "slip": ss.PartialSlip(40.0, 0.4, 0.2e-3, half_width=A, friction=0.6),
    "profile": ss.PressureProfile(
        A * np.array([-1.0, -0.4, 0.1, 1.0]), [2e3, 9e3, 4e3, 0.0], [0, 1e3, -4e3, 0]
    ),
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


def interfaces(skin):
    """Depths at which fields may jump, the surface and the base among them."""
    if isinstance(skin, ss.Round):
        return np.array([0.0, skin.thickness])
    ends = np.concatenate([[0.0], np.cumsum([layer.thickness for layer in skin.stack])])
    return ends if skin.base is None else np.append(ends, ends[-1] + 3 * A)


def curvature(skin, x):
    """1/r and d(arc)/dy at depth x: 0 and 1 in a flat skin."""
    if isinstance(skin, ss.Round):
        r = skin.radius - x
        return 1 / r, r / skin.radius
    return np.zeros_like(x), np.ones_like(x)


def points(skin):
    """Some points in the middle half of each layer, and the distance of each to the next interface."""
    rng = np.random.default_rng(1)
    ends = interfaces(skin)
    x = np.concatenate([a + (b - a) * rng.uniform(0.25, 0.75, 6) for a, b in pairwise(ends)])
    return x, A * rng.uniform(-3.0, 3.0, x.size), np.abs(x[:, None] - ends).min(axis=1)


def stencils(skin, contact):
    """States on 9 points along x and 9 along y about each point, with steps."""
    x, y, room = points(skin)
    h = room / 16
    along_x = skin.state(contact, x + h * STEPS[:, None], np.broadcast_to(y, (9, x.size)))
    along_y = skin.state(contact, np.broadcast_to(x, (9, x.size)), y + h * STEPS[:, None])
    return x, h, along_x, along_y


def test_equilibrium(skin, contact):
    """In the coordinates of the skin: d/dx of what acts across depth, d/ds along the arc, and the curvature's terms."""
    x, h, depth, along = stencils(skin, contact)
    bend, arc = curvature(skin, x)

    def by_x(f):
        return FIRST @ f / h

    def by_s(f):
        return FIRST @ f / (h * arc)

    s = depth.stress
    middle = {name: getattr(s, name)[4] for name in ("xx", "yy", "xy")}
    first = by_x(s.xx) + by_s(along.stress.xy) - bend * (middle["xx"] - middle["yy"])
    second = by_x(s.xy) + by_s(along.stress.yy) - 2 * bend * middle["xy"]
    scale = np.max([np.abs(m) for m in middle.values()], axis=0) / np.minimum(x, A)
    assert (np.abs(first) < 1e-6 * scale).all()
    assert (np.abs(second) < 1e-6 * scale).all()


def test_compatibility_of_flat_skins(skin, contact):
    if isinstance(skin, ss.Round):
        pytest.skip("in polar coordinates; there the displacements of the harmonics are compared instead")
    x, y, room = points(skin)
    h = room / 16
    grid = skin.strain(contact, (x + h * STEPS[:, None])[:, None], (y + h * STEPS[:, None])[None])
    yy = np.einsum("i,i...->...", SECOND, grid.yy[:, 4]) / h**2
    xx = np.einsum("i,i...->...", SECOND, grid.xx[4]) / h**2
    xy = np.einsum("i,j,ij...->...", FIRST, FIRST, grid.xy) / h**2
    scale = np.max([np.abs(c[4, 4]) for c in (grid.xx, grid.yy, grid.xy)], axis=0) / np.minimum(x, A) ** 2
    assert (np.abs(xx + yy - 2 * xy) < 1e-4 * scale).all()


def test_hooke(skin, contact):
    x, y, _ = points(skin)
    state = skin.state(contact, x, y)
    s, e = state.stress, state.strain
    if isinstance(skin, ss.Round):
        materials = [skin.material] * x.size
    else:
        stack = [*(layer.material for layer in skin.stack), skin.base]
        materials = [stack[i] for i in np.searchsorted(interfaces(skin)[1:-1], x)]
    young, nu = (np.array([getattr(m, name) for m in materials]) for name in ("young", "poisson"))
    assert np.allclose(
        e.xx, (s.xx - nu * (s.yy + s.zz)) / young, rtol=0, atol=1e-12 * np.abs(s.xx / young).max()
    )
    assert np.allclose(
        e.yy, (s.yy - nu * (s.xx + s.zz)) / young, rtol=0, atol=1e-12 * np.abs(s.xx / young).max()
    )
    assert np.allclose(e.xy, (1 + nu) / young * s.xy, rtol=1e-12)
    assert np.allclose(0 * s.zz, (s.zz - nu * (s.xx + s.yy)), rtol=0, atol=1e-12 * np.abs(s.zz).max())
    assert (e.zz == 0).all()


def test_the_traction_comes_back_at_the_surface(skin, contact):
    if isinstance(contact, ss.LineLoad):
        y = np.array([-0.5e-3, 0.6e-3, 3e-3])  # beside the load
    else:
        y = A * np.array([-2.7, -1.3, -0.37, 0.23, 0.71, 1.6, 3.1])
    s = skin.stress(contact, 0.0, y)
    scale = 40.0 / A
    assert np.abs(s.xx + contact.pressure(y)).max() < 1e-10 * scale
    assert np.abs(s.xy + contact.shear(y)).max() < 1e-10 * scale


def test_buried_surfaces_carry_the_load(skin, contact):
    """On a plane at any depth, or on a circle, the tractions add up to the load."""
    for share in (0.3, 0.9):
        depth = share * interfaces(skin)[-1]
        if isinstance(skin, ss.Round):
            y = np.linspace(0, skin.period, 4000, endpoint=False)
            s = skin.stress(contact, depth, y)
            phi, size = y / skin.radius, (skin.radius - depth) / skin.radius * skin.period / y.size
            # force on the core along the inward normal at y = 0 and along +y there
            down = (s.xx * np.cos(phi) + s.xy * np.sin(phi)).sum() * size
            along = (s.xy * np.cos(phi) - s.xx * np.sin(phi)).sum() * size
            # integrals of p cos(phi), q sin(phi) and so on are the spectra at one wave round the finger
            p, q = contact.spectrum(np.array(1 / skin.radius))
            wanted = p.real - q.imag, q.real + p.imag
            assert (-down, -along) == pytest.approx(wanted, abs=1e-9 * 40)
        else:
            y = np.linspace(-80 * A, 80 * A, 4001)
            s = skin.stress(contact, depth, y)
            normal, tangential = (float(np.trapezoid(c, y)) for c in (s.xx, s.xy))
            assert -normal == pytest.approx(float(contact.normal_force), rel=2e-3)
            if all(
                layer.bond == "bonded" for layer in skin.stack
            ):  # else a layer bears a drag by its own tension
                assert -tangential == pytest.approx(float(contact.tangential_force), abs=0.03 * 40)


def test_a_bonded_base_does_not_stretch(skin, contact):
    if not skin.grounded or (isinstance(skin, ss.Layered) and skin.stack[-1].bond == "frictionless"):
        pytest.skip("its base is not bonded and rigid")
    y = A * np.linspace(-6, 6, 31)
    e = skin.strain(contact, skin.thickness, y)
    assert np.abs(e.yy).max() < 1e-12 * max(np.abs(e.xy).max(), 1e-6)


def test_what_holds_across_an_interface(contact):
    """Bonded: tractions and the stretch along it. Frictionless: the normal traction, and no shear."""
    for name in ("epidermis", "sliding epidermis", "three on a half plane"):
        skin = SKINS[name]
        depth, y = skin.stack[0].thickness, A * np.linspace(-3, 3, 21)
        above, below = (skin.state(contact, d, y) for d in (depth, depth * (1 + 1e-9)))
        scale = np.abs(above.stress.xx).max()
        assert np.abs(above.stress.xx - below.stress.xx).max() < 1e-6 * scale
        assert np.abs(above.stress.xy - below.stress.xy).max() < 1e-6 * scale
        if name == "sliding epidermis":
            assert np.abs(above.stress.xy).max() < 1e-10 * scale
            assert np.abs(above.strain.yy - below.strain.yy).max() > 1e-2 * np.abs(above.strain.yy).max()
        else:
            assert np.abs(above.strain.yy - below.strain.yy).max() < 1e-6 * np.abs(above.strain.yy).max()
            assert np.abs(above.stress.yy - below.stress.yy).max() > 1e-2 * np.abs(above.stress.yy).max()


def test_superposition(skin):
    one, two = CONTACTS["hertz"], CONTACTS["punch"]
    x, y, _ = points(skin)
    parts = [skin.strain(c, x, y) for c in (one, two, one + two)]
    assert np.allclose(
        parts[2].xx, parts[0].xx + parts[1].xx, rtol=0, atol=1e-13 * np.abs(parts[2].xx).max() * 10
    )


def test_mirror(skin):
    x, y, _ = points(skin)
    a = skin.state(ss.Hertz(40.0, 0.4, 0.7e-3, half_width=A), x, y)
    b = skin.state(ss.Hertz(40.0, -0.4, -0.7e-3, half_width=A), x, -y)
    for tensor in ("stress", "strain"):
        one, two = getattr(a, tensor), getattr(b, tensor)
        size = np.abs(one.xx).max()
        for name, sign in (("xx", 1), ("yy", 1), ("zz", 1), ("xy", -1)):
            assert np.allclose(getattr(one, name), sign * getattr(two, name), rtol=0, atol=1e-12 * size)


def test_batches_broadcast_as_one_by_one(skin):
    force, position = np.array([10.0, 20.0, 30.0]), np.array([-1e-3, 0.0, 2e-3])
    batch = ss.Hertz(force, 0.3, position, half_width=A)
    x, y, _ = points(skin)
    x, y = x[:3], y[:3]
    single = [
        skin.strain(ss.Hertz(f, 0.3, p, half_width=A), x, y).xx for f, p in zip(force, position, strict=True)
    ]
    size = np.abs(single).max()
    assert np.allclose(skin.strain(batch.expand(1), x, y).xx, single, rtol=0, atol=1e-12 * size)
    assert np.allclose(skin.strain(batch, x, y).xx, np.diagonal(single), rtol=0, atol=1e-12 * size)
    one = [skin.strain(batch, a, b).xx for a, b in zip(x, y, strict=True)]
    assert np.allclose(skin.strain(batch, x[:, None], y[:, None]).xx, one, rtol=0, atol=1e-12 * size)
    assert skin.strain(batch, np.zeros((0, 1)), 0.0).xx.shape == (0, 3)


@pytest.mark.parametrize("nu", [0.5, 0.3])
def test_a_thick_layer_is_a_half_plane(nu):
    material, contact = ss.Material(0.4e6, nu), CONTACTS["hertz"]
    x, y = A * np.array([[0.1], [1.0], [2.0]]), A * np.linspace(-2, 2, 9)
    half = ss.HalfPlane(material).state(contact, x, y)
    heights = A * np.array([1e1, 1e2, 1e3])
    errors = []
    for height in heights:
        layer = ss.Layered(ss.Layer(material, height)).state(contact, x, y)
        errors.append(np.abs(layer.stress.yy - half.stress.yy).max() / np.abs(half.stress.yy).max())
    rates = np.diff(np.log(errors)) / np.diff(np.log(heights))
    assert np.all(rates < -0.9)
    assert errors[-1] < 5e-3
    same = ss.Layered([ss.Layer(material, A), ss.Layer(material, 2 * A)], base=material).state(contact, x, y)
    assert np.abs(same.stress.yy - half.stress.yy).max() < 1e-12 * np.abs(half.stress.yy).max()


@pytest.mark.parametrize("nu", [0.5, 0.3])
def test_a_large_round_finger_is_a_layer(nu):
    material, contact = ss.Material(0.4e6, nu), CONTACTS["hertz"]
    x, y = A * np.array([[0.1], [1.0], [3.0], [4.0]]), A * np.linspace(-2, 2, 9)
    layer = ss.Layered(ss.Layer(material, 4 * A)).state(contact, x, y)
    radii = A * np.array([1e2, 1e3, 1e4])
    errors = []
    for radius in radii:
        finger = ss.Round(material, radius, radius - 4 * A).state(contact, x, y)
        errors.append(np.abs(finger.strain.xx - layer.strain.xx).max() / np.abs(layer.strain.xx).max())
    rates = np.diff(np.log(errors)) / np.diff(np.log(radii))
    assert rates == pytest.approx([-1, -1], abs=0.05)
    assert errors[-1] < 1e-3


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


@pytest.mark.parametrize(
    "build", [lambda m: ss.Layered(ss.Layer(m, 4 * A)), lambda m: ss.Round(m, 8 * A, 4 * A)]
)
def test_incompressible_is_the_limit_and_no_special_case(build):
    """At any one place nu -> 1/2 is smooth; only the order with k -> 0 matters."""
    x, y = A * np.array([[0.5], [2.0], [3.9]]), A * np.linspace(-3, 3, 13)
    exact = build(SOFT).state(CONTACTS["hertz"], x, y)
    gaps = np.array([1e-3, 1e-5, 1e-7])
    errors = [
        np.abs(
            build(ss.Material(0.4e6, 0.5 - g)).state(CONTACTS["hertz"], x, y).strain.xx - exact.strain.xx
        ).max()
        for g in gaps
    ]
    assert np.diff(np.log10(errors)) == pytest.approx([-2, -2], abs=0.1)


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


def test_reciprocity_and_stiffness(skin):
    k = np.arange(1, 60) / skin.radius if isinstance(skin, ss.Round) else np.geomspace(1e-2, 1e3, 60) / A
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


@pytest.mark.parametrize("skin", [ss.HalfPlane(FIRM), ss.HalfPlane(FIRM, "stress"), *SKINS.values()])
def test_a_wave_strains_as_it_displaces(skin):
    """Its strains are derivatives of its displacements, by differences along x; along y they are known."""
    k = np.array([1.0, 4.0, 13.0]) * (skin.curvature or 0.1 / A)
    x = A * np.array([0.2, 0.7, 1.1, 2.2, 3.0])
    h, x = 1e-3 * A, x[x < 0.95 * skin.thickness]
    around = skin.wave(k, (x[:, None] + h * STEPS).reshape(-1))
    ux, uy = (u.reshape(k.size, x.size, 9, 2) for u in (around.ux, around.uy))
    bend, arc = curvature(skin, x)
    turns = (k[:, None] / arc)[..., None]
    wave = skin.wave(k, x)
    strains = {
        "xx": np.einsum("kxsl,s->kxl", ux, FIRST) / h,
        "yy": turns * wave.uy - bend[:, None] * wave.ux,
        "xy": 0.5 * (np.einsum("kxsl,s->kxl", uy, FIRST) / h + bend[:, None] * wave.uy - turns * wave.ux),
    }
    for name, expected in strains.items():
        seen = getattr(wave.strain, name)
        assert np.abs(seen - expected).max() < 1e-8 * np.abs(wave.strain.yy).max(), name


@pytest.mark.parametrize("name", ["round-0.5", "round-0.3", "thin round"])
def test_influence_on_a_round_finger_is_the_sum_of_its_waves(name):
    skin, step, count = SKINS[name], 0.05 * A, 400
    seen = skin.surface_influence(step, count)
    n = np.arange(1.0, 3e5)
    k = n / skin.radius
    share = step * np.sinc(0.5 * k * step / np.pi) ** 2 / (np.pi * skin.radius)
    c, mean = skin.surface_compliance(k) * share[:, None, None], skin.surface_compliance(np.zeros(1))[0]
    scale = np.abs(seen).max()
    for j in (0, 1, 9, 60, 399):
        cos, sin = np.cos(k * j * step), np.sin(k * j * step)
        waves = [[c[:, 0, 0] @ cos, -c[:, 0, 1] @ sin], [c[:, 1, 0] @ sin, c[:, 1, 1] @ cos]]
        expected = np.array(waves) + mean * np.eye(2) * step / (2 * np.pi * skin.radius)
        assert np.abs(seen[:, :, j] - expected).max() < (1e-10 if j > 1 else 1e-7) * scale  # the sum's end


@pytest.mark.parametrize(
    "name", ["layer-0.5", "layer-0.3", "epidermis", "three on a half plane", "loose layer"]
)
def test_influence_on_layers_is_the_integral_of_their_waves(name):
    """By the trapezoidal rule in log k, which shares nothing with the panels; differences where there is no datum."""
    skin, step = SKINS[name], 0.2 * A
    seen = skin.surface_influence(step, 61)
    k = np.exp(np.linspace(np.log(1e-7 / A), np.log(600 / A), 400_001))
    weight = k * (np.log(k[1]) - np.log(k[0])) * step * np.sinc(0.5 * k * step / np.pi) ** 2 / np.pi
    c = skin.surface_compliance(k) * weight[:, None, None]

    def expected(j):
        cos, sin = np.cos(k * j * step), np.sin(k * j * step)
        return np.array([[c[:, 0, 0] @ cos, -c[:, 0, 1] @ sin], [c[:, 1, 0] @ sin, c[:, 1, 1] @ cos]])

    scale = np.abs(seen[:, :, 1:] - seen[:, :, :1]).max()
    absolute = np.array([[skin.grounded, True], [True, skin.grounded and name != "loose layer"]])
    for j in (9, 20, 60):
        difference = seen[:, :, j] - seen[:, :, 4] - expected(j) + expected(4)
        assert np.abs(difference).max() < 2e-6 * scale
        assert np.abs((seen[:, :, j] - expected(j))[absolute]).max() < 2e-6 * scale


def test_a_surface_point_of_infinite_stress_is_blanked():
    punch = ss.FlatPunch(40.0, half_width=A)
    for skin in (SKINS["layer-0.5"], SKINS["round-0.5"]):
        with pytest.warns(ss.errors.SingularPointWarning):
            s = skin.stress(punch, 0.0, [A, 0.0])
        assert np.isnan(s.xx[0])
        assert np.isfinite(s.xx[1])
