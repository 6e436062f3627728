"""What the solver on an area is built of: products on a quarter of a grid, starts from coarse grids, term by term."""

from __future__ import annotations

import numpy as np
import pytest

import subskin as ss
from subskin import pressing as on
from subskin.pressing.area import between
from subskin.pressing.influence import influence
from subskin.pressing.quarter import corner, quarter, unfolded, with_parity

RUBBER = ss.Material(0.4e6, 0.5)
HALF = ss.HalfSpace(RUBBER)
SKINS = [ss.HalfSpace(ss.Material(0.4e6, 0.3)), ss.Layered(ss.Layer(ss.Material(0.4e6, 0.45), 1e-3))]
PARITIES = [(False, False), (True, True), (False, True), (True, False)]
BALL, FORCE, RUB = on.Sphere(8e-3), 0.3, 0.5


def drag_of(parity, shape):
    """Random quarters of q_y and q_z."""
    return np.random.default_rng(3).standard_normal((2, *shape)), (not parity[0], not parity[1])


@pytest.mark.parametrize("skin", SKINS, ids=["half space", "layer"])
class TestQuarter:
    def test_pressure(self, skin):
        op = influence(skin, 1e-4, (24, 30), True)
        p = np.random.default_rng(0).random((12, 15))
        at = [(12, 15), (17, 29), (23, 18)]
        direct = [op.direct(unfolded(p), np.zeros((2, 24, 30)), node)[0] for node in at]
        moved = quarter(op).normal_wide(p)
        assert [moved[i - 12, j - 15] for i, j in at] == pytest.approx(direct, rel=1e-12)

    @pytest.mark.parametrize("parity", PARITIES)
    def test_drag(self, skin, parity):
        op = influence(skin, 1e-4, (24, 30), True)
        q, other = drag_of(parity, (12, 15))
        whole = np.stack([unfolded(q[0], parity), unfolded(q[1], other)])
        at = [(12, 15), (17, 29), (23, 18)]
        direct = np.array([op.direct(np.zeros((24, 30)), whole, node)[1:] for node in at])
        moved = quarter(op, parity).lateral_wide(q)
        scale = np.abs(direct).max()
        assert [moved[:, i - 12, j - 15] for i, j in at] == pytest.approx(direct, abs=1e-12 * scale)
        assert corner(op.lateral(whole)) == pytest.approx(moved, abs=1e-12 * scale)

    @pytest.mark.parametrize("parity", PARITIES)
    def test_preconditioners(self, skin, parity):
        """On a grid that repeats the whole and its quarter are the same circulant."""
        op = influence(skin, 1e-4, (24, 32), True)
        q, other = drag_of(parity, (12, 16))
        whole = np.stack([unfolded(q[0], parity), unfolded(q[1], other)]).astype(np.float32)
        nearly = corner(op.nearly_lateral_wide(whole))
        found = quarter(op, parity).nearly_lateral_wide(q.astype(np.float32))
        assert found == pytest.approx(nearly, abs=2e-6 * float(np.abs(nearly).max()))
        p = corner(unfolded(q[0]))
        nearly = corner(op.nearly_wide(unfolded(p).astype(np.float32)))
        scale = float(np.abs(nearly).max())
        assert quarter(op).nearly_wide(p.astype(np.float32)) == pytest.approx(nearly, abs=2e-6 * scale)


def test_parity_is_told_both_ways():
    q = np.random.default_rng(1).random((4, 6))
    for parity in PARITIES:
        whole = unfolded(q, parity)
        assert [with_parity(whole, other, 1e-12) for other in PARITIES] == [other == parity for other in PARITIES]
        assert (corner(whole) == q).all()


def test_finer_maps_continue_a_plane():
    y, z = np.arange(6.0), np.arange(8.0)
    fine = between(2 * y[:, None] - 3 * z)
    yy, zz = (np.arange(2 * n) / 2 - 0.25 for n in (6, 8))
    assert fine[1:-1, 1:-1] == pytest.approx((2 * yy[:, None] - 3 * zz)[1:-1, 1:-1])


class TestSolutions:
    def test_a_drag_askew_is_that_along_an_axis_turned(self):
        """One is solved on the whole grid and one on a quarter, and a sphere knows no direction."""
        along = ss.press(HALF, BALL, force=FORCE, friction=RUB, tangential=(0.075, 0.0), nodes=96)
        askew = ss.press(HALF, BALL, force=FORCE, friction=RUB, tangential=(0.06, 0.045), nodes=96)
        assert along.certificate.worst < 1e-8
        assert askew.certificate.worst < 1e-8
        assert askew.slide == pytest.approx(along.slide[0] * np.array([0.8, 0.6]), rel=2e-5)
        assert askew.stick.sum() == pytest.approx(along.stick.sum(), rel=5e-3)

    def test_a_moment_too_small_to_tell_changes_nothing(self):
        """Asked for a moment, the solver takes the whole grid; to its own limit the answer is that of a quarter."""
        quartered = ss.press(HALF, BALL, force=FORCE, nodes=96, tolerance=1e-10)
        whole = ss.press(HALF, BALL, force=FORCE, nodes=96, tolerance=1e-10, moment=(1e-18, 0.0))
        assert whole.depth == pytest.approx(quartered.depth, rel=1e-9)
        assert whole.pressure == pytest.approx(quartered.pressure, abs=1e-6 * quartered.pressure.max())

    def test_a_drag_along_z_is_that_along_y(self):
        y, z = (
            ss.press(HALF, on.Ellipsoid(8e-3, 4e-3, azimuth=turn), force=FORCE, friction=RUB, tangential=drag, nodes=64)
            for turn, drag in ((0.0, (0.07, 0.0)), (np.pi / 2, (0.0, 0.07)))
        )
        assert z.slide[1] == pytest.approx(y.slide[0], rel=1e-7)
        assert z.shear[..., 1].T == pytest.approx(y.shear[..., 0], abs=1e-5 * np.abs(y.shear).max())

    @pytest.mark.parametrize("load", [{"tangential": (0.06, 0.045)}, {"torsion": 2.5e-5}, {"tangential": (0.13, 0.0)}])
    def test_nodes_that_slip_far_do_not_cost_products(self, load):
        """Each takes 14 to 20 products; answered as if they stuck, nodes that slip take 34 to 64."""
        pressed = ss.press(HALF, BALL, force=FORCE, friction=RUB, nodes=128, **load)
        assert pressed.certificate.worst < 1e-8
        assert pressed.state.steps[1] <= 24

    def test_what_is_let_go_is_solved_to_its_own_displacement(self):
        firm = ss.press(HALF, BALL, force=FORCE, nodes=64)
        for force in (0.1, 0.03):
            assert ss.press(HALF, BALL, force=force, after=firm).certificate.worst < 1e-8
