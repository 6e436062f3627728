"""Parts of the search for the pressure on an area, against dense algebra: factor, what leaves, what follows a drag."""

from __future__ import annotations

import numba as nb
import numpy as np
import pytest

import subskin as ss
from subskin.estimate.pressure import _elements
from subskin.estimate.pressure import _solver as solver
from subskin.estimate.pressure._algebra import factored, forward
from subskin.estimate.pressure._windows import windows
from subskin.estimate.pressure.hats import AT_ONCE, LANES, REGISTERS

WEIGHT, DRAG = 1e-7, np.array([0.2, -0.1])


@pytest.mark.parametrize("count", [1, 2, 3, 4, 5, 7, 8, 11, 30])
def test_factor(count):
    root = np.random.default_rng(count).normal(size=(count, count + 3))
    matrix = root @ root.T
    room = np.full((count + 2, count + 2), 7.0)
    room[:count, :count] = matrix
    assert factored(room, count)
    found = np.tril(room[:count, :count])
    np.fill_diagonal(found, 1 / np.diag(found))
    np.testing.assert_allclose(found, np.linalg.cholesky(matrix), atol=1e-12)
    for k in range(count):  # not positive from some row on
        room[:count, :count] = matrix
        room[k, k] = -1.0
        assert not factored(room, count)


@nb.njit  # nothing kept on disk, which would not see that what it calls has changed
def sums(line, start, pull, at, registers, out):
    windows(line, start, pull, at, registers, out)


@pytest.mark.parametrize("registers", range(1, REGISTERS + 1))
def test_sums_of_windows(registers):
    rng = np.random.default_rng(registers)
    line, pull = rng.normal(size=300).astype(np.float32), rng.normal(size=6 * AT_ONCE).astype(np.float32)
    start, out = rng.integers(0, 240, pull.size), np.full(REGISTERS * LANES + 1, 7.0, dtype=np.float32)
    expected, many = out.copy(), registers * LANES
    for share, first in zip(pull, start, strict=True):
        expected[:many] += share * line[first + 11 : first + 11 + many]
    expected[:many] -= 7.0
    for how in (windows, sums):
        found = out.copy()
        how(line, start, pull, 11, registers, found)
        np.testing.assert_allclose(found, expected, atol=1e-5, equal_nan=False)


class Searched:
    """One frame's heights on a square of elements that reaches beyond the touch, so that some come out < 0."""

    def __init__(self) -> None:
        array = ss.SensorArray.grid((6, 6), 1.5e-3, 2e-3, transducer=ss.MeanPressure(), noise=30.0)
        finger = ss.Finger(ss.HalfSpace(ss.Material(young=0.4e6)), array)
        mapper = ss.estimate.ImageMapper(finger)
        frame = finger.read(ss.RoundHertz(1.5, angle=0.2, half_width=2e-3), np.random.default_rng(3))
        self.level = _elements.Level(*mapper._prepare(array.live)[0].fine)
        self.work = _elements.Work.of(self.level, 36, 256, 1)
        self.b = frame / np.asarray(array.noise)
        hats, prior = mapper._hats(array.live), mapper._surface.prior
        self.parts = np.stack([hats.columns(i) for i in range(3)])
        self.form, self.cost = prior.form.toarray(), self.level.cost
        ny, nz = prior.shape
        y, z = np.divmod(np.arange(ny * nz), nz)
        self.on = (abs(y - ny // 2) <= 4) & (abs(z - nz // 2) <= 4)
        self.square = self.on.copy()
        _elements.forget(self.work)
        _elements.lean(self.level, DRAG, self.work)
        self.count, self.reach = solver.heights(self.level, WEIGHT, self.b, self.on, self.work)
        self.first = self.work.z[: self.count].copy()
        solver.leave(self.on, self.count, self.work)

    def heights(self, on: np.ndarray, t: np.ndarray) -> np.ndarray:
        """Those of the elements `on` at the drag t by dense algebra, (N,)."""
        columns = (self.parts[0] + t[0] * self.parts[1] + t[1] * self.parts[2])[on]
        out = np.zeros(on.size)
        matrix = columns @ columns.T + WEIGHT * self.form[np.ix_(on, on)]
        out[on] = np.linalg.solve(matrix, columns @ self.b - self.cost[on])
        return out


@pytest.fixture(scope="module")
def searched() -> Searched:
    return Searched()


def test_heights_of_a_square(searched):
    expected = searched.heights(searched.square, DRAG)
    np.testing.assert_allclose(searched.first, expected[searched.square], atol=1e-8 * expected.max())
    columns = searched.parts[0] + DRAG @ searched.parts[1:].transpose(1, 0, 2)
    slopes = (columns @ searched.b - searched.cost)[searched.square]
    assert searched.reach == pytest.approx(np.abs(slopes).max())


def test_what_comes_out_below_zero_leaves(searched):
    expected = searched.heights(searched.square, DRAG)
    assert searched.work.taken[_elements.AWAY] == (expected < 0).sum() > 3
    np.testing.assert_array_equal(searched.on, searched.square & (expected >= 0))
    without = searched.heights(searched.on, DRAG)
    np.testing.assert_allclose(searched.work.z[: searched.count], without[searched.square], atol=1e-8 * without.max())


def test_what_left_has_no_part_in_a_variance(searched):
    """The factor of all, and the directions in which x stays, give the variances of those that are left."""
    on, count = searched.on, searched.count
    weights = np.random.default_rng(0).normal(size=on.size)
    z = weights[searched.work.listed[:count]]
    forward(searched.work.lower, count, z)
    solver.stay(searched.work, count, z)
    columns = (searched.parts[0] + DRAG[0] * searched.parts[1] + DRAG[1] * searched.parts[2])[on]
    matrix = columns @ columns.T + WEIGHT * searched.form[np.ix_(on, on)]
    assert z @ z == pytest.approx(weights[on] @ np.linalg.solve(matrix, weights[on]), rel=1e-8)


def test_products_in_single_precision(searched):
    """They are near, and those in double precision take their place."""
    level, work, count = searched.level, searched.work, searched.count
    room = [np.copy(part) for part in work]
    columns = (searched.parts[0] + DRAG[0] * searched.parts[1] + DRAG[1] * searched.parts[2])[searched.square]
    expected = columns @ columns.T + WEIGHT * searched.form[np.ix_(searched.square, searched.square)]
    for exact, off in ((False, 1e-5), (True, 1e-13)):
        _elements.make_exact(work)
        work.taken[_elements.SINGLE] = not exact
        assert _elements.hessian(level, WEIGHT, work, count)
        found = np.abs(np.tril(work.lower[:count, :count]) - np.tril(expected)).max() / expected.max()
        assert 0.0 < found < off
    for part, kept in zip(work, room, strict=True):
        part[...] = kept


def test_heights_follow_the_drag(searched):
    level, work, count, n = searched.level, searched.work, searched.count, searched.b.size
    x, index = work.x[0], work.listed
    turned = solver.Turn(np.empty((2, n)), np.empty((2, x.size)), np.zeros(2), np.zeros(3), np.zeros(2))

    def least(t: np.ndarray) -> float:
        p = searched.heights(searched.on, t)
        left = (searched.parts[0] + t[0] * searched.parts[1] + t[1] * searched.parts[2]).T @ p - searched.b
        return 0.5 * left @ left + 0.5 * WEIGHT * p @ searched.form @ p + searched.cost @ p

    x[:] = 0.0
    x[index[:count]] = work.z[:count]
    _elements.residual(searched.b, work)
    solver.turn(work, count, turned)
    h = 1e-3
    ey, ez = h * np.eye(2)
    for i, e in enumerate((ey, ez)):
        assert turned.slope[i] == pytest.approx((least(DRAG + e) - least(DRAG - e)) / (2 * h), rel=1e-3)
        bent = (least(DRAG + e) - 2 * least(DRAG) + least(DRAG - e)) / h**2
        assert turned.bend[2 * i] == pytest.approx(bent, rel=1e-2)
    new, t = DRAG + np.array([2e-4, 1e-4]), DRAG.copy()
    turned.new[:] = new
    assert solver.follow(level, t, searched.on, count, turned, work)
    np.testing.assert_array_equal(t, new)
    expected, before = searched.heights(searched.on, new), searched.heights(searched.on, DRAG)
    off = np.abs(x - expected).max()
    assert off < 0.02 * np.abs(expected - before).max()
    assert (x[~searched.on] == 0.0).all()
