"""The slip figure draws what was found: cone, load, least grip, zones."""

from __future__ import annotations

import numpy as np
import pytest
from matplotlib.patches import Ellipse

import subskin as ss
from subskin.decide import Friction, least_force, slip
from subskin.plot import slip_figure

from ._estimates import estimate


def lines(axes):
    return {line.get_label(): line for line in axes.lines}


def test_load_cone_and_error_ellipse():
    made = estimate(30.0, 8.0, (1.0, 0.3, 0.5))
    plane, _ = slip_figure(slip(made, Friction.between(0.4, 0.6))).axes
    drawn = lines(plane)
    assert drawn["load found, 95 %"].get_xydata() == pytest.approx(np.array([[30.0, 8.0]]))
    (x0, y0), (x1, y1) = drawn["cone, by its median"].get_xydata()
    assert (y1 - y0) / (x1 - x0) == pytest.approx(0.5)
    (ring,) = [p for p in plane.patches if isinstance(p, Ellipse)]
    values = np.linalg.eigvalsh([[1.0, 0.3], [0.3, 0.5]])[::-1]
    assert [ring.width, ring.height] == pytest.approx(2 * np.sqrt(5.991465 * values), rel=1e-6)
    turn = 0.5 * np.degrees(np.arctan2(2 * 0.3, 1.0 - 0.5))
    assert (ring.angle - turn) % 180 == pytest.approx(0, abs=1e-9) or (turn - ring.angle) % 180 < 1e-9
    words = " ".join(t.get_text() for t in plane.texts)
    assert f"{float(least_force(made, Friction.between(0.4, 0.6))):.3g} N/m" in words
    assert "holds: probability of slip" in plane.get_title(loc="left")


def test_stick_zone_of_one_frame_of_a_batch():
    made = estimate([30.0, 30.0], [5.0, -9.0], (1e-9, 0.0, 1e-9))
    judged = slip(made, 0.5, contact="wedge")
    _, zone = slip_figure(judged, frame=1).axes
    slips, sticks = zone.patches[:2]
    assert slips.get_width() == pytest.approx(2.0)
    assert sticks.get_width() == pytest.approx(2 * (1 - 9 / 15))
    shear, held = lines(zone)["shear, $|q|$"], lines(zone)["what friction holds, $\\mu\\,p$"]
    y = shear.get_xdata()
    assert np.trapezoid(held.get_ydata(), y) / 2 == pytest.approx(1.0, rel=2e-3)
    assert np.trapezoid(shear.get_ydata(), y) / 2 == pytest.approx(9 / 15, rel=4e-3)
    outside = np.abs(y) > 0.41
    assert shear.get_ydata()[outside] == pytest.approx(held.get_ydata()[outside])


@pytest.mark.parametrize("contact", ["hertz", "punch"])
def test_shear_adds_up_to_the_drag(contact):
    judged = slip(estimate(30.0, 6.0, (1e-9, 0.0, 1e-9)), 0.5, contact=contact)
    _, zone = slip_figure(judged).axes
    shear = lines(zone)["shear, $|q|$"]
    total = np.trapezoid(shear.get_ydata(), shear.get_xdata()) / 2
    assert total == pytest.approx(6 / 15, rel=0.04)  # a sum over a root's infinite ends


def test_nothing_to_tell_and_nothing_that_sticks():
    none = slip_figure(slip(estimate(30.0, 6.0, status=ss.Status.NO_CONTACT), 0.5))
    assert none.axes[0].get_title(loc="left") == "cannot tell: no contact"
    line = slip_figure(slip(estimate(30.0, 6.0), 0.5, contact="line"))
    assert "no stick zone" in line.axes[1].get_title(loc="left")
    slides = slip_figure(slip(estimate(30.0, -20.0), 0.5))
    assert slides.axes[1].get_title(loc="left") == "slides all over"
    assert "slips" in slides.axes[0].get_title(loc="left")


@pytest.mark.parametrize("frame", [0, (0, 1), 7])
def test_a_frame_that_is_not_there(frame):
    judged = slip(estimate(30.0, 6.0), 0.5) if frame == 0 else slip(estimate([30.0, 30.0], 6.0), 0.5)
    with pytest.raises(ss.errors.GeometryError, match="one frame"):
        slip_figure(judged, frame=frame)
