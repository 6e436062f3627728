"""Ridges: their shapes, batches and places, bad input, and figures that can be read."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
from matplotlib.text import Text

import subskin as ss
from subskin.design import Ridges, best_ridge_pitch, press_ridges, ridge_gain
from subskin.design.ridges import closing_pressure, read_ridged
from subskin.plot import memo_figure, pressed_ridges_figure, ridge_figure

DEPTH = 0.5e-3
BEST = 2 * np.pi * DEPTH
SKIN = ss.HalfPlane(ss.Material(0.4e6, 0.5))
FINGER = ss.Finger(SKIN, ss.SensorArray(y=[0.0, 1.3e-3], depth=[DEPTH, 2 * DEPTH]))
TOUCH = ss.Hertz(40.0, half_width=2e-3)
SHAPES = ("abs_cos", "cos_squared", "raised_cosine", "square")


@pytest.mark.parametrize("shape", SHAPES)
def test_a_shape_repeats_is_even_and_has_its_mean(shape):
    ridges = Ridges(2e-3, shape, crest=0.3e-3)
    y = 0.3e-3 + np.linspace(-1e-3, 1e-3, 20001)
    share = ridges.share(y)
    assert share.max() == 1.0 == ridges.share(0.3e-3)
    assert share.min() >= 0
    np.testing.assert_allclose(share, share[::-1], atol=1e-12)
    np.testing.assert_allclose(ridges.share(y[1:-1] + 4e-3), share[1:-1], atol=1e-9 if shape != "square" else 1.1)
    assert np.trapezoid(share, y) / 2e-3 == pytest.approx(ridges.mean, abs=1e-4)
    assert not share.flags.writeable


def test_shapes_are_those_they_are_named_after():
    u = np.array([0.0, 0.25, 1 / 3, 0.5])
    expected = {
        "abs_cos": [1, np.sqrt(0.5), 0.5, 0],
        "cos_squared": [1, 0.5, 0.25, 0],
        "raised_cosine": [1, 2 / 3, 0.5, 1 / 3],
        "square": [1, 1, 1, 0],
    }
    for shape, values in expected.items():
        np.testing.assert_allclose(Ridges(1.0, shape).share(u), values, atol=1e-15)
    assert Ridges(1.0, "square", duty=0.4).share([0.19, 0.21]).tolist() == [1.0, 0.0]
    assert Ridges(1.0, "square", duty=0.4).mean == 0.4


def test_a_shape_of_ones_own():
    def cosine(u):
        return (2 + np.cos(2 * np.pi * u)) / 3

    own, named = (ridge_gain(FINGER, TOUCH, Ridges(BEST, s)) for s in (cosine, "raised_cosine"))
    for one, two in zip(own.equal_load, named.equal_load, strict=True):
        assert one == pytest.approx(two, rel=1e-9)
    block = Ridges(1.1e-3, lambda u: 1.0 * (np.abs(u) < 0.3), kinks=(-0.3, 0.3), crest=0.2e-3)
    assert block.mean == pytest.approx(0.6, rel=1e-12)
    named = Ridges(1.1e-3, "square", duty=0.6, crest=0.2e-3)
    np.testing.assert_allclose(read_ridged(FINGER, TOUCH, block), read_ridged(FINGER, TOUCH, named), rtol=1e-9)


def test_batches_are_their_members_and_broadcast():
    widths, pitches = np.array([0.4e-3, 2e-3]), np.array([1e-3, 2e-3, 5e-3])
    found = ridge_gain(FINGER, ss.Hertz(40, 0.2, half_width=widths[:, None]), Ridges(pitches), sensor=1)
    assert found.pitch.shape == found.half_width.shape == found.smooth.shape == (2, 3)
    assert found.depth == 2 * DEPTH
    for i, j in np.ndindex(2, 3):
        one = ridge_gain(FINGER, ss.Hertz(40, 0.2, half_width=widths[i]), Ridges(pitches[j]), sensor=1)
        for many, alone in zip(found.equal_load, one.equal_load, strict=True):
            assert many[i, j] == pytest.approx(float(alone), rel=1e-7)
    readings = read_ridged(FINGER, ss.Hertz(40, half_width=widths[:, None]), Ridges(pitches))
    assert readings.shape == (2, 3, 2)
    single = read_ridged(FINGER, ss.Hertz(40, half_width=2e-3), Ridges(5e-3))
    np.testing.assert_allclose(readings[1, 2], single, rtol=1e-7)


def test_positions_do_not_matter_nor_which_pitch_away_a_crest_is():
    one = ridge_gain(FINGER, TOUCH, Ridges(1.7e-3, crest=0.2e-3))
    two = ridge_gain(FINGER, ss.Hertz(80.0, position=3e-3, half_width=2e-3), Ridges(1.7e-3, crest=3.2e-3 - 5.1e-3))
    for a, b in zip(one.equal_peak, two.equal_peak, strict=True):
        assert a == pytest.approx(float(b), rel=1e-6)
    assert two.smooth == pytest.approx(2 * one.smooth, rel=1e-6)


def test_beneath_and_between_are_readings_there():
    row = ss.Finger(SKIN, ss.SensorArray(y=np.array([-1, -0.5, 0, 0.5, 1]) * BEST, depth=DEPTH))
    touch = ss.Hertz(40.0, half_width=1.2 * BEST)
    found = ridge_gain(row, touch, Ridges(BEST))
    readings = np.abs(read_ridged(row, touch, Ridges(BEST))) / found.smooth
    assert found.equal_peak.beneath == pytest.approx(readings[::2].max(), rel=1e-7)
    assert found.equal_peak.between == pytest.approx(readings[1::2].max(), rel=1e-7)
    assert found.equal_peak.peak >= max(found.equal_peak.beneath, found.equal_peak.between)
    assert np.abs(row.read(touch)).max() <= found.smooth * (1 + 1e-7)


def test_a_contact_between_ridges_carries_nothing():
    found = ridge_gain(FINGER, ss.Strip(40.0, half_width=0.1e-3), Ridges(2e-3, "square", crest=1e-3))
    assert np.isinf(found.load_ratio)
    assert found.equal_peak.peak == 0
    assert np.isnan(found.equal_load.peak)


def test_noise_gain_and_range_are_those_of_the_array():
    array = ss.SensorArray(y=[0.0, 1e-3], depth=DEPTH, gain=[2.0, 0.0], offset=0.5, noise=1e-3, high=0.6)
    tip = ss.Finger(SKIN, array)
    plain = read_ridged(FINGER, TOUCH, Ridges(2e-3))[0]
    readings = read_ridged(tip, TOUCH, Ridges(2e-3))
    np.testing.assert_allclose(readings, [2 * plain + 0.5, 0.5], rtol=1e-7)
    noisy = read_ridged(tip, TOUCH, Ridges(2e-3), np.random.default_rng(1))
    np.testing.assert_allclose(noisy, readings + 1e-3 * np.random.default_rng(1).standard_normal(2), rtol=1e-12)


def test_locate_takes_a_ridged_line_load_for_what_it_is():
    row = ss.Finger(SKIN, ss.SensorArray.line(7, pitch=0.4e-3, depth=DEPTH, noise=1e-5))
    found = row.locate(read_ridged(row, ss.LineLoad(40.0, 0.2, 0.3e-3), Ridges(BEST)))
    assert found.position == pytest.approx(0.3e-3, abs=1e-8)
    assert found.force == pytest.approx(40.0 * np.cos(np.pi * 0.3e-3 / BEST), rel=1e-5)
    assert found.angle == pytest.approx(0.2, abs=1e-5)


def test_results_are_closed_to_writing_and_inputs_stay():
    pitch = np.array([1e-3, 2e-3])
    found = ridge_gain(FINGER, TOUCH, Ridges(pitch))
    pitch[:] = 0
    assert found.pitch.tolist() == [1e-3, 2e-3]
    for array in (found.pitch, found.half_width, found.load_ratio, *found.equal_peak, *found.equal_load):
        assert not array.flags.writeable


@pytest.mark.parametrize(
    ("arguments", "rule"),
    [
        ({"pitch": 0.0}, "> 0"),
        ({"pitch": np.nan}, "finite"),
        ({"pitch": 1e-3, "shape": "sine"}, "abs_cos"),
        ({"pitch": 1e-3, "duty": 0.5}, "only square ridges"),
        ({"pitch": 1e-3, "shape": "square", "duty": 1.5}, "<= 1"),
        ({"pitch": 1e-3, "kinks": (0.2,)}, "kinks of that shape are known"),
        ({"pitch": 1e-3, "shape": lambda u: 0.5 + 0 * u}, "all of it at its crest"),
        ({"pitch": 1e-3, "shape": lambda u: np.cos(2 * np.pi * u)}, "from 0 to 1"),
        ({"pitch": 1e-3, "shape": lambda u: 1.0}, "function of an array"),
        ({"pitch": 1e-3, "shape": lambda u: 1.0 * (np.abs(u) < 0.31)}, "kinks="),
        ({"pitch": [1e-3, 2e-3], "crest": [0.0, 0.0, 1e-3]}, "broadcast"),
    ],
)
def test_ridges_that_are_none(arguments, rule):
    with pytest.raises(ss.SubskinError, match=rule):
        Ridges(**arguments)


def test_what_cannot_be_asked():
    ridges = Ridges(2e-3)
    with pytest.raises(ss.errors.InvalidValueError, match="there are 0 to 1"):
        ridge_gain(FINGER, TOUCH, ridges, sensor=2)
    with pytest.raises(ss.errors.InvalidValueError, match="there are 0 to 1"):
        press_ridges(FINGER, 2e-3, 1e-5, force=40.0, radius=20e-3, sensor=-1)
    with pytest.raises(ss.errors.InvalidValueError, match="a Contact is needed"):
        ridge_gain(FINGER, 40.0, ridges)
    with pytest.raises(ss.errors.InvalidValueError, match="a Ridges is needed"):
        ridge_gain(FINGER, TOUCH, 2e-3)
    with pytest.raises(ss.errors.GeometryError, match="broadcast"):
        ridge_gain(FINGER, ss.Hertz(40.0, half_width=[1e-3, 2e-3]), Ridges([1e-3, 2e-3, 3e-3]))
    with pytest.raises(ss.errors.InvalidValueError, match="does not read"):
        ridge_gain(FINGER, ss.Hertz(0.0, half_width=1e-3), ridges)
    with pytest.raises(ss.errors.GeometryError, match="sensors read nothing"):
        ridge_gain(FINGER, TOUCH, Ridges(3.0))
    with pytest.raises(ss.errors.InvalidValueError, match="100 depths"):
        read_ridged(FINGER, ss.Strip(1.0, half_width=1.0), ridges)
    quadratic = ss.Finger(SKIN, ss.SensorArray(y=[0.0], depth=DEPTH, transducer=ss.EnergyDensity()))
    for ask in (lambda: ridge_gain(quadratic, TOUCH, ridges), lambda: best_ridge_pitch(quadratic)):
        with pytest.raises(ss.errors.NotLinearError):
            ask()
    with pytest.raises(ss.errors.GeometryError, match="touch all along"):
        press_ridges(FINGER, 2e-3, 1e-5, force=40.0)
    with pytest.raises(ss.errors.InvalidValueError, match="amplitude"):
        closing_pressure(SKIN, 2e-3, -1e-6)


def test_a_contact_that_hides_a_kink_is_noticed():
    class Hat(ss.Strip):
        def unit_pressure(self, y):
            return np.where(np.abs(y) < 0.317 * self._a, 1 / (2 * 0.317 * self._a), 0.0)

    with pytest.raises(ss.errors.ConvergenceError, match="force comes out wrong"):
        ridge_gain(FINGER, Hat(40.0, half_width=2e-3), Ridges(2e-3))


def test_pressed_ridges_of_no_height_are_the_smooth_contact():
    found = press_ridges(FINGER, 2e-3, [0.0, 5e-6], force=40.0, radius=30e-3)
    assert found.solved.peak[0] == pytest.approx(1.0, rel=1e-9)
    assert found.solved.ripple[0] == pytest.approx(0.0, abs=1e-9)
    assert np.isinf(found.filling[0])
    assert found.half_width[0] == pytest.approx(
        np.sqrt(4 * 40.0 * 30e-3 / (np.pi * SKIN.material.plane_strain_modulus)), rel=2e-3
    )
    assert found.touching[0] == 1
    assert 1 < found.solved.peak[1]
    assert found.solved.beneath[1] > found.solved.between[1]


def test_a_round_finger_on_ridges():
    tip = ss.Finger(ss.Round(SKIN.material, 8e-3, 4e-3), ss.SensorArray(y=[0.0], depth=DEPTH))
    found = press_ridges(tip, 0.8e-3, [5e-6, 40e-6], force=40.0)
    assert (found.status == ss.pressing.PressStatus.OK).all()
    assert found.touching[0] == 1 > found.touching[1]
    assert found.solved.peak[1] > found.solved.peak[0]


def gains(shape):
    tip = ss.Finger(SKIN, ss.SensorArray(y=[0.0], depth=DEPTH))
    widths, pitches = np.array([0.5, 2.0, 8.0]) * DEPTH, np.array([1.0, 3.0, 6.0, 20.0]) * DEPTH
    if shape == "map":
        return ridge_gain(tip, ss.Hertz(40.0, half_width=widths[:, None]), Ridges(pitches))
    if shape == "pitch":
        return ridge_gain(tip, TOUCH, Ridges(pitches))
    return ridge_gain(tip, ss.Hertz(40.0, half_width=widths), Ridges(BEST))


def pressed():
    tip = ss.Finger(SKIN, ss.SensorArray(y=[0.0], depth=DEPTH))
    return press_ridges(tip, 2e-3, np.array([2e-6, 10e-6, 40e-6]), force=100.0, radius=50e-3)


@pytest.mark.parametrize("kind", ["map", "pitch", "width", "pressed", "memo"])
def test_figures_are_labelled_and_nothing_covers_anything(kind):
    figure = {"pressed": lambda: pressed_ridges_figure(pressed()), "memo": lambda: memo_figure(16)}.get(
        kind, lambda: ridge_figure(gains(kind))
    )()
    figure.draw_without_rendering()
    assert round(figure.get_figwidth() * 25.4, 6) == 174.0
    for axes in figure.axes:
        sharing = [axes.get_shared_x_axes(), axes.get_shared_y_axes()]
        labels = [("get_xlabel", sharing[0]), ("get_ylabel", sharing[1])]
        for name, group in labels:
            assert any(getattr(other, name)() for other in group.get_siblings(axes))
    renderer = figure.canvas.get_renderer()
    fixed = [t for axes in figure.axes for t in (axes.title, axes._left_title, axes.xaxis.label, axes.yaxis.label)]
    fixed += [t for legend in figure.legends for t in legend.get_texts()]
    boxes = [(t, t.get_window_extent(renderer)) for t in fixed if isinstance(t, Text) and t.get_text()]
    for _, box in boxes:
        assert figure.bbox.x0 <= box.x0 < box.x1 <= figure.bbox.x1
        assert figure.bbox.y0 <= box.y0 < box.y1 <= figure.bbox.y1
    for (one, a), (two, b) in itertools.combinations(boxes, 2):
        assert min(min(a.x1, b.x1) - max(a.x0, b.x0), min(a.y1, b.y1) - max(a.y0, b.y0)) < 2.0, (one, two)


def test_figures_show_the_numbers():
    found = gains("pitch")
    left, right = ridge_figure(found).axes
    for axes, values in ((left, found.equal_peak), (right, found.equal_load)):
        for line, gain in zip(axes.lines, values, strict=False):
            np.testing.assert_allclose(line.get_ydata(), gain)
            np.testing.assert_allclose(line.get_xdata(), found.pitch / DEPTH)
    smooth, ridged, below, beneath = memo_figure(16).axes
    assert smooth.get_title(loc="left") == "Smooth: 1.56 times the load"
    assert "2.02 times the strain" in ridged.get_title(loc="left")
    curves = [max(axes.lines, key=lambda line: np.size(line.get_xdata())) for axes in (below, beneath)]
    tops = [np.abs(line.get_ydata()).max() for line in curves]
    assert tops[1] / tops[0] == pytest.approx(2.0166, rel=1e-3)
    marks = {line.get_marker(): line for line in beneath.lines}
    np.testing.assert_allclose(marks["o"].get_xdata(), [-2 * np.pi, 0, 2 * np.pi], atol=1e-6)
    assert len(marks["s"].get_xdata()) > 0
    assert (marks["o"].get_ydata() < 0).all()
    assert (marks["s"].get_ydata() > 0).all()


def test_figures_that_cannot_be_drawn():
    with pytest.raises(ss.errors.GeometryError, match="three or more"):
        ridge_figure(ridge_gain(FINGER, TOUCH, Ridges([1e-3, 2e-3])))
    with pytest.raises(ss.errors.GeometryError, match="has to change"):
        ridge_figure(ridge_gain(FINGER, TOUCH, Ridges([2e-3] * 3)))
    widths = np.array([1e-3, 2e-3, 3e-3])
    turned = ridge_gain(FINGER, ss.Hertz(40.0, half_width=widths), Ridges(widths[:, None]))
    with pytest.raises(ss.errors.GeometryError, match="first axis"):
        ridge_figure(turned)
    with pytest.raises(ss.errors.GeometryError, match="have a height"):
        pressed_ridges_figure(press_ridges(FINGER, 2e-3, [0.0, 1e-5, 2e-5], force=40.0, radius=20e-3))
