"""Calibration on touches at known places."""

from __future__ import annotations

import numpy as np
import pytest

import subskin as ss
from subskin.errors import InvalidValueError

SKIN = ss.HalfPlane(ss.Material(young=0.4e6, poisson=0.45))
PLACES = np.linspace(0, 32e-3, 65)
ORIGIN = 16.3e-3


def true_finger(noise=1e-6, **changes):
    parameters = {
        "y": [-9.1e-3, -3.0e-3, 3.2e-3, 8.9e-3],
        "depth": [5.2e-3, 5.5e-3, 5.4e-3, 5.1e-3],
        "gain": [80.0, -110.0, 90.0, 100.0],
        "offset": [0.1, -0.2, 0.0, 0.3],
        "width": 2e-3,
        "noise": noise,
    }
    return ss.Finger(SKIN, ss.SensorArray(**{**parameters, **changes}))


def drawn(poisson=0.5, **changes):
    array = ss.SensorArray.line(4, pitch=6e-3, depth=5e-3, width=1e-3, **changes)
    return ss.Finger(ss.HalfPlane(ss.Material(young=0.4e6, poisson=poisson)), array)


def touch(finger, positions=PLACES, seed=0, **load):
    return finger.read(ss.LineLoad(**{"force": 1.0, **load}, position=positions - ORIGIN), np.random.default_rng(seed))


def errors_in_sigma(found, truth):
    values = {"origin": ORIGIN, "poisson": truth.skin.material.poisson, "width": truth.array.width[0]}
    out = []
    for p in found.parameters:
        expected = values[p.name] if p.name in values else getattr(truth.array, p.name)[p.sensor or 0]
        out.append((p.value - expected) / p.std)
    return np.array(out)


def test_everything_at_once_is_recovered_within_its_standard_errors():
    truth = true_finger()
    fit = ("gain", "offset", "depths", "origin", "position", "poisson", "width")
    readings = touch(truth)
    # with the origin and the places both free, the mean place stays as drawn: draw it right
    start = ss.Finger(drawn().skin, ss.SensorArray(y=np.array([-9, -3, 3, 9]) * 1e-3, depth=5e-3, width=1e-3))
    found = ss.calibrate(start, readings, PLACES, fit=fit)
    assert len(found.parameters) == 4 * 4 + 3
    sigma = errors_in_sigma(found, truth)
    assert np.abs(sigma).max() < 4.5
    assert 0.3 < np.sqrt((sigma**2).mean()) < 2.0
    np.testing.assert_allclose(found.finger.array.noise, 1e-6, rtol=0.4)
    assert found.r2 > 0.999999
    assert not found.weak.any()


@pytest.mark.long
def test_standard_errors_are_the_scatter_over_repeats():
    truth = true_finger(noise=2e-4, y=[-9e-3, -3e-3, 3e-3, 9e-3], depth=5.3e-3, width=0.0)
    start = ss.Finger(SKIN, ss.SensorArray.line(4, pitch=6e-3, depth=5e-3))
    repeats = 30
    runs = [ss.calibrate(start, touch(truth, seed=s), PLACES, origin=16e-3) for s in range(repeats)]
    values = np.array([[p.value for p in r.parameters] for r in runs])
    claimed = np.array([[p.std for p in r.parameters] for r in runs])
    np.testing.assert_allclose(values.std(0, ddof=1), claimed.mean(0), rtol=0.4)  # 3 standard errors of a scatter
    bias = (values.mean(0) - [ORIGIN, 5.3e-3, *truth.array.gain, *truth.array.offset]) / values.std(0)
    assert np.abs(bias).max() < 4.5 / np.sqrt(repeats)


def test_known_forces_and_angles_are_used():
    truth = true_finger(y=[-9e-3, -3e-3, 3e-3, 9e-3], depth=5.3e-3, width=0.0, offset=0.0)
    rng = np.random.default_rng(4)
    force, angle = rng.uniform(5, 20, 65), rng.uniform(-0.6, 0.6, 65)
    readings = touch(truth, force=force, angle=angle)
    start = ss.Finger(SKIN, ss.SensorArray.line(4, pitch=6e-3, depth=5e-3))
    found = ss.calibrate(start, readings, PLACES, fit=("gain", "depth", "origin"), force=force, angle=angle)
    assert np.abs(errors_in_sigma(found, truth)).max() < 4.5
    located = found.finger.locate(readings)
    ok = located.status == ss.Status.OK
    np.testing.assert_allclose(located.force[ok], force[ok], rtol=1e-2)


def test_three_touches_find_the_origin_of_a_known_finger():
    truth = true_finger(noise=1e-4)
    rows = [10, 30, 50]
    found = ss.calibrate(truth, touch(truth)[rows], PLACES[rows], fit=("origin",))
    assert abs(found.origin - ORIGIN) < 4.5 * found.parameters[0].std + 1e-9
    assert found.parameters[0].std < 0.05e-3
    np.testing.assert_array_equal(found.finger.array.gain, truth.array.gain)


def test_dead_and_weak_sensors_and_missing_readings_are_said():
    truth = true_finger(gain=[80.0, 0.0, 90.0, 5.0], noise=1e-5)
    readings = np.array(touch(truth))
    readings[::7, 0] = np.nan
    found = ss.calibrate(drawn(poisson=0.45), readings, PLACES, fit=("gain", "offset", "depth", "origin", "position"))
    assert found.health == (
        ss.calibration.Health.OK,
        ss.calibration.Health.DEAD,
        ss.calibration.Health.OK,
        ss.calibration.Health.WEAK,
    )
    assert found.weak.tolist() == [False, True, False, True]
    assert found.finger.array.gain[1] == 0
    stuck = np.array(touch(true_finger()))
    stuck[:, 2] = 101325.0
    assert ss.calibrate(drawn(), stuck, PLACES).health[2] == ss.calibration.Health.DEAD


def test_the_score_on_held_out_touches_is_that_of_its_formula():
    truth = true_finger(noise=2e-3)
    readings = touch(truth)
    found = ss.calibrate(drawn(), readings[::2], PLACES[::2])
    score = found.evaluate(readings[1::2], PLACES[1::2])
    model = found.finger.read(ss.LineLoad(1.0, position=PLACES[1::2] - found.origin))
    rest, spread = readings[1::2] - model, readings[1::2] - readings[1::2].mean(0)
    np.testing.assert_allclose(score.r2, 1 - (rest**2).sum() / (spread**2).sum(), rtol=1e-12)
    np.testing.assert_allclose(score.r2_sensor, 1 - (rest**2).sum(0) / (spread**2).sum(0), rtol=1e-12)
    assert score.touches == 32


@pytest.mark.parametrize(
    ("change", "error", "seen"),
    [
        ({"fit": ("gian",)}, ss.errors.InvalidValueError, "gian"),
        ({"fit": ()}, ss.errors.InvalidValueError, "empty"),
        ({"fit": ("depth", "depths")}, ss.errors.InvalidValueError, "both"),
        ({"positions": PLACES[:-1]}, ss.errors.GeometryError, "one position for each"),
        ({"positions": np.where(PLACES > 0.03, np.nan, PLACES)}, ss.errors.InvalidValueError, "positions"),
        ({"readings": np.zeros((65, 3))}, ss.errors.GeometryError, "4 sensors"),
        ({"readings": np.zeros((65, 4))}, ss.errors.ConvergenceError, "no sensor"),
        ({"readings": np.full((65, 4), np.nan)}, ss.errors.ConvergenceError, "no sensor"),
        ({"force": -1.0}, ss.errors.InvalidValueError, "force"),
        ({"force": np.ones(3)}, ValueError, "shape|broadcast"),
    ],
)
def test_bad_touches_are_refused(change, error, seen):
    arguments = {"readings": touch(true_finger()), "positions": PLACES, **change}
    with pytest.raises(error, match=seen):
        ss.calibrate(drawn(), **arguments)


def test_too_few_touches_are_refused():
    with pytest.raises(ss.errors.ConvergenceError, match="more readings than parameters"):
        ss.calibrate(drawn(), touch(true_finger())[20:22], PLACES[20:22])


def test_inputs_stay_as_they_were():
    readings, positions = touch(true_finger()), PLACES.copy()
    before = readings.copy()
    ss.calibrate(drawn(), readings, positions)
    np.testing.assert_array_equal(readings, before)
    np.testing.assert_array_equal(positions, PLACES)


def test_a_parameter_that_the_readings_say_nothing_of_has_no_finite_error():
    array = ss.SensorArray.line(4, pitch=6e-3, depth=5e-3, transducer=ss.NormalStress(), gain=1e-6, noise=1e-9)
    finger = ss.Finger(SKIN, array)
    found = ss.calibrate(finger, touch(finger), PLACES, fit=("gain", "depth", "origin", "poisson"))
    errors = {p.name: p.std for p in found.parameters}
    assert errors["poisson"] == np.inf  # stresses in a half plane do not depend on it
    assert errors["depth"] < 1e-5


def test_a_width_of_none_is_fitted_without_leaving_its_range():
    truth = true_finger(width=0.0, noise=1e-5)
    found = ss.calibrate(
        drawn(poisson=0.45), touch(truth), PLACES, fit=("gain", "offset", "depths", "origin", "position", "width")
    )
    width = next(p for p in found.parameters if p.name == "width")
    assert 0 <= width.value < 0.3e-3


LAYER = ss.Layered(ss.Layer(ss.Material(young=0.4e6, poisson=0.5), thickness=9e-3))
ROUND = ss.Round(ss.Material(young=0.4e6, poisson=0.48), radius=16e-3, core_radius=9e-3)
FEW = PLACES[::3]


def on(skin, **changes):
    parameters = {"count": 4, "pitch": 6e-3, "depth": 5.3e-3, "gain": 90.0, "noise": 1e-6}
    return ss.Finger(skin, ss.SensorArray.line(**{**parameters, **changes}))


def value(found, name):
    return next(p for p in found.parameters if p.name == name)


class TestThickness:
    @pytest.mark.parametrize(("skin", "start"), [(LAYER, 20e-3), (ROUND, 6e-3)], ids=["layer", "round"])
    def test_it_is_recovered_with_depth_gain_and_origin(self, skin, start):
        truth = on(skin)
        drawn_so = on(skin.with_(thickness=start), depth=5e-3, gain=1.0)
        found = ss.calibrate(drawn_so, touch(truth, FEW), FEW, fit=("gain", "depth", "origin", "thickness"))
        thickness, depth = value(found, "thickness"), value(found, "depth")
        assert abs(thickness.value - skin.thickness) < 4.5 * thickness.std
        assert thickness.std < 2e-4 * skin.thickness
        assert abs(depth.value - 5.3e-3) < 4.5 * depth.std
        assert found.finger.skin.thickness == pytest.approx(thickness.value, rel=1e-12)
        assert type(found.finger.skin) is type(skin)
        assert found.doubts == ()

    def test_one_that_is_off_by_much_is_still_found(self):
        shallow = on(LAYER.with_(thickness=5.6e-3))  # its base lies just beneath the sensors
        for start in (5.4e-3, 60e-3):
            drawn_so = on(LAYER.with_(thickness=start))
            found = ss.calibrate(drawn_so, touch(shallow, FEW), FEW, fit=("gain", "origin", "thickness"))
            assert value(found, "thickness").value == pytest.approx(5.6e-3, abs=2e-6)

    @pytest.mark.parametrize("skin", [LAYER.with_(thickness=7e-3), ROUND], ids=["layer", "round"])
    @pytest.mark.parametrize("name", ["depth", "depths"])
    def test_a_depth_is_found_without_leaving_a_thin_skin(self, skin, name):
        truth = on(skin)
        found = ss.calibrate(on(skin, depth=6.5e-3), touch(truth, FEW), FEW, fit=("gain", name, "origin"))
        np.testing.assert_allclose(found.finger.array.depth, 5.3e-3, atol=2e-6)
        assert found.origin == pytest.approx(ORIGIN, abs=1e-6)

    @pytest.mark.parametrize(
        "skin",
        [
            ss.HalfPlane(ss.Material(0.4e6)),
            ss.Layered([ss.Layer(ss.Material(0.4e6), 6e-3), ss.Layer(ss.Material(1e6), 2e-3)]),
            ss.Layered(ss.Layer(ss.Material(0.4e6), 9e-3), base=ss.Material(1e9)),
        ],
        ids=["half plane", "two layers", "on a half plane"],
    )
    def test_a_skin_without_a_single_one_is_refused(self, skin):
        with pytest.raises(ss.errors.InvalidValueError, match="no single thickness"):
            ss.calibrate(on(skin), touch(on(LAYER), FEW), FEW, fit=("gain", "thickness"))


class TestCovariance:
    def test_gains_and_offsets_are_those_of_straight_lines(self):
        truth = on(LAYER, gain=[80.0, -110.0, 90.0, 100.0], offset=0.3, noise=3e-4)
        readings = np.array(touch(truth, FEW))
        readings[::5, 2] = np.nan
        found = ss.calibrate(truth, readings, FEW, fit=("gain", "offset"), origin=ORIGIN, gain_error=np.inf)
        assert [(p.name, p.sensor) for p in found.parameters] == [
            (name, i) for name in ("gain", "offset") for i in range(4)
        ]
        unit = on(LAYER, gain=1.0).receptive_field(FEW - ORIGIN)[..., 0]
        for i in range(4):
            seen = np.isfinite(readings[:, i])
            columns = np.stack([unit[seen, i], np.ones(seen.sum())], axis=-1)
            expected = found.finger.array.noise[i] ** 2 * np.linalg.inv(columns.T @ columns)
            np.testing.assert_allclose(found.covariance[i::4, i::4], expected, rtol=1e-8)
        others = np.arange(8)[:, None] % 4 != np.arange(8) % 4
        size = np.sqrt(np.outer(*2 * [np.diag(found.covariance)]))
        assert np.abs(found.covariance / size)[others].max() < 1e-9

    @pytest.mark.parametrize("name", ["depth", "depths"])
    def test_it_is_the_inverse_fisher_information_of_what_is_reported(self, name):
        depth = [5.2e-3, 5.5e-3, 5.4e-3, 5.1e-3] if name == "depths" else 5.3e-3
        truth = on(LAYER.with_(materials=[ss.Material(0.4e6, 0.45)]), depth=depth, noise=1e-5)
        fit = ("gain", name, "origin", "poisson", "thickness", "position")
        start = on(LAYER)
        found = ss.calibrate(start, touch(truth, FEW), FEW, fit=fit)
        reported = np.array([p.value for p in found.parameters])
        np.testing.assert_array_equal(np.sqrt(np.diag(found.covariance)), [p.std for p in found.parameters])

        def model(values):
            """Readings as a function of the numbers reported."""
            by = {}
            for p, v in zip(found.parameters, values, strict=True):
                by.setdefault(p.name, []).append(v)
            skin = LAYER.with_(materials=[ss.Material(0.4e6, by["poisson"][0])], thickness=by["thickness"][0])
            array = ss.SensorArray(y=by["y"], depth=by["depth"], gain=by["gain"])
            return ss.Finger(skin, array).receptive_field(FEW - by["origin"][0])[..., 0]

        step = 1e-5 * np.maximum(np.abs(reported), 1e-3)
        names = [p.name for p in found.parameters]
        noise = np.asarray(found.finger.array.noise)
        columns = []
        for k in range(reported.size):
            ends = [reported.copy(), reported.copy()]
            ends[0][k] += step[k]
            ends[1][k] -= step[k]
            columns.append(((model(ends[0]) - model(ends[1])) / (2 * step[k]) / noise).reshape(-1))
        jacobian = np.stack(columns, axis=-1)
        y = [i for i, n in enumerate(names) if n == "y"]
        keep = np.delete(np.eye(reported.size), y[-1], axis=1)
        keep[y[-1], y[:-1]] = -1.0  # the mean place is as drawn
        jacobian = jacobian @ keep
        size = np.linalg.norm(jacobian, axis=0)
        inverse = np.linalg.inv((jacobian / size).T @ (jacobian / size)) / np.outer(size, size)
        expected = keep @ inverse @ keep.T
        scale = np.sqrt(np.outer(*2 * [np.diag(expected)]))
        assert np.abs((found.covariance - expected) / scale).max() < 2e-3


class TestDoubts:
    def test_a_base_too_deep_to_be_felt(self):
        truth = on(LAYER.with_(thickness=0.3), noise=1e-3)
        found = ss.calibrate(truth, touch(truth, FEW), FEW, fit=("gain", "offset", "origin", "thickness"))
        thickness = value(found, "thickness")
        assert thickness.std > 0.1 * thickness.value
        (said,) = (doubt for doubt in found.doubts if "end of its range" not in doubt)
        assert said.startswith("thickness is not determined: its standard error is")
        ratio = thickness.std / thickness.value
        assert ("more than 10 times" in said) == (ratio > 10)
        assert f"{100 * ratio:.0f} % of it" in said or ratio > 10

    def test_what_the_readings_say_nothing_of(self):
        stress = on(SKIN, transducer=ss.NormalStress(), gain=1e-6, noise=1e-9)
        found = ss.calibrate(stress, touch(stress, FEW), FEW, fit=("gain", "depth", "poisson"), origin=ORIGIN)
        assert found.doubts == ("poisson is not determined: its standard error is more than 10 times the value",)

    def test_what_can_hardly_be_told_apart(self):
        # the mean pressure of a thin layer is nearly the same at all depths
        truth = on(LAYER.with_(thickness=5.6e-3), transducer=ss.MeanPressure(), noise=1e-3)
        readings = touch(truth, FEW)
        found = ss.calibrate(truth, readings, FEW, fit=("gain", "depth", "thickness", "origin"))
        names = [p.name for p in found.parameters]
        i, j = names.index("depth"), names.index("thickness")
        variance = np.diag(found.covariance)
        r = found.covariance[i, j] / np.sqrt(variance[i] * variance[j])
        assert abs(r) > 0.95
        tied = [said for said in found.doubts if "separable" in said]
        assert len(tied) == 1
        assert tied[0].startswith(f"depth and thickness are hardly separable (correlation {r:.3f})")
        # were the thickness known, the depth's error would be that of a fit without it
        less = ss.calibrate(found.finger, readings, FEW, fit=("gain", "depth", "origin"))
        alone = float(tied[0].rsplit("would be ", 1)[1].split()[0])
        assert value(less, "depth").std / np.sqrt(variance[i]) == pytest.approx(alone, rel=0.1)

    def test_none(self):
        truth = on(LAYER)
        assert ss.calibrate(truth, touch(truth, FEW), FEW).doubts == ()


@pytest.mark.parametrize("area", [False, True])
def test_positions_in_millimetres_are_said_to_be(area):
    """A track of a thousand arrays, which would be searched through a depth at a time."""
    if area:
        array, skin = ss.SensorArray.grid((3, 3), 3e-3, 3e-3, noise=1e-6), ss.HalfSpace(ss.Material(young=0.4e6))
        at = np.stack(np.meshgrid(np.linspace(-3, 3, 4), np.linspace(-3, 3, 4)), axis=-1).reshape(-1, 2)
        touches = ss.Finger(skin, array).read(ss.PointLoad(1.0, position=1e-3 * at), np.random.default_rng(0))
    else:
        array, skin = ss.SensorArray.line(4, 3e-3, 3e-3, noise=1e-6), ss.HalfPlane(ss.Material(young=0.4e6))
        at = np.linspace(0.0, 9.0, 16)
        touches = ss.Finger(skin, array).read(ss.LineLoad(1.0, position=1e-3 * at - 4.5e-3))
    finger = ss.Finger(skin, array)
    with pytest.raises(InvalidValueError, match=r"touches over [69] m, .* in mm these would span [69] mm.*1e-3 \* pos"):
        ss.calibrate(finger, touches, at)
    assert ss.calibrate(finger, touches, 1e-3 * at).r2 > 0.999
    assert ss.calibrate(finger, touches, 1e-3 * at + 7.0).r2 > 0.999  # wherever the motor's zero is
