"""Contacts at their door: shapes, ints, read-only results, batches, sums, and what they refuse or warn of."""

from __future__ import annotations

import pickle
import warnings

import numpy as np
import pytest

import subskin as ss

RUBBER = ss.Material(0.4e6, 0.5)
SKIN = ss.HalfPlane(RUBBER)
A = 1e-3
BUILD = {
    "line": lambda force=40.0, angle=0.3, position=0.0: ss.LineLoad(force, angle, position),
    "strip": lambda force=40.0, angle=0.3, position=0.0: ss.Strip(force, angle, position, half_width=A),
    "punch": lambda force=40.0, angle=0.3, position=0.0: ss.FlatPunch(force, angle, position, half_width=A),
    "tilted": lambda force=40.0, angle=0.3, position=0.0: ss.FlatPunch(
        force, angle, position, half_width=A, moment=0.3 * A * np.asarray(force)
    ),
    "wedge": lambda force=40.0, angle=0.3, position=0.0: ss.Wedge(force, angle, position, half_width=A),
    "hertz": lambda force=40.0, angle=0.3, position=0.0: ss.Hertz(force, angle, position, half_width=A),
    "slip": lambda force=40.0, angle=0.3, position=0.0: ss.PartialSlip(
        force, angle, position, half_width=A, friction=0.6
    ),
}
SLIPS = {"half_width": A, "friction": 0.6}
WIDE = {name: build for name, build in BUILD.items() if name != "line"}
X, Y = np.array([0.5e-3, 1e-3, 4e-3, 90e-3]), np.array([0.0, -1.3e-3, 2e-3, 10e-3])


def profile():
    return ss.PressureProfile([-A, 0.0, A], [0.0, 4e4, 0.0], [0.0, 1e4, 0.0])


@pytest.fixture(params=BUILD.values(), ids=BUILD)
def build(request):
    return request.param


@pytest.fixture(params=WIDE.values(), ids=WIDE)
def wide(request):
    return request.param


def components(stress):
    return np.array([stress.xx, stress.yy, stress.zz, stress.xy])


class TestShapes:
    @pytest.mark.parametrize("shape", [(), (5,), (4, 1), (3, 2), (2, 0)])
    def test_points_of_any_shape(self, build, shape):
        rng = np.random.default_rng(2)
        x, y = rng.uniform(1e-4, 5e-3, shape), rng.uniform(-5e-3, 5e-3, shape)
        state = SKIN.state(build(), x, y)
        for part in (state.stress, state.strain):
            assert part.shape == shape
        for index in np.ndindex(shape):
            one = SKIN.stress(build(), x[index], y[index])
            np.testing.assert_allclose(components(one), components(state.stress)[(slice(None), *index)], rtol=1e-13)

    @pytest.mark.parametrize("parameter", ["force", "angle", "position"])
    @pytest.mark.parametrize("batch", [(4,), (3, 1), (2, 3, 1)])
    def test_a_batch_broadcasts_against_the_points(self, build, parameter, batch):
        rng = np.random.default_rng(3)
        lo, hi = {"force": (1.0, 50.0), "angle": (-0.5, 0.5), "position": (-2e-3, 2e-3)}[parameter]
        values = rng.uniform(lo, hi, batch)
        many = build(**{parameter: values})
        assert many.shape == batch
        stress = SKIN.stress(many, X, Y)
        assert stress.shape == np.broadcast_shapes(batch, X.shape)
        full = np.broadcast_to(values, stress.shape)
        for index in np.ndindex(stress.shape):
            one = SKIN.stress(build(**{parameter: full[index]}), X[index[-1]], Y[index[-1]])
            np.testing.assert_allclose(
                components(one), components(stress)[(slice(None), *index)], rtol=1e-12, atol=1e-13
            )

    def test_batch_of_widths(self):
        widths = np.array([[0.5e-3], [1e-3]])
        for kind in (ss.Strip, ss.FlatPunch, ss.Wedge, ss.Hertz):
            many = SKIN.stress(kind(40.0, 0.3, half_width=widths), X, Y)
            for k in range(2):
                one = SKIN.stress(kind(40.0, 0.3, half_width=widths[k, 0]), X, Y)
                np.testing.assert_allclose(components(many)[:, k], components(one), rtol=1e-13)

    def test_many_points_go_in_blocks(self, build):
        x, y = np.linspace(1e-4, 5e-3, 120)[:, None], np.linspace(-5e-3, 5e-3, 90)
        field = components(SKIN.stress(build(), x, y))
        assert field.shape == (4, 120, 90)
        for i, j in ((0, 0), (57, 44), (119, 89)):
            one = components(SKIN.stress(build(), x[i, 0], y[j]))
            np.testing.assert_allclose(field[:, i, j], one, rtol=1e-13, atol=1e-13)

    def test_expand_appends_axes(self, build):
        many = build(position=[0.0, 1e-3, 2e-3]).expand(2)
        assert many.shape == (3, 1, 1)
        assert SKIN.stress(many, X, Y).shape == (3, 1, 4)
        assert profile().expand(2).shape == (1, 1)

    def test_profiles_of_a_batch(self):
        pressure = np.array([[0.0, 4e4, 0.0], [1e4, 0.0, 3e4]])
        many = ss.PressureProfile([-A, 0.2 * A, A], pressure, -pressure)
        assert many.shape == (2,)
        stress = components(SKIN.stress(many.expand(1), X, Y))
        for k in range(2):
            one = ss.PressureProfile([-A, 0.2 * A, A], pressure[k], -pressure[k])
            np.testing.assert_allclose(stress[:, k], components(SKIN.stress(one, X, Y)), rtol=1e-13, atol=1e-13)
            np.testing.assert_allclose(many.pressure(0.4 * A)[k], one.pressure(0.4 * A))

    def test_a_profile_of_very_many_nodes(self):
        """Its stretches are then taken a few at a time."""
        nodes = A * np.linspace(-1, 1, 3001)
        fine = ss.PressureProfile(nodes, 4e4 * (1 - np.abs(nodes / A)), np.zeros_like(nodes))
        coarse = ss.PressureProfile([-A, 0.0, A], [0.0, 4e4, 0.0])
        x, y = np.linspace(1e-4, 3e-3, 40), np.linspace(-2e-3, 2e-3, 40)
        np.testing.assert_allclose(
            components(SKIN.stress(fine, x, y)), components(SKIN.stress(coarse, x, y)), rtol=0, atol=1e-12 * 4e4
        )

    def test_shapes_that_do_not_fit_are_told(self):
        with pytest.raises(ss.errors.GeometryError, match=r"force \(2,\), angle \(3,\)"):
            ss.LineLoad([1.0, 2.0], [0.1, 0.2, 0.3])
        with pytest.raises(ss.errors.GeometryError, match="broadcast"):
            SKIN.stress(ss.LineLoad([1.0, 2.0]), X[:3], Y[:3])
        with pytest.raises(ss.errors.GeometryError, match="broadcast"):
            SKIN.stress(ss.LineLoad(1.0), X[:3], Y[:2])


class TestTypes:
    def test_order_of_the_arguments(self):
        """A contract (DESIGN.md): force, angle, position, half width, then what is the contact's own."""
        hertz, punch = ss.Hertz(4.0, 0.1, 0.2, 0.3), ss.FlatPunch(4.0, 0.1, 0.2, 0.3, 0.5)
        assert (hertz.force, hertz.angle, hertz.position, hertz.half_width) == (4.0, 0.1, 0.2, 0.3)
        assert (punch.half_width, punch.moment) == (0.3, 0.5)
        assert ss.PartialSlip(4.0, 0.1, 0.2, 0.3, 0.6).friction == 0.6

    def test_ints_mean_floats(self):
        as_int = ss.Strip(force=4, angle=0, position=1, half_width=2)
        as_float = ss.Strip(force=4.0, angle=0.0, position=1.0, half_width=2.0)
        for x, y in ((3, 5), (np.array([3, 4]), np.array([5, 6]))):
            np.testing.assert_array_equal(
                components(SKIN.stress(as_int, x, y)), components(SKIN.stress(as_float, np.float64(x), np.float64(y)))
            )
        assert as_int.pressure(1).dtype == np.float64
        assert ss.PressureProfile([0, 2], [1, 1]).pressure([1, 3]).tolist() == [1.0, 0.0]

    def test_results_are_read_only_and_inputs_unchanged(self, build):
        x, y = X.copy(), Y.copy()
        force = np.array([30.0, 40.0])
        contact = build(force=force)
        results = [contact.pressure(y[:2]), contact.shear(y[:2]), contact.normal_force, contact.tangential_force]
        state = SKIN.state(contact.expand(1), x, y)
        results += [getattr(part, c) for part in (state.stress, state.strain) for c in ("xx", "yy", "zz", "xy")]
        results += [value for value in vars(contact).values() if isinstance(value, np.ndarray)]
        for result in results:
            with pytest.raises(ValueError, match="read-only"):
                result[...] = 0.0
        np.testing.assert_array_equal(x, X)
        np.testing.assert_array_equal(y, Y)
        force[:] = 7.0  # the contact keeps its own copy
        assert contact.force.tolist() == [30.0, 40.0]

    def test_frozen(self, build):
        with pytest.raises(AttributeError):
            build().force = 3.0

    def test_survives_pickling(self, build):
        for contact in (build(), profile(), build() + profile()):
            copy = pickle.loads(pickle.dumps(contact))
            np.testing.assert_array_equal(components(SKIN.stress(copy, X, Y)), components(SKIN.stress(contact, X, Y)))


class TestRefusals:
    @pytest.mark.parametrize("bad", [np.nan, np.inf, "two", None, [1.0, np.nan], 1j])
    @pytest.mark.parametrize("parameter", ["force", "angle", "position"])
    def test_what_is_not_a_finite_number(self, parameter, bad):
        with pytest.raises(ss.errors.InvalidValueError, match=parameter):
            ss.Hertz(**{"force": 1.0, parameter: bad}, half_width=A)

    def test_the_message_tells_position_rule_and_fix(self):
        with pytest.raises(ss.errors.InvalidValueError, match=r"force\[1\] = nan: has to be finite \[N/m\]. Fix: "):
            ss.LineLoad([1.0, np.nan])
        with pytest.raises(
            ss.errors.InvalidValueError, match=r"angle = 30: has to be <= 3.14159 \[rad\]. Fix: .*deg2rad"
        ):
            ss.LineLoad(1.0, 30.0)

    @pytest.mark.parametrize("kind", [ss.Strip, ss.FlatPunch, ss.Wedge, ss.Hertz])
    @pytest.mark.parametrize("width", [0.0, -1e-3, np.nan, [1e-3, 0.0]])
    def test_half_width(self, kind, width):
        with pytest.raises(ss.errors.InvalidValueError, match="half_width"):
            kind(force=1.0, half_width=width)

    @pytest.mark.parametrize("kind", [ss.Strip, ss.FlatPunch, ss.Wedge, ss.Hertz, ss.PartialSlip])
    def test_half_width_is_required(self, kind):
        with pytest.raises(ss.errors.InvalidValueError, match="half of the contact's width"):
            kind(1.0, 0.0, 0.0, **({"friction": 0.5} if kind is ss.PartialSlip else {}))

    def test_negative_force(self, build):
        with pytest.raises(ss.errors.InvalidValueError, match="turn the angle instead"):
            build(force=-1.0)

    @pytest.mark.parametrize(("x", "y"), [(np.nan, 0.0), (0.1, np.inf), (0.1, "here")])
    def test_points(self, x, y):
        with pytest.raises(ss.errors.InvalidValueError):
            SKIN.stress(ss.LineLoad(1.0), x, y)

    def test_points_above_the_surface(self):
        with pytest.raises(ss.errors.GeometryError, match="x >= 0 is the depth"):
            SKIN.strain(ss.LineLoad(1.0), [1e-3, -1e-3], 0.0)

    @pytest.mark.parametrize("y", [np.nan, [0.0, np.nan]])
    def test_pressure_of_nowhere(self, build, y):
        for method in (build().pressure, build().shear, profile().pressure):
            with pytest.raises(ss.errors.InvalidValueError, match="y"):
                method(y)

    @pytest.mark.parametrize(
        ("y", "pressure", "message"),
        [
            ([0.0], [1.0], "at least two nodes"),
            (0.0, 1.0, "at least two nodes"),
            ([0.0, 1.0], [1.0, 2.0, 3.0], "broadcast"),
            ([0.0, 0.0], [1.0, 1.0], "ascend"),
            ([1.0, 0.0], [1.0, 1.0], "ascend"),
        ],
    )
    def test_profile(self, y, pressure, message):
        with pytest.raises(ss.errors.GeometryError, match=message):
            ss.PressureProfile(y, pressure)

    def test_profile_of_nan(self):
        with pytest.raises(ss.errors.InvalidValueError, match=r"pressure\[1\] = nan"):
            ss.PressureProfile([0.0, 1.0], [1.0, np.nan])
        with pytest.raises(ss.errors.InvalidValueError, match="shear"):
            ss.PressureProfile([0.0, 1.0], [1.0, 1.0], [np.inf, 0.0])

    @pytest.mark.parametrize("angle", [0.7, -0.7, 2.0])
    def test_partial_slip_that_slides_or_pulls(self, angle):
        with pytest.raises(ss.errors.InvalidValueError, match=r"\|T\| <= mu N, else the contact slides"):
            ss.PartialSlip(40.0, angle, half_width=A, friction=0.6)

    @pytest.mark.parametrize("friction", [0.0, -0.3, np.nan, [0.5, -1.0]])
    def test_friction(self, friction):
        with pytest.raises(ss.errors.InvalidValueError, match="friction"):
            ss.PartialSlip(40.0, 0.0, half_width=A, friction=friction)

    def test_one_of_a_batch_that_slides_is_named(self):
        with pytest.raises(ss.errors.InvalidValueError, match=r"\|T\| = 26.97.*, mu N = 17.7"):
            ss.PartialSlip(40.0, [0.0, 0.74], half_width=A, friction=0.6)


class TestForces:
    def test_components(self, build):
        contact = build(force=[10.0, 20.0], angle=[0.2, -0.4])
        np.testing.assert_allclose(contact.normal_force, [10 * np.cos(0.2), 20 * np.cos(0.4)])
        np.testing.assert_allclose(contact.tangential_force, [10 * np.sin(0.2), -20 * np.sin(0.4)])

    def test_given_components_are_kept_exactly(self):
        """np.cos(np.pi / 2) is 6e-17: beneath a pure drag that would be all the stress there is."""
        for kind, more in ((ss.LineLoad, {}), (ss.Hertz, {"half_width": A}), (ss.PartialSlip, SLIPS)):
            loads = kind.of_components([[0.3, 0.0], [0.0, 0.0], [3.7, 1.1]], [0.0, 1e-3, 2e-3], **more)
            for contact in (loads, loads.expand(2), pickle.loads(pickle.dumps(loads))):
                np.testing.assert_array_equal(contact.normal_force.ravel(), [0.3, 0.0, 3.7])
                np.testing.assert_array_equal(contact.tangential_force.ravel(), [0.0, 0.0, 1.1])
            np.testing.assert_allclose(loads.force, [0.3, 0.0, np.hypot(3.7, 1.1)])
            np.testing.assert_allclose(loads.angle, [0.0, 0.0, np.arctan2(1.1, 3.7)])
        pull, drag = ss.LineLoad.of_components([-40.0, 0.0]), ss.LineLoad.of_components([0.0, 40.0])
        assert (float(pull.normal_force), float(pull.angle)) == (-40.0, np.pi)
        assert not components(SKIN.stress(drag, 1e-3, 0.0)).any()
        both = (drag + ss.Hertz.of_components([[5.0, 1.0], [6.0, -2.0]], half_width=A)).components
        np.testing.assert_array_equal(both, [[5.0, 41.0], [6.0, 38.0]])

    @pytest.mark.parametrize("bad", [40.0, [1.0, 2.0, 3.0], [1.0, np.nan], "both"])
    def test_components_that_are_not_two_numbers(self, bad):
        with pytest.raises((ss.errors.InvalidValueError, ss.errors.GeometryError), match="components"):
            ss.LineLoad.of_components(bad)

    def test_no_force_makes_nothing(self, build):
        nothing = build(force=0.0)
        y = [-A, -0.3e-3, 0.0, A, 2 * A]
        assert not nothing.pressure(y).any()
        assert not nothing.shear(y).any()
        assert not components(SKIN.stress(nothing, X, Y)).any()

    def test_drag_follows_the_angle(self, build):
        right, left = build(angle=0.3).shear(0.4e-3), build(angle=-0.3).shear(0.4e-3)
        assert right >= 0
        np.testing.assert_allclose(right, -left)


class TestSums:
    def test_plus_and_sum(self):
        contacts = [make() for make in BUILD.values()] + [profile()]
        total = sum(contacts)
        assert isinstance(total, ss.contact.ContactSum)
        assert len(total.parts) == len(contacts)
        assert len((total + total).parts) == 2 * len(contacts)
        np.testing.assert_allclose(total.normal_force, sum(c.normal_force for c in contacts))
        np.testing.assert_allclose(total.tangential_force, sum(c.tangential_force for c in contacts))
        y = [0.31e-3, 5e-3]
        np.testing.assert_allclose(total.pressure(y), sum(c.pressure(y) for c in contacts))
        np.testing.assert_allclose(total.shear(y), sum(c.shear(y) for c in contacts))
        np.testing.assert_allclose(
            components(SKIN.stress(total, X, Y)), sum(components(SKIN.stress(c, X, Y)) for c in contacts), rtol=1e-12
        )

    def test_batches_of_both_kinds_broadcast(self):
        both = ss.Hertz([[1.0], [2.0]], half_width=A) + ss.LineLoad([1.0, 2.0, 3.0])
        assert both.shape == (2, 3)
        assert SKIN.stress(both.expand(1), X, Y).shape == (2, 3, 4)

    @pytest.mark.parametrize("points", [(7,), (90, 80)])
    def test_many_line_loads(self, points):
        """On many points compiled code adds them up."""
        rng = np.random.default_rng(3)
        rows = rng.uniform([1.0, -3.0, -2.0], [9.0, 3.0, 2.0], (20, 3))
        loads = [ss.LineLoad(*row) for row in rows]
        x, y = rng.uniform(0.01, 3.0, points), rng.uniform(-3.0, 3.0, points)
        seen, alone = (components(SKIN.stress(c, x, y)) for c in (sum(loads), loads[0]))
        expected = alone + sum(components(SKIN.stress(load, x, y)) for load in loads[1:])
        np.testing.assert_allclose(seen, expected, rtol=0, atol=1e-13 * np.abs(expected).max())

    def test_many_line_loads_on_the_surface(self):
        loads = [ss.LineLoad(1.0, 0.3, position) for position in range(10)]
        y = np.linspace(0.5, 9.5, 4999) + 1e-4
        y[7] = 3.0
        with pytest.warns(ss.errors.SingularPointWarning):
            s = SKIN.stress(sum(loads), 0.0, y)
        assert np.flatnonzero(~np.isfinite(s.yy)).tolist() == [7]

    @pytest.mark.parametrize("other", [1, "a", None])
    def test_with_what_is_no_contact(self, build, other):
        with pytest.raises(TypeError):
            build() + other
        with pytest.raises(TypeError):
            other + build()


class TestSingularPoints:
    @pytest.mark.parametrize(
        ("contact", "at"),
        [
            (ss.LineLoad(1.0, 0.2, 3.0), [3.0]),
            (ss.Strip(1.0, 0.2, 3.0, half_width=1.0), [2.0, 4.0]),
            (ss.FlatPunch(1.0, 0.2, 3.0, half_width=1.0), [2.0, 4.0]),
            (ss.Wedge(1.0, 0.2, 3.0, half_width=1.0), [3.0]),
            (ss.PressureProfile([0.0, 1.0], [0.0, 1.0]), [1.0]),
            (ss.PressureProfile([0.0, 1.0], [0.0, 0.0], [2.0, 0.0]), [0.0]),
        ],
        ids=lambda v: type(v).__name__ if isinstance(v, ss.Contact) else "",
    )
    def test_are_blanked_and_told(self, contact, at):
        for y in at:
            with pytest.warns(ss.errors.SingularPointWarning, match=f"infinite on the surface at y = {y:g} m"):
                s = SKIN.stress(contact, [0.0, 0.0], [y, 7.0])
            assert np.isnan([s.xx[0], s.yy[0], s.xy[0]]).all()
            assert np.isfinite(components(s)[:, 1]).all()
            with pytest.warns(ss.errors.SingularPointWarning):
                assert np.isnan(SKIN.surface_gradient(contact, y).ux)
            near = components(SKIN.stress(contact, 1e-12, y))
            assert np.isfinite(near).all()

    @pytest.mark.parametrize(
        "contact",
        [
            ss.Hertz(1.0, 0.2, half_width=1.0),
            ss.PartialSlip(1.0, 0.2, half_width=1.0, friction=0.6),
            ss.PartialSlip(1.0, 0.0, half_width=1.0, friction=0.6),
            ss.PartialSlip(1.0, np.arctan(0.6), half_width=1.0, friction=0.6),
            ss.PressureProfile([-1.0, 0.0, 0.5, 1.0], [0.0, 2.0, 0.5, 0.0], [0.0, 1.0, -1.0, 0.0]),
        ],
        ids=["hertz", "slip", "sticks", "about to slide", "profile"],
    )
    def test_none_where_the_traction_is_continuous(self, contact):
        """At edges, stick boundaries, middle and kinks the surface stress is the limit of the stress just beneath."""
        c = float(getattr(contact, "stick_half_width", 0.0))
        y = np.array([-1.0, 1.0, 0.0, 0.5, c, -c])
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            on, beneath = (components(SKIN.stress(contact, x, y)) for x in (0.0, 1e-12))
            gradient = SKIN.surface_gradient(contact, y)
        np.testing.assert_allclose(on[[0, 1, 3]], beneath[[0, 1, 3]], rtol=0, atol=5e-6)
        np.testing.assert_allclose(on[0], -contact.pressure(y), rtol=0, atol=1e-12)
        np.testing.assert_allclose(on[3], -contact.shear(y), rtol=0, atol=1e-12)
        assert np.isfinite(gradient.ux).all()
        assert np.isfinite(gradient.uy).all()

    def test_wedge_and_punch_edges_from_without(self):
        """A wedge's edges are no singular points; a punch's pressure is infinite at its own."""
        assert np.isfinite(components(SKIN.stress(ss.Wedge(1.0, 0.2, half_width=1.0), 0.0, [-1.0, 1.0]))).all()
        assert ss.FlatPunch(1.0, half_width=1.0).pressure([-1.0, 1.0, 1.1]).tolist() == [np.inf, np.inf, 0.0]
        assert ss.Wedge(1.0, half_width=1.0).pressure([0.0, 1.1]).tolist() == [np.inf, 0.0]

    def test_in_a_batch_only_the_touched_one(self):
        line = ss.LineLoad([1.0, 2.0], 0.0, [[0.0], [1.0]])
        for points in (0.0, np.zeros((1, 2)), [0.0, 0.5]):
            with pytest.warns(ss.errors.SingularPointWarning):
                s = SKIN.stress(line, 0.0, points)
            assert np.isnan(s.xx[0, 0])
            assert np.isfinite(s.xx[1]).all()

    def test_batch_of_one_position(self):
        with pytest.warns(ss.errors.SingularPointWarning):
            s = SKIN.stress(ss.LineLoad([[1.0], [2.0], [3.0]]), 0.0, [0.0, 1.0])
        assert np.isnan(s.xx).tolist() == [[True, False]] * 3

    def test_negative_zero_depth_is_the_surface(self):
        strip = ss.Strip(2.0, half_width=1.0)
        np.testing.assert_allclose(SKIN.stress(strip, -0.0, 0.3).xx, -1.0, rtol=1e-15)


class TestValidity:
    def test_hertz_from_radius(self):
        """a = 2 sqrt(N R (1 - nu^2) / (pi E)): half of what the memo's eq. (17) gives."""
        touch = ss.Hertz.from_radius(40.0, 8e-3, RUBBER, angle=0.3, position=1e-3)
        n = 40 * np.cos(0.3)
        np.testing.assert_allclose(touch.half_width, 2 * np.sqrt(n * 8e-3 * 0.75 / (np.pi * 0.4e6)), rtol=1e-15)
        np.testing.assert_allclose([touch.normal_force, touch.position], [n, 1e-3])
        slip = ss.PartialSlip.from_radius(40.0, 8e-3, RUBBER, angle=0.3, friction=0.6)
        assert isinstance(slip, ss.PartialSlip)
        assert slip.half_width == touch.half_width
        assert ss.Hertz.from_radius([10.0, 20.0], [[8e-3], [9e-3]], RUBBER).shape == (2, 2)

    def test_hertz_wider_than_its_theory(self):
        radius = 1e-3
        force = 0.3**2 * radius * np.pi * 0.4e6 / (4 * 0.75)
        ss.Hertz.from_radius(force * 0.999, radius, RUBBER)
        with pytest.warns(ss.errors.ValidityWarning, match=r"half width / radius = 0.3"):
            ss.Hertz.from_radius(force * 1.001, radius, RUBBER)

    def test_wedge_from_angle(self):
        """a = N tan(theta/2) (1 - nu^2) / E."""
        wedge = ss.Wedge.from_angle(40.0, 2.8, RUBBER, angle=-0.2, position=1e-3)
        np.testing.assert_allclose(wedge.half_width, 40 * np.cos(0.2) * np.tan(1.4) * 0.75 / 0.4e6, rtol=1e-14)
        np.testing.assert_allclose([wedge.angle, wedge.position], [-0.2, 1e-3])

    def test_wedge_too_sharp_for_linear_theory(self):
        edge = 2 * np.arctan(1 / 0.3)
        ss.Wedge.from_angle(40.0, edge + 1e-3, RUBBER)
        with pytest.warns(ss.errors.ValidityWarning, match=r"slope by cot\(theta/2\) = 0.30.* small\s+slopes"):
            ss.Wedge.from_angle(40.0, edge - 1e-3, RUBBER)

    @pytest.mark.parametrize("angle", [0.0, np.pi, -1.0, 160.0, [2.8, 0.0]])
    def test_wedge_that_is_none(self, angle):
        with pytest.raises(ss.errors.InvalidValueError, match=r"vertex_angle = .* \(0, pi\) .*deg2rad"):
            ss.Wedge.from_angle(40.0, angle, RUBBER)

    @pytest.mark.parametrize(("force", "angle"), [(0.0, 0.0), (40.0, np.pi / 2), (40.0, 2.0), ([40.0, 0.0], 0.0)])
    def test_load_that_does_not_press(self, force, angle):
        with pytest.raises(ss.errors.InvalidValueError, match="presses"):
            ss.Hertz.from_radius(force, 8e-3, RUBBER, angle)
        with pytest.raises(ss.errors.InvalidValueError, match="presses"):
            ss.Wedge.from_angle(force, 2.8, RUBBER, angle)

    @pytest.mark.parametrize("radius", [0.0, -1.0, np.nan])
    def test_radius(self, radius):
        with pytest.raises(ss.errors.InvalidValueError, match="radius"):
            ss.Hertz.from_radius(40.0, radius, RUBBER)

    def test_punch_that_lifts(self):
        most = 40.0 * A / 2
        assert (ss.FlatPunch(40.0, half_width=A, moment=most).pressure(A * np.linspace(-0.999, 0.999, 50)) >= 0).all()
        with pytest.warns(ss.errors.ValidityWarning, match="one edge of the punch pulls"):
            lifted = ss.FlatPunch(40.0, half_width=A, moment=[0.0, -1.01 * most])
        assert lifted.pressure(0.999 * A)[1] < 0
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            lifted.expand()  # said once, not at every use

    def test_moment_has_to_be_a_number(self):
        with pytest.raises(ss.errors.InvalidValueError, match="moment"):
            ss.FlatPunch(40.0, half_width=A, moment=np.nan)

    def test_plain_use_warns_of_nothing(self, wide):
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            SKIN.state(wide(), X, Y)
            SKIN.surface_gradient(wide(), [0.3e-3, 5e-3])
            wide().pressure([-2 * A, -A, 0.0, 0.3 * A, A])
