"""A finger that is not exactly its drawing: what `locate` says of it, against fingers drawn at random."""

from __future__ import annotations

import os
import subprocess
import sys
from dataclasses import replace

import numpy as np
import pytest

import subskin as ss
from subskin.errors import InvalidValueError
from subskin.estimate.settle.normal import room_of
from subskin.estimate.settle.variants import case_of, lay_out

DEPTH = 3e-3
SKIN = ss.HalfSpace(ss.Material(young=0.4e6))
PEAK = 0.04  # strain that a newton makes


def drawn(told: ss.Tolerances | None, noise: float = 1e-3) -> ss.Finger:
    array = ss.SensorArray.grid(shape=(4, 4), pitch=DEPTH, depth=DEPTH, noise=noise * PEAK)
    return ss.Finger(SKIN, array, tolerances=told)


def touches(rng: np.random.Generator, count: int) -> dict[str, np.ndarray]:
    force, lean, turn = rng.uniform(0.5, 1.5, count), rng.uniform(0, 0.4, count), rng.uniform(-np.pi, np.pi, count)
    drag = force * lean
    components = np.stack([force, drag * np.cos(turn), drag * np.sin(turn)], axis=-1)
    return {"position": rng.uniform(-1.5, 1.5, (count, 2)) * DEPTH, "components": components}


EACH = {
    "gain": ss.Tolerances(gain=0.02),
    "depth": ss.Tolerances(depth=0.05),
    "position": ss.Tolerances(position=0.05),
    "poisson": ss.Tolerances(poisson=0.05),
    "offset": ss.Tolerances(offset=0.01 * PEAK),
    "all": ss.Tolerances(gain=0.02, depth=0.05, position=0.05, poisson=0.05, offset=0.01 * PEAK),
}


def drawn_row(told: ss.Tolerances | None, noise: float = 1e-3) -> ss.Finger:
    array = ss.SensorArray.line(count=8, pitch=0.75 * DEPTH, depth=DEPTH, noise=noise * PEAK)
    return ss.Finger(ss.HalfPlane(ss.Material(young=0.4e6)), array, tolerances=told)


def lines(rng: np.random.Generator, count: int) -> dict[str, np.ndarray]:
    # a load of 160 N/m makes the strain PEAK
    force, angle = rng.uniform(80, 240, count), rng.uniform(-0.5, 0.5, count)
    return {"force": force, "angle": angle, "position": rng.uniform(-2.6, 2.6, count) * DEPTH}


@pytest.mark.parametrize("told", EACH.values(), ids=EACH)
def test_rows_drawn_from_the_tolerances_are_located_within_their_intervals(told: ss.Tolerances) -> None:
    rng, finger = np.random.default_rng(3), drawn_row(told)
    held, ok, wrong, exact = [], [], [], []
    for _ in range(12):
        touch = lines(rng, 40)
        readings = ss.Finger(*told.draw(finger.skin, finger.array, rng)).read(ss.LineLoad(**touch), rng)
        found = finger.locate(readings)
        off = np.abs(found.position - touch["position"])
        std = np.sqrt(np.diagonal(found.load.covariance, axis1=-2, axis2=-1))
        ok.append(found.ok)
        held.append((off < 1.96 * std[:, 0])[found.ok])
        normal = np.abs(found.load.components[:, 0] - touch["force"] * np.cos(touch["angle"]))
        held.append((normal < 1.96 * std[:, 1])[found.ok])
        wrong.append(found.ok & ((off > 5 * std[:, 0]) | (off > 0.3 * DEPTH)))
        exact.append(replace(finger, tolerances=None).locate(readings).ok)
    assert np.mean(np.concatenate(ok)) > 0.95
    assert np.mean(np.concatenate(wrong)) <= 0.01
    assert 0.88 < np.mean(np.concatenate(held)) <= 1.0
    assert np.mean(np.concatenate(exact)) < 0.9  # the noise alone does not explain them


def tips(rng: np.random.Generator, count: int, beside: float) -> tuple[np.ndarray, dict[str, np.ndarray]]:
    """Touches of a tip on a row, or beside it: their y, and what makes them."""
    force, y = rng.uniform(0.5, 1.5, count), rng.uniform(-2.3, 2.3, count) * DEPTH
    drag = force * rng.uniform(-0.4, 0.4, count)
    position = np.stack([y, np.full(count, beside * DEPTH)], axis=-1)
    return y, {"position": position, "components": np.stack([force, drag, np.zeros(count)], axis=-1)}


@pytest.mark.parametrize("beside", [0.0, 0.6])
@pytest.mark.parametrize("told", EACH.values(), ids=EACH)
def test_tips_on_a_row_and_beside_it_are_located_within_their_intervals(told: ss.Tolerances, beside: float) -> None:
    rng, finger = np.random.default_rng(3), replace(drawn_row(told), skin=SKIN)
    ok, wrong, held, exact, away, forces, pressed = [], [], [], [], [], [], []
    for _ in range(12):
        y, touch = tips(rng, 40, beside)
        readings = ss.Finger(*told.draw(SKIN, finger.array, rng)).read(ss.PointLoad(**touch), rng)
        found = finger.locate(readings)
        off = np.abs(found.position - y)
        ok.append(found.ok)
        held.append((off < 1.96 * found.position_std)[found.ok])
        wrong.append(found.ok & ((off > 5 * found.position_std) | (off > 0.3 * DEPTH)))
        exact.append(replace(finger, tolerances=None).locate(readings).ok)
        point = finger.locate(readings, load="point")
        low, high = point.beside_interval.T
        away.append(((low <= beside * DEPTH) & (beside * DEPTH <= high))[point.ok])
        on_row = finger.locate(readings, load="point", beside=0.0)
        if beside == 0.0:
            forces.append((np.abs(on_row.position - y) < 1.96 * np.sqrt(on_row.covariance[:, 0, 0]))[on_row.ok])
            pressed.append(np.abs(on_row.components[:, 0] / touch["components"][:, 0] - 1)[on_row.ok])
    assert np.mean(np.concatenate(ok)) > (0.85 if beside == 0.0 else 0.6)
    assert np.mean(np.concatenate(wrong)) <= 0.01
    assert 0.9 < np.mean(np.concatenate(held)) <= 1.0
    assert np.mean(np.concatenate(away)) > 0.88
    assert np.mean(np.concatenate(exact)) < np.mean(np.concatenate(ok))
    if beside == 0.0:
        assert 0.88 < np.mean(np.concatenate(forces)) <= 1.0
        assert np.median(np.concatenate(pressed)) < 0.1


def test_a_ball_on_a_row_is_said_to_be_one() -> None:
    rng, finger = np.random.default_rng(5), replace(drawn_row(ss.Tolerances()), skin=SKIN)
    y, touch = tips(rng, 200, 0.0)
    found = finger.locate(finger.read(ss.RoundHertz(half_width=0.5 * DEPTH, **touch), rng))
    held = np.abs(found.position - y) < 1.96 * found.position_std
    assert found.ok.mean() > 0.8
    assert 0.9 < held[found.ok].mean() <= 1.0
    sized = found.on_row.half_width[found.likeliest == 1]
    assert np.median(sized) == pytest.approx(0.5 * DEPTH, rel=0.1)


def test_a_ball_beside_a_row_is_not_taken_for_one_on_it() -> None:
    rng, finger = np.random.default_rng(5), replace(drawn_row(ss.Tolerances()), skin=SKIN)
    y, touch = tips(rng, 200, 0.6)
    found = finger.locate(finger.read(ss.RoundHertz(half_width=0.5 * DEPTH, **touch), rng))
    off = np.abs(found.position - y)
    wrong = found.ok & ((off > 5 * found.position_std) | (off > 0.3 * DEPTH))
    assert found.ok.mean() > 0.9
    assert wrong.mean() <= 0.01  # without a size of its own the point beside the row leaves 15 %


def test_a_size_alone_leaves_what_is_known_of_a_point_beside_a_row() -> None:
    rng = np.random.default_rng(8)
    _, touch = tips(rng, 50, 0.6)
    exact, told = (replace(drawn_row(one), skin=SKIN) for one in (None, ss.Tolerances()))
    readings = exact.read(ss.PointLoad(**touch), rng)
    one, other = (finger.locate(readings).point for finger in (exact, told))
    both = one.ok & other.ok & (other.half_width == 0)
    assert both.mean() > 0.7
    assert other.position[both] == pytest.approx(one.position[both], abs=0.02e-3)
    assert np.median(other.std[both, 0] / one.std[both, 0]) < 2.0  # the crest is narrow


def test_the_error_of_a_point_counts_every_distance_that_explains_it() -> None:
    """Without the walk along the crest twice as many positions are more than four deviations off."""
    told, rng = EACH["offset"], np.random.default_rng(3)
    finger, wrong = replace(drawn_row(told), skin=SKIN), []
    for _ in range(12):
        y, touch = tips(rng, 40, 0.6)
        readings = ss.Finger(*told.draw(SKIN, finger.array, rng)).read(ss.PointLoad(**touch), rng)
        found = finger.locate(readings, load="point")
        wrong.append(np.abs(found.position - y) > 4 * found.std[:, 0])
    assert np.mean(wrong) < 0.006


def test_errors_of_positions_across_the_row_count_by_the_slope_there() -> None:
    finger = replace(drawn_row(ss.Tolerances(position=0.05)), skin=SKIN)
    locator = finger.locator("point")
    variants, errors, told, _, _ = locator._prepare(locator._all)[-1]
    room, case = room_of(2, 2, 0, errors.ratios, 8), case_of(variants, errors, told, 2, 8)
    y, z, step = 0.4 * DEPTH, 0.8 * DEPTH, 1e-4 * DEPTH
    room.at[:], room.load[:] = (y, z * z / told.aside), (1.2, 0.3)

    def read(y: float, z: float) -> np.ndarray:
        touch = ss.PointLoad(components=(1.2, 0.3, 0.0), position=(y, z))
        return finger.read(touch) / finger.array.noise

    lay_out(np.zeros(8), case, False, room)
    across = (read(y, z + step) - read(y, z - step)) / (2 * step)
    along = (read(y + step, z) - read(y - step, z)) / (2 * step)
    variance = 1.0 + (0.05 * DEPTH) ** 2 * (across**2 + along**2)
    assert 1 / room.weight == pytest.approx(variance, rel=1e-3)
    assert -room.rest == pytest.approx(read(y, z), rel=1e-4, abs=1e-4 * np.abs(read(y, z)).max())


PLAIN = """
import subskin as ss
array = ss.SensorArray.line(count=6, pitch=2e-3, depth=3e-3, noise=4e-5)
finger = ss.Finger(ss.HalfSpace(ss.Material(young=0.4e6)), array, tolerances=ss.Tolerances({}))
found = finger.locate(finger.read(ss.PointLoad(force=1.0, position=(1e-3, 2e-3))))
print(int(found.status), round(float(found.position) * 1e3, 4), round(float(found.point.beside) * 1e3, 4))
"""


@pytest.mark.parametrize("told", ["", "depth=0.05"])
def test_the_first_frames_in_plain_python_are_those_of_the_compiled_loop(told: str) -> None:
    """Loops are compiled after the first frames. Where Python raises an error, a compiled one has an infinity."""
    every = [
        subprocess.run(
            [sys.executable, "-W", "ignore", "-c", PLAIN.format(told)],
            env=os.environ | {"NUMBA_DISABLE_JIT": off}, capture_output=True, text=True, check=True,
        ).stdout
        for off in "01"
    ]  # fmt: skip
    assert every[0] == every[1]
    assert every[0].startswith("0 1.0 2.0")


def test_few_readings_seldom_take_a_pull_for_a_press_beside_the_row() -> None:
    rng = np.random.default_rng(3)
    array = ss.SensorArray.line(count=6, pitch=0.75 * DEPTH, depth=DEPTH, noise=1e-3 * PEAK)
    finger = ss.Finger(SKIN, array, tolerances=EACH["all"])
    pulled = finger.locate(-finger.read(ss.PointLoad(**tips(rng, 400, 0.0)[1]), rng))
    assert pulled.ok.mean() < 0.06  # .15 where it may press a depth beside the row and farther
    wild = finger.locate(rng.normal(size=(400, 6)) * PEAK)
    assert wild.ok.mean() < 0.04


def test_a_line_that_may_be_two_is_ambiguous() -> None:
    rng, finger = np.random.default_rng(4), drawn_row(EACH["all"])
    touch = lines(rng, 100)
    both = [finger.read(ss.LineLoad(**touch | {"position": touch["position"] + side * DEPTH})) for side in (-0.6, 0.6)]
    found = finger.locate(sum(both) / 2)
    nearer = np.abs(np.abs(found.position - touch["position"]) - 0.6 * DEPTH)
    assert (found.ok & (nearer > 0.3 * DEPTH)).mean() < 0.05
    roller = finger.locate(finger.read(ss.Hertz(half_width=0.5 * DEPTH, **touch), rng))
    assert roller.ok.mean() > 0.95


@pytest.mark.parametrize("told", [None, ss.Tolerances()], ids=["exact", "size"])
def test_the_force_of_a_point_counts_where_else_it_may_press(told: ss.Tolerances | None) -> None:
    rng, finger = np.random.default_rng(6), replace(drawn_row(told, 1e-2), skin=SKIN)
    force, both = [], []
    for beside in np.linspace(0.0, 1.0, 6):
        _, touch = tips(rng, 60, float(beside))
        found = finger.locate(finger.read(ss.PointLoad(**touch), rng))
        point = found.ok & (found.likeliest > 0)
        true = np.linalg.norm(touch["components"], axis=-1)
        force.append((np.abs(found.force - true) < 1.96 * found.std[:, 1])[point])
        both.append((found.std[:, 1] >= np.where(found.likeliest == 1, found.on_row.std[:, 1], 0.0))[point])
    assert np.mean(np.concatenate(force)) > 0.75  # of the likeliest contact alone it was .5
    assert np.concatenate(both).all()


def test_tips_of_a_row_without_errors_are_found_as_by_an_exact_one() -> None:
    rng, none = np.random.default_rng(7), ss.Tolerances()
    for beside in (0.0, 0.7):
        _, touch = tips(rng, 50, beside)
        exact, told = (replace(drawn_row(one), skin=SKIN) for one in (None, none))
        readings = exact.read(ss.PointLoad(**touch), rng)
        one, other = (finger.locate(readings, load="point") for finger in (exact, told))
        both = one.ok & other.ok
        assert both.mean() > 0.7
        assert other.position[both] == pytest.approx(one.position[both], abs=0.05e-3)
        assert other.residual[both] == pytest.approx(one.residual[both], abs=0.1)


def test_a_roller_is_explained_and_said_to_be_one() -> None:
    rng, finger = np.random.default_rng(5), drawn_row(ss.Tolerances())
    touch = lines(rng, 200)
    found = finger.locate(finger.read(ss.Hertz(half_width=0.5 * DEPTH, **touch), rng))
    assert found.ok.mean() > 0.95
    assert np.abs(found.half_width[found.ok] / DEPTH - 0.5).mean() < 0.05
    std = np.sqrt(np.diagonal(found.load.covariance, axis1=-2, axis2=-1))
    inside = np.abs(found.position - touch["position"]) < 1.96 * std[:, 0]
    assert 0.9 < inside[found.ok].mean() < 0.99


def test_a_row_without_errors_answers_as_an_exact_one() -> None:
    rng = np.random.default_rng(7)
    readings = drawn_row(None).read(ss.LineLoad(**lines(rng, 50)), rng)
    exact, told = drawn_row(None).locate(readings), drawn_row(ss.Tolerances()).locate(readings)
    assert told.position == pytest.approx(exact.position, abs=1e-9)
    assert (told.half_width == 0).all()


@pytest.mark.parametrize("told", EACH.values(), ids=EACH)
def test_fingers_drawn_from_the_tolerances_are_located_within_their_intervals(told: ss.Tolerances) -> None:
    rng, finger = np.random.default_rng(3), drawn(told)
    held, ok, wrong, exact = [], [], [], []
    for _ in range(12):
        touch = touches(rng, 40)
        readings = ss.Finger(*told.draw(finger.skin, finger.array, rng)).read(ss.PointLoad(**touch), rng)
        found = finger.locate(readings)
        off = np.abs(found.position - touch["position"])
        std = np.sqrt(np.diagonal(found.load.covariance, axis1=-2, axis2=-1))
        ok.append(found.ok)
        held.append((off < 1.96 * std[:, :2])[found.ok])
        held.append((np.abs(found.load.components - touch["components"])[:, :1] < 1.96 * std[:, 2:3])[found.ok])
        wrong.append(found.ok & ((off > 5 * std[:, :2]).any(axis=-1) | (np.hypot(*off.T) > 0.3 * DEPTH)))
        exact.append(replace(finger, tolerances=None).locate(readings).ok)
    assert np.mean(np.concatenate(ok)) > 0.9
    assert np.mean(np.concatenate(wrong)) <= 0.01
    assert 0.88 < np.mean(np.concatenate([each.reshape(-1) for each in held])) <= 1.0
    assert np.mean(np.concatenate(exact)) < 0.9  # the noise alone does not explain them


def test_a_ball_is_explained_and_said_to_be_one() -> None:
    rng, finger = np.random.default_rng(5), drawn(ss.Tolerances(noise=1.0))
    touch = touches(rng, 200)
    readings = finger.read(ss.RoundHertz(half_width=0.5 * DEPTH, **touch), rng)
    found = finger.locate(readings)
    assert found.ok.mean() > 0.95
    sized = found.ok & (found.half_width > 0)
    assert sized.mean() > 0.8
    assert np.abs(found.half_width[sized] / DEPTH - 0.5).mean() < 0.05
    std = np.sqrt(np.diagonal(found.load.covariance, axis1=-2, axis2=-1))
    inside = np.abs(found.position - touch["position"]) < 1.96 * std[:, :2]
    assert 0.9 < inside[found.ok].mean() < 0.99
    assert not (finger.locate(readings, load="point").status == ss.Status.OK).mean() > 0.3


def test_without_errors_the_answer_is_that_of_an_exact_finger() -> None:
    rng = np.random.default_rng(7)
    readings = drawn(None).read(ss.PointLoad(**touches(rng, 50)), rng)
    exact, told = drawn(None).locate(readings), drawn(ss.Tolerances()).locate(readings)
    assert told.position == pytest.approx(exact.position, abs=1e-9)
    assert (told.half_width == 0).all()
    more = np.diagonal(told.load.covariance - exact.load.covariance, axis1=-2, axis2=-1)
    assert (more > -0.02 * np.diagonal(exact.load.covariance, axis1=-2, axis2=-1)).all()  # a size can only add


@pytest.mark.parametrize("kind", [ss.ShearStrain("xy"), ss.MeanPressure()])
def test_other_sensors_of_a_layer_know_tolerances_too(kind: ss.Transducer) -> None:
    skin = ss.Layered(ss.Layer(ss.Material(young=0.4e6, poisson=0.45), thickness=6e-3))
    array = ss.SensorArray.grid(shape=(4, 4), pitch=DEPTH, depth=DEPTH, transducer=kind, noise=1.0)
    finger = ss.Finger(skin, array)
    scale = np.abs(finger.read(ss.PointLoad(force=1.0, position=(1e-3, 0.0)))).max()
    told = ss.Tolerances(gain=0.02, depth=0.03, poisson=0.03)
    finger = ss.Finger(skin, replace(array, noise=1e-3 * scale), tolerances=told)
    rng = np.random.default_rng(1)
    at = np.array([1e-3, -2e-3])
    found = finger.locate(
        ss.Finger(*told.draw(finger.skin, finger.array, rng)).read(ss.PointLoad(force=1.0, position=at), rng),
        friction=0.5,
    )
    assert ss.Status(found.status) in (ss.Status.OK, ss.Status.AMBIGUOUS)
    assert np.hypot(*(found.position - at)) < 0.3 * DEPTH


def test_what_does_not_count_tolerances_refuses_them() -> None:
    with pytest.raises(InvalidValueError, match="`locate` counts them, of lines"):
        drawn(ss.Tolerances(gain=0.02)).fit(np.zeros(16))
    row = drawn_row(ss.Tolerances(gain=0.02))
    with pytest.raises(InvalidValueError, match="`locate` counts them, of lines"):
        row.fit(np.zeros(8), "hertz")
    with pytest.raises(InvalidValueError, match="16 sensors"):
        drawn(ss.Tolerances(gain=[0.02, 0.03])).locate(np.zeros(16))
    with pytest.raises(InvalidValueError, match="noise"):
        ss.Tolerances(noise=0.5)


def test_one_deviation_of_poissons_ratio_is_held_and_bends_with_the_load() -> None:
    rng, finger = np.random.default_rng(2), drawn(ss.Tolerances(poisson=0.1))
    touch = touches(rng, 300)
    made = ss.Finger(ss.HalfSpace(ss.Material(young=0.4e6, poisson=0.4)), finger.array)
    found = finger.locate(made.read(ss.PointLoad(**touch), rng))
    off = np.abs(found.position - touch["position"]) / np.sqrt(
        np.diagonal(found.load.covariance, axis1=-2, axis2=-1)[:, :2]
    )
    assert found.ok.mean() > 0.98
    assert (off < 1.96).mean() > 0.9
    assert (off > 5).mean() == 0.0  # slopes of the drawing's readings alone make this 1 %


def test_tolerances_of_each_sensor() -> None:
    each = np.linspace(0.0, 0.1, 16)
    told = ss.Tolerances(gain=0.5 * each, depth=each)
    rng, finger = np.random.default_rng(4), drawn(told)
    touch = touches(rng, 100)
    made = ss.Finger(*told.draw(finger.skin, finger.array, rng))
    found = finger.locate(made.read(ss.PointLoad(**touch), rng))
    assert found.ok.mean() > 0.95
    assert (np.hypot(*(found.position - touch["position"]).T)[found.ok] < 0.3 * DEPTH).all()


@pytest.mark.parametrize("what", ["gain", "depth"])
def test_an_error_in_common_is_settled_as_a_search_over_all_unknowns_has_it(what: str) -> None:
    """By an independent route: least squares in position, force and the error, with its prior as one reading more."""
    from scipy.optimize import least_squares

    each = np.where(np.arange(16) % 3 == 0, 0.1, 0.0) if what == "gain" else 0.05
    told = ss.Tolerances(common=1.0, **{what: each})
    finger = drawn(told, noise=1e-2)
    exact, noise = replace(finger, tolerances=None), np.asarray(finger.array.noise)
    changed = {"gain": 1 + each} if what == "gain" else {"depth": DEPTH * (1 + each)}
    off = replace(exact, array=replace(exact.array, **changed))
    rng = np.random.default_rng(8)
    touch = touches(rng, 8)
    readings = exact.read(ss.PointLoad(**touch)) + 1.5 * (
        off.read(ss.PointLoad(**touch)) - exact.read(ss.PointLoad(**touch))
    )
    readings += rng.normal(0, noise, readings.shape)
    found = finger.locate(readings, load="point")
    assert found.ok.sum() > 5

    def rest(x: np.ndarray, frame: np.ndarray) -> np.ndarray:
        load = ss.PointLoad(position=1e-3 * x[:2], components=x[2:5])
        base = exact.read(load)
        return np.append((frame - base - x[5] * (off.read(load) - base)) / noise, x[5])

    for f in np.flatnonzero(found.ok):
        start = np.concatenate([1e3 * touch["position"][f], touch["components"][f], [0.0]])
        best = least_squares(rest, start, args=(readings[f],), xtol=1e-12, ftol=1e-12)
        assert found.residual[f] == pytest.approx(2 * best.cost, rel=0.01, abs=0.05)
        std = np.sqrt(np.diagonal(found.load.covariance[f]))
        assert (np.abs(found.position[f] - 1e-3 * best.x[:2]) < 0.1 * std[:2]).all()
        assert (np.abs(found.load.components[f] - best.x[2:5]) < 0.1 * std[2:]).all()


def test_four_sensors_answer_because_a_rival_pays_for_its_larger_errors() -> None:
    told = ss.Tolerances(gain=0.02, depth=0.05, position=0.05, poisson=0.05, offset=0.01 * PEAK)
    array = ss.SensorArray.line(count=4, pitch=0.75 * DEPTH, depth=DEPTH, noise=1e-3 * PEAK)
    finger, rng, ok = (
        ss.Finger(ss.HalfPlane(ss.Material(young=0.4e6)), array, tolerances=told),
        np.random.default_rng(1),
        [],
    )
    for _ in range(20):
        touch = lines(rng, 40) | {"position": rng.uniform(-1.1, 1.1, 40) * DEPTH}
        ok.append(finger.locate(ss.Finger(*told.draw(finger.skin, array, rng)).read(ss.LineLoad(**touch), rng)).ok)
    assert np.mean(ok) > 0.68  # without the determinant of the errors 0.64


@pytest.mark.parametrize(("best", "deviation"), [(0.3, 0.1), (-0.5, 0.3), (1.4, 0.5), (0.5, 2.0), (-3.0, 0.2)])
def test_the_mean_square_of_what_is_cut_to_a_stretch(best: float, deviation: float) -> None:
    from scipy.stats import truncnorm

    from subskin.estimate.settle.normal import second_moment

    own = truncnorm((0 - best) / deviation, (1 - best) / deviation, loc=best, scale=deviation)
    assert second_moment(best, deviation) == pytest.approx(own.var() + own.mean() ** 2, rel=0.05)
