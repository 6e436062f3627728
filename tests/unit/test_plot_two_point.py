"""The figures on two points show what was found."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import subskin as ss
from subskin.design import Touches, two_point_limen, two_point_study
from subskin.errors import GeometryError
from subskin.plot import two_point_figure, two_point_study_figure

UNIT = ss.HalfPlane(ss.Material(young=1.5 / np.pi))


def row(count, noise=1e-3):
    return ss.Finger(UNIT, ss.SensorArray.line(count, 0.5, depth=1.0, noise=noise))


def test_the_figure_says_where_two_points_are_not_told():
    found = two_point_limen(row(3, noise=1e-2), Touches(1.0, span=(-2, 2)))
    figure = two_point_figure(found)
    marks = [line for line in figure.axes[0].lines if "read as one" in str(line.get_label())]
    never = np.isinf(found.separation).any(axis=(1, 2))
    assert marks[0].get_xdata().tolist() == (found.position[never] * 1e3).tolist()
    share = figure.axes[1].lines[0].get_ydata()
    assert share[-1] == pytest.approx(100 * np.isfinite(found.separation).mean())


def test_the_study_figure_draws_a_line_a_count():
    study = two_point_study(row(2), Touches(1.0, span=(-1, 1)), count=[4, 5], pitch=[0.5, 1.0], positions=3, shares=0.5)
    figure = two_point_study_figure(study)
    lines = figure.axes[0].lines
    assert [line.get_label() for line in lines] == ["4 sensors", "5 sensors"]
    assert lines[1].get_ydata().tolist() == study.worst[1, 0, :, 1].tolist()
    many = replace(study, count=np.arange(8), worst=np.ones((8, 1, 2, 3)))
    with pytest.raises(GeometryError, match="8 counts"):
        two_point_study_figure(many)
