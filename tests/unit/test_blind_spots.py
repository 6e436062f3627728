"""What a finger cannot object to: the readings are those that the rows name, and the shares those of a plain count."""

import numpy as np
import pytest

import subskin as ss
from subskin.design import Touches
from subskin.design.outside import Scene, outside_of

COUNT, FORCE = 400, 40.0


def row_of(sensors, noise=1e-4, **array):
    skin = ss.HalfPlane(ss.Material(young=0.4e6))
    return ss.Finger(skin, ss.SensorArray.line(sensors, pitch=1.5e-3, depth=2e-3, noise=noise, **array))


@pytest.fixture(scope="module")
def drawn():
    """Readings of each kind, and a finger whose noise is next to nothing, so that they can be taken apart."""
    finger = row_of(8, noise=1e-12)
    touches = Touches(FORCE, friction=0.8)
    return finger, {
        o.name: o.draw(Scene(finger, touches, COUNT, np.random.default_rng(3))) for o in outside_of(touches)
    }


def loads_at(finger, readings, positions):
    """The forces of line loads at known positions that fit each frame best, (m, k, 2), and what is left of it."""
    out, left = [], []
    for frame, at in zip(readings, positions[..., 0], strict=True):
        fields = np.concatenate(list(finger.receptive_field(at)), axis=-1)
        found, *_ = np.linalg.lstsq(fields, frame, rcond=None)
        out.append(found.reshape(-1, 2))
        left.append(np.abs(frame - fields @ found).max() / np.abs(frame).max())
    return np.array(out), np.array(left)


@pytest.mark.parametrize("name", ["line", "two", "two_weak", "drag", "beyond_cone", "pull", "beyond_row"])
def test_loads_are_those_of_the_row(drawn, name):
    finger, kinds = drawn
    one = kinds[name]
    loads, left = loads_at(finger, one.readings, one.positions)
    assert left.max() < 1e-6
    normal, tangential = loads.sum(axis=1).T
    np.testing.assert_allclose(normal, one.normal, atol=1e-6 * FORCE)
    lean = np.abs(tangential) / np.abs(normal).clip(1e-9)
    rows = np.asarray(finger.array.y)
    beyond = (np.abs(one.positions[:, 0, 0]) - rows.max()) / 2e-3
    small = loads[:, -1, 0]
    assert {
        "line": (normal > 0).all() and (lean < 0.8).all() and (beyond < 0).all(),
        "two": loads.shape[1] == 2 and (small > 0.2 * FORCE).all(),
        "two_weak": loads.shape[1] == 2 and (small < 0.3 * FORCE).all() and (small > 0).all(),
        "drag": (np.abs(normal) < 1e-6 * FORCE).all() and (np.abs(tangential) > 0.99 * FORCE).all(),
        "beyond_cone": (normal > 0).all() and (lean > 0.95).all(),
        "pull": (normal < 0).all(),
        "beyond_row": (beyond > 1.6).all() and (beyond < 4).all(),
    }[name]
    if name.startswith("two"):
        gap = np.abs(np.diff(one.positions[..., 0], axis=1)) / 2e-3
        assert gap.min() > 0.5
        assert gap.max() < 3


@pytest.mark.parametrize(
    "name", ["wide_roller", "wide_flat", "tilted_flat", "thickness", "poisson", "position", "gains"]
)
def test_no_line_load_makes_such_readings(drawn, name):
    finger, kinds = drawn
    one = kinds[name]
    assert np.median(loads_at(finger, one.readings, one.positions[:, :1])[1]) > 5e-3
    assert (one.normal > 0).all()


def test_a_tilted_flat_presses_where_it_is_said_to(drawn):
    # far away a contact reads as its resultant does: force and moment
    punch, skin = drawn[1]["tilted_flat"], drawn[0].skin
    assert np.ptp(punch.positions, axis=1).max() < 0.75 * 2e-3 + 1e-9
    touch = ss.FlatPunch(FORCE, 0.0, 0.0, half_width=2e-3, moment=0.9e-3 * FORCE)
    far = ss.Finger(skin, ss.SensorArray.line(3, pitch=0.05, depth=0.099))
    lever = ss.LineLoad(FORCE, 0.0, 0.9e-3)
    np.testing.assert_allclose(far.read(touch), far.read(lever), rtol=8e-3)


@pytest.mark.parametrize("name", ["stuck", "held", "weak"])
def test_one_sensor_is_at_fault(drawn, name):
    kinds = drawn[1]
    one, good = kinds[name], kinds["line"]
    # the draws of the touches are the same: the fault alone differs
    off = np.abs(one.readings - good.readings) > 1e-9
    assert (off.sum(axis=1) <= 1).all()
    assert off.any(axis=0).all()
    at = np.nonzero(off)
    ratio = one.readings[at] / good.readings[at]
    assert {"stuck": np.abs(ratio) < 1e-4, "weak": np.isclose(ratio, 0.6), "held": np.ones(1, bool)}[name].all()


def test_shares_are_counts():
    finger, touches = row_of(4, noise=1e-4), Touches(FORCE)
    passed = finger.blind_spots(touches, count=300, rng=5)
    kinds = outside_of(touches)
    i = [o.name for o in kinds].index("wide_roller")
    one = kinds[i].draw(Scene(finger, touches, 300, np.random.default_rng([i, 5])))
    found = ss.locate(finger, one.readings)
    ok = found.status == ss.Status.OK
    off = np.abs(found.position - one.positions[:, 0, 0])
    row = passed["wide_roller"]
    assert row.ok == ok.mean()
    assert row.far == (ok & (off > 0.6e-3)).mean()
    assert row.wrong == (ok & ((off > 0.6e-3) | (off > 5 * found.std[:, 0]))).mean()
    assert row.unexplained == (found.status == ss.Status.UNEXPLAINED).mean()
    assert row.force == (ok & (np.abs(found.components[:, 0] / one.normal - 1) > 0.3)).mean()


def test_more_sensors_object_to_more():
    few, many = (row_of(n).blind_spots(snr=100, count=300) for n in (4, 8))
    assert (few.spare, many.spare) == (1, 5)
    assert few.wrong > 0.15 > many.wrong
    assert few["line"].ok > 0.9
    assert few["line"].wrong < 0.01
    assert "1 spare reading (4 sensors, 3 unknowns)" in few.sentence


def test_what_the_family_describes_is_not_outside():
    found = row_of(6).blind_spots(Touches(FORCE), "hertz", count=50)
    names = [row.name for row in found.rows]
    assert "wide_roller" not in names
    assert "wide_flat" in names
    assert found.spare == 2


def test_options_and_dead_sensors():
    finger = row_of(6, gain=[1, 1, 0, 1, 1, 1])
    found = finger.blind_spots(Touches(FORCE, friction=0.0), count=50)
    assert found.sensors == 5
    assert found.spare == 3
    with pytest.raises(ss.SubskinError, match="snr = -1"):
        finger.blind_spots(snr=-1)
    with pytest.raises(ss.SubskinError, match="count = 0"):
        finger.blind_spots(count=0)
    with pytest.raises(ss.SubskinError, match="serch"):
        finger.blind_spots(serch=(0, 1))


def test_other_skins_are_tried():
    for skin in (
        ss.Layered(ss.Layer(ss.Material(young=0.4e6), 5e-3)),
        ss.Round(ss.Material(young=0.4e6), radius=8e-3, core_radius=3e-3),
    ):
        finger = ss.Finger(skin, ss.SensorArray.line(6, pitch=1.5e-3, depth=2e-3, noise=1e-4))
        good, other = (
            o.draw(Scene(finger, Touches(FORCE), 20, np.random.default_rng(0)))
            for o in outside_of(Touches(FORCE))
            if o.name in ("line", "thickness")
        )
        assert 0.01 < np.abs(other.readings / good.readings - 1).max()
