"""The memo's figures show what the formulas say: curves, roots and marks, against formulas spelt out here."""

import numpy as np
import pytest
from matplotlib.colors import to_hex

from subskin.plot import memo_figure

MARKERS = {"o": "accepted", "v": "pulls", "s": "slips"}


def curve(axes, label):
    """The data of the one line with this label."""
    (line,) = [line for line in axes.lines if line.get_label() == label]
    return np.asarray(line.get_xdata()), np.asarray(line.get_ydata())


def flamant(x, y, angle):
    """eps_x of a line load at 0, P = E = 1 (memo eq. 8; drag towards +y)."""
    return -3 / (2 * np.pi) * (x * np.cos(angle) + y * np.sin(angle)) * (x**2 - y**2) / (x**2 + y**2) ** 2


@pytest.mark.parametrize(("number", "angle"), [(2, 0.0), (3, np.pi / 6)])
def test_figures_2_and_3_are_the_strain_beneath_a_line_load(number, angle):
    sketch, axes = memo_figure(number).axes
    depths = {"$d$": 1.0, r"$1.5\,d$": 1.5, r"$2\,d$": 2.0, r"$3\,d$": 3.0}
    for label, depth in depths.items():
        y, strain = curve(axes, label)
        assert (y[0], y[-1]) == (-6.0, 6.0)
        np.testing.assert_allclose(strain, flamant(depth, y, angle), rtol=0, atol=1e-14)
    marks = [line for line in axes.lines if line.get_marker() == "o"]
    assert len(marks) == 4
    for mark, depth in zip(marks, depths.values(), strict=True):
        positions = np.asarray(mark.get_xdata())
        assert positions.size == 2 + (angle > 0)
        assert not np.any(mark.get_ydata())
        np.testing.assert_allclose(flamant(depth, positions, angle), 0.0, atol=1e-15)
        assert any(np.array_equal(line.get_xdata(), positions) for line in sketch.lines)


def test_figure_3_draws_the_arrow_towards_plus_y():
    (arrow,) = [text for text in memo_figure(3).axes[0].texts if text.get_text() == ""]
    (y_head, x_head), (y_tail, x_tail) = arrow.xy, arrow.get_position()
    assert np.arctan2(y_head - y_tail, x_head - x_tail) == pytest.approx(np.deg2rad(30), abs=1e-12)


def test_figure_6_marks_every_real_root_with_its_verdict():
    axes, sketch = memo_figure(6).axes
    x, b, readings = 3.0, 2.5, (0.048, -0.18, -0.19)
    y = np.poly1d([1.0, 0.0])
    q = {t: (x**2 + (y + t) ** 2) for t in (-b, 0.0, b)}
    g = {t: (x**2 - (y + t) ** 2) for t in (-b, 0.0, b)}
    f = 2 * readings[1] * q[0.0] ** 2 * g[-b] * g[b]
    f -= readings[0] * q[b] ** 2 * g[0.0] * g[-b] + readings[2] * q[-b] ** 2 * g[0.0] * g[b]
    roots = np.sort([r.real for r in f.roots if abs(r.imag) < 1e-9])
    assert len(roots) == 4

    marks = {float(line.get_xdata()[0]): line for line in axes.lines if line.get_marker() in MARKERS}
    np.testing.assert_allclose(sorted(marks), roots, rtol=0, atol=1e-9)
    assert all(line.get_ydata()[0] == 0 for line in marks.values())
    verdicts = [MARKERS[marks[position].get_marker()] for position in sorted(marks)]
    assert verdicts == ["pulls", "slips", "accepted", "pulls"]
    assert len({to_hex(line.get_color()) for line in marks.values()}) == 3

    position, height = max((line.get_data() for line in axes.lines), key=lambda data: np.size(data[0]))
    np.testing.assert_allclose(height, f(position) / (x**2 + position**2) ** 4, rtol=0, atol=1e-13)
    assert np.count_nonzero(np.diff(np.sign(height))) == 4
    for lobe in np.split(height, np.flatnonzero(np.diff(np.sign(height))) + 1):  # every root can be seen
        assert np.abs(lobe).max() > 0.05 * np.ptp(height)
    words = [text.get_text() for text in sketch.texts]
    (accepted,) = [text for text in words if text.endswith("accepted")]
    assert "+1.491" in accepted
    assert "-22.5" in accepted
    assert sum(text.endswith("pulls") for text in words) == 2


def test_figure_9_is_punch_wedge_and_line_load():
    surface, near, far = memo_figure(9).axes
    punch, wedge = (line.get_data() for line in surface.lines[:2])
    np.testing.assert_allclose(punch[1], 1 / (np.pi * np.sqrt(1 - punch[0] ** 2)), rtol=1e-9)
    np.testing.assert_allclose(wedge[1], np.arccosh(1 / np.abs(wedge[0])) / np.pi, rtol=1e-9)
    for axes, x in ((near, 0.5), (far, 2.0)):
        s = np.hypot(x, 1.0)
        centre = {
            "flat punch, its edges at ±a": -3 / (2 * np.pi) * x**2 / s**3,
            "wedge, its tip at 0": -3 / (2 * np.pi * s),
            "line load": -3 / (2 * np.pi * x),
        }
        for label, value in centre.items():
            y, strain = curve(axes, label)
            assert strain[y == 0].item() == pytest.approx(value, rel=1e-12)
            np.testing.assert_allclose(strain, strain[::-1], atol=1e-13)


def test_figure_11_is_a_hertz_contact_and_eq_17_makes_it_twice_as_wide():
    stress, strain = memo_figure(11).axes
    y, surface = curve(stress, "surface")
    np.testing.assert_allclose(surface, -2 / np.pi * np.sqrt(1 - y**2), atol=1e-9)
    y, printed = curve(stress, "surface, eq. (17) taken for the half width")
    assert np.ptp(y) == pytest.approx(4.0, rel=1e-12)
    assert printed.min() == pytest.approx(surface.min() / 2, rel=1e-12)
    for line, (label, x) in zip(
        strain.lines[:3], {r"depth $0.5\,a$": 0.5, "depth $a$": 1.0, r"depth $2\,a$": 2.0}.items(), strict=True
    ):
        s = np.hypot(x, 1.0)
        position, values = line.get_data()
        assert values[position == 0].item() == pytest.approx(-3 / np.pi * x * (1 - x / s), rel=1e-12)
        y, normal = curve(stress, label)
        assert normal[y == 0].item() == pytest.approx(-2 / (np.pi * s), rel=1e-12)


def test_figure_12_drags_in_proportion_to_pressure():
    (axes,) = memo_figure(12).axes
    y, pressure = curve(axes, "pressure $p$")
    _, shear = curve(axes, r"shear $q = p\,\tan\alpha$")
    np.testing.assert_allclose(shear, pressure * np.tan(np.deg2rad(25)), atol=1e-12)
    assert pressure.max() == pytest.approx(1.0)
    assert np.count_nonzero(np.diff(np.sign(np.diff(pressure)))) == 3
    arrows = [text for text in axes.texts if text.get_text() == ""]
    assert len(arrows) > 8
    inverse = axes.transData
    for arrow in arrows:
        tail, tip = (np.asarray(p) for p in (arrow.get_position(), arrow.xy))
        assert tip[1] == pytest.approx(-np.interp(tail[0], y, pressure), abs=1e-9)
        on_paper = inverse.transform(tip) - inverse.transform(tail)  # to scale: the angle is seen as it is
        assert np.degrees(np.arctan2(on_paper[0], -on_paper[1])) == pytest.approx(25.0, abs=0.01)


def test_figure_13_slopes_are_those_of_the_curves_and_vanish_at_the_blind_depth():
    far, near, slopes = memo_figure(13).axes
    x, right = curve(slopes, "slope under the centre")
    _, printed = curve(slopes, "by eq. (21) as printed")
    for axes, depth in ((far, 2.0), (near, 0.4)):
        for degrees in (0, 15, 30, 45):
            y, strain = curve(axes, f"α = {degrees}°")
            i, h = np.flatnonzero(y == 0).item(), y[1] - y[0]
            drawn = np.dot(strain[i - 3 : i + 4], [-1, 9, -45, 0, 45, -9, 1]) / (60 * h)
            here = np.interp(depth, x, right) * np.sin(np.deg2rad(degrees))
            assert drawn == pytest.approx(here, abs=2e-6)
        solid, dashed = [line for line in axes.lines if np.size(line.get_xdata()) == 2 and line.get_zorder() == 3]
        for line, values in ((solid, right), (dashed, printed)):
            (y0, y1), (e0, e1) = line.get_data()
            expected = np.interp(depth, x, values) * np.sin(np.pi / 4)
            assert (e1 - e0) / (y1 - y0) == pytest.approx(expected, rel=1e-9)
    (mark,) = [line for line in slopes.lines if line.get_marker() == "o"]
    blind = float(mark.get_xdata()[0])
    assert blind == pytest.approx(np.interp(0.0, -right[:200], x[:200]), abs=1e-4)
    assert right[0] > 0 > right[-1]
    assert printed[0] < 0 < printed[-1]  # as printed: of the other sign
    eq21 = 3 * np.sqrt(3) / (4 * np.pi**2) * (x**2 - 1) / (x**2 + 1) ** 2  # with the full width 2 for its a
    np.testing.assert_allclose(printed, eq21, rtol=0, atol=1e-14)
