"""What must be true of any skin under any contact, and of any transducer in it: one body for tests/_tables.py."""

from __future__ import annotations

from dataclasses import fields

import numpy as np
import pytest

import subskin as ss

from .._tables import CONTACTS, FIRM, FORCE, PLAIN, SKINS, SOFT, TRANSDUCERS, A
from ._contract import (
    FIRST,
    ONCE,
    PAIRS,
    SECOND,
    STEPS,
    bonds,
    box,
    components,
    field,
    interfaces,
    is_even,
    largest,
    load,
    panels,
    points,
    resultants,
    slides,
    slope,
    traction,
)

SURFACE = A * np.array([-30.0, -2.13, -0.97, -0.61, -0.23, -0.07, 0.31, 0.47, 0.83, 1.21, 3.7])
"""Off every node, edge and tip of the contacts."""
EDGED = [name for name, build in CONTACTS.items() if name != "line" and build().singular_points()]

both = pytest.mark.parametrize(("skin", "contact"), PAIRS)
once = pytest.mark.parametrize(("skin", "contact"), ONCE)
each_skin = pytest.mark.parametrize("skin", SKINS)
each_contact = pytest.mark.parametrize("contact", CONTACTS)


def another(contact):
    """The next contact of the table."""
    names = list(CONTACTS)
    return CONTACTS[names[(names.index(contact) + 1) % len(names)]]()


def close(seen, expected, share, size=None):
    """To a share of a size, that of the largest if there is none."""
    off = np.abs(np.asarray(seen) - expected) / (np.abs(expected).max() if size is None else size)
    assert off.max() < share


@both
def test_equilibrium(skin, contact):
    """In the coordinates of the skin: d/dx of what acts across depth, d/ds along the arc, and the curvature's terms."""
    f = field(skin, contact)
    s, (xx, yy, xy) = f.state.stress, (getattr(f.state.stress, c)[4, 4] for c in ("xx", "yy", "xy"))
    scale = f.scale(s) / f.room
    assert (np.abs(f.by_x(s.xx) + f.by_s(s.xy) - f.bend * (xx - yy)) < 2e-8 * scale).all()
    assert (np.abs(f.by_x(s.xy) + f.by_s(s.yy) - 2 * f.bend * xy) < 2e-8 * scale).all()


@both
def test_compatibility(skin, contact):
    """Strains are those of a displacement (Malvern 1969, section II.3, for the curved ones)."""
    f = field(skin, contact)
    e = f.state.strain
    stretch = f.by_x(e.yy, SECOND, 2) + f.by_s(e.xx, SECOND, 2) + f.bend * (f.by_x(e.xx) - 2 * f.by_x(e.yy))
    turn = f.by_xs(e.gamma_xy) - f.bend * f.by_s(e.gamma_xy)
    assert (np.abs(stretch - turn) < 5e-7 * f.scale(e) / f.room**2).all()


@both
def test_hooke(skin, contact):
    f, skin = field(skin, contact), SKINS[skin]
    s, e = f.state.stress, f.state.strain
    made_of = [skin.materials[i] for i in np.searchsorted(skin.interfaces, f.x)]
    young, nu = (np.array([getattr(m, name) for m in made_of]) for name in ("young", "poisson"))
    size = largest(s).max() / young
    close(e.xx, (s.xx - nu * (s.yy + s.zz)) / young, 1e-12, size)
    close(e.yy, (s.yy - nu * (s.xx + s.zz)) / young, 1e-12, size)
    close(e.zz, (s.zz - nu * (s.xx + s.yy)) / young, 1e-12, size)
    np.testing.assert_allclose(e.xy, (1 + nu) / young * s.xy, rtol=1e-12)
    assert not (s.zz if getattr(skin, "plane", "strain") == "stress" else e.zz).any()


@both
def test_the_traction_comes_back_at_the_surface(skin, contact):
    skin, contact = SKINS[skin], CONTACTS[contact]()
    p, q = contact.pressure(SURFACE), contact.shear(SURFACE)
    on, near = (skin.stress(contact, x, SURFACE) for x in (0.0, 1e-9 * A))
    close(on.xx, -p, 1e-10, FORCE / A)
    close(on.xy, -q, 1e-10, FORCE / A)
    close(near.xx, -p, 1e-6, FORCE / A)
    close(near.xy, -q, 1e-6, FORCE / A)
    close(near.yy, on.yy, 1e-6, FORCE / A)


@both
@pytest.mark.parametrize("share", [0.1, 0.9])
def test_a_buried_plane_and_the_cuts_down_to_it_carry_the_load(skin, contact, share):
    skin, contact = SKINS[skin], CONTACTS[contact]()
    deepest = interfaces(skin)[-1] if np.isfinite(skin.thickness) else interfaces(skin)[-1] + 3 * A
    carried = resultants(skin, box(skin, contact, share * deepest, 10 * A))
    arm = 1.0, 1.0, 10 * A
    close(carried / arm, -load(skin, contact) / arm, 1e-9, FORCE)


@both
def test_it_decays(skin, contact):
    """As 1/r in what has no end, faster along what lies on a base; but nothing takes a drag off a layer that slides."""
    skin, contact = SKINS[skin], CONTACTS[contact]()
    if np.isfinite(skin.period):
        y = np.array([[4.0], [10.0], [22.0]]) * A
        x = min(skin.thickness, 0.5 / skin.curvature) * np.array([0.3, 0.8])
        sizes = np.maximum(largest(skin.stress(contact, x, y)), largest(skin.stress(contact, x, -y)))
        sizes = sizes.max(axis=1)
        assert (sizes[1:] < 0.8 * (sizes[:1] if slides(skin) else sizes[:-1])).all()  # a loose ring bends all about
    elif np.isfinite(skin.thickness):
        x, y = skin.thickness * np.array([[0.05], [0.3], [0.8]]), A * np.array([-200.0, -150.0, 150.0, 200.0])
        loose = slides(skin)
        s, drag = skin.stress(contact, x, y), -np.sign(y) * contact.tangential_force
        close(s.yy, np.where(x < loose, drag / (2 * loose or 1.0), 0.0), 1e-6, FORCE / A)
        close([s.xx, s.xy], 0.0, 1e-6, FORCE / A)
    else:
        radii, direction = A * np.logspace(4, 6, 5), np.array([-1.1, 0.2, 0.7])
        sizes = [largest(skin.stress(contact, r * np.cos(direction), r * np.sin(direction))) for r in radii]
        for size in np.transpose(sizes):
            assert slope(radii, size) == pytest.approx(-1, abs=2e-3)


@both
def test_superposition(skin, contact):
    """Of two contacts, of a contact and itself, and of a force three times as large."""
    skin, build = SKINS[skin], CONTACTS[contact]
    x, y, _ = points(skin)

    def seen(c):
        return components(skin.state(c, x, y))

    one, two = build(), another(contact)
    for size in (slice(0, 4), slice(4, 8)):
        alone, beside = seen(one)[size], seen(two)[size]
        close(seen(one + two)[size], alone + beside, 1e-12)
        close(seen(one + one + one)[size], 3 * alone, 1e-12)
        close(seen(build(p=3 * FORCE))[size], 3 * alone, 1e-12)


@both
def test_mirror(skin, contact):
    skin, build = SKINS[skin], CONTACTS[contact]
    x, y, _ = points(skin)
    here, there = (components(skin.state(build(side), x, side * y)) for side in (1, -1))
    sign = np.array([1, 1, 1, -1])[:, None]
    close(there[:4], sign * here[:4], 1e-12)
    close(there[4:], sign * here[4:], 1e-12)


@both
def test_batches_broadcast_as_one_by_one(skin, contact):
    skin, build = SKINS[skin], CONTACTS[contact]
    x, y, _ = points(skin, each=2)
    x, y, force = x[:2], y[:2], np.array([10.0, 20.0, 40.0])
    single = np.array([skin.strain(build(p=p), x, y).xx for p in force])
    batch = build(p=force)
    close(skin.strain(batch.expand(1), x, y).xx, single, 1e-12)
    close(skin.strain(batch, x[:, None], y[:, None]).xx, single.T, 1e-12)
    close(skin.strain(batch, x[0], y[0]).xx, single[:, 0], 1e-12)
    assert skin.strain(batch, np.zeros((0, 1)), 0.0).xx.shape == (0, 3)


@pytest.mark.parametrize(("skin", "contact"), [pair for pair in PAIRS if pair[1] != "line"])
def test_narrow_contacts_tend_to_the_line_load(skin, contact):
    """Saint-Venant: what a contact adds to its resultant falls with its width, a symmetric one's with its square."""
    skin, widths = SKINS[skin], A * np.array([0.04, 0.02, 0.01, 0.005])
    x, y = 0.3 * A + points(skin)[0].min(), A * np.array([0.4, -1.3, 0.9])
    off = []
    for a in widths:
        narrow = CONTACTS[contact](a=a)
        n, t = narrow.normal_force, narrow.tangential_force
        line = ss.LineLoad(np.hypot(n, t), np.arctan2(t, n), np.mean(narrow.support))
        off.append(np.abs(components(skin.state(narrow, x, y)) - components(skin.state(line, x, y)))[:4].max())
    assert slope(widths, off) == pytest.approx(2 if is_even(narrow) else 1, abs=0.1)


@both
def test_a_bonded_base_does_not_stretch_and_interfaces_pass_on_what_they_can(skin, contact):
    """Bonded: tractions and the stretch along it. Frictionless: the normal traction, and no shear but a torque's."""
    skin, contact = SKINS[skin], CONTACTS[contact]()
    y = A * np.linspace(-6, 6, 31)
    made_of = [*skin.materials, None]  # None for what is rigid
    for depth, bond, above, below in zip(interfaces(skin)[1:], bonds(skin), made_of, made_of[1:]):
        upper = skin.state(contact, depth, y)
        size, stretch = np.abs(upper.stress.xx).max(), np.abs(upper.strain.yy).max()
        if bond == "frictionless":
            evenly = contact.tangential_force * skin.curvature / (2 * np.pi)  # what holds a ring that is turned
            close(upper.stress.xy, -evenly / (1 - skin.curvature * depth) ** 2, 1e-10, size)
        if below is None:
            assert bond == "frictionless" or stretch < 1e-12 * np.abs(upper.strain.xy).max()
            continue
        lower = skin.state(contact, depth * (1 + 1e-9), y)
        close(upper.stress.xx, lower.stress.xx, 1e-6, size)
        close(upper.stress.xy, lower.stress.xy, 1e-6, size)
        slip = np.abs(upper.strain.yy - lower.strain.yy).max()
        assert slip > 1e-2 * stretch if bond == "frictionless" else slip < 1e-6 * stretch
        assert above == below or np.abs(upper.stress.yy - lower.stress.yy).max() > 1e-2 * size


@pytest.mark.parametrize("contact", EDGED)
@each_skin
def test_a_surface_point_of_infinite_stress_is_blanked(skin, contact):
    edge = min(float(point) for point in CONTACTS[contact]().singular_points() if np.isfinite(point))
    with pytest.warns(ss.errors.SingularPointWarning):
        s = SKINS[skin].stress(CONTACTS[contact](), 0.0, [edge, edge + 0.03 * A])
    assert np.isnan(s.xx[0])
    assert np.isfinite(s.xx[1])


def one(material, thickness=4 * A, **more):
    return ss.Layered(ss.Layer(material, thickness), **more)


EPIDERMIS = ss.Layer(FIRM, 2 * A)


LIMITS = {  # what a skin becomes: (the skin by a parameter, what it tends to, the power with which it does, parameters)
    "a thick layer": (lambda h: one(SOFT, h * A), ss.HalfPlane(SOFT), -1, (1e1, 1e2, 1e3)),
    "a thick layer-0.3": (lambda h: one(PLAIN, h * A), ss.HalfPlane(PLAIN), -1, (1e1, 1e2, 1e3)),
    "a large finger": (lambda r: ss.Round(SOFT, r * A, (r - 4) * A), one(SOFT), -1, (1e2, 4e2, 16e2)),
    "a large finger-0.3": (lambda r: ss.Round(PLAIN, r * A, (r - 4) * A), one(PLAIN), -1, (1e2, 4e2, 16e2)),
    "a large finger with an epidermis": (
        lambda r: ss.Round(SOFT, r * A, (r - 4) * A, EPIDERMIS),
        ss.Layered([EPIDERMIS, ss.Layer(SOFT, 2 * A)]), -1, (1e2, 2e2, 4e2),
    ),
    "a stiff core": (
        lambda e: ss.Round(PLAIN, 8 * A, 4 * A, core=ss.Material(e, 0.3)), ss.Round(PLAIN, 8 * A, 4 * A),
        -1, (1e8, 1e9, 1e10),
    ),
    "a stiff base": (lambda e: one(SOFT, base=ss.Material(e, 0.3)), one(SOFT), -1, (1e8, 1e9, 1e10)),
    "incompressible": (lambda g: one(ss.Material(0.4e6, 0.5 - g)), one(SOFT), 1, (1e-3, 1e-5, 1e-7)),
    "incompressible finger": (
        lambda g: ss.Round(ss.Material(0.4e6, 0.5 - g), 8 * A, 4 * A), SKINS["round-0.5"], 1, (1e-3, 1e-5, 1e-7)
    ),
}  # fmt: skip


@pytest.mark.parametrize("contact", ["line", "slip", "tilted"])
@pytest.mark.parametrize("name", LIMITS)
def test_limits(name, contact):
    build, limit, power, sizes = LIMITS[name]
    x, y = A * np.array([[0.1], [1.0], [2.0], [3.9]]), A * np.linspace(-2, 2, 9)
    wanted, *seen = (
        components(skin.state(CONTACTS[contact](), x, y))[[0, 1, 3, 4, 5, 7]] for skin in (limit, *map(build, sizes))
    )
    off = [np.abs(s - wanted).max(axis=(1, 2)) / np.abs(wanted).max(axis=(1, 2)) for s in seen]
    assert slope(sizes, np.max(off, axis=1)) == pytest.approx(power, abs=0.05)


@pytest.mark.parametrize("contact", ["line", "slip", "tilted"])
@pytest.mark.parametrize("material", [SOFT, PLAIN])
def test_layers_of_one_material_are_one_half_plane(material, contact):
    x, y = A * np.array([[0.1], [1.0], [2.0], [3.9]]), A * np.linspace(-2, 2, 9)
    stack = ss.Layered([ss.Layer(material, A), ss.Layer(material, 2 * A)], base=material)
    seen, wanted = (skin.stress(CONTACTS[contact](), x, y) for skin in (stack, ss.HalfPlane(material)))
    for c in ("xx", "yy", "zz", "xy"):
        close(getattr(seen, c), getattr(wanted, c), 1e-12)


@pytest.mark.parametrize("material", [SOFT, PLAIN])
def test_rings_of_one_material_are_one_ring(material):
    x, y = A * np.array([[0.1], [1.0], [2.0], [3.9]]), A * np.linspace(-2, 2, 9)
    one = ss.Round(material, 8 * A, 2 * A)
    cut = ss.Round(material, 8 * A, 2 * A, [ss.Layer(material, A), ss.Layer(material, 2 * A)])
    for contact in ("line", "slip", "tilted"):
        seen, wanted = (components(skin.state(CONTACTS[contact](), x, y)) for skin in (cut, one))
        close(seen[:4], wanted[:4], 1e-12)
        close(seen[4:], wanted[4:], 1e-12)


@each_contact
def test_spectrum_is_that_of_the_traction(contact):
    contact = CONTACTS[contact]()
    waves = np.array([0.0, 1e-3, 0.05, 0.7, 3.0, 21.0, 60.0]) / A
    seen, bar = contact.spectrum(waves), 1e-8 if contact.singular_points() else 1e-10
    for part, k in enumerate(waves):
        p, q = sum(
            traction(c, lambda y, k=k: np.exp(-1j * k * y))
            if c.support[0] < c.support[1]
            else np.array([c.normal_force, c.tangential_force]) * np.exp(-1j * k * c.position)
            for c in getattr(contact, "parts", [contact])
        )
        close([seen.p[part], seen.q[part]], [p, q], bar, FORCE)
    close([seen.p[0], seen.q[0]], [contact.normal_force, contact.tangential_force], 1e-12)


@each_contact
def test_support_is_where_it_presses(contact):
    contact = CONTACTS[contact]()
    low, high = contact.support
    outside = np.array([low - 1e-9, high + 1e-9])
    assert not contact.pressure(outside).any()
    assert not contact.shear(outside).any()
    if low < high:
        assert (contact.pressure(np.array([low + 1e-6, high - 1e-6])) != 0).all()


def times(state, factor):
    """The state under a load `factor` times as large."""
    return ss.tensor.State(*(
        type(t)(*(factor * getattr(t, f.name) for f in fields(t))) for t in (state.stress, state.strain)
    ))  # fmt: skip


def sensors(skin, **more):
    """A finger with one sensor of each kind of `more["transducer"]`, at depths and places of their own."""
    count = len(more["transducer"])
    depth = min(skin.thickness, 4 * A) * np.linspace(0.2, 0.9, count)
    return ss.Finger(skin, ss.SensorArray(y=A * np.linspace(-2.1, 1.7, count), depth=depth, **more))


@once
@pytest.mark.parametrize("kind", TRANSDUCERS)
def test_a_transducer_and_its_linear_part(kind, skin, contact):
    """Linear is what grows with the load and turns with its sign; else its linear part is its slope at no load."""
    kind, state = TRANSDUCERS[kind], SKINS[skin].state(CONTACTS[contact](), 0.4 * A, SURFACE)
    full = kind.measure(state)
    off = [np.abs(kind.measure(times(state, s)) - s * full).max() / np.abs(full).max() for s in (2, -1)]
    if kind.linear:
        assert max(off) < 1e-14
        assert kind.linear_part == kind
        assert kind.linearise(full) is full
        return
    assert max(off) > 1e-6
    if not kind.linear_part.linear:
        with pytest.raises(ss.errors.NotLinearError, match=type(kind).__name__):
            kind.linearise(full)
        with pytest.raises(ss.errors.NotLinearError, match=type(kind).__name__):
            sensors(SKINS[skin], transducer=[kind]).receptive_field(0.0)
        return
    small, slope_at_rest = 1e-4, kind.linear_part.measure(state)
    up, down = (kind.measure(times(state, s)) for s in (small, -small))
    close((up - down) / (2 * small), slope_at_rest, 1e-6)
    close(kind.linearise(up) / small, slope_at_rest, 1e-3)


@once
def test_a_finger_reads_what_its_transducers_measure_where_they_are(skin, contact):
    """Point sensors exactly, wide ones by a quadrature of three times as many points."""
    skin, contact, kinds = SKINS[skin], CONTACTS[contact](), list(TRANSDUCERS.values())
    gain, offset = np.linspace(1, 5, len(kinds)), np.linspace(-1, 1, len(kinds))
    finger = sensors(skin, transducer=kinds, gain=gain, offset=offset)
    y, depth = finger.array.y, finger.array.depth
    width = depth * np.linspace(0.1, 3.0, len(kinds))
    wide = sensors(skin, transducer=kinds, width=width).read(contact)
    t, weight = panels(np.linspace(-0.5, 0.5, 9))
    across = skin.state(contact, depth[:, None], y[:, None] + width[:, None] * t)
    at = skin.state(contact, depth, y)
    point = (finger.read(contact) - offset) / gain
    for i, kind in enumerate(kinds):
        np.testing.assert_allclose(point[i], kind.measure(at)[i], rtol=1e-12, atol=1e-15)
        # the largest compressive strain has a kink where it changes direction: no quadrature is exact there
        rtol = 1e-2 if isinstance(kind, ss.MaxCompressiveStrain) else 1e-9
        np.testing.assert_allclose(wide[i], kind.measure(across)[i] @ weight, rtol=rtol, atol=1e-15)


@once
def test_receptive_fields_are_what_readings_change_by(skin, contact):
    """And readings of two contacts are the sum of those of each."""
    skin, contact = SKINS[skin], CONTACTS[contact]()
    kinds = [kind for kind in TRANSDUCERS.values() if kind.linear]
    finger = sensors(skin, transducer=kinds, gain=np.linspace(-1, 5, len(kinds)), offset=0.5, width=0.3 * A)
    rest, positions = finger.read(ss.LineLoad(0.0)), A * np.array([[-3.0, 0.2], [1.0, 4.0]])
    response = finger.receptive_field(positions)
    assert response.shape == (2, 2, len(kinds), 2)
    size = np.abs(response).max(axis=(0, 1, 3)) + 1e-3
    change = finger.read(ss.LineLoad(1.0, np.arctan2(-0.8, 0.6), positions)) - rest
    close(response @ [0.6, -0.8], change, 1e-12, size)
    line = ss.LineLoad(FORCE, 0.3, A)
    alone, beside, together = (finger.read(c) - rest for c in (contact, line, contact + line))
    close(together, alone + beside, 1e-12, FORCE * size)


@pytest.mark.parametrize("name", SKINS)
def test_a_wave_strains_as_it_displaces(name):
    """Its strains are derivatives of its displacements, by differences along x; along y they are known."""
    skin = SKINS[name]
    k = np.array([1.0, 4.0, 13.0]) * (skin.curvature or 0.1 / A)
    x = A * np.array([0.2, 0.7, 1.1, 2.2, 3.0])
    h, x = 1e-3 * A, x[x < 0.95 * skin.thickness]
    x = x[np.abs(x[:, None] - interfaces(skin)).min(axis=1) > 5 * h]
    around = skin.wave(k, (x[:, None] + h * STEPS).reshape(-1))
    ux, uy = (u.reshape(k.size, x.size, 9, 2) for u in (around.ux, around.uy))
    bend = skin.curvature / (1 - skin.curvature * x)
    turns = (k[:, None] / (1 - skin.curvature * x))[..., None]
    wave = skin.wave(k, x)
    strains = {
        "xx": np.einsum("kxsl,s->kxl", ux, FIRST) / h,
        "yy": turns * wave.uy - bend[:, None] * wave.ux,
        "xy": 0.5 * (np.einsum("kxsl,s->kxl", uy, FIRST) / h + bend[:, None] * wave.uy - turns * wave.ux),
    }
    for component, expected in strains.items():
        seen = getattr(wave.strain, component)
        assert np.abs(seen - expected).max() < 1e-8 * np.abs(wave.strain.yy).max(), component
