"""Slip by closed forms: known friction, batches, statuses, the estimator's own cone, stick zones, and bad input."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.stats import multivariate_normal, norm

import subskin as ss
from subskin.decide import Friction, SlipVerdict, slip, stick_zone
from subskin.estimate.layout import LINE

from ._estimates import estimate

FINGER = ss.Finger(ss.HalfPlane(ss.Material(0.4e6)), ss.SensorArray.line(6, pitch=1e-3, depth=2e-3, noise=1e-4))


class TestProbability:
    @pytest.mark.parametrize("drag", [3.0, 9.0, 10.0, 12.0, -9.0, -11.0])
    def test_one_side_of_the_cone(self, drag):
        """Far from N = 0 and from the cone's other side: a normal tail of mu N - |T|."""
        mu, (nn, nt, tt) = 0.5, (0.04, 0.03, 0.09)
        found = slip(estimate(20.0, drag, (nn, nt, tt)), mu)
        std = np.sqrt(mu**2 * nn + tt - 2 * np.sign(drag) * mu * nt)
        assert found.margin == pytest.approx(10.0 - abs(drag), rel=1e-12)
        assert found.margin_std == pytest.approx(std, rel=1e-9)
        assert found.probability == pytest.approx(norm.cdf((abs(drag) - 10.0) / std), rel=1e-9)
        assert found.ratio == pytest.approx(abs(drag) / 10.0, rel=1e-12)
        assert found.normal == pytest.approx(20.0, rel=1e-12)
        assert found.tangential == pytest.approx(drag, rel=1e-12)

    def test_both_sides_and_loads_that_may_pull(self):
        """Against the normal distribution in the plane: what holds is mu N - T >= 0 and mu N + T >= 0."""
        rng = np.random.default_rng(0)
        for _ in range(30):
            mu = rng.uniform(0.2, 1.0)
            root = rng.normal(size=(2, 2))
            cov = root @ root.T
            normal, tangential = rng.uniform(0.1, 2.0), rng.uniform(-1.0, 1.0)
            rows = np.array([[mu, -1.0], [mu, 1.0]])
            holds = multivariate_normal(
                -rows @ [normal, tangential], rows @ cov @ rows.T, abseps=1e-9, releps=1e-9, maxpts=400_000
            ).cdf([0.0, 0.0])
            made = estimate(normal, tangential, (cov[0, 0], cov[0, 1], cov[1, 1]))
            found = slip(made, mu)
            assert found.probability == pytest.approx(1 - holds, abs=2e-5)

    def test_a_range_without_errors_is_its_distribution(self):
        made = estimate(20.0, [4.0, 9.0, 11.0, 14.0, 18.0], (1e-20, 0.0, 1e-20))
        found = slip(made, Friction.between(0.4, 0.8))
        assert found.probability == pytest.approx([0.0, 0.125, 0.375, 0.75, 1.0], abs=1e-9)
        assert found.margin == pytest.approx(0.6 * 20 - np.array([4.0, 9.0, 11.0, 14.0, 18.0]), rel=1e-9)
        assert found.margin_std == pytest.approx(20 * 0.4 / np.sqrt(12), rel=1e-9)

    def test_a_normal_friction_adds_its_variance(self):
        """T and mu normal, N without error: mu N - T is normal."""
        made = estimate(20.0, np.linspace(8.0, 13.0, 6), (1e-20, 0.0, 0.25))
        found = slip(made, Friction.normal(0.6, 0.03))
        std = np.hypot(0.5, 20 * 0.03)
        assert found.probability == pytest.approx(norm.cdf(-found.margin / std), abs=2e-4)
        assert found.margin_std == pytest.approx(std, rel=2e-3)  # cells widen the density by a little

    def test_no_friction_slips_and_no_drag_holds(self):
        assert slip(estimate(20.0, 1.0), 0.0).probability == pytest.approx(1.0)
        still = slip(estimate(20.0, 0.0), 0.5)
        assert still.probability < 1e-100
        assert still.ratio == 0
        assert still.stick == 1

    def test_more_grip_is_safer(self):
        normal = np.linspace(0.05, 60.0, 400)
        for friction in (0.4, Friction.between(0.0, 0.8), Friction.normal(0.5, 0.1)):
            found = slip(estimate(normal, 7.0, (4.0, 1.0, 2.0)), friction).probability
            assert (np.diff(found) <= 1e-12).all()
            assert found[0] > 0.9
            assert found[-1] < 0.3


class TestFrames:
    def test_batches_are_frame_by_frame(self):
        rng = np.random.default_rng(1)
        normal, tangential = rng.uniform(5, 40, (3, 4)), rng.uniform(-10, 10, (3, 4))
        friction = Friction.between(0.3, 0.7)
        whole = slip(estimate(normal, tangential), friction)
        assert whole.shape == (3, 4)
        assert whole.ratio_interval.shape == whole.stick_interval.shape == (3, 4, 2)
        for i, j in np.ndindex(3, 4):
            one = slip(estimate(normal[i, j], tangential[i, j]), friction)
            for name in ("probability", "margin", "margin_std", "ratio", "verdict", "stick", "ratio_interval"):
                wanted = getattr(one, name)
                assert getattr(whole, name)[i, j] == pytest.approx(wanted, rel=1e-9, abs=1e-300), name

    def test_a_friction_for_each_frame(self):
        made = estimate([20.0, 20.0, 20.0], 8.0)
        each = slip(made, Friction.between([0.3, 0.4, 0.5], [0.5, 0.6, 0.7]))
        for k, low in enumerate((0.3, 0.4, 0.5)):
            one = slip(made, Friction.between(low, low + 0.2))
            assert each.probability[k] == pytest.approx(one.probability[k], rel=1e-12)
            assert each.ratio_interval[k] == pytest.approx(one.ratio_interval[k], rel=1e-9)

    def test_no_number_where_there_is_no_load(self):
        status = np.array([ss.Status.NO_CONTACT, ss.Status.UNEXPLAINED, ss.Status.INCOMPLETE, ss.Status.OK])
        frames = np.tile(FINGER.read(ss.LineLoad(40.0, 0.2, 0.3e-3)), (4, 1))
        frames[0] = 0.0
        frames[1, ::2] *= -3.0
        frames[2, 1:] = np.nan
        found = slip(FINGER.locate(frames), 0.8)
        assert found.status.tolist() == status.tolist()
        numbers = (found.probability, found.margin, found.margin_std, found.ratio, found.normal, found.stick)
        for values in numbers:
            assert np.isnan(values).tolist() == [True, True, True, False]
        assert np.isnan(found.ratio_interval[:3]).all()
        assert np.isnan(found.stick_interval[:3]).all()
        assert found.verdict.tolist() == [SlipVerdict.CANNOT_TELL] * 3 + [SlipVerdict.HOLDS]
        assert slip(FINGER.fit(frames, "hertz"), 0.8).verdict[-1] == SlipVerdict.HOLDS

    def test_an_infinite_error_is_no_number(self):
        made = estimate(20.0, 5.0)
        table = made.table.copy()
        table[LINE.covariance + 5] = np.inf
        found = slip(ss.Estimate(table, made.used, made.friction), 0.5)
        assert np.isnan(found.probability)
        assert found.verdict == SlipVerdict.CANNOT_TELL

    def test_verdicts_and_thresholds(self):
        made = estimate(20.0, [5.0, 9.9, 10.1, 12.0])
        assert slip(made, 0.5).verdict.tolist() == [0, 1, 2, 2]
        assert slip(made, 0.5, thresholds=(0.45, 0.99)).verdict.tolist() == [0, 0 if _p(made, 1) < 0.45 else 1, 1, 2]
        unsure = estimate(20.0, 5.0, status=ss.Status.AMBIGUOUS)
        found = slip(unsure, 0.5)
        assert found.verdict == SlipVerdict.CANNOT_TELL
        assert found.probability == pytest.approx(slip(estimate(20.0, 5.0), 0.5).probability)

    def test_nothing_given_is_changed_and_nothing_returned_can_be(self):
        made = estimate([20.0, 20.0], 5.0)
        before = made.table.copy()
        found = slip(made, 0.5)
        np.testing.assert_array_equal(made.table, before)
        for name in ("probability", "margin", "verdict", "at_edge", "ratio_interval", "stick"):
            assert not getattr(found, name).flags.writeable, name


def _p(made, index):
    return float(slip(made, 0.5).probability[index])

    def test_what_another_load_would_have(self):
        made = estimate([20.0, 25.0], [5.0, 9.0], (0.5, 0.2, 0.3))
        judged = slip(made, Friction.between([0.3, 0.4], 0.6))
        assert judged.probability_at(1, 25.0, 9.0) == pytest.approx(judged.probability[1], rel=1e-9)
        assert judged.covariance[0] == pytest.approx(np.array([[0.5, 0.2], [0.2, 0.3]]), rel=1e-9)
        grid = judged.probability_at((1,), np.full((2, 3), 20.0), [4.0, 9.0, 14.0])
        assert grid.shape == (2, 3)
        one = slip(estimate(20.0, [4.0, 9.0, 14.0], (0.5, 0.2, 0.3)), Friction.between(0.4, 0.6))
        assert grid[1] == pytest.approx(one.probability, rel=1e-9)


class TestOwnCone:
    """An estimator keeps |T| <= cone N itself: what lies on that edge may be steeper."""

    def test_where_friction_might_hold_more_nothing_is_told(self):
        steep = ss.LineLoad(40.0, np.arctan(1.1), 0.3e-3)
        frame = FINGER.read(steep)
        found = FINGER.locate(frame, friction=0.7, false_alarm=1e-300)  # made to accept what it cannot explain
        assert np.tan(found.angle) == pytest.approx(0.7, rel=1e-9)
        judged = slip(found, 0.9)
        assert judged.at_edge
        assert judged.verdict == SlipVerdict.CANNOT_TELL
        assert np.isnan(judged.probability)
        assert np.isnan(judged.margin)
        # no friction of up to 0.6 holds what is 0.7 or steeper
        judged = slip(found, Friction.between(0.4, 0.6))
        assert judged.at_edge
        assert judged.probability > 0.5
        assert judged.verdict == SlipVerdict.SLIPS

    def test_a_wide_cone_sees_the_load(self):
        frame = FINGER.read(ss.LineLoad(40.0, np.arctan(1.1), 0.3e-3))
        judged = slip(FINGER.locate(frame, friction=2.0), 0.9)
        assert not judged.at_edge
        assert judged.verdict == SlipVerdict.SLIPS
        assert judged.ratio == pytest.approx(1.1 / 0.9, rel=1e-4)

    def test_an_angle_that_was_not_measured(self):
        frame = FINGER.read(ss.LineLoad(40.0, 0.0, 0.3e-3))
        for judged in (
            slip(FINGER.locate(frame, friction=0.0), 0.5),
            slip(FINGER.fit(frame, "line", friction=0.0), 0.5),
        ):
            assert np.isnan(judged.probability)
            assert judged.verdict == SlipVerdict.CANNOT_TELL


class TestIntervals:
    def test_ratio(self):
        """N without error, T normal, mu known: |T| / (mu N) is normal."""
        found = slip(estimate(20.0, [6.0, -8.0], (1e-18, 0.0, 0.09)), 0.5)
        wanted = np.array([0.6, 0.8])[:, None] + 1.959964 * 0.3 / 10.0 * np.array([-1, 1])
        assert found.ratio_interval == pytest.approx(wanted, rel=1e-6)
        assert found.stick_interval == pytest.approx(np.sqrt(1 - wanted[:, ::-1]), rel=1e-6)

    def test_friction_alone(self):
        found = slip(estimate(20.0, 6.0, (1e-20, 0.0, 1e-20)), Friction.between(0.4, 0.8))
        mu = 0.4 + 0.4 * np.array([0.975, 0.025])
        assert found.ratio_interval == pytest.approx(0.3 / mu, rel=1e-6)

    def test_holds_the_ratio_and_closes_on_it(self):
        wide, narrow = (slip(estimate(20.0, 8.0, (v, 0.0, v)), 0.5) for v in (0.5, 1e-12))
        for found in (wide, narrow):
            low, high = found.ratio_interval
            assert low < found.ratio < high
        assert narrow.ratio_interval == pytest.approx([0.8, 0.8], rel=1e-4)


class TestStick:
    SHARE = np.array([0.0, 0.3, 0.75, 1.2])

    @pytest.mark.parametrize(
        ("contact", "wanted"),
        [
            ("hertz", [1.0, np.sqrt(0.7), 0.5, 0.0]),
            ("wedge", [1.0, 0.7, 0.25, 0.0]),
            ("punch", [1.0, 1.0, 1.0, 0.0]),
            ("line", [np.nan] * 4),
        ],
    )
    def test_closed_forms(self, contact, wanted):
        found = slip(estimate(20.0, 10.0 * self.SHARE, (1e-20, 0.0, 1e-20)), 0.5, contact=contact)
        assert found.stick == pytest.approx(wanted, rel=1e-9, nan_ok=True)

    @pytest.mark.parametrize(
        ("contact", "body"), [("hertz", ss.pressing.Sphere(radius=8e-3)), ("wedge", ss.pressing.ConeTip(slope=0.15))]
    )
    def test_on_an_area_it_is_that_of_a_ball_and_of_a_cone(self, contact, body):
        """T = .6 mu N: .4^(1/3) beneath a ball, .4^(1/2) beneath a cone, and so says the solver."""
        half = ss.HalfSpace(ss.Material(young=0.4e6))
        pad = ss.Finger(half, ss.SensorArray.grid((4, 4), 3e-3, depth=3e-3, noise=1e-6))
        press = ss.PointLoad(components=[0.3, 0.6 * 0.15 * 0.6, 0.6 * 0.15 * 0.8], position=(1e-3, 0.0))
        found = pad.locate(pad.read(press))
        law, solved = slip(found, 0.5, contact=contact), slip(found, 0.5, skin=half, indenter=body)
        assert law.stick == pytest.approx(0.4 ** (1 / 3 if contact == "hertz" else 1 / 2), abs=1e-3)
        assert solved.stick == pytest.approx(law.stick, abs=4e-3)

    def test_it_is_that_of_the_contact_class(self):
        touch = ss.PartialSlip(force=40.0, angle=0.3, half_width=0.6e-3, friction=0.6)
        found = slip(estimate(float(touch.normal_force), float(touch.tangential_force)), 0.6)
        assert found.stick * 0.6e-3 == pytest.approx(float(touch.stick_half_width), rel=1e-9)

    def test_two_drags_of_a_row_are_two_loads_and_no_vector(self):
        skin, body = FINGER.skin, ss.pressing.Cylinder(8e-3)
        both = stick_zone(skin, body, 30.0, [4.0, 8.0], 0.5)
        assert both == pytest.approx([float(stick_zone(skin, body, 30.0, drag, 0.5)) for drag in (4.0, 8.0)])

    def test_the_drag_of_a_ball_has_two_components(self):
        half, ball = ss.HalfSpace(ss.Material(young=0.4e6)), ss.pressing.Sphere(8e-3)
        turned = stick_zone(half, ball, 1.0, [[0.3, 0.0], [0.0, 0.3]], 0.5)
        assert turned == pytest.approx(0.4 ** (1 / 3), abs=0.01)
        with pytest.raises(ss.SubskinError, match="two components"):
            stick_zone(half, ball, 1.0, 0.3, 0.5)

    def test_what_does_not_press_has_none(self):
        skin, body = FINGER.skin, ss.pressing.Cylinder(8e-3)
        found = stick_zone(skin, body, [20.0, 0.0, np.nan, 20.0], [12.0, 0.0, 1.0, np.nan], 0.5)
        assert found == pytest.approx([0.0, np.nan, np.nan, np.nan], nan_ok=True)


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda: slip(np.zeros(3), 0.5), "Finger.locate or Finger.fit"),
        (lambda: slip(estimate(20.0, 5.0), -0.5), "friction"),
        (lambda: slip(estimate(20.0, 5.0), 0.5, contact="strip"), '"hertz", "line", "punch" or "wedge"'),
        (lambda: slip(estimate(20.0, 5.0), 0.5, skin=FINGER.skin), "needs both"),
        (lambda: slip(estimate(20.0, 5.0), 0.5, skin=FINGER.skin, indenter=ss.pressing.Sphere(8e-3)), "of a row"),
        (lambda: slip(estimate(20.0, 5.0), 0.5, thresholds=(0.5, 0.1)), "ascending"),
        (lambda: slip(estimate(20.0, 5.0), 0.5, thresholds=0.5), "two probabilities"),
        (lambda: slip(estimate([20.0, 20.0], 5.0), Friction.known([0.4, 0.5, 0.6])), "frictions of shape"),
        (lambda: slip(estimate(20.0, 5.0), Friction.known([0.4, 0.5])), "frictions of shape"),
        (lambda: stick_zone(FINGER.skin, ss.pressing.Cylinder(8e-3), 20.0, 5.0, 0.0), "friction"),
    ],
)
def test_what_cannot_be_asked(call, words):
    with pytest.raises(ss.SubskinError, match=words):
        call()


def test_the_margin_varies_as_draws_of_load_and_friction_do():
    """Of mu N, both uncertain: std(mu)^2 (N^2 + var N) is in it, the square of both errors too."""
    mu, square = Friction.between(0.1, 0.9), np.array([[16.0, 2.0], [2.0, 1.0]])
    found = slip(estimate(6.0, 2.0, (16.0, 2.0, 1.0)), mu)
    rng = np.random.default_rng(0)
    n, t = rng.multivariate_normal([6.0, 2.0], square, 1_000_000).T
    assert found.margin_std == pytest.approx(np.std(rng.uniform(0.1, 0.9, n.size) * n - t), rel=5e-3)


@pytest.mark.parametrize("tangential", [-14.0, 8.0, 11.0])
def test_four_wide_cells_are_the_integral_over_friction(tangential):
    """z is bent over cells as wide as these, by what N's error adds with mu: the bend is summed too."""
    low, high, nn, nt, tt = 0.2, 0.9, 4.0, -0.5, 1.0

    def beyond(mu):
        sides = (tangential, nt), (-tangential, -nt)
        return sum(norm.cdf((t - 20 * mu) / np.sqrt(tt - 2 * mu * c + mu**2 * nn)) for t, c in sides)

    mean = quad(beyond, low, high, epsabs=1e-12)[0] / (high - low)
    found = slip(estimate(20.0, tangential, (nn, nt, tt)), Friction.between(low, high, cells=4))
    assert found.probability == pytest.approx(mean, abs=3e-4)
