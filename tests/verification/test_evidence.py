"""The evidence of a kind against the integral it stands for, and its probabilities against how often they come true."""

import itertools

import numpy as np
import pytest

import subskin as ss
from subskin.decide import Kind, contact_type, usual_kinds

FULL_SCALE = 3 / (2 * np.pi)
CLASSES = {"line": ss.LineLoad, "wedge": ss.Wedge, "punch": ss.FlatPunch, "hertz": ss.Hertz}
SMALL = (Kind("vertex", "wedge", (0.1, 0.35)), Kind("round side", "hertz", (0.5, 1.2)))
ALL = (Kind("line", "line"), SMALL[0], Kind("flat side", "punch", (0.5, 1.2)), SMALL[1])


def finger(count, pitch, noise):
    array = ss.SensorArray.line(count, pitch=pitch, depth=1.0, noise=noise * FULL_SCALE)
    return ss.Finger(ss.HalfPlane(ss.Material(young=1.0)), array)


def simulated(tip, kinds, count, seed):
    """Readings of touches drawn from the prior, and the numbers of their kinds."""
    rng = np.random.default_rng(seed)
    half = float(np.asarray(tip.array.y).max())
    truth = np.arange(count) % len(kinds)
    readings = np.empty((count, len(tip.array)))
    for i, kind in enumerate(kinds):
        chosen = truth == i
        size = int(chosen.sum())
        load = {"force": np.ones(size), "position": rng.uniform(-half, half, size)}
        load["angle"] = rng.uniform(-np.pi / 4, np.pi / 4, size)
        if kind.half_width[1]:
            load["half_width"] = rng.uniform(*kind.half_width, size)
        readings[chosen] = tip.read(CLASSES[kind.family](**load), rng)
    return readings, truth


def unit_readings(tip, kind, positions, widths, angles):
    """Whitened readings of unit forces, (angles, positions, n), and their squares' sum, for each half width."""
    noise = np.asarray(tip.array.noise)
    for a in widths:
        more = {"half_width": a} if kind.half_width[1] else {}
        columns = [
            tip.read(CLASSES[kind.family](force=1.0, angle=angle, position=positions, **more)) / noise
            for angle in (0.0, np.pi / 2)
        ]
        unit = np.cos(angles)[:, None, None] * columns[0] + np.sin(angles)[:, None, None] * columns[1]
        yield unit, (unit**2).sum(-1)


def integral(tip, units, frame, positions, widths, angles, span=None):
    """log of the likelihood's average over the prior, up to what all kinds share: plain sums over place, half width
    and angle; the force is integrated by Laplace's method, which is exact to its relative error squared.
    """
    w = frame / np.asarray(tip.array.noise)
    high = []
    for unit, square in units:
        along = unit @ w
        force = np.maximum(along, 1e-300) / square
        log = np.where(along > 0, 0.5 * along * force + 0.5 * np.log(2 * np.pi / square) - np.log(force), -np.inf)
        top = log.max()
        high.append(top + np.log(np.exp(log - top).sum()))
    high = np.array(high)
    mean = np.exp(high - high.max())
    mean = np.trapezoid(mean, widths) / (widths[-1] - widths[0]) if len(widths) > 1 else mean[0]
    return high.max() + np.log(mean) + np.log((positions[1] - positions[0]) * (span or angles[1] - angles[0]))


@pytest.mark.long
def test_evidence_is_the_integral_where_readings_tell_little():
    """Four sensors, noise of 1 %: place and width known to a tenth of a depth, several places possible."""
    tip = finger(4, 0.8, 1e-2)
    half = float(np.asarray(tip.array.y).max())
    readings, _ = simulated(tip, SMALL, 30, seed=3)
    said = contact_type(tip, readings, SMALL, search=(-half, half))
    positions, angles = np.linspace(-half, half, 241), np.linspace(-np.pi / 4, np.pi / 4, 241)
    widths = [np.linspace(*k.half_width, 21) for k in SMALL]
    units = [list(unit_readings(tip, k, positions, w, angles)) for k, w in zip(SMALL, widths, strict=True)]
    compared = []
    for frame, evidence in zip(readings, said.log_evidence, strict=True):
        exact = np.array([integral(tip, u, frame, positions, w, angles) for u, w in zip(units, widths, strict=True)])
        if np.isfinite(evidence).all() and abs(exact[0] - exact[1]) < 9:
            compared.append([evidence[0] - evidence[1], exact[0] - exact[1]])
    ours, theirs = np.array(compared).T
    assert ours.size >= 12
    close = np.abs(theirs) < 5  # where it matters: the lesser kind's probability is above 0.7 %
    assert close.sum() >= 6
    assert np.abs(ours - theirs)[close].max() < 0.05
    assert np.abs(ours - theirs).max() < 0.5
    assert np.abs(1 / (1 + np.exp(ours)) - 1 / (1 + np.exp(theirs))).max() < 0.01


def test_evidence_is_the_integral_where_readings_tell_much():
    """Noise of 0.01 %: the other branch, Gaussian in place and forces; fine sums about the best place.

    Four readings are explained by all three families, with forces that differ by a quarter.
    """
    tip = finger(4, 0.5, 1e-4)
    kinds = tuple(Kind(n, n, (0.02, 1.2)) for n in ("wedge", "punch", "hertz"))
    touch = ss.Hertz(1.0, 0.3, -0.3, half_width=0.7)
    frame = tip.read(touch, np.random.default_rng(0))
    said = contact_type(tip, frame, kinds, search=(-0.75, 0.75))
    exact = []
    for k in kinds:
        best = tip.fit(frame, k.family, search=(-0.75, 0.75), half_width=k.half_width)
        position, lean, width = (
            np.linspace(value - reach * std, value + reach * std, count)
            for value, std, reach, count in (
                (float(best.position), float(best.std[0]), 7, 161),
                (float(best.angle), float(best.std[2]), 7, 161),
                (float(best.half_width), float(best.std[3]), 8, 61),
            )
        )
        share = (width[-1] - width[0]) / (k.half_width[1] - k.half_width[0])
        units = unit_readings(tip, k, position, width, lean)
        exact.append(integral(tip, units, frame, position, width, lean) + np.log(share))
    np.testing.assert_allclose(np.diff(said.log_evidence), np.diff(exact), atol=0.01)
    assert np.ptp(exact) > 1


@pytest.mark.parametrize("noise", [1e-2, 3e-4])
def test_evidence_without_friction(noise):
    """Place, width and normal force are all that is unknown; sums over the three, in both branches."""
    tip = finger(4, 0.8, noise)
    kinds = (Kind("round", "hertz", (0.1, 0.9)), Kind("flat", "punch", (0.1, 0.9)))
    frame = tip.read(ss.Hertz(1.0, 0.0, 0.3, half_width=0.5), np.random.default_rng(1))
    said = contact_type(tip, frame, kinds, search=(-1.2, 1.2), friction=0.0)
    exact = []
    for kind in kinds:
        best = tip.fit(frame, kind.family, search=(-1.2, 1.2), half_width=kind.half_width, friction=0.0)
        y, a = float(best.position), float(best.half_width)
        positions = np.linspace(y - 8 * float(best.std[0]), y + 8 * float(best.std[0]), 301)
        spread = 8 * float(best.std[3])
        widths = np.linspace(max(a - spread, 0.1), min(a + spread, 0.9), 201)
        share = (widths[-1] - widths[0]) / 0.8
        units = unit_readings(tip, kind, positions, widths, np.zeros(2))
        exact.append(integral(tip, units, frame, positions, widths, np.zeros(2), 1.0) + np.log(share))
    assert np.diff(said.log_evidence) == pytest.approx(np.diff(exact), abs=0.03)


def test_a_wide_range_is_the_mean_of_narrow_ones():
    """A kind of the half widths of a side is the sum of kinds of narrow ranges, each with its share."""
    tip = finger(6, 0.5, 3e-3)
    rng = np.random.default_rng(0)
    for half_width in (0.45, 2.0):
        frame = tip.read(ss.Hertz(1.0, 0.3, 0.2, half_width=half_width), rng)
        edges = np.linspace(0.4, 2.4, 41)
        bins = [Kind(f"{a:.2f}", "hertz", (a, b)) for a, b in itertools.pairwise(edges)]
        said = contact_type(tip, frame, [Kind("whole", "hertz", (0.4, 2.4)), *bins])
        expected = np.log(np.exp(said.log_evidence[1:]).mean())
        assert said.log_evidence[0] == pytest.approx(expected, abs=0.05)


def test_none_of_these_is_a_kind_with_more_noise():
    """The evidence of fingers that are noisier by the model error, worked out by themselves."""
    tip = finger(6, 0.5, 1e-3)
    frame = tip.read(ss.LineLoad(1.0, 0.3, 0.2)) * [1.0, 1.0, 1.02, 1.0, 0.98, 1.0]
    both = (Kind("line", "line"), Kind("far from it", "punch", (2.0, 2.2)))
    said = contact_type(tip, frame, (*both, Kind("none", "none")), false_alarm=1e-9)
    chi2 = float(said.table[2])
    assert said.log_evidence[1] < said.log_evidence[0] - 30
    square = np.sum((frame / np.asarray(tip.array.noise)) ** 2) / 6
    each = []
    for error in (0.01, 0.03, 0.1, 0.3):
        noisier = 1 + error**2 * square
        alone = contact_type(finger(6, 0.5, 1e-3 * np.sqrt(noisier)), frame, both).table
        each.append(alone[1] - 0.5 * alone[2] + 0.5 * chi2 - 3 * np.log(noisier))
    # the mean of two kinds; a quarter of its prior, the rest being shapes that are excluded here
    expected = np.log(np.mean(np.exp(np.array(each) - max(each)))) + max(each) - np.log(2) - np.log(4)
    assert said.log_evidence[2] == pytest.approx(expected, abs=0.1)
    assert chi2 > 10


def test_two_touches_against_a_plain_sum():
    """Midpoint and half distance on a grid; the four forces, far within their cones, by a Gaussian integral at each."""
    tip = finger(8, 0.5, 2e-3)
    frame = tip.read(ss.LineLoad(1.0, 0.2, -0.6)) + tip.read(ss.LineLoad(0.8, -0.1, 0.5))
    frame += np.asarray(tip.array.noise) * np.random.default_rng(0).standard_normal(8)
    kinds = (Kind("line", "line"), Kind("far from it", "punch", (2.0, 2.2)), Kind("two", "pair", (0.25, 1.5)))
    ends = (-2.25, 2.25)
    said = contact_type(tip, frame, kinds, search=ends)
    column = 1 + 2 * 6
    position, half = said.table[column + 2], said.table[column + 5]
    sigma = np.asarray(tip.array.noise)
    w = frame / sigma
    grid = np.linspace(-0.12, 0.12, 97)
    high = []
    for h in half + grid:
        y = position + grid
        a = np.concatenate([tip.receptive_field(y - h), tip.receptive_field(y + h)], -1) / sigma[:, None]
        g, b = np.einsum("mni,mnj->mij", a, a), np.einsum("mni,n->mi", a, w)
        f = np.linalg.solve(g, b[..., None])[..., 0]
        one, two = np.hypot(f[:, 0], f[:, 1]), np.hypot(f[:, 2], f[:, 3])
        log = 0.5 * (b * f).sum(-1) - 0.5 * np.linalg.slogdet(g)[1] + 2 * np.log(2 * np.pi)
        # alike: shares of the force, its logarithm, both angles (one range is common to all kinds), half distances
        prior = -2 * np.log(one + two) - np.log(one * two) - np.log(np.pi / 2) - np.log(1.25) - np.log(1 - 2 * h / 4.5)
        high.append(log + prior)
    high = np.array(high)
    step = grid[1] - grid[0]
    exact = high.max() + np.log(np.exp(high - high.max()).sum() * step**2)
    explained = (w**2).sum() - min(said.table[2], said.table[8])  # of one contact, off which all evidence is counted
    assert said.log_evidence[2] == pytest.approx(exact - 0.5 * explained, abs=0.15)


def calibration_error(top, right, bins=15):
    group = np.minimum((top * bins).astype(int), bins - 1)
    return sum(abs(top[group == b].mean() - right[group == b].mean()) * (group == b).mean() for b in np.unique(group))


@pytest.mark.parametrize(
    ("kinds", "count", "pitch", "noise", "least"),
    [
        (SMALL, 4, 0.35, 1e-2, 0.995),  # the memo's claim
        (SMALL, 4, 1.0, 1e-2, 0.88),  # wider apart they tell less, and say so
        (ALL, 5, 0.5, 1e-3, 0.94),
        (ALL, 6, 0.5, 1e-3, 0.95),
        (ALL, 6, 0.5, 1e-4, 0.99),
    ],
)
def test_right_as_often_as_it_says(kinds, count, pitch, noise, least):
    """Bayes's rule is the best that any method can do on touches drawn from the prior, if what it says comes true."""
    tip = finger(count, pitch, noise)
    half = float(np.asarray(tip.array.y).max())
    readings, truth = simulated(tip, kinds, 4000, seed=count)
    said = contact_type(tip, readings, kinds, search=(-half, half))
    top, right = np.nan_to_num(said.probability.max(-1)), said.best == truth
    assert right.mean() > least - 2 * np.sqrt(least * (1 - least) / 4000)
    assert calibration_error(top, right) < 0.02
    assert abs(top.mean() - right.mean()) < 3 * np.sqrt(max((top * (1 - top)).mean(), 1e-4) / 4000)
    decided = said.decision >= 0
    assert (said.decision[decided] != truth[decided]).mean() < 0.01


def test_usual_kinds_are_right_and_seldom_sure_and_wrong():
    """Named contacts: as often right as they say. Others: a named kind, surely, in at most a twentieth."""
    tip = finger(6, 0.5, 1e-3)
    readings, truth = simulated(tip, ALL, 1600, seed=8)
    said = contact_type(tip, readings)
    right = said.best == truth
    assert right.mean() > 0.97
    assert calibration_error(said.probability.max(-1), right) < 0.02
    rng = np.random.default_rng(0)
    load = {"force": np.ones(300), "angle": rng.uniform(-0.7, 0.7, 300), "position": rng.uniform(-1.2, 1.2, 300)}
    width = rng.uniform(0.5, 1.5, 300)
    moment = rng.uniform(0.4, 1.0, 300) * np.cos(load["angle"]) * width / 2
    soft = ss.Finger(ss.HalfPlane(ss.Material(young=1.0, poisson=0.4)), tip.array)
    others = {
        "tilted": tip.read(ss.FlatPunch(**load, half_width=width, moment=moment)),
        "wide": tip.read(ss.Hertz(**load, half_width=rng.uniform(2.4, 3.5, 300))),
        "two": tip.read(ss.LineLoad(**load)) + tip.read(ss.LineLoad(0.6, -load["angle"], -load["position"] + 0.2)),
        "soft": soft.read(ss.LineLoad(**load)),
    }
    noise = np.asarray(tip.array.noise)
    four = usual_kinds(tip)[:4] + usual_kinds(tip)[5:]  # two touches are not among them
    for name, frames in others.items():
        said = contact_type(tip, frames + noise * rng.standard_normal(frames.shape), four)
        named = (said.decision >= 0) & (said.decision < 4)
        if name == "wide":
            named &= said.decision != 3  # a side, though wider than it ends
        assert named.mean() < 0.05, name
