"""What the decision of a kind says, and what it does with bad input, odd frames and stated priors."""

from dataclasses import replace

import numpy as np
import pytest

import subskin as ss
from subskin.decide import UNDECIDED, Kind, contact_type, usual_kinds

FULL_SCALE = 3 / (2 * np.pi)


def finger(count=6, pitch=0.5, noise=1e-3, **options):
    array = ss.SensorArray.line(count, pitch=pitch, depth=1.0, noise=noise * FULL_SCALE, **options)
    return ss.Finger(ss.HalfPlane(ss.Material(young=1.0)), array)


TIP = finger()
TOUCHES = {
    "line": ss.LineLoad(1.0, 0.2, 0.3),
    "vertex": ss.Wedge(1.0, 0.2, 0.3, half_width=0.3),
    "flat side": ss.FlatPunch(1.0, 0.2, 0.3, half_width=0.8),
    "round side": ss.Hertz(1.0, 0.2, 0.3, half_width=0.8),
}
NAMED = (
    Kind("line", "line"),
    Kind("vertex", "wedge", (0.1, 0.35)),
    Kind("flat side", "punch", (0.5, 1.2)),
    Kind("round side", "hertz", (0.5, 1.2)),
)


def frames(tip=TIP):
    return np.stack([tip.read(touch) for touch in TOUCHES.values()])


def test_names_the_contact():
    said = contact_type(TIP, frames(), NAMED)
    assert said.names == tuple(TOUCHES)
    assert said.name.tolist() == list(TOUCHES)
    assert said.status.tolist() == [ss.Status.OK] * 4
    np.testing.assert_allclose(said.probability.sum(axis=-1), 1, rtol=1e-12)
    assert (np.diagonal(said.probability) > 0.95).all()
    np.testing.assert_allclose(said.position, 0.3, atol=2e-4)
    np.testing.assert_allclose(said.angle, 0.2, atol=2e-3)
    np.testing.assert_allclose(said.half_width, [0, 0.3, 0.8, 0.8], atol=2e-3)
    assert (said.residual < 1e-3).all()


def test_the_batch_has_the_shape_of_the_readings():
    readings = frames().reshape(2, 2, 6)
    said = contact_type(TIP, readings, NAMED)
    assert (said.shape, said.name.shape, said.probability.shape) == ((2, 2), (2, 2), (2, 2, 4))
    alone = contact_type(TIP, readings[1, 0], NAMED)
    assert (alone.shape, str(alone.name)) == ((), "flat side")
    np.testing.assert_array_equal(alone.probability, said.probability[1, 0])


def test_odds_are_the_prior_s_times_the_evidence_s():
    tip = finger(4, noise=1e-2)
    readings = tip.read(TOUCHES["vertex"])
    even = (Kind("line", "line"), Kind("vertex", "wedge", (0.1, 0.35)))
    odd = (Kind("line", "line", prior=9.0), Kind("vertex", "wedge", (0.1, 0.35), prior=3.0))
    one, two = contact_type(tip, readings, even), contact_type(tip, readings, odd)
    assert 0.01 < one.probability[0] < 0.99
    ratio = [s.probability[0] / s.probability[1] for s in (one, two)]
    assert ratio[1] / ratio[0] == pytest.approx(3.0, rel=1e-9)
    np.testing.assert_array_equal(one.log_evidence, two.log_evidence)


def test_a_wider_range_of_widths_costs_what_it_adds():
    """Occam's factor: widths that the readings rule out thin the prior where they are."""
    readings = TIP.read(TOUCHES["round side"])
    narrow, wide = Kind("narrow", "hertz", (0.7, 0.9)), Kind("wide", "hertz", (0.4, 1.4))
    said = contact_type(TIP, readings, (narrow, wide))
    assert said.log_evidence[0] - said.log_evidence[1] == pytest.approx(np.log(5.0), abs=1e-6)


def test_cannot_tell_with_four_sensors_and_a_free_width():
    """Four unknowns, four readings: several kinds explain them, and the answer is that they cannot tell."""
    tip = finger(4)
    kinds = tuple(Kind(n, n, (0.02, 1.2)) for n in ("wedge", "punch", "hertz"))
    touches = [ss.Hertz(1.0, a, y, half_width=0.5) for a, y in ((0.0, 0.2), (0.3, -0.4), (-0.4, 0.1), (0.1, 0.6))]
    said = contact_type(tip, [tip.read(t) for t in touches], kinds)
    assert said.decision.tolist() == [UNDECIDED] * 4
    assert said.name.tolist() == ["cannot tell"] * 4
    assert said.status.tolist() == [ss.Status.AMBIGUOUS] * 4
    assert (said.best != UNDECIDED).all()
    assert (said.residual < 1e-3).all()
    more = finger(6, noise=1e-4)
    six = contact_type(more, [more.read(t) for t in touches], kinds)
    assert six.name.tolist() == ["hertz"] * 4


def test_sure_sets_where_a_kind_is_decided_for():
    tip = finger(4, noise=1e-2)
    readings = tip.read(TOUCHES["vertex"])
    kinds = (Kind("line", "line"), Kind("vertex", "wedge", (0.1, 0.35)))
    top = contact_type(tip, readings, kinds).probability.max()
    assert contact_type(tip, readings, kinds, sure=top - 1e-9).decision != UNDECIDED
    assert contact_type(tip, readings, kinds, sure=top + 1e-9).decision == UNDECIDED


def test_odd_frames_get_a_status_and_no_kind():
    good = TIP.read(TOUCHES["round side"])
    one_out, three_out, nothing = good.copy(), good.copy(), np.zeros(6)
    one_out[2] = np.nan
    three_out[:3] = np.nan
    nonsense = np.array([1.0, -1.0, 1.0, -1.0, 1.0, -1.0])
    said = contact_type(TIP, [good, one_out, three_out, nothing, nonsense, np.full(6, np.inf)])
    expected = ["OK", "OK", "INCOMPLETE", "NO_CONTACT", "UNEXPLAINED", "INCOMPLETE"]
    assert [ss.Status(s).name for s in said.status] == expected
    words = ["round side", "round side", "incomplete", "no contact", "unexplained", "incomplete"]
    assert said.name.tolist() == words
    assert (said.best[2:] == UNDECIDED).all()
    for values in (said.probability[:, 0], said.position, said.force, said.half_width):
        assert np.isnan(values[2:]).all()
        assert np.isfinite(values[:2]).all()
    np.testing.assert_array_equal(said.used[1], [True, True, False, True, True, True])


@pytest.mark.parametrize("family", [ss.Hertz, "strip"])
def test_families_of_one_s_own(family):
    touch = (ss.Strip if family == "strip" else family)(1.0, 0.1, -0.2, half_width=0.9)
    kinds = (Kind("point", "line"), Kind("mine", family, (0.5, 1.2)))
    assert str(contact_type(TIP, TIP.read(touch), kinds).name) == "mine"


def test_gain_and_offset_are_taken_off():
    tip = finger(gain=[1, -2, 3, 1, 0.5, -1], offset=[1, 2, 3, 4, 5, 6])
    assert contact_type(tip, frames(tip), NAMED).name.tolist() == list(TOUCHES)


def test_other_skins_and_transducers():
    skin = ss.Layered(ss.Layer(ss.Material(young=1.0, poisson=0.45), thickness=2.5))
    array = ss.SensorArray.line(8, pitch=0.5, depth=1.0, transducer=ss.MeanPressure(), noise=1e-4)
    tip = ss.Finger(skin, array)
    assert contact_type(tip, frames(tip), NAMED, search=(-1.0, 1.0)).name.tolist() == list(TOUCHES)


def test_inputs_stay_as_they_are():
    readings = frames()
    before = readings.copy()
    contact_type(TIP, readings)
    np.testing.assert_array_equal(readings, before)


@pytest.mark.parametrize(
    ("make", "seen"),
    [
        (lambda: Kind("", "line"), "name"),
        (lambda: Kind("a", "lin"), "family"),
        (lambda: Kind("a", "line", (0.0, 1.0)), "width"),
        (lambda: Kind("a", "hertz"), "largest half width"),
        (lambda: Kind("a", "hertz", (1.0, 0.5)), "ascending"),
        (lambda: Kind("a", "hertz", (0.5, 1.0), prior=0.0), "prior"),
        (lambda: Kind("a", "none", (0.0, 1.0)), "has none"),
        (lambda: Kind("a", "pair"), "largest half width"),
        (lambda: Kind("a", "punch", (0.5, 1.0), stick=0.3), "can stick"),
        (lambda: Kind("a", "hertz", (0.5, 1.0), stick=1.0), "can stick"),
        (lambda: Kind("a", "hertz", (0.5, 1.0), stick=-0.1), "stick"),
        (lambda: Kind("a", "round_hertz", (0.5, 1.0), stick=0.3), "can stick"),
        (lambda: contact_type(TIP, frames(), (Kind("a", "none"),)), "of a family"),
        (lambda: contact_type(TIP, frames(), (Kind("a", "line"), Kind("b", "none"), Kind("c", "none"))), "at most one"),
        (lambda: contact_type(TIP, frames(), ()), "at least one"),
        (lambda: contact_type(TIP, frames(), (Kind("a", "line"), Kind("a", "line"))), "own name"),
        (lambda: contact_type(TIP, frames(), ("line",)), "Kind"),
        (lambda: Kind("cannot tell", "line"), "called so"),
        (lambda: Kind("no contact", "line"), "called so"),
        (lambda: contact_type(TIP, frames(), Kind("a", "line")), "several kinds"),
        (lambda: contact_type(frames(), TIP), "a Finger is needed"),
        (lambda: contact_type(TIP, ["a"] * 6), "numbers are needed"),
        (lambda: contact_type(TIP, frames(), search=1.0), "two ascending"),
        (lambda: contact_type(TIP, frames(), sure="0.9"), "real number"),
        (lambda: contact_type(TIP, frames(), sure=0.4), "sure"),
        (lambda: contact_type(TIP, frames(), sure=1.0), "sure"),
        (lambda: contact_type(TIP, frames(), friction=-1.0), "friction"),
        (lambda: contact_type(TIP, frames(), search=(1.0, 0.0)), "search"),
        (lambda: contact_type(finger(noise=0.0), frames()), "noise"),
        (lambda: contact_type(TIP, np.zeros((3, 5))), "6 sensors"),
    ],
)
def test_bad_input_is_told(make, seen):
    with pytest.raises(ss.SubskinError, match=seen):
        make()


def test_the_usual_kinds_are_in_depths():
    skin = ss.HalfPlane(ss.Material(young=1.0))
    tip = ss.Finger(skin, ss.SensorArray(y=[0.0, 1.0, 2.0], depth=[2.0, 3.0, 2.5]))
    widths = np.array([kind.half_width for kind in usual_kinds(tip)]) / 2.0
    np.testing.assert_allclose(widths[[0, 5]], 0)
    np.testing.assert_allclose(widths[4], [0.25, 1.5])
    named = {"vertex": (0.1, 0.35), "flat side": (0.5, 1.2), "round side": (0.5, 1.2)}  # of 0.1
    for kind, (low, high) in zip(usual_kinds(tip)[1:4], widths[1:4], strict=True):
        assert low <= named[kind.name][0]
        assert named[kind.name][1] <= high
    np.testing.assert_allclose(widths[3], [0.4, 2.4])


def second_moment(family, half_width):
    """Of the pressure of a unit force, by a sum over y = a sin(t)."""
    t = (np.arange(200_000) + 0.5) * np.pi / 200_000 - np.pi / 2
    y = half_width * np.sin(t)
    pressure = family(1.0, half_width=half_width).pressure(y) * half_width * np.cos(t)
    assert pressure.sum() * np.pi / 200_000 == pytest.approx(1, rel=1e-4)
    return (y**2 * pressure).sum() / pressure.sum()


def test_the_usual_kinds_meet_in_the_second_moment():
    _, vertex, flat, round_, *_ = usual_kinds(TIP)
    edge = second_moment(ss.Hertz, round_.half_width[0])
    assert second_moment(ss.Wedge, vertex.half_width[1]) == pytest.approx(edge, rel=1e-4)
    assert second_moment(ss.FlatPunch, flat.half_width[0]) == pytest.approx(edge, rel=1e-4)
    end = second_moment(ss.Hertz, round_.half_width[1])
    assert second_moment(ss.FlatPunch, flat.half_width[1]) == pytest.approx(end, rel=1e-4)


def test_what_is_narrower_than_the_edge_is_a_vertex():
    """Readings know only the second moment of what is narrow; wider than the edge, they know a side."""
    tip = finger(6, noise=5e-4)
    rollers = contact_type(tip, tip.read(ss.Hertz(1.0, 0.2, 0.3, half_width=[0.2, 0.3, 0.6, 1.0, 2.0])))
    assert rollers.name.tolist() == ["vertex"] * 2 + ["round side"] * 3
    bars = contact_type(tip, tip.read(ss.FlatPunch(1.0, 0.2, 0.3, half_width=[0.15, 0.2, 0.6, 1.0, 1.5])))
    assert bars.name.tolist() == ["vertex"] * 2 + ["flat side"] * 3
    assert (bars.spare == 2).all()


def test_any_number_of_kinds_is_one_compilation():
    from subskin.estimate.evidence._kernel import weigh_frames

    for kinds in (NAMED[:2], NAMED[:3], NAMED, usual_kinds(TIP)):
        contact_type(TIP, frames(), kinds)
    assert len(getattr(weigh_frames, "signatures", [0])) == 1


def test_two_touches_are_named_where_readings_are_to_spare():
    tip = finger(8)
    readings = tip.read(ss.LineLoad(1.0, 0.2, -0.6)) + tip.read(ss.LineLoad(0.7, -0.2, 0.7))
    said = contact_type(tip, readings)
    assert (str(said.name), int(said.spare)) == ("two touches", 2)
    np.testing.assert_allclose([said.position, said.half_width], [0.05, 0.65], atol=1e-5)
    pushed = [np.cos(0.2) * 1.7, np.sin(0.2) * 0.3]
    np.testing.assert_allclose([said.force, said.angle], [np.hypot(*pushed), np.arctan2(*pushed[::-1])], atol=1e-4)
    few = contact_type(TIP, readings[1:-1])  # six readings, six unknowns
    assert (str(few.name), int(few.spare)) == ("cannot tell", 0)
    # a prior of 0.2, against an eighth of 0.8: what is near to two touches, the other shapes being excluded
    assert few.probability[4] == pytest.approx(2 / 3, abs=0.01)
    np.testing.assert_array_equal(contact_type(tip, readings, friction=0.1).names, said.names)


def test_none_of_these_is_near_to_a_kind_but_off():
    """An even pressure: neither a roller's nor a flat bar's."""
    touch = ss.Strip(1.0, 0.2, 0.3, half_width=0.95)
    quiet = finger(6, noise=5e-4)
    assert str(contact_type(quiet, quiet.read(touch)).name) == "unexplained"
    said = contact_type(TIP, TIP.read(touch), false_alarm=1e-30)
    assert str(said.name) == "none of these"
    assert np.isnan([said.position, said.force, said.half_width, said.residual]).all()
    assert int(said.spare) == 2


@pytest.mark.parametrize("skin", [ss.Round(ss.Material(1.0), 5.0, 2.5), ss.HalfPlane(ss.Material(1.0))])
def test_a_load_beyond_the_search_is_no_kind_within_it(skin):
    """Four sensors, and a side of any width and position: on a round finger one load in seven reads like one."""
    row = ss.SensorArray.line(4, 1.0, depth=1.0)
    noise = 1e-3 * np.abs(ss.Finger(skin, row).measure(ss.LineLoad(1.0, position=0.5))).max()
    tip = ss.Finger(skin, replace(row, noise=noise))
    rng = np.random.default_rng(3)
    y = rng.choice([-1, 1], 400) * (1.5 + rng.uniform(1.6, 4.0, 400))
    readings = tip.read(ss.LineLoad(1.0, rng.uniform(-0.7, 0.7, 400), y), rng)
    said = contact_type(tip, readings)
    assert np.mean((said.status == ss.Status.OK) & (np.abs(said.position - y) > 0.3)) <= 0.003
    found = said.name == "cannot tell"
    assert (said.status[found] == ss.Status.AMBIGUOUS).all()
    assert found.mean() > 0.05
