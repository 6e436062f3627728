"""Tolerances and blind spots on an area, against fingers that are off and located one by one; the verdict."""

from dataclasses import replace

import numpy as np
import pytest

import subskin as ss
from subskin.calibration.known import explained, fitted
from subskin.design import Goals, Touches, rank_fingers, search_grid, tolerance_budget, usual_tolerances
from subskin.design.finger_table import finger_table
from subskin.design.outside import Scene, outside_of
from subskin.design.search import Accuracy, Effort, Mix, Room, SensorKind, SkinChoice
from subskin.design.search.look import looked_at
from subskin.design.tolerance import tolerance_outcome
from subskin.design.words import in_words, tolerances_of, verdict_of
from subskin.errors import GeometryError

SKIN = ss.HalfSpace(ss.Material(young=1e6, poisson=0.45))
BOX, WIDER = ((-4e-3, 4e-3), (-3e-3, 3e-3)), ((-6e-3, 6e-3), (-6e-3, 6e-3))
TOUCHES = Touches(force=1.0, friction=0.5, area=BOX)
SMALL = {"positions": 6, "angles": 3}


def pad(kind=None, noise=20.0, skin=SKIN, shape=(4, 4), **more):
    kind = kind or ss.MeanPressure()
    return ss.Finger(skin, ss.SensorArray.grid(shape, pitch=3e-3, depth=3e-3, transducer=kind, noise=noise, **more))


def direction(parts):
    return parts / np.linalg.norm(parts, axis=-1, keepdims=True)


def errors(finger, readings, position, load, touches=TOUCHES, family="point", **options):
    """Distance, angle between directions and share of the force that the finger as drawn is off by; which are OK."""
    found = finger.fit(readings, family, friction=touches.friction, search=WIDER, **options)
    off = np.linalg.norm(found.position - position[:, None], axis=-1)
    true = direction(load)
    angle = 2 * np.arcsin(0.5 * np.linalg.norm(direction(found.components) - true, axis=-1))
    return off, angle, np.linalg.norm(found.components, axis=-1) / touches.force - 1, found


@pytest.mark.parametrize(
    ("source", "amount", "change"),
    [
        ("depth", 2e-5, lambda a, s: {"depth": np.asarray(a.depth) + s}),
        ("gain", 0.03, lambda a, s: {"gain": np.asarray(a.gain) * (1 + s)}),
        ("young", 0.05, lambda a, s: {}),
        ("poisson", 0.02, lambda a, s: {}),
    ],
)
def test_what_is_off_of_the_finger_costs_what_locating_its_readings_shows(source, amount, change):
    finger = pad(ss.NormalStrain(), noise=2e-4)
    row = tolerance_budget(finger, TOUCHES, {source: amount}, **SMALL, search=WIDER).rows[0]
    position, load = TOUCHES.loads(6, 3)
    every = []
    for sign in (1, -1):
        material = finger.skin.material
        if source == "young":
            material = replace(material, young=1e6 * (1 + sign * amount))
        if source == "poisson":
            material = replace(material, poisson=0.45 + sign * amount)
        array = replace(finger.array, **change(finger.array, sign * amount))
        made = ss.Finger(ss.HalfSpace(material), array)
        readings = made.read(ss.PointLoad(components=load, position=position[:, None]))
        off, angle, force, found = errors(finger, readings, position, load)
        assert (found.status != ss.Status.UNEXPLAINED).all()
        every.append([off, angle, force])
    expected = np.sqrt((np.array(every) ** 2).mean(axis=(0, 2, 3)))
    got = [row.position_rms, row.angle_rms, row.force_rms]
    np.testing.assert_allclose(got, expected, rtol=1e-6, atol=1e-9, equal_nan=False)


def test_to_first_order_sensors_are_moved_one_at_a_time_along_both_axes():
    finger = pad(noise=20.0)
    amount = 1e-7
    row = tolerance_budget(finger, TOUCHES, {"position": amount}, **SMALL, draws=1, search=WIDER).rows[0]
    position, load = TOUCHES.loads(6, 3)
    total = np.zeros(3)
    for name in ("y", "z"):
        for i in range(len(finger.array)):
            values = np.array(getattr(finger.array, name))
            values[i] += amount
            made = replace(finger, array=replace(finger.array, **{name: values}))
            readings = made.read(ss.PointLoad(components=load, position=position[:, None]))
            total += (np.array(errors(finger, readings, position, load)[:3]) ** 2).mean(axis=(1, 2))
    got = [row.position_linear, row.angle_linear, row.force_linear]
    np.testing.assert_allclose(got, np.sqrt(total), rtol=5e-3, equal_nan=False)


def test_noise_to_first_order_is_the_covariance_of_what_is_found():
    finger = pad()
    budget = tolerance_budget(finger, TOUCHES, {"noise": 20.0}, **SMALL, search=WIDER)
    position, load = TOUCHES.loads(6, 3)
    found = errors(finger, finger.read(ss.PointLoad(components=load, position=position[:, None])), position, load)[-1]
    square = found.load.covariance
    trace = square[..., 0, 0] + square[..., 1, 1]
    assert budget.rows[0].position_linear == pytest.approx(np.sqrt(trace.mean()), rel=1e-3)
    assert budget.rows[0].position_rms == pytest.approx(np.sqrt(trace.mean()), rel=0.1)
    worst = np.sqrt(np.linalg.eigvalsh(square[..., :2, :2])[..., -1])
    assert budget.kept(0.95)[0] == pytest.approx(np.quantile(worst, 0.95, method="higher"), rel=1e-3)


def test_the_radius_of_a_round_touch_is_off_as_fitting_it_shows():
    finger, touches = pad(), replace(TOUCHES, half_width=1.5e-3)
    row = tolerance_budget(finger, touches, {"depth": 3e-5}, **SMALL, search=WIDER).rows[0]
    position, load = touches.loads(6, 3)
    off = []
    for sign in (1, -1):
        made = replace(finger, array=replace(finger.array, depth=3e-3 + sign * 3e-5))
        readings = made.read(ss.RoundHertz(components=load, position=position[:, None], half_width=1.5e-3))
        *_, found = errors(finger, readings, position, load, touches, "round_hertz", moment=False)
        off.append(found.half_width - 1.5e-3)
    assert row.radius_rms == pytest.approx(np.sqrt(np.mean(np.square(off))), rel=1e-5)
    assert row.radius_linear == pytest.approx(row.radius_rms, rel=0.05)
    assert np.isnan(tolerance_budget(finger, TOUCHES, {"depth": 3e-5}, **SMALL, search=WIDER).rows[0].radius_rms)


def test_what_is_lost_as_made_is_what_locating_drawn_fingers_loses():
    """Another draw of fingers, made by hand."""
    finger, amounts = pad(noise=100.0), {"position": 6e-5, "gains": 0.05, "noise": 100.0}
    outcome = tolerance_outcome(finger, TOUCHES, amounts, search=WIDER, rng=1)
    rng, lost = np.random.default_rng(8), []
    touch = TOUCHES.sample(60, rng)
    for _ in range(60):
        array, n = finger.array, len(finger.array)
        moved = {"y": np.asarray(array.y) + 6e-5 * rng.standard_normal(n), "z": array.z + 6e-5 * rng.standard_normal(n)}
        made = replace(finger, array=replace(array, gain=1 + 0.05 * rng.standard_normal(n), **moved))
        found = finger.locate(made.read(touch, rng), friction=0.5, search=WIDER)
        lost.append((found.status != ss.Status.OK).mean())
    assert 0.05 < np.mean(lost) < 0.95
    assert outcome.as_made.lost == pytest.approx(np.mean(lost), abs=0.12)
    assert outcome.calibrated.lost < 0.01 * outcome.as_made.lost + 0.01


def test_what_a_calibration_leaves_is_what_calibrating_fingers_leaves():
    """Fingers calibrated one by one on noisy presses. A width is not fitted, and what is fitted bends to it."""
    finger = pad(noise=50.0, shape=(3, 3))
    amounts = {"depth": 1e-4, "gains": 0.04, "offset": 50.0, "width": 1.2e-3, "noise": 50.0}
    outcome = tolerance_outcome(finger, TOUCHES, amounts, search=WIDER)
    assert outcome.presses == 63
    rng, off = np.random.default_rng(2), []
    position, load = TOUCHES.loads(36, 6)
    presses = TOUCHES.presses(64)
    for _ in range(4):
        each = {"gain": 1 + 0.04 * rng.standard_normal(9), "offset": 50.0 * rng.standard_normal(9), "width": 1.2e-3}
        array = replace(finger.array, depth=3e-3 + 1e-4 * rng.standard_normal(), **each)
        made = replace(finger, array=array)
        readings = made.read(ss.PointLoad(force=1.0, position=presses), rng)
        fit = {"fit": ("gain", "offset", "depth"), "force": 1.0, "origin": (0.0, 0.0)}
        found = explained(fitted(finger, readings, presses, **fit)).finger
        touch = made.read(ss.PointLoad(components=load, position=position[:, None]))
        off.append(errors(found, touch, position, load)[0])
    rms = np.quantile(np.sqrt(np.mean(np.square(off), axis=0)), 0.95)  # of both directions: a little more than of one
    assert outcome.calibrated.position == pytest.approx(rms, rel=0.3)
    assert outcome.as_made.position > 3 * outcome.calibrated.position


def test_what_does_not_belong_together_is_refused():
    with pytest.raises(GeometryError, match="sensors on an area"):
        tolerance_budget(pad(), Touches(20.0, span=(-1e-3, 1e-3)), {"depth": 1e-5})
    row = ss.Finger(SKIN, ss.SensorArray.line(8, 2e-3, 2e-3, noise=1e-4))
    with pytest.raises(GeometryError, match="sensors in a row"):
        tolerance_budget(row, TOUCHES, {"depth": 1e-5})
    with pytest.raises(GeometryError, match="sensors in a row"):
        row.blind_spots(TOUCHES)
    with pytest.raises(GeometryError, match="a narrower area"):
        tolerance_budget(pad(), replace(TOUCHES, area=((-9e-3, 9e-3), BOX[1])), {"depth": 1e-5}, search=WIDER)


@pytest.fixture(scope="module")
def drawn():
    """Readings of each kind, of a finger whose noise is next to nothing, so that they can be taken apart."""
    finger = pad(noise=1e-9)
    kinds = {o.name: o.draw(Scene(finger, TOUCHES, 40, np.random.default_rng(3))) for o in outside_of(TOUCHES)}
    return finger, kinds


@pytest.mark.parametrize("name", ["touch", "two", "two_weak", "drag", "beyond_cone", "pull", "beyond_area"])
def test_loads_are_those_of_the_row_of_the_table(drawn, name):
    """The forces of points at the known positions that fit each frame, of which the rows say what they are."""
    finger, kinds = drawn
    one, loads = kinds[name], []
    for frame, at in zip(one.readings, one.positions, strict=True):
        fields = np.concatenate(list(finger.receptive_field(at)), axis=-1)
        found, *_ = np.linalg.lstsq(fields, frame, rcond=None)
        np.testing.assert_allclose(fields @ found, frame, atol=1e-6 * np.abs(frame).max(), equal_nan=False)
        loads.append(found.reshape(-1, 3))
    loads = np.array(loads)
    normal, drag = loads[..., 0], np.linalg.norm(loads[..., 1:], axis=-1)
    np.testing.assert_allclose(normal.sum(axis=1), one.normal, atol=1e-5, equal_nan=False)
    box, at = np.array(BOX), one.positions
    inside = ((at >= box[:, 0]) & (at <= box[:, 1])).all()
    beyond = (np.abs(at[:, 0]).max(axis=-1) - 4.5e-3) / 3e-3
    assert {
        "touch": inside and (drag <= 0.5 * normal + 1e-6).all(),
        "two": normal.shape[1] == 2 and (normal > 0.2).all(),
        "two_weak": normal.shape[1] == 2 and (normal.min(axis=1) < 0.3).all() and (normal > 0).all(),
        "drag": np.abs(normal).max() < 1e-5 and np.allclose(drag, 1.0, rtol=1e-4),
        "beyond_cone": (normal > 0).all() and (drag > 1.19 * 0.5 * normal).all(),
        "pull": (normal < 0).all(),
        "beyond_area": (beyond > 1.6).all() and (beyond < 4).all(),
    }[name]
    if name.startswith("two"):
        gap = np.linalg.norm(np.diff(at, axis=1), axis=-1) / 3e-3
        assert gap.min() > 0.5
        assert gap.max() < 3
        assert len(np.unique(np.sign(np.diff(at, axis=1)[:, 0]), axis=0)) == 4  # in all directions


def test_a_flat_of_points_that_is_not_tilted_is_the_flat():
    """And tilted it presses as its resultant does far away: force, and moment about the middle."""
    from subskin.design.outside import _disc

    points, weights = _disc(np.array([1.5e-3]))
    finger = pad()
    parts = ss.PointLoad(components=weights[:, None] * [1.0, 0.3, 0.0], position=points[:, 0] + [1e-3, 0.0])
    disc = ss.RoundPunch(components=(1.0, 0.3, 0.0), position=(1e-3, 0.0), half_width=1.5e-3)
    np.testing.assert_allclose(finger.read(parts).sum(axis=0), finger.read(disc), rtol=1e-3, equal_nan=False)
    tilted = weights * (1 + points[:, 0, 0] / 1.5e-3)
    assert (tilted > 0).all()
    # a third of the radius: one edge carries nothing
    assert tilted @ points[:, 0, 0] == pytest.approx(0.5e-3, rel=1e-6)


def test_shares_are_counts():
    finger = pad(shape=(3, 3), noise=50.0)
    passed = finger.blind_spots(TOUCHES, count=200, rng=5, search=WIDER)
    kinds = outside_of(TOUCHES)
    i = [o.name for o in kinds].index("two_weak")
    one = kinds[i].draw(Scene(finger, TOUCHES, 200, np.random.default_rng([i, 5])))
    found = finger.locate(one.readings, friction=0.5, search=WIDER)
    ok = found.status == ss.Status.OK
    off = np.linalg.norm(found.position[:, None] - one.positions, axis=-1).min(axis=1)
    square = np.where(ok[:, None, None], found.load.covariance, 0.0)[:, :2, :2]
    std = np.sqrt(np.linalg.eigvalsh(square)[:, -1])
    row = passed["two_weak"]
    assert row.wrong > 0.05
    assert row.ok == ok.mean()
    assert row.wrong == (ok & ((off > 0.9e-3) | (off > 5 * std))).mean()
    assert row.unexplained == (found.status == ss.Status.UNEXPLAINED).mean()
    assert passed["touch"].ok > 0.95
    assert passed["touch"].wrong < 0.01
    assert (passed.sensors, passed.spare, passed.family) == (9, 4, "point")
    assert passed.wrong > pad(noise=50.0).blind_spots(TOUCHES, count=200, rng=5, search=WIDER).wrong


def test_a_fit_of_balls_leaves_balls_out():
    found = pad().blind_spots(replace(TOUCHES, half_width=1e-3), count=20)
    assert found.family == "round_hertz"
    assert found.spare == 10
    names = {row.name for row in found.rows}
    assert "wide_ball" not in names
    assert {"wide_disc", "edge", "touch"} <= names
    assert not {"line", "wide_roller", "beside"} & names


GOALS = Goals(
    touches=TOUCHES,
    strongest=2.0,
    accuracy=Accuracy(position=0.15e-3, force=0.1),
    sensors=(SensorKind("pressure", ss.MeanPressure(), 20.0),),
    skins=(SkinChoice("thick", SKIN),),
    room=Room(count=(9, 9), depth=(3e-3, 3e-3), least_pitch=3e-3, area=(25e-3, 14e-3), layouts=("row", "grid")),
    largest_strain=0.3,
    effort=Effort(depths=1, pitches=1, touches=100, keep=3),
)
GRID = [layout.pattern for layout in GOALS.layouts].index("grid")


@pytest.fixture(scope="module")
def study():
    return rank_fingers(search_grid(GOALS))


def test_the_verdict_counts_the_usual_tolerances_and_says_so(study):
    best = study.fingers[0]
    assert best.meets
    verdict = verdict_of(study)
    assert verdict.startswith("It meets every goal once it is calibrated on 63 touches at known positions. As made it")
    assert max(check.ratio for check in best.as_made) > 1 >= max(check.ratio for check in best.calibrated)
    said = tolerances_of(study)
    assert said.startswith("No tolerances were stated. The usual ones are counted")
    usual = usual_tolerances(best.finger)
    assert f"each sensor's position {1e3 * usual['position']:.3g} mm" in said
    assert set(best.outcome.amounts) == set(usual)
    assert best.unopposed.spare == best.row.count - 5
    assert {row.source for row in best.budget.rows} == set(usual)
    columns, rows, _ = finger_table(study)
    assert rows[0][columns.index("goals")] == "calibrated"
    assert rows[0][columns.index("as made")] == in_words(best.outcome.as_made.lost, "")


def test_what_a_finger_does_is_noise_and_tolerances_together(study):
    best = study.fingers[0]
    for checks, left in ((best.as_made, best.outcome.as_made), (best.calibrated, best.outcome.calibrated)):
        value = {check.criterion.name: check.value for check in checks}
        assert value["position_95"] == pytest.approx(np.hypot(best.values["position_95"], left.position))
        assert value["unsure"] == max(best.values["unsure"], left.lost)


def test_a_row_that_would_tell_the_touch_meets_nothing():
    """Three magnets in a row tell all unknowns, and `locate` takes touches of sensors in a row for lines."""
    axes = tuple(SensorKind(axis, ss.transducer.Displacement(axis), 1e-6) for axis in "xyz")
    room = replace(GOALS.room, layouts=("row",))
    goals = replace(GOALS, sensors=axes, mixes=(Mix("magnets", axes),), room=room, accuracy=Accuracy(position=1e-3))
    finger = looked_at(search_grid(goals), (0, 3, 0))
    assert finger.row.layout.text == "row of 3"
    assert finger.values["position_95"] < 1e-3
    assert not finger.meets
    assert finger.outcome is None
    assert {check.criterion.name: check.value for check in finger.checks}["unsure"] == 1


def test_the_verdict_changes_when_a_goal_is_tightened(study):
    """To what noise alone would meet and tolerances do not; to the finger as made; to blind spots."""
    best, grid = study.fingers[0], study.grid
    left = next(c.value for c in best.calibrated if c.criterion.name == "position_95")
    noise = best.values["position_95"]
    assert left > noise
    between = replace(GOALS, accuracy=Accuracy(position=np.sqrt(left * noise), force=0.1))
    assert not looked_at(search_grid(between), (0, 0, GRID)).meets
    assert looked_at(search_grid(replace(between, tolerances={})), (0, 0, GRID)).meets
    made = replace(grid, goals=replace(GOALS, accuracy=replace(GOALS.accuracy, calibrated="none")))
    assert not looked_at(made, (0, 0, GRID)).meets
    for most, meets in ((0.9, True), (1e-3, False)):
        wanted = replace(GOALS.accuracy, blind_spots=most)
        asked = replace(grid, goals=replace(GOALS, accuracy=wanted, tolerances={"depth": 1e-5}))
        finger = looked_at(asked, (0, 0, GRID))
        assert finger.meets == meets
        assert finger.checks[-1].value == finger.unopposed.wrong


def test_tolerances_that_are_stated_are_those_that_count():
    goals = replace(GOALS, tolerances={"depth": 1e-5, "thickness": 1e-3})
    finger = looked_at(search_grid(goals), (0, 0, GRID))
    assert dict(finger.outcome.amounts) == {"depth": 1e-5, "noise": pytest.approx(20.0)}
    assert finger.meets
    assert all(check.ratio <= 1 for check in finger.as_made)
