"""Truth against estimate, the finger cut open and the receptive fields: what is drawn is what was given."""

import re

import numpy as np
import pytest
from matplotlib.collections import EllipseCollection, LineCollection, PolyCollection
from matplotlib.container import ErrorbarContainer
from matplotlib.contour import ContourSet
from matplotlib.patches import FancyArrowPatch

import subskin as ss
from subskin import plot
from subskin.errors import GeometryError, InvalidValueError
from subskin.plot import COMPONENTS, finger_section, truth_against_estimate

SKIN = ss.HalfPlane(ss.Material(young=0.4e6))
FINGER = ss.Finger(SKIN, ss.SensorArray.line(count=8, pitch=1.5e-3, depth=2e-3, noise=1e-4))
TOUCH = ss.LineLoad(force=40.0, angle=-0.3, position=0.8e-3)


def labels(figure):
    return [text.get_text() for legend in figure.legends for text in legend.get_texts()]


def touches(count=40):
    rng = np.random.default_rng(5)
    true = rng.uniform(-8e-3, 8e-3, count)
    std = rng.uniform(3e-5, 9e-5, count)
    return true, true + std * rng.standard_normal(count), std


class TestTruthAgainstEstimate:
    def test_points_and_bars_are_those_given(self):
        true, found, std = touches()
        upper, lower = truth_against_estimate(true, found, std).axes
        for axes, height in ((upper, found), (lower, found - true)):
            (bar,) = [c for c in axes.containers if isinstance(c, ErrorbarContainer)]
            np.testing.assert_allclose(bar.lines[0].get_xydata(), 1e3 * np.column_stack([true, height]), atol=1e-12)
            segments = np.array(bar.lines[2][0].get_segments())
            half = 0.5 * np.ptp(segments[:, :, 1], axis=1)
            np.testing.assert_allclose(half, 1e3 * 1.959964 * std, rtol=1e-9)

    def test_numbers_band_and_median_are_those_of_the_ok_frames(self):
        true, found, std = touches()
        status = np.zeros(true.size, dtype=int)
        status[7], found[7] = ss.Status.AMBIGUOUS, found[7] + 4e-3
        upper, lower = truth_against_estimate(true, found, std, status).axes
        keep = status == 0
        error = 1e3 * (found - true)[keep]
        r2 = 1 - np.sum(error**2) / np.sum((1e3 * true[keep] - 1e3 * true[keep].mean()) ** 2)
        text = upper.get_title(loc="left")
        assert f"39 ok: |error| median {np.median(abs(error)):.3g} mm, rms {np.sqrt(np.mean(error**2)):.3g} mm" in text
        assert f"= {r2:.4f}" in text
        assert f"{100 * np.mean(abs(error) <= 1.959964e3 * std[keep]):.1f} % within" in text
        (band,) = [c for c in lower.collections if c.get_label() == "95 % of errors"]
        edges = band.get_paths()[0].vertices[:, 1]
        np.testing.assert_allclose([edges.min(), edges.max()], np.quantile(error, [0.025, 0.975]), rtol=1e-12)
        (line,) = [line for line in lower.lines if line.get_label() == "median error"]
        assert line.get_ydata() == pytest.approx(np.median(error), rel=1e-12)

    def test_a_gross_error_is_a_triangle_on_the_edge_and_does_not_set_the_scale(self):
        true, found, std = touches()
        found[3] += 5e-3
        found[4] -= 5e-3
        _, lower = truth_against_estimate(true, found, std).axes
        assert lower.get_ylim()[1] < 0.7
        for index, marker, sign in ((3, "^", 1), (4, "v", -1)):
            (line,) = [x for x in lower.lines if x.get_marker() == marker and np.size(x.get_xdata())]
            assert line.get_xdata().tolist() == [1e3 * true[index]]
            assert 0.9 < sign * line.get_ydata()[0] / lower.get_ylim()[1] < 1.0

    def test_every_status_has_a_marker_and_what_has_no_position_a_tick(self):
        true, found, std = touches()
        status = np.arange(true.size) % 5
        found[status >= 2] = np.nan
        found[status == 3] = true[status == 3]  # a caller's own: unexplained, yet with a position
        figure = truth_against_estimate(true, found, std, status)
        assert labels(figure)[:3] == ["ok (8)", "ambiguous (8)", "unexplained (8)"]
        (ticks,) = [line for line in figure.axes[0].lines if line.get_label() == "no position (16)"]
        np.testing.assert_allclose(np.sort(ticks.get_xdata()), np.sort(1e3 * true[(status == 2) | (status == 4)]))
        markers = {c.lines[0].get_marker() for c in figure.axes[0].containers}
        assert len(markers) == 3

    def test_an_estimate_brings_its_own_deviations_and_status(self):
        positions = np.linspace(-4e-3, 4e-3, 12)
        load = ss.LineLoad(force=40.0, angle=0.2, position=positions)
        found = FINGER.locate(FINGER.read(load, np.random.default_rng(2)))
        whole = truth_against_estimate(positions, found)
        parts = truth_against_estimate(positions, found.position, found.std[:, 0], found.status)
        assert whole.axes[0].get_title(loc="left") == parts.axes[0].get_title(loc="left")
        assert "within their 95 % interval" in whole.axes[0].get_title(loc="left")
        assert labels(whole) == labels(parts)

    @pytest.mark.parametrize("count", [2100, 100_000])
    def test_many_frames_become_a_density_that_holds_them_all(self, count):
        true, found, std = touches(count)
        status = np.zeros(count, dtype=int)
        status[:30] = ss.Status.AMBIGUOUS
        figure = truth_against_estimate(true, found, std, status)
        upper, lower, bar = figure.axes
        clouds = [c for axes in (upper, lower) for c in axes.collections if isinstance(c, PolyCollection)]
        totals = [cloud.get_array().sum() for cloud in clouds if cloud.get_array() is not None]
        beyond = sum(
            np.size(x.get_xdata()) for x in lower.lines if x.get_marker() in "^v" and x.get_color() == "#0072B2"
        )
        assert totals == [count - 30, count - 30 - beyond]
        assert clouds[0].norm.vmax == clouds[-1].norm.vmax  # one scale, one colour bar
        assert bar.get_ylabel() == "ok frames in a cell"
        low, high = (line for line in lower.lines if line.get_linewidth() == 0.7)
        error = 1e3 * (found - true)[30:]
        position = 1e3 * true[30:]
        inside = (np.interp(position, *low.get_data()) <= error) & (error <= np.interp(position, *high.get_data()))
        assert inside.mean() == pytest.approx(0.95, abs=0.01)
        assert figure.axes[0].get_legend() is None

    def test_without_deviations_or_spread_nothing_is_claimed(self):
        text = truth_against_estimate([1e-3, 1e-3], [1.1e-3, 0.9e-3]).axes[0].get_title(loc="left")
        assert text == "2 ok: |error| median 0.1 mm, rms 0.1 mm"
        figure = truth_against_estimate(0.0, np.nan, status=ss.Status.NO_CONTACT)
        assert figure.axes[0].get_title(loc="left") == "no frame is ok"
        figure = truth_against_estimate([0.0, 1e-3], [0.0, 1e-3])  # no error at all
        assert figure.axes[1].get_ylim()[1] > 0

    def test_inputs_stay_as_they_are(self):
        arrays = touches()
        before = [a.copy() for a in arrays]
        truth_against_estimate(*arrays)
        assert all(np.array_equal(a, b) for a, b in zip(arrays, before, strict=True))

    @pytest.mark.parametrize(
        ("arguments", "error", "says"),
        [
            (([0.0], [0.0, 1e-3]), GeometryError, "one estimate for each"),
            (([0.0, 1e-3], [0.0, 1e-3, 2e-3]), GeometryError, "broadcast"),
            (([], []), GeometryError, "at least one"),
            (([np.nan], [0.0]), InvalidValueError, "finite"),
            (([0.0], ["x"]), InvalidValueError, "real number"),
            (([0.0], [0.0], [-1e-5]), InvalidValueError, ">= 0"),
            (([0.0], [0.0], None, [5]), InvalidValueError, "<= 4"),
        ],
    )
    def test_bad_input_is_said(self, arguments, error, says):
        with pytest.raises(error, match=says):
            truth_against_estimate(*arguments)


def arrows(figure):
    """Of each arrow its tail, its tip, and the place where its line meets the surface, in mm of (y, x)."""
    found = []
    for patch in figure.axes[0].patches:
        if isinstance(patch, FancyArrowPatch):
            path = patch.get_path()
            ends = path.vertices[path.codes != path.CLOSEPOLY]
            tail, tip = ends[0], ends[np.argmax(np.hypot(*(ends - ends[0]).T))]
            along, into = tip - tail
            found.append((tail, tip, tail[0] - tail[1] * along / into if into else tip[0]))
    return found


class TestFingerSection:
    def test_the_colours_are_those_of_the_field(self):
        figure = finger_section(FINGER, TOUCH)
        (drawn,) = [c for c in figure.axes[0].collections if isinstance(c, ContourSet)]
        levels = np.array(drawn.levels)
        np.testing.assert_allclose(levels, -levels[::-1])  # white is zero
        rng = np.random.default_rng(0)
        y, x = rng.uniform(-6, 6, 400), rng.uniform(0.4, 3.3, 400)
        t = y - 0.8
        n, q = 40e3 * np.cos(-0.3), 40e3 * np.sin(-0.3)
        strain = -150 / (np.pi * 0.4e6) * (n * x + q * t) * (x**2 - t**2) / (x**2 + t**2) ** 2
        band = np.digitize(strain, levels)
        away = np.abs(strain[:, None] / levels - 1).min(axis=1) > 0.05  # clear of a contour
        assert away.sum() > 200
        paths = drawn.get_paths()
        hits = [paths[b].contains_point((v, u)) for v, u, b in zip(y[away], x[away], band[away], strict=True)]
        assert np.mean(hits) > 0.99
        misses = [paths[(b + 3) % len(paths)].contains_point((v, u)) for v, u, b in zip(y, x, band, strict=True)]
        assert np.mean(misses) < 0.01

    def test_arrows_wedge_and_words_tell_the_load_and_the_estimate(self):
        frame = FINGER.read(TOUCH, np.random.default_rng(1))
        found = FINGER.locate(frame)
        figure = finger_section(FINGER, TOUCH, found)
        given = ((0.8, -0.3), (1e3 * float(found.position), float(found.angle)))
        for (tail, tip, foot), (position, angle) in zip(arrows(figure), given, strict=True):
            assert foot == pytest.approx(position, abs=1e-6)
            assert np.arctan2(tip[0] - tail[0], tip[1] - tail[1]) == pytest.approx(angle, abs=1e-6)
            assert tail[1] < tip[1] < 0
        words = labels(figure)
        assert any("true: 40 N/m at −17.2°, y = 0.80 mm" in text for text in words)
        (text,) = [text for text in words if text.startswith("found (ok)")]
        numbers = [float(v.replace("−", "-")) for v in re.findall(r"−?\d+\.?\d*", text)]
        half = 1.959964 * found.std
        expected = [found.force, half[1], np.degrees(found.angle), np.degrees(half[2])]
        expected += [1e3 * found.position, 1e3 * half[0]]
        np.testing.assert_allclose(numbers, np.array(expected, dtype=float), rtol=0.06)

    def test_the_sensors_stand_where_they_are_and_those_left_out_are_crossed(self):
        array = ss.SensorArray(
            y=[-2e-3, 0.0, 2e-3, 4e-3], depth=[1e-3, 2e-3, 1e-3, 2e-3], gain=[1, 0, 1, 1], noise=1e-4
        )
        axes = finger_section(ss.Finger(SKIN, array), TOUCH).axes[0]
        marks = {line.get_label(): line.get_xydata().tolist() for line in axes.lines}
        assert marks["sensor"] == [[-2.0, 1.0], [2.0, 1.0], [4.0, 2.0]]
        assert marks["sensor left out"] == [[0.0, 2.0]]

    def test_the_lower_panel_shows_readings_and_both_loads(self):
        array = ss.SensorArray.line(count=6, pitch=1.5e-3, depth=2e-3, gain=-3.0, offset=0.5, noise=1e-4)
        finger = ss.Finger(SKIN, array)
        frame = finger.read(TOUCH, np.random.default_rng(1))
        found = finger.locate(frame)
        axes = finger_section(finger, TOUCH, found, readings=frame).axes[1]
        (dots,) = axes.containers
        np.testing.assert_allclose(dots.lines[0].get_ydata(), 100 * (frame - 0.5) / -3.0, rtol=1e-12)
        assert axes.get_ylabel() == "measured [%]"
        curves = [line for line in axes.lines if np.size(line.get_xdata()) > 100]
        loads = (TOUCH, ss.LineLoad(float(found.force), float(found.angle), float(found.position)))
        for line, load in zip(curves, loads, strict=True):
            expected = 100 * SKIN.strain(load, x=2e-3, y=line.get_xdata() * 1e-3).xx
            np.testing.assert_allclose(line.get_ydata(), expected, rtol=0, atol=1e-12)

    def test_sensors_that_differ_are_compared_one_by_one(self):
        array = ss.SensorArray(y=[-2e-3, 0.0, 2e-3], depth=[1e-3, 2e-3, 1e-3], noise=1e-4)
        finger = ss.Finger(SKIN, array)
        axes = finger_section(finger, TOUCH, readings=finger.read(TOUCH)).axes[1]
        (dashes,) = [line for line in axes.lines if line.get_marker() == "_"]
        np.testing.assert_allclose(dashes.get_ydata(), 100 * finger.measure(TOUCH), rtol=1e-12)

    def test_the_pressure_is_drawn_to_scale_and_its_peak_told(self):
        touch = ss.Hertz(force=40.0, half_width=1e-3)
        figure = finger_section(FINGER, touch)
        (hump,) = [c for c in figure.axes[0].collections if str(c.get_label()).startswith("pressure")]
        assert hump.get_label() == f"pressure, at most {2 * 40 / np.pi:.3g} kPa"
        y, height = hump.get_paths()[0].vertices.T
        expected = height.min() * np.sqrt(np.maximum(1 - y**2, 0))
        np.testing.assert_allclose(height[np.abs(height) > 0], expected[np.abs(height) > 0], rtol=1e-3)
        words = labels(finger_section(FINGER, ss.FlatPunch(force=40.0, half_width=1e-3)))
        assert "pressure" in words  # infinite at its edges: no peak to tell

    @pytest.mark.parametrize(
        ("contact", "position"),
        [
            (ss.FlatPunch(force=40.0, position=1e-3, half_width=2e-3, moment=0.02), 1.5),
            (ss.PressureProfile([0.0, 3e-3], [0.0, 2e4]), 2.0),
            (ss.PressureProfile([0.0, 3e-3], [0.0, 0.0], shear=[2e4, 0.0]), 1.0),
            (ss.Strip(force=10.0, angle=1.0, position=-1e-3, half_width=1e-3), -1.0),
        ],
    )
    def test_the_arrow_stands_on_the_line_of_action(self, contact, position):
        figure = finger_section(FINGER, contact)
        ((tail, tip, foot),) = arrows(figure)
        flat = tail[1] == tip[1]  # it lies along the surface, and its point is blunt
        assert foot == pytest.approx(position, abs=0.2 if flat else 1e-6)
        (text,) = [text for text in labels(figure) if text.startswith("load")]
        assert text.endswith(f"y = {position:.2f} mm".replace("-", "−"))

    def test_each_of_several_loads_has_an_arrow_and_one_that_pulls_leaves_the_skin(self):
        two = ss.LineLoad(10.0, 0.0, -2e-3) + ss.LineLoad(40.0, 3.0, 2e-3)
        (start, tip, foot), (tail, head, _) = arrows(finger_section(FINGER, two))
        assert start[1] < tip[1] < 0
        assert foot == pytest.approx(-2.0, abs=1e-6)
        assert tail == pytest.approx([2.0, 0.0], abs=1e-6)
        assert head[1] < -0.5

    @pytest.mark.parametrize("status", [ss.Status.NO_CONTACT, ss.Status.UNEXPLAINED, ss.Status.INCOMPLETE])
    def test_what_was_not_found_is_said_and_not_drawn(self, status):
        frame = {
            ss.Status.NO_CONTACT: np.zeros(8),
            ss.Status.UNEXPLAINED: FINGER.read(ss.LineLoad(60.0, 0.0, -3e-3) + ss.LineLoad(60.0, 0.3, 3e-3)),
            ss.Status.INCOMPLETE: np.where(np.arange(8) < 7, np.nan, 0.01),
        }[status]
        found = FINGER.locate(frame)
        assert found.status == status
        figure = finger_section(FINGER, TOUCH, found, readings=frame)
        assert len(arrows(figure)) == 1
        assert f"found: {status.name.lower().replace('_', ' ')}" in labels(figure)

    @pytest.mark.parametrize("component", COMPONENTS)
    def test_every_component_has_its_label(self, component):
        if component.startswith("displacement"):
            with pytest.raises(InvalidValueError, match=f"{component}.*known only up to a constant"):
                finger_section(FINGER, TOUCH, component=component)
            return
        bar = finger_section(FINGER, TOUCH, component=component).axes[-1]
        assert bar.get_ylabel() == COMPONENTS[component].label
        assert re.search(r"\[(%|kPa)\]$", bar.get_ylabel())

    def test_bad_input_is_said(self):
        with pytest.raises(InvalidValueError, match=r'"strain\.xx", "strain\.yy"'):
            finger_section(FINGER, TOUCH, component="strain")
        with pytest.raises(GeometryError, match="a single contact"):
            finger_section(FINGER, ss.LineLoad([1.0, 2.0]))
        with pytest.raises(GeometryError, match="each of the 8 sensors"):
            finger_section(FINGER, TOUCH, readings=np.zeros(7))
        with pytest.raises(GeometryError, match="single frame"):
            finger_section(FINGER, TOUCH, FINGER.locate(np.zeros((2, 8))))
        frame = np.full(8, np.nan)
        before = frame.copy()
        finger_section(FINGER, TOUCH, readings=frame)
        assert np.array_equal(frame, before, equal_nan=True)


class TestAbove:
    """Touches on an area, from above."""

    RNG = np.random.default_rng(0)
    TRUE = RNG.uniform(-5e-3, 5e-3, (40, 2))
    ERROR = RNG.normal(0, 2e-5, (40, 2))

    def drawn(self, **more):
        status = np.where(np.arange(40) < 30, ss.Status.OK, ss.Status.AMBIGUOUS)
        covariance = np.broadcast_to(np.diag([4e-10, 1e-10]), (40, 2, 2))
        return plot.truth_above(
            self.TRUE + self.ERROR, self.TRUE, status=status, covariance=covariance, sensors=[(0.0, 0.0)], **more
        )

    def test_errors_are_drawn_larger_by_a_round_number_that_is_said(self):
        axes = self.drawn().axes[0]
        lines = next(part for part in axes.collections if isinstance(part, LineCollection))
        ends = np.array(lines.get_segments())
        factor = (ends[:, 1] - ends[:, 0]) / (1e3 * self.ERROR)
        scale = float(np.median(factor))
        np.testing.assert_allclose(factor, scale, rtol=1e-6)
        assert f"errors are drawn {scale:g} times as large" in axes.get_title(loc="left")
        median = np.median(np.linalg.norm(self.ERROR[:30], axis=1))
        assert f"30 ok frames: median error {1e3 * median:.2g} mm" in axes.get_title(loc="left")

    def test_only_what_is_ok_has_an_ellipse(self):
        ellipses = next(part for part in self.drawn().axes[0].collections if isinstance(part, EllipseCollection))
        assert len(ellipses.get_offsets()) == 30

    def test_the_ellipses_lie_in_the_picture(self):
        covariance = np.broadcast_to(1.6e-9 * np.eye(2), (40, 2, 2))
        axes = plot.truth_above(self.TRUE + self.ERROR, self.TRUE, covariance=covariance).axes[0]
        ellipses = next(part for part in axes.collections if isinstance(part, EllipseCollection))
        at, half = np.asarray(ellipses.get_offsets()), 0.5 * ellipses._widths.max()
        for (low, high), along in zip((axes.get_xlim(), axes.get_ylim()), at.T, strict=True):
            assert low < along.min() - half
            assert along.max() + half < high

    def test_frames_and_their_finger_show_its_sensors(self):
        skin = ss.HalfSpace(ss.Material(0.4e6))
        finger = ss.Finger(skin, ss.SensorArray.grid((3, 3), 2e-3, depth=2e-3, noise=1e-4))
        frames = finger.locate(finger.read(ss.PointLoad(1.0, position=[(0.0, 0.0), (1e-3, 0.0)])))
        sensors = next(line for line in frames.plot(finger).axes[0].lines if line.get_label() == "sensor")
        np.testing.assert_allclose(np.column_stack(sensors.get_data()), 1e3 * finger.array.points)

    def test_frames_without_a_load_are_counted_and_the_others_drawn(self):
        skin = ss.HalfSpace(ss.Material(0.4e6))
        finger = ss.Finger(skin, ss.SensorArray.grid((3, 3), 2e-3, depth=2e-3, noise=1e-4))
        force = np.array([0.0, 1.0, 0.0, 1.5])
        frames = finger.locate(finger.read(ss.PointLoad(force, position=4 * [(1e-3, 0.0)])))
        for axes in (frames.plot().axes[0], frames.plot(finger).axes[0], plot.truth_above(frames.position).axes[0]):
            labels = [line.get_label() for line in axes.lines]
            assert "2 frames without a position" in labels
            assert "found, ok (2)" in labels
            assert np.isfinite([*axes.get_xlim(), *axes.get_ylim()]).all()
        assert not any("without" in str(line.get_label()) for line in frames[[1, 3]].plot().axes[0].lines)
        with pytest.raises(GeometryError, match="no frame has a position"):
            frames[0].plot()

    def test_shapes_are_checked(self):
        with pytest.raises(GeometryError, match="both need the shape"):
            plot.truth_above(self.TRUE, self.TRUE[:3])
