"""Placement foretold from readings free of noise, against `finger.locate` on noisy ones and the forward model alone."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.special import ndtr

import subskin as ss
from subskin.design import Touches, placement_quality
from subskin.design.placement import Channel, study_at_depth

FULL_SCALE = 3 / (2 * np.pi)  # |strain| one depth beneath a unit normal line load, E = 1
PLANE = ss.HalfPlane(ss.Material(young=1.0))
TOUCH = Touches(force=1.0)
FRAMES = 30


def rows(skin, kind, depth, pitches, counts, touches, *, noise, width=0.0, **options):
    return study_at_depth(skin, Channel(kind, noise, width), depth, pitches, counts, touches, **options)


def row(count, pitch, noise, skin=PLANE, kind=None, depth=1.0):
    array = ss.SensorArray.line(count, pitch, depth, transducer=kind or ss.NormalStrain(), noise=noise * FULL_SCALE)
    return ss.Finger(skin, array)


def odd():
    """Free places and depths, a dead sensor, gains and noises of their own, two kinds, one of them wide."""
    array = ss.SensorArray(
        y=[-1.7, -0.8, 0.1, 0.5, 1.6, 2.1],
        depth=[1.0, 1.1, 0.9, 1.0, 1.2, 1.0],
        transducer=[ss.NormalStrain()] * 4 + [ss.MeanPressure()] * 2,
        gain=[1.0, 2.0, -1.0, 0.0, 1.0, 3.0],
        offset=0.01,
        noise=[0.02, 0.04, 0.02, 0.01, 0.03, 0.05],
        width=[0.0, 0.3, 0.0, 0.0, 0.0, 0.0],
    )
    return ss.Finger(PLANE, array)


FINGERS = {
    "three": (row(3, 1.0, 1e-3), 0.012),
    "three, close": (row(3, 0.5, 1e-3), 0.035),
    "four, noisy": (row(4, 1.0, 1e-2), 0.006),
    "four, very close": (row(4, 0.3, 1e-3), 0.01),
    "six, far apart": (row(6, 2.0, 1e-3), 0.006),
    "six, far apart and noisy": (row(6, 1.5, 1e-2), 0.012),
    "odd": (odd(), 0.015),
    "layer": (row(4, 1.5, 3e-3, ss.Layered(ss.Layer(ss.Material(1.0), 3.0))), 0.006),
    "round": (row(4, 1.8, 3e-3, ss.Round(ss.Material(1.0), 5.0, 2.5)), 0.006),
    "pressure": (row(4, 2.0, 2e-2, kind=ss.MeanPressure()), 0.025),
}


def foretold_and_found(finger, touches=TOUCH, grid=(61, 31), rng=None, **options):
    """Quality; and how often `locate` says so, in `FRAMES` noisy frames of each touch."""
    rng = rng or np.random.default_rng(0)
    quality = placement_quality(finger, touches, grid=grid, **options)
    measured = finger.measure(ss.LineLoad(touches.force, quality.angle, quality.position[:, None]))
    frames = finger.array.digitise(np.repeat(measured[..., None, :], FRAMES, -2), rng)
    found = finger.locate(frames, load="line", search=quality.search, friction=touches.friction)
    return quality, found


@pytest.mark.parametrize("name", FINGERS)
def test_locate_is_as_often_unsure_as_foretold(name):
    finger, off = FINGERS[name]
    quality, found = foretold_and_found(finger)
    often = (found.status == ss.Status.AMBIGUOUS).mean(-1)
    if len(finger.array) == 3:  # no reading to spare: what is foretold is how often another load explains as well
        often = (found.second.chi2 < 13.8).mean(-1)
    # what is random of the mean of so many frames, and what the formula leaves out (docs/placement.md)
    random = 4 * np.sqrt(0.25 / found.status.size)
    assert abs(quality.ambiguous.mean() - often.mean()) < off + random
    silent = (found.status == ss.Status.NO_CONTACT).mean(-1)
    assert abs(quality.unfelt.mean() - silent.mean()) < 0.002 + random


def test_faint_touches_are_as_often_unfelt_as_foretold():
    quality, found = foretold_and_found(row(4, 3.0, 0.1))
    silent = (found.status == ss.Status.NO_CONTACT).mean(-1)
    assert 0.2 < silent.mean() < 0.8
    np.testing.assert_allclose(quality.unfelt.mean(), silent.mean(), atol=0.012)
    for low, high in ((0.02, 0.2), (0.2, 0.5), (0.5, 0.8), (0.8, 0.98)):
        some = (quality.unfelt > low) & (quality.unfelt < high)
        assert some.sum() > 30
        np.testing.assert_allclose(quality.unfelt[some].mean(), silent[some].mean(), atol=0.04)


def test_at_the_end_of_the_search_touches_are_ambiguous():
    """Every second one is foretold; `locate` calls all of them so, for the end itself explains them nearly as well."""
    quality, found = foretold_and_found(row(5, 0.8, 1e-2), margin=0.0)
    often = (found.status == ss.Status.AMBIGUOUS).mean(-1)
    assert 0.45 < quality.ambiguous[[0, -1]].mean() < 0.6
    assert often[[0, -1]].mean() > 0.95
    assert quality.ambiguous[20:40].max() < 0.01


def test_the_worst_touch_does_not_hang_on_the_grid():
    """Followed uphill; and four sensors under a wide span are blind at single touches, which no grid hits."""
    for finger in (row(5, 0.8, 1e-3), row(8, 1.7, 1e-3)):
        worst = [placement_quality(finger, TOUCH, grid=grid)["position_worst"] for grid in ((90, 40), (401, 161))]
        rough = placement_quality(finger, TOUCH, grid=(401, 161))
        y = float(rough.position[rough.std["position"].max(axis=1).argmax()])
        span = max(y - 0.02, rough.position[0]), min(y + 0.02, rough.position[-1])
        fine = placement_quality(finger, Touches(1.0, span=span), grid=(401, 641)).std["position"].max()
        np.testing.assert_allclose(worst[0], worst[1], rtol=1e-4)
        assert fine <= worst[1] * (1 + 1e-6) < 1.001 * fine
    wide = placement_quality(row(4, 0.85, 1e-3), Touches(1.0, span=(-2.0, 2.0)), grid=(100, 40))
    assert np.isfinite(wide.std["position"]).all()
    assert np.isinf(wide["position_worst"])


def test_quantile_and_mean_are_those_of_the_maps():
    quality = placement_quality(row(3, 0.8, 1e-2), TOUCH, grid=(201, 101))
    weight = np.ones((201, 101))
    weight[[0, -1]] *= 0.5
    weight[:, [0, -1]] *= 0.5
    for name, std, unknown in (
        ("position", quality.std["position"], 1.6 / np.sqrt(12)),
        ("angle", quality.std["angle"], np.pi / 4 / np.sqrt(3)),
        ("force", quality.std["force"], 1.0),
    ):
        below = np.average(std <= quality[f"{name}_95"], weights=weight)
        assert 0.95 <= below < 0.9503
        assert (std > unknown).any()
        mean = np.average(np.where(std < unknown, std, unknown), weights=weight)
        np.testing.assert_allclose(quality[f"{name}_mean"], mean, rtol=1e-12)


def test_a_rival_elsewhere_is_ambiguous_and_wrong_as_often_as_foretold():
    """Where a rival is neither near nor tied, both probabilities are told touch by touch."""
    quality, found = foretold_and_found(row(4, 2.0, 1e-3), grid=(301, 31))
    sharp = 6 * quality.std["position"] < 0.1
    error = np.abs(found.position - quality.position[:, None, None])
    for foretold, said in ((quality.ambiguous, found.status == ss.Status.AMBIGUOUS), (quality.wrong, error > 0.1)):
        for low, high in ((1e-6, 0.05), (0.05, 0.2), (0.2, 0.45), (0.55, 0.95)):
            some = sharp & (foretold > low) & (foretold < high)
            if foretold is quality.wrong and low > 0.5:
                continue  # one rival is at best as good as the truth
            assert some.sum() > 20
            spread = 4 * np.sqrt(0.25 / (some.sum() * FRAMES))
            np.testing.assert_allclose(foretold[some].mean(), said[some].mean(), atol=0.015 + spread)


@pytest.mark.parametrize(("count", "pitch"), [(3, 0.5), (4, 0.4), (4, 2.0), (6, 2.0)])
def test_no_rival_is_overlooked(count, pitch):
    """The rival that `locate` finds in readings free of noise makes as many ambiguous as its chi-square says."""
    finger = row(count, pitch, 1e-3)
    quality = placement_quality(finger, TOUCH, grid=(101, 41))
    load = ss.LineLoad(1.0, quality.angle, quality.position[:, None])
    rival = finger.locate(finger.read(load), search=quality.search).second
    distance = np.sqrt(np.clip(rival.chi2, 1e-12, 1e6))  # infinite where there is none
    chance = ndtr((13.8 - distance**2) / (2 * distance)) - ndtr((-13.8 - distance**2) / (2 * distance))
    sharp = 6 * quality.std["position"] < 0.1  # not where the profile is flat: there `locate` sees minima by rounding
    assert (chance[sharp] > 0.5).sum() > 20
    assert (quality.ambiguous > chance - 0.02)[sharp].mean() > 0.9985


@pytest.mark.parametrize("name", ["four, noisy", "odd", "layer", "round"])
@pytest.mark.parametrize("friction", [1.0, 0.0])
def test_bounds_are_those_of_the_forward_model(name, friction):
    finger = FINGERS[name][0]
    touches = Touches(2.0, friction, span=(-1.5, 1.4))
    quality = placement_quality(finger, touches, grid=(11, 5))
    y, angle, h = quality.position[:, None], quality.angle, 1e-4

    def read(dy=0.0, df=0.0, da=0.0):
        return finger.read(ss.LineLoad(2.0 * (1 + df), angle + da, y + dy))

    steps = ("dy", "df", "da") if friction else ("dy", "df")
    columns = [(read(**{s: h}) - read(**{s: -h})) / (2 * h) for s in steps]
    live = finger.array.live
    jacobian = np.stack(columns, -1)[..., live, :] / np.asarray(finger.array.noise)[live, None]
    fisher = np.einsum("...ni,...nj->...ij", jacobian, jacobian)
    std = np.sqrt(np.diagonal(np.linalg.inv(fisher), axis1=-2, axis2=-1))
    np.testing.assert_allclose(quality.std["position"], std[..., 0], rtol=1e-4)
    np.testing.assert_allclose(quality.std["force"], std[..., 1], rtol=1e-4)
    if friction:
        np.testing.assert_allclose(quality.std["angle"], std[..., 2], rtol=1e-4)
        weight = np.ones((11, 5))
        weight[[0, -1]] *= 0.5
        weight[:, [0, -1]] *= 0.5
        log_det = np.average(np.log(np.linalg.det(fisher)), weights=weight)
        np.testing.assert_allclose(quality["log_det"], log_det, atol=1e-4)
    else:
        assert (quality.std["angle"] == 0).all()


@pytest.mark.parametrize("pitch", [0.4, 0.7, 1.0, np.sqrt(3), 2.3])
def test_three_sensors_do_not_tell_a_normal_touch_in_the_middle(pitch):
    """det J = 0 there at every spacing; and at spacings of 1 and sqrt(3) depths at every angle of it.

    At a spacing of one depth it is the angle that is not told: only the middle sensor feels it, and not to first order.
    """
    quality = placement_quality(row(3, pitch, 1e-3), TOUCH, grid=(21, 11))
    middle = (quality.std["angle"] if pitch == 1.0 else quality.std["position"])[10]
    assert np.isinf(middle[5])
    if pitch in (1.0, np.sqrt(3)):
        assert np.isinf(middle).all()
    else:
        assert (np.delete(middle, 5) < 1).all()


def test_a_row_is_judged_alike_alone_and_in_a_study():
    """One sensor's field shifted, or the finger's own table: in a half plane, and round a finger."""
    for skin in (PLANE, ss.Round(ss.Material(1.0), 5.0, 2.5)):
        finger = row(5, 0.8, 1e-3, skin)
        finger = replace(finger, array=replace(finger.array, width=0.4))
        alone = placement_quality(finger, TOUCH, grid=(101, 41))
        study = rows(skin, ss.NormalStrain(), 1.0, [0.8], [5], TOUCH, noise=1e-3 * FULL_SCALE, width=0.4, samples=1)
        for name in ("position_worst", "position_95", "position_mean", "angle_worst", "force_95", "log_det"):
            np.testing.assert_allclose(study[name][0, 0], alone[name], rtol=1e-5)


def test_jittered_touches_come_to_the_same_as_random_ones():
    from subskin.design.placement._field import RowField

    finger = row(4, 1.5, 3e-3)
    study = rows(PLANE, ss.NormalStrain(), 1.0, [1.5], [4], TOUCH, noise=3e-3 * FULL_SCALE)
    load = TOUCH.sample(20_000, np.random.default_rng(3), finger)
    maps = RowField.of(finger, (-3.75, 3.75)).survey(TOUCH, load.position, load.angle[:, None], 13.8)
    for k, name in ((4, "ambiguous"), (5, "wrong")):
        spread = maps[k].std() / np.sqrt(maps[k].size)
        assert 0.005 < maps[k].mean()
        assert abs(maps[k].mean() - study[name][0, 0]) < 4 * spread


def test_lengths_scale():
    """Twice all lengths and twice the force: the same readings, and so twice the errors of place and nothing else."""
    small = rows(PLANE, ss.NormalStrain(), 1.0, [0.6, 1.6], [4], Touches(1.0, span=(-1, 1)), noise=1e-3, samples=2000)
    large = rows(PLANE, ss.NormalStrain(), 2.0, [1.2, 3.2], [4], Touches(2.0, span=(-2, 2)), noise=1e-3, samples=2000)
    for name in ("position_worst", "position_95", "position_mean"):
        np.testing.assert_allclose(large[name], 2 * small[name], rtol=1e-6)
    for name in ("angle_worst", "force_95", "ambiguous", "wrong"):
        np.testing.assert_allclose(large[name], small[name], rtol=1e-5)
    np.testing.assert_allclose(large["log_det"], small["log_det"] - 2 * np.log(2), rtol=1e-6)


def test_the_study_depends_on_the_seed():
    def study(seed):
        return rows(PLANE, ss.MeanPressure(), 1.0, [1.0, 2.0], [3, 4], TOUCH, noise=1e-2, samples=3000, rng=seed)

    one, again, other = study(4), study(4), study(5)
    for name, values in one.items():
        np.testing.assert_array_equal(values, again[name])
    assert (one["ambiguous"] != other["ambiguous"]).any()


def test_three_sensors_want_a_pitch_of_one_depth_sharply():
    """Loads within a depth of the middle, 45 degrees, noise of 0.5 % of full scale, looked for half a depth beyond."""
    found = rows(
        PLANE, ss.NormalStrain(), 1.0, [0.5, 0.9, 1.0, 1.1], [3], Touches(1.0, span=(-1, 1)),
        noise=5e-3 * FULL_SCALE, margin=0.5,
    )["ambiguous"][:, 0]  # fmt: skip
    np.testing.assert_allclose(found[0], 0.42, atol=0.01)  # the marks of the study that was asked for
    np.testing.assert_allclose(found[2], 0.009, atol=0.001)
    assert (found[[1, 3]] > 7 * found[2]).all()


def test_more_sensors_are_told_from_055_or_040_depths_on_and_less_than_twice_the_depth_is_too_far():
    found = rows(
        PLANE, ss.NormalStrain(), 1.0, [0.35, 0.4, 0.5, 0.55, 0.75, 1.0, 1.05, 2.0], [4, 5, 8],
        Touches(1.0, span=(-1, 1)), noise=5e-3 * FULL_SCALE, margin=0.5, samples=20_000,
    )  # fmt: skip
    unsure = found["ambiguous"]
    assert unsure[2, 0] > 0.005
    assert (unsure[3:7, 0] < 2e-4).all()
    assert unsure[0, 1] > 0.03
    assert (unsure[1:7, 1:] < 2e-4).all()
    worst = found["position_worst"]
    assert (worst[7] > 36 * worst[4]).all()
    assert (unsure[7] > 0.2).all()


def test_the_largest_determinant_is_not_the_best_position():
    """D-optimality alone: three sensors with a tenth of all touches ambiguous; six with the worst touch unseen."""
    pitches = np.arange(0.4, 1.6, 0.05)
    noise = 1e-3 * FULL_SCALE
    three = rows(PLANE, ss.NormalStrain(), 1.0, pitches, [3], TOUCH, noise=noise, margin=0.5, samples=5000)
    chosen, best = three["log_det"].argmax(), three["ambiguous"].argmin()
    assert abs(pitches[best] - 1) < 1e-9
    assert three["ambiguous"][chosen] > 0.08 > 50 * three["ambiguous"][best]
    six = rows(PLANE, ss.NormalStrain(), 1.0, pitches, [6], Touches(1.0, span=(-2, 2)), noise=noise, samples=5000)
    assert six["position_worst"][six["log_det"].argmax()] > 10 * six["position_worst"].min()


@pytest.mark.parametrize("kind", [ss.MeanPressure(), ss.NormalStrain()], ids=["pressure", "strain"])
def test_on_an_area_the_worst_touch_does_not_hang_on_the_grid(kind):
    """Of ten thousand touches drawn from the area and the cone none is worse, by a bound of derivatives."""
    unit = 1 / (2 * np.pi) if isinstance(kind, ss.MeanPressure) else FULL_SCALE
    array = ss.SensorArray.grid((3, 3), pitch=1.5, depth=1.0, transducer=kind, noise=1e-3 * unit)
    finger = ss.Finger(ss.HalfSpace(ss.Material(young=1.0)), array)
    touches = Touches(force=1.0, friction=0.5, area=((-2.0, 2.0), (-1.5, 1.5)))
    rough, fine = (placement_quality(finger, touches, grid=grid)["position_worst"] for grid in ((9, 6), (17, 10)))
    np.testing.assert_allclose(rough, fine, rtol=0.01)
    rng = np.random.default_rng(0)
    # many at the ends of all three, where touches are worst
    at = np.stack([rng.uniform(-2.5, 2.5, 10_000).clip(-2.0, 2.0), rng.uniform(-2, 2, 10_000).clip(-1.5, 1.5)], axis=-1)
    angle, azimuth = np.arctan(0.5) * (2 * rng.random(10_000)).clip(max=1.0), rng.uniform(-np.pi, np.pi, 10_000)
    load = np.stack([np.cos(angle), np.sin(angle) * np.cos(azimuth), np.sin(angle) * np.sin(azimuth)], axis=-1)
    slopes = [finger.measure(ss.PointLoad(components=row, position=at)) for row in np.eye(3)]
    for axis in np.eye(2):
        ahead, back = (finger.measure(ss.PointLoad(components=load, position=at + s * axis)) for s in (1e-4, -1e-4))
        slopes.insert(0, (ahead - back) / 2e-4)
    jacobian = np.stack(slopes, axis=-1) / np.asarray(array.noise)[:, None]
    covariance = np.linalg.inv(np.swapaxes(jacobian, 1, 2) @ jacobian)
    widest = np.sqrt(np.linalg.eigvalsh(covariance[:, :2, :2])[:, -1].max())
    assert 0.9 * rough < widest <= rough * (1 + 1e-3)
