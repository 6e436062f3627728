"""A load as a vector, of a long contact and of a local one."""

from __future__ import annotations

import numpy as np
import pytest

import subskin as ss
from subskin.errors import GeometryError
from subskin.loads import polar_covariance

LONG = ss.Load([1e-3, 2e-3], [[3.0, -4.0], [12.0, 5.0]])
LOCAL = ss.Load([[1e-3, 2e-3]], [[2.0, -3.0, 6.0]])
EDGE = np.sqrt(0.5)  # a drag of (EDGE, EDGE) is 1


def square(size, seed=0):
    """A covariance without a zero in it."""
    root = np.random.default_rng(seed).normal(size=(size, size))
    return root @ root.T


def polar(components):
    """Force, angle and azimuth by trigonometry of their own: cosines and sines put back together."""
    if len(components) == 2:
        force = np.sqrt(components @ components)
        return np.array([force, np.arcsin(components[1] / force)])
    force = np.sqrt(components @ components)
    return np.array([force, np.arccos(components[0] / force), np.angle(components[1] + 1j * components[2])])


def test_a_long_contact_in_numbers():
    assert (LONG.dim, LONG.shape) == (1, (2,))
    assert LONG.force.tolist() == [5.0, 13.0]
    assert LONG.drag.tolist() == [4.0, 5.0]
    np.testing.assert_allclose(np.tan(LONG.angle), [-4 / 3, 5 / 12], rtol=1e-15)
    np.testing.assert_allclose(LONG.azimuth, [np.pi, 0.0], rtol=1e-15)  # towards -y, towards +y


def test_a_local_contact_in_numbers():
    assert (LOCAL.dim, LOCAL.shape, LOCAL.force.tolist()) == (2, (1,), [7.0])
    assert LOCAL.normal.tolist() == [2.0]
    assert LOCAL.tangential.tolist() == [[-3.0, 6.0]]
    np.testing.assert_allclose(LOCAL.drag, np.sqrt(45), rtol=1e-15)
    np.testing.assert_allclose(np.cos(LOCAL.angle), 2 / 7, rtol=1e-15)
    assert LOCAL.angle[0] > 0
    assert LOCAL.azimuth[0] > np.pi / 2


@pytest.mark.parametrize("components", [[3.0, -4.0], [2.0, -3.0, 6.0]], ids=["long", "local"])
def test_the_polar_covariance_is_that_of_differences(components):
    components = np.array(components)
    d = components.size - 1
    covariance = square(2 * d + 2)  # one more unknown, such as a half width, after the components
    turn = np.eye(2 * d + 2)
    h = 1e-5
    for i in range(d + 1):
        step = h * np.eye(d + 1)[i]
        turn[d : 2 * d + 1, d + i] = (polar(components + step) - polar(components - step)) / (2 * h)
    np.testing.assert_allclose(
        polar_covariance(components, covariance), turn @ covariance @ turn.T, rtol=1e-8, atol=1e-9
    )


def test_the_polar_covariance_is_the_spread_of_draws():
    rng = np.random.default_rng(1)
    covariance = 1e-4 * square(5, seed=2)
    load = ss.Load([0.0, 0.0], [2.0, -3.0, 6.0], covariance)
    drawn = rng.multivariate_normal([0.0, 0.0, 2.0, -3.0, 6.0], covariance, 200_000)
    many = ss.Load(drawn[:, :2], drawn[:, 2:])
    seen = np.cov(np.column_stack([many.position, many.force, many.angle, many.azimuth]).T)
    size = np.sqrt(np.outer(np.diag(seen), np.diag(seen)))
    assert (np.abs(load.polar - seen) < 0.02 * size).all()  # 5 standard errors of 200 000 draws, and second order
    np.testing.assert_allclose(load.std**2, np.diag(load.polar))


def test_what_is_not_known_stays_so():
    assert np.isnan(LONG.polar).all()
    assert LONG.polar.shape == (2, 3, 3)
    covariance = np.diag([np.inf, 1.0, 4.0])  # of a position that nothing tells, the force is told
    told = ss.Load(0.0, [3.0, 4.0], covariance).polar
    assert told[0, 0] == np.inf
    assert np.isclose(told[1, 1], (3**2 * 1 + 4**2 * 4) / 25)


def test_within_the_cone():
    inside, edge, outside, pull = [2.0, 0.9], [2.0, 1.0], [2.0, -1.1], [-2.0, 0.0]
    assert ss.Load(np.zeros(4), [inside, edge, outside, pull]).within(0.5).tolist() == [True, True, False, False]
    local = [[2.0, EDGE - 1e-9, -EDGE], [2.0, EDGE + 1e-9, -EDGE], [-1.0, 0.0, 0.0]]
    assert ss.Load(np.zeros((3, 2)), local).within(0.5).tolist() == [True, False, False]
    assert ss.Load(0.0, [1.0, 9.0]).within(np.inf)
    assert not ss.Load(0.0, [1.0, 1e-12]).within(0.0)


def test_some_of_a_batch():
    covariance = np.stack([square(3), 2 * square(3)])
    one = ss.Load(LONG.position, LONG.components, covariance)[1]
    assert one.shape == ()
    assert one.position == 2e-3
    assert one.components.tolist() == [12.0, 5.0]
    assert np.array_equal(one.covariance, covariance[1])
    assert LOCAL[0].position.tolist() == [1e-3, 2e-3]


def test_what_does_not_belong_together():
    for position, components, covariance in (
        ([0.0, 0.0], [1.0, 0.0], None),  # two positions, one force
        (0.0, [1.0, 0.0, 0.0], None),  # a local force at a position of one coordinate
        (0.0, [1.0], None),
        (0.0, [1.0, 0.0], np.eye(2)),
    ):
        with pytest.raises(GeometryError):
            ss.Load(position, components, covariance)
