"""How close a touch on an area is to slipping: two components of drag, and their errors."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.stats import norm

import subskin as ss
from subskin.decide import Friction, SlipVerdict, least_force, slip
from subskin.estimate import Estimate
from subskin.estimate.layout import AREA, BESIDE

SQUARE = np.array([[4.0, 0.6, -0.8], [0.6, 1.5, 0.5], [-0.8, 0.5, 2.5]]) * 1e-3


def estimate(components, square=SQUARE, status=ss.Status.OK, friction=np.inf):
    """An estimate of touches on an area with the given errors of (N, Ty, Tz)."""
    components = np.atleast_2d(components)
    table = np.zeros((len(components), AREA.columns))
    table[:, AREA.components : AREA.components + 3] = components
    full = np.eye(5) * 1e-8
    full[2:, 2:] = square
    table[:, AREA.square] = full
    table[:, AREA.status] = status
    return Estimate(table, np.ones((len(components), 9), bool), friction, 5, AREA)


LOADS = np.array([[1.0, 0.3, 0.2], [1.0, -0.25, 0.42], [0.3, 0.05, -0.12], [1.0, 0.02, 0.01], [0.1, 0.02, 0.02]])


@pytest.mark.parametrize("friction", [Friction.known(0.5), Friction.between(0.3, 0.6)])
def test_the_probability_is_that_of_draws(friction):
    rng = np.random.default_rng(0)
    judged = slip(estimate(LOADS), friction)
    edges, masses = np.asarray(friction.edges), np.asarray(friction.masses)
    for load, p in zip(LOADS, judged.probability, strict=True):
        n, ty, tz = rng.multivariate_normal(load, SQUARE, 400_000).T
        cell = rng.choice(masses.size, n.size, p=masses / masses.sum())
        mu = rng.uniform(edges[cell], edges[cell + 1])
        drawn = (np.hypot(ty, tz) > mu * n).mean()
        assert p == pytest.approx(drawn, abs=5e-3 * np.sqrt(drawn) + 2e-4)


def test_a_turned_touch_is_as_close_to_slipping():
    turn = 0.7
    c, s = np.cos(turn), np.sin(turn)
    r = np.array([[1, 0, 0], [0, c, -s], [0, s, c]])
    here, there = slip(estimate(LOADS), 0.5), slip(estimate(LOADS @ r.T, r @ SQUARE @ r.T), 0.5)
    for name in ("probability", "margin", "margin_std", "ratio", "ratio_interval"):
        np.testing.assert_allclose(getattr(there, name), getattr(here, name), rtol=1e-8)
    np.testing.assert_allclose(here.tangential, np.hypot(LOADS[:, 1], LOADS[:, 2]))
    np.testing.assert_allclose(here.margin, 0.5 * LOADS[:, 0] - here.tangential)
    assert here.covariance.shape == (5, 3, 3)
    assert " N" in repr(here)


def test_without_error_across_it_is_the_planar_one():
    from subskin.estimate.layout import LINE

    square = SQUARE.copy()
    square[2] = square[:, 2] = 0.0
    square[2, 2] = 1e-24
    loads = LOADS * [1.0, 1.0, 0.0]
    table = np.zeros((len(loads), LINE.columns))
    table[:, 1:3] = loads[:, :2]
    full = np.eye(3) * 1e-8
    full[1:, 1:] = square[:2, :2]
    table[:, LINE.square] = full
    line = Estimate(table, np.ones((len(loads), 9), bool), np.inf, 3, LINE)
    friction = Friction.between(0.3, 0.6)
    area, plane = slip(estimate(loads, square), friction), slip(line, friction)
    np.testing.assert_allclose(area.probability, plane.probability, atol=1e-3)
    np.testing.assert_allclose(area.margin_std, plane.margin_std, rtol=1e-12)
    np.testing.assert_array_equal(area.verdict, plane.verdict)


def test_verdicts_and_what_cannot_be_told():
    loads = [[1.0, 0.05, 0.05], [1.0, 0.3, 0.3], [1.0, 0.5, 0.5]]
    tight = SQUARE * 0.1
    judged = slip(estimate(loads, tight), Friction.between(0.4, 0.5))
    assert judged.verdict.tolist() == [SlipVerdict.HOLDS, SlipVerdict.AT_RISK, SlipVerdict.SLIPS]
    lost = slip(estimate(loads, status=ss.Status.UNEXPLAINED), 0.5)
    assert (lost.verdict == SlipVerdict.CANNOT_TELL).all()
    assert np.isnan(lost.probability).all()
    cut = slip(estimate(loads, tight, friction=0.45), 0.5)
    assert cut.at_edge.tolist() == [False, False, True]
    assert judged.probability_at(1, 1.0, np.hypot(0.3, 0.3)) == pytest.approx(judged.probability[1], rel=1e-9)


def test_the_least_force_holds_by_its_own_probability():
    found = estimate(LOADS[:2])
    force = least_force(found, 0.5, 1e-3)
    held = estimate(np.column_stack([force, LOADS[:2, 1:]]))
    np.testing.assert_allclose(slip(held, 0.5).probability, 1e-3, rtol=1e-4)


def test_what_a_row_does_not_tell_is_refused():
    table = np.zeros((1, BESIDE.columns))
    beside = Estimate(table, np.ones((1, 6), bool), 1.0, 4, BESIDE)
    with pytest.raises(ss.errors.InvalidValueError, match="drag across"):
        slip(beside, 0.5)
    with pytest.raises(ss.errors.InvalidValueError, match="one component of drag"):
        Friction.between(0.3, 0.6).updated(slips=estimate(LOADS))


def beyond_by_sums(mean, square, ratios):
    """P(|T| > q N) for each of the `ratios`: N given the drag is normal, and the drag is summed over a grid."""
    to_drag = square[0, 1:] @ np.linalg.inv(square[1:, 1:])
    spread = np.sqrt(square[0, 0] - to_drag @ square[1:, 0])
    root = np.linalg.cholesky(square[1:, 1:])
    steps = np.linspace(-8.0, 8.0, 401)
    y, z = np.moveaxis(np.stack(np.meshgrid(steps, steps, indexing="ij"), axis=-1) @ root.T, -1, 0)
    weight = norm.pdf(steps)[:, None] * norm.pdf(steps) * (steps[1] - steps[0]) ** 2
    normal = mean[0] + to_drag[0] * y + to_drag[1] * z
    drag = np.hypot(mean[1] + y, mean[2] + z)
    return np.array([(weight * norm.sf((normal - drag / q) / spread)).sum() for q in ratios])[()]


@pytest.mark.parametrize(("scale", "off"), [(1e-6, 1e-9), (1e-2, 2e-6), (1.0, 1e-3), (25.0, 2e-3)])
def test_the_probability_is_the_integral(scale, off):
    """Errors from a thousandth of the drag, by which the cone looks flat, to errors as large as the forces."""
    rng = np.random.default_rng(5)
    for _ in range(6):
        drag, azimuth = rng.uniform(0.05, 0.6), rng.uniform(-np.pi, np.pi)
        mean = np.array([1.0, drag * np.cos(azimuth), drag * np.sin(azimuth)])
        root = rng.normal(size=(3, 3))
        square = scale * 1e-2 * (root @ root.T / 3 + 0.5 * np.eye(3))
        mu = drag + rng.uniform(-2.0, 2.0) * np.sqrt(np.trace(square) / 3)
        if mu > 0.02:
            found = slip(estimate(mean, square), mu).probability[0]
            np.testing.assert_allclose(found, beyond_by_sums(mean, square, [mu])[0], atol=off)
        friction, middles = Friction.between(0.2, 0.7), 0.2 + 0.5 * (np.arange(40) + 0.5) / 40
        if scale > 1e-3:  # else the sum over mu is the coarser one
            found = slip(estimate(mean, square), friction).probability[0]
            wanted = beyond_by_sums(mean, square, middles).mean()
            np.testing.assert_allclose(found, wanted, atol=off + 2e-4)


@pytest.mark.parametrize("friction", [0.5, Friction.between(0.2, 0.9), Friction.normal(0.5, 0.1)], ids=str)
@pytest.mark.parametrize("scale", [1e-4, 1.0])
def test_at_the_least_force_and_at_the_ends_of_the_ratio_the_probability_is_the_one_asked_for(friction, scale):
    rng = np.random.default_rng(1)
    drag = rng.uniform(0.1, 0.6, (20, 2))
    loads = np.column_stack([np.ones(20), drag])
    made = estimate(loads, scale * SQUARE)
    for bound in (0.2, 1e-3, 1e-6):
        force = least_force(made, friction, bound)
        again = slip(estimate(np.column_stack([force, drag]), scale * SQUARE), friction).probability
        np.testing.assert_allclose(again, bound, rtol=1e-3)
    for end, share in zip(slip(made, friction).ratio_interval.T, (0.975, 0.025), strict=True):
        # a drag as large a part of mu N as that is one of a friction that is so much less
        known = isinstance(friction, float)
        less = friction * end if known else None
        for k in range(0, 20, 7):
            mu = less[k] if known else Friction(np.asarray(friction.edges) * end[k], np.asarray(friction.masses))
            np.testing.assert_allclose(slip(made, mu).probability[k], share, rtol=1e-3)
