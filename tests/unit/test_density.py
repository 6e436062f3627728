"""Density of sensors, the error between them, and what sliding adds: against roots and integrals spelt out here."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.optimize import brentq
from scipy.special import j0, j1

import subskin as ss
from subskin.design import aliasing_error, sensor_density, sliding_samples, spatial_response
from subskin.memo import eq26_corrected
from subskin.plot import aliasing_figure, density_figure

D = 2e-3
RUBBER = ss.Material(0.4e6, 0.5)
HALF = ss.HalfPlane(RUBBER)
LAYER = ss.Layered(ss.Layer(RUBBER, 6e-3))
TIP = ss.Round(RUBBER, 8e-3, 4e-3)


def finger(skin=HALF, **more):
    return ss.Finger(skin, ss.SensorArray(**{"y": [0.0], "depth": D, **more}))


def last_root(function, ends):
    """Where a function of k d is 0 for the last time: a fine scan, then Brent."""
    x = np.linspace(*ends, 60001)
    at = np.flatnonzero(np.diff(np.sign(function(x))))[-1]
    return brentq(function, x[at], x[at + 1], xtol=1e-14)


class TestDensity:
    def test_the_memo_s_number_and_others(self):
        wanted = [10.0, 100.0, 1000.0, 1e4]
        found = sensor_density(finger(), wanted)
        assert found.density[:, 0] * D == pytest.approx(eq26_corrected(wanted) / np.pi, rel=1e-11)
        assert found.density[2, 0] * D == pytest.approx(3.25739667896, abs=1e-10)
        # the memo's 3.2 falls short: exp(f - 1) / f at f = 3.2 pi
        assert 1 / found.relative(np.pi * 3.2 / D)[0] == pytest.approx(850, abs=0.5)
        assert found.peak[0] * D == pytest.approx(1.0, rel=1e-6)
        assert found.largest[0] * 0.4e6 == pytest.approx(1.5 / np.e, rel=1e-13)

    def test_shear_is_read_most_at_long_waves(self):
        found = sensor_density(finger(), 1e3)
        assert found.peak[1] == 0
        f = last_root(lambda x: (x - 1) * np.exp(-x) - 1e-3, (2, 20))
        assert round(f, 3) == 8.985
        assert found.nyquist[1] * D == pytest.approx(f, rel=1e-10)

    @pytest.mark.parametrize("a", [0.5e-3, 2e-3, 6e-3])
    @pytest.mark.parametrize(
        ("kind", "spectrum"),
        [(ss.Hertz, lambda x: 2 * j1(x) / x), (ss.FlatPunch, j0), (ss.Strip, lambda x: np.sin(x) / x)],
    )
    def test_all_waves_beyond_count(self, kind, spectrum, a):
        """A spectrum has zeros: it is the last crossing that decides, not the first."""
        contact = kind(17.0, 0.3, 1e-3, half_width=a)
        found = sensor_density(finger(), 500.0, contact=contact)

        def size(x):
            return np.abs(x * np.exp(-x) * spectrum(x * a / D))

        peak = size(np.linspace(1e-4, 3, 300001)).max()
        f = last_root(lambda x: size(x) - peak / 500, (0.01, 30))
        assert found.nyquist[0] * D == pytest.approx(f, rel=1e-9)
        assert found.relative(found.nyquist[0])[0] == pytest.approx(1 / 500, rel=1e-9)
        beyond = found.nyquist[0] * np.linspace(1.0001, 4, 5000)
        assert found.relative(beyond)[:, 0].max() < 1 / 500

    def test_rounded_things_ask_for_less_than_a_line(self):
        line = sensor_density(finger(), 1e3).pitch[0]
        roller = sensor_density(finger(), 1e3, contact=ss.Hertz(1.0, half_width=D)).pitch[0]
        assert roller > 1.5 * line

    def test_force_position_and_angle_of_the_contact_do_not_matter(self):
        one = sensor_density(finger(), [30, 1e3], contact=ss.Wedge(1.0, half_width=D))
        other = sensor_density(finger(), [30, 1e3], contact=ss.Wedge(40.0, -0.4, 5e-3, half_width=D))
        np.testing.assert_allclose(one.pitch, other.pitch, rtol=1e-9)
        np.testing.assert_allclose(one.error_pitch, other.error_pitch, rtol=1e-9)

    def test_a_wide_sensor_is_as_good_as_a_strip(self):
        wide = sensor_density(finger(width=3e-3), [10, 1e3])
        strip = sensor_density(finger(), [10, 1e3], contact=ss.Strip(1.0, half_width=1.5e-3))
        np.testing.assert_allclose(wide.pitch, strip.pitch, rtol=1e-9)
        np.testing.assert_allclose(wide.error_pitch, strip.error_pitch, rtol=1e-4)

    @pytest.mark.parametrize("skin", [LAYER, ss.HalfPlane(ss.Material(1e6, 0.4), "stress")])
    def test_other_skins(self, skin):
        found = sensor_density(finger(skin), 200.0)
        k = np.linspace(1e-3, 40 / D, 80001)
        size = np.abs(spatial_response(finger(skin), k).amplitude[:, 0])
        for load in (0, 1):
            last = k[np.flatnonzero(size[:, load] > found.largest[load] / 200)[-1]]
            assert found.nyquist[load] == pytest.approx(last, rel=5e-4)
            assert size[:, load].max() <= found.largest[load] * (1 + 1e-12)
            assert size[:, load].max() > 0.998 * found.largest[load]

    def test_round_a_finger_goes_a_whole_number_of_sensors(self):
        found = sensor_density(finger(TIP), [10, 1e3])
        n = np.arange(200)
        size = np.abs(spatial_response(finger(TIP), n / 8e-3).amplitude[:, 0])
        for i, ratio in enumerate((10, 1e3)):
            for load in (0, 1):
                count = TIP.period / found.pitch[i, load]
                last = n[size[:, load] > size[:, load].max() / ratio][-1]
                assert count == pytest.approx(2 * last + 1, rel=1e-12)

    def test_a_sliding_layer_answers_long_drags_without_bound(self):
        loose = ss.Layered(ss.Layer(RUBBER, 6e-3, "frictionless"))
        found = sensor_density(finger(loose), 1e3)
        assert np.isfinite(found.pitch[0])
        assert np.isnan(found.pitch[1])
        assert np.isfinite(found.error_pitch).all()

    def test_shapes(self):
        found = sensor_density(finger(), np.full((2, 3), 100))
        assert found.pitch.shape == found.error_pitch.shape == found.density.shape == (2, 3, 2)
        assert found.relative(np.ones((4, 5))).shape == (4, 5, 2)
        assert found.rate(0.05).shape == (2, 3, 2)
        assert found.rate(-0.05)[0, 0, 0] == pytest.approx(0.05 / found.pitch[0, 0, 0])
        for values in (found.pitch, found.error_pitch, found.peak, found.largest, found.relative(1.0)):
            assert not values.flags.writeable

    def test_the_sensor_named_is_the_one_repeated(self):
        two = ss.Finger(HALF, ss.SensorArray(y=[0.0, 1e-3], depth=[D, 2 * D], gain=[1.0, 5.0]))
        assert sensor_density(two, 1e3, sensor=1).pitch[0] == pytest.approx(2 * D / 3.25739667896)

    def test_what_is_refused(self):
        with pytest.raises(ss.errors.InvalidValueError, match="attenuation"):
            sensor_density(finger(), 1.0)
        with pytest.raises(ss.errors.InvalidValueError, match="sensor = 1"):
            sensor_density(finger(), sensor=1)
        with pytest.raises(ss.errors.InvalidValueError, match="dead"):
            sensor_density(finger(gain=0.0))
        with pytest.raises(ss.errors.GeometryError, match="single"):
            sensor_density(finger(), contact=ss.LineLoad([1.0, 2.0]))
        with pytest.raises(ss.errors.GeometryError, match="too wide"):
            sensor_density(finger(), contact=ss.Strip(1.0, half_width=3.0))
        base = finger(ss.Layered(ss.Layer(RUBBER, D)), transducer=ss.LateralStrain())
        with pytest.raises(ss.errors.InvalidValueError, match="nothing"):
            sensor_density(base)
        with pytest.raises(ss.errors.NotLinearError):
            sensor_density(finger(transducer=ss.EnergyDensity()))


def spectrum_of(tip, contact):
    """Its reading's transform at k, from the response and the contact's spectrum."""

    def at(k):
        p, q = contact.spectrum(np.asarray(k))
        h = spatial_response(tip, k).amplitude[..., 0, :]
        return p * h[..., 0] + q * h[..., 1]

    return at


class TestError:
    @pytest.mark.parametrize("pitch", [1.3, 0.8, 0.5, 1 / 3.2574])
    def test_a_line_load_meets_the_bound_midway_between_two_sensors(self, pitch):
        """2 (f + 1) exp(-f) of the peak, f = pi d / spacing; less what comes back from three times that."""
        found = aliasing_error(finger(), ss.LineLoad(40.0), pitch * D)
        f = np.pi / pitch
        # at the load itself wave k of the fold m counts (-1)^m - 1 times: only the odd folds are wrong
        tails = [2 * (m * f + 1) * np.exp(-m * f) for m in (1, 3, 5, 7)]
        exact = tails[0] - tails[1] + tails[2] - tails[3]
        assert found.bound == pytest.approx(tails[0], rel=1e-3)
        assert found.largest == pytest.approx(exact, rel=1e-6)
        assert found.at_nyquist == pytest.approx(min(f * np.exp(1 - f), 1.0), rel=1e-3)
        assert found.full_scale == pytest.approx(3 * 40.0 / (2 * np.pi * 0.4e6 * D), rel=1e-9)

    def test_shear_makes_nine_times_the_error_at_the_same_criterion(self):
        """8 f exp(-f) of the largest reading: the criterion's peak is at waves so long that they move no reading."""
        pitch = float(sensor_density(finger(), 1e3).pitch[1])
        found = aliasing_error(finger(), ss.LineLoad(40.0, np.pi / 2), pitch)
        f = np.pi * D / pitch
        assert found.bound == pytest.approx(8 * f * np.exp(-f), rel=2e-3)
        assert 0.95 * found.bound < found.largest <= found.bound
        assert found.bound == pytest.approx(9.0e-3, rel=0.01)

    def test_error_pitch_keeps_the_error_below(self):
        found = sensor_density(finger(), [50, 1000])
        for i, ratio in enumerate((50, 1000)):
            press = brentq(lambda f, r=ratio: 2 * (f + 1) * np.exp(-f) - 1 / r, 2, 30)
            drag = brentq(lambda f, r=ratio: 8 * f * np.exp(-f) - 1 / r, 2, 30)
            assert np.pi * D / found.error_pitch[i] == pytest.approx([press, drag], rel=2e-4)
        for load, angle in enumerate((0.0, np.pi / 2)):
            error = aliasing_error(finger(), ss.LineLoad(1.0, angle), float(found.error_pitch[1, load]))
            assert 0.95e-3 < error.largest < 1.0005e-3

    @pytest.mark.parametrize(
        ("skin", "contact", "pitch"),
        [
            (HALF, ss.Hertz(40.0, 0.3, 0.4e-3, half_width=2e-3), 1.6e-3),
            (HALF, ss.FlatPunch(40.0, half_width=3e-3), 1.1e-3),
            (HALF, ss.Strip(9.0, -0.5, half_width=2e-3) + ss.LineLoad(20.0, 0.2, 3e-3), 1.5e-3),
            (ss.HalfPlane(ss.Material(1e6, 0.4), "stress"), ss.Wedge(40.0, 0.2, half_width=1e-3), 2e-3),
            (LAYER, ss.Hertz(40.0, 0.6, half_width=1e-3), 1.5e-3),
        ],
    )
    def test_mean_square_over_the_shifts_is_that_of_the_folds(self, skin, contact, pitch):
        """At a place, and over all shifts: what each fold brings, and what is missing, squared and added."""
        tip = finger(skin, transducer=ss.NormalStrain())
        found = aliasing_error(tip, contact, pitch, shifts=16)
        assert found.largest <= found.bound * (1 + 1e-3)
        nyquist, read = np.pi / pitch, spectrum_of(tip, contact)
        t, w = np.polynomial.legendre.leggauss(60)
        y = found.position[:: max(1, found.position.size // 40)]
        total, missing = np.zeros(y.size), np.zeros(y.size, dtype=complex)
        for m in range(1, 12):  # the fold about 2 m nyquist
            k = nyquist * (2 * m + t)
            wave = read(k) * np.exp(1j * np.outer(y, k)) @ (nyquist * w) / (2 * np.pi)
            missing += wave
            total += 2 * np.abs(wave) ** 2  # of either sign of k
        exact = total + (2 * missing.real) ** 2
        seen = (found.error[:, :: max(1, found.position.size // 40)] ** 2).mean(axis=0)
        assert np.abs(np.sqrt(seen) - np.sqrt(exact)).max() < 2e-6 * found.full_scale
        assert found.rms == pytest.approx(np.sqrt((found.error**2).mean(axis=0).max()) / found.full_scale)

    def test_bound_is_the_integral_of_the_spectrum(self):
        tip, contact, pitch = finger(), ss.Hertz(40.0, 0.3, half_width=1e-3), 2e-3
        read = spectrum_of(tip, contact)
        whole = quad(lambda k: abs(read(k)), np.pi / pitch, 30 / D, limit=400, epsrel=1e-9)[0]
        found = aliasing_error(tip, contact, pitch)
        assert found.bound * found.full_scale == pytest.approx(2 / np.pi * whole, rel=1e-4)

    @pytest.mark.parametrize("count", [13, 14])
    def test_round_a_finger(self, count):
        """Harmonics of half the number of sensors and more are folded; sampled and solved for as a linear system."""
        contact, tip = ss.Hertz(40.0, 0.3, 1e-3, half_width=1e-3), finger(TIP)
        found = aliasing_error(tip, contact, TIP.period / (count - 0.5), shifts=4)
        assert found.pitch == pytest.approx(TIP.period / count, rel=1e-12)
        assert found.largest <= found.bound
        for shift, error in zip(found.shift, found.error, strict=True):
            at = 1e-3 + shift + found.pitch * np.arange(count)
            samples = ss.Finger(TIP, ss.SensorArray(y=at, depth=D)).measure(contact)
            half = (count - 1) // 2
            phase = np.outer(at, np.arange(1, half + 1)) / 8e-3
            here = np.outer(found.position, np.arange(1, half + 1)) / 8e-3
            rows = [np.ones((count, 1)), np.cos(phase), np.sin(phase)]
            columns = [np.ones((found.position.size, 1)), np.cos(here), np.sin(here)]
            if count % 2 == 0:  # the wave of two spacings is seen as a cosine about a sensor
                rows.append(np.cos(count / 2 * (at - at[0]) / 8e-3)[:, None])
                columns.append(np.cos(count / 2 * (found.position - at[0]) / 8e-3)[:, None])
            joined = np.concatenate(columns, axis=1) @ np.linalg.solve(np.concatenate(rows, axis=1), samples)
            assert np.abs(joined - found.reading - error).max() < 1e-11 * found.full_scale

    def test_a_longer_row_changes_nothing(self, monkeypatch):
        from subskin.design.sampling import aliasing

        contact = ss.LineLoad(40.0, 1.2)
        short = aliasing_error(finger(), contact, 1e-3)
        monkeypatch.setattr(aliasing, "_BEYOND", 400.0)
        long = aliasing_error(finger(), contact, 1e-3)
        assert np.abs(short.error - long.error).max() < 1e-10 * short.full_scale

    def test_pitch_of_the_finger_itself(self):
        row = ss.Finger(HALF, ss.SensorArray.line(5, pitch=1.2e-3, depth=D))
        assert aliasing_error(row, ss.LineLoad(1.0)).pitch == pytest.approx(1.2e-3)
        uneven = ss.Finger(HALF, ss.SensorArray(y=[0.0, 1e-3, 3e-3], depth=D))
        with pytest.raises(ss.errors.GeometryError, match="evenly"):
            aliasing_error(uneven, ss.LineLoad(1.0))
        with pytest.raises(ss.errors.GeometryError, match="evenly"):
            aliasing_error(finger(), ss.LineLoad(1.0))

    def test_what_is_refused(self):
        with pytest.raises(ss.errors.InvalidValueError, match="pitch"):
            aliasing_error(finger(), ss.LineLoad(1.0), 0.0)
        with pytest.raises(ss.errors.InvalidValueError, match="shifts"):
            aliasing_error(finger(), ss.LineLoad(1.0), 1e-3, shifts=1)
        with pytest.raises(ss.errors.InvalidValueError, match="nothing"):
            aliasing_error(finger(), ss.LineLoad(0.0), 1e-3)
        with pytest.raises(ss.errors.GeometryError, match="single"):
            aliasing_error(finger(), ss.LineLoad([1.0, 2.0]), 1e-3)


class TestSliding:
    ROW = ss.SensorArray.line(count=4, pitch=1e-3, depth=D)

    def test_even_steps_between(self):
        found = sliding_samples(self.ROW, speed=0.08, rate=100)
        assert found.step == pytest.approx(0.8e-3)
        assert found.pitch == pytest.approx(0.2e-3)
        assert found.mean_pitch == pytest.approx(0.2e-3)
        assert found.noise_gain == pytest.approx(1.0, abs=1e-9)
        assert found.visits == 1
        assert found.distance == pytest.approx(3.8e-3)

    @pytest.mark.parametrize("step", [1e-3, 0.5e-3, 0.25e-3])
    def test_sensors_whole_steps_apart_follow_each_other(self, step):
        found = sliding_samples(self.ROW, speed=step * 50, rate=50)
        assert found.position.size == 1
        assert found.pitch == pytest.approx(step)
        assert found.visits == 4

    def test_positions_are_those_of_a_simulated_slide(self):
        rng = np.random.default_rng(0)
        for _ in range(20):
            row = ss.SensorArray(y=np.sort(rng.uniform(0, 5e-3, 5)), depth=D)
            found = sliding_samples(row, speed=-rng.uniform(0.02, 0.2), rate=100)
            y = np.asarray(row.y)
            every = np.sort((y[:, None] + found.step * np.arange(2000)).reshape(-1))
            inside = every[(every > y[-1] + 50 * found.step) & (every < y[-1] + 60 * found.step)]
            assert np.diff(inside).max() == pytest.approx(found.pitch, rel=1e-9)
            assert np.diff(inside).mean() == pytest.approx(found.mean_pitch, rel=0.1)
            shifted = np.mod((found.position[:, None] - inside) / found.step + 0.5, 1) - 0.5
            assert np.abs(shifted).min(axis=1).max() < 1e-9

    def test_noise_of_bunched_samples(self):
        """Two places a step, `share` of it apart: noise goes with 1 / sin(pi share), by Monte-Carlo too."""
        for share in (0.5, 0.3, 0.1):
            row = ss.SensorArray(y=[0.0, share * 1e-3], depth=D)
            found = sliding_samples(row, speed=0.1, rate=100)
            assert found.noise_gain == pytest.approx(1 / np.sin(np.pi * share), rel=1e-9)
        rng, share, count = np.random.default_rng(1), 0.2, 64
        y = np.concatenate([np.arange(count), np.arange(count) + share])
        waves = np.exp(2j * np.pi * np.outer(y, np.arange(-count, count)) / count)
        noise = np.linalg.solve(waves, rng.standard_normal((2 * count, 400)))
        even = np.exp(2j * np.pi * np.outer(np.arange(2 * count) / 2, np.arange(-count, count)) / count)
        seen = np.sqrt(np.mean(np.abs(even @ noise) ** 2))
        row = ss.SensorArray(y=[0.0, share * 1e-3], depth=D)
        assert sliding_samples(row, speed=0.1, rate=100).noise_gain == pytest.approx(seen, rel=0.02)

    def test_only_sensors_of_a_kind_count(self):
        row = replace(self.ROW, depth=[D, D, 2 * D, D], gain=[1.0, 1.0, 1.0, 0.0])
        found = sliding_samples(row, speed=0.08, rate=100)
        assert found.position.size == 2
        assert sliding_samples(row, speed=0.08, rate=100, sensor=2).position.size == 1

    def test_what_is_refused(self):
        with pytest.raises(ss.errors.InvalidValueError, match="speed"):
            sliding_samples(self.ROW, speed=0.0, rate=100)
        with pytest.raises(ss.errors.InvalidValueError, match="rate"):
            sliding_samples(self.ROW, speed=0.1, rate=0)
        with pytest.raises(ss.errors.InvalidValueError, match="sensor"):
            sliding_samples(self.ROW, speed=0.1, rate=10, sensor=4)
        with pytest.raises(ss.errors.GeometryError, match="dead"):
            sliding_samples(replace(self.ROW, gain=0.0), speed=0.1, rate=10)


class TestFigures:
    def test_density_marks_each_attenuation_where_its_curve_passes(self):
        found = sensor_density(finger(), [10, 1000])
        axes = density_figure(found).axes[0]
        marks = [line.get_xydata() for line in axes.lines if line.get_marker() == "o"]
        for load, mark in enumerate(marks):
            np.testing.assert_allclose(mark[:, 0], 0.5 / (1e3 * found.pitch[:, load]))
            np.testing.assert_allclose(mark[:, 1], [0.1, 0.001])
            curve = {line.get_label(): line for line in axes.lines}[("pressure", "shear")[load]]
            x, y = curve.get_xydata().T
            np.testing.assert_allclose(np.interp(mark[:, 0], x, np.log(y)), np.log(mark[:, 1]), atol=2e-3)
        with pytest.raises(ss.errors.GeometryError, match="row"):
            density_figure(sensor_density(finger(), np.full((2, 2), 100)))

    def test_density_without_a_bound_draws_the_other_load_alone(self):
        loose = ss.Layered(ss.Layer(RUBBER, 6e-3, "frictionless"))
        axes = density_figure(sensor_density(finger(loose), 1e3)).axes[0]
        names = {line.get_label() for line in axes.lines}
        assert "pressure" in names
        assert "shear" not in names

    def test_error_is_drawn_with_its_bound(self):
        found = aliasing_error(finger(), ss.Hertz(40.0, 0.3, half_width=1e-3), D)
        upper, lower = aliasing_figure(found).axes
        worst = np.unravel_index(np.abs(found.error).argmax(), found.error.shape)[0]
        curves = {line.get_label(): line.get_xydata() for line in (*upper.lines, *lower.lines)}
        scale = 100 / found.full_scale
        np.testing.assert_allclose(curves["error"][:, 1], scale * found.error[worst])
        np.testing.assert_allclose(curves["recovered"][:, 1], scale * (found.reading + found.error[worst]))
        assert curves["bound"][0, 1] == pytest.approx(100 * found.bound)
        y, values = curves["sensors"].T
        np.testing.assert_allclose(np.diff(y), 1e3 * found.pitch)
        np.testing.assert_allclose(np.interp(y, *curves["recovered"].T), values, atol=0.2)  # joined there
        with pytest.raises(ss.errors.GeometryError, match="shift"):
            aliasing_figure(found, shift=16)


SPACE = ss.HalfSpace(RUBBER)
TABLE = {  # k d at attenuations of 10, 100, 1000 (docs/density.md): closed forms of each response
    ss.MeanPressure(): lambda x: np.exp(-x),
    ss.NormalStress(): lambda x: (1 + x) * np.exp(-x),
    ss.NormalStrain(): lambda x: x * np.exp(1 - x),
}


class TestLattices:
    @pytest.mark.parametrize("kind", TABLE, ids=str)
    def test_pitch_and_density_are_those_of_the_closed_forms(self, kind):
        wanted = np.array([10.0, 1000.0])
        pad = ss.Finger(SPACE, ss.SensorArray(y=[0.0], depth=D, transducer=kind))
        square, hexagonal = (sensor_density(pad, wanted, lattice=name) for name in ("square", "hexagonal"))
        for i, ratio in enumerate(wanted):
            k = last_root(lambda x, ratio=ratio: TABLE[kind](x) - 1 / ratio, (1e-3, 30))
            assert square.nyquist[i, 0] * D == pytest.approx(k, rel=1e-6)
            assert square.pitch[i, 0] == pytest.approx(np.pi * D / k, rel=1e-6)
            assert hexagonal.pitch[i, 0] == pytest.approx(2 * np.pi * D / np.sqrt(3) / k, rel=1e-6)
            assert square.density[i, 0] * D**2 == pytest.approx((k / np.pi) ** 2, rel=1e-6)
        assert hexagonal.density / square.density == pytest.approx(np.sqrt(3) / 2, rel=1e-9)
        assert (square.error_pitch < square.pitch).all()

    def test_the_numbers_of_one_in_a_thousand(self):
        for kind, per in ((ss.NormalStrain(), (10.61, 9.19)), (ss.MeanPressure(), (4.83, 4.19))):
            pad = ss.Finger(SPACE, ss.SensorArray(y=[0.0], depth=D, transducer=kind))
            for lattice, number in zip(("square", "hexagonal"), per, strict=True):
                assert sensor_density(pad, lattice=lattice).density[0] * D**2 == pytest.approx(number, abs=0.006)

    @pytest.mark.long
    @pytest.mark.parametrize("kind", [ss.ShearStrain("xy"), ss.LateralStrain(0.4), ss.transducer.Displacement("z")])
    @pytest.mark.parametrize("skin", [SPACE, ss.Layered([ss.Layer(RUBBER, 3e-3), ss.Layer(ss.Material(1e6), 2e-3)])])
    def test_a_wave_in_any_direction_reads_as_the_field_of_a_wavy_patch(self, skin, kind):
        """Against the field of a wide Gaussian-windowed wave, by the map of a PressureGrid."""
        from subskin.design.sampling._plane import EndlessLattice

        pad = ss.Finger(skin, ss.SensorArray(y=[0.0], depth=D, transducer=kind))
        k, phi, wide = 1.1 / D, 0.6, 8 * D
        at = np.arange(-3.2 * wide, 3.2 * wide + 1e-9, D / 4)
        y, z = np.meshgrid(at, at, indexing="ij")
        along = y * np.cos(phi) + z * np.sin(phi)
        shape = np.exp(-(y**2 + z**2) / (2 * wide**2))
        # the same of the interpolated nodes: bilinear hats pass this share of a wave
        share = np.prod([np.sinc(k * c * D / 8 / np.pi) ** 2 for c in (np.cos(phi), np.sin(phi))])
        read = EndlessLattice.of(pad, 0).filters(np.array([k]), np.array([phi]))[0]
        size = np.abs(read).max()
        for load in range(3):
            seen = []
            for wave in (np.cos(k * along), np.sin(k * along)):
                values = np.zeros((3, *shape.shape))
                values[load] = wave * shape
                grid = ss.PressureGrid(at, at, values[0], np.moveaxis(values[1:], 0, -1))
                seen.append(float(kind.measure(skin.map(grid, D, np.zeros(1), np.zeros(1)))[0, 0]))
            assert complex(*seen) / share == pytest.approx(complex(read[load]), abs=0.03 * size)

    def test_what_is_read_beyond_the_first_zone(self):
        strain = ss.Finger(SPACE, ss.SensorArray(y=[0.0], depth=D))
        pressure = ss.Finger(SPACE, ss.SensorArray(y=[0.0], depth=D, transducer=ss.MeanPressure()))
        for pad, rows in ((strain, (1e-4, 0.027, 0.14, 0.31)), (pressure, (1e-5, 0.0046, 0.034, 0.091))):
            for pitch, number in zip((0.25, 0.5, 0.75, 1.0), rows, strict=True):
                found = aliasing_error(pad, pitch=pitch * D, lattice="square")
                assert found.beyond[0] == pytest.approx(number, rel=0.1)
        same = np.sqrt(2 / np.sqrt(3))  # of the same density
        for pitch, number in ((0.5, 0.021), (0.75, 0.128)):
            found = aliasing_error(strain, pitch=pitch * same * D, lattice="hexagonal")
            assert found.beyond[0] == pytest.approx(number, rel=0.03)

    def test_the_error_is_that_of_samples_joined_again(self):
        """A touch sampled on a square lattice in all its shifts, by fast Fourier transforms over a wide area."""
        pad = ss.Finger(SPACE, ss.SensorArray(y=[0.0], depth=D, transducer=ss.MeanPressure()))
        touch, finer, count = ss.RoundHertz(force=1.0, angle=0.3, azimuth=0.5, half_width=1e-3), 4, 16
        pitch = 1.3 * D
        at = pitch / finer * (np.arange(finer * count) - finer * count / 2)
        true = ss.MeanPressure().measure(SPACE.map(touch, D, at, at))
        off = 0.0
        waves = np.fft.fftfreq(finer * count) * finer
        within = (np.abs(waves)[:, None] < 0.5) & (np.abs(waves) < 0.5)
        for i in range(finer):
            for j in range(finer):
                samples = np.zeros_like(true)
                samples[i::finer, j::finer] = true[i::finer, j::finer] * finer**2
                again = np.fft.ifft2(np.where(within, np.fft.fft2(samples), 0.0)).real
                off += ((again - true) ** 2).mean() / finer**2
        found = aliasing_error(pad, touch, pitch, lattice="square")
        assert found.rms == pytest.approx(np.sqrt(off / (true**2).mean()), rel=0.03)

    def test_the_error_made_is_an_integral_over_the_waves_beyond(self):
        """Of pressure, exp(-k d): (1/pi) times the integral of k exp(-k d) from K, over 1 / (2 pi d^2) at a point."""
        pad = ss.Finger(SPACE, ss.SensorArray.grid((3, 3), D, depth=D, transducer=ss.MeanPressure()))
        found = sensor_density(pad, [10.0, 100.0], lattice="square").error_pitch[:, 0]
        for pitch, ratio in zip(found, (10.0, 100.0), strict=True):
            kd = brentq(lambda x, ratio=ratio: 2 * (x + 1) * np.exp(-x) - 1 / ratio, 0.1, 40.0)
            assert pitch == pytest.approx(np.pi * D / kd, rel=1e-3)

    def test_the_finger_s_own_lattice_is_meant(self):
        grid = ss.Finger(SPACE, ss.SensorArray.grid(shape=(3, 3), pitch=D, depth=D))
        comb = ss.Finger(SPACE, ss.SensorArray.hexagonal(shape=(3, 3), pitch=D, depth=D))
        for pad, lattice in ((grid, "square"), (comb, "hexagonal")):
            assert sensor_density(pad, 10.0).lattice == lattice
            found = aliasing_error(pad)
            assert (found.lattice, found.pitch) == (lattice, pytest.approx(D))

    def test_what_a_lattice_refuses(self):
        row, pad = finger(), ss.Finger(SPACE, ss.SensorArray(y=[0.0], depth=D))
        for call, message in (
            (lambda: sensor_density(row, lattice="square"), "solved in a plane"),
            (lambda: sensor_density(pad, lattice="round"), '"row", "square" or "hexagonal"'),
            (lambda: sensor_density(pad, lattice="square", contact=ss.Hertz(1.0, half_width=D)), "worst case"),
            (lambda: aliasing_error(row), "a long contact"),
            (lambda: aliasing_error(pad, lattice="square"), "pitch="),
            (lambda: aliasing_error(pad, ss.LineLoad(1.0), D, lattice="square"), "a local contact"),
        ):
            with pytest.raises(ss.SubskinError, match=message):
                call()
