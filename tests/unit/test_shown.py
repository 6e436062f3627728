"""What a person sees of a result: text, tables, dictionaries and figures say what the numbers are."""

from __future__ import annotations

import re
import sys

import numpy as np
import pytest

import subskin as ss
from subskin._shown import span, with_error
from subskin.errors import GeometryError, InvalidValueError
from subskin.io import parse_finger

SKIN = ss.HalfPlane(ss.Material(young=0.4e6))
FINGER = ss.Finger(SKIN, ss.SensorArray.line(count=8, pitch=1.5e-3, depth=2e-3, noise=5e-4))
MANY = ss.LineLoad(40.0, 0.2, np.linspace(-5e-3, 5e-3, 100))
TOUCH = ss.Hertz(force=40.0, angle=0.3, position=0.8e-3, half_width=0.4e-3)


@pytest.fixture(scope="module")
def found():
    """Six frames, the first two without a touch."""
    force = np.array([0.0, 0.0, 40.0, 40.0, 40.0, 40.0])
    touches = ss.LineLoad(force, 0.2, np.linspace(-4e-3, 4e-3, 6))
    return FINGER.locate(FINGER.read(touches, np.random.default_rng(0)))


@pytest.mark.parametrize(
    ("value", "std", "text"),
    [
        (0.7902, 0.0334, "0.79 +- 0.03 mm"),
        (0.7902, 0.0154, "0.790 +- 0.015 mm"),
        (-3997234.0, 11300.0, "-3997000 +- 11000 mm"),
        (0.9996, 0.04, "1.00 +- 0.04 mm"),
        (-0.0001, 0.5, "0.0 +- 0.5 mm"),
        (1.23456, 0.0, "1.235 mm"),
        (1.23456, np.nan, "1.235 mm"),
        (np.nan, 1.0, "-"),
    ],
)
def test_a_number_has_the_digits_that_its_error_leaves(value, std, text):
    assert with_error(value, std, "mm") == text


def test_a_range_is_of_what_is_known():
    assert span([1.0, np.nan, -2.0], "mm") == "-2 to 1 mm"
    assert span([2.0, 2.0]) == "2"
    assert span([np.nan]) == "-"


def test_one_frame_says_what_was_found_with_errors_and_units(found):
    one = found[2]
    text = repr(one)
    numbers = re.search(
        r"Estimate\(OK, position (\S+) \+- (\S+) mm, force (\S+) \+- (\S+) N/m, angle (\S+) \+- (\S+) deg;\n *"
        r"chi-square \S+ with 5 to spare\)",
        text,
    )
    said = np.array([float(n) for n in numbers.groups()]).reshape(3, 2)
    scale = np.array([1e3, 1.0, 180 / np.pi])
    right = scale * [one.position, one.force, one.angle]
    np.testing.assert_allclose(said[:, 1], scale * one.std, rtol=0.3)
    assert (np.abs(said[:, 0] - right) <= 0.51 * scale * one.std).all()
    assert repr(found[0]).startswith("Estimate(NO_CONTACT")


def test_many_frames_say_counts_and_ranges(found):
    text = repr(found).splitlines()
    assert text[0] == "Estimate of 6 frames: 4 OK, 2 NO_CONTACT"
    low, high = (float(v) for v in re.search(r"position +(\S+) to (\S+) mm", text[1]).groups())
    assert (low, high) == pytest.approx((1e3 * found.position[2], 1e3 * found.position[5]), abs=0.01)
    table = found._repr_html_()
    assert table.count("<tr>") == 7
    assert "&plusmn;" in table
    assert "<th>position [mm]</th>" in table
    assert repr(found[:0]) == "Estimate of 0 frames: none"
    assert "frames of shape (2, 3)" in repr(found[np.arange(6).reshape(2, 3)])


def test_ok_picks_the_frames_that_are(found):
    assert found.ok.tolist() == [False, False, True, True, True, True]
    assert found[found.ok].shape == (4,)
    assert found[2].ok.shape == ()


def test_a_dictionary_has_the_columns_of_the_tables(found):
    columns = found.to_dict()
    assert list(columns)[:6] == ["position", "force", "angle", "position_std", "force_std", "angle_std"]
    np.testing.assert_array_equal(columns["angle_std"], found.std[:, 2])
    assert columns["status"].tolist() == ["no_contact"] * 2 + ["ok"] * 4
    one = found[2].to_dict()
    assert (type(one["position"]), one["status"]) == (float, "ok")
    wide = FINGER.fit(FINGER.read(TOUCH), "hertz").to_dict()
    assert wide["half_width_low"] <= wide["half_width"] <= wide["half_width_high"]
    assert "half_width" not in columns


def test_pandas_is_asked_for_where_it_is_missing(found, monkeypatch):
    monkeypatch.setitem(sys.modules, "pandas", None)
    with pytest.raises(ModuleNotFoundError, match="Fix: pip install pandas"):
        found.to_pandas()


def test_a_pandas_table_has_a_row_a_frame(found):
    pytest.importorskip("pandas")
    table = found.to_pandas()
    np.testing.assert_array_equal(table["position"], found.position)
    assert found[np.arange(6).reshape(2, 3)].to_pandas().index.tolist()[3] == (1, 0)
    assert len(found[2].to_pandas()) == 1


def test_the_others_say_what_they_are(found):
    said = ss.decide.contact_type(FINGER, FINGER.read(TOUCH))
    assert repr(said).startswith(f"TypeDecision({said.name}, p(line) ")
    judged = ss.decide.slip(found, 0.6)
    assert repr(judged).splitlines()[0] == "Slip of 6 frames: 4 HOLDS, 2 CANNOT_TELL"
    assert "<table>" in judged._repr_html_()
    assert repr(FINGER).splitlines()[1] == "  skin      a half plane (0.4 MPa, nu 0.5)"
    assert "<td>8 NormalStrain</td>" in FINGER._repr_html_()
    text = "[skin]\nyoung = 4e5\n[sensors]\ncount = 4\npitch = 2e-3\ndepth = 2e-3\n[locate]\nfriction = 0"
    lines = repr(parse_finger(text, "a<b.toml")).splitlines()
    assert lines[0] == "FingerFile a<b.toml"
    assert "  locate    friction = 0" in lines
    assert "a&lt;b.toml" in parse_finger(text, "a<b.toml")._repr_html_()
    positions = np.linspace(-4e-3, 4e-3, 9)
    readings = FINGER.read(ss.LineLoad(40.0, position=positions))
    known = ss.calibrate(FINGER, readings, positions, force=40.0, fit=("depth", "origin"))
    assert repr(known).startswith("Calibration on 9 touches: R^2 1.00000; sensors 8 OK\n  origin")
    unknown = ss.calibrate_blind(FINGER, FINGER.read(MANY))
    title, *rows = repr(unknown).splitlines()
    assert title == f"BlindCalibration on {unknown.used.sum()} of 100 touches: sensors 8 OK"
    assert rows[8].startswith("  depth")
    assert rows[8].endswith(" mm")
    still = ss.Tare(FINGER)(np.zeros((30, 8)), 0.01 * np.arange(30))
    assert repr(still).splitlines()[:2] == ["Tared of 30 frames", "  free of contact  30 frames"]


def test_loads_and_tables_are_said_in_the_units_of_people(found):
    assert repr(ss.Load(1e-3, [30.0, 40.0])) == "Load(y 1 mm, force 50 N/m, angle 53.13 deg)"
    local = ss.Load([1e-3, -2e-3], [4.0, 0.0, -3.0], moment=2e-3)
    assert repr(local) == "Load(y 1 mm, z -2 mm, force 5 N, angle 36.87 deg, azimuth -90 deg, moment 2 N mm)"
    many = repr(ss.Load([-1e-3, 2e-3], [[30.0, 40.0], [3.0, 4.0]])).splitlines()
    assert many[:3] == ["Load of shape (2,)", "  y      -1 to 2 mm", "  force  5 to 50 N/m"]
    assert repr(found.second).startswith("Rival(in ")
    spots = FINGER.blind_spots(count=20)
    head, names, *rows = repr(spots).splitlines()
    assert head == spots.sentence
    assert names.split("  ")[-1] == "unexplained"
    assert len(rows) == len(spots.rows)
    assert "<th>OK and wrong</th>" in spots._repr_html_()
    health = repr(ss.calibration.sensor_health(FINGER, FINGER.read(MANY))).splitlines()
    assert health[0].startswith(f"SensorHealth from {len(MANY.position)} touches: 100 % explained")
    assert [line.split()[:2] for line in health[1:]] == [[str(i), "OK"] for i in range(8)]


def legends(figure):
    return [text.get_text() for legend in figure.legends for text in legend.get_texts()]


def test_figures_are_drawn_by_the_things_themselves(found):
    assert legends(FINGER.plot()) == ["sensor"]
    assert any(text.startswith("load: 40 N/m") for text in legends(FINGER.plot(TOUCH)))
    alone = legends(found[2].plot(FINGER))
    assert any(text.startswith("found (ok)") for text in alone)
    assert not any(text.startswith("true") for text in alone)
    assert any(text.startswith("found (ok)") for text in legends(found[2].plot()))
    assert len(found.plot().axes) == 2
    assert found.plot(truth=np.linspace(-4e-3, 4e-3, 6)).axes[0].get_ylabel() == "estimated position [mm]"
    assert ss.decide.slip(found, 0.6).plot(3).axes


def test_a_map_of_the_field_takes_one_call():
    figure = SKIN.plot(TOUCH, "strain.yy", span=(-2e-3, 3e-3), depth=1e-3)
    axes = figure.axes[0]
    assert axes.get_xlim() == pytest.approx((-2.0, 3.0))
    assert axes.get_ylim()[0] == pytest.approx(1.0)
    layer = ss.Layered(ss.Layer(ss.Material(young=0.4e6), thickness=3e-3))
    assert "rigid base" in legends(layer.plot(TOUCH, depth=3e-3))


@pytest.mark.parametrize(
    ("draw", "error", "said"),
    [
        (lambda found: SKIN.plot(TOUCH, "stress.rr"), InvalidValueError, "component = 'stress.rr'"),
        (lambda found: SKIN.plot(ss.LineLoad([1.0, 2.0])), GeometryError, "a single contact"),
        (lambda found: SKIN.plot(TOUCH, span=(1e-3, 0.0)), InvalidValueError, "has to ascend"),
        (lambda found: FINGER.plot(title="x"), InvalidValueError, "nothing that presses"),
        (lambda found: found[0].plot(), GeometryError, "nothing to draw"),
        (lambda found: found[0].plot(FINGER), GeometryError, "neither a contact"),
        (lambda found: found.plot(FINGER), GeometryError, "a finger goes with a single frame"),
    ],
)
def test_what_cannot_be_drawn_is_said(found, draw, error, said):
    with pytest.raises(error, match=said):
        draw(found)


@pytest.mark.parametrize(("force", "area"), [(40.0, False), (1.0, False), (1e-6, False), (1e4, False), (1e-2, True)])
def test_a_colour_bar_lies_on_the_page_and_says_the_strain(force, area):
    """Its tick times the power of ten is the level in percent, and no letter of it leaves the page."""
    skin = ss.HalfSpace(ss.Material(young=0.4e6)) if area else SKIN
    load = ss.PointLoad(force) if area else ss.LineLoad(force)
    figure = ss.plot.field_map(skin, load, "strain.xx", span=(-4e-3, 4e-3))
    figure.canvas.draw()
    bar = next(axes for axes in figure.axes if "[" in axes.get_ylabel() and "%" in axes.get_ylabel())
    page = figure.bbox
    for text in (bar.yaxis.label, *bar.get_yticklabels()):
        box = text.get_window_extent()
        assert page.x0 <= box.x0
        assert box.x1 <= page.x1
    power = re.search(r"10\^\{(-?\d+)\}", bar.get_ylabel())
    scale = 10.0 ** int(power[1]) if power else 1.0
    ticks = [scale * float(text.get_text().replace("−", "-")) for text in bar.get_yticklabels()]
    assert len(ticks) > 2
    np.testing.assert_allclose(ticks, bar.get_yticks(), rtol=1e-6, equal_nan=False)


def test_a_legend_has_no_minus_zero():
    load = ss.PointLoad(1.0, angle=0.3, azimuth=-1e-4, position=(-1e-7, -1e-7))
    finger = ss.Finger(ss.HalfSpace(ss.Material(0.4e6)), ss.SensorArray.grid((3, 3), 2e-3, depth=2e-3))
    said = [text.get_text() for text in finger.plot(load).legends[0].get_texts()]
    assert any("towards 0°, at (0.00, 0.00) mm" in text for text in said)
    row = [text.get_text() for text in FINGER.plot(ss.LineLoad(1.0, -1e-5, -1e-7)).legends[0].get_texts()]
    assert any("0.0°, y = 0.00 mm" in text and "−" not in text for text in row)


def test_presses_are_shown_in_a_few_lines():
    """Of what was put in: 100 presses from 1 to 100 s at 0 to 9.9 mm; a text, no dump of arrays."""
    time, position = np.arange(1.0, 101.0), np.arange(100) * 1e-4
    reading = np.full((100, 4), 3.0)
    shown = repr(ss.stream.Presses(time, time + 0.5, position, None, None, reading, 0.1 * reading, 2))
    assert shown.splitlines()[0] == "100 presses of 4 sensors, 2 plateaus left out"
    assert "1 to 100 s" in shown
    assert "0 to 9.9 mm" in shown
    assert len(shown.splitlines()) < 8
    area = np.stack([position, -position], axis=-1)
    shown = repr(ss.stream.Presses(time, time, area, position, time, reading, reading))
    assert re.search(r"position z +-9.9 to 0 mm", shown)


def test_a_map_without_a_drag_is_told_its_option():
    with pytest.raises(InvalidValueError, match='Fix: shear="none"'):
        ss.pressure_map(FINGER, np.zeros(8), friction=0)


def test_what_looks_at_a_finger_shows_shapes_and_ends():
    """Results of design are shown by a line or two, and not by thousands of numbers."""
    touches = ss.design.Touches(force=20.0)
    for result in (
        ss.design.placement_quality(FINGER, touches, grid=(21, 11)),
        ss.design.spatial_response(FINGER),
        ss.design.sensor_density(FINGER),
    ):
        assert "array(" not in repr(result)
        assert len(repr(result)) < 1500
    shown = repr(ss.design.placement_quality(FINGER, touches, grid=(21, 11)))
    assert "PlacementQuality(finger=Finger(...)" in shown
    assert "std={position: (21, 11) from " in shown
