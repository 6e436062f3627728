"""How wrong the half plane is: against published factors, limits and what `locate` itself says of the two skins."""

from dataclasses import replace

import numpy as np
import pytest

import subskin as ss
from subskin.design import half_plane_error, half_plane_map
from subskin.design.half_plane import MAP_RADIUS, MAP_THICKNESS, half_plane_of
from subskin.plot import half_plane_map_figure

RUBBER = ss.Material(young=0.4e6, poisson=0.5)
DEPTH = 2e-3
ROW = {"count": 6, "pitch": DEPTH, "depth": DEPTH}
PUBLISHED = {0.05: 1.027, 0.1: 1.046, 0.2: 1.068, 0.25: 1.073, 0.5: 1.047, 0.75: 0.863}
ROUND = {1 / 16: 1.085, 1 / 8: 1.152, 1 / 4: 1.256, 3 / 8: 1.250}


def finger(skin, **more):
    return ss.Finger(skin, ss.SensorArray.line(**{**ROW, **more}))


def layer(thickness, poisson=0.5):
    return ss.Layered(ss.Layer(ss.Material(0.4e6, poisson), thickness * DEPTH))


class TestReadings:
    @pytest.mark.parametrize(("share", "factor"), PUBLISHED.items())
    def test_beneath_a_line_load_on_a_bonded_layer(self, share, factor):
        found = half_plane_error(finger(layer(1 / share)))
        np.testing.assert_allclose(found.beneath, factor, atol=6e-4)

    @pytest.mark.parametrize(("share", "factor"), ROUND.items())
    def test_beneath_a_line_load_on_a_round_finger(self, share, factor):
        radius = DEPTH / share
        found = half_plane_error(finger(ss.Round(RUBBER, radius, 0.5 * radius), pitch=0.5 * DEPTH))
        np.testing.assert_allclose(found.beneath, factor, atol=6e-4)

    @pytest.mark.parametrize("kind", ["layer", "round"])
    def test_a_thick_flat_skin_becomes_a_half_plane_and_its_error_falls_with_the_thickness(self, kind):
        size = np.array([200.0, 400.0, 800.0])
        if kind == "layer":
            skins = [layer(s) for s in size]
        else:
            skins = [ss.Round(RUBBER, s * DEPTH, 0.2 * s * DEPTH) for s in size]
        found = [half_plane_error(finger(skin)) for skin in skins]
        errors = {
            "normal": [e.normal for e in found],
            "tangential": [e.tangential for e in found],
            "beneath": [e.beneath[0] - 1 for e in found],
            "position": [e.as_drawn.summary()["position"]["worst"] for e in found],
            "angle": [e.as_drawn.summary()["angle"]["worst"] for e in found],
        }
        for name, error in errors.items():
            rate = np.log2(np.divide(error[:-1], error[1:]))
            # what a layer sends back of a drag is odd in y: its first order is nothing beneath the load
            expected = 2.0 if (kind, name) == ("layer", "tangential") else 1.0
            np.testing.assert_allclose(rate, expected, atol=0.12, err_msg=name)
        if kind == "layer":  # 1 + 0.63773 depth / thickness, and a square that is taken out
            slope = np.array(errors["beneath"]) * size
            np.testing.assert_allclose(2 * slope[2] - slope[1], 0.63773, atol=2e-5)

    def test_the_largest_difference_is_that_of_the_receptive_fields(self):
        skin = layer(3.0, poisson=0.45)
        found = half_plane_error(finger(skin, gain=[1, -2, 1, 1, 3, 1], offset=7.0))
        own, flat = (finger(s).receptive_field(found.positions) for s in (skin, half_plane_of(finger(skin))))
        worst = np.abs(own - flat).max(axis=(0, 1)) / np.abs(own).max(axis=(0, 1))
        np.testing.assert_allclose([found.normal, found.tangential], worst, rtol=1e-12)

    def test_a_touch_as_wide_as_it_is_deep(self):
        found = half_plane_error(finger(layer(3.0)), half_width=DEPTH)
        above = ss.Hertz(1.0, position=finger(layer(3.0)).array.y[:, None], half_width=DEPTH)
        skins = (layer(3.0), ss.HalfPlane(RUBBER))
        own, flat = (s.strain(above, DEPTH, above.position).xx[:, 0] for s in skins)
        np.testing.assert_allclose(found.beneath, own / flat, rtol=1e-10)

    def test_a_sensor_that_reads_nothing_beneath_a_press_has_no_factor(self):
        found = half_plane_error(finger(layer(3.0), transducer=ss.ShearStrain()))
        assert np.isnan(found.beneath).all()
        assert found.normal > 0.1

    def test_the_half_plane_is_of_the_material_around_the_sensors(self):
        stiff, soft, bone = ss.Material(3e6, 0.4), ss.Material(0.2e6, 0.48), ss.Material(1e9, 0.3)
        stack = ss.Layered([ss.Layer(stiff, 0.5 * DEPTH), ss.Layer(soft, DEPTH)], base=bone)
        for depth, material in ((0.3, stiff), (1.0, soft), (2.0, bone)):
            assert half_plane_of(finger(stack, depth=depth * DEPTH)) == ss.HalfPlane(material)
        assert half_plane_of(finger(ss.Round(soft, 8e-3, 4e-3))) == ss.HalfPlane(soft)


class TestLocating:
    def test_the_bias_is_what_locate_makes_of_readings_in_the_true_skin(self):
        skin = ss.Round(RUBBER, 8e-3, 4e-3)
        found = half_plane_error(finger(skin))
        i, j = 27, 2  # a touch off the middle at 0.4 rad
        touch = ss.LineLoad(1.0, 0.4, found.positions[i])
        readings = finger(skin).read(touch)
        every = finger(skin).read(ss.LineLoad(1.0, found.angles, found.positions[:, None]))
        noise = 0.05 * np.abs(every).max(axis=(0, 1))
        flat = finger(ss.HalfPlane(RUBBER), noise=noise).locate(readings, friction=1.0)
        assert flat.status == ss.Status.OK
        np.testing.assert_allclose(
            [found.as_drawn.position[i, j], found.as_drawn.force[i, j], found.as_drawn.angle[i, j]],
            [flat.position - touch.position, flat.force - 1, flat.angle - 0.4],
            rtol=1e-6,
        )
        assert found.as_drawn.force[i, j] > 0.2  # the half plane is not a little wrong here

    def test_its_own_skin_makes_no_error(self):
        found = half_plane_error(finger(layer(3.0), gain=[1, 2, -3, 1, 1, 1], offset=5.0))
        worst = {k: v["worst"] for k, v in found.own.summary().items()}
        assert worst["position"] < 1e-4 * DEPTH
        assert worst["force"] < 1e-3
        assert worst["angle"] < 1e-3
        assert found.own.unanswered == 0
        assert found.own.status["ok"] == found.positions.size * found.angles.size

    def test_sensors_of_several_kinds_count_alike(self):
        kinds = [ss.NormalStrain(), ss.MeanPressure()] * 3
        found = half_plane_error(finger(layer(3.0), transducer=kinds))  # strains beside pascals
        assert found.own.unanswered == 0
        assert found.own.summary()["position"]["worst"] < 1e-4 * DEPTH
        assert 0.01 * DEPTH < found.as_drawn.summary()["position"]["worst"] < 0.5 * DEPTH

    def test_sensors_good_enough_see_that_the_half_plane_does_not_fit(self):
        seen = [half_plane_error(finger(layer(3.0)), snr=snr).as_drawn for snr in (20.0, 1000.0)]
        assert [e.status["unexplained"] for e in seen] == [0, seen[1].position.size]
        np.testing.assert_array_equal(seen[0].position, seen[1].position)

    def test_calibrating_trades_a_wrong_skin_for_a_wrong_depth(self):
        found = half_plane_error(finger(layer(3.0)))
        touches = finger(layer(3.0)).read(ss.LineLoad(1.0, 0.0, found.positions))
        flat = finger(ss.HalfPlane(RUBBER), noise=1e-3 * np.abs(touches).max(axis=0))
        again = ss.calibrate(flat, touches, found.positions, fit=("gain", "depth"), force=1.0, origin=0.0)
        np.testing.assert_allclose(found.depth, again.finger.array.depth[0], rtol=1e-6)
        assert found.depth > 1.05 * DEPTH
        drawn, calibrated = found.as_drawn.summary(), found.calibrated.summary()
        assert all(calibrated[k]["worst"] < drawn[k]["worst"] for k in ("position", "force", "angle"))

    def test_rounding_range_and_noise_of_the_sensors_are_left_out(self):
        plain = half_plane_error(finger(layer(3.0)))
        coarse = half_plane_error(finger(layer(3.0), noise=1.0, resolution=1e-2, low=-1e-9, high=1e-9))
        for a, b in ((plain.as_drawn, coarse.as_drawn), (plain.calibrated, coarse.calibrated)):
            np.testing.assert_array_equal(a.position, b.position)
            assert a.status == b.status

    def test_touches_without_an_answer_are_counted_not_averaged(self):
        near = half_plane_error(finger(layer(1.01)))
        lost = np.isnan(near.as_drawn.position)
        assert 0 < near.as_drawn.unanswered == lost.sum() < lost.size
        assert np.isfinite(near.as_drawn.summary()["position"]["worst"])


class TestMap:
    def test_a_cell_is_the_finger_of_its_thickness_and_radius(self):
        values = half_plane_map([2.0, 3.0], [6.0, np.inf], poisson=0.4, half_width=0.25, count=5)
        material = ss.Material(0.4e6, 0.4)
        skins = {
            (0, 0): ss.Round(material, 6 * DEPTH, 4 * DEPTH),
            (0, 1): ss.Round(material, 6 * DEPTH, 3 * DEPTH),
            (1, 0): layer(2.0, 0.4),
            (1, 1): layer(3.0, 0.4),
        }
        for cell, skin in skins.items():
            found = half_plane_error(finger(skin, count=5), half_width=0.25 * DEPTH)
            worst = found.as_drawn.summary()
            expected = {
                "beneath": found.beneath[2],
                "reading": max(found.normal, found.tangential),
                "position": worst["position"]["worst"] / DEPTH,
                "angle": worst["angle"]["worst"],
            }
            for name, value in expected.items():
                np.testing.assert_allclose(values[name][cell], value, rtol=1e-5, err_msg=f"{name} {cell}")

    def test_fingers_that_cannot_be_are_left_out(self):
        values = half_plane_map([2.0, 4.0, 8.0], [4.0, 10.0], count=3)
        assert np.isnan(values["beneath"]).tolist() == [[False, True, True], [False, False, False]]
        wide = half_plane_map([2.0], [3.0, 100.0], half_width=5.0, count=3)
        assert np.isnan(wide["beneath"][:, 0]).tolist() == [True, False]

    def test_progress_is_told_of_every_cell(self):
        calls = []
        half_plane_map([2.0, 4.0], [3.0, np.inf], count=3, progress=lambda: calls.append(1))
        assert len(calls) == 4
        assert len(MAP_THICKNESS) * len(MAP_RADIUS) == 132

    def test_every_number_stands_in_its_cell_and_none_overflows(self):
        rng = np.random.default_rng(0)
        shape = (len(MAP_RADIUS), len(MAP_THICKNESS))
        values = {"thickness": np.array(MAP_THICKNESS), "radius": np.array(MAP_RADIUS)}
        values |= {"beneath": rng.uniform(0.4, 1.5, shape), "reading": rng.uniform(0.01, 1.2, shape)}
        values |= {"position": rng.uniform(0.01, 0.99, shape), "angle": rng.uniform(0.01, 0.7, shape)}
        values["angle"][0, -3:] = np.nan
        figure = half_plane_map_figure(values, here=(2.0, np.inf))
        labels = [[label.get_text() for label in axes.get_yticklabels()] for axes in figure.axes]
        assert [side[-1:] for side in labels] == [["flat"], [], ["flat"], []]
        renderer = figure.canvas.get_renderer()
        for axes, count in zip(figure.axes, (132, 132, 132, 129), strict=True):
            assert len(axes.texts) == count
            cell = axes.get_window_extent(renderer).width / shape[1]
            assert max(text.get_window_extent(renderer).width for text in axes.texts) < 0.95 * cell
            ring = axes.lines[0].get_xydata()[0]
            np.testing.assert_allclose(ring, [3.5, 11.5], atol=1e-9)  # fourth column, the top row

    def test_shapes_that_do_not_match_are_refused(self):
        values = half_plane_map([2.0, 4.0], [np.inf], count=3)
        with pytest.raises(ss.errors.GeometryError, match="angle of shape"):
            half_plane_map_figure({**values, "angle": values["angle"].T})
        with pytest.raises(ss.errors.GeometryError, match="ascending"):
            half_plane_map_figure({**values, "thickness": values["thickness"][::-1]})


@pytest.mark.parametrize(
    ("wrong", "options", "error", "seen"),
    [
        (finger(ss.HalfPlane(RUBBER)), {}, ss.errors.InvalidValueError, "whose skin is a half plane"),
        (finger(layer(3.0), count=2), {}, ss.errors.InvalidValueError, "2 sensors"),
        (finger(layer(3.0), gain=[0, 0, 0, 0, 1, 1]), {}, ss.errors.InvalidValueError, "2 sensors that respond"),
        (finger(layer(3.0), transducer=ss.EnergyDensity()), {}, ss.errors.NotLinearError, "EnergyDensity"),
        (finger(layer(3.0)), {"half_width": -1e-3}, ss.errors.InvalidValueError, "half_width"),
        (finger(layer(3.0)), {"snr": 0.0}, ss.errors.InvalidValueError, "snr"),
        (finger(ss.Round(RUBBER, 8e-3, 4e-3)), {"half_width": 13e-3}, ss.errors.GeometryError, "round the finger"),
    ],
)
def test_bad_input_is_refused(wrong, options, error, seen):
    with pytest.raises(error, match=seen):
        half_plane_error(wrong, **options)


def test_the_finger_is_left_as_it_was():
    given = finger(layer(3.0), noise=1e-4, resolution=1e-5)
    half_plane_error(given)
    assert given.array.noise[0] == 1e-4
    assert given.array.resolution[0] == 1e-5
    assert replace(given).skin == layer(3.0)


def test_thickness_and_radius_of_a_map_are_beyond_the_sensors():
    for arguments in (([1.0], [np.inf]), ([2.0], [0.5])):
        with pytest.raises(ss.errors.InvalidValueError):
            half_plane_map(*arguments)
