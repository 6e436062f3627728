"""The shapes of the catalogue: their heights, their ends, and what they refuse."""

from __future__ import annotations

import numpy as np
import pytest

import subskin as ss

MM = 1e-3


class TestHeights:
    Y = np.array([-2.0, -0.5, 0.0, 0.3, 1.0, 1.7]) * MM

    @pytest.mark.parametrize(
        ("body", "wanted"),
        [
            (ss.pressing.Cylinder(4 * MM), lambda y: y**2 / (8 * MM)),
            (ss.pressing.Flat(), lambda y: 0 * y),
            (ss.pressing.Edge(), lambda y: np.where(y > 0, np.inf, 0.0)),
            (ss.pressing.Edge(2 * MM), lambda y: np.where(y > 0, y**2 / (4 * MM), 0.0)),
            (ss.pressing.RoundedFlat(MM), lambda y: np.where(np.abs(y) > MM, np.inf, 0.0)),
            (ss.pressing.RoundedFlat(0.4 * MM, MM), lambda y: np.maximum(np.abs(y) - 0.4 * MM, 0) ** 2 / (2 * MM)),
            (ss.pressing.RoundedWedge(0.2), lambda y: 0.2 * np.abs(y)),
            (
                ss.pressing.RoundedWedge(0.2, 2.5 * MM),
                lambda y: np.where(np.abs(y) < 0.5 * MM, y**2 / (5 * MM), 0.2 * np.abs(y) - 0.05 * MM),
            ),
            (
                ss.pressing.SineRidges(0.7 * MM, 0.01 * MM),
                lambda y: 0.01 * MM * (1 - np.cos(2 * np.pi * y / (0.7 * MM))),
            ),
            (
                ss.pressing.SineRidges(0.7 * MM, 0.01 * MM, 9 * MM),
                lambda y: 0.01 * MM * (1 - np.cos(2 * np.pi * y / (0.7 * MM))) + y**2 / (18 * MM),
            ),
            (
                ss.pressing.ParticleOnFlat(0.4 * MM, 0.02 * MM),
                lambda y: 0.02 * MM * np.minimum((y / (0.4 * MM)) ** 2, 1),
            ),
            (
                ss.pressing.ParticleOnFlat(0.4 * MM, 0.02 * MM, 1.5 * MM),
                lambda y: np.where(np.abs(y) > 1.5 * MM, np.inf, 0.02 * MM * np.minimum((y / (0.4 * MM)) ** 2, 1)),
            ),
        ],
        ids=lambda value: type(value).__name__ if isinstance(value, ss.pressing.Indenter) else "",
    )
    def test_formula(self, body, wanted):
        assert isinstance(body, ss.pressing.Indenter)
        np.testing.assert_allclose(body.height(self.Y), wanted(self.Y), rtol=1e-12, atol=1e-18)
        assert body.height(0) == 0.0
        assert body.height(self.Y.reshape(2, 3)).shape == (2, 3)
        low, high = body.ends
        finite = np.isfinite(body.height(self.Y))
        assert (finite == ((self.Y >= low) & (self.Y <= high))).all()

    def test_a_tip_joins_its_sides(self):
        body, join = ss.pressing.RoundedWedge(0.2, 2.5 * MM), 0.5 * MM
        below, at, above = body.height(join + np.array([-1e-9, 0, 1e-9]))
        assert at - below == pytest.approx(0.2e-9, rel=1e-4)
        assert above - at == pytest.approx(0.2e-9, rel=1e-4)

    def test_ints_are_floats(self):
        assert ss.pressing.Cylinder(2) == ss.pressing.Cylinder(2.0)
        assert isinstance(ss.pressing.Cylinder(2).radius, float)


class TestProfile:
    def test_straight_lines_from_the_lowest_point(self):
        body = ss.pressing.Profile([-1, 0, 2], [5, 3, 7])
        np.testing.assert_allclose(body.height([-1, -0.5, 0, 1, 2, 2.001, -1.001]), [2, 1, 0, 2, 4, np.inf, np.inf])
        assert body.ends == (-1.0, 2.0)

    def test_input_is_copied_and_kept(self):
        y, height = np.array([-1.0, 0.0, 1.0]), np.array([2.0, 1.0, 2.0])
        body = ss.pressing.Profile(y, height)
        y[:], height[:] = 0.0, 9.0
        np.testing.assert_array_equal(body.y, [-1, 0, 1])
        np.testing.assert_array_equal(body.height_at, [1, 0, 1])
        with pytest.raises(ValueError, match="read-only"):
            body.y[0] = 3.0
        with pytest.raises(ValueError, match="read-only"):
            body.height_at[0] = 3.0

    def test_a_function_is_taken_at_its_word(self):
        body = ss.pressing.Profile.from_function(lambda y: 1 + 1e3 * y**4, -MM, MM, points=5)
        np.testing.assert_allclose(body.height([0.13 * MM, MM]), 1e3 * np.array([0.13 * MM, MM]) ** 4, rtol=1e-3)
        assert body.height(1.1 * MM) == np.inf

    @pytest.mark.parametrize(
        ("y", "height", "error", "words"),
        [
            ([0, 1, 2], [0, np.nan, 1], ss.errors.InvalidValueError, [r"height_at\[1\] = nan", "finite", "np.interp"]),
            ([0, np.inf], [0, 1], ss.errors.InvalidValueError, [r"y\[1\] = inf", "finite", "np.interp"]),
            ([0], [0], ss.errors.GeometryError, [r"shape \(1,\)", "two points or more"]),
            ([0, 1], [0, 1, 2], ss.errors.GeometryError, [r"shape \(2,\)", r"shape \(3,\)"]),
            ([[0, 1]], [[0, 1]], ss.errors.GeometryError, [r"shape \(1, 2\)"]),
            ([0, 2, 1], [0, 1, 0], ss.errors.GeometryError, [r"y\[1\] = 2, y\[2\] = 1", "ascend", "sort"]),
            ([0, 1, 1], [0, 1, 0], ss.errors.GeometryError, [r"y\[1\] = 1, y\[2\] = 1", "keep one of each"]),
            ("ab", [0, 1], ss.errors.InvalidValueError, ["y = 'ab'", "real number"]),
        ],
    )
    def test_what_is_refused(self, y, height, error, words):
        with pytest.raises(error) as caught:
            ss.pressing.Profile(y, height)
        for word in words:
            assert caught.match(word)

    @pytest.mark.parametrize(
        ("args", "error", "words"),
        [
            ((3, 0, 1), ss.errors.InvalidValueError, "function = 3.*function of the positions"),
            ((lambda y: y[:2], 0, 1), ss.errors.GeometryError, r"shape \(2,\).*shape \(4097,\)"),
            (
                (lambda y: np.where(y > 0, y, np.nan), 0, 1),
                ss.errors.InvalidValueError,
                r"height\[0\] = nan.*end the profile",
            ),
            ((np.square, 1, 0), ss.errors.GeometryError, "ascend"),
            ((np.square, 0, 1, 1), ss.errors.InvalidValueError, "points = 1"),
            ((np.square, 0, np.nan), ss.errors.InvalidValueError, "high = nan"),
        ],
    )
    def test_functions_that_are_refused(self, args, error, words):
        with pytest.raises(error, match=words):
            ss.pressing.Profile.from_function(*args)


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: ss.pressing.Cylinder(0), r"radius = 0: has to be > 0 \[m\]"),
        (lambda: ss.pressing.Cylinder(-4e-3), "radius = -0.004"),
        (lambda: ss.pressing.Cylinder(np.inf), "radius = inf: has to be finite"),
        (lambda: ss.pressing.Cylinder("4 mm"), "radius = '4 mm'.*number"),
        (lambda: ss.pressing.Cylinder([1, 2]), r"radius of shape \(2,\): a single number"),
        (lambda: ss.pressing.Edge(-1), r"edge_radius = -1: has to be >= 0 \[m\]"),
        (lambda: ss.pressing.RoundedFlat(0), "half_width = 0: has to be > 0"),
        (lambda: ss.pressing.RoundedFlat(1, -1), "edge_radius = -1"),
        (lambda: ss.pressing.RoundedWedge(0), "slope = 0: has to be > 0"),
        (lambda: ss.pressing.RoundedWedge(0.1, -1), "tip_radius = -1"),
        (lambda: ss.pressing.SineRidges(0, 1), "pitch = 0"),
        (lambda: ss.pressing.SineRidges(1, -1), "amplitude = -1"),
        (lambda: ss.pressing.SineRidges(1, 1, 0), "radius = 0"),
        (lambda: ss.pressing.SineRidges(1, 1, np.nan), "radius = nan"),
        (lambda: ss.pressing.ParticleOnFlat(0, 1), "half_width = 0"),
        (lambda: ss.pressing.ParticleOnFlat(1, 0), "protrusion = 0"),
        (lambda: ss.pressing.ParticleOnFlat(1, 1, -1), "flat_half_width = -1"),
        (lambda: ss.pressing.Cylinder(1).height([0, np.nan]), r"y\[1\] = nan"),
    ],
)
def test_numbers_that_are_refused(make, words):
    with pytest.raises(ss.errors.InvalidValueError, match=words):
        make()


def test_a_flat_as_narrow_as_its_particle():
    with pytest.raises(ss.errors.GeometryError, match=r"half_width = 0.001 m, flat_half_width = 0.001 m.*wider"):
        ss.pressing.ParticleOnFlat(1e-3, 1e-5, 1e-3)
