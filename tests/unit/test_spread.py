"""Standard errors of positions that hold on skins which no model quite has, and fingers that are not to be trusted."""

from __future__ import annotations

import warnings
from contextlib import nullcontext
from dataclasses import replace

import numpy as np
import pytest

import subskin as ss
from subskin.calibration.correlated import Correlated, Residuals
from subskin.calibration.fit import Fit
from subskin.calibration.held_out import measured, size_of
from subskin.calibration.known import fitted
from subskin.spread import Spread

from .._commands import subskin

SKIN = ss.HalfPlane(ss.Material(young=0.4e6))
FIT = ("gain", "offset", "depth", "origin", "position")
MOTOR = np.arange(0.0, 26e-3, 0.5e-3)
ORIGIN = 13e-3
Q95 = 1.96


def finger(noise=10.0, **changes):
    return ss.Finger(SKIN, ss.SensorArray.line(4, pitch=6e-3, depth=5.4e-3, gain=-1e6, noise=noise), **changes)


def recorded(phase, own, seed=0, noise=10.0):
    """Presses on a skin that no model quite has: what is missed is smooth along the positions.

    Of all sensors alike, as of a field of another shape, and a part that each has for `own`.
    """
    rng = np.random.default_rng(seed)
    clean = finger(0.0).read(ss.LineLoad(20.0, position=MOTOR - ORIGIN))
    u = ((MOTOR - ORIGIN)[:, None] - np.asarray(finger().array.y)) / 5.4e-3
    turns = phase + own * np.arange(4)
    missed = 0.03 * np.abs(clean).max() * np.cos(2.5 * u + turns) * np.exp(-((u / 2.5) ** 2))
    return clean + missed + rng.normal(0.0, noise, clean.shape)


SKINS = {"of the field": recorded(1.5, 0.0, 1), "of the sensors": recorded(0.4, 0.9, 3)}
BETWEEN = np.arange(0, len(MOTOR), 2)
AROUND = np.setdiff1d(np.arange(len(MOTOR)), np.arange(20, 32))
"""All but a gap of a depth, in the middle."""


@pytest.fixture(scope="module")
def found():
    """Two skins, each calibrated on every second press, and on all but a gap."""
    return {
        (name, lie): ss.calibrate(finger(), readings[used], MOTOR[used], fit=FIT)
        for name, readings in SKINS.items()
        for lie, used in (("between", BETWEEN), ("gap", AROUND))
    }


def test_a_sensor_that_only_the_presses_held_out_came_near_says_nothing_of_the_finger():
    # three presses lie above the first sensor; without them its gain is a seventh, and no such finger is used
    made = ss.SensorArray(y=[-8.9e-3, -3.15e-3, 3e-3, 9.05e-3], depth=5.4e-3, gain=[-2.2e6, -2.9e6, -3e6, -3.5e6])
    real = ss.Finger(ss.Layered(ss.Layer(ss.Material(0.2e6, 0.36), 6e-3)), made)
    at = np.arange(0.5e-3, 30e-3, 2e-3)
    clean = real.read(ss.LineLoad(13.0, position=at - 8.65e-3))
    readings = 13e3 / np.abs(clean).max() * clean + np.random.default_rng(0).normal(0.0, 10.0, clean.shape)
    drawn = ss.Finger(ss.HalfPlane(ss.Material(0.2e6)), replace(finger().array, depth=5e-3))
    one = ss.calibrate(drawn, readings, at, fit=("gain", "lift", "depth", "origin", "position"))
    assert min(one.held_out) >= 15
    assert one.finger.spread.straight.max() < 10
    assert one.finger.spread.leaning.max() < 10


class TestHeldOutPresses:
    @pytest.mark.parametrize("lie", ["between", "gap"])
    def test_95_percent_intervals_hold_the_truth(self, found, lie):
        z, before = [], []
        for name, readings in SKINS.items():
            one, used = found[name, lie], {"between": BETWEEN, "gap": AROUND}[lie]
            assert one.misfit.structured
            assert min(one.held_out) >= 20
            held = np.setdiff1d(np.arange(len(MOTOR)), used)
            for friction in (0.0, 1.0):
                at = one.finger.locate(readings[held], friction=friction)
                error = np.abs(at.position - (MOTOR[held] - one.origin))[at.ok]
                z += (error / at.std[at.ok, 0]).tolist()
                before += (error / at.std[at.ok, 0] * one.finger.spread.at(at.position, friction)[at.ok]).tolist()
        z = np.array(z)
        assert z.size > 45
        # 88 to 99 % are wanted; a share of so few has a standard error of its own
        assert 0.88 - 2 * np.sqrt(0.88 * 0.12 / z.size) <= np.mean(z <= Q95)
        assert np.mean(z <= Q95) <= 0.99 + 2 * np.sqrt(0.99 * 0.01 / z.size)
        # nor are they held by intervals far too wide
        assert 0.4 < np.sqrt(np.mean(z**2)) < 1.3
        if lie == "gap":  # as if the misfit were white noise they are not
            assert np.mean(np.array(before) <= Q95) < 0.75

    def test_a_gap_is_known_to_be_one(self, found):
        """Of the same skin: within the gap the spread is larger than where there were touches on both sides."""
        for name in SKINS:
            around, between = (found[name, lie] for lie in ("gap", "between"))
            middle = MOTOR[26] - ORIGIN
            for friction in (0.0, 1.0):
                gap, touched = (
                    one.finger.locate(finger(0.0).read(ss.LineLoad(20.0, position=middle)), friction=friction).std[0]
                    for one in (around, between)
                )
                assert gap > 1.2 * touched

    def test_white_residuals_leave_errors_as_they_are(self):
        true = finger()
        readings = true.read(ss.LineLoad(20.0, position=MOTOR - ORIGIN), np.random.default_rng(0))
        one = ss.calibrate(true, readings, MOTOR, fit=FIT)
        assert one.finger.spread is None
        assert one.held_out == (0, 0)

    def test_of_loads_that_lean_no_straight_ones_are_held_out(self):
        lean = np.tile([0.0, 0.3], len(MOTOR))[: len(MOTOR)]
        clean = finger(0.0).read(ss.LineLoad(20.0, angle=lean, position=MOTOR - ORIGIN))
        readings = clean + SKINS["of the sensors"] - finger(0.0).read(ss.LineLoad(20.0, position=MOTOR - ORIGIN))
        (down, _), (straight, leaning) = measured(fitted(finger(), readings, MOTOR, fit=FIT, angle=lean))
        assert straight <= 2 * (lean == 0).sum() < leaning
        assert down < 3.0  # of leaning loads taken for straight ones it would be far more

    def test_three_touches_for_the_origin_keep_the_finger_s_own(self, found):
        one = found["of the field", "between"]
        three = [15, 25, 35]
        again = ss.calibrate(one.finger, SKINS["of the field"][three], MOTOR[three], fit=("origin",))
        assert again.finger.spread is one.finger.spread

    def test_of_few_touches_what_is_above_the_noise_is_no_noise(self):
        """Too few to see that residuals go together, but far above the noise that is stated."""
        few, readings = np.arange(20, 32, 3), SKINS["of the field"]
        loose, white = (ss.calibrate(finger(n), readings[few], MOTOR[few], fit=("gain", "origin")) for n in (10.0, 1e3))
        assert not loose.misfit.structured
        assert white.finger.spread is None
        assert loose.finger.spread is not None
        assert any("hold some out" in doubt for doubt in loose.doubts) == (not any(loose.held_out))
        origin = [next(p for p in one.parameters if p.name == "origin").std for one in (loose, white)]
        assert origin[0] > 1.5 * origin[1] * np.median(loose.finger.array.noise) / 1e3


class TestTheProcess:
    def test_positions_are_off_as_far_as_it_says(self):
        """Misfit drawn from a process, the finger fitted to it anew, and a touch located that has its share of it."""
        names, motor = ("gain", "depth", "origin"), np.concatenate([MOTOR[:20:2], MOTOR[34::2]])
        new = MOTOR[[9, 22, 27, 32]]  # among touches, and in their gap
        clean = finger(0.0).read(ss.LineLoad(20.0, position=np.concatenate([motor, new]) - ORIGIN))
        start = fitted(finger(), clean[: len(motor)], motor, fit=names, force=20.0, origin=ORIGIN)
        process = Correlated(0.4, np.array([0.0, 0.5, 0.0, 0.0]), np.array([0.0, 0.0, 1.5, 0.0]))
        start.uncertainty.process = process
        expected = start.uncertainty.of_positions(new - ORIGIN)
        touch, sensor = (a.ravel() for a in np.indices(clean.shape))
        at = (np.concatenate([motor, new]) - ORIGIN)[touch] - np.asarray(finger().array.y)[sensor]
        every = Residuals(
            np.zeros(touch.size), sensor, at / 5.4e-3, np.ones(touch.size), touch, np.zeros((touch.size, 5)), 0 * at
        )
        covariance = process.misfit(every, every) + process.noise**2 * np.eye(touch.size)
        root = np.linalg.cholesky(covariance)
        rng, off = np.random.default_rng(0), []
        for _ in range(60):
            readings = clean + 1.0 * (root @ rng.standard_normal(touch.size)).reshape(clean.shape)
            fit = Fit(finger(), names, readings[: len(motor)], motor, start.load, start.live, ORIGIN, scan=False)
            fit.noise = start.noise
            fit = fit.solve(start.p)
            loose = replace(fit.finger_found(), array=replace(fit.finger_found().array, noise=30.0))
            located = [loose.locate(readings[len(motor) :], friction=friction) for friction in (0.0, 1.0)]
            truth = new - fit.forward.origin(fit.p, ORIGIN)
            off.append([30.0 * (one.position - truth) / one.std[:, 0] for one in located])
        ratio = np.sqrt(np.mean(np.square(off), axis=0))
        np.testing.assert_allclose(ratio, expected, rtol=0.35)
        # without the misfit that moves the fit, or its correlation with that of the touch, half as much again
        np.testing.assert_allclose(np.mean(ratio / expected), 1.0, atol=0.15)

    @pytest.mark.parametrize("count", [5, 10, 19, 60])
    def test_95_percent_of_new_errors_are_within_the_size(self, count):
        errors = np.abs(np.random.default_rng(count).standard_normal((2000, count + 1)))
        held = np.mean([row[-1] <= Q95 * size_of(row[:-1]) for row in errors])
        assert held == pytest.approx(0.95, abs=0.03)


@pytest.fixture(scope="module")
def readings():
    return finger().read(ss.LineLoad(20.0, position=np.linspace(-8e-3, 8e-3, 5)), np.random.default_rng(1))


class TestWhatAFingerCarries:
    def test_a_spread_widens_covariances_and_nothing_else(self, readings):
        spread = Spread([-6e-3, 6e-3], straight=[1.0, 3.0], leaning=[2.0, 4.0])
        wide = finger(spread=spread)
        for friction in (0.0, 1.0):
            a, b = (one.locate(readings, friction=friction) for one in (finger(), wide))
            factor = spread.at(a.position, friction)[:, None, None]
            assert np.ptp(factor) > 1.5
            np.testing.assert_allclose(b.covariance, factor**2 * a.covariance, rtol=1e-12)
            np.testing.assert_allclose(b.load.covariance, factor**2 * a.load.covariance, rtol=1e-12)
            for name in ("position", "force", "residual", "status"):
                np.testing.assert_array_equal(getattr(b, name), getattr(a, name))
            np.testing.assert_array_equal(b.second.position, a.second.position)
            one = wide.locate(readings[2], friction=friction)  # a frame by itself goes another way
            np.testing.assert_allclose(one.covariance, b.covariance[2], rtol=1e-12)

    def test_the_interval_of_a_half_width_too(self):
        row = ss.SensorArray.line(7, pitch=3e-3, depth=5.4e-3, gain=-1e6, noise=10.0)
        true = ss.Finger(SKIN, row)
        readings = true.read(ss.Hertz(40.0, 0.0, 1e-3, half_width=3e-3))
        spread = Spread([0.0], straight=[1.0], leaning=[2.0])
        a, b = (one.fit(readings, "hertz") for one in (true, replace(true, spread=spread)))
        (low, high), (lower, higher) = np.square(a.half_width_interval), np.square(b.half_width_interval)
        square = float(a.half_width) ** 2
        assert higher - square == pytest.approx(2 * (high - square), rel=1e-9)
        assert square - lower == pytest.approx(min(2 * (square - low), square), rel=1e-9)
        np.testing.assert_allclose(b.std, 2 * a.std, rtol=1e-12)

    def test_no_frame_is_ok_without_trust_and_that_is_said(self, readings):
        doubted = finger(trusted=False)
        frames = np.concatenate([readings, [[3e3, -3e3, 3e3, -3e3], [0.0] * 4]])
        usual = finger().locate(frames, friction=0)
        with pytest.warns(ss.errors.ValidityWarning, match="no frame of it is OK"):
            found = doubted.locate(frames, friction=0)
        assert (usual.status == ss.Status.OK).sum() >= 4
        np.testing.assert_array_equal(found.status, np.where(usual.ok, ss.Status.AMBIGUOUS, usual.status))
        np.testing.assert_array_equal(found.std, usual.std)
        with warnings.catch_warnings():
            warnings.simplefilter("error")  # the same question again is not warned of
            assert doubted.locate(readings[0], friction=0).status == ss.Status.AMBIGUOUS
        with pytest.warns(ss.errors.ValidityWarning):
            assert not doubted.fit(readings, "hertz", friction=0).ok.any()
        with pytest.warns(ss.errors.ValidityWarning):
            assert (ss.decide.contact_type(doubted, readings, friction=0).status != ss.Status.OK).all()

    @pytest.mark.parametrize(
        "wrong",
        [
            {"straight": [0.0, 1.0]},
            {"leaning": [1.0]},
            {"y": [1.0, 0.0]},
            {"straight": [np.nan, 1.0]},
            {"y": [], "straight": [], "leaning": []},
        ],
    )
    def test_a_spread_has_ratios_above_0_at_nodes_that_rise(self, wrong):
        with pytest.raises(ss.errors.SubskinError, match=f"spread.{next(iter(wrong))}"):
            Spread(**{"y": [0.0, 1.0], "straight": [1.0, 1.0], "leaning": [1.0, 1.0]} | wrong)

    def test_a_finger_has_a_spread_or_none(self):
        with pytest.raises(ss.errors.InvalidValueError, match=r"spread = 1\.0"):
            finger(spread=1.0)


TOML = """
[skin]
young = "0.4 MPa"

[sensors]
count = 4
pitch = "6 mm"
depth = "5.4 mm"
kind = "normal_strain"
gain = -1e6
noise = 10
"""


class TestTheFile:
    def test_it_keeps_spread_and_trust(self):
        file = ss.io.parse_finger(TOML)
        spread = Spread([-9e-3, 1e-3], straight=[0.7, 1.25], leaning=[1.0, 2.0])
        facts = {"r2": 0.5, "std": {"depth": "0.1 mm"}}
        written = file.with_finger(replace(file.finger, spread=spread, trusted=False), 0.0, facts)
        assert "straight = [0.7, 1.25]" in written.text
        assert "accepted_misfit = true" in written.text
        again = ss.io.parse_finger(written.text)
        assert {k: v.tolist() for k, v in vars(again.finger.spread).items()} == {
            k: pytest.approx(v.tolist()) for k, v in vars(spread).items()
        }
        assert not again.finger.trusted
        assert "r2 = 0.5" in again.with_finger(again.finger, 0.0, facts).text
        assert "spread" not in file.with_finger(file.finger, 0.0).text

    @pytest.mark.parametrize("ratios", ["[]", "[0.0]", "[1.0, 2.0]"])
    def test_a_wrong_one_is_named(self, ratios):
        with pytest.raises(ss.errors.FileError, match="straight"):
            ss.io.parse_finger(f"{TOML}\n[calibration.spread]\ny = ['0 mm']\nstraight = {ratios}\nleaning = [1.0]")

    def test_what_was_accepted_is_never_ok(self, tmp_path, monkeypatch):
        monkeypatch.chdir(tmp_path)
        (tmp_path / "finger.toml").write_text(TOML)
        slope = np.linspace(-1.0, 1.0, 4) * (MOTOR[:, None] - ORIGIN) / ORIGIN  # a channel, no skin
        readings = 1e3 * (1.2 + slope) + np.random.default_rng(0).normal(0, 10.0, slope.shape)
        ss.io.write_table("channel.csv", {"position": MOTOR} | {f"s{i}": readings[:, i] for i in range(4)})
        ran = subskin("calibrate", "finger.toml", "channel.csv", "-o", "new.toml", "--accept-misfit")
        assert ran.code == 0, ran.err
        assert not ss.load("new.toml").finger.trusted
        with warnings.catch_warnings():
            warnings.simplefilter("always", ss.errors.ValidityWarning)  # the command prints what Python would
            ran = subskin("locate", "new.toml", "channel.csv", "-o", "located.csv")
        assert ran.code == 0, ran.err
        assert "no frame of it is OK" in ran.err
        with pytest.warns(ss.errors.ValidityWarning, match="no frame of it is OK"):
            assert not ss.load("new.toml").locate(readings).ok.any()
        for asked, sure in (("true", False), ("false", True)):  # of a finger that has nothing else amiss
            usual = ss.io.parse_finger(f"{TOML}\n[calibration]\naccepted_misfit = {asked}")
            touch = usual.finger.read(ss.LineLoad(20.0, position=1e-3))
            said = nullcontext() if sure else pytest.warns(ss.errors.ValidityWarning, match="no frame of it is OK")
            with said:
                assert usual.locate(touch).ok == sure
        assert "ok" not in {line.split(",")[-1] for line in (tmp_path / "located.csv").read_text().splitlines()}


def test_an_interval_that_reaches_the_end_of_the_search_is_ambiguous():
    """Errors that are larger than noise's leave open what these would not: a load at the end, and a rival."""
    array = ss.SensorArray.line(5, pitch=3e-3, depth=4e-3, noise=1e-4)
    finger = ss.Finger(ss.HalfPlane(ss.Material(young=0.4e6)), array)
    readings = finger.read(ss.LineLoad(40.0, position=[0.0, 6e-3]), np.random.default_rng(0))
    search = (-9e-3, 9e-3)
    plain = finger.locate(readings, friction=0, search=search)
    assert (plain.status == ss.Status.OK).all()
    reach = np.sqrt(13.8) * plain.std[:, 0]  # `ambiguity` of chi-square
    for ratio, ok in ((0.9 * 3e-3 / reach[1], True), (1.1 * 3e-3 / reach[1], False)):
        wide = replace(finger, spread=Spread([0.0], straight=[ratio], leaning=[ratio]))
        found = wide.locate(readings, friction=0, search=search)
        np.testing.assert_allclose(found.std[:, 0], ratio * plain.std[:, 0])
        assert (found.status[1] == ss.Status.OK) is np.bool_(ok)
        assert found.status[0] == ss.Status.OK  # in the middle


def test_a_rival_is_weighed_by_the_larger_errors():
    array = ss.SensorArray.line(4, pitch=3e-3, depth=4e-3, noise=1e-4)
    finger = ss.Finger(ss.HalfPlane(ss.Material(young=0.4e6)), array)
    readings = finger.read(ss.LineLoad(40.0, position=3e-3), np.random.default_rng(0))
    chi2 = float(finger.locate(readings, search=(-20e-3, 20e-3)).second.chi2)  # larger than that of the best
    for share, expected in ((0.9, ss.Status.OK), (1.1, ss.Status.AMBIGUOUS)):
        ratio = share * np.sqrt(chi2 / 13.8)
        wide = replace(finger, spread=Spread([0.0], straight=[ratio], leaning=[ratio]))
        assert wide.locate(readings, search=(-20e-3, 20e-3)).status == expected
