from __future__ import annotations

import numpy as np
import pytest

import subskin as ss
from subskin.estimate.pressure.prior import half_widths

RUBBER = ss.Material(young=0.4e6)
NOISE = 2e-5


def finger(count=13, pitch=1e-3, **more) -> ss.Finger:
    more = {"noise": NOISE} | more
    return ss.Finger(ss.HalfPlane(RUBBER), ss.SensorArray.line(count, pitch=pitch, depth=2e-3, **more))


ROLLER = ss.Hertz(force=[40.0, 10.0, 25.0], position=[0.0, 1e-3, -1e-3], half_width=2e-3)


@pytest.fixture(scope="module")
def tip() -> ss.Finger:
    return finger()


@pytest.fixture(scope="module")
def frames(tip) -> np.ndarray:
    return tip.read(ROLLER, np.random.default_rng(0))


@pytest.mark.parametrize("shape", [(), (1,), (3,), (3, 1), (1, 3), (0,)])
def test_shapes_follow_the_batch(tip, frames, shape):
    count = int(np.prod(shape))
    found = ss.pressure_map(tip, frames[:count].reshape(*shape, 13) if shape else frames[0])
    m = len(found.y)
    assert found.shape == shape
    for name in ("normal_force", "normal_std", "tangential_force", "tangential_std", "angle", "centre", "weight"):
        assert getattr(found, name).shape == shape
    for name in ("pressure", "pressure_std", "shear", "shear_std", "resolution", "seen"):
        assert getattr(found, name).shape == (*shape, m)
    assert found.pressure_interval.shape == (*shape, m, 2)
    assert found.status.shape == shape
    assert found.used.shape == (*shape, 13)


def test_a_frame_by_itself_and_in_a_batch_are_the_same(tip, frames):
    for shear in ("none", "proportional"):
        whole = ss.pressure_map(tip, frames, shear=shear)
        for f in range(3):
            one = ss.pressure_map(tip, frames[f], shear=shear)
            np.testing.assert_array_equal(one.table, whole.table[f])
            np.testing.assert_array_equal(one.resolution, whole.resolution[f])


def test_totals_belong_to_the_curves(tip, frames):
    found = ss.pressure_map(tip, frames, shear="proportional")
    np.testing.assert_allclose(np.trapezoid(found.pressure, found.y), found.normal_force, rtol=1e-12)
    np.testing.assert_allclose(np.trapezoid(found.shear, found.y), found.tangential_force, rtol=1e-9, equal_nan=False)
    first = np.trapezoid(found.y * found.pressure, found.y)
    np.testing.assert_allclose(first / found.normal_force, found.centre, atol=1e-9)
    assert (found.pressure[:, [0, -1]] == 0).all()
    again = tip.read(ss.PressureProfile(found.y, found.pressure, found.shear)) - frames
    np.testing.assert_allclose(((again / NOISE) ** 2).sum(axis=-1), found.residual, rtol=1e-4)


def test_nothing_can_be_written_to(tip, frames):
    found = ss.pressure_map(tip, frames)
    before = frames.copy()
    for name in ("table", "used", "y", "pressure", "pressure_std", "shear", "resolution", "seen", "pressure_interval"):
        with pytest.raises(ValueError, match="read-only"):
            getattr(found, name)[...] = 0
    np.testing.assert_array_equal(frames, before)


def test_whole_numbers_are_numbers():
    tip = finger(noise=1, gain=1e5)
    touch = np.rint(tip.read(ROLLER)).astype(int)
    one, two = ss.pressure_map(tip, touch), ss.pressure_map(tip, touch.astype(float))
    assert (one.status == ss.Status.OK).all()
    np.testing.assert_array_equal(one.table, two.table)


def test_a_reading_that_is_out_costs_its_frame_that_sensor(tip, frames):
    holed = frames.copy()
    holed[0, 4] = np.nan
    holed[2, [0, 7]] = np.inf, np.nan
    found, whole = ss.pressure_map(tip, holed), ss.pressure_map(tip, frames)
    assert (found.status == ss.Status.OK).all()
    assert found.used.sum(axis=-1).tolist() == [12, 13, 11]
    np.testing.assert_array_equal(found.table[1], whole.table[1])
    rest = [i for i in range(13) if i != 4]
    fewer = ss.Finger(tip.skin, tip.array.select(rest))
    by_rest = ss.pressure_map(fewer, frames[0, rest], search=(found.y[0], found.y[-1]))
    np.testing.assert_allclose(by_rest.pressure, found.pressure[0], atol=1e-6 * found.pressure[0].max())
    np.testing.assert_allclose(by_rest.resolution, found.resolution[0], rtol=1e-3)
    assert (found.pressure_std[0] >= whole.pressure_std[0] * 0.8).all()


def test_dead_and_saturated_sensors_are_left_out(frames):
    gain, high = np.ones(13), np.full(13, np.inf)
    gain[3], high[9] = 0.0, -1e-3
    noise = np.full(13, NOISE)
    noise[3] = 0.0  # a dead sensor needs none
    tip = finger(gain=gain, noise=noise, high=high, low=-0.1)
    found = ss.pressure_map(tip, np.minimum(frames, high))
    assert not found.used[:, 3].any()
    assert not found.used[0, 9] or frames[0, 9] < -1e-3
    assert (found.status == ss.Status.OK).all()
    assert np.abs(found.normal_force - ROLLER.normal_force).max() < 0.5


def test_offsets_and_gains_are_taken_off(tip, frames):
    gain, offset = np.linspace(50, 200, 13), np.linspace(-3, 3, 13)
    other = finger(gain=gain, offset=offset, noise=NOISE * gain)
    found = ss.pressure_map(other, frames * gain + offset)
    np.testing.assert_allclose(found.pressure, ss.pressure_map(tip, frames).pressure, atol=1e-3)


def test_every_status(tip, frames):
    rng = np.random.default_rng(1)
    few = frames[0].copy()
    few[2:] = np.nan
    edge = tip.read(ss.Hertz(force=40.0, position=9e-3, half_width=1e-3))
    pulled = -frames[0]
    found = ss.pressure_map(tip, [frames[0], edge, NOISE * rng.standard_normal(13), pulled, few], shear="none")
    assert [ss.Status(s).name for s in found.status] == [
        "OK", "AMBIGUOUS", "NO_CONTACT", "UNEXPLAINED", "INCOMPLETE",
    ]  # fmt: skip
    for f in (2, 3, 4):
        assert np.isnan(found.pressure[f]).all()
        assert np.isnan(found.resolution[f]).all()
        assert np.isnan(found.normal_force[f])
    assert found.residual[3] > 100


def test_what_a_row_of_eight_cannot_object_to():
    """docs/pressure.md: readings of a skin that is pulled are explained, by a map and by no single contact."""
    few = finger(8, 1.5e-3, noise=1e-4)
    touch = ss.LineLoad(30.0, 0.2, np.linspace(-5e-3, 5e-3, 40))
    pulled = -few.read(touch, np.random.default_rng(1))
    assert (ss.pressure_map(few, pulled).status == ss.Status.AMBIGUOUS).all()
    assert (few.locate(pulled).status == ss.Status.UNEXPLAINED).all()


def test_what_no_pressure_explains_is_said_so(tip, frames):
    wild = frames.copy()
    wild[:, 6] += 400 * NOISE  # one reading that is far off
    assert (ss.pressure_map(tip, wild).status == ss.Status.UNEXPLAINED).all()
    pushed = tip.read(ss.Hertz(force=40.0, angle=0.5, half_width=1.5e-3))
    assert ss.pressure_map(tip, pushed, shear="none").status == ss.Status.UNEXPLAINED  # it drags, and none was allowed
    assert ss.pressure_map(tip, pushed).status == ss.Status.OK


@pytest.mark.parametrize("shear", ["none", "proportional"])
def test_very_precise_readings_are_explained(shear):
    tip = finger(count=25, pitch=0.5e-3, noise=2e-8)
    found = ss.pressure_map(
        tip, tip.read(ss.Hertz(force=40.0, angle=0.3 * (shear != "none"), half_width=2e-3)), shear=shear
    )
    assert found.status == ss.Status.OK
    assert found.optimality < 1e-8
    assert found.normal_force == pytest.approx(40 * np.cos(0.3 * (shear != "none")), rel=1e-4)


def test_mirrored_readings_give_the_mirrored_map(tip, frames):
    found, back = (ss.pressure_map(tip, f, shear="proportional") for f in (frames, frames[:, ::-1]))
    np.testing.assert_allclose(back.pressure[:, ::-1], found.pressure, atol=1e-3 * found.pressure.max())
    np.testing.assert_allclose(back.angle, -found.angle, atol=0.02 * found.angle_std.max())
    np.testing.assert_allclose(back.resolution[:, ::-1], found.resolution, rtol=1e-2)


def test_a_resistance_is_made_linear_first():
    noise = 2 * NOISE
    exact, linear = (finger(transducer=ss.VolumeResistance(exact=e), noise=noise, gain=1.0) for e in (True, False))
    found = [ss.pressure_map(f, f.read(ROLLER)) for f in (exact, linear)]
    np.testing.assert_allclose(found[0].pressure, found[1].pressure, atol=1e-3)
    with pytest.raises(ss.errors.NotLinearError):
        ss.estimate.PressureMapper(finger(transducer=ss.EnergyDensity()))


def kinds(*transducers: ss.Transducer, depth=2e-3, count=13) -> ss.Finger:
    y = np.tile(1e-3 * (np.arange(count) - (count - 1) / 2), len(transducers))
    kind = tuple(t for t in transducers for _ in range(count))
    scale = np.repeat([0.4e6 if isinstance(t, ss.MeanPressure | ss.NormalStress) else 1.0 for t in transducers], count)
    depths = np.broadcast_to(np.repeat(depth, count) if np.ndim(depth) else depth, y.shape)
    return ss.Finger(ss.HalfPlane(RUBBER), ss.SensorArray(y=y, depth=depths, transducer=kind, noise=NOISE * scale))


@pytest.mark.parametrize(
    "blind",
    [
        finger(),
        finger(count=5, pitch=2e-3),
        kinds(ss.NormalStrain(), ss.LateralStrain()),  # at nu = 1/2 one is minus the other
        kinds(ss.NormalStrain(), ss.ShearStrain()),  # real and imaginary part of one analytic function
    ],
)
def test_free_shear_is_refused_where_it_cannot_be_told(blind):
    with pytest.raises(ss.errors.InvalidValueError, match="one function of y") as caught:
        ss.estimate.PressureMapper(blind, shear="free")
    assert "proportional" in str(caught.value)
    assert ss.estimate.PressureMapper(blind).shear_seen < 0.15


@pytest.mark.parametrize(
    "seeing",
    [
        kinds(ss.NormalStrain(), ss.MeanPressure()),
        kinds(ss.NormalStrain(), ss.NormalStrain(), depth=[2e-3, 3e-3]),
        kinds(ss.NormalStrain(), ss.NormalStress()),
    ],
)
def test_free_shear_is_taken_where_it_can(seeing):
    mapper = ss.estimate.PressureMapper(seeing, shear="free")
    assert mapper.shear_seen > 0.3
    drag = ss.Hertz(force=40.0, angle=-0.4, half_width=2e-3)
    found = mapper(seeing.read(drag, np.random.default_rng(2)))
    assert found.status == ss.Status.OK
    assert abs(found.tangential_force - drag.tangential_force) < 5 * found.tangential_std
    assert abs(found.angle + 0.4) < 5 * found.angle_std < 0.05
    assert np.linalg.norm(found.shear - drag.shear(found.y)) < 0.3 * np.linalg.norm(drag.shear(found.y))


def test_the_search_and_the_step_are_kept(tip, frames):
    found = ss.pressure_map(tip, frames, search=(-5e-3, 6e-3), step=0.4e-3)
    np.testing.assert_allclose(found.y[[0, -1]], [-5e-3, 6e-3], rtol=1e-12)
    assert np.diff(found.y).max() <= 0.4e-3 + 1e-15
    assert (len(found.y) - 1) % 3 == 0
    np.testing.assert_allclose(found.normal_force, ROLLER.normal_force, rtol=0.02)


def test_a_finger_keeps_its_mappers(tip, frames):
    one, two = ss.pressure_map(tip, frames), ss.pressure_map(tip, frames)
    assert one.mapper is two.mapper
    assert ss.pressure_map(tip, frames, rule="gcv").mapper is not one.mapper


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"shear": "some"}, '"none", "proportional" or "free"'),
        ({"rule": "lcurve"}, '"evidence", "discrepancy" or "gcv"'),
        ({"friction": 0}, "friction = 0: has to be > 0"),
        ({"friction": np.inf}, "finite"),
        ({"least_force": -1}, "least_force = -1"),
        ({"false_alarm": 0}, "false_alarm = 0"),
        ({"step": 1e-3}, "at most 0.0005 m"),
        ({"step": 1e-6}, "at most 4096"),
        ({"search": (1e-3, 0.0)}, "two ascending positions"),
    ],
)
def test_options_out_of_range(tip, options, message):
    with pytest.raises(ss.SubskinError, match=message):
        ss.estimate.PressureMapper(tip, **options)


def test_sensors_without_noise_and_other_shapes_are_refused(tip, frames):
    with pytest.raises(ss.errors.InvalidValueError, match="noise = 0"):
        ss.estimate.PressureMapper(finger(noise=0.0))
    with pytest.raises(ss.errors.GeometryError, match="13 sensors"):
        ss.pressure_map(tip, frames[:, :5])
    with pytest.raises(ss.errors.GeometryError, match="13 sensors"):
        ss.pressure_map(tip, 1.0)


def test_all_sensors_dead():
    tip = finger(gain=0.0)
    assert ss.pressure_map(tip, np.zeros(13)).status == ss.Status.INCOMPLETE


def test_half_widths_of_known_peaks():
    rows = np.arange(201.0)[:, None]
    centres = np.array([60.0, 100.0, 140.0])
    bells = np.exp(-0.5 * ((rows - centres) / 10) ** 2)
    columns = np.zeros((201, 201))
    columns[:, [60, 100, 150]] = bells  # the last is seen ten rows from where it is
    widths = half_widths(columns, rows[:, 0].astype(int))
    half = 10 * np.sqrt(2 * np.log(2))
    np.testing.assert_allclose(widths[[60, 100]], 2 * half, rtol=2e-3)
    assert widths[150] == pytest.approx(2 * half, rel=2e-3)  # ten is within its half width
    columns[:, 170] = columns[:, 150]
    assert half_widths(columns, rows[:, 0].astype(int))[170] == pytest.approx(half + 30, rel=2e-3)
