"""The figure of a stream with drift shows what was read, what was followed, and where the skin was free."""

from __future__ import annotations

import numpy as np
import pytest

import subskin as ss
from subskin.plot import drift_figure


@pytest.fixture(scope="module")
def stream():
    tip = ss.Finger(ss.HalfPlane(ss.Material(0.4e6)), ss.SensorArray.line(4, pitch=2e-3, depth=2e-3, noise=1e-4))
    time = np.arange(0.0, 20.0, 0.02)
    force = 40.0 * ((time > 8) & (time < 12))
    drift = 2e-5 * time
    raw = tip.read(ss.LineLoad(force), np.random.default_rng(0)) + drift[:, None]
    return raw, time, ss.Tare(tip, drift=4e-5)(raw, time), drift


def test_lines_and_shading_are_those_of_the_stream(stream):
    raw, time, tared, drift = stream
    figure = drift_figure(raw, time, tared, sensor=1, truth=drift, unit="strain")
    top, low = figure.axes
    lines = {line.get_label(): line.get_ydata() for line in top.get_lines()}
    np.testing.assert_array_equal(lines["read"], raw[:, 1])
    np.testing.assert_array_equal(lines["offset, followed"], tared.offset[:, 1])
    np.testing.assert_array_equal(lines["offset, true"], drift)
    shaded = [patch.get_extents().transformed(low.transData.inverted()) for patch in low.patches]
    starts = np.flatnonzero(np.diff(np.concatenate([[0], tared.free.astype(int)])) == 1)
    np.testing.assert_allclose([box.x0 for box in shaded], time[starts], atol=1e-9)
    assert len(shaded) == 2
    assert (top.get_ylabel(), low.get_ylabel(), low.get_xlabel()) == ("reading [strain]", "offset [strain]", "time [s]")
    bottom, height = low.get_ylim()
    assert bottom < tared.offset[:, 1].min() < tared.offset[:, 1].max() < height < 0.002


def test_without_the_truth_or_a_unit(stream):
    raw, time, tared, _ = stream
    figure = drift_figure(raw, time, tared)
    assert [axes.get_ylabel() for axes in figure.axes] == ["reading", "offset"]
    assert len(figure.axes[1].get_lines()) == 1


@pytest.mark.parametrize(
    ("change", "error", "seen"),
    [
        ({"sensor": 4}, ss.errors.InvalidValueError, "sensor = 4"),
        ({"sensor": -1}, ss.errors.InvalidValueError, "sensor = -1"),
        ({"truth": [1.0]}, ss.errors.GeometryError, "truth"),
        ({"time": [1.0]}, ss.errors.GeometryError, "time"),
    ],
)
def test_what_does_not_fit_is_said(stream, change, error, seen):
    raw, time, tared, _ = stream
    with pytest.raises(error, match=seen):
        drift_figure(**{"readings": raw, "time": time, "tared": tared, **change})
