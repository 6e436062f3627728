"""Ends of what is sought: of positions, of the normal force, and of unknowns where no reading is to spare."""

from __future__ import annotations

import numpy as np
import pytest

import subskin as ss

FULL_SCALE = 3 / (2 * np.pi)
SKIN = ss.HalfPlane(ss.Material(1.0))
PITCH = 0.75
OK, AMBIGUOUS, NO_CONTACT, UNEXPLAINED = (
    ss.Status.OK,
    ss.Status.AMBIGUOUS,
    ss.Status.NO_CONTACT,
    ss.Status.UNEXPLAINED,
)


def row(count, noise):
    return ss.Finger(SKIN, ss.SensorArray.line(count, PITCH, 1.0, noise=noise * FULL_SCALE))


FINGERS = {(n, noise): row(n, noise) for n in (4, 6, 8) for noise in (1e-3, 1e-2)}


def loads(tip, count, low, high, rng):
    """Lines beside the row by `low` to `high`, which may be inside it."""
    half = 0.5 * np.ptp(tip.array.y)
    y = rng.choice([-1, 1], count) * (half + rng.uniform(low, high, count))
    return ss.LineLoad(10 ** rng.uniform(-0.5, 1, count), rng.uniform(-0.75, 0.75, count), y)


def wrong(found, load):
    off = np.abs(found.position - load.position)
    return (found.status == OK) & ((off > 5 * found.std[:, 0]) | (off > 0.3))


def explained(a, w, mu):
    """Chi-square explained by responses a (..., n, 2), forces in the cone: by the normal equations, and its edges."""
    b, g = np.einsum("...nk,...n->...k", a, w), np.einsum("...nk,...nl->...kl", a, a)
    theta = np.linalg.solve(g, b[..., None])[..., 0]
    inside = (theta[..., 0] > 0) & (np.abs(theta[..., 1]) <= mu * theta[..., 0])
    edges = [(np.maximum(b @ e, 0) ** 2) / np.einsum("k,...kl,l->...", e, g, e) for e in ([1, mu], [1, -mu])]
    return np.where(inside, np.sum(b * theta, axis=-1), np.maximum(*edges))


@pytest.mark.parametrize("case", FINGERS, ids=str)
def test_a_load_beyond_the_row_is_not_taken_for_one_within(case):
    tip, rng = FINGERS[case], np.random.default_rng(0)
    for low, high in ((1.6, 4.0), (4.0, 8.0)):
        load = loads(tip, 3000, low, high, rng)
        assert wrong(tip.locate(tip.read(load, rng)), load).mean() < 0.003  # 0.01 to 0.07 without a look beyond
    inside = loads(tip, 3000, -0.375 * (case[0] - 1), 0.0, rng)
    found = tip.locate(tip.read(inside, rng))
    stated = (-0.375 * (case[0] - 1) - 1.5, 0.375 * (case[0] - 1) + 1.5)
    believed = tip.locate(tip.read(inside, rng), search=stated)
    assert (found.status == OK).mean() > {4: 0.94, 6: 0.998, 8: 0.998}[case[0]]
    assert abs((found.status == OK).mean() - (believed.status == OK).mean()) < 0.02


@pytest.mark.parametrize("family", ["hertz", "punch"])
def test_nor_by_a_fit(family):
    rng = np.random.default_rng(1)
    for tip in (FINGERS[4, 1e-3], FINGERS[8, 1e-2]):
        load = loads(tip, 150, 1.6, 4.0, rng)
        assert not wrong(tip.fit(tip.read(load, rng), family), load).any()


def test_no_end_of_the_search_comes_near_an_answer_that_is_ok():
    """Chi-square at the ends by an independent sum; with a stated search, which is believed beyond them."""
    tip, rng, ends = FINGERS[6, 1e-2], np.random.default_rng(2), (-2.2, 2.2)
    readings = tip.read(loads(tip, 4000, -0.8, 0.6, rng), rng)
    found = tip.locate(readings, search=ends)
    w = readings / tip.array.noise
    at_end = np.max([explained(tip.receptive_field(y) / tip.array.noise[:, None], w, 1.0) for y in ends], axis=0)
    gap = (w**2).sum(axis=1) - found.residual - at_end
    sure = found.status == OK
    assert (gap[sure] > 13.8).all()
    near = np.isfinite(found.position) & (gap < 13.8) & (np.abs(found.position) < 2.15)
    assert near.sum() > 100
    assert (found.status[near] == AMBIGUOUS).all()


@pytest.mark.parametrize(("thickness", "kind"), [(1.25, ss.NormalStrain), (4.0, ss.transducer.ShearStrain)])
def test_in_a_layer_where_readings_turn_quickly_with_the_distance(thickness, kind):
    """Loads far beside the row by an independent sum, wherever chi-square has its tops there."""
    skin = ss.Layered(ss.Layer(ss.Material(1.0), thickness))
    tip = ss.Finger(skin, ss.SensorArray.line(4, PITCH, 1.0, noise=1e-3, transducer=kind()))
    rng, half = np.random.default_rng(0), 1.5 * PITCH
    y = rng.choice([-1, 1], 2000) * (half + rng.uniform(1.4, 5.0, 2000))
    readings = tip.read(ss.LineLoad(10 ** rng.uniform(0, 3, 2000), rng.uniform(-0.75, 0.75, 2000), y), rng)
    found, w = tip.locate(readings, load="line"), readings / 1e-3
    far = np.linspace(1.5, 8.0, 160)
    top = np.max([explained(tip.receptive_field(s * (half + d)) / 1e-3, w, 1.0) for s in (-1, 1) for d in far], axis=0)
    sure = found.status == OK
    assert sure.sum() > 10
    assert ((w**2).sum(axis=1) - found.residual - top)[sure].min() > 13.8


def test_nor_with_any_half_width():
    tip, rng, ends = FINGERS[6, 1e-2], np.random.default_rng(3), (-2.2, 2.2)
    readings = tip.read(loads(tip, 150, -0.8, 0.3, rng), rng)
    found = tip.fit(readings, "hertz", search=ends)
    locator, w = tip.locator("hertz", search=ends), readings / tip.array.noise
    widths = 1.5 * np.sqrt(np.linspace(0, 1, 200))
    at_end = np.full(len(w), -np.inf)
    for y in ends:
        fields = locator.response(np.full(widths.size, y), widths) / tip.array.noise[:, None]
        at_end = np.maximum(at_end, explained(fields[:, None], w, 1.0).max(axis=0))
    gap = (w**2).sum(axis=1) - found.residual - at_end
    sure, given = found.status == OK, np.isfinite(found.position)
    assert (gap[sure] > 13.8).all()
    assert (given & (gap < 13.7) & (np.abs(found.position) < 2.15)).sum() > 10


def test_beyond_ends_where_a_round_finger_comes_back():
    skin = ss.Round(ss.Material(0.4e6), 8e-3, 4e-3)
    part, whole = (ss.Finger(skin, ss.SensorArray.line(4, pitch, 2e-3, noise=1e-6)) for pitch in (7e-3, 15e-3))
    assert part.locator()._beyond.stop == pytest.approx(0.5 * skin.period - 1.5 * 7e-3)
    assert whole.locator()._beyond is None  # the search goes all the way about it


def least(tip, readings, force, mu):
    """Chi-square of the best load with its normal force in a range, by brute force."""
    w = readings / tip.array.noise
    best = np.inf
    for a in tip.receptive_field(np.linspace(tip.array.y.min() - 1.5, tip.array.y.max() + 1.5, 500)):
        a = a / tip.array.noise[:, None]
        n = np.linspace(*force, 100)
        t = np.clip(((w - np.outer(n, a[:, 0])) @ a[:, 1]) / (a[:, 1] @ a[:, 1]), -mu * n, mu * n)
        left = w - np.outer(n, a[:, 0]) - np.outer(t, a[:, 1])
        best = min(best, (left**2).sum(axis=1).min())
    return best


class TestNormalForce:
    """A range in which the normal force is known to be."""

    @pytest.mark.parametrize("mu", [0.6, 1.0])
    def test_the_best_within_the_range_is_found(self, mu):
        tip, rng = row(5, 0.05), np.random.default_rng(4)
        touch = ss.LineLoad(rng.uniform(0.7, 3, 6), rng.uniform(-0.6, 0.6, 6), rng.uniform(-1.5, 1.5, 6))
        frames = tip.read(touch, rng)
        for force in ((1.2, 1.8), (0.0, 1.0), (2.0, 2.5)):
            found = tip.locate(frames, normal_force=force, friction=mu, false_alarm=1e-300)
            brute = np.array([least(tip, frame, force, mu) for frame in frames])
            assert (found.residual < brute + 1e-6).all()
            assert found.residual == pytest.approx(brute, rel=0.02, abs=0.05)  # what its grid leaves
            at = np.isfinite(found.position)
            n, t = found.components[at].T
            assert ((force[0] <= n) & (n <= force[1])).all()
            assert (np.abs(t) <= mu * n * (1 + 1e-12)).all()
            ends = (n == force[0]) & (force[0] > 0) | (n == force[1])
            assert ends.any()
            assert (found.status[at][ends] == AMBIGUOUS).all()

    def test_a_range_that_holds_the_force_changes_nothing(self):
        tip, rng = FINGERS[6, 1e-3], np.random.default_rng(5)
        frames = tip.read(ss.LineLoad(1.0, rng.uniform(-0.5, 0.5, 300), rng.uniform(-1.5, 1.5, 300)), rng)
        free, bound = tip.locate(frames), tip.locate(frames, normal_force=(0.3, 3.0))
        assert (bound.status == OK).all()
        assert bound.table[:, :3] == pytest.approx(free.table[:, :3], abs=1e-9)
        assert bound.std == pytest.approx(free.std, rel=1e-4)
        wide = [tip.fit(frames[:20], **more) for more in ({}, {"normal_force": (0.3, 3.0)})]
        assert wide[1].position == pytest.approx(wide[0].position, abs=1e-6)

    def test_a_rival_out_of_range_is_none(self):
        tip, rng = row(3, 1e-3), np.random.default_rng(6)
        frames = tip.read(ss.LineLoad(1 / np.cos(0.2), 0.2, rng.uniform(-0.7, 0.7, 500)), rng)
        free, bound = tip.locate(frames), tip.locate(frames, normal_force=(0.9, 1.1))
        alone = [(found.second.chi2 > 13.8).sum() for found in (bound, free)]
        assert alone[0] > alone[1] + 50

    def test_wrong_models_are_unexplained_more_often(self):
        tip, rng = FINGERS[4, 1e-2], np.random.default_rng(7)
        y = rng.uniform(-1, 1, 500)
        frames = tip.measure(ss.LineLoad(3.0, np.pi / 2 - 1e-9, y)) + tip.array.noise * rng.standard_normal((500, 4))
        free, bound = tip.locate(frames), tip.locate(frames, normal_force=(0.5, 2.0))
        assert (bound.status == OK).sum() < 0.5 * (free.status == OK).sum()

    def test_nothing_is_nothing(self):
        tip, rng = FINGERS[4, 1e-2], np.random.default_rng(8)
        frames = tip.array.noise * rng.standard_normal((3000, 4))
        status = tip.locate(frames, normal_force=(1.0, 2.0)).status
        assert (status == NO_CONTACT).all()

    @pytest.mark.parametrize("force", [(2.0, 1.0), (-1.0, 1.0), (1.0, 1.0), (1.0, float("nan"))])
    def test_a_range_that_is_none_is_refused(self, force):
        with pytest.raises(ss.errors.InvalidValueError, match="normal_force"):
            FINGERS[4, 1e-3].locate(np.zeros(4), normal_force=force)


class TestNoSpareReading:
    """`fit` with as many readings as unknowns: the cone, pressing and the widths' ends can still object."""

    tip = row(4, 1e-3)

    def test_nonsense_is_unexplained(self):
        roller = ss.Hertz(np.ones(20), 0.2, np.linspace(-1, 1, 20), half_width=0.6)
        pulled = self.tip.fit(-self.tip.read(roller))
        assert (pulled.status == UNEXPLAINED).mean() > 0.7  # 0 without a threshold
        assert (pulled.residual[pulled.status == UNEXPLAINED] > 20).all()
        skin = ss.HalfPlane(ss.Material(0.4e6))
        finger = ss.Finger(skin, ss.SensorArray.line(4, 1.5e-3, 2e-3, noise=1e-4))
        found = finger.fit([0.02, -0.02, 0.02, -0.02])
        assert found.status == UNEXPLAINED
        assert found.residual > 1e5
        five = ss.Finger(skin, ss.SensorArray.line(5, 1.5e-3, 2e-3, noise=1e-4))
        assert five.fit([0.02, -0.02, np.nan, 0.02, -0.02]).status == UNEXPLAINED
        random = finger.fit(0.02 * np.random.default_rng(0).standard_normal((100, 4)))
        assert not (random.residual[np.isfinite(random.position)] > 24).any()

    def test_a_right_model_stays_explained(self):
        """The chance is that of chi-square with one degree of freedom, where one end binds."""
        rng, alarm = np.random.default_rng(9), 0.02
        angle = np.full(600, np.pi / 4)  # on the edge of the cone
        touch = ss.Hertz(np.ones(600), angle, rng.uniform(-1, 1, 600), half_width=0.5)
        inside = ss.Hertz(np.ones(600), 0.2, rng.uniform(-1, 1, 600), half_width=0.5)
        edge = (self.tip.fit(self.tip.read(touch, rng), false_alarm=alarm).status == UNEXPLAINED).mean()
        assert 0.001 < edge < 1.5 * alarm
        assert (self.tip.fit(self.tip.read(inside, rng), false_alarm=alarm).status == UNEXPLAINED).mean() < 0.5 * alarm
