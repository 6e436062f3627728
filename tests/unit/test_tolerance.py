"""Budgets of tolerances: defaults, what is lost, needed amounts, self-calibration, bad input, the figure."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import subskin as ss
from subskin.design import Touches, tolerance_budget, usual_tolerances
from subskin.design.tolerance import SOURCES, tolerance_outcome
from subskin.errors import GeometryError, InvalidValueError, NotLinearError
from subskin.plot import save, tolerance_figure

FLAT = ss.HalfPlane(ss.Material(0.4e6))
TOUCHES = Touches(20.0, 0.8)
SMALL = {"positions": 8, "angles": 4, "draws": 40}


def finger(skin=FLAT, count=6, noise=5e-5, **more):
    return ss.Finger(skin, ss.SensorArray.line(count, pitch=1.5e-3, depth=2e-3, noise=noise, **more))


def test_usual_tolerances_are_those_of_a_blind_calibration():
    usual = usual_tolerances(finger(resolution=3e-5, noise=[1e-5, 1e-5, 1e-5, 1e-5, 1e-5, 7e-5]))
    assert list(usual) == [name for name in SOURCES if name not in ("thickness", "radius")]
    assert [usual[n] for n in ("position", "depth", "gains")] == pytest.approx([0.02 * 2e-3, 0.05 * 2e-3, 0.05])
    assert usual["resolution"] == pytest.approx(3e-5)
    assert usual["noise"] == pytest.approx(3e-5)  # root mean square
    tip = ss.Round(ss.Material(0.4e6), 8e-3, 4e-3)
    assert usual_tolerances(finger(tip))["radius"] == pytest.approx(0.16e-3)
    assert usual_tolerances(finger(tip))["thickness"] == pytest.approx(0.2e-3)


def test_rows_are_the_same_alone_and_with_others_and_from_a_seed():
    tolerances = {"gains": 0.03, "position": 2e-5}
    both = tolerance_budget(finger(), TOUCHES, tolerances, **SMALL)
    alone = tolerance_budget(finger(), TOUCHES, {"gains": 0.03, "depth": 0}, **SMALL)
    assert [row.source for row in both.rows] == ["position", "gains"]
    assert both.rows[1] == alone.rows[0]
    assert both.rows != tolerance_budget(finger(), TOUCHES, tolerances, **SMALL, rng=1).rows
    assert both.rows == tolerance_budget(finger(), TOUCHES, tolerances, **SMALL, rng=0).rows
    drawn = [
        tolerance_budget(finger(), TOUCHES, tolerances, **SMALL, rng=np.random.default_rng(s)).rows for s in (7, 7, 8)
    ]
    assert drawn[0] == drawn[1] != drawn[2]
    assert both.total.angle_rms == pytest.approx(np.hypot(both.rows[0].angle_rms, both.rows[1].angle_rms))


def test_frames_are_lost_by_the_noise_and_wrong_by_the_source_alone():
    """A load that `locate` calls unexplained is off by as much as one that it takes for explained."""
    quiet, loud = (
        tolerance_budget(finger(noise=n), TOUCHES, {"depth": 2e-4, "gains": 0.05}, **SMALL).rows for n in (1e-6, 4e-4)
    )
    for a, b in zip(quiet, loud, strict=True):
        assert a.lost > 0.99
        assert b.lost == 0.0
        for name in ("position_rms", "angle_rms", "force_rms"):
            assert getattr(a, name) == pytest.approx(getattr(b, name), rel=1e-5), (a.source, name)


def test_an_offset_of_all_readings_changes_nothing():
    a, b = (
        tolerance_budget(f, TOUCHES, {"depth": 2e-4, "gains": 0.05}, **SMALL).rows
        for f in (finger(noise=1e-6), finger(noise=1e-6, offset=[1.0, -2.0, 0.5, 3.0, 0.0, 1.0]))
    )
    for x, y in zip(a, b, strict=True):
        assert x.lost > 0.99
        for name in ("position_rms", "angle_rms", "force_rms", "angle_linear", "angle_worst"):
            assert getattr(x, name) == pytest.approx(getattr(y, name), rel=1e-5), (x.source, name)


def test_small_steps_are_an_even_noise():
    (row,) = tolerance_budget(finger(), TOUCHES, {"resolution": 1e-5}, positions=24, angles=12).rows
    assert row.position_rms == pytest.approx(row.position_linear, rel=0.1)
    assert row.angle_rms == pytest.approx(row.angle_linear, rel=0.1)


def test_a_radius_leaves_the_thickness_as_it_is():
    tip, wider, narrower = (ss.Round(ss.Material(0.4e6), r, r - 4e-3) for r in (8e-3, 8.4e-3, 7.6e-3))
    (row,) = tolerance_budget(finger(tip), TOUCHES, {"radius": 0.4e-3}, **SMALL).rows
    position, angle = TOUCHES.grid(8, 4, finger())
    touch = ss.LineLoad(20.0, angle, position[:, None])
    found = finger(tip, noise=3e-4).locate(np.stack([finger(s).read(touch) for s in (wider, narrower)]), friction=0.8)
    assert row.angle_rms == pytest.approx(np.sqrt(np.mean((found.angle - angle) ** 2)), rel=1e-5)


def test_a_step_rounds_as_the_array_does():
    step = 2e-3
    made = finger(resolution=step, noise=5e-4)
    (row,) = tolerance_budget(made, TOUCHES, {"resolution": step}, positions=8, angles=4).rows
    position, angle = TOUCHES.grid(8, 4, made)
    found = made.locate(made.read(ss.LineLoad(20.0, angle, position[:, None])), friction=0.8)
    assert row.position_rms == pytest.approx(np.sqrt(np.mean((found.position - position[:, None]) ** 2)), rel=1e-9)
    assert row.angle_worst == pytest.approx(np.abs(found.angle - angle).max(), rel=1e-9)
    assert row.lost == pytest.approx((found.status != ss.Status.OK).mean())


def test_the_worst_touch_is_that_of_the_quantile():
    two = [
        tolerance_budget(finger(), TOUCHES, {"gain": 0.05, "gains": 0.01}, **{**SMALL, "draws": 300}, quantile=q).rows
        for q in (0.5, 0.99)
    ]
    # half of a normal distribution lies within 0.674 of its standard deviation, 99 % within 2.576
    assert [rows[0].force_worst for rows in two] == pytest.approx([0.05 * 0.67449, 0.05 * 2.57583], rel=1e-4)
    assert two[1][1].angle_worst / two[0][1].angle_worst == pytest.approx(2.576 / 0.674, rel=0.25)
    assert two[0][1].angle_rms == two[1][1].angle_rms


@pytest.mark.parametrize(("quantile", "of_two"), [(0.6, max), (0.5, min)])
def test_a_share_of_the_draws_is_no_less_than_that_share(quantile, of_two):
    """Of two draws 60 % are both, 50 % the better one; of one touch, at whose errors a and b the rms is known."""
    (row,) = tolerance_budget(
        finger(), TOUCHES, {"gains": 0.05}, positions=1, angles=1, draws=2, quantile=quantile
    ).rows
    for name in ("position", "angle", "force"):
        worst, rms = getattr(row, f"{name}_worst"), getattr(row, f"{name}_rms")
        other = np.sqrt(2 * rms**2 - worst**2)
        assert worst == of_two(worst, other) != other, name


def test_poissons_ratio_goes_the_one_way_that_there_is():
    at_half, below = (
        tolerance_budget(finger(ss.HalfPlane(ss.Material(0.4e6, nu))), TOUCHES, {"poisson": 0.02}, **SMALL).rows[0]
        for nu in (0.5, 0.45)
    )
    assert at_half.angle_linear == pytest.approx(below.angle_linear, rel=0.1)
    off = finger(ss.HalfPlane(ss.Material(0.4e6, 0.48)))
    position, angle = TOUCHES.grid(8, 4, off)
    readings = off.read(ss.LineLoad(20.0, angle, position[:, None]))
    found = finger(noise=4e-4).locate(readings, friction=0.8)
    assert at_half.angle_rms == pytest.approx(np.sqrt(np.mean((found.angle - angle) ** 2)), rel=2e-3)


def test_needed_amounts_are_what_gives_the_accuracy():
    tolerances = {"position": 4e-5, "depth": 1e-4, "young": 0.1, "gains": 0.05, "width": 4e-4, "noise": 5e-5}
    budget = tolerance_budget(finger(), TOUCHES, tolerances, **SMALL)
    wanted = np.radians(0.7)
    needed = budget.needed(angle=wanted)
    assert [row.source for row in needed] == list(tolerances)
    shared = {row.source: row.shared for row in needed if np.isfinite(row.shared)}
    assert set(tolerances) - set(shared) == {"young"}
    again = tolerance_budget(finger(), TOUCHES, shared, **SMALL)
    assert again.total.angle_rms == pytest.approx(wanted, rel=0.03)
    for row in again.rows:
        assert row.angle_rms == pytest.approx(wanted / np.sqrt(len(shared)), rel=0.03), row.source
    (alone,) = (row.alone for row in needed if row.source == "position")
    (row,) = tolerance_budget(finger(), TOUCHES, {"position": alone}, **SMALL).rows
    assert row.angle_rms == pytest.approx(wanted, rel=0.03)


def test_what_is_kept_takes_its_part_first():
    budget = tolerance_budget(finger(), TOUCHES, {"depth": 1e-4, "noise": 5e-5}, **SMALL)
    noise = budget.rows[1].position_rms
    (depth,) = budget.needed(position=2 * noise, keep=["noise"])
    (row,) = tolerance_budget(finger(), TOUCHES, {"depth": depth.alone}, **SMALL).rows
    assert row.position_rms == pytest.approx(np.sqrt(3) * noise, rel=0.03)
    with pytest.raises(InvalidValueError, match="noise alone cost more"):
        budget.needed(position=0.9 * noise, keep=["noise"])
    with pytest.raises(InvalidValueError, match="no accuracy wanted"):
        budget.needed()
    with pytest.raises(InvalidValueError, match="keep = 'gain'"):
        budget.needed(position=1e-4, keep=["gain"])


def test_both_accuracies_are_kept():
    budget = tolerance_budget(finger(), TOUCHES, {"position": 4e-5, "poisson": 0.02}, **SMALL)
    position, poisson = budget.needed(position=3e-5, angle=np.radians(0.5))
    both = tolerance_budget(finger(), TOUCHES, {"position": position.shared, "poisson": poisson.shared}, **SMALL).total
    assert both.position_rms < 1.03 * 3e-5
    assert both.angle_rms < 1.03 * np.radians(0.5)


@pytest.fixture(scope="module")
def recovered():
    return tolerance_budget(
        finger(),
        TOUCHES,
        {"gain": 0.05, "gains": 0.05, "radius": 0.0, "noise": 5e-5},
        positions=8,
        angles=4,
        draws=20,
        self_calibration=("blind", "known"),
        calibration_draws=2,
        calibration_touches=150,
        calibration_presses=40,
    )


def test_self_calibration_wins_back_gains_and_blind_not_the_one_they_share(recovered):
    gain, gains, every = recovered.recovered
    assert [r.source for r in recovered.recovered] == ["gain", "gains", "together"]
    assert gains.known.angle_rms < 0.2 * gains.drawn.angle_rms
    assert gains.blind.angle_rms < 0.3 * gains.drawn.angle_rms
    assert gain.known.force_rms < 0.1 * gain.drawn.force_rms
    assert gain.blind.force_rms == pytest.approx(gain.drawn.force_rms, rel=0.1)
    assert every.known.angle_rms < 0.3 * every.drawn.angle_rms
    assert every.failed == (("known", 0), ("blind", 0))


def test_what_is_drawn_of_calibrated_fingers_is_the_row(recovered):
    gain, row = recovered.recovered[0].drawn, recovered.rows[0]
    assert gain.force_rms == pytest.approx(row.force_rms, rel=1e-9)


def test_fingers_to_be_calibrated_are_off_to_either_side_in_turn():
    budget = tolerance_budget(
        finger(), TOUCHES, {"young": 0.1}, **SMALL, self_calibration={"known": ("gain",)}, calibration_draws=2
    )
    assert budget.recovered[0].drawn.force_rms == pytest.approx(budget.rows[0].force_rms, rel=1e-9)


def test_calibrating_fits_what_it_is_told_to():
    budget = tolerance_budget(
        finger(), TOUCHES, {"poisson": 0.05}, **SMALL,
        self_calibration={"known": ("poisson",)}, calibration_draws=1,
    )  # fmt: skip
    other = tolerance_budget(
        finger(), TOUCHES, {"poisson": 0.05}, **SMALL,
        self_calibration={"known": ("gain",)}, calibration_draws=1,
    )  # fmt: skip
    assert budget.recovered[0].known.angle_rms < 0.05 * budget.recovered[0].drawn.angle_rms
    assert other.recovered[0].known.angle_rms > 0.5 * other.recovered[0].drawn.angle_rms
    assert budget.recovered[0].blind is None


def test_a_calibration_that_fails_leaves_the_finger_as_drawn():
    few = finger(count=3)
    (gains, _) = tolerance_budget(
        few, TOUCHES, {"gains": 0.05}, **SMALL, self_calibration="blind", calibration_draws=2
    ).recovered
    assert gains.failed == (("blind", 2),)
    assert gains.blind.angle_rms == gains.drawn.angle_rms


def test_normal_touches_have_no_angle():
    (row,) = tolerance_budget(finger(), Touches(20.0, 0.0), {"gains": 0.02}, **SMALL).rows
    assert row.angle_rms == 0.0
    assert row.angle_linear == 0.0
    assert row.position_rms == pytest.approx(row.position_linear, rel=0.25)


def test_sensors_that_are_linear_to_first_order_and_dead_ones():
    exact = finger(transducer=ss.VolumeResistance(exact=True))
    plain = finger(transducer=ss.VolumeResistance())
    a, b = (tolerance_budget(f, TOUCHES, {"depth": 1e-5}, **SMALL).rows[0] for f in (exact, plain))
    assert a.position_linear == pytest.approx(b.position_linear, rel=0.05)
    dead = finger(gain=[1, 1, 0, 1, 1, 1])
    (row,) = tolerance_budget(dead, TOUCHES, {"gains": 1e-3}, **SMALL).rows
    without = replace(dead, array=dead.array.select([0, 1, 3, 4, 5]))
    (other,) = tolerance_budget(without, TOUCHES, {"gains": 1e-3}, **SMALL).rows
    assert row.angle_linear == pytest.approx(other.angle_linear, rel=1e-6)


def test_three_sensors_have_no_first_order_where_they_are_singular():
    three = finger(count=3)
    budget = tolerance_budget(three, TOUCHES, {"position": 1e-6, "young": 0.1}, positions=9, angles=5, draws=20)
    position, young = budget.rows
    assert position.position_linear == np.inf  # a normal load above the middle sensor
    assert np.isfinite(position.position_rms)
    assert young.force_linear == np.inf


@pytest.mark.parametrize(
    ("change", "error", "message"),
    [
        ({"tolerances": {"deepness": 1e-4}}, InvalidValueError, "deepness"),
        ({"tolerances": {"depth": -1e-4}}, InvalidValueError, "depth"),
        ({"tolerances": {"depth": 0.0}}, InvalidValueError, "no tolerance"),
        ({"tolerances": ["depth"]}, InvalidValueError, "a Mapping"),
        ({"tolerances": {"radius": 1e-4}}, InvalidValueError, "radius of a HalfPlane"),
        ({"tolerances": {"thickness": 1e-4}}, InvalidValueError, "thickness of a HalfPlane"),
        ({"tolerances": {"poisson": 0.6}}, InvalidValueError, "no such finger"),
        ({"draws": 0}, InvalidValueError, "draws"),
        ({"quantile": 1.0}, InvalidValueError, "quantile"),
        ({"rng": -1}, InvalidValueError, "rng"),
        ({"self_calibration": "daily"}, InvalidValueError, "daily"),
        ({"touches": Touches(20.0, 0.8, (-20e-3, 20e-3))}, GeometryError, "a narrower span"),
        ({"finger": finger(noise=0.0)}, InvalidValueError, "noise"),
        ({"finger": finger(count=2)}, InvalidValueError, "2 sensors"),
        ({"finger": finger(transducer=ss.EnergyDensity())}, NotLinearError, "EnergyDensity"),
    ],
)
def test_bad_input_is_refused(change, error, message):
    given = {"finger": finger(), "touches": TOUCHES, "tolerances": {"depth": 1e-4}, **SMALL} | change
    with pytest.raises(error, match=message):
        tolerance_budget(given.pop("finger"), given.pop("touches"), given.pop("tolerances"), **given)


def test_a_layer_of_several_materials_has_poissons_ratios_but_no_one_thickness():
    two = ss.Layered([ss.Layer(ss.Material(0.4e6, 0.45), 3e-3), ss.Layer(ss.Material(1e6, 0.45), 2e-3)])
    usual = usual_tolerances(finger(two))
    assert "poisson" in usual
    assert "thickness" not in usual
    (row,) = tolerance_budget(finger(two), TOUCHES, {"young": 0.1}, **SMALL).rows
    assert row.angle_rms < 1e-6
    with pytest.raises(InvalidValueError, match="thickness"):
        tolerance_budget(finger(two), TOUCHES, {"thickness": 1e-4}, **SMALL)


def test_progress_is_told_of_every_row_and_calibration():
    told = []
    tolerance_budget(
        finger(), TOUCHES, {"gains": 0.02, "noise": 5e-5}, **SMALL,
        self_calibration="known", calibration_draws=2, progress=lambda: told.append(1),
    )  # fmt: skip
    assert len(told) == 2 + 1 + 2 * 2


def test_the_figure_has_labels_bars_and_the_wanted_lines(recovered, tmp_path):
    figure = tolerance_figure(recovered, position=1e-4, angle=np.radians(2))
    left, right = figure.axes
    assert (left.get_xlabel(), right.get_xlabel()) == ("error of position [mm]", "error of angle [deg]")
    names = [text.get_text() for text in left.get_yticklabels()]
    assert names[:3] == ["gain of all, 5 %", "each sensor's gain, 5 %", "noise, 5e-05"]
    bars = [bar.get_width() for bar in right.patches]
    expected = [np.degrees(row.angle_rms) for row in (*recovered.rows, recovered.total, recovered.together)]
    assert bars == pytest.approx(expected)
    assert any(np.allclose(line.get_xdata(), 0.1) for line in left.lines)
    assert any(np.allclose(line.get_xdata(), 2.0) for line in right.lines)
    labels = {text.get_text() for text in figure.legends[0].get_texts()}
    assert labels == {"rms", "worst touch", "calibrated at known positions", "calibrated blind", "wanted"}
    assert save(figure, tmp_path / "t.svg")[0].stat().st_size > 10_000
    with pytest.raises(InvalidValueError, match="position"):
        tolerance_figure(recovered, position=0.0)


def test_what_95_percent_of_the_touches_keep_is_a_quantile_of_the_sum_at_each():
    """Against fingers drawn and located: the standard deviation at each touch, and its quantile over the touches."""
    touches = Touches(force=20.0, friction=0.5, span=(-3e-3, 3e-3))
    skin = ss.HalfPlane(ss.Material(young=0.4e6))
    finger = ss.Finger(skin, ss.SensorArray.line(count=6, pitch=1.5e-3, depth=1.5e-3, noise=2e-4))
    budget = tolerance_budget(finger, touches, {"position": 0.02e-3, "noise": 2e-4}, positions=9, angles=5)
    position, angle = touches.grid(9, 5)
    load = ss.LineLoad(20.0, angle, position[:, None])
    rng = np.random.default_rng(5)
    errors = []
    for _ in range(600):
        y = np.asarray(finger.array.y) + 0.02e-3 * rng.standard_normal(6)
        made = ss.Finger(skin, ss.SensorArray(y=y, depth=1.5e-3, noise=2e-4))
        found = finger.locate(made.read(load, rng), friction=0.5, false_alarm=1e-30)
        errors.append([found.position - load.position, found.angle - load.angle])
    at_each = np.sqrt((np.array(errors) ** 2).mean(axis=0))
    expected = np.quantile(at_each, 0.95, axis=(1, 2), method="higher")
    np.testing.assert_allclose(budget.kept(0.95)[:2], expected, rtol=0.08)
    alone = np.array([budget.kept(0.95, [name])[:2] for name in ("position", "noise")])
    assert (np.array(budget.kept(0.95)[:2]) > alone.max(axis=0)).all()


def test_touches_keep_only_what_is_in_the_budget():
    skin = ss.HalfPlane(ss.Material(young=0.4e6))
    finger = ss.Finger(skin, ss.SensorArray.line(count=6, pitch=1.5e-3, depth=1.5e-3, noise=1e-4))
    budget = tolerance_budget(finger, Touches(force=20.0), {"position": 0.03e-3}, positions=4, angles=3, draws=4)
    with pytest.raises(InvalidValueError, match="the budget has position"):
        budget.kept(0.95, ["noise"])
    with pytest.raises(InvalidValueError, match="share = 0"):
        budget.kept(0.0)


@pytest.mark.parametrize("method", ["known", "blind"])
def test_what_calibration_leaves_to_first_order_is_what_it_leaves(method):
    """Against fingers that are drawn, calibrated and located one by one."""
    array = ss.SensorArray.line(6, pitch=1.6e-3, depth=2e-3, noise=5e-5)
    finger, touches = ss.Finger(ss.HalfPlane(ss.Material(young=0.4e6)), array), Touches(20.0, 0.8)
    amounts = {"position": 5e-5, "gains": 0.05, "noise": 5e-5}
    how = {"positions": 12, "angles": 6}
    budget = tolerance_budget(finger, touches, amounts, self_calibration=method, calibration_draws=2, draws=2, **how)
    real = getattr(budget.recovered[-1], method)
    found = tolerance_outcome(finger, touches, amounts, method=method, draws=50, share=0.6827, **how)
    assert found.calibrated.lost < 0.01
    assert real.lost == 0
    for name in ("position", "angle", "force"):
        assert getattr(found.calibrated, name) == pytest.approx(getattr(real, f"{name}_rms"), rel=0.7), name
        assert getattr(found.calibrated, name) < 0.5 * getattr(found.as_made, name) or (method, name) == (
            "blind",
            "force",
        )


def test_a_calibration_knows_what_it_cannot_fit():
    """Wider sensors than drawn: no fit has them, so they cost what they cost, and the finger says it has more noise."""
    array = ss.SensorArray.line(6, pitch=1.6e-3, depth=2e-3, noise=5e-6)
    finger, touches = ss.Finger(ss.HalfPlane(ss.Material(young=0.4e6)), array), Touches(20.0, 0.8)
    wide = tolerance_outcome(finger, touches, {"width": 1e-3, "noise": 5e-6}, draws=10)
    fitted = tolerance_outcome(finger, touches, {"gains": 0.01, "noise": 5e-6}, draws=10)
    assert wide.as_made.lost > 0.5
    assert wide.calibrated.lost < 0.1
    assert wide.calibrated.position > 20 * fitted.calibrated.position


def on_area():
    grid = ss.SensorArray.grid((4, 4), 3e-3, 3e-3, transducer=ss.MeanPressure(), noise=20.0)
    return ss.Finger(ss.HalfSpace(ss.Material(young=0.4e6)), grid)


def test_a_blind_calibration_on_an_area_does_not_see_what_all_share():
    """Where all sensors are, and the gain of all, no touch of unknown force and position tells."""
    touches = Touches(1.0, 0.5, area=((-4e-3, 4e-3), (-4e-3, 4e-3)))
    how = {"positions": 9, "angles": 4, "draws": 20, "share": 0.6827}
    gains, moved = (
        tolerance_outcome(on_area(), touches, amounts, method="blind", **how)
        for amounts in ({"gains": 0.05, "noise": 20.0}, {"position": 6e-5, "noise": 20.0})
    )
    assert gains.presses == 200
    assert gains.calibrated.force == pytest.approx(0.05 / 4, rel=0.4)  # of the mean of 16 gains
    assert gains.calibrated.angle < 0.05 * gains.as_made.angle
    assert moved.calibrated.position == pytest.approx(6e-5 / 4, rel=0.4)
    assert moved.calibrated.angle < 0.1 * moved.as_made.angle


@pytest.mark.long
def test_what_a_blind_calibration_leaves_on_an_area_to_first_order_is_what_it_leaves():
    """Against fingers that are drawn, calibrated by points and located by balls, one by one."""
    touches = Touches(1.0, 0.5, area=((-4e-3, 4e-3), (-4e-3, 4e-3)), half_width=1e-3)
    amounts, how = {"gains": 0.05, "noise": 20.0}, {"positions": 9, "angles": 4}
    blind = {"self_calibration": "blind", "calibration_draws": 3, "calibration_touches": 200}
    real = tolerance_budget(on_area(), touches, amounts, draws=1, **blind, **how).recovered[-1].blind
    found = tolerance_outcome(on_area(), touches, amounts, method="blind", draws=20, share=0.6827, **how)
    assert real.lost == 0
    assert found.calibrated.lost < 0.01
    for name in ("position", "angle", "force", "radius"):
        assert getattr(found.calibrated, name) == pytest.approx(getattr(real, f"{name}_rms"), rel=0.7), name
