"""Calibrating from unlabelled touches: derivatives, elimination, what cannot be known, every skin, bad input."""

from dataclasses import replace

import numpy as np
import pytest

import subskin as ss
from subskin.calibration import Known
from subskin.calibration._blind_model import BlindModel, UnknownTouch, Whitened

SOFT = ss.Material(0.4e6)
SKINS = {
    "half plane": ss.HalfPlane(SOFT),
    "layer": ss.Layered(ss.Layer(SOFT, 4e-3)),
    "stack": ss.Layered([ss.Layer(ss.Material(1e6, 0.4), 1.5e-3), ss.Layer(SOFT, 2.5e-3)]),
    "round": ss.Round(SOFT, 12e-3, 8e-3),
}
SCALE, SHIFT, LENGTH = "common scale of the gains", "common shift", "common scale of depths and positions"


def drawn(skin="half plane", count=5, **array):
    array = {"pitch": 1.5e-3, "depth": 2e-3, "noise": 5e-5} | array
    return ss.Finger(SKINS[skin], ss.SensorArray.line(count, **array))


def made(finger, seed=0, gain=0.05, depth=0.05, position=0.02):
    """A real finger, as far from the drawing as it says."""
    rng = np.random.default_rng(seed)
    a, n = finger.array, len(finger.array)
    d = np.asarray(a.depth)
    changed = replace(
        a,
        gain=np.asarray(a.gain) * np.exp(gain * rng.standard_normal(n)),
        depth=d + depth * d.mean() * rng.standard_normal(),
        y=np.asarray(a.y) + position * d.mean() * rng.standard_normal(n),
    )
    return ss.Finger(finger.skin, changed)


def loads(finger, count=120, seed=1, lean=0.7):
    rng = np.random.default_rng(seed)
    y = np.asarray(finger.array.y)
    force, angle = rng.uniform(50, 200, count), rng.uniform(-lean, lean, count)
    return ss.LineLoad(force, angle, rng.uniform(y.min(), y.max(), count))


def touched(finger, count=120, seed=1, lean=0.7):
    return finger.read(loads(finger, count, seed, lean), np.random.default_rng(seed + 100))


def off_line(found, truth):
    """RMS error of places up to shift and scale."""
    line = np.stack([np.ones_like(truth), truth], axis=-1)
    return np.sqrt(np.mean((found - line @ np.linalg.lstsq(line, found, rcond=None)[0]) ** 2))


class TestDerivatives:
    """Against differences of `Finger.read`, which knows nothing of x."""

    @pytest.mark.parametrize("skin", ["half plane", "layer", "round"])
    @pytest.mark.parametrize("width", [0.0, 1e-3])
    def test_by_position_and_by_finger(self, skin, width):
        nu = ss.Material(0.4e6, 0.4)
        medium = {
            "half plane": ss.HalfPlane(nu), "layer": ss.Layered(ss.Layer(nu, 4e-3)), "round": ss.Round(nu, 12e-3, 8e-3)
        }[skin]  # fmt: skip
        tip = ss.Finger(
            medium,
            ss.SensorArray(
                [-2e-3, 0.3e-3, 2e-3],
                [2e-3, 1.5e-3, 2.5e-3],
                gain=[1.0, -2.0, 0.5],
                noise=[1e-4, 2e-4, 1e-4],
                width=width,
            ),
        )
        names = ["gain", "offset", "depth", "position", "poisson"] + (["thickness"] if skin != "half plane" else [])
        errors = dict.fromkeys(names, 1e-4) | {"gain": 0.05, "poisson": 0.03, "offset": 1e-3}
        x = np.random.default_rng(0).standard_normal(9 + 2 + (skin != "half plane"))
        model = BlindModel(tip, names, errors, UnknownTouch(1, 1.0))
        assert model.size == x.size
        touch = ss.LineLoad([100.0, 60.0], [0.3, -0.5], [0.4e-3, -1.1e-3])
        offset = np.asarray(tip.array.offset)

        def readings(at, load):
            return (model.finger(at).read(load) - offset) / np.asarray(tip.array.noise)

        seen = np.ones((2, 3), dtype=bool)
        near = model.linearise(Whitened(readings(x, touch), seen), x, np.asarray(touch.position)[:, None])
        np.testing.assert_allclose(near.force, np.stack([touch.normal_force, touch.tangential_force], -1), rtol=1e-7)
        assert np.abs(near.rest).max() < 1e-6
        for i, step in enumerate(np.full(x.size, 1e-3) * np.eye(x.size)):
            slope = (readings(x + step, touch) - readings(x - step, touch)) / 2e-3
            scale = np.abs(slope).max()
            np.testing.assert_allclose(near.by_finger[..., i], slope, atol=2e-5 * scale, rtol=0)
        h = 1e-6
        ends = [replace(touch, position=np.asarray(touch.position) + s) for s in (h, -h)]
        slope = (readings(x, ends[0]) - readings(x, ends[1])) / (2 * h)
        np.testing.assert_allclose(near.by_position[..., 0], slope, atol=2e-6 * np.abs(slope).max(), rtol=0)

    def test_at_the_end_of_poissons_range(self):
        model = BlindModel(drawn(count=4), ("poisson",), {"poisson": 0.03}, UnknownTouch(1, 1.0))
        touch = loads(drawn(count=4), 3)
        data = drawn(count=4).read(touch) / 5e-5
        near = model.linearise(
            Whitened(data, np.ones_like(data, bool)), np.zeros(1), np.asarray(touch.position)[:, None]
        )
        below = ss.Finger(ss.HalfPlane(ss.Material(0.4e6, 0.5 - 1e-6)), drawn(count=4).array).read(touch) / 5e-5
        slope = (data - below) / 1e-6 * 0.03
        np.testing.assert_allclose(near.by_finger[..., 0], slope, atol=1e-4 * np.abs(slope).max())


def dense(model, near):
    """Fisher information of (finger, all places, all forces), as one matrix."""
    m, n, k = near.by_force.shape
    own = near.by_position.shape[2] + k
    whole = np.zeros((m * n, model.size + m * own))
    whole[:, : model.size] = near.by_finger.reshape(m * n, -1)
    for i in range(m):
        block = np.concatenate([near.by_position[i], near.by_force[i]], axis=1)
        whole[i * n : (i + 1) * n, model.size + i * own : model.size + (i + 1) * own] = block
    return whole


def test_elimination_is_the_schur_complement_of_the_whole_system():
    tip = drawn(count=5)
    model = BlindModel(
        tip, ("gain", "depth", "position"), {"gain": 0.05, "depth": 1e-4, "position": 4e-5}, UnknownTouch(1, 1.0)
    )
    touch = loads(tip, 6)
    data = (tip.read(touch, np.random.default_rng(0)) + 1e-3) / 5e-5
    near = model.linearise(Whitened(data, np.ones_like(data, bool)), np.zeros(11), np.asarray(touch.position)[:, None])
    whole = dense(model, near)
    size = np.linalg.norm(whole, axis=0)
    fisher = (whole / size).T @ (whole / size)
    a, b, c = fisher[:11, :11], fisher[:11, 11:], fisher[11:, 11:]
    schur = (a - b @ np.linalg.solve(c, b.T)) * np.outer(size[:11], size[:11])
    np.testing.assert_allclose(near.information(), schur, atol=1e-9 * np.abs(schur).max())


def test_settles_at_the_minimum_over_everything_at_once():
    """The gradient of the whole objective, by differences in x with places and forces refitted, vanishes."""
    tip = drawn(count=5)
    real = made(tip)
    readings = touched(real, 40)
    found = ss.calibrate_blind(tip, readings)
    learning = found._learning
    model, x, positions = learning.model, learning.x, found.touches.position[found.used][:, None]
    rows = Whitened(readings[found.used] / 5e-5, np.ones((found.used.sum(), 5), dtype=bool))

    def objective(at, where):
        return (model.fit_forces(rows, at, where)[3] ** 2).sum() + found.misfit**2 * (at @ at)

    here = objective(x, positions)
    for i in range(x.size):
        step = 1e-4 * np.eye(x.size)[i]
        slope = (objective(x + step, positions) - objective(x - step, positions)) / 2e-4
        assert abs(slope) < 1e-2  # chi-square per standard deviation of the drawing
    rng = np.random.default_rng(0)
    for _ in range(20):
        elsewhere = objective(
            x + 0.02 * rng.standard_normal(x.size), positions + 2e-7 * rng.standard_normal(positions.shape)
        )
        assert elsewhere > here - 1e-9


class TestWhatCannotBeKnown:
    @pytest.mark.parametrize(
        ("skin", "fit", "said"),
        [
            ("half plane", ("gain", "depth", "position"), (SCALE, SHIFT, LENGTH)),
            ("half plane", ("gain", "depths", "position"), (SCALE, SHIFT, LENGTH)),
            ("half plane", ("gain", "depth"), (SCALE,)),
            ("half plane", ("gain", "position"), (SCALE, SHIFT)),
            ("half plane", ("depth",), ()),
            ("layer", ("gain", "depth", "position"), (SCALE, SHIFT)),
            ("stack", ("gain", "depth", "position"), (SCALE, SHIFT)),
            ("round", ("gain", "depth", "position"), (SCALE, SHIFT)),
        ],
    )
    def test_null_directions_are_found_from_the_information(self, skin, fit, said):
        tip = drawn(skin)
        found = ss.calibrate_blind(tip, touched(made(tip), 16), fit=fit)
        assert len(found.unknown) == len(said) == found._learning.null.shape[1]
        for text, part in zip(found.unknown, said, strict=True):
            assert part in text

    def test_a_thickness_to_be_found_frees_the_scale_again(self):
        tip = drawn("layer")
        fit = ("gain", "depth", "position", "thickness")
        found = ss.calibrate_blind(tip, touched(made(tip), 30), fit=fit, thickness_error=0.1)
        assert any("depths, positions and thickness" in text for text in found.unknown)
        assert len(found.unknown) == 3

    def test_sensors_of_some_width_tell_the_scale_if_little(self):
        tip = drawn(width=1e-3)
        found = ss.calibrate_blind(tip, touched(made(tip), 60))
        assert len(found.unknown) == 2

    def test_pressures_of_normal_loads_hide_a_turn_of_the_half_plane(self):
        """Poisson's kernel keeps its form under every Moebius map of the half plane: one direction without a name.

        d |f'| / |z - f|^2 is the same for (z, f) as for their images, and the force takes up |f'|.
        """
        tip = drawn(transducer=ss.MeanPressure(), noise=30.0)
        readings = touched(tip, 60, lean=0.0)
        found = ss.calibrate_blind(tip, readings, fit=("gain", "depths", "position"), friction=0)
        assert len(found.unknown) == 4
        assert found.unknown[3].startswith("a change of ")
        assert found.unknown[3].endswith(" together")
        # y -> y + e (y^2 - d^2), d -> d + 2 e y d, and the gains of sensors as they are
        y, d = np.asarray(tip.array.y), np.asarray(tip.array.depth)
        turn = np.concatenate([np.zeros(5), 2 * y * d / (0.05 * 2e-3), (y**2 - d**2) / (0.02 * 2e-3)])
        x = np.asarray(found._learning.x)
        assert np.abs(x).max() < 1.5  # near the drawing, where this is the direction
        null = found._learning.null
        inside = null @ (null.T @ turn)
        assert np.linalg.norm(turn - inside) < 0.1 * np.linalg.norm(turn)

    def test_what_is_unknown_stays_as_drawn_and_keeps_the_priors_spread(self):
        tip = drawn()
        found = ss.calibrate_blind(tip, touched(made(tip, 3)))
        gain = [p for p in found.parameters if p.name == "gain"]
        logs = np.log([p.value for p in gain])
        assert abs(logs.mean()) < 1e-5  # alike, so the drawing's mean is kept
        for p in gain:
            assert p.limit == pytest.approx(p.value * 0.05 / np.sqrt(5), rel=1e-9)
        positions = [p for p in found.parameters if p.name == "y"]
        assert abs(np.mean([p.value - p.drawn for p in positions])) < 1e-5 * 2e-3
        for p in found.parameters:
            grown = p.value / p.drawn if p.name == "gain" else 1.0
            assert p.limit <= p.std <= p.prior * grown * (1 + 1e-9)


class TestHowMany:
    @pytest.fixture(scope="class")
    @staticmethod
    def found():
        tip = drawn("layer", 4)
        return ss.calibrate_blind(tip, touched(made(tip), 60))

    def test_standard_deviations_fall_as_the_root(self, found):
        depth = next(i for i, p in enumerate(found.parameters) if p.name == "depth")
        used = int(found.used.sum())
        std = found.parameters[depth].std
        assert found.std(used)[depth] == pytest.approx(std, rel=1e-12)
        assert found.std(4 * used)[depth] == pytest.approx(std / 2, rel=0.01)
        assert found.touches_for(depth, std / 3) == pytest.approx(9 * used, rel=0.02)
        assert found.std(0)[depth] == pytest.approx(found.parameters[depth].prior, rel=1e-9)
        assert found.parameters[depth].limit < 1e-9 * std
        assert found.parameters[depth].known is Known.LEARNT

    def test_never_for_what_lies_in_a_null_direction(self, found):
        assert found.parameters[0].name == "gain"
        assert found.touches_for(0, 0.5 * found.parameters[0].limit) == np.inf
        assert found.touches_for(0, 1.001 * found.parameters[0].prior * found.parameters[0].value) == 0

    def test_ratio_goes_to_one(self, found):
        now = found.error_ratio()
        more = found.error_ratio(400 * found.used.sum())
        assert 1 < more.angle < now.angle < 1.3
        assert more.angle - 1 == pytest.approx((now.angle**2 - 1) / 800, rel=0.1)
        need = found.touches_for_ratio(1.05)
        assert max(found.error_ratio(need).position, found.error_ratio(need).angle) <= 1.05
        assert max(found.error_ratio(need - 1).position, found.error_ratio(need - 1).angle) > 1.05

    def test_ratio_against_fresh_fingers_of_the_posterior(self):
        """Angles located by fingers drawn from the posterior scatter as `error_ratio` says."""
        tip, rng = drawn(count=6), np.random.default_rng(7)

        def aslant(finger, count):  # to one side only: else the signs of the two forces' parts would not matter
            load = loads(finger, count, seed=5)
            return replace(load, angle=0.1 + 0.8 * np.abs(np.asarray(load.angle)))

        real = made(tip)
        found = ss.calibrate_blind(tip, real.read(aslant(tip, 100), rng))
        learning = found._learning
        rng = np.random.default_rng(0)
        drawn_x = rng.multivariate_normal(learning.x, learning.covariance(), size=200)
        fresh = aslant(tip, 100)
        readings = found.finger.read(fresh)
        errors, noise = [], []
        for x in drawn_x:
            at = learning.model.finger(x).locate(readings)
            angle = at.angle - np.asarray(fresh.angle)
            ok = np.isfinite(angle) & (np.abs(angle) < 0.2)
            errors.append((angle[ok] ** 2).mean())
            noise.append((at.std[ok, 2] ** 2).mean())
        assert np.sqrt(1 + np.mean(errors) / np.mean(noise)) == pytest.approx(found.error_ratio().angle, rel=0.01)

    def test_bad_questions(self, found):
        for ask in (
            lambda: found.touches_for(99, 1.0),
            lambda: found.touches_for(-1, 1.0),
            lambda: found.touches_for(0, 0.0),
            lambda: found.touches_for_ratio(1.0),
            lambda: found.std(-1),
        ):
            with pytest.raises(ss.errors.InvalidValueError):
                ask()


class TestItLearns:
    @pytest.mark.parametrize("skin", ["half plane", "layer", "round"])
    def test_held_out_touches_on_every_skin(self, skin):
        tip = drawn(skin, 5)
        real = made(tip, 2)
        found = ss.calibrate_blind(tip, touched(real, 100, seed=2))
        fresh = loads(real, 200, 9)
        readings = real.read(fresh, np.random.default_rng(3))
        new, known = found.finger.locate(readings), real.locate(readings)
        rough = ss.Finger(tip.skin, replace(tip.array, noise=3e-3)).locate(readings)
        ok = (new.status == 0) & (known.status == 0)
        assert ok.mean() > 0.95
        truth = np.asarray(fresh.position)
        assert off_line(new.position[ok], truth[ok]) < 1.3 * off_line(known.position[ok], truth[ok])
        angle = [np.sqrt(np.mean((e.angle - np.asarray(fresh.angle))[ok] ** 2)) for e in (new, known)]
        assert angle[0] < 1.3 * angle[1]
        placed = ok & np.isfinite(rough.position)
        worst = np.sqrt(np.nanmean((rough.angle - np.asarray(fresh.angle))[placed] ** 2))
        assert worst > 4 * angle[0]

    @pytest.mark.parametrize(
        ("kind", "noise"),
        [
            (ss.MeanPressure(), 10.0), (ss.NormalStress(), 10.0), (ss.ShearStrain(), 5e-5),
            (ss.LateralStrain(), 5e-5), (ss.VolumeResistance(), 1e-4),
            ([ss.NormalStrain(), ss.ShearStrain()] * 3, 5e-5),
        ],
    )  # fmt: skip
    def test_every_transducer(self, kind, noise):
        tip = drawn(count=6, transducer=kind, noise=noise)
        real = made(tip, 4)
        found = ss.calibrate_blind(tip, touched(real))
        assert found.used.mean() > 0.8
        assert found.misfit < 1.2
        ratio = np.asarray(found.finger.array.gain) / np.asarray(real.array.gain)
        assert np.ptp(np.log(ratio)) < 0.02 < 0.08 < np.ptp(np.log(np.asarray(real.array.gain)))

    def test_normal_touches_need_a_sensor_less(self):
        tip = drawn(count=3)
        real = made(tip, 1)
        found = ss.calibrate_blind(tip, touched(real, lean=0.0), friction=0)
        ratio = np.asarray(found.finger.array.gain) / np.asarray(real.array.gain)
        assert np.ptp(np.log(ratio)) < 0.01
        assert np.isnan(found.error_ratio().angle)
        assert np.isfinite(found.touches_for_ratio(1.1))

    def test_poisson_and_offsets(self):
        skin = ss.HalfPlane(ss.Material(0.4e6, 0.42))
        tip = ss.Finger(skin, drawn(count=8).array)
        real = ss.Finger(
            ss.HalfPlane(ss.Material(0.4e6, 0.45)), replace(made(tip).array, offset=2e-3 * np.sin(np.arange(8)))
        )
        fit = ("gain", "depth", "position", "poisson", "offset")
        found = ss.calibrate_blind(tip, touched(real, 200), fit=fit, poisson_error=0.03, offset_error=2e-3)
        by_name = {p.called: p for p in found.parameters}
        nu = by_name["poisson"]
        assert abs(nu.value - 0.45) < 3 * nu.std < 0.03
        offsets = np.array([by_name[f"offset of sensor {i}"].value for i in range(8)])
        assert np.abs(offsets - np.asarray(real.array.offset)).max() < 1e-4
        assert found.finger.skin.material.poisson == nu.value

    def test_each_sensors_depth(self):
        tip = drawn("layer", 6)
        real = ss.Finger(tip.skin, replace(tip.array, depth=2e-3 * (1 + 0.04 * np.cos(2 * np.arange(6)))))
        found = ss.calibrate_blind(tip, touched(real, 80), fit=("gain", "depths", "position"))
        error = np.asarray(found.finger.array.depth) / np.asarray(real.array.depth) - 1
        assert np.abs(error).max() < 4e-3 < 0.03

    def test_a_rival_position_is_left_again(self):
        """Four sensors: on the finger as drawn some touches are put a row away; in the end none is."""
        tip = drawn(count=4)
        wrong = 0
        for seed in range(3):
            real = made(tip, seed, gain=0.1, depth=0.1)
            touch = loads(real, 150, seed)
            readings = real.read(touch, np.random.default_rng(seed))
            rough = ss.Finger(tip.skin, replace(tip.array, noise=5e-4)).locate(readings)
            wrong += (np.abs(rough.position - np.asarray(touch.position)) > 5e-4).sum()
            found = ss.calibrate_blind(tip, readings, gain_error=0.1, depth_error=0.1)
            off = np.abs(found.touches.position - np.asarray(touch.position))[found.used]
            assert found.used.sum() > 140
            assert off.max() < 4e-4
        assert wrong > 3


class TestOddReadings:
    def test_dead_drawn_dead_and_missing(self):
        tip = drawn(count=7, gain=[1, 1, 1, 1, 0, 1, 1])
        real = made(tip, 5)
        real = ss.Finger(real.skin, replace(real.array, gain=np.where(np.arange(7) == 2, 0, real.array.gain)))
        readings = touched(real, 150)
        readings[::10, 0] = np.nan
        found = ss.calibrate_blind(tip, readings)
        assert [h.name for h in found.health] == ["OK", "OK", "DEAD", "OK", "DEAD", "OK", "OK"]
        assert np.asarray(found.finger.array.gain)[[2, 4]].tolist() == [0, 0]
        assert {p.sensor for p in found.parameters} == {None, 0, 1, 3, 5, 6}
        alive = np.array([0, 1, 3, 5, 6])
        ratio = np.asarray(found.finger.array.gain)[alive] / np.asarray(real.array.gain)[alive]
        assert np.ptp(np.log(ratio)) < 0.01
        assert found.used.mean() > 0.95

    def test_a_sensor_far_from_all_touches_is_not_dead(self):
        tip = drawn(count=7, pitch=3e-3)
        rng = np.random.default_rng(0)
        touch = ss.LineLoad(rng.uniform(50, 200, 100), 0.0, rng.uniform(-9e-3, -2e-3, 100))
        found = ss.calibrate_blind(tip, tip.read(touch, rng))
        assert all(h.name == "OK" for h in found.health)

    def test_saturated_readings_are_left_out(self):
        tip = drawn(count=6)
        real = made(tip, 6)
        readings = touched(real)
        low = float(np.quantile(readings, 0.05))
        limited = ss.Finger(tip.skin, replace(tip.array, low=low))
        found = ss.calibrate_blind(limited, np.maximum(readings, low))
        ratio = np.asarray(found.finger.array.gain) / np.asarray(real.array.gain)
        assert np.ptp(np.log(ratio)) < 0.01

    def test_nothing_touched_two_at_once_and_rubbish_are_left_out(self):
        tip = drawn(count=6)
        real = made(tip, 7)
        readings = touched(real, 150)
        rng = np.random.default_rng(2)
        free = 5e-5 * rng.standard_normal((20, 6))
        two = real.read(ss.LineLoad(np.full(10, 80.0), 0.2, np.linspace(-3.5e-3, -2e-3, 10)))
        two += real.read(ss.LineLoad(np.full(10, 80.0), -0.2, np.linspace(2e-3, 3.5e-3, 10)))
        rubbish = 0.02 * rng.standard_normal((10, 6))
        nothing = np.full((3, 6), np.nan)
        found = ss.calibrate_blind(tip, np.concatenate([readings, free, two, rubbish, nothing]))
        state = found.touches.status
        assert found.used[:150].mean() > 0.97
        assert not found.used[150:].any()
        assert (state[150:170] == ss.Status.NO_CONTACT).all()
        assert (state[170:190] == ss.Status.UNEXPLAINED).mean() > 0.9
        assert (state[190:] == ss.Status.INCOMPLETE).all()
        ratio = np.asarray(found.finger.array.gain) / np.asarray(real.array.gain)
        assert np.ptp(np.log(ratio)) < 0.01

    def test_a_model_that_does_not_fit_is_said_not_to(self):
        tip = drawn(count=6)
        layer = ss.Finger(ss.Layered(ss.Layer(SOFT, 3e-3)), tip.array)
        found = ss.calibrate_blind(tip, touched(layer))
        assert found.misfit > 3
        assert "the model does not fit" in found.doubts[0]
        np.testing.assert_allclose(found.finger.array.noise, 5e-5 * found.misfit)

    def test_noise_drawn_too_small_is_found_out(self):
        tip, quiet = drawn(count=6), drawn(count=6, noise=1e-5)
        readings = touched(made(tip), 150)
        known, found = (ss.calibrate_blind(finger, readings) for finger in (tip, quiet))
        assert known.misfit == 1.0
        assert found.misfit == pytest.approx(5.0, rel=0.15)
        np.testing.assert_allclose([p.std for p in found.parameters], [p.std for p in known.parameters], rtol=0.1)
        at = [f.error_ratio(10 * 150) for f in (known, found)]
        assert at[1].angle - 1 == pytest.approx(at[0].angle - 1, rel=0.2)
        spread = [f._learning.covariance() - f._learning.covariance(np.inf) for f in (known, found)]
        assert np.trace(spread[1]) == pytest.approx(np.trace(spread[0]), rel=0.35)

    def test_a_surprise_is_said(self):
        tip = drawn(count=6)
        real = ss.Finger(tip.skin, replace(tip.array, gain=[1, 1, 0.7, 1, 1, 1]))
        found = ss.calibrate_blind(tip, touched(real, 200), gain_error=0.03)
        assert any(text.startswith("gain of sensor 2 is ") for text in found.doubts)


class TestInput:
    def test_is_not_changed_and_results_are_read_only(self):
        tip = drawn()
        readings = touched(made(tip), 40)
        before = readings.copy()
        found = ss.calibrate_blind(tip, readings)
        np.testing.assert_array_equal(readings, before)
        for array in (found.covariance, found.used, found.touches.table, found.std(10)):
            with pytest.raises(ValueError, match="read-only"):
                array[...] = 0
        again = ss.calibrate_blind(tip, readings.tolist(), fit=["position", "depth", "gain"])
        assert again.parameters == found.parameters

    def test_integers_and_one_error_a_sensor(self):
        tip = drawn(noise=1.0, gain=5e4)
        readings = np.round(touched(made(tip), 60)).astype(int)
        errors = [0.05, 0.05, 1e-9, 0.05, 0.05]
        found = ss.calibrate_blind(tip, readings, gain_error=errors)
        assert found.finger.array.gain[2] == pytest.approx(5e4, rel=1e-8)

    @pytest.mark.parametrize(
        ("change", "error", "match"),
        [
            ({"fit": ("gain", "origin")}, ss.errors.InvalidValueError, "origin.*leave it out"),
            ({"fit": ("gain", "size")}, ss.errors.InvalidValueError, "has to be among"),
            ({"fit": ()}, ss.errors.InvalidValueError, "empty"),
            ({"fit": ("depth", "depths")}, ss.errors.InvalidValueError, "both depth and depths"),
            ({"fit": "poisson"}, ss.errors.InvalidValueError, "without poisson_error"),
            ({"fit": "thickness", "thickness_error": 0.1}, ss.errors.InvalidValueError, "no single thickness"),
            ({"gain_error": 0.0}, ss.errors.InvalidValueError, "gain_error"),
            ({"gain_error": [0.1, 0.1]}, ss.errors.GeometryError, "gain_error of shape"),
            ({"depth_error": np.nan}, ss.errors.InvalidValueError, "depth_error"),
            ({"position_error": "much"}, ss.errors.InvalidValueError, "position_error"),
            ({"friction": -1.0}, ss.errors.InvalidValueError, "friction"),
            ({"search": (1.0, 0.0)}, ss.errors.InvalidValueError, "search"),
        ],
    )
    def test_bad_options(self, change, error, match):
        tip = drawn()
        with pytest.raises(error, match=match):
            ss.calibrate_blind(tip, touched(tip, 20), **change)

    def test_bad_readings_and_fingers(self):
        tip = drawn()
        with pytest.raises(ss.errors.GeometryError, match="one touch a row"):
            ss.calibrate_blind(tip, np.zeros((10, 4)))
        with pytest.raises(ss.errors.GeometryError, match="one touch a row"):
            ss.calibrate_blind(tip, np.zeros(5))
        with pytest.raises(ss.errors.InvalidValueError, match="noise = 0"):
            ss.calibrate_blind(drawn(noise=0.0), touched(tip, 20))
        with pytest.raises(ss.errors.NotLinearError):
            ss.calibrate_blind(drawn(transducer=ss.VolumeResistance(exact=True)), touched(tip, 20))
        with pytest.raises(ss.errors.InvalidValueError, match="no single poisson"):
            ss.calibrate_blind(drawn("stack"), touched(tip, 20), fit="poisson", poisson_error=0.1)

    def test_too_few(self):
        tip = drawn()
        with pytest.raises(
            ss.errors.ConvergenceError, match=r"5 touches.*10 readings more.*11 numbers.*at least 6 touches"
        ):
            ss.calibrate_blind(tip, touched(tip, 5))
        with pytest.raises(ss.errors.ConvergenceError, match=r"3 live sensors.*friction=0"):
            ss.calibrate_blind(drawn(count=3), touched(drawn(count=3), 50))
        with pytest.raises(ss.errors.ConvergenceError, match="0 live sensors"):
            ss.calibrate_blind(tip, np.full((50, 5), np.nan))
        with pytest.raises(ss.errors.ConvergenceError, match="50 no_contact"):
            ss.calibrate_blind(tip, 5e-5 * np.random.default_rng(0).standard_normal((50, 5)))
