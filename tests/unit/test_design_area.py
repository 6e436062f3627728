"""Arrays on an area: bounds, ambiguity, blind arrays, and the search from goals to ranked fingers."""

from dataclasses import replace

import numpy as np
import pytest

import subskin as ss
from subskin.design import Goals, Touches, placement_quality, rank_fingers, search_grid
from subskin.design.placement import Arrangement, Channel, layouts, study_at_depth
from subskin.design.search import Accuracy, Effort, Mix, Room, Row, SensorKind, SkinChoice
from subskin.design.search.grid import studied
from subskin.design.search.refine import freed
from subskin.design.two_point import edge_direction, two_point_area
from subskin.design.words import reasons_of, verdict_of
from subskin.errors import GeometryError, InvalidValueError
from subskin.io import FolderStore, load, parse_goals
from subskin.io.goals_file import GoalsFile, finger_text

SKIN = ss.HalfSpace(ss.Material(young=0.4e6))
BOX = ((-4e-3, 4e-3), (-3e-3, 3e-3))
TOUCHES = Touches(force=1.0, friction=0.5, area=BOX)
LINES = Touches(force=40.0)
GAUGE, PRESSURE = (
    SensorKind("gauge", ss.NormalStrain(), 1e-3),
    SensorKind("pressure", ss.MeanPressure(), 30.0, 0.0, 8e4),
)
GOALS = Goals(
    touches=TOUCHES,
    strongest=1.5,
    accuracy=Accuracy(position=0.4e-3, force=0.3),
    sensors=(GAUGE, PRESSURE),
    skins=(SkinChoice("thick", SKIN),),
    room=Room(
        count=(6, 7), depth=(3e-3, 3.5e-3), least_pitch=3e-3, area=(18e-3, 9e-3), layouts=("row", "grid", "hexagonal")
    ),
    largest_strain=0.25,
    tolerances={},
    effort=Effort(depths=2, pitches=1, touches=100, keep=3),
)


def grid_finger(kind=None, noise=1e-3, depth=2.5e-3):
    kind = kind or ss.NormalStrain()
    return ss.Finger(SKIN, ss.SensorArray.grid((4, 4), pitch=2.5e-3, depth=depth, transducer=kind, noise=noise))


def fisher(finger, touch):
    """Of (y, z, (a), N, Ty, Tz) by differences of what the finger reads."""
    names = ("position", "half_width", "components") if hasattr(touch, "half_width") else ("position", "components")
    columns = []
    for name in names:
        value = np.atleast_1d(np.asarray(getattr(touch, name), dtype=float))
        for i in range(value.size):
            step = np.zeros(value.size)
            step[i] = 1e-4 if name == "components" else 1e-6
            ends = []
            for sign in (1, -1):
                given = {n: getattr(touch, n) for n in names} | {name: value + sign * step}
                given["half_width"] = float(np.asarray(given["half_width"]).reshape(())) if "half_width" in given else 0
                if not given["half_width"]:
                    del given["half_width"]
                ends.append(finger.read(type(touch)(**given)))
            columns.append((ends[0] - ends[1]) / (2 * step[i]))
    jacobian = np.stack(columns, axis=-1) / np.asarray(finger.array.noise)[:, None]
    return jacobian.T @ jacobian


@pytest.fixture(scope="module")
def quality():
    return placement_quality(grid_finger(), TOUCHES, grid=(7, 6), samples=1000)


def test_bounds_are_those_of_differences_of_the_readings(quality):
    for j, k, d in ((0, 0, 0), (3, 2, 4), (5, 6, 12)):
        touch = ss.PointLoad(components=quality.load[d], position=quality.position[j, k])
        expected = np.linalg.inv(fisher(quality.finger, touch))
        scale = np.sqrt(np.outer(np.diag(expected), np.diag(expected)))
        np.testing.assert_allclose(quality.covariance[j, k, d] / scale, expected / scale, atol=2e-5, equal_nan=False)
        across = np.eye(3) - np.outer(*2 * [quality.load[d] / 1.0])
        angle = np.sqrt(np.linalg.eigvalsh(across @ expected[2:, 2:] @ across)[-1])
        assert quality.std["angle"][j, k, d] == pytest.approx(angle, rel=1e-4)
        widest = np.sqrt(np.linalg.eigvalsh(expected[:2, :2])[-1])
        assert quality.std["position"][j, k, d] == pytest.approx(widest, rel=1e-4)


def test_the_radius_of_a_round_touch_is_an_unknown_more():
    touches = replace(TOUCHES, half_width=1.5e-3)
    found = placement_quality(grid_finger(), touches, grid=(3, 3), samples=20)
    assert found.covariance.shape[-1] == 6
    where = found.position[0, 1]
    touch = ss.RoundHertz(components=found.load[4], position=where, half_width=1.5e-3)
    expected = np.linalg.inv(fisher(found.finger, touch))
    scale = np.sqrt(np.outer(np.diag(expected), np.diag(expected)))
    np.testing.assert_allclose(found.covariance[0, 1, 4] / scale, expected / scale, atol=1e-3, equal_nan=False)
    assert found.std["radius"][0, 1, 4] == pytest.approx(np.sqrt(expected[2, 2]), rel=1e-3)
    channel, array = [Channel(ss.NormalStrain(), 1e-3)], [Arrangement("grid", (4, 4))]
    row = study_at_depth(SKIN, channel, 2.5e-3, [2.5e-3], array, touches, grid=(3, 3), samples=20)
    for name in ("position_95", "radius_mean", "force_worst"):
        assert row[name][0, 0] == pytest.approx(found[name], rel=1e-6)


def test_what_is_foretold_is_what_locate_does(quality):
    """The errors of frames with noise are those of the bounds; shares of ambiguous touches within 0.05."""
    few = ss.SensorArray.grid((3, 2), pitch=4e-3, depth=2.5e-3, transducer=ss.MeanPressure(), noise=50.0)
    for finger in (quality.finger, ss.Finger(SKIN, few)):
        found = quality if finger is quality.finger else placement_quality(finger, TOUCHES, grid=(7, 6), samples=1000)
        rng = np.random.default_rng(1)
        touch = TOUCHES.sample(1500, rng)
        seen = finger.locate(finger.read(touch, rng), search=found.search, friction=0.5)
        ambiguous = (seen.status == ss.Status.AMBIGUOUS).mean()
        assert found["ambiguous"] == pytest.approx(ambiguous, abs=0.05)
        sure = seen.status == ss.Status.OK
        off = np.linalg.norm(np.asarray(seen.position) - np.asarray(touch.position), axis=-1)[sure]
        # the worst direction's error is kept by 95 %: twice it by all but a few of these
        assert np.mean(off > 2 * found["position_95"]) < 0.03
        assert np.median(off) > 0.2 * np.median(found.std["position"])
    assert quality["ambiguous"] < 0.03 < found["ambiguous"]


@pytest.mark.long
def test_errors_of_many_frames_are_the_covariance(quality):
    touch = ss.PointLoad(components=quality.load[4], position=quality.position[3, 2])
    frames = np.broadcast_to(quality.finger.read(touch), (4000, 16))
    frames = frames + 1e-3 * np.random.default_rng(2).standard_normal(frames.shape)
    seen = quality.finger.locate(frames, search=quality.search, friction=0.5)
    errors = np.concatenate([seen.position - touch.position, seen.components - touch.components], axis=-1)
    ratio = np.var(errors, axis=0) / np.diag(quality.covariance[3, 2, 4])
    np.testing.assert_allclose(ratio, 1.0, atol=0.12)


def test_sensors_on_a_line_do_not_see_the_touch():
    """Four of five unknowns (docs/locating_area.md); shear gauges beside them, or a grid, see all."""
    row, grid = Arrangement("row", (6,)), Arrangement("grid", (3, 2))
    gauge, shear = Channel(ss.NormalStrain(), 1e-3), Channel(ss.ShearStrain("xz"), 1e-3)
    study = study_at_depth(SKIN, [gauge], 3e-3, [2e-3], [row, grid], TOUCHES, grid=(5, 4), samples=20)
    assert study["rank"].tolist() == [[4.0, 5.0]]
    assert study["ambiguous"][0, 0] == 1
    assert np.isinf(study["position_95"][0, 0])
    assert np.isfinite(study["position_95"][0, 1])
    both = study_at_depth(SKIN, [gauge, shear], 3e-3, [2e-3], [row], TOUCHES, grid=(4, 4), samples=20)
    assert both["rank"].tolist() == [[4.0]]  # every strain at nu = 1/2 is (F.r) times a function of position
    moved = [Channel(ss.transducer.Displacement(axis), 1e-6) for axis in "xyz"]
    two = study_at_depth(SKIN, moved, 3e-3, [4e-3], [Arrangement("row", (2,))], TOUCHES, grid=(5, 4), samples=20)
    assert two["rank"].tolist() == [[5.0]]  # two magnets, six readings


def test_kinds_that_take_turns_and_kinds_at_each_position():
    gauge, shear = Channel(ss.NormalStrain(), 1e-3), Channel(ss.ShearStrain("xy"), 1e-3)
    grid = Arrangement("grid", (3, 2))
    turns = study_at_depth(SKIN, [gauge, shear], 3e-3, [3e-3], [grid], TOUCHES, together=False, grid=(5, 4), samples=20)
    at, which = grid.points(3e-3), grid.colours(2)
    kinds = [(gauge, shear)[i].transducer for i in which]
    finger = ss.Finger(SKIN, ss.SensorArray(at[:, 0], 3e-3, kinds, z=at[:, 1], noise=1e-3))
    alone = placement_quality(finger, TOUCHES, grid=(5, 4), samples=20)
    assert sorted(which.tolist()) == [0, 0, 0, 1, 1, 1]
    assert turns["log_det"][0, 0] == pytest.approx(alone["log_det"], rel=1e-6)
    both = study_at_depth(SKIN, [gauge, shear], 3e-3, [3e-3], [grid], TOUCHES, grid=(5, 4), samples=20)
    assert both["position_mean"][0, 0] < turns["position_mean"][0, 0]


def test_layouts_keep_to_the_sides_of_the_area():
    for layout in layouts(("grid", "hexagonal"), (3, 16), slender=1.5):
        along, across = layout.size
        assert 3 <= layout.count <= 16
        assert 0.75 - 1e-9 <= along / across <= 3 + 1e-9
    points = Arrangement("hexagonal", (2, 3, 2)).points(1.0)
    apart = np.sort(np.linalg.norm(points[:, None] - points, axis=-1), axis=1)
    np.testing.assert_allclose(apart[:, 1:4], 1.0)  # three neighbours each, and the middle one six
    assert (apart[:, 6] < 1 + 1e-9).sum() == 1
    with pytest.raises(InvalidValueError, match="one sensor more"):
        Arrangement("hexagonal", (3, 3))


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return tmp_path_factory.mktemp("search")


@pytest.fixture(scope="module")
def grid(folder):
    return search_grid(GOALS, store=FolderStore(folder / "search"))


@pytest.fixture(scope="module")
def study(grid):
    return rank_fingers(grid)


def test_a_search_that_was_killed_goes_on_to_the_same_bytes(grid, folder, tmp_path):
    seen = []

    def stop():
        seen.append(1)
        if len(seen) == 1:
            raise KeyboardInterrupt

    store = FolderStore(tmp_path)
    with pytest.raises(KeyboardInterrupt):
        search_grid(GOALS, store=store, workers=1, progress=stop)
    kept = {path.name: path.read_bytes() for path in tmp_path.glob("*.npz")}
    whole = {path.name: path.read_bytes() for path in (folder / "search").glob("*.npz")}
    assert 1 <= len(kept) < len(whole) == 4
    assert kept.items() <= whole.items()
    again = search_grid(GOALS, store=store)
    assert {path.name: path.read_bytes() for path in tmp_path.glob("*.npz")} == whole
    for name, values in grid.values.items():
        np.testing.assert_array_equal(again.values[name], values, err_msg=name)


def test_a_design_of_the_grid_is_what_its_finger_does(grid):
    at = (0, 1, 1, 0, [layout.pattern for layout in GOALS.layouts].index("grid"))
    row = grid.row(*at)
    finger = GOALS.finger(row)
    found = placement_quality(finger, TOUCHES, grid=(9, 6), samples=100)
    for name in ("position_95", "angle_mean", "force_95", "log_det", "rank"):
        assert grid.values[name][at] == pytest.approx(found[name], rel=1e-6)
    # straight beneath a point load at nu = 1/2: eps_x = 3 F / (2 pi E x^2), pressure F (1 + nu) / (3 pi x^2) ...
    depth = row.depth
    assert grid.values["strain"][at] == pytest.approx(3 * 1.5 / (2 * np.pi * 0.4e6 * depth**2), rel=1e-3)
    assert grid.values["range"][at] == pytest.approx(1.5 / (2 * np.pi * depth**2) / 8e4, rel=1e-3)


def test_rows_have_no_room_or_see_nothing_and_say_so(grid, study):
    rows = [n for n, layout in enumerate(GOALS.layouts) if layout.pattern == "row"]
    ranks = grid.values["rank"][..., rows]
    assert np.nanmax(ranks) == 4
    assert np.isinf(grid.values["position_95"][..., rows][~np.isnan(ranks)]).all()
    finger = next(f for f in study.fingers if f.row.which(GOALS)[2] - 1 in rows)
    assert "does not see the touch: it tells 4 of its 5 unknowns" in " ".join(reasons_of(study, finger.row))


def test_fingers_are_ranked_and_go_into_files(study, tmp_path):
    best = study.fingers[0]
    assert best.meets
    assert "meets every goal" in verdict_of(study)
    assert [f.meets for f in study.fingers] == sorted((f.meets for f in study.fingers), reverse=True)
    for finger in study.fingers:
        assert finger.row.layout.pattern in ("grid", "hexagonal")
        assert finger.values["position_95"] == pytest.approx(finger.quality["position_95"], rel=0.25)
    text = """
    touch = {force = ["1 N", "1.5 N"], friction = 0.5, area = ["8 mm", "6 mm"], largest_strain = 0.25}
    accuracy = {position = "0.4 mm", force = 0.3}
    room = {count = [6, 7], depth = ["3 mm", "3.5 mm"], least_pitch = "3 mm", area = ["18 mm", "9 mm"],
            layouts = ["row", "grid", "hexagonal"]}
    sensor = [{name = "gauge", kind = "normal_strain", noise = 1e-3}, {name = "pressure", kind = "mean_pressure",
              noise = "30 Pa", largest = "80 kPa"}]
    skin = [{name = "thick", kind = "half_space", young = "0.4 MPa"}]
    tolerances = {none = true}
    search = {depths = 2, pitches = 1, touches = 100, keep = 3}
    """.replace("\n            ", " ")
    file = parse_goals(text)
    assert replace(file.goals, title="Finger") == replace(GOALS, title="Finger")
    for k, layout in enumerate((best.row.layout, Arrangement("grid", (3, 2)))):
        row = replace(best.row, layout=layout)
        path = tmp_path / f"finger_{k}.toml"
        path.write_text(finger_text(file, row, best.quality.search, ["tried"]))
        back = load(path).finger
        np.testing.assert_allclose(back.array.points, GOALS.finger(row).array.points, atol=1e-7, equal_nan=False)
        assert back.array.transducers == GOALS.finger(row).array.transducers


def test_mixes_go_into_files(tmp_path):
    mixes = tuple(Mix(f"mix {k}", (GAUGE, PRESSURE), together=bool(k)) for k in (0, 1))
    goals = replace(GOALS, mixes=mixes)
    assert goals.readings(2, 6) == 6
    assert goals.readings(3, 6) == 12
    raw = {"kind": "half_space", "young": "0.4 MPa"}
    for m in (2, 3):
        row = Row(0, m, Arrangement("grid", (3, 2)), 3e-3, 2.5e-3)
        path = tmp_path / f"finger_{m}.toml"
        path.write_text(finger_text(GoalsFile(goals, (raw,), ""), row, BOX, []))
        back, own = load(path).finger.array, goals.finger(row).array
        np.testing.assert_allclose(back.points, own.points, atol=1e-9, equal_nan=False)
        assert back.transducers == own.transducers
        for name in ("noise", "low", "high"):
            np.testing.assert_array_equal(getattr(back, name), getattr(own, name))


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"skins": (SkinChoice("plane", ss.HalfPlane(ss.Material(0.4e6))),)}, "solved in a plane"),
        ({"accuracy": Accuracy(position=1e-4, radius=1e-4)}, "points"),
    ],
)
def test_what_is_not_worked_out_on_an_area_is_refused(change, message):
    with pytest.raises(InvalidValueError, match=message):
        replace(GOALS, **change)


def test_an_unknown_layout_is_refused():
    with pytest.raises(InvalidValueError, match='layout "circle"'):
        Room((6, 9), (3e-3, 4e-3), 2e-3, layouts=("circle",))


def test_rows_refuse_what_is_of_an_area():
    with pytest.raises(GeometryError, match="a 2 x 2 grid"):
        study_at_depth(SKIN, Channel(ss.NormalStrain(), 1e-3), 2e-3, [2e-3], [Arrangement("grid", (2, 2))], LINES)
    with pytest.raises(InvalidValueError, match="2 channels"):
        study_at_depth(SKIN, [Channel(ss.NormalStrain(), 1e-3)] * 2, 2e-3, [2e-3], [4], LINES)
    with pytest.raises(InvalidValueError, match="are on an area"):
        Touches(1.0, half_width=1e-3)
    with pytest.raises(InvalidValueError, match="a span is of line loads"):
        Touches(1.0, span=(-1e-3, 1e-3), area=BOX)


def test_the_direction_of_an_edge_is_told_as_differences_of_readings_say():
    """An edge of points, evenly loaded; unknown are its position, direction and all three components of its force."""
    finger, length = grid_finger(), 4e-3
    found = edge_direction(finger, TOUCHES, length, positions=3, directions=4)
    t, weight = np.polynomial.legendre.leggauss(24)

    def read(unknowns):
        y, z, turn, *components = unknowns
        at = np.array([y, z]) + 0.5 * length * t[:, None] * np.array([np.cos(turn), np.sin(turn)])
        load = 0.5 * weight[:, None] * np.array(components)
        return finger.read(ss.PointLoad(components=load, position=at)).sum(axis=0)

    middle, turn = (-4e-3, 0.0), np.pi * 1.25 / 4
    point = np.array([*middle, turn, 1.0, 0.0, 0.0])
    steps = np.array([1e-6, 1e-6, 1e-4, 1e-3, 1e-3, 1e-3])
    columns = [(read(point + s * e) - read(point - s * e)) / (2 * s) for s, e in zip(steps, np.eye(6), strict=True)]
    jacobian = np.stack(columns, axis=-1) / 1e-3
    expected = np.sqrt(np.linalg.inv(jacobian.T @ jacobian)[2, 2])
    assert found[0, 1, 1] == pytest.approx(expected, rel=1e-4)


def test_two_touches_on_an_area_read_as_two_as_often_as_is_said(quality):
    """At the distance that is found 90 % of noisy frames fail the test that 1 % of frames of one touch fail."""
    from scipy.stats import chi2

    finger, rng = grid_finger(noise=2e-4), np.random.default_rng(3)
    found = two_point_area(finger, TOUCHES, pairs=12, search=quality.search)
    told = np.flatnonzero(np.isfinite(found.separation))
    assert told.size > 6
    half = 0.5 * found.separation[told, None] * np.stack([np.cos(found.azimuth), np.sin(found.azimuth)], -1)[told]
    inside = np.abs(half)
    middle = np.clip(found.position[told], np.array(BOX)[:, 0] + inside, np.array(BOX)[:, 1] - inside)
    readings = sum(finger.read(ss.PointLoad(force=0.5, position=middle + side * half)) for side in (-1, 1))
    frames = readings + 2e-4 * rng.standard_normal((60, *readings.shape))
    left = finger.locate(frames, search=quality.search, friction=0.5).residual
    assert np.mean(left > chi2.isf(0.01, 16 - 5)) == pytest.approx(0.9, abs=0.05)


def test_free_positions_are_never_worse_and_keep_to_the_room(grid):
    """A grid of six; mirror images move together."""
    n = [layout.text for layout in GOALS.layouts].index("3 x 2 grid")
    row = replace(grid.row(0, 1, 1, 0, n), pitch=4e-3)
    values = {
        name: float(v[0, 0]) for name, v in studied(GOALS, 0, 1, row.depth, np.array([4e-3]), [row.layout], 100).items()
    }
    moved, after = freed(grid, row, values)
    wanted = {c.name: c.wanted for c in grid.criteria if c.name in after}
    assert moved.layout.pattern == "free"
    assert max(after[k] / w for k, w in wanted.items()) < max(values[k] / w for k, w in wanted.items())
    points = moved.layout.points(moved.pitch)
    apart = np.linalg.norm(points[:, None] - points, axis=-1) + np.diag(np.full(6, np.inf))
    assert apart.min() >= GOALS.room.least_pitch * (1 - 1e-3)
    assert (np.abs(points) <= 0.5 * GOALS.extent * (1 + 1e-9)).all()
    for mirror in ((-1, 1), (1, -1)):
        np.testing.assert_allclose(sorted((points * mirror).tolist()), sorted(points.tolist()), atol=2e-5)


@pytest.mark.parametrize("shape", [(3, 3), (4, 2), (1, 5)])
def test_a_grid_is_that_of_an_array(shape):
    grid = Arrangement("grid", shape)
    np.testing.assert_allclose(grid.points(2e-3), ss.SensorArray.grid(shape, 2e-3, depth=2e-3).points, atol=1e-15)
    assert grid.count == shape[0] * shape[1] == len(grid.colours(2))
    with pytest.raises(ss.errors.InvalidValueError, match=r"a grid of \(4, 4, 4\).*Fix: \(4, 3\)"):
        Arrangement("grid", (4, 4, 4))
