"""What is made once of a finger: kept by value, bounded, never pickled; options that are no key, or do not exist."""

from __future__ import annotations

import gc
import pickle
import weakref

import numpy as np
import pytest

import subskin as ss
from subskin import prepared as prepared_module
from subskin.design.placement import Channel
from subskin.design.placement._field import OneSensor
from subskin.errors import InvalidValueError, UnknownOptionError
from subskin.prepared import Prepared, prepared, tabulated
from subskin.radial import tabulate_radial


def finger():
    return ss.Finger(ss.HalfPlane(ss.Material(young=0.4e6)), ss.SensorArray.line(5, 1.5e-3, depth=2e-3, noise=1e-4))


def test_by_value_and_no_more_than_there_is_room_for():
    made = []
    kept = Prepared(most=3)
    for key in (1, 2, 3, 1.0, 4, 2, 1):  # 4 drives out 1, the first that was made
        kept.get(key, lambda key=key: made.append(key))
    assert made == [1, 2, 3, 4, 1]


def test_one_locator_for_equal_options():
    tip = finger()
    assert tip.locator(friction=1) is tip.locator() is tip.locator(friction=np.float32(1.0))
    assert (
        tip.locator(search=[-3e-3, 3e-3])
        is tip.locator(search=(-3e-3, 3e-3))
        is tip.locator(search=np.array([-3e-3, 3e-3]))
    )
    assert tip.locator(friction=0.5) is not tip.locator()
    assert finger().locator() is not tip.locator()  # a finger of its own


def test_a_thousand_searches_do_not_stay():
    tip = finger()
    first = weakref.ref(tip.tabulate((-2e-3, 2e-3)))
    for k in range(40):
        tip.tabulate((-2e-3, 2e-3 + 1e-5 * (k + 1)))
    gc.collect()
    assert first() is None


def test_a_finger_travels_without_what_was_made_of_it():
    tip = finger()
    bare = len(pickle.dumps(tip))
    locator = tip.locator()
    tip.locate(np.zeros(5))
    assert len(pickle.dumps(tip)) == bare
    assert pickle.loads(pickle.dumps(tip)).locator() is not locator


def test_what_is_made_goes_with_the_finger():
    tip = finger()
    kept = weakref.ref(prepared(tip))
    tip.locate(np.zeros(5))
    del tip
    gc.collect()
    assert kept() is None


@pytest.mark.parametrize(
    ("call", "seen", "fix"),
    [
        (lambda tip, r: tip.locate(r, frictoin=0.5), "frictoin", "friction="),
        (lambda tip, r: tip.locator(scanstep=1e-4), "scanstep", "scan_step="),
        (lambda tip, r: tip.fit(r, halfwidth=(0.0, 1e-3)), "halfwidth", "half_width="),
        (lambda tip, r: ss.pressure_map(tip, r, least_forse=0.1), "least_forse", "least_force="),
    ],
    ids=["locate", "locator", "fit", "pressure_map"],
)
def test_a_misspelt_option_is_told_what_there_is(call, seen, fix):
    with pytest.raises(UnknownOptionError, match=seen) as error:
        call(finger(), np.zeros(5))
    assert "false_alarm" in str(error.value)
    assert fix in str(error.value)


def test_locate_has_no_half_width():
    with pytest.raises(UnknownOptionError) as error:
        finger().locate(np.zeros(5), half_width=(0.0, 1e-3))
    assert "half_width" not in str(error.value).split("there are")[1]


def test_an_option_that_is_no_number_says_so():
    for value in ([0.5], np.array([0.5, 1.0]), {}, "much"):
        with pytest.raises(InvalidValueError, match=r"friction.*a single number"):
            finger().locate(np.zeros(5), friction=value)
    with pytest.raises(InvalidValueError, match=r"search.*two ascending numbers"):
        finger().locate(np.zeros(5), search={})


def test_readings_that_are_read_only_have_no_loop_of_their_own():
    from subskin.estimate.project import project_frames

    tip = finger()
    readings = tip.read(ss.LineLoad(force=[30.0, 20.0]))
    found = tip.locate(readings)
    before = list(project_frames.signatures)
    readings.flags.writeable = False
    np.testing.assert_array_equal(tip.locate(readings).table, found.table)
    assert project_frames.signatures == before != []


@pytest.fixture
def tables(monkeypatch):
    """No tables kept, and how often a layered skin is asked for a field."""
    asked = []
    own = ss.Layered.at
    monkeypatch.setattr(prepared_module, "_tables", Prepared(most=256))
    monkeypatch.setattr(ss.Layered, "at", lambda self, *points: (asked.append(1), own(self, *points))[1])
    return asked


def layered():
    return ss.Layered(ss.Layer(ss.Material(young=0.4e6), thickness=5e-3))


def one_sensor(reach, width=0.0, noise=1.0):
    return OneSensor(layered(), Channel(ss.NormalStrain(), noise, width), 2e-3, reach)


def test_a_row_of_an_equal_skin_is_tabulated_once(tables):
    one_sensor(20e-3)
    first = len(tables)
    one_sensor(15e-3, noise=2.0)
    one_sensor(22e-3, width=0.4e-3)
    assert 0 < first == len(tables)
    one_sensor(40e-3)  # farther than before: what is beyond, and no more
    assert len(tables) == first + 2


def test_an_area_of_an_equal_skin_is_tabulated_once(tables):
    def table(pitch):
        array = ss.SensorArray.grid((2, 3), pitch=pitch, depth=2e-3)
        return tabulate_radial(ss.Finger(layered(), array), 15e-3)

    one = table(2e-3)
    first = len(tables)
    two = table(3e-3)
    assert 0 < first
    assert len(tables) < 2 * first  # no field, but the look whether a transducer has a linear part
    np.testing.assert_array_equal(one.coefficients, two.coefficients)


def test_a_table_does_not_depend_on_what_was_asked_for_before(tables):
    long = one_sensor(60e-3)
    short = one_sensor(20e-3)
    prepared_module._tables = Prepared()
    alone = one_sensor(20e-3)
    np.testing.assert_array_equal(short._values, alone._values)
    middle, half = len(long._values) // 2, len(alone._values) // 2
    np.testing.assert_array_equal(long._values[middle - half : middle + half], alone._values)


@pytest.mark.parametrize("width", [0.0, 0.8e-3])
def test_the_pieces_of_a_table_are_the_field(width):
    """In the middle, where pieces meet, and far off."""
    one = one_sensor(60e-3, width)
    array = ss.SensorArray([0.0], 2e-3, width=width)
    at = np.array([-58e-3, -24e-3, -1.3e-3, 0.0, 0.7e-3, 24.01e-3, 47.9e-3])
    field = ss.Finger(layered(), array).receptive_field(at)[:, 0]
    steps = (at - one._start) / one._step
    cell = np.floor(steps).astype(int)
    t = (steps - cell - 0.5)[:, None] ** np.arange(5)
    found = np.einsum("pkl,pk->pl", one._values[cell], t)
    np.testing.assert_allclose(found, field, rtol=0, atol=2e-9 * np.abs(field).max(), equal_nan=False)


def test_a_skin_without_a_hash_is_tabulated_each_time():
    assert [tabulated(("row", []), lambda k=k: k) for k in (1, 2)] == [1, 2]
