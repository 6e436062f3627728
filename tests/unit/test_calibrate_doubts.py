"""Calibration that knows when it does not: few touches, dead and weak sensors, models that are not the skin's."""

from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pytest

import subskin as ss
import subskin.cli.calibrate_more as cli_choose
from subskin.calibration import Health, choose
from subskin.calibration.correlated import Correlated, Residuals, correlated, scatter
from subskin.calibration.uncertainty import misfit_of

from .._commands import subskin

SKIN = ss.HalfPlane(ss.Material(young=0.4e6))
FIT = ("gain", "offset", "depth", "origin")
MOTOR = np.linspace(0, 30e-3, 40)
ORIGIN = 14e-3


def finger(**changes):
    row = {"count": 4, "pitch": 6e-3, "depth": 5.4e-3, "gain": -1e6, "noise": 10.0}
    return ss.Finger(SKIN, ss.SensorArray.line(**{**row, **changes}))


def pressed(true, motor=MOTOR, seed=0, force=20.0):
    return true.read(ss.LineLoad(force, position=motor - ORIGIN), np.random.default_rng(seed))


def lumpy(true, motor=MOTOR, size=0.02):
    """Readings of a skin that no model quite has: smooth, of the touch's position relative to each sensor."""
    u = ((motor - ORIGIN)[:, None] - np.asarray(true.array.y)) / 5e-3
    clean = pressed(replace(true, array=replace(true.array, noise=0.0)), motor)
    return pressed(true, motor) + size * np.abs(clean).max() * np.cos(2.5 * u + 0.4) * np.exp(-((u / 2.5) ** 2))


def channel(motor=MOTOR, count=4):
    """A pressure that a channel carries to its ends: each sensor reads a slope, not a field that dies away."""
    slopes = np.linspace(-1.0, 1.0, count)
    rng = np.random.default_rng(1)
    return 1e3 * (1.2 + slopes * (motor[:, None] / 15e-3 - 1)) + rng.normal(0, 1, (len(motor), count))


class TestFewTouches:
    def test_less_than_one_spare_reading_a_sensor_is_refused(self):
        rows = [8, 20, 32]  # 12 readings, 10 numbers
        with pytest.raises(ss.errors.ConvergenceError, match="12 readings for 10 parameters"):
            ss.calibrate(finger(), pressed(finger())[rows], MOTOR[rows], fit=FIT)

    def test_few_are_said_first_and_the_stated_noise_is_the_least(self):
        rows = [8, 14, 20, 26]  # 16 readings, 10 numbers
        found = ss.calibrate(finger(), pressed(finger())[rows], MOTOR[rows], fit=FIT)
        assert found.spare == 6
        assert found.doubts[0].startswith("too few touches to check the fit: 6 spare readings for 10 fitted numbers")
        assert (np.asarray(found.finger.array.noise) >= 10.0).all()

    def test_enough_are_not_doubted(self):
        found = ss.calibrate(finger(), pressed(finger()), MOTOR, fit=FIT)
        assert found.spare == 4 * 40 - 10
        assert found.doubts == ()

    @pytest.mark.parametrize(("count", "friction", "spare"), [(4, 1.0, 1), (4, 0.0, 2), (6, 0.5, 3), (2, 0.0, 0)])
    def test_what_a_frame_has_to_spare(self, count, friction, spare):
        true = finger(count=count)
        found = ss.calibrate(true, pressed(true), MOTOR, fit=("gain", "origin"))
        assert found.spare_readings(friction) == spare


class TestSensors:
    def test_one_that_moves_by_many_noises_is_not_dead_whatever_its_gain(self):
        """Its readings have nothing to do with the touches, so that its gain comes out as 0 within its error."""
        readings = np.array(pressed(finger()))
        readings[:, 2] = np.random.default_rng(3).normal(0, 500.0, len(MOTOR))  # noise is said to be 10
        found = ss.calibrate(finger(), readings, MOTOR, fit=FIT)
        assert found.health[2] == Health.WEAK
        readings[:, 2] = np.random.default_rng(3).normal(0, 10.0, len(MOTOR))
        found = ss.calibrate(finger(), readings, MOTOR, fit=FIT)
        assert found.health[2] == Health.DEAD

    @pytest.mark.parametrize(("ratio", "health"), [(0.29, Health.WEAK), (0.45, Health.WEAK), (0.6, Health.OK)])
    def test_weak_is_below_half_of_the_median(self, ratio, health):
        true = finger(gain=-1e6 * np.array([1, ratio, 1, 1.1]))
        found = ss.calibrate(finger(), pressed(true), MOTOR, fit=FIT)
        assert [h.name for h in found.health] == ["OK", health.name, "OK", "OK"]

    def test_a_weak_sensor_of_a_fit_with_offsets_is_found_in_daily_use(self):
        """The offsets are part of the fit, and a weak sensor loses its share of them too."""
        true = finger(noise=100.0, offset=[300.0, -250.0, 280.0, -300.0])
        at = np.linspace(-11e-3, 11e-3, 80)
        readings = true.read(ss.LineLoad(20.0, position=at), np.random.default_rng(0))
        readings[:, 3] *= 0.29
        found = ss.calibration.sensor_health(true, readings, friction=0, search=(-16e-3, 16e-3))
        assert found.health[3] == Health.WEAK
        assert found.gain_ratio[3] == pytest.approx(0.29, abs=0.05)
        np.testing.assert_allclose(found.gain_ratio[:3], 1.0, atol=0.1)


class TestMisfit:
    def test_a_model_that_fits(self):
        found = ss.calibrate(finger(), pressed(finger()), MOTOR, fit=FIT).misfit
        assert not found.structured
        assert not found.wrong
        assert found.over_noise == pytest.approx(1.0, abs=0.2)
        assert found.verdict.startswith("the model fits")

    def test_one_that_does_not_quite_fit_is_said_to(self):
        found = ss.calibrate(finger(), lumpy(finger()), MOTOR, fit=FIT).misfit
        assert found.structured
        assert not found.wrong
        assert found.along > 0.5
        assert found.over_noise > 1.7
        assert "does not quite fit" in found.verdict

    def test_no_elastic_skin_is_refused_and_named(self):
        with pytest.raises(ss.errors.ConvergenceError, match="this is no elastic skin like the one drawn"):
            ss.calibrate(finger(), channel(), MOTOR, fit=FIT)
        found = ss.calibrate(finger(), channel(), MOTOR, fit=FIT, accept_misfit=True)
        assert found.misfit.wrong
        assert found.misfit.stretched or found.misfit.share > 1 / 3

    def test_loads_that_are_not_alike_are_named(self):
        rng = np.random.default_rng(0)
        force = rng.uniform(5, 35, 40)
        readings = pressed(finger(), force=force)
        with pytest.raises(ss.errors.ConvergenceError, match="do not carry the same load"):
            ss.calibrate(finger(), readings, MOTOR, fit=FIT)
        assert not ss.calibrate(finger(), readings, MOTOR, fit=FIT, force=force).misfit.structured

    def test_noise_however_large_is_no_structure(self):
        """One in 15 000 by chance: none of 200, whatever their size."""
        rng = np.random.default_rng(0)
        for _ in range(200):
            rest, model = rng.normal(0, 1, (2, 40, 4))
            said = misfit_of(rest, model, MOTOR, np.ones(4), share=0.9, over_noise=1.0, stretched="", alike=False)
            assert not said.structured

    def test_a_parameter_at_the_end_of_its_range_is_said(self):
        flat = finger(depth=30e-3)  # as drawn 5.4 mm: five times that is looked through
        found = ss.calibrate(finger(), pressed(flat), MOTOR, fit=("gain", "depth"), origin=ORIGIN, accept_misfit=True)
        assert [p.name for p in found.ends] == ["depth"]
        assert any("depth is at the end of its range (0.027 m)" in said for said in found.doubts)


class TestErrorsThatHold:
    def test_a_process_is_told_from_noise(self):
        rng = np.random.default_rng(0)
        at, sensor = np.tile(np.linspace(-3, 3, 50), 4), np.repeat(np.arange(4), 50)
        jacobian = np.stack([np.ones(200), at, np.cos(at)], axis=-1)
        touch, slopes = np.tile(np.arange(50), 4), np.zeros((200, 5))
        white = Residuals(rng.normal(0, 1, 200), sensor, at, np.ones(200), touch, slopes, 0 * at)
        for noise_like in (True, False):
            assert correlated(white, jacobian, noise_like=noise_like) is None
        few = np.arange(0, 200, 20)  # of which three numbers were fitted, and that are larger than the noise
        assert correlated(white[few], jacobian[few], noise_like=True) is None
        few = np.arange(0, 200, 15)
        assert correlated(white[few], jacobian[few], noise_like=False) is not None
        truth = Correlated(0.3, np.array([0.0, 1.0, 0.0, 0.0]), np.zeros(4))  # over half a depth
        root = np.linalg.cholesky(truth.misfit(white, white) + 0.09 * np.eye(200))
        found = correlated(replace(white, value=root @ rng.normal(0, 1, 200)), jacobian, noise_like=True)
        assert found.own.argmax() == 1
        assert np.linalg.norm(found.own) == pytest.approx(1.0, rel=0.5)
        assert found.noise == pytest.approx(0.3, rel=0.2)
        expected = jacobian.T @ (root @ root.T) @ jacobian
        np.testing.assert_allclose(scatter(truth, white, jacobian), expected, atol=1e-9)

    def test_depths_of_a_lumpy_skin_are_off_by_no_more_than_is_said(self):
        """Over shifted halves of one recording; independent noise would have the error half of that or less."""
        long = np.linspace(-4e-3, 34e-3, 60)
        readings = lumpy(finger(), long)
        for rows in (np.arange(0, 40), np.arange(20, 60), np.arange(60)):
            found = ss.calibrate(finger(), readings[rows], long[rows], fit=FIT)
            depth = next(p for p in found.parameters if p.name == "depth")
            assert abs(depth.value - 5.4e-3) < 4 * depth.std
        noise = np.asarray(found.finger.array.noise)
        white = ss.calibrate(finger(), pressed(finger(noise=noise), long), long, fit=FIT)
        assert not white.misfit.structured
        assert depth.std > 2 * next(p for p in white.parameters if p.name == "depth").std


def test_the_choice_is_by_positions():
    true = finger()
    kinds = {"strain": ss.NormalStrain(), "stress": ss.NormalStress()}
    drawn = {name: (finger(transducer=kind, depth=5e-3), FIT) for name, kind in kinds.items()}
    found = choose(drawn, lumpy(true), MOTOR, friction=0, search=(-16e-3, 16e-3))
    assert [t.name for t in found.trials] == ["strain", "stress"]
    assert found.best.score < found.trials[1].score
    assert found.best.score == pytest.approx(np.hypot(found.best.rms, found.best.worst / 5) / found.best.ok)
    assert found.reason.startswith("strain: ")
    with pytest.raises(ss.errors.ConvergenceError, match=r"no candidate fits: .*no elastic skin"):
        choose({"strain": drawn["strain"]}, channel(), MOTOR, friction=0)
    with pytest.raises(ss.errors.InvalidValueError, match="at least 10"):
        choose(drawn, lumpy(true)[:9], MOTOR[:9])


TOML = """\
[skin]
young = "0.4 MPa"

[sensors]
count = 4
pitch = "6 mm"
depth = "5.4 mm"
gain = -1e6
noise = 10

[locate]
friction = 0
search = ["-16 mm", "16 mm"]
"""


@pytest.fixture
def folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "finger.toml").write_text(TOML)
    for name, readings in (("good", lumpy(finger())), ("channel", channel())):
        ss.io.write_table(f"{name}.csv", {"position": MOTOR} | {f"s{i}": readings[:, i] for i in range(4)})
    return tmp_path


class TestTheCommand:
    def test_no_finger_is_written_of_what_is_no_skin_unless_asked(self, folder):
        ran = subskin("calibrate", "finger.toml", "channel.csv", "-o", "new.toml")
        assert ran.code != 0
        assert "no elastic skin" in ran.err
        assert not (folder / "new.toml").exists()
        ran = subskin("calibrate", "finger.toml", "channel.csv", "-o", "new.toml", "--accept-misfit")
        assert (ran.code, (folder / "new.toml").exists()) == (0, True)
        assert "no elastic skin" in ran.out

    def test_few_touches_are_the_first_line(self, folder):
        ran = subskin("calibrate", "finger.toml", "good.csv", "--rows", "8,14,20,26")
        assert ran.code == 0
        assert ran.out.startswith("too few touches to check the fit")
        friction = TOML.replace("friction = 0", "friction = 0.5")
        (folder / "finger.toml").write_text(friction)
        ran = subskin("calibrate", "finger.toml", "good.csv")
        assert ran.out.startswith("4 live sensors leave a frame 1 spare reading, and at least 2 are wanted")

    def test_choose_writes_the_best_and_says_why(self, folder, monkeypatch):
        both = cli_choose._candidates
        monkeypatch.setattr(cli_choose, "_candidates", lambda *a: {k: v for k, v in both(*a).items() if "plane" in k})
        monkeypatch.setattr(cli_choose, "_KINDS", ("normal_strain", "normal_stress"))
        ran = subskin("calibrate", "finger.toml", "good.csv", "-o", "new.toml", "--choose", "--json")
        assert ran.code == 0, ran.err
        choice = json.loads(ran.out)["choice"]
        assert len(choice["candidates"]) == 3  # two kinds, and the strain with Poisson's ratio
        best = choice["candidates"][0]["name"]
        assert choice["reason"].startswith(best)
        assert best.startswith("normal strain of a half plane")
        assert ss.load("new.toml").finger.array.transducers[0] == ss.NormalStrain()
        assert subskin("calibrate", "finger.toml", "good.csv", "--choose", "--fit", "origin").code != 0

    def test_candidates_are_each_kind_in_each_skin(self, folder):
        found = cli_choose._candidates(ss.load("finger.toml"), FIT)
        assert len(found) == 2 * (3 + 1)
        for name, (file, fit) in found.items():
            layer = name.split(",")[0].endswith("a layer")
            assert np.isfinite(file.finger.skin.thickness) == layer == ("thickness" in fit)
            assert ("poisson" in fit) == name.endswith("fitted")
            assert file.finger.skin.single_material == SKIN.material
            assert file.search == (-16e-3, 16e-3)
