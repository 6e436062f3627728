"""Presses found in recordings whose presses are known."""

import numpy as np
import pytest

import subskin as ss
from subskin.contact import contact_of, families
from subskin.errors import GeometryError, InvalidValueError
from subskin.stream import segment
from subskin.synthetic import simulate_recording

SKIN = ss.HalfPlane(ss.Material(young=0.4e6))
GAIN, OFFSET = [-1e5, -2e5, -1.5e5, -1e5], [1e5, 2e5, 3e5, 4e5]
ARRAY = ss.SensorArray.line(count=4, pitch=6e-3, depth=5e-3, gain=GAIN, offset=OFFSET)
FINGER = ss.Finger(SKIN, ARRAY)
PLACES = np.linspace(-9e-3, 9e-3, 13)


def simple(depths, rate=100.0, ramp=0.5, hold=2.0, rest=1.0):
    """A depth that goes to each of `depths` and back, and its times."""
    corners, values, at = [0.0, rest], [0.0, 0.0], rest
    for depth in depths:
        corners += [at + ramp, at + ramp + hold, at + 2 * ramp + hold, at + 2 * ramp + hold + rest]
        values += [depth, depth, 0.0, 0.0]
        at = corners[-1]
    t = np.arange(0, at, 1 / rate)
    return t, np.interp(t, corners, values)


def test_the_reading_of_an_elastic_skin_is_exact():
    raw = simulate_recording(FINGER, PLACES, force=40.0, relaxation=0.0, origin=2e-3)
    found = segment(raw.readings, raw.time, position=raw.position, press=raw.press)
    assert len(found) == len(PLACES)
    np.testing.assert_allclose(found.position, PLACES, atol=1e-12)
    np.testing.assert_allclose(found.depth, 4e-3, rtol=2e-3)
    expected = FINGER.read(ss.LineLoad(40.0, 0.0, PLACES - 2e-3)) - np.asarray(ARRAY.offset)
    # frames on the ramp's last hundredth belong to the plateau
    np.testing.assert_allclose(found.reading, expected, rtol=3e-3, atol=1e-6)


def test_only_the_early_part_of_a_plateau_counts():
    t, z = simple([1e-3])
    held = np.clip(t - 1.5, 0, 2.0)
    readings = (1e6 * z * (1 - 0.1 * held))[:, None]  # falls by a tenth each second on the plateau
    for early in (0.2, 0.4, 1.0):
        (value,) = segment(readings, t, press=z, early=early).reading[0]
        assert value == pytest.approx(1000 * (1 - 0.1 * early * 2.0 / 2), rel=2e-3)


def test_the_base_is_what_comes_just_before():
    t, z = simple([1e-3, 1e-3])
    drift = 50.0 * t
    for before in (0.1, 0.5):
        found = segment((drift + 1e6 * z)[:, None], t, press=z, before=before, early=0.05)
        # the plateau's early part lies 0.5 s + 0.05 s after the end of the base, whose middle is before / 2 earlier
        gap = 0.5 + 0.05 + before / 2
        np.testing.assert_allclose(found.reading[:, 0], 1000 + 50 * gap, rtol=2e-3)


def test_presses_of_different_depth_and_staircases():
    t, z = simple([1e-3, 0.3e-3, 2e-3, 0.15e-3])
    found = segment(z[:, None], t, press=z)
    # 0.15 mm is less than a tenth of the 2 mm stroke: no press
    np.testing.assert_allclose(found.depth, [1e-3, 0.3e-3, 2e-3], rtol=2e-2)
    stairs = np.interp(np.arange(0, 10, 0.01), [0, 1, 1.5, 4, 4.5, 7, 8, 10], [0, 0, 1, 1, 2, 2, 0, 0])
    found = segment(stairs[:, None], np.arange(0, 10, 0.01), press=stairs)
    np.testing.assert_allclose(found.reading[:, 0], [1, 2], rtol=1e-2)


def test_a_press_without_free_skin_before_it_is_left_out():
    t, z = simple([1e-3, 1e-3])
    inside = t > 2.0
    found = segment(z[inside, None], t[inside], press=z[inside])
    assert (len(found), found.skipped) == (1, 1)


def test_a_missing_reading_costs_that_sensor_that_frame():
    t, z = simple([1e-3, 1e-3])
    rng = np.random.default_rng(0)
    readings = np.stack([1e6 * z, 2e6 * z], axis=-1) + rng.normal(0, 1, (t.size, 2))
    holed = readings.copy()
    holed[rng.random(holed.shape) < 0.3] = np.nan
    full, found = segment(readings, t, press=z), segment(holed, t, press=z)
    np.testing.assert_allclose(found.reading, full.reading, atol=6 * full.std.max())
    assert found.std.mean() > full.std.mean()
    holed[t > 4.5, 1] = np.nan  # gone before the second press
    found = segment(holed, t, press=z)
    assert np.isfinite(found.reading).tolist() == [[True, True], [True, False]]


def test_standard_errors_are_those_of_repeated_recordings():
    t, z = simple([1e-3])
    rng = np.random.default_rng(3)
    clean = (1e6 * z * (1 - 0.1 * np.clip(t - 1.5, 0, 2)) + 5 * t)[:, None]  # relaxes and drifts
    found = [segment(clean + rng.normal(0, 7, clean.shape), t, press=z) for _ in range(400)]
    values, claimed = (np.array([getattr(f, k)[0, 0] for f in found]) for k in ("reading", "std"))
    assert claimed.mean() == pytest.approx(values.std(), rel=0.12)


class TestWithoutADepth:
    def test_the_same_presses_are_found(self):
        rng = np.random.default_rng(1)
        finger = ss.Finger(SKIN, ss.SensorArray.line(4, pitch=6e-3, depth=5e-3, gain=-1e5, offset=1e5, noise=2.0))
        raw = simulate_recording(finger, PLACES, force=40.0, relaxation=0.2, drift=20.0, rest=1.5, rng=rng)
        with_depth = segment(raw.readings, raw.time, position=raw.position, press=raw.press)
        without = segment(raw.readings, raw.time, position=raw.position)
        assert len(without) == len(PLACES)
        assert without.depth is None
        np.testing.assert_allclose(without.position, PLACES, atol=1e-12)
        largest = np.abs(with_depth.reading).max()
        np.testing.assert_allclose(without.reading, with_depth.reading, atol=0.04 * largest)

    def test_a_wild_frame_is_no_contact(self):
        t, z = simple([1e-3])
        readings = (1e6 * z)[:, None].copy()
        readings[20] = 5e3
        assert len(segment(readings, t)) == 1


def test_bad_recordings_are_refused():
    t, z = simple([1e-3])
    data = z[:, None]
    with pytest.raises(InvalidValueError, match=r"time\[5\] = .*must not go back"):
        segment(data, np.where(np.arange(t.size) == 5, -1.0, t), press=z)
    with pytest.raises(InvalidValueError, match="no plateau"):
        segment(data, t, press=np.zeros_like(z))
    with pytest.raises(InvalidValueError, match="no plateau"):
        segment(data, t, press=z, hold=60.0)
    with pytest.raises(InvalidValueError, match="no contact"):
        segment(np.zeros_like(data), t)
    with pytest.raises(InvalidValueError, match="press"):
        segment(data, t, press=np.where(np.arange(t.size) == 5, np.nan, z))
    with pytest.raises(GeometryError, match="press of shape"):
        segment(data, t, press=z[:-1])
    with pytest.raises(GeometryError, match="readings of shape"):
        segment(data[:, 0], t, press=z)
    for option in ({"early": 0.0}, {"early": 1.1}, {"before": 0.0}, {"hold": -1.0}):
        with pytest.raises(InvalidValueError, match=next(iter(option))):
            segment(data, t, press=z, **option)
    assert data.flags.writeable  # the caller's own arrays are left as they were


class TestSimulatedRecording:
    def test_relaxation_and_recoil_are_those_of_a_standard_linear_solid(self):
        share, tau, hold, ramp, rate = 0.3, 0.8, 3.0, 0.25, 40.0  # each corner on a frame
        options = {"relaxation": share, "relaxation_time": tau, "hold": hold, "ramp": ramp, "rate": rate}
        raw = simulate_recording(FINGER, [0.0], force=40.0, **options)
        peak = FINGER.read(ss.LineLoad(40.0)) - np.asarray(ARRAY.offset)
        felt = ((raw.readings - np.asarray(ARRAY.offset)) / peak)[:, 1]
        # load rises linearly over `rise`, from where the indenter meets the skin; then (FORMULAS of a linear solid)
        rise = 0.7 * ramp
        top = 0.5 + ramp
        t = raw.time[(raw.time > top) & (raw.time < top + hold)] - top
        expected = 1 - share + share * tau / rise * (1 - np.exp(-rise / tau)) * np.exp(-t / tau)
        np.testing.assert_allclose(felt[(raw.time > top) & (raw.time < top + hold)], expected, rtol=1e-9)
        assert felt[-1] < -0.02  # it recoils, and has not come back yet

    def test_dead_drift_range_and_resolution(self):
        array = ss.SensorArray.line(
            3, pitch=6e-3, depth=5e-3, gain=[-1e5, 0.0, -1e5], offset=1e5, resolution=8.0, high=100504.0
        )
        finger = ss.Finger(SKIN, array)
        raw = simulate_recording(finger, [0.0, 6e-3], force=40.0, drift=30.0, rng=np.random.default_rng(0))
        assert (raw.readings <= 100504.0).all()
        assert (raw.readings[:, 2] == 100504.0).any()
        np.testing.assert_array_equal(raw.readings[raw.readings < 100504.0] % 8, 0)
        assert 4 < np.abs(raw.readings[:, 1] - 1e5).max() < 200
        again = simulate_recording(finger, [0.0, 6e-3], force=40.0, drift=30.0, rng=np.random.default_rng(0))
        np.testing.assert_array_equal(raw.readings, again.readings)

    @pytest.mark.parametrize("kind", families())
    def test_contacts(self, kind):
        contact = contact_of(kind, None if kind == "line" else 1e-3)
        raw = simulate_recording(FINGER, [0.0], force=40.0, contact=contact, relaxation=0.1)
        felt = raw.readings - np.asarray(ARRAY.offset)
        expected = FINGER.read(contact(force=40.0, position=0.0)) - np.asarray(ARRAY.offset)
        shape = felt[np.abs(felt[:, 1]).argmax()]
        np.testing.assert_allclose(shape / shape[1], expected / expected[1], rtol=1e-9)

    def test_contacts_are_checked(self):
        for kind, width in (("lne", None), ("line", 1e-3), ("hertz", None), ("hertz", -1.0)):
            with pytest.raises(InvalidValueError):
                contact_of(kind, width)
        for option in ({"force": -1.0}, {"rate": 0.0}, {"relaxation": 1.0}, {"drift": np.nan}, {"hold": -1.0}):
            with pytest.raises(InvalidValueError, match=next(iter(option))):
                simulate_recording(FINGER, [0.0], **{"force": 40.0, **option})


@pytest.mark.parametrize(
    ("unit", "more", "scale"), [("N/mm", "", 1e3), ("N", '[touch]\nlength = "20 mm"', 50.0), ("mN/mm", "", 1.0)]
)
def test_a_column_of_forces_is_per_length_of_a_row(unit, more, scale):
    columns = f'sensors = ["a", "b"]\nforce = {{column = "f", unit = "{unit}"}}\n{more}'
    text = f"[skin]\nyoung = 4e5\n[sensors]\ncount = 2\npitch = 2e-3\ndepth = 2e-3\n[recording]\n{columns}"
    assert ss.io.parse_finger(text).recording.force.scale == pytest.approx(scale, rel=1e-12)
