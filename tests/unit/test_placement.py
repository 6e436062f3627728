"""Placement of sensors: what is refused, and what is left blank."""

import numpy as np
import pytest

import subskin as ss
from subskin.design import Touches, placement_quality
from subskin.design.placement import PLACEMENT_MEASURES, Channel, study_at_depth
from subskin.errors import GeometryError, InvalidValueError, NotLinearError
from subskin.plot import placement_figure, placement_study_figure

SKIN = ss.HalfPlane(ss.Material(young=0.4e6))
KIND = ss.NormalStrain()
TOUCH = Touches(force=40.0)
FINGER = ss.Finger(SKIN, ss.SensorArray.line(4, 1.5e-3, 2e-3, noise=5e-5))


def rows(pitches=(1e-3, 2e-3), counts=(4,), skin=SKIN, kind=KIND, depth=2e-3, touches=TOUCH, **options):
    channel = Channel(kind, options.pop("noise", 5e-5), options.pop("width", 0.0))
    options = {"samples": 100} | options
    return study_at_depth(skin, channel, depth, list(pitches), list(counts), touches, **options)


@pytest.mark.parametrize(
    ("bad", "error", "said"),
    [
        ({"counts": [2, 4]}, InvalidValueError, "2 sensors"),
        ({"counts": [4.5]}, InvalidValueError, "whole numbers"),
        ({"noise": 0.0}, InvalidValueError, "noise"),
        ({"noise": -1.0}, InvalidValueError, "noise"),
        ({"depth": 0.0}, InvalidValueError, "depth"),
        ({"pitches": [0.0]}, InvalidValueError, "pitches"),
        ({"pitches": [[1e-3]]}, GeometryError, "pitches"),
        ({"width": -1e-3}, InvalidValueError, "width"),
        ({"samples": 0}, InvalidValueError, "samples"),
        ({"margin": -0.1}, InvalidValueError, "margin"),
        ({"grid": (1, 5)}, InvalidValueError, "grid"),
        ({"grid": (11.5, 5)}, InvalidValueError, "grid"),
        ({"kind": ss.EnergyDensity()}, NotLinearError, "EnergyDensity"),
        ({"skin": ss.Layered(ss.Layer(ss.Material(1e6), 1e-3))}, GeometryError, "thick"),
        (
            {"skin": ss.Round(ss.Material(1e6), 8e-3, 4e-3), "touches": Touches(40.0, span=(-0.03, 0.03))},
            GeometryError,
            "about",
        ),
    ],
)
def test_what_makes_no_row_is_refused(bad, error, said):
    with pytest.raises(error, match=said):
        rows(**bad)


def test_two_sensors_do_where_the_angle_is_known():
    found = rows(counts=[2, 4], touches=Touches(40.0, friction=0.0))
    assert np.isfinite(found["position_95"]).all()
    assert (found["angle_worst"] == 0).all()
    assert (found["position_mean"][:, 1] < found["position_mean"][:, 0]).all()


def test_rows_that_do_not_fit_are_blank_and_the_others_are_not():
    skin = ss.Round(ss.Material(0.4e6), 8e-3, 4e-3)  # 50.3 mm about
    found = rows([1e-3, 3e-3], [4, 16, 17], skin, width=1.5e-3)
    for name in PLACEMENT_MEASURES:
        np.testing.assert_array_equal(np.isnan(found[name]), [[True] * 3, [False, False, True]])
    assert all(np.isnan(v).all() for v in rows([1e-3], width=2e-3).values())


def test_all_of_a_span_counts_felt_or_not():
    near = rows([1e-3], touches=Touches(4.0, span=(-2e-3, 2e-3)))
    far = rows([1e-3], touches=Touches(4.0, span=(-60e-3, 60e-3)))
    assert near["unfelt"] == 0
    assert 0.5 < far["unfelt"][0, 0] < 1
    assert far["position_worst"] > 100 * near["position_worst"]


def test_the_row_stands_in_the_middle_of_the_span():
    here, there = (rows([1e-3], touches=Touches(40.0, span=(a - 2e-3, a + 2e-3)), samples=400) for a in (0.0, 7e-3))
    for name in PLACEMENT_MEASURES:
        np.testing.assert_allclose(here[name], there[name], rtol=1e-6)


def test_progress_is_told_of_each_design():
    calls = []
    rows(counts=[3, 4, 5], progress=lambda: calls.append(1))
    assert len(calls) == 6


def test_results_are_closed_to_writing():
    quality = placement_quality(FINGER, TOUCH, grid=(5, 3))
    arrays = [v for v in vars(quality).values() if isinstance(v, np.ndarray)]
    assert len(arrays) > 5
    assert not any(a.flags.writeable for a in arrays)


def test_a_finger_that_cannot_be_judged_is_refused():
    with pytest.raises(InvalidValueError, match="noise"):
        placement_quality(ss.Finger(SKIN, ss.SensorArray.line(4, 1e-3, 2e-3)), TOUCH)
    dead = ss.Finger(SKIN, ss.SensorArray([0.0, 1e-3, 2e-3], 2e-3, gain=[1.0, 0.0, 1.0], noise=1e-4))
    with pytest.raises(InvalidValueError, match="2 sensors"):
        placement_quality(dead, TOUCH)


def test_figures_refuse_what_they_cannot_draw():
    with pytest.raises(GeometryError, match="one angle"):
        placement_figure(placement_quality(FINGER, Touches(40.0, 0.0), grid=(5, 3)))
    pitches, counts = 2e-3 * np.array([0.3, 0.5, 0.6, 0.7, 1.0, 2.0]), [3, 4, 6]
    study = rows(pitches, counts, samples=2000)
    for bad in ({"counts": [3, 4]}, {"pitches": [1e-3]}, {"depth": 0.0}, {"measure": "angle_worst"}):
        with pytest.raises(InvalidValueError):
            placement_study_figure(study, **({"depth": 2e-3, "pitches": pitches, "counts": counts} | bad))
    with pytest.raises(GeometryError, match="one pitch"):
        placement_study_figure(rows([1e-3]), 2e-3, [1e-3], [4])
    thick = [a for a in placement_study_figure(study, 2e-3, pitches, counts).axes[0].lines if a.get_linewidth() > 3]
    assert len(thick) == 2  # three sensors are never told to 1 %


@pytest.mark.parametrize("margin", [1e300, 1e4, np.inf])
def test_a_margin_from_which_nothing_is_felt_is_refused_at_once(margin, monkeypatch):
    monkeypatch.setattr("subskin.design.placement.study.OneSensor", pytest.fail)
    with pytest.raises(InvalidValueError, match=r"margin = .* has to be .*Fix: margin=1\.5"):
        rows(margin=margin)
    finger = ss.Finger(SKIN, ss.SensorArray.line(4, 1e-3, 1e-3, noise=1e-4))
    with pytest.raises(InvalidValueError, match="margin"):
        ss.design.placement_quality(finger, ss.design.Touches(force=40.0), margin=margin)
