"""The half space and the local contacts at the door: shapes, batches, singular points, errors, and what books say."""

from __future__ import annotations

import copy
import pickle
from dataclasses import replace

import numpy as np
import pytest
from scipy.special import ellipk

import subskin as ss
from subskin.contact import LocalContact, RoundContact
from subskin.errors import GeometryError, InvalidValueError, SingularPointWarning

from .._tables import LOCAL, A

RUBBER = ss.Material(0.4e6, 0.4)
FLAT = ss.HalfSpace(RUBBER)
SIX = ("xx", "yy", "zz", "xy", "xz", "yz")
each = pytest.mark.parametrize("name", LOCAL)


def tensor(found):
    return np.array([getattr(found, c) for c in SIX])


class TestBooks:
    """Johnson, Contact Mechanics (1985), chapters 3 to 5."""

    def test_a_flat_punch_sinks_evenly(self):
        force, a = 2.0, 1.5e-3
        y = a * np.array([0.0, 0.3, 0.7, 0.99])
        moved = FLAT.displacement(ss.RoundPunch(force=force, half_width=a), 0.0, y, 0.1 * a)
        expected = force * (1 - 0.4**2) / (2 * a * RUBBER.young)
        np.testing.assert_allclose(moved.x, expected, rtol=1e-13)

    def test_a_sphere_leaves_its_shape(self):
        """By R = 4 E* a^3 / (3 N), and its middle goes down by a^2 / R."""
        force, a = 2.0, 1.5e-3
        radius = 4 * RUBBER.plane_strain_modulus * a**3 / (3 * force)
        r = a * np.array([0.0, 0.4, 0.8, 1.0])
        moved = FLAT.displacement(ss.RoundHertz(force=force, half_width=a), 0.0, 0.6 * r, 0.8 * r)
        np.testing.assert_allclose(moved.x, a**2 / radius - r**2 / (2 * radius), rtol=1e-13)

    def test_an_ellipsoid_leaves_its_shape(self):
        """A quadratic form in y and z."""
        touch = ss.EllipticHertz(force=2.0, half_widths=(2e-3, 1e-3), turn=0.4)
        y, z = (
            1e-3 * np.array([0.1, -0.5, 0.9, 0.3, -0.2, 0.6, 0.0]),
            1e-3 * np.array([0.2, 0.1, 0.4, -0.3, 0.3, 0.1, 0.0]),
        )
        moved = FLAT.displacement(touch, 0.0, y, z).x
        rows = np.stack([np.ones(7), y**2, y * z, z**2], axis=1)
        shape, *_ = np.linalg.lstsq(rows / moved[:, None], np.ones(7), rcond=None)
        np.testing.assert_allclose(rows @ shape, moved, rtol=1e-12)
        # section 4.2: the middle goes down by 3 N K(e) / (2 pi a E*)
        middle = 3 * 2.0 * ellipk(1 - 0.5**2) / (2 * np.pi * 2e-3 * RUBBER.plane_strain_modulus)
        assert moved[-1] == pytest.approx(middle, rel=1e-12)

    def test_a_cone_leaves_its_shape(self):
        a = 1e-3
        r = a * np.array([0.1, 0.4, 0.7, 1.0])
        moved = FLAT.displacement(ss.Cone(force=1.0, half_width=a), 0.0, r, 0.0).x
        np.testing.assert_allclose(np.diff(moved), np.diff(moved)[0], rtol=1e-12)
        slope = -np.diff(moved)[0] / np.diff(r)[0]
        assert slope == pytest.approx(2 * 1.0 / (np.pi * RUBBER.plane_strain_modulus * a**2), rel=1e-12)

    def test_a_disc_that_is_turned_turns_as_a_whole(self):
        """Reissner and Sagoci: M = (16/3) G a^3 beta."""
        moment, a = 1e-3, 1.5e-3
        r, turn = a * np.array([0.2, 0.6, 0.99]), 0.7
        moved = FLAT.displacement(
            ss.RoundHertz(force=0.0, half_width=a, moment=moment), 0.0, r * np.cos(turn), r * np.sin(turn)
        )
        beta = 3 * moment / (16 * RUBBER.shear * a**3)
        np.testing.assert_allclose(moved.z * np.cos(turn) - moved.y * np.sin(turn), beta * r, rtol=1e-12)
        np.testing.assert_allclose(moved.y * np.cos(turn) + moved.z * np.sin(turn), 0.0, atol=1e-15 * a)
        assert (moved.x == 0).all()

    def test_a_body_that_sticks_moves_as_a_whole(self):
        """What sticks moves evenly along the drag at nu = 1/2 (Mindlin 1949)."""
        skin = ss.HalfSpace(ss.Material(0.4e6, 0.5))
        for stick, reach in ((0.6, 0.59), (1.0, 0.99)):
            touch = ss.RoundHertz(components=(1.0, 0.3, 0.4), half_width=1e-3, stick=stick * 1e-3)
            r = reach * 1e-3 * np.array([0.1, 0.5, 1.0])
            moved = skin.displacement(touch, 0.0, 0.6 * r, -0.8 * r)
            # the pressure moves no point of the surface along it at nu = 1/2
            np.testing.assert_allclose(moved.z / moved.y, 4 / 3, rtol=1e-9)
            # by 3 (2 - nu) mu N (1 - (c/a)^2) / (16 G a), with T = mu N (1 - (c/a)^3); to its limit for c = a
            share = (1 - stick**2) / (1 - stick**3) if stick < 1 else 2 / 3
            expected = 3 * 1.5 * 0.3 * share / (16 * skin.material.shear * 1e-3)
            np.testing.assert_allclose(moved.y, expected, rtol=1e-9)

    def test_torsion_is_invisible_to_normal_strain_and_pressure(self):
        x, y, z = 1e-3 * np.array([[0.5, 1.0], [0.3, -2.0], [0.8, 0.1]])
        for build in (LOCAL["point torque"], LOCAL["ellipse"], LOCAL["twisted"]):
            load = build()
            still = FLAT.state(replace(load, moment=0.0), x, y, z)
            state = FLAT.state(load, x, y, z)
            np.testing.assert_allclose(state.strain.xx, still.strain.xx, rtol=1e-12)
            np.testing.assert_allclose(state.stress.mean_pressure, still.stress.mean_pressure, rtol=1e-12)
            assert (np.abs(state.stress.yz - still.stress.yz) > 1e-3 * np.abs(still.stress.yz)).all()


class TestForces:
    def test_both_forms_are_the_same_load(self):
        polar = ss.PointLoad(2.0, 0.4, -2.1, (1e-3, 2e-3))
        same = ss.PointLoad(components=polar.components, position=(1e-3, 2e-3))
        assert (float(same.force), float(same.angle), float(same.azimuth)) == pytest.approx((2.0, 0.4, -2.1))
        assert polar.components == pytest.approx(
            [2 * np.cos(0.4), 2 * np.sin(0.4) * np.cos(-2.1), 2 * np.sin(0.4) * np.sin(-2.1)]
        )
        assert ss.PointLoad(1.0, np.pi / 2).normal_force == 0.0

    def test_azimuth_turns_from_y_to_z(self):
        assert ss.PointLoad(1.0, np.pi / 2, np.pi / 2).components[2] == 1.0

    @pytest.mark.parametrize(
        ("arguments", "match"),
        [
            ({}, "no force"),
            ({"force": 1.0, "components": (1.0, 0.0, 0.0)}, "one form"),
            ({"angle": 0.2, "components": (1.0, 0.0, 0.0)}, "one form"),
            ({"force": -1.0}, "turn the angle"),
            ({"force": 1.0, "angle": -0.2}, "the azimuth says"),
            ({"force": 1.0, "angle": 30.0}, "radians"),
            ({"force": np.nan}, "finite"),
            ({"components": (1.0, 0.0)}, r"\(\.\.\., 3\)"),
            ({"force": 1.0, "position": 1e-3}, r"\(\.\.\., 2\)"),
            ({"force": [1.0, 2.0], "position": np.zeros((3, 2))}, "broadcast"),
        ],
    )
    def test_what_is_refused(self, arguments, match):
        with pytest.raises((InvalidValueError, GeometryError), match=match):
            ss.PointLoad(**arguments)

    @pytest.mark.parametrize(
        ("make", "match"),
        [
            (lambda: ss.RoundHertz(1.0), "half_width"),
            (lambda: ss.RoundHertz(1.0, half_width=0.0), "PointLoad"),
            (lambda: ss.RoundHertz(1.0, half_width=1e-3, stick=2e-3), "within the contact"),
            (lambda: ss.Patch(1.0), "half_widths"),
            (lambda: ss.Patch(1.0, half_widths=1e-3), r"\(a_y, a_z\)"),
            (lambda: ss.EllipticHertz(1.0, half_widths=(1e-3, -1e-3)), "> 0"),
            (lambda: ss.PressureGrid([0.0, 1.0], [1.0, 0.0], np.ones((2, 2))), "ascend"),
            (lambda: ss.PressureGrid([0.0, 1.0], [0.0, 1.0], np.ones((2, 3))), "are needed"),
            (lambda: ss.FromProjections(3.0, force=1.0), "a long contact or a function"),
            (lambda: ss.FromProjections(ss.Strip(1.0, position=1e-3, half_width=1e-3), force=1.0), "both sides"),
            (lambda: ss.FromProjections(ss.Strip([1.0, 2.0], half_width=1e-3), force=1.0), "single"),
        ],
    )
    def test_lengths_that_are_refused(self, make, match):
        with pytest.raises((InvalidValueError, GeometryError), match=match):
            make()

    def test_moment_of_a_sum_and_of_a_grid(self):
        patch = ss.Patch(components=(0.0, 1.0, 2.0), half_widths=(1e-3, 2e-3), slopes=(200.0, 100.0, 0.0), moment=1e-3)
        assert float(patch.torque) == pytest.approx(1e-3 + 2 * 200 * 1e-6 / 3 - 100 * 4e-6 / 3)
        pair = ss.PointLoad(components=(0, 1.0, 0), position=(0.0, -1e-3)) + ss.PointLoad(
            components=(0, -1.0, 0), position=(0.0, 1e-3)
        )
        assert float(pair.moment) == pytest.approx(2e-3)
        assert pair.components.tolist() == [0.0, 0.0, 0.0]


class TestSkins:
    def test_a_long_contact_is_as_on_a_half_plane(self):
        long, x, y = ss.Hertz(40.0, 0.3, half_width=A), A * np.array([0.5, 2.0]), A * np.array([0.1, -1.0])
        plane, space = ss.HalfPlane(RUBBER).state(long, x, y), FLAT.state(long, x, y, z=[[0.0], [1e-3], [5.0]])
        assert space.stress.xx.shape == (3, 2)
        for c in ("xx", "yy", "zz", "xy"):
            assert (getattr(space.strain, c) == getattr(plane.strain, c)).all()
        assert not space.stress.xz.any()
        wide = ss.HalfPlane(RUBBER).stress(long, x, y, z=np.zeros((4, 1)))
        assert wide.xx.shape == (4, 2)
        with pytest.raises(InvalidValueError, match="only up to a constant"):
            FLAT.displacement(long, x, y)

    @pytest.mark.parametrize("skin", [ss.HalfPlane(RUBBER), ss.Round(RUBBER, 8e-3, 4e-3)], ids=["half plane", "round"])
    @pytest.mark.parametrize("ask", ["stress", "strain", "displacement"])
    def test_skins_of_a_plane_say_why_they_do_not(self, skin, ask):
        with pytest.raises(InvalidValueError, match=r"a RoundHertz on a \w+: it acts on an area.*HalfSpace"):
            getattr(skin, ask)(LOCAL["round hertz"](), 1e-3, 0.0)
        finger = ss.Finger(skin, ss.SensorArray.line(3, pitch=1e-3, depth=1e-3))
        with pytest.raises(InvalidValueError, match="HalfSpace"):
            finger.read(ss.PointLoad(1.0))

    def test_other_numbers(self):
        assert FLAT.with_(materials=[ss.Material(1e6)]) == ss.HalfSpace(ss.Material(1e6))
        assert (str(FLAT), FLAT.materials, FLAT.endless) == ("a half space (0.4 MPa, nu 0.4)", (RUBBER,), True)
        with pytest.raises(InvalidValueError, match="material"):
            ss.HalfSpace(0.4e6)
        with pytest.raises(GeometryError, match="points lie in the skin"):
            FLAT.stress(LOCAL["point"](), -1e-3, 0.0, 0.0)
        with pytest.raises(GeometryError, match="broadcast"):
            FLAT.stress(LOCAL["point"](), 1e-3, np.zeros(2), np.zeros(3))

    def test_sensors_feel_a_touch_on_an_area(self):
        finger = ss.Finger(FLAT, ss.SensorArray.line(5, pitch=1e-3, depth=2e-3))
        touch = ss.PointLoad(components=(1.0, 0.2, 0.1), position=(0.5e-3, 1e-3))
        expected = FLAT.strain(touch, 2e-3, finger.array.y, 0.0).xx
        np.testing.assert_allclose(finger.read(touch), expected, rtol=1e-14)

    def test_many_points_are_as_few(self):
        y = A * np.linspace(-3, 3, 1200)
        many = FLAT.state(LOCAL["slip"](), 0.5 * A, y, 0.2 * A)
        few = FLAT.state(LOCAL["slip"](), 0.5 * A, y[::400], 0.2 * A)
        np.testing.assert_array_equal(many.stress.yz[::400], few.stress.yz)
        np.testing.assert_array_equal(many.displacement.z[::400], few.displacement.z)


@each
def test_batches_broadcast_as_one_by_one(name):
    if name == "projections":
        batch = ss.FromProjections(ss.Strip(1.0, half_width=A), force=[1.0, 2.0], angle=0.2)
        singles = [ss.FromProjections(ss.Strip(1.0, half_width=A), force=p, angle=0.2) for p in (1.0, 2.0)]
    elif name == "grid":
        y, pressure = A * np.array([-1.0, 0.0, 1.0]), np.random.default_rng(0).uniform(0, 1, (2, 3, 3))
        batch, singles = ss.PressureGrid(y, y, pressure), [ss.PressureGrid(y, y, p) for p in pressure]
    else:
        one = LOCAL[name]()
        batch = (
            one
            if isinstance(one, ss.contact.LocalSum)
            else replace(one, components=np.outer([1.0, 2.0], one.components))
        )
        singles = [batch] if batch is one else [replace(one, components=k * one.components) for k in (1.0, 2.0)]
    x, y, z = A * np.array([0.7, 20.0, 0.9]), A * np.array([0.3, -1.0, 50.0]), 0.2 * A
    expected = np.array([tensor(FLAT.stress(c, x, y, z)) for c in singles])
    if batch.shape:
        seen = tensor(FLAT.stress(batch.expand(1), x, y, z))
        size = np.abs(expected).max(axis=1)
        assert (np.abs(np.swapaxes(seen, 0, 1) - expected).max(axis=1) <= 1e-13 * size).all()
        assert FLAT.displacement(batch.expand(2), x, y, np.zeros((4, 1))).x.shape == (2, 4, 3)
        assert batch.pressure(0.0, 0.0).shape == (2,)
        assert batch.shear(0.0, 0.0).shape == (2, 2)
        assert all(end.shape == (2, 2) for end in batch.support)
    assert FLAT.stress(batch.expand(1) if batch.shape else batch, np.zeros(0), 0.0, 0.0).xx.shape == (*batch.shape, 0)


@pytest.mark.parametrize(
    "skin", [FLAT, ss.Layered(ss.Layer(ss.Material(0.4e6), thickness=5 * A))], ids=["flat", "layer"]
)
@pytest.mark.parametrize("swapped", [False, True])
def test_a_batch_and_a_single_contact_add_up(skin, swapped):
    two = ss.RoundHertz([1.0, 2.0, 3.0], 0.2, half_width=A), ss.Patch(1.0, half_widths=(A, 2 * A))
    one, other = two[::-1] if swapped else two
    at = 0.7 * A, 0.3 * A, 0.2 * A
    for part in ("xx", "yy", "zz", "xy", "xz", "yz", "x", "y", "z"):
        field = skin.stress if len(part) == 2 else skin.displacement
        total, first, second = (getattr(field(c, *at), part) for c in (one + other, one, other))
        assert total.shape == (3,)
        assert np.abs(total).min() > 0
        np.testing.assert_allclose(total, first + second, rtol=1e-9, equal_nan=False)


def test_projections_answer_at_their_own_edge():
    disc = ss.FromProjections(ss.Hertz(1.0, half_width=A), 1.0, 0.3)
    edge, beside = (FLAT.displacement(disc, 0.0, k * A, 0.0) for k in (1.0, 1 - 1e-6))
    assert edge.x != 0 != edge.y
    np.testing.assert_allclose([edge.x, edge.y], [beside.x, beside.y], rtol=1e-4, equal_nan=False)
    assert FLAT.stress(disc, 0.0, A, 0.0).xx.shape == ()


@each
def test_contacts_travel_and_stay_as_they_are(name):
    contact = LOCAL[name]()
    for other in (copy.deepcopy(contact), pickle.loads(pickle.dumps(contact))):
        assert (other.components == contact.components).all()
        seen, expected = (FLAT.stress(c, A, 0.1 * A, 0.0).xx for c in (other, contact))
        assert seen == expected
    with pytest.raises(ValueError, match="read-only"):
        contact.components[0] = 2.0


def test_states_travel():
    state = FLAT.state(LOCAL["twisted"](), A, 0.3 * A, np.array([0.0, A]))
    other = pickle.loads(pickle.dumps(state))
    assert (other.stress.xz == state.stress.xz).all()
    assert (other.displacement.z == state.displacement.z).all()


def test_principal_values_of_six_components():
    """Beneath an oblique point force at nu = 1/2 the stress is radial: one principal value, -3 (F.r) / (2 pi R^3)."""
    load, x, y, z = np.array([1.0, 0.4, -0.3]), 1e-3, np.array([0.5e-3, -2e-3]), np.array([-1e-3, 0.3e-3])
    stress = ss.HalfSpace(ss.Material(1.0, 0.5)).stress(ss.PointLoad(components=load), x, y, z)
    away = np.stack([np.full(2, x), y, z])
    value = -3 * (load @ away) / (2 * np.pi * (away**2).sum(axis=0) ** 1.5)
    np.testing.assert_allclose(stress.principal[:, 2], value, rtol=1e-13)
    np.testing.assert_allclose(stress.principal[:, :2], 0.0, atol=1e-13 * np.abs(value).max())
    assert stress.matrix.shape == (2, 3, 3)
    assert not stress.is_plane


class TestSingularPoints:
    @pytest.mark.parametrize(
        ("contact", "y", "z"),
        [
            (ss.PointLoad(1.0, position=(1e-3, 2e-3)), 1e-3, 2e-3),
            (ss.RoundPunch(1.0, half_width=1e-3), 1e-3, 0.0),
            (ss.Cone(1.0, half_width=1e-3), 0.0, 0.0),
            (ss.RoundHertz(1.0, half_width=1e-3, moment=1e-3), 0.0, -1e-3),
            (ss.Patch(1.0, 0.3, half_widths=(1e-3, 2e-3)), 1e-3, 0.5e-3),
            (ss.Patch(1.0, 0.3, half_widths=(1e-3, 2e-3)), 1e-3, 2e-3),
            (ss.PressureGrid([0.0, 1e-3], [0.0, 1e-3], np.ones((2, 2))), 0.0, 0.5e-3),
        ],
        ids=lambda value: type(value).__name__,
    )
    def test_are_nan_with_a_warning(self, contact, y, z):
        with pytest.warns(SingularPointWarning, match="infinite") as caught:
            stress = FLAT.stress(contact, np.array([0.0, 1e-3]), y, z)
        assert caught[0].filename == __file__
        assert np.isnan(tensor(stress)[:, 0]).all()
        assert np.isfinite(tensor(stress)[:, 1]).all()

    @pytest.mark.parametrize(
        ("contact", "y", "z"),
        [
            (ss.RoundHertz(1.0, 0.4, half_width=1e-3), 1e-3, 0.0),
            (ss.RoundHertz(1.0, 0.4, half_width=1e-3, stick=0.5e-3), 0.5e-3, 0.0),
            (ss.RoundPunch(1.0, 0.4, half_width=1e-3), 0.0, 0.0),
            (ss.EllipticHertz(1.0, 0.4, half_widths=(1e-3, 2e-3)), 0.0, 2e-3),
            (ss.Patch(1.0, 0.4, half_widths=(1e-3, 2e-3)), 1e-3, 3e-3),
            (LOCAL["grid"](), -0.2 * A, 0.1 * A),
        ],
        ids=lambda value: type(value).__name__,
    )
    def test_elsewhere_on_the_surface_all_is_finite(self, contact, y, z):
        state = FLAT.state(contact, 0.0, y, z)
        assert np.isfinite(tensor(state.stress)).all()
        close_by = FLAT.displacement(contact, 1e-9, y, z)
        np.testing.assert_allclose(
            [getattr(state.displacement, c) for c in "xyz"], [getattr(close_by, c) for c in "xyz"], rtol=1e-3, atol=1e-9
        )

    def test_a_patch_moves_its_edge(self):
        """The displacement is finite on an edge, where the stress is not."""
        patch = ss.Patch(1.0, 0.4, half_widths=(1e-3, 2e-3))
        edge, beside = (FLAT.displacement(patch, x, 1e-3, 2e-3) for x in (1e-12, 1e-9))
        np.testing.assert_allclose(edge.x, beside.x, rtol=1e-4)
        with pytest.warns(SingularPointWarning):
            on = FLAT.displacement(patch, 0.0, 1e-3, 2e-3)
        np.testing.assert_allclose([on.x, on.y, on.z], [edge.x, edge.y, edge.z], rtol=1e-6)


class TestOnesOwn:
    def test_a_round_contact_of_two_formulas(self):
        """(1 - r^2)^(3/2) without a closed form: the sum of Hertz's, 5/3 of one less 2/3 of what is left."""

        class Soft(RoundContact):
            def disc_pressure(self, r):
                return 2.5 / np.pi * np.maximum(1 - r * r, 0.0) ** 1.5

            def disc_spectrum(self, k):
                return np.full(np.shape(k), np.nan)  # a half space asks for none

        touch = Soft(components=(1.0, 0.2, 0.1), half_width=A)
        s, w = np.polynomial.legendre.leggauss(20)
        s, w = 0.5 * (1 + s), 0.5 * w  # f = integral of 5 s^4 times Hertz's of radius s
        x, y, z = 0.8 * A, 0.4 * A, 0.3 * A
        summed = sum(
            5 * a**4 * b * tensor(FLAT.stress(ss.RoundHertz(components=touch.components, half_width=a * A), x, y, z))
            for a, b in zip(s, w, strict=True)
        )
        np.testing.assert_allclose(
            tensor(FLAT.stress(touch, x, y, z)), summed, rtol=1e-9, atol=1e-9 * np.abs(summed).max()
        )

    def test_projections_that_change_with_the_direction(self):
        """An ellipse under uniform pressure: its projections are semi-ellipses; against a fine sum of points."""
        a, b = A, 0.5 * A

        def profile(phi):
            return ss.Hertz(np.ones(np.shape(phi)), half_width=np.hypot(a * np.cos(phi), b * np.sin(phi)))

        touch = ss.FromProjections(profile, components=(1.0, 0.3, -0.2))
        assert touch.pressure(0.5 * A, 0.2 * A) == pytest.approx(1 / (np.pi * a * b), rel=1e-10)
        assert touch.radial_terms is None
        s, w = np.polynomial.legendre.leggauss(40)
        rho, turn = np.sqrt(0.5 * (1 + s)), 2 * np.pi * np.arange(80) / 80
        at = np.stack([a * rho[:, None] * np.cos(turn), b * rho[:, None] * np.sin(turn)], axis=-1)
        load = np.multiply.outer(np.outer(0.5 * w, np.full(80, 1 / 80)), [1.0, 0.3, -0.2])
        points = ss.PointLoad(components=load, position=at)
        x, y, z = np.array([0.9, 0.5]) * A, np.array([0.2, -1.3]) * A, np.array([-0.4, 0.6]) * A
        expected = np.array([tensor(FLAT.stress(points, *p)).sum(axis=(1, 2)) for p in zip(x, y, z, strict=True)]).T
        np.testing.assert_allclose(
            tensor(FLAT.stress(touch, x, y, z)), expected, rtol=1e-8, atol=1e-9 * np.abs(expected).max()
        )

    def test_what_its_class_does_not_say_is_said(self):
        class Own(LocalContact):
            components, position, moment = np.ones((2, 3)), np.zeros((2, 2)), np.zeros(2)
            support = (np.zeros((2, 2)), np.ones((2, 2)))

            def pressure(self, y, z):
                return 0.0

            shear = pressure

        with pytest.raises(InvalidValueError, match="expand"):
            Own().expand()
        with pytest.raises(InvalidValueError, match="define `spectrum"):
            Own().spectrum(np.zeros(1), np.zeros(1))
        with pytest.raises(TypeError):
            Own() + 3
