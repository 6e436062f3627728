"""What is known of friction: its density, and what slips and holds make of it."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.stats import norm, truncnorm

import subskin as ss
from subskin.decide import Friction

from ._estimates import estimate


class TestDensity:
    def test_known(self):
        mu = Friction.known(0.5)
        assert (mu.mean, mu.std, mu.high, mu.quantile(0.3)) == (0.5, 0.0, 0.5, 0.5)
        assert Friction.known([0.4, 1]).mean == pytest.approx([0.4, 1.0])

    def test_range(self):
        mu = Friction.between(0.4, 0.9)
        assert mu.mean == pytest.approx(0.65, rel=1e-12)
        assert mu.std == pytest.approx(0.5 / np.sqrt(12), rel=1e-12)
        assert mu.quantile([0.0, 0.1, 0.5, 1.0]) == pytest.approx([0.4, 0.45, 0.65, 0.9], rel=1e-12)
        each = Friction.between([0.2, 0.4], 0.9)
        assert each.shape == (2,)
        assert each.mean == pytest.approx([0.55, 0.65], rel=1e-12)
        assert each.quantile([0.0, 0.5, 1.0]).shape == (2, 3)

    def test_normal(self):
        mu = Friction.normal(0.6, 0.05)
        assert mu.mean == pytest.approx(0.6, rel=1e-9)
        assert mu.std == pytest.approx(0.05, rel=1e-3)
        p = np.array([1e-4, 0.025, 0.5, 0.9])
        assert mu.quantile(p) == pytest.approx(norm(0.6, 0.05).ppf(p), abs=2e-4)

    def test_normal_cut_off_at_0(self):
        mu, wanted = Friction.normal(0.1, 0.1), truncnorm(-1.0, 6.0, 0.1, 0.1)
        assert mu.mean == pytest.approx(wanted.mean(), rel=1e-3)
        assert mu.std == pytest.approx(wanted.std(), rel=1e-3)
        assert mu.quantile(0.0) == 0.0

    def test_gaps_and_read_only(self):
        mu = Friction([0.2, 0.3, 0.5, 0.7], [1, 0, 3])
        assert mu.quantile([0.25, 0.26, 1.0]) == pytest.approx([0.3, 0.5 + 0.2 * 0.01 / 0.75, 0.7])
        assert mu.mean == pytest.approx(0.25 * 0.25 + 0.6 * 0.75)
        assert not mu.masses.flags.writeable
        assert not mu.edges.flags.writeable
        assert "0.512 +- 0.16" in repr(mu)


class TestLearning:
    def test_a_slip_says_what_friction_is(self):
        """N without error: the density of mu is that of T / N, cut off by the range."""
        seen = estimate(20.0, 12.0, (1e-20, 0.0, 0.36))
        mu = Friction.between(0.3, 0.9).updated(slips=seen)
        wanted = truncnorm((0.3 - 0.6) / 0.03, (0.9 - 0.6) / 0.03, 0.6, 0.03)
        assert mu.mean == pytest.approx(wanted.mean(), abs=2e-4)
        assert mu.std == pytest.approx(wanted.std(), rel=0.01)
        assert mu.quantile([0.025, 0.975]) == pytest.approx(wanted.ppf([0.025, 0.975]), abs=1e-3)

    def test_the_likelihood_of_a_slip_with_both_forces_unsure(self):
        """Against the integral over N of the density of (N, T) measured, at T = mu N and at T = -mu N."""
        cov = np.array([[4.0, 1.5], [1.5, 2.0]])
        mu = Friction.between(0.1, 0.9).updated(slips=estimate(8.0, -3.0, (cov[0, 0], cov[0, 1], cov[1, 1])))
        n = np.linspace(-40, 60, 4001)
        grid = np.linspace(0.1, 0.9, 801)
        density = np.zeros(grid.size)
        for side in (1, -1):
            away = np.stack(np.broadcast_arrays(n - 8.0, side * grid[:, None] * n + 3.0))
            chi2 = np.einsum("i...,ij,j...", away, np.linalg.inv(cov), away)
            density += np.exp(-0.5 * chi2).sum(axis=1)
        share = np.cumsum(density) - 0.5 * density
        share /= density.sum()
        for p in (0.05, 0.3, 0.7, 0.95):
            assert mu.quantile(p) == pytest.approx(np.interp(p, share, grid), abs=1e-3)

    def test_a_hold_says_what_friction_is_at_least(self):
        seen = estimate(20.0, -10.0, (1e-20, 0.0, 0.04))
        mu = Friction.between(0.3, 0.9).updated(holds=seen)
        grid = np.linspace(0.3, 0.9, 60001)
        density = norm.cdf((20 * grid - 10.0) / 0.2)
        assert mu.mean == pytest.approx((density * grid).sum() / density.sum(), abs=5e-5)
        assert mu.quantile(1e-3) > 0.47

    def test_together_and_one_after_the_other(self):
        slips, holds = estimate([20.0, 25.0], [11.0, 14.0]), estimate([20.0, 20.0, 20.0], [8.0, 9.0, 10.0])
        prior = Friction.between(0.3, 0.9)
        together = prior.updated(slips=slips, holds=holds)
        after = prior.updated(holds=holds).updated(slips=slips)
        assert together.mean == pytest.approx(after.mean, abs=3e-4)
        assert together.std == pytest.approx(after.std, rel=0.02)
        assert together.mean == pytest.approx(0.555, abs=0.01)

    def test_the_grid_follows_where_it_becomes_narrow(self):
        """A thousand times narrower than the range, and still drawn by many cells."""
        seen = estimate(20.0, 12.0, (1e-20, 0.0, 1e-4))
        mu = Friction.between(0.0, 2.0).updated(slips=seen)
        assert mu.mean == pytest.approx(0.6, abs=1e-5)
        assert mu.std == pytest.approx(5e-4, rel=0.02)
        # and what was known before is kept on the finer grid
        sided = Friction([0.0, 0.6, 2.0], [0.9, 0.1]).updated(slips=seen)
        assert sided.quantile(0.9 / 0.6 / (0.9 / 0.6 + 0.1 / 1.4)) == pytest.approx(0.6, abs=2e-4)

    def test_each_friction_its_own_events(self):
        prior = Friction.between([0.3, 0.3], 0.9)
        seen = estimate([[20.0, 20.0, 20.0]] * 2, [[10.0, 10.2, 9.8], [14.0, 14.2, 13.8]])
        learned = prior.updated(slips=seen)
        assert learned.shape == (2,)
        for k in range(2):
            one = Friction.between(0.3, 0.9).updated(
                slips=estimate([20.0] * 3, [[10.0, 10.2, 9.8], [14.0, 14.2, 13.8]][k])
            )
            assert learned.mean[k] == pytest.approx(one.mean, rel=1e-9)
            assert learned.std[k] == pytest.approx(one.std, rel=1e-6)

    def test_what_says_nothing(self):
        prior = Friction.between(0.3, 0.9)
        none = estimate([20.0, 20.0], 12.0, status=ss.Status.NO_CONTACT)
        cut = estimate(20.0, 20.0 * 0.7, friction=0.7)
        for learned in (prior.updated(), prior.updated(slips=none), prior.updated(slips=cut)):
            assert learned.masses == pytest.approx(prior.masses, rel=1e-12)
        assert Friction.known(0.5).updated(slips=estimate(20.0, 9.0)).mean == 0.5

    def test_many_holds_do_not_underflow(self):
        mu = Friction.between(0.3, 0.9).updated(holds=estimate(np.full(5000, 20.0), 12.0))
        assert mu.quantile(0.01) > 0.6
        assert np.isfinite(mu.mean)


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda: Friction.known(-0.1), "friction"),
        (lambda: Friction.known(np.nan), "finite"),
        (lambda: Friction.between(0.8, 0.4), "ascends"),
        (lambda: Friction.between(-0.1, 0.4), "low"),
        (lambda: Friction.between(0.5, 0.5), "known"),
        (lambda: Friction.between(0.2, 0.5, cells=0), "cells"),
        (lambda: Friction.normal(0.5, 0.0), "std"),
        (lambda: Friction([0.1, 0.2], [1.0, 1.0]), "k \\+ 1 edges"),
        (lambda: Friction([0.1, 0.3, 0.2], [1.0, 1.0]), "ascend"),
        (lambda: Friction([0.1, 0.2, 0.3], [0.0, 0.0]), "all 0"),
        (lambda: Friction([0.1, 0.2, 0.3], [1.0, -0.1]), "masses"),
        (lambda: Friction.between(0.3, 0.5).updated(slips=estimate(20.0, 19.0)), "no friction from 0.3 to 0.5"),
        (lambda: Friction.between(0.3, 0.5).updated(holds=estimate(20.0, 19.0)), "no friction from 0.3 to 0.5"),
        (lambda: Friction.between([0.3, 0.4], 0.5).updated(slips=estimate(20.0, 9.0)), "first axes"),
        (lambda: Friction.between(0.3, 0.5).updated(slips=np.zeros(3)), "Finger.locate"),
        (lambda: Friction.between(0.3, 0.5).quantile(1.5), "probability"),
    ],
)
def test_what_cannot_be(call, words):
    with pytest.raises(ss.SubskinError, match=words):
        call()
