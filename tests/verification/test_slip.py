"""Probabilities of slip against frequencies, stick zones against the contact solver, learning against what is true."""

from __future__ import annotations

import numpy as np
import pytest

import subskin as ss
from subskin.decide import Friction, least_force, slip, stick_zone

DEPTH = 2e-3
RUBBER = ss.Material(0.4e6)
HALF = ss.HalfPlane(RUBBER)
STIFF = RUBBER.plane_strain_modulus
NOISE = 1e-3
WIDE = 3.0
"""Cone of the estimators: far outside all loads and frictions here."""


def finger(count=6, noise=NOISE):
    return ss.Finger(HALF, ss.SensorArray.line(count, pitch=0.75 * DEPTH, depth=DEPTH, noise=noise))


def loads(rng, count, steepest=1.1):
    """Normal forces, and tangential ones whose share of them is anything, chosen without knowing the friction."""
    normal = rng.uniform(25.0, 45.0, count)
    return normal, normal * rng.uniform(-steepest, steepest, count)


def touch(kind, normal, tangential, position, **more):
    return kind(np.hypot(normal, tangential), np.arctan2(tangential, normal), position, **more)


def assert_reliable(stated, happened, width=4.0):
    """In each bin of stated probability, as many as were stated; and some bins to speak of."""
    bins = np.quantile(stated, np.linspace(0, 1, 13))
    which = np.clip(np.searchsorted(bins, stated) - 1, 0, 11)
    for k in range(12):
        here = which == k
        p = stated[here]
        error = np.sqrt((p * (1 - p)).sum()) / here.sum()
        assert abs(happened[here].mean() - p.mean()) < width * error + 1e-3, (k, p.mean(), happened[here].mean())
    assert stated.std() > 0.3


def test_probability_against_random_draws():
    """Readings' errors and the friction drawn at random around given estimates: how often is |T| > mu N?"""
    rng = np.random.default_rng(0)
    tip = finger(4, noise=3e-3)
    normal, tangential = loads(rng, 40, 0.9)
    found = tip.locate(
        tip.read(touch(ss.LineLoad, normal, tangential, rng.uniform(-2e-3, 2e-3, 40)), rng), friction=np.inf
    )
    found_ok = np.flatnonzero(found.status <= ss.Status.AMBIGUOUS)
    assert found_ok.size > 25
    draws = 60_000
    for friction in (Friction.known(0.5), Friction.between(0.3, 0.8), Friction.normal(0.5, 0.08)):
        judged = slip(found, friction)
        mu = friction.quantile(rng.uniform(size=draws))
        checked = 0
        for i in found_ok[np.isfinite(judged.probability[found_ok])]:
            # force and angle, turned into N and T as the linear part of the estimate's own error
            f, a = float(found.force[i]), float(found.angle[i])
            df, da = rng.multivariate_normal([0, 0], found.covariance[i, 1:3, 1:3], draws).T
            n = f * np.cos(a) + df * np.cos(a) - f * da * np.sin(a)
            t = f * np.sin(a) + df * np.sin(a) + f * da * np.cos(a)
            p = float(judged.probability[i])
            share = (np.abs(t) > mu * n).mean()
            assert abs(share - p) < 4.5 * np.sqrt(p * (1 - p) / draws) + 1e-5
            checked += 0.01 < p < 0.99
        assert checked > 8


def test_margin_against_random_draws():
    rng = np.random.default_rng(1)
    tip = finger()
    found = tip.locate(tip.read(ss.LineLoad(40.0, 0.35, 0.4e-3), rng))
    friction = Friction.between(0.4, 0.7)
    judged = slip(found, friction)
    draws = 400_000
    f, a = float(found.force), float(found.angle)
    df, da = rng.multivariate_normal([0, 0], found.covariance[1:3, 1:3], draws).T
    n = (f + df) * np.cos(a) - f * da * np.sin(a)
    t = (f + df) * np.sin(a) + f * da * np.cos(a)
    margin = friction.quantile(rng.uniform(size=draws)) * n - t
    assert judged.margin == pytest.approx(margin.mean(), abs=4 * margin.std() / np.sqrt(draws))
    assert judged.margin_std == pytest.approx(margin.std(), rel=0.01)
    low, high = np.quantile(t / (friction.quantile(rng.uniform(size=draws)) * n), [0.025, 0.975])
    assert judged.ratio_interval == pytest.approx([low, high], rel=5e-3)


@pytest.mark.parametrize("friction", [0.6, Friction.between(0.4, 0.8)], ids=["known", "range"])
def test_located_touches_slip_as_often_as_stated(friction):
    """From readings to the stated probability, the truth being a load and a friction that nobody told."""
    rng = np.random.default_rng(2)
    tip, count = finger(), 20_000
    normal, tangential = loads(rng, count)
    position = rng.uniform(-2.5e-3, 2.5e-3, count)
    mu = (Friction.known(friction) if isinstance(friction, float) else friction).quantile(rng.uniform(size=count))
    found = tip.locate(tip.read(touch(ss.LineLoad, normal, tangential, position), rng), friction=WIDE)
    judged = slip(found, friction)
    ok = found.status == ss.Status.OK
    assert ok.mean() > 0.95
    assert_reliable(judged.probability[ok], (np.abs(tangential) > mu * normal)[ok])


def test_fitted_touches_slip_as_often_as_stated():
    rng = np.random.default_rng(3)
    tip, count = finger(8), 4000
    normal, tangential = loads(rng, count)
    position, a = rng.uniform(-2e-3, 2e-3, count), rng.uniform(0.3, 0.9, count) * DEPTH
    friction = Friction.between(0.4, 0.8)
    mu = friction.quantile(rng.uniform(size=count))
    frames = tip.read(touch(ss.Hertz, normal, tangential, position, half_width=a), rng)
    found = tip.fit(frames, "hertz", friction=WIDE)
    judged = slip(found, friction)
    ok = found.status == ss.Status.OK
    assert ok.mean() > 0.9
    assert_reliable(judged.probability[ok], (np.abs(tangential) > mu * normal)[ok])


@pytest.mark.parametrize("bound", [0.2, 0.02])
def test_the_least_force_slips_as_often_as_it_is_allowed_to(bound):
    """A hand that presses harder by what is missing, from readings alone; friction known as a range."""
    rng = np.random.default_rng(4)
    tip, count = finger(noise=3e-4), 12_000
    normal, tangential = loads(rng, count, 0.9)
    friction = Friction.between(0.4, 0.8, cells=32)
    mu = friction.quantile(rng.uniform(size=count))
    position = rng.uniform(-2.5e-3, 2.5e-3, count)
    found = tip.locate(tip.read(touch(ss.LineLoad, normal, tangential, position), rng), friction=WIDE)
    ok = found.status == ss.Status.OK
    raised = normal + least_force(found, friction, bound) - found.force * np.cos(found.angle)
    # |T| is not below 0: near there loads are not spread evenly about what is felt, and fewer slip than may
    ok &= np.abs(tangential) > 8.0
    share = (np.abs(tangential) > mu * raised)[ok].mean()
    assert share == pytest.approx(bound, abs=4 * np.sqrt(bound * (1 - bound) / ok.sum()))


def test_friction_learned_from_slips_and_holds_is_as_sure_as_it_says():
    """Loads tried without knowing mu: some hold, some slide at T = mu N. What is learned has its quantiles right."""
    rng = np.random.default_rng(5)
    tip, hands, tries = finger(noise=4e-4), 1500, 4
    mu = rng.uniform(0.3, 0.9, hands)
    normal, tangential = loads(rng, (hands, tries), steepest=1.2)
    slides = np.abs(tangential) > mu[:, None] * normal
    felt = np.where(slides, np.sign(tangential) * mu[:, None] * normal, tangential)
    frames = tip.read(touch(ss.LineLoad, normal, felt, rng.uniform(-2e-3, 2e-3, (hands, tries))), rng)
    missing = np.full_like(frames, np.nan)
    # of loads up to 1.2 N a share of 1 - mu / 1.2 slides: how many did is known, and goes into what is known before
    steepest, flat = 1.2, Friction.between(0.3, 0.9, cells=192)
    centres = np.asarray(flat.edges)[:-1] + 0.5 * np.diff(flat.edges)
    prior = Friction(flat.edges, (steepest - centres) ** slides.sum(axis=1, keepdims=True))
    learned = prior.updated(
        slips=tip.locate(np.where(slides[..., None], frames, missing), friction=WIDE),
        holds=tip.locate(np.where(slides[..., None], missing, frames), friction=WIDE),
    )
    shares = np.linspace(0.05, 0.95, 10)
    below = (mu[:, None] < learned.quantile(shares)).mean(axis=0)
    assert below == pytest.approx(shares, abs=4 * np.sqrt(0.25 / hands))
    assert np.median(learned.std) < 0.3 * float(flat.std)


BODIES = {
    "hertz": (ss.pressing.Cylinder(8e-3), 3e-3),
    "wedge": (ss.pressing.RoundedWedge(0.1), 4e-3),
    "punch": (ss.pressing.RoundedFlat(1e-3), 3e-3),
}


class TestStick:
    """First pressed, then dragged, at nu = 1/2: the stick zone is the contact zone of N - |T|/mu."""

    MU, FORCE, NODES = 0.5, 30.0, 512
    SHARES = np.array([0.0, 0.2, -0.5, 0.8])

    @pytest.mark.parametrize("contact", BODIES)
    def test_closed_forms_against_the_solver(self, contact):
        body, accuracy = BODIES[contact]
        drags = self.SHARES * self.MU * self.FORCE
        solved = stick_zone(HALF, body, self.FORCE, drags, self.MU, nodes=self.NODES)
        share = np.abs(self.SHARES)
        wanted = {"hertz": np.sqrt(1 - share), "wedge": 1 - share, "punch": np.ones(4)}[contact]
        assert solved == pytest.approx(wanted, abs=accuracy)
        assert stick_zone(HALF, body, self.FORCE, 1.1 * self.MU * self.FORCE, self.MU) == 0

    def test_slip_asks_the_solver(self):
        tip = finger(8, noise=1e-6)
        wedge = ss.pressing.RoundedWedge(0.1, tip_radius=4e-3)
        touches = ss.LineLoad(np.hypot(30.0, [4.0, 9.0]), np.arctan2([4.0, 9.0], 30.0), 0.2e-3)
        frames = np.vstack([tip.read(touches), np.zeros((1, 8))])
        found = tip.locate(frames)
        judged = slip(found, 0.5, skin=HALF, indenter=wedge)
        # the contact zone of N - |T|/mu, solved without any friction
        widths = [ss.press(HALF, wedge, force=n).half_width for n in (30.0, 30.0 - 8.0, 30.0 - 18.0)]
        assert judged.stick[:2] == pytest.approx([widths[1] / widths[0], widths[2] / widths[0]], abs=4e-3)
        assert np.isnan(judged.stick[2])
        low, high = judged.stick_interval[:2].T
        assert (low <= judged.stick[:2] + 4e-3).all()
        assert (high >= judged.stick[:2] - 4e-3).all()
        round_body = slip(found, 0.5)
        assert (np.abs(judged.stick[:2] - round_body.stick[:2]) > 0.02).all()

    def test_on_a_thin_layer_the_zone_is_another(self):
        """No closed form: pressing slips by itself there, and the order of press and drag matters."""
        layer, body, load = (ss.Layered(ss.Layer(RUBBER, 1e-3)), ss.pressing.Cylinder(8e-3), {"force": self.FORCE})
        drags = np.array([2.0, 6.0, 10.0, 14.0])
        solved = stick_zone(layer, body, self.FORCE, drags, self.MU, nodes=256)
        assert (np.diff(solved) < 0).all()
        assert np.abs(solved - np.sqrt(1 - drags / 15.0)).max() > 0.03

        def share(state):
            return np.diff(state.stick).sum() / (2 * state.half_width)

        state = pressed = ss.press(layer, body, **load, friction=self.MU, nodes=256)
        for drag in (0.5, 1.0, 2.0):
            state = ss.press(layer, body, **load, friction=self.MU, tangential=drag, after=state)
        whole = ss.press(layer, body, **load, friction=self.MU, tangential=2.0, after=pressed)
        at_once = ss.press(layer, body, **load, friction=self.MU, tangential=2.0, nodes=256)
        assert solved[0] == pytest.approx(share(whole), rel=1e-9)
        assert solved[0] == pytest.approx(share(state), abs=0.01)
        assert abs(solved[0] - share(at_once)) > 0.05
