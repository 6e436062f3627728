"""Fits of a contact of some width: exact readings, statistics against the Cramer-Rao bound, what cannot be told."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pytest
from scipy.special import jv

import subskin as ss
from subskin.contact import SpreadContact, families

DEPTH = 2e-3
RUBBER = ss.Material(0.4e6)
SKINS = {
    "half plane": ss.HalfPlane(RUBBER),
    "layer": ss.Layered(ss.Layer(ss.Material(0.4e6, 0.45), 2 * DEPTH)),
    "round": ss.Round(RUBBER, 8e-3, 4e-3),
}
FAMILIES = {name: family for name, family in families().items() if name != "line"}
NOISE = 2e-5


def finger(count=6, skin=SKINS["half plane"], **more):
    return ss.Finger(skin, ss.SensorArray.line(count, pitch=0.5 * DEPTH, depth=DEPTH, **{"noise": NOISE, **more}))


def chi2(tip, reading, contact):
    return float((((reading - tip.read(contact)) / np.asarray(tip.array.noise)) ** 2).sum())


@dataclass(frozen=True, eq=False)
class Soft(SpreadContact):
    """A family of one's own: (8 N / (3 pi a)) (1 - y^2/a^2)^(3/2)."""

    SERIES = (1.0, 1 / 6, 1 / 16, 1 / 32)

    def unit_transform(self, z):
        a = self._a
        s = np.sqrt(z - a) * np.sqrt(z + a)
        w = a / (z + s)
        return -2 / a * (w - w**3 / 3), 2 / (a * s) * w * (1 - w**2)

    def unit_spectrum(self, k):
        s = np.maximum(k * self._a, 1e-4)
        return 8 * jv(2, s) / s**2

    def unit_pressure(self, y):
        return 8 / (3 * np.pi * self._a) * np.maximum(1 - (y / self._a) ** 2, 0) ** 1.5

    def singular_points(self):
        return ()


@pytest.mark.parametrize("skin", SKINS.values(), ids=SKINS)
@pytest.mark.parametrize("family", FAMILIES)
def test_exact_readings_give_the_contact_back(skin, family):
    tip = finger(skin=skin)
    rng = np.random.default_rng(3)
    y, angle = rng.uniform(-2e-3, 2e-3, 25), rng.uniform(-0.6, 0.6, 25)
    a = rng.uniform(0.3, 1.2, 25) * DEPTH
    found = tip.fit(tip.read(FAMILIES[family](40.0, angle, y, half_width=a)), family)
    assert (found.residual < 1e-3).all()
    # another minimum may fit exact readings as well: where it does, it is said
    sure = found.status == ss.Status.OK
    assert sure.mean() > 0.5
    assert np.abs(found.position - y)[sure] == pytest.approx(0.0, abs=1e-4 * DEPTH)
    assert found.half_width[sure] == pytest.approx(a[sure], abs=3e-4 * DEPTH)
    assert found.force[sure] == pytest.approx(40.0, rel=1e-3)
    assert found.angle[sure] == pytest.approx(angle[sure], abs=1e-3)


@pytest.mark.parametrize("family", ["wedge", "hertz"])
def test_errors_are_those_of_the_bound(family):
    """Against an information matrix of differences of the forward model, and against the scatter."""
    tip = finger()
    kind, a = FAMILIES[family], {"wedge": 0.3, "hertz": 0.8}[family] * DEPTH
    truth = np.array([0.3e-3, 40.0, 0.2, a])

    def read(p):
        return tip.read(kind(p[1], p[2], p[0], half_width=p[3]))

    steps = np.array([1e-6, 1e-3, 1e-5, 1e-6])
    columns = [(read(truth + h) - read(truth - h)) / (2 * h.sum()) for h in np.diag(steps)]
    jacobian = np.stack(columns, -1) / NOISE
    bound = np.linalg.inv(jacobian.T @ jacobian)
    frames = read(truth) + NOISE * np.random.default_rng(0).normal(size=(3000, 6))
    found = tip.fit(frames, family)
    assert (found.status == ss.Status.OK).mean() > 0.999
    assert np.sqrt(np.diag(tip.fit(read(truth), family).covariance)) == pytest.approx(np.sqrt(np.diag(bound)), rel=2e-3)
    values = np.stack([found.position, found.force, found.angle, found.half_width], -1)
    scaled = (values - truth) / np.sqrt(np.diag(bound))
    assert scaled.std(axis=0) == pytest.approx(np.ones(4), abs=0.04)
    low, high = found.half_width_interval.T
    assert ((low <= a) & (a <= high)).mean() == pytest.approx(0.95, abs=0.012)
    correlation = np.corrcoef(values.T)
    expected = bound / np.sqrt(np.outer(np.diag(bound), np.diag(bound)))
    assert correlation == pytest.approx(expected, abs=0.05)


def test_the_answer_fits_no_worse_than_the_truth():
    """Global: over the whole range of places and widths, the residual is that of the truth or less."""
    tip, rng = finger(), np.random.default_rng(5)
    y, angle, a = (rng.uniform(-2.5e-3, 2.5e-3, 600), rng.uniform(-0.7, 0.7, 600), rng.uniform(0.0, 1.5, 600) * DEPTH)
    for name, kind in FAMILIES.items():
        contact = kind(40.0, angle, y, half_width=np.maximum(a, 1e-9))
        frames = tip.read(contact, rng)
        truth = (((frames - tip.read(contact)) / NOISE) ** 2).sum(axis=1)
        assert (tip.fit(frames, name).residual < truth + 1e-3).all(), name


def test_a_narrow_width_shows_in_its_square_alone():
    tip = finger()
    frames = tip.read(ss.Hertz(40.0, 0.2, 0.3e-3, half_width=0.03 * DEPTH)) + NOISE * np.random.default_rng(1).normal(
        size=(500, 6)
    )
    found = tip.fit(frames, "hertz")
    low, high = found.half_width_interval.T
    assert (low == 0).mean() > 0.9
    assert ((high > 0.05 * DEPTH) & (high < 0.4 * DEPTH)).mean() > 0.9
    assert np.isfinite(found.std).all()
    assert found.position.std() == pytest.approx(np.median(found.std[:, 0]), rel=0.15)


def test_four_readings_for_four_unknowns_fit_everything():
    """Two presses at once are no cylinder: six sensors see that, four cannot."""
    two = ss.LineLoad(30.0, 0.3, -1.2e-3) + ss.LineLoad(20.0, -0.2, 0.9e-3)
    few, many = finger(4), finger(8)
    assert many.fit(many.read(two), "hertz").status == ss.Status.UNEXPLAINED
    with_four = few.fit(few.read(ss.Wedge(40.0, 0.2, 0.3e-3, half_width=0.7 * DEPTH)), "hertz")
    assert with_four.spare == 0
    assert with_four.status != ss.Status.UNEXPLAINED
    assert many.fit(many.read(two), "hertz").spare == 4


def test_the_rival_fits_as_well_as_it_says():
    tip, rng = finger(5), np.random.default_rng(2)
    y, angle, a = (rng.uniform(-2e-3, 2e-3, 600), rng.uniform(-0.7, 0.7, 600), rng.uniform(0.5, 1.2, 600) * DEPTH)
    frames = tip.read(ss.FlatPunch(40.0, angle, y, half_width=a), rng)
    found = tip.fit(frames, "punch")
    second = found.second
    some = np.flatnonzero((found.status == ss.Status.AMBIGUOUS) & (second.chi2 < 100))[:20]
    assert some.size > 5
    for i in some:
        rival = ss.FlatPunch(
            float(second.force[i]), float(second.angle[i]), float(second.position[i]),
            half_width=max(float(second.half_width[i]), 1e-9),
        )  # fmt: skip
        assert chi2(tip, frames[i], rival) - found.residual[i] == pytest.approx(second.chi2[i], abs=2e-3)


def test_a_family_of_ones_own():
    tip = finger()
    found = tip.fit(tip.read(Soft(40.0, 0.1, -0.5e-3, half_width=0.9 * DEPTH)), Soft)
    assert found.half_width == pytest.approx(0.9 * DEPTH, rel=1e-4)
    assert found.position == pytest.approx(-0.5e-3, abs=1e-7)


def test_lines_are_what_locate_finds():
    tip = finger()
    frames = tip.read(ss.LineLoad(40.0, 0.2, np.linspace(-2e-3, 2e-3, 50)), np.random.default_rng(0))
    line, located = tip.fit(frames, "line"), tip.locate(frames)
    assert line.position == pytest.approx(located.position, abs=1e-9)
    assert line.covariance[:, :3, :3] == pytest.approx(located.covariance, rel=0.05)
    assert (line.half_width == 0).all()


def test_missing_sensors_and_shapes():
    tip = finger(6)
    frames = np.tile(tip.read(ss.Hertz(40.0, 0.2, 0.3e-3, half_width=DEPTH)), (2, 3, 1))
    frames[0, 1, 2] = np.nan
    frames[1, 2, :3] = np.nan
    frames[1, 1] = 0.0
    found = tip.fit(frames, "hertz")
    assert found.shape == (2, 3)
    assert found.status.tolist() == [[0, 0, 0], [0, ss.Status.NO_CONTACT, ss.Status.INCOMPLETE]]
    assert found.half_width[0, 1] == pytest.approx(DEPTH, rel=1e-3)
    assert found.spare.tolist() == [[2, 1, 2], [2, 2, 0]]
    assert found.covariance.shape == (2, 3, 4, 4)


def test_without_friction_there_is_no_angle_to_be_unsure_of():
    """The bound on place, force and width is that of three unknowns."""
    tip = finger()
    truth = np.array([0.3e-3, 40.0, 0.8 * DEPTH])

    def read(p):
        return tip.read(ss.Hertz(p[1], 0.0, p[0], half_width=p[2]))

    steps = np.array([1e-6, 1e-3, 1e-6])
    columns = [(read(truth + h) - read(truth - h)) / (2 * h.sum()) for h in np.diag(steps)]
    jacobian = np.stack(columns, -1) / NOISE
    bound = np.sqrt(np.diag(np.linalg.inv(jacobian.T @ jacobian)))
    found = tip.fit(read(truth), "hertz", friction=0.0)
    assert found.std[[0, 1, 3]] == pytest.approx(bound, rel=2e-3)
    assert found.std[2] == 0
    assert (tip.fit(read(truth), "hertz").std[[0, 3]] > 1.01 * bound[[0, 2]]).any()


def test_a_known_width_and_no_friction():
    tip = finger(4)
    frame = tip.read(ss.Hertz(40.0, 0.0, 0.3e-3, half_width=DEPTH))
    known = tip.fit(frame, "hertz", half_width=(DEPTH, DEPTH), friction=0.0)
    assert known.unknowns == 2
    assert known.spare == 2
    assert known.force == pytest.approx(40.0, rel=1e-6)
    assert known.std[3] == 0
    wider = tip.read(ss.Hertz(40.0, 0.0, 0.3e-3, half_width=0.601 * DEPTH))
    bounded = tip.fit(wider, "hertz", half_width=(0.2 * DEPTH, 0.6 * DEPTH))
    assert bounded.half_width == pytest.approx(0.6 * DEPTH, rel=1e-6)
    assert bounded.status == ss.Status.AMBIGUOUS


def test_an_answer_at_the_edge_of_the_search_is_not_sure():
    tip = finger(8)
    for touch, options in (
        (ss.Hertz(40.0, 0.1, 0.3e-3, half_width=DEPTH), {"half_width": (0.0, 0.99 * DEPTH)}),
        (ss.Hertz(40.0, 0.1, 0.3e-3, half_width=0.5 * DEPTH), {"half_width": (0.51 * DEPTH, DEPTH)}),
        (ss.Hertz(40.0, 0.55, 0.3e-3, half_width=0.8 * DEPTH), {"friction": 0.6}),
    ):
        found = tip.fit(tip.read(touch), "hertz", false_alarm=1e-300, **options)
        assert found.status == ss.Status.AMBIGUOUS
    line = tip.fit(tip.read(ss.LineLoad(40.0, 0.1, 0.3e-3)), "hertz")  # no width at all is an answer
    assert line.status == ss.Status.OK


@pytest.mark.parametrize(
    ("call", "words"),
    [
        ({"family": "sphere"}, '"hertz", "line", "punch", "strip" or "wedge"'),
        ({"family": 3}, "subclass of SpreadContact"),
        ({"family": "hertz", "half_width": (2e-3, 1e-3)}, "ascending"),
        ({"family": "hertz", "half_width": (-1e-3, 1e-3)}, "width"),
        ({"family": "line", "half_width": (0.0, 1e-3)}, "it has none"),
        ({"family": "hertz", "friction": -1.0}, "friction"),
        ({"family": "hertz", "search": 1e-3}, "two ascending"),
        ({"family": "hertz", "search": (-3.0, 3.0)}, "in metres"),
        ({"family": "hertz", "half_width": (0.0, 4.1 * DEPTH)}, "4 depths"),
        ({"family": "hertz", "half_width": (0.0, 3.0)}, "4 depths"),
        ({"family": "hertz", "search": "ab"}, "two ascending"),
        ({"family": "hertz", "half_width": 1e-3}, "two ascending"),
    ],
)
def test_what_cannot_be_asked(call, words):
    tip = finger()
    with pytest.raises(ss.SubskinError, match=words):
        tip.fit(np.zeros(6), **call)
    with pytest.raises(ss.errors.GeometryError, match="6 sensors"):
        tip.fit(np.zeros(5), "hertz")
    with pytest.raises(ss.errors.InvalidValueError, match="noise = 0"):
        finger(noise=0.0).fit(np.zeros(6), "hertz")


def test_fewer_sensors_than_unknowns_are_too_few():
    for count in (1, 2, 3):
        array = ss.SensorArray.line(count, pitch=DEPTH / 2, depth=DEPTH, noise=NOISE)
        tip = ss.Finger(ss.HalfPlane(ss.Material(young=0.4e6)), array)
        frame = tip.read(ss.Hertz(40.0, 0.1, 0.0, half_width=DEPTH))
        assert tip.fit(frame, "hertz").status == ss.Status.INCOMPLETE
        assert ss.decide.contact_type(tip, frame).status == ss.Status.INCOMPLETE
        if count < 3:
            assert tip.locate(frame).status == ss.Status.INCOMPLETE


def test_contacts_of_up_to_four_depths_are_found():
    tip = finger(10)
    rng = np.random.default_rng(0)
    a, y = rng.uniform(0.5 * DEPTH, 3.5 * DEPTH, 200), rng.uniform(-DEPTH, DEPTH, 200)
    frames = tip.read(ss.Hertz(np.full(200, 40.0), 0.2, y, half_width=a), rng)
    found = tip.fit(frames, "hertz", half_width=(0.0, 4 * DEPTH))
    sure = found.status == ss.Status.OK
    assert sure.mean() > 0.9
    assert (np.abs(found.half_width - a)[sure] < 5 * found.std[sure, 3]).mean() > 0.97
