"""From goals to fingers: the grid against what its parts say, resuming, ranking, reasons."""

from dataclasses import replace

import numpy as np
import pytest

import subskin as ss
from subskin.design import Goals, Touches, placement_quality, rank_fingers, search_grid
from subskin.design.finger_table import finger_table
from subskin.design.placement import Arrangement
from subskin.design.search import (
    Accuracy,
    Check,
    Criterion,
    DesignGrid,
    DesignStudy,
    Effort,
    Room,
    Row,
    SensorKind,
    SkinChoice,
    look,
)
from subskin.design.search import grid as grid_module
from subskin.design.search.rank import remedies
from subskin.design.words import held, in_words, reasons_of, tolerances_of, usual_goals_of, verdict_of
from subskin.errors import ConvergenceError, GeometryError, InvalidValueError, NotLinearError

SKIN = ss.HalfPlane(ss.Material(young=0.4e6))
GOALS = Goals(
    touches=Touches(force=20.0, friction=0.5, span=(-3e-3, 3e-3)),
    strongest=100.0,
    accuracy=Accuracy(position=0.1e-3, angle=0.06),
    sensors=(
        SensorKind("gauge", ss.NormalStrain(), 2e-4),
        SensorKind("pressure", ss.MeanPressure(), 30.0, largest=2e4),
    ),
    skins=(SkinChoice("silicone", SKIN),),
    room=Room(count=(4, 6), depth=(1.5e-3, 3e-3), least_pitch=1e-3, longest_row=8e-3),
    tolerances={},
    effort=Effort(depths=3, pitches=4, touches=1000, keep=2),
)


class Memory(dict):
    """A store that counts what it is asked for."""

    found = 0

    def get(self, key):
        self.found += key in self
        return super().get(key)

    def put(self, key, row):
        self[key] = row


@pytest.fixture(scope="module")
def store():
    return Memory()


@pytest.fixture(scope="module")
def grid(store):
    return search_grid(GOALS, store=store, workers=1)


@pytest.fixture(scope="module")
def study(grid):
    return rank_fingers(grid)


def test_the_grid_covers_the_room_and_no_more(grid):
    assert grid.excess.shape == (1, 2, 3, 4, 3)
    np.testing.assert_allclose(grid.depths[0, [0, -1]], [1.5e-3, 3e-3], rtol=1e-12)
    np.testing.assert_allclose(grid.pitches[[0, -1]], [1e-3, 8e-3 / 3], rtol=1e-12)
    lengths = grid.pitches[:, None] * (grid.counts - 1)
    outside = lengths > 8e-3 * (1 + 1e-9)
    assert outside.any()
    assert np.isnan(grid.excess[..., outside]).all()
    assert not np.isnan(grid.excess[..., ~outside]).any()


def test_a_design_of_the_grid_is_what_its_finger_can_do(grid):
    finger = GOALS.finger(Row(0, 0, Arrangement("row", (5,)), float(grid.depths[0, 1]), float(grid.pitches[1])))
    quality = placement_quality(finger, GOALS.touches, grid=(101, 41))
    for name in ("position_95", "angle_95", "force_95", "position_mean", "log_det"):
        np.testing.assert_allclose(grid.values[name][0, 0, 1, 1, 1], quality.values[name], rtol=1e-5)


def test_strain_and_range_under_the_strongest_force():
    touches, room = replace(GOALS.touches, friction=0.0), replace(GOALS.room, count=(4, 4))
    goals = replace(GOALS, touches=touches, room=room, effort=replace(GOALS.effort, touches=100))
    grid = search_grid(goals)
    # straight beneath a normal line load at nu = 1/2, plane strain: eps_x = -3 P / (2 pi E x), a principal strain
    beneath = 3 * 100.0 / (2 * np.pi * 0.4e6 * grid.depths[0])
    np.testing.assert_allclose(grid.values["strain"][0, 0, :, 0, 0], beneath, rtol=1e-6)
    # mean pressure there is (sx + sy + sz)/3 = (1 + nu)(sx + sy)/3 = -P / (pi x)
    np.testing.assert_allclose(grid.values["range"][0, 1, :, 0, 0], 100 / (np.pi * grid.depths[0] * 2e4), rtol=1e-6)
    assert (grid.values["range"][0, 0] == 0).all()


def test_the_excess_is_the_worst_ratio(grid):
    at = (0, 1, 2, 1, 1)
    ratios = [
        grid.values["position_95"][at] / 0.1e-3,
        grid.values["angle_95"][at] / 0.06,
        (grid.values["ambiguous"][at] + grid.values["unfelt"][at]) / 0.01,
        grid.values["strain"][at] / 0.1,
        grid.values["range"][at],
    ]
    assert grid.excess[at] == max(ratios)


def test_the_number_of_workers_changes_nothing(grid):
    other = search_grid(GOALS, workers=3)
    for name, values in grid.values.items():
        np.testing.assert_array_equal(values, other.values[name], err_msg=name)


def test_another_seed_other_touches(grid):
    other = search_grid(replace(GOALS, sensors=GOALS.sensors[:1], effort=replace(GOALS.effort, seed=1)))
    assert (grid.values["ambiguous"][:, :1] != other.values["ambiguous"]).any()
    np.testing.assert_array_equal(grid.values["position_95"][:, :1], other.values["position_95"])


def test_finished_rows_are_not_worked_out_again(grid, store, monkeypatch):
    monkeypatch.setattr(grid_module, "study_at_depth", lambda *a, **k: pytest.fail("worked out again"))
    before = store.found
    again = search_grid(GOALS, store=store)
    assert store.found - before == len(store) == 6
    np.testing.assert_array_equal(again.excess, grid.excess)
    # other accuracy, other largest strain: the rows still hold
    search_grid(replace(GOALS, accuracy=Accuracy(angle=0.01), largest_strain=0.01), store=store)


@pytest.mark.parametrize(
    "change",
    [
        {"touches": replace(GOALS.touches, friction=0.6)},
        {"effort": replace(GOALS.effort, touches=500)},
        {"room": replace(GOALS.room, least_pitch=1.1e-3)},
        {"skins": (SkinChoice("silicone", ss.HalfPlane(ss.Material(young=0.41e6))),)},
        {"sensors": (SensorKind("gauge", ss.NormalStrain(), 2e-4, width=1e-4),)},
    ],
)
def test_rows_of_another_question_are_not_taken(store, change, grid, monkeypatch):
    monkeypatch.setattr(grid_module, "study_at_depth", lambda *a, **k: next(iter(store.values())))
    own = Memory(store)
    search_grid(replace(GOALS, **change), store=own)
    assert own.found == 0
    assert len(own) > len(store)  # and are kept beside them


def test_a_search_that_is_stopped_keeps_what_is_finished():
    own, seen = Memory(), []

    def stop():
        seen.append(1)
        if len(seen) == 2:
            raise KeyboardInterrupt

    small = replace(GOALS, effort=replace(GOALS.effort, pitches=2, touches=100))
    with pytest.raises(KeyboardInterrupt):
        search_grid(small, store=own, workers=1, progress=stop)
    assert 2 <= len(own) < 6
    np.testing.assert_array_equal(search_grid(small, store=own).excess, search_grid(small).excess)
    assert own.found >= 2


def test_fingers_are_ranked_and_refined(grid, study):
    met = [f.meets for f in study.fingers]
    assert met == sorted(met, reverse=True)
    assert met[0]
    counts = [f.row.count for f in study.fingers if f.meets]
    assert counts == sorted(counts)
    assert len({(f.row.skin, f.row.sensor, f.row.count) for f in study.fingers}) == len(study.fingers) == 2
    for finger in study.fingers:
        row = finger.row
        n = row.count - 4
        coarse = np.nanmin(grid.excess[row.skin, row.sensor, :, :, n])
        assert finger.excess <= 1.02 * coarse  # as good as the grid, but for what rounding costs
        assert row.length <= 8e-3 * (1 + 1e-9)
        assert 1.5e-3 * (1 - 1e-9) <= row.depth <= 3e-3 * (1 + 1e-9)
        assert row.pitch >= 1e-3 * (1 - 1e-9)
        for length in (row.depth, row.pitch):  # can be put on a drawing: a multiple of 0.05 mm
            assert abs(length / 0.05e-3 - round(length / 0.05e-3)) < 1e-6
        assert finger.values["position_95"] == pytest.approx(finger.quality.values["position_95"], rel=0.01)


def test_halving_the_counts_finds_the_fewest_sensors(grid, study):
    """Against a close look at every count; the neighbours of the fewest are looked at too."""
    for kind in (0, 1):
        own = {n: all(c.ratio <= 1 for c in checks) for (_, m, n), checks in study.looked.items() if m == kind}
        others = {n: look.looked_at(grid, (0, kind, n)).meets for n in range(3) if n not in own}
        every = own | others
        fewest = min(n for n in every if every[n])
        assert min(n for n in own if own[n]) == fewest
        assert {n for n in (fewest - 1, fewest, fewest + 1) if 0 <= n < 3} <= set(own)


@pytest.mark.long
def test_the_number_of_workers_does_not_change_the_ranking():
    room, effort = replace(GOALS.room, count=(5, 5)), replace(GOALS.effort, depths=2, pitches=3, touches=200)
    grid = search_grid(replace(GOALS, room=room, effort=effort))
    one, many = (rank_fingers(grid, workers=n).fingers for n in (1, 3))
    assert len(one) == 2
    assert [f.row for f in one] == [f.row for f in many]
    assert [f.point for f in one] == [f.point for f in many]


def test_what_is_promised_is_what_locate_does(study):
    finger = study.fingers[0].finger
    touches = GOALS.touches.sample(20_000, np.random.default_rng(3))
    found = finger.locate(
        finger.read(touches, np.random.default_rng(4)), friction=0.5, search=study.fingers[0].quality.search
    )
    sure = found.status == ss.Status.OK
    assert 1 - sure.mean() < 0.01 + 0.003
    off = np.abs(found.position - touches.position)[sure]
    # 95 % of the touches have a standard error of at most position_95: of these at most 5 % are off by twice that
    assert np.mean(off > 2 * study.fingers[0].values["position_95"]) < 0.05
    mean_square = np.mean((study.fingers[0].quality.std["position"]) ** 2)
    assert np.mean(off**2) == pytest.approx(mean_square, rel=0.1)


@pytest.fixture(scope="module")
def off():
    """One kind and count, sensors out of place: judged as made, and after a calibration."""
    one = replace(
        GOALS,
        sensors=(SensorKind("gauge", ss.NormalStrain(), 1e-4),),
        room=Room(count=(5, 5), depth=(2e-3, 2e-3), least_pitch=1.5e-3, longest_row=6e-3),
        tolerances={"position": 0.1e-3, "depth": 0.1e-3, "thickness": 1e-4},
        effort=Effort(depths=1, pitches=1, touches=500, keep=1),
    )
    grid = search_grid(one)
    judged = [replace(GOALS.accuracy, calibrated=kind, blind_spots=0.9) for kind in ("none", "known")]
    return [rank_fingers(replace(grid, goals=replace(one, accuracy=accuracy))) for accuracy in judged]


def test_tolerances_count_against_the_goals(off, study):
    made = off[0].fingers[0]
    assert [cost.source for cost in made.budget.rows] == ["position", "depth", "noise"]  # a half plane has no thickness
    check = next(check for check in made.checks if check.criterion.name == "position_95")
    assert check.value == pytest.approx(made.budget.kept(0.95)[0], rel=0.02)
    assert check.value > 1.1 * made.values["position_95"]
    assert study.fingers[0].budget is study.fingers[0].outcome is None


def test_touches_that_tolerances_lose_are_unsure(off):
    """As a stranger would find it: fingers made off, their touches located by the finger as drawn and as calibrated."""
    finger, rng = off[1].fingers[0].finger, np.random.default_rng(5)
    before, after = [], []
    for draw in range(40):
        y, depth = (1e-4 * rng.standard_normal(size) for size in (5, 1))
        array = replace(finger.array, y=finger.array.y + y, depth=finger.array.depth + depth)
        made, touch = replace(finger, array=array), GOALS.touches.sample(200, rng)
        readings = made.read(touch, rng=rng)
        before.append(finger.locate(readings, friction=0.5).status != ss.Status.OK)
        if draw < 2:
            at = np.linspace(-3e-3, 3e-3, 60)
            presses = made.read(ss.LineLoad(20.0, 0.0, at), rng=rng)
            own = ss.calibrate(finger, presses, at, fit=("position", "depth"), force=20.0, origin=0.0).finger
            after.append(own.locate(readings, friction=0.5).status != ss.Status.OK)
    as_made, known = off
    for found in off:
        lost = {c.criterion.name: c.value for c in found.fingers[0].as_made}["unsure"]
        assert lost == pytest.approx(np.mean(before), abs=0.1)
        assert 0.2 < lost < 1
    assert not as_made.fingers[0].meets
    assert known.fingers[0].meets
    assert np.mean(after) < 0.01
    assert {c.criterion.name: c.value for c in known.fingers[0].checks}["unsure"] < 0.01


def test_the_verdict_says_which_finger_meets_the_goals(off):
    as_made, known = (verdict_of(found) for found in off)
    lost = next(c for c in off[1].fingers[0].as_made if c.criterion.name == "unsure").value
    assert known.startswith(
        "It meets every goal once it is calibrated on 60 touches at known positions. As made it misses"
    )
    assert f"not noticed or lost {in_words(lost, '')} (at most 1 % wanted)" in known
    assert as_made.startswith("As made it misses")
    assert as_made.endswith("It would meet every goal calibrated on 60 touches at known positions.")
    columns, rows, _ = finger_table(off[1])
    cells = dict(zip(columns, rows[0], strict=True))
    assert cells["goals"] == "calibrated"
    assert cells["as made"] == in_words(lost, "")
    columns, rows, _ = finger_table(off[0])
    assert dict(zip(columns, rows[0], strict=True))["goals"].endswith(" x")
    assert tolerances_of(off[1]).startswith("The tolerances that were stated are counted")


def test_blind_spots_are_a_goal_where_they_are_asked_for(off):
    best = off[1].fingers[0]
    check = next(c for c in best.checks if c.criterion.name == "blind_spots")
    assert check.value == best.unopposed.wrong > 0
    strict = replace(off[1].goals, accuracy=replace(GOALS.accuracy, blind_spots=0.5 * check.value))
    found = rank_fingers(replace(off[1].grid, goals=strict))
    assert not found.fingers[0].meets
    assert "touches outside the model" in verdict_of(found)


def test_without_a_goal_for_blind_spots_the_usual_one_is_taken_and_named(off):
    """With 1 there is none: no check, and the report's table alone."""
    accuracy, grid = replace(GOALS.accuracy, blind_spots=None), off[1].grid
    judged, silent = (
        rank_fingers(replace(grid, goals=replace(off[1].goals, tolerances={}, accuracy=each)))
        for each in (accuracy, replace(accuracy, blind_spots=1.0))
    )
    checks = {check.criterion.name: check.criterion.wanted for check in judged.fingers[0].checks}
    assert checks["blind_spots"] == 0.2
    assert "at most 20 % of each kind" in usual_goals_of(judged)
    assert "blind_spots" not in [check.criterion.name for check in silent.fingers[0].checks]
    assert silent.fingers[0].unopposed is not None
    assert usual_goals_of(silent) == usual_goals_of(off[1]) == ""


def test_without_tolerances_the_usual_ones_are_counted_and_named(off):
    usual = rank_fingers(replace(off[1].grid, goals=replace(off[1].goals, tolerances=None)))
    amounts = ss.design.usual_tolerances(usual.fingers[0].finger)
    del amounts["noise"]
    assert {k: v for k, v in usual.fingers[0].outcome.amounts.items() if k != "noise"} == amounts
    said = tolerances_of(usual)
    assert said.startswith("No tolerances were stated. The usual ones are counted")
    assert "depth of all 0.1 mm" in said
    assert "Poisson's ratio 0.02" in said


def test_what_would_do_where_nothing_does(off):
    """Each change by itself, made to the goals and searched again: then a design of the grid meets them."""
    barometer = (SensorKind("pressure", ss.MeanPressure(), noise=20.0),)  # reads as much in a stiffer skin
    goals = replace(off[1].goals, strongest=400.0, accuracy=Accuracy(position=0.1e-3), tolerances={}, sensors=barometer)
    goals = replace(goals, room=replace(goals.room, count=(4, 4)), effort=replace(goals.effort, pitches=3))
    grid = search_grid(goals)
    assert np.nanmin(grid.excess) > 1
    found = {remedy.what: remedy for remedy in remedies(grid)}
    # straight beneath a line load the strain is 3 P / (2 pi E x), whatever its angle
    assert found["borne"].value == pytest.approx(0.1 * 2 * np.pi * 0.4e6 * 2e-3 / 3, rel=1e-6)
    assert np.isnan(found["count"].value)  # more sensors bear no more
    young, depth = found["young"].value, found["depth"].value
    changed = []
    if np.isfinite(young):
        changed.append(replace(goals, skins=(SkinChoice("stiff", ss.HalfPlane(ss.Material(0.4e6 * young))),)))
    if np.isfinite(depth):
        changed.append(replace(goals, room=replace(goals.room, depth=(depth, depth))))
    assert changed  # one of the two would do
    assert all(np.nanmin(search_grid(one).excess) <= 1 for one in changed)
    weaker = replace(goals, strongest=max(found["force"].value, 20.0))
    assert (np.nanmin(search_grid(weaker).excess) <= 1 + 1e-9) == np.isfinite(found["force"].value)


def test_a_feature_counts_against_the_goals(study, grid, store):
    assert not [c for c in study.fingers[0].checks if c.criterion.name == "feature"]
    accuracy, effort = replace(GOALS.accuracy, feature=0.2e-3), replace(GOALS.effort, keep=1)
    fine = replace(GOALS, accuracy=accuracy, effort=effort, sensors=GOALS.sensors[:1])
    found = rank_fingers(search_grid(fine, store=store))
    finger = found.fingers[0]
    check = next(c for c in finger.checks if c.criterion.name == "feature")
    assert check.value == finger.point
    assert not finger.meets
    assert "distance that two touches need" in reasons_of(found, finger.row)[0]


def test_reasons_are_about_what_was_tried(study):
    finger = study.fingers[0]
    reasons = reasons_of(study, finger.row)
    tightest = max(finger.checks, key=lambda c: c.ratio)
    assert tightest.criterion.label in reasons[0]
    assert in_words(tightest.value, tightest.criterion.unit) in reasons[0]
    depth = next(r for r in reasons if r.startswith("Depth"))
    assert in_words(finger.row.depth, "m") in depth
    other = GOALS.sensors[1 - finger.row.sensor].name
    assert any(f'sensor "{other}"' in reason for reason in reasons)


@pytest.mark.parametrize(
    ("errors", "said"),
    [  # errors of the position [mm] at depths of 1, 1.5, ... 4 mm, where 0.1 mm is wanted; 2.5 mm was chosen
        (
            [0.30, 0.12, 0.08, 0.05, 0.10, 0.13, 0.40],
            (
                "anything from 2 mm to 3 mm would do, with a pitch that suits it; "
                "shallower, error 0.12 mm; deeper, error 0.13 mm."
            ),
        ),
        (
            [0.08, 0.08, 0.11, 0.05, 0.11, 0.08, 0.08],
            (
                "none of its neighbours on the grid would do, with a pitch that suits it; "
                "shallower, error 0.11 mm; deeper, error 0.11 mm."
            ),
        ),
        (
            [0.30, 0.165, 0.155, 0.15, 0.153, 0.14, 0.16],
            (
                "anything from 2.5 mm to 3.5 mm would be within 10 % of the best, with a pitch that suits it; "
                "shallower, error 0.155 mm; deeper, error 0.16 mm."
            ),
        ),
    ],
)
def test_how_far_a_depth_may_be_changed(errors, said):
    """All depths beside the chosen one that keep the goals, or within 10 % of the best where none does; and no more."""
    wanted = Criterion("position_95", "error", "m", 0.1e-3)
    values = 1e-3 * np.array(errors).reshape(1, 1, 7, 1, 1)
    grid = DesignGrid(
        goals=replace(GOALS, sensors=GOALS.sensors[:1]),
        depths=1e-3 * np.arange(1.0, 4.5, 0.5)[None],
        pitches=np.array([1e-3]),
        counts=np.array([4]),
        values={"position_95": values, "log_det": np.zeros_like(values)},
        criteria=(wanted,),
    )
    row = Row(0, 0, Arrangement("row", (4,)), 2.5e-3, 1e-3)
    study = DesignStudy(grid, (), {(0, 0, 0): (Check(wanted, 1e-3 * errors[3]),)})
    reasons = reasons_of(study, row)
    assert f"Depth 2.5 mm: for noise alone {said}" in reasons


def small(span, **more):
    """Goals of five sensors at one depth."""
    room = Room((5, 5), (2e-3, 2e-3), 0.5e-3, **more)
    choice = {"touches": Touches(20.0, 0.5, span), "accuracy": Accuracy(position=1e-6), "sensors": GOALS.sensors[:1]}
    return replace(GOALS, **choice, room=room, effort=Effort(1, 8, touches=500))


def test_a_row_stands_about_the_middle_of_its_span():
    here, there = (rank_fingers(search_grid(small((a - 3e-3, a + 3e-3)))).fingers[0] for a in (0.0, 7e-3))
    np.testing.assert_allclose(there.finger.array.y, np.asarray(here.finger.array.y) + 7e-3, rtol=1e-12)
    assert there.quality["position_95"] == pytest.approx(here.quality["position_95"], rel=1e-6)
    assert there.quality["position_95"] == pytest.approx(there.values["position_95"], rel=0.05)


def test_sensors_of_a_row_at_free_positions_are_no_worse():
    goals = small((-4e-3, 4e-3), layouts=("row", "free"))
    goals = replace(goals, touches=Touches(40.0, span=(-4e-3, 4e-3)), effort=Effort(1, 20, touches=500))
    free, even = rank_fingers(search_grid(goals)).fingers
    assert (free.row.layout.text, even.row.layout.text) == ("5 free", "row of 5")
    assert 0.9 < free.excess / even.excess < 1
    y = np.asarray(free.finger.array.y)
    np.testing.assert_allclose(y, -y[::-1], atol=1e-12)
    assert np.diff(y).min() >= goals.room.least_pitch * (1 - 1e-9)
    found = placement_quality(free.finger, goals.touches)
    assert found["position_95"] == pytest.approx(free.values["position_95"], rel=0.05)


def test_table_and_columns(study, grid):
    columns, rows, left = finger_table(study)
    assert all(len(row) == len(columns) for row in rows)
    assert columns[:left] == ["", "goals", "sensor"]  # there was no choice of skins
    table = grid.columns()
    sizes = {len(values) for values in table.values()}
    assert sizes == {int(np.isfinite(grid.excess).sum())}
    assert "two" not in columns


def test_no_room_at_all():
    with pytest.raises(GeometryError, match="longest_row"):
        Room(count=(4, 6), depth=(1e-3, 2e-3), least_pitch=3e-3, longest_row=8e-3)
    thin = ss.Layered(ss.Layer(ss.Material(young=0.4e6), 1e-3))
    with pytest.raises(GeometryError, match=r'"thin" is 0\.001 m thick'):
        search_grid(replace(GOALS, skins=(SkinChoice("thin", thin),)))
    wide = SensorKind("wide", ss.NormalStrain(), 2e-4, width=9e-3)
    with pytest.raises(ConvergenceError, match="no row has room"):
        rank_fingers(search_grid(replace(GOALS, sensors=(wide,))))


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (Accuracy, "no accuracy is wanted"),
        (lambda: Accuracy(position=-1.0), "position = -1"),
        (lambda: Accuracy(position=1e-3, unsure=0.0), "unsure = 0"),
        (lambda: Effort(depths=0), "depths = 0"),
        (lambda: Effort(touches=10.5), "touches = 10.5"),
        (lambda: Room((3, 2), (1e-3, 2e-3), 1e-3), "count"),
        (lambda: Room((3, 4), (2e-3, 1e-3), 1e-3), "depth"),
        (lambda: Room((3, 4), (2e-3, 1e305), 1e-3), "at most 1e"),
        (lambda: Room((3, 4), (2e-3, 10.0), 1e-3), "deepest <= 1000 times the shallowest"),
        (lambda: Room((3, np.nan), (1e-3, 2e-3), 1e-3), r"count = \[3, nan\]: two whole numbers"),
        (lambda: Room(None, (1e-3, 2e-3), 1e-3), "count = None: two ascending numbers"),
        (lambda: SensorKind("x", ss.NormalStrain(), 0.0), "noise = 0"),
        (lambda: SensorKind("x", ss.NormalStrain(), 1e-4, largest=0.0), "largest = 0"),
        (lambda: SensorKind("x", "strain", 1e-4), "a Transducer is needed"),
        (lambda: replace(GOALS, strongest=1.0), "at least the weakest force"),
        (lambda: replace(GOALS, sensors=()), "one at least is needed"),
        (lambda: replace(GOALS, largest_strain=0.0), "largest_strain = 0"),
        (lambda: replace(GOALS, touches=Touches(20.0)), "without a span"),
    ],
)
def test_bad_goals_are_refused(make, words):
    with pytest.raises((InvalidValueError, GeometryError), match=words):
        make()


def test_sensors_that_are_not_linear_are_refused():
    with pytest.raises(NotLinearError):
        SensorKind("energy", ss.EnergyDensity(), 1.0)


def test_words():
    assert in_words(0.0, "m") == "0 mm"
    assert in_words(4e-7, "m") == "< 0.001 mm"
    assert in_words(5e-5, "") == "< 0.01 %"
    assert in_words(np.inf, "rad") == "without bound"
    assert in_words(12.0, "N/m") == "12 N/m"
    assert held("5 of 12 mm") == "5 of 12\xa0mm"
