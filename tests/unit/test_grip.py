"""The least normal force: closed forms, the bound met, batches, limits, and bad input."""

from __future__ import annotations

import os
import subprocess
import sys

import numpy as np
import pytest
from scipy.stats import norm

import subskin as ss
from subskin.decide import Friction, least_force, slip

from ._estimates import estimate


class TestClosedForms:
    def test_known_friction_and_a_normal_drag(self):
        """mu N = |T| + z std, N without error."""
        made = estimate(20.0, [6.0, -8.0, 12.0], (1e-20, 0.0, 0.25))
        for bound in (0.3, 1e-3, 1e-9):
            wanted = (np.array([6.0, 8.0, 12.0]) - norm.ppf(bound) * 0.5) / 0.4
            assert least_force(made, 0.4, bound) == pytest.approx(wanted, rel=1e-9)

    def test_the_error_of_the_normal_force(self):
        """(mu N - T)^2 = z^2 var(T - mu N), the larger root."""
        nn, nt, tt, mu = 0.5, 0.2, 0.3, 0.6
        z = -norm.ppf(1e-3)
        wanted = (9.0 + z * np.sqrt(tt - 2 * mu * nt + mu**2 * nn)) / mu
        assert least_force(estimate(20.0, 9.0, (nn, nt, tt)), mu) == pytest.approx(wanted, rel=1e-9)

    def test_a_range_without_errors_of_the_load(self):
        """The friction's own quantile decides: N = |T| / quantile."""
        made = estimate(20.0, 8.0, (1e-20, 0.0, 1e-20))
        friction = Friction.between(0.4, 0.8)
        assert least_force(made, friction, 0.01) == pytest.approx(8.0 / 0.404, rel=1e-6)

    def test_what_is_predicted(self):
        made = estimate(20.0, 6.0, (1e-20, 0.0, 0.09))
        steps = np.array([0.0, 2.0, -10.0])
        found = least_force(estimate([20.0] * 3, 6.0, (1e-20, 0.0, 0.09)), 0.5, 1e-3, rise=steps, rise_std=0.4)
        wanted = (np.abs(6.0 + steps) - norm.ppf(1e-3) * 0.5) / 0.5
        assert found == pytest.approx(wanted, rel=1e-8)
        # a drag that will be gone still needs holding against its error, to both sides
        gone = least_force(made, 0.5, 1e-3, rise=-6.0)
        assert gone == pytest.approx(-norm.ppf(5e-4) * 0.3 / 0.5, rel=1e-8)


@pytest.mark.parametrize("friction", [0.5, Friction.between(0.2, 0.9), Friction.normal(0.5, 0.1)], ids=str)
@pytest.mark.parametrize("bound", [0.2, 1e-3, 1e-6])
def test_at_the_answer_the_probability_is_the_bound(friction, bound):
    """`slip` is asked about the same load with the answer for N: it has to say the bound, and more below it."""
    rng = np.random.default_rng(0)
    root = rng.normal(size=(2, 2))
    cov = root @ root.T
    square = (cov[0, 0], cov[0, 1], cov[1, 1])
    tangential = rng.uniform(-15.0, 15.0, 20)
    found = least_force(estimate(30.0, tangential, square), friction, bound)
    told = found > 0
    assert told.mean() > 0.8
    again = slip(estimate(found[told], tangential[told], square), friction).probability
    assert again == pytest.approx(bound, rel=1e-7)
    less = slip(estimate(0.999 * found[told], tangential[told], square), friction).probability
    assert (less > bound).all()


class TestFrames:
    def test_batches_and_a_friction_for_each(self):
        made = estimate(np.full((2, 3), 20.0), np.linspace(-9, 9, 6).reshape(2, 3))
        friction = Friction.between(np.linspace(0.3, 0.6, 6).reshape(2, 3), 0.9)
        found = least_force(made, friction, rise=0.5)
        assert found.shape == (2, 3)
        assert not found.flags.writeable
        for k, (i, j) in enumerate(np.ndindex(2, 3)):
            one = least_force(estimate(20.0, np.linspace(-9, 9, 6)[k]), Friction.between(0.3 + 0.06 * k, 0.9), rise=0.5)
            assert found[i, j] == pytest.approx(one, rel=1e-9)

    def test_no_load_no_answer(self):
        status = [ss.Status.OK, ss.Status.NO_CONTACT, ss.Status.UNEXPLAINED, ss.Status.INCOMPLETE]
        found = [float(least_force(estimate(20.0, 5.0, status=s), 0.5)) for s in status]
        assert np.isnan(found).tolist() == [False, True, True, True]
        assert np.isnan(least_force(estimate(20.0, 20.0 * 0.7, friction=0.7), 0.5))

    def test_where_friction_may_be_nothing(self):
        made = estimate(20.0, 5.0)
        assert least_force(made, 0.0) == np.inf
        assert least_force(made, Friction([0.0, 0.0, 0.5], [0.01, 0.99]), 1e-3) == np.inf
        assert np.isfinite(least_force(made, Friction([0.0, 0.0, 0.5], [0.01, 0.99]), 0.02))
        # a range down to 0 asks for |T| / (bound * range): finite, and far beyond any hand
        found = least_force(estimate(20.0, 5.0, (1e-20, 0.0, 1e-20)), Friction.between(0.0, 0.5), 1e-3)
        assert found == pytest.approx(5.0 / (1e-3 * 0.5), rel=1e-4)

    def test_a_bound_that_needs_no_grip(self):
        assert least_force(estimate(20.0, 0.1), 0.5, 0.999) == 0.0


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda: least_force(estimate(20.0, 5.0), 0.5, 0.0), "probability"),
        (lambda: least_force(estimate(20.0, 5.0), 0.5, 1.0), "< 1"),
        (lambda: least_force(estimate(20.0, 5.0), 0.5, rise=np.nan), "rise"),
        (lambda: least_force(estimate(20.0, 5.0), 0.5, rise_std=-1.0), "rise_std"),
        (lambda: least_force(estimate(20.0, 5.0), 0.5, rise=[1.0, 2.0]), "one for each"),
        (lambda: least_force(estimate([20.0] * 3, 5.0), 0.5, rise=[1.0, 2.0]), "broadcast"),
        (lambda: least_force(0.5, 0.5), "Finger.locate"),
    ],
)
def test_what_cannot_be_asked(call, words):
    with pytest.raises(ss.SubskinError, match=words):
        call()


_LEVELS = """
import numpy as np
from subskin.decide._drag_kernel import fill_levels
known, uncertain = (np.array([[0.5, 0.5]]), np.ones((1, 1))), (np.linspace(0.4, 0.8, 9)[None], np.full((1, 8), 0.125))
for parts in (2, 3):
    mean, square, out = np.array([[1.0, 0.3, 0.0]])[:, :parts].copy(), 1e-4 * np.eye(parts)[None], np.empty(1)
    for density in (known, uncertain):
        for by_ratio in (True, False):
            fill_levels(mean, square, *density, 1e-3, by_ratio, out)
            print(out[0])
"""


def test_the_loop_keeps_within_its_arrays():
    """In plain Python an index past an end is an error; compiled it reads, or writes, what lies there."""
    said = []
    for plain in ("0", "1"):
        environment = {**os.environ, "NUMBA_DISABLE_JIT": plain}
        call = [sys.executable, "-c", _LEVELS]
        ran = subprocess.run(call, env=environment, capture_output=True, text=True, check=False)
        assert ran.returncode == 0, ran.stderr
        said.append([float(line) for line in ran.stdout.split()])
    np.testing.assert_allclose(*said, rtol=1e-9)
    assert len(said[0]) == 8
