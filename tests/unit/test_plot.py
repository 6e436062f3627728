"""Figures as pictures and as files: sizes, labels, nothing over anything else, the same bytes each time."""

import itertools
import subprocess
import sys
from functools import cache
from pathlib import Path

import matplotlib as mpl
import numpy as np
import pytest
from matplotlib.text import Text

import subskin as ss
from subskin.design.placement import Channel, study_at_depth
from subskin.errors import FileError, InvalidValueError
from subskin.plot import (
    MEMO_FIGURES,
    aliasing_figure,
    contact_strip,
    density_figure,
    field_map,
    finger_above,
    finger_section,
    memo_figure,
    placement_figure,
    placement_study_figure,
    probability_strip,
    response_figure,
    save,
    save_memo_figures,
    truth_against_estimate,
    two_point_figure,
    two_point_study_figure,
)

SKIN = ss.HalfPlane(ss.Material(young=0.4e6))
FINGER = ss.Finger(SKIN, ss.SensorArray.line(count=8, pitch=1.5e-3, depth=2e-3, noise=5e-4))


def section(width=174.0):
    touch = ss.LineLoad(force=40.0, angle=-0.3, position=0.8e-3)
    frame = FINGER.read(touch, np.random.default_rng(3))
    return finger_section(
        FINGER, touch, FINGER.locate(frame), readings=frame, title="A touch and its load", width=width
    )


AREA = ss.Finger(
    ss.HalfSpace(ss.Material(young=0.4e6)),
    ss.SensorArray.grid((4, 4), 3e-3, [3e-3, 2e-3], channels=[ss.MeanPressure(), ss.ShearStrain("xz")], noise=20.0),
)
WIDE = ss.Finger(AREA.skin, ss.SensorArray.grid((8, 2), 3e-3, 3e-3, transducer=ss.MeanPressure()))
ROUND = ss.RoundHertz(force=1.5, angle=0.5, azimuth=0.8, position=(1e-3, -2e-3), half_width=1e-3)
LOCATED = ss.Load((1.2e-3, -1.8e-3), (1.3, 0.4, 0.5), np.diag([2e-4, 4e-4, 0.1, 0.1, 0.1]) ** 2)


CLOSE = ss.Finger(SKIN, ss.SensorArray.line(count=6, pitch=1e-3, depth=2e-3, noise=2e-5))


def stroke():
    """Frames of a line, a roller and a faint wedge that go along the skin, of nonsense and of nothing."""
    y, rng = np.linspace(-2e-3, 2e-3, 12), np.random.default_rng(0)
    touches = (
        ss.LineLoad(30.0, 0.1, y),
        ss.Hertz(30.0, 0.2, y, half_width=1.6e-3),
        ss.Wedge(6.0, 0.2, y, half_width=0.25e-3),
    )
    odd = [np.tile([1e-2, -1e-2], (8, 3)), rng.normal(0, 2e-5, (6, 6))]
    return np.concatenate([*(CLOSE.read(touch, rng) for touch in touches), *odd])


def truth(count, title="Held out"):
    rng = np.random.default_rng(1)
    true = np.linspace(-9e-3, 9e-3, count)
    found = true + 5e-5 * rng.standard_normal(count)
    status = np.zeros(count, dtype=int)
    status[3::20], status[9::40] = ss.Status.AMBIGUOUS, ss.Status.NO_CONTACT
    found[3::20] += 3e-3
    found[9::40] = np.nan
    return truth_against_estimate(true, found, 5e-5, status, title=title)


def rows_of_sensors():
    pitches = 2e-3 * np.array([0.3, 0.5, 0.7, 1.0, 1.5, 2.0])
    channel, counts = Channel(ss.NormalStrain(), 5e-5), [3, 4, 6]
    study = study_at_depth(SKIN, channel, 2e-3, pitches, counts, ss.design.Touches(40.0), samples=1000)
    return placement_study_figure(study, 2e-3, pitches, counts)


FIGURES = {f"memo {n}": lambda n=n: memo_figure(n) for n in MEMO_FIGURES} | {
    "section": section,
    "narrow section": lambda: section(84.0),
    "touches": lambda: truth(60),
    "frames": lambda: truth(5000),
    "from above": lambda: finger_above(AREA, ROUND, LOCATED, title="A touch on an area"),
    "from above, wide": lambda: finger_above(WIDE, ROUND),
    "from above, bare": AREA.plot,
    "readings from above": lambda: AREA.plot(ROUND, LOCATED, readings=AREA.read(ROUND), title="Readings"),
    "readings of one kind": lambda: WIDE.plot(ROUND, readings=WIDE.read(ROUND)),
    "local field": lambda: field_map(AREA.skin, ss.PointLoad(force=1.0, angle=0.6, azimuth=0.4)),
    "two points": lambda: two_point_figure(
        ss.design.two_point_limen(FINGER, ss.design.Touches(force=1.0), against="wide", positions=7)
    ),
    "two points, a study": lambda: two_point_study_figure(
        ss.design.two_point_study(
            FINGER, ss.design.Touches(force=40.0), count=(3, 6), pitch=(0.5, 1.0, 2.0), positions=3, shares=0.5
        )
    ),
    "contact strip": lambda: contact_strip(CLOSE.fit(stroke(), "hertz")),
    "placement": lambda: placement_figure(ss.design.placement_quality(FINGER, ss.design.Touches(40.0))),
    "placement study": rows_of_sensors,
    "probability strip": lambda: probability_strip(ss.decide.contact_type(CLOSE, stroke())),
    "response": lambda: response_figure(ss.design.spatial_response(FINGER)),
    "density": lambda: density_figure(ss.design.sensor_density(FINGER, [10, 1000])),
    "aliasing error": lambda: aliasing_figure(ss.design.aliasing_error(FINGER, ss.Hertz(40.0, 0.3, half_width=1e-3))),
}


@pytest.fixture(scope="module", params=FIGURES)
def name(request):
    """One figure after the other through all tests, so that one process makes it once."""
    return request.param


@cache
def made(name):
    """A figure, and whether making it left the user's settings alone."""
    with mpl.rc_context({"font.size": 14.0, "axes.facecolor": "red"}):
        before = dict(mpl.rcParams)
        figure = FIGURES[name]()
        return figure, dict(mpl.rcParams) == before


@cache
def drawn(name):
    with mpl.rc_context({"xtick.labelsize": 16.0, "ytick.labelsize": 16.0, "axes.labelsize": 16.0}):  # a user's own
        made(name)[0].draw_without_rendering()
    return made(name)[0]


def words(figure):
    """Each visible text with its box on the page [dots]."""
    renderer = figure.canvas.get_renderer()
    ticks = {}
    for axes, axis in itertools.product(figure.axes, ("xaxis", "yaxis")):
        for tick in getattr(axes, axis).get_major_ticks():
            at = tick.get_loc()
            low, high = sorted(getattr(axes, axis).get_view_interval())
            slack = 1e-9 * (high - low)
            for label in (tick.label1, tick.label2):
                ticks[label] = low - slack <= at <= high + slack
    texts = [t for t in figure.findobj(Text) if t.get_visible() and t.get_text().strip() and ticks.get(t, True)]
    return [(text, text.get_window_extent(renderer)) for text in texts]


def test_width_is_that_of_a_column_or_a_page(name):
    assert round(drawn(name).get_figwidth() * 25.4, 6) in (84.0, 174.0)


def test_every_axis_says_what_it_is(name):
    figure = drawn(name)
    for axes in figure.axes:
        below = [other for other in axes.get_shared_x_axes().get_siblings(axes) if other is not axes]
        beside = [other for other in axes.get_shared_y_axes().get_siblings(axes) if other is not axes]
        bar = axes.get_label() == "<colorbar>" or axes.get_position().width < 0.05
        assert axes.get_xlabel() or bar or any(other.get_xlabel() for other in below)
        assert axes.get_ylabel() or any(other.get_ylabel() for other in beside)


def test_no_text_leaves_the_page_or_covers_another(name):
    figure = drawn(name)
    page, texts = figure.bbox, words(figure)
    assert len(texts) > 10
    for text, box in texts:
        assert box.x0 >= page.x0 - 0.5, text
        assert box.x1 <= page.x1 + 0.5, text
        assert box.y0 >= page.y0 - 0.5, text
        assert box.y1 <= page.y1 + 0.5, text
    for (one, a), (two, b) in itertools.combinations(texts, 2):
        overlap = min(a.x1, b.x1) - max(a.x0, b.x0), min(a.y1, b.y1) - max(a.y0, b.y0)
        assert min(overlap) < 2.0, (one, two)


def test_no_legend_covers_data(name):
    figure = drawn(name)
    legends = [*figure.legends, *(axes.get_legend() for axes in figure.axes if axes.get_legend())]
    boxes = [legend.get_window_extent() for legend in legends]
    for axes, box in itertools.product(figure.axes, boxes):
        frame = axes.get_window_extent()
        for line in axes.lines:
            at = line.get_transform().transform(line.get_xydata())
            inside = frame.count_contains(at) and (box.contains(*p) and frame.contains(*p) for p in at)
            assert not (inside and any(inside)), line


def test_type_is_not_too_small(name):
    sizes = [text.get_fontsize() for text, _ in words(drawn(name))]
    assert 6.0 <= min(sizes)
    assert max(sizes) == 8.0


@pytest.mark.parametrize(
    ("kind", "kinds"), [("memo 6", ["svg", "png", "pdf"]), ("section", ["svg"]), ("touches", ["svg"])]
)
def test_files_are_the_same_each_time(tmp_path, kind, kinds):
    figure = FIGURES[kind]()
    first = save(figure, tmp_path / "first", kinds)
    with mpl.rc_context({"font.size": 20.0, "axes.grid": True, "lines.linewidth": 5.0, "svg.hashsalt": "other"}):
        again = save(FIGURES[kind](), tmp_path / "second", kinds), save(figure, tmp_path / "third", kinds)
    for file, second, third in zip(first, *again):
        assert file.read_bytes() == second.read_bytes()
        assert file.read_bytes() == third.read_bytes()
        assert file.stat().st_size > 5000


def test_png_has_300_dots_an_inch(tmp_path):
    from matplotlib.image import imread

    (file,) = save_memo_figures([2], tmp_path, ["png"])
    assert imread(file).shape[1] == int(84 / 25.4 * 300)


def test_save_memo_figures_makes_its_folder_and_leaves_nothing_else(tmp_path):
    folder = tmp_path / "a" / "b"
    files = save_memo_figures([2, 12], folder)
    assert [file.name for file in files] == [f"memo_figure_{n}.{kind}" for n in ("02", "12") for kind in ("svg", "png")]
    assert sorted(folder.iterdir()) == sorted(files)
    assert files[0].read_text().startswith("<?xml")
    assert files[1].read_bytes().startswith(b"\x89PNG")


def test_none_means_all_the_figures(tmp_path, monkeypatch):
    figure = memo_figure(12)
    monkeypatch.setattr("subskin.plot.memo_figure", lambda number: figure)
    files = save_memo_figures(None, tmp_path, "svg")
    assert [file.stem for file in files] == [f"memo_figure_{n:02d}" for n in (2, 3, 6, 9, *range(11, 20))]


@pytest.mark.parametrize("number", [1, 0, -2, 20, 2.5, "two", True, None])
def test_an_unknown_figure_is_refused_and_the_others_are_named(tmp_path, number):
    with pytest.raises(InvalidValueError, match="2, 3, 6, 9, 11, 12, 13"):
        memo_figure(number)
    with pytest.raises(InvalidValueError, match="2, 3, 6, 9, 11, 12, 13"):
        save_memo_figures([2, number], tmp_path / "new")
    assert not (tmp_path / "new").exists()


@pytest.mark.parametrize("formats", [["svg", "gif"], "jpg", [""]])
def test_an_unknown_format_is_refused_and_nothing_is_written(tmp_path, formats):
    with pytest.raises(InvalidValueError, match="pdf, png, svg"):
        save_memo_figures([2], tmp_path / "new", formats)
    assert not (tmp_path / "new").exists()


def test_save_takes_the_format_from_the_name(tmp_path):
    figure = memo_figure(12)
    assert save(figure, tmp_path / "one.SVG") == [tmp_path / "one.svg"]
    assert save(figure, tmp_path / "two.v2") == [tmp_path / "two.v2.svg", tmp_path / "two.v2.png"]
    assert save(figure, tmp_path / "three.png", ["pdf"]) == [tmp_path / "three.pdf"]
    assert len(list(tmp_path.iterdir())) == 4


def test_what_cannot_be_written_is_said_and_the_old_file_stays(tmp_path, monkeypatch):
    (tmp_path / "file").write_text("not a folder")
    with pytest.raises(FileError, match="cannot be written"):
        save(memo_figure(12), tmp_path / "file" / "figure.svg")

    figure, old = memo_figure(12), tmp_path / "figure.svg"
    old.write_text("old")

    def fails(path, data):
        path.write_text("half")
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(Path, "write_bytes", fails)
    with pytest.raises(FileError, match="No space left"):
        save(figure, old)
    assert old.read_text() == "old"
    assert sorted(p.name for p in tmp_path.iterdir()) == ["figure.svg", "file"]


def test_the_users_settings_stay_as_they_are_and_do_not_show(name):
    figure, untouched = made(name)
    assert untouched
    assert all(axes.get_facecolor() == (1.0, 1.0, 1.0, 1.0) for axes in figure.axes)


def test_pyplot_is_never_imported_nor_matplotlib_by_the_package(tmp_path):
    program = f"""
import sys
import subskin
assert not any(name.partition('.')[0] == 'matplotlib' for name in sys.modules)
import subskin.plot
subskin.plot.save_memo_figures([13], {str(tmp_path / "there")!r}, ['svg'])
assert 'matplotlib.pyplot' not in sys.modules
"""
    subprocess.run([sys.executable, "-W", "error", "-c", program], check=True)
    (here,) = save_memo_figures([13], tmp_path / "here", ["svg"])
    assert here.read_bytes() == (tmp_path / "there" / here.name).read_bytes()  # nor does the process matter
