from __future__ import annotations

import numpy as np
import pytest

import subskin as ss

PER_SENSOR = ("depth", "gain", "offset", "noise", "width", "low", "high", "resolution")


def row(**parameters):
    return ss.SensorArray(**{"y": [-1e-3, 0.0, 2e-3], "depth": 2e-3, **parameters})


class TestMaking:
    def test_one_value_for_all_or_one_each(self):
        array = row(gain=2, noise=[1e-4, 0, 1e-3])
        assert array.gain.tolist() == [2.0, 2.0, 2.0]
        assert array.noise.tolist() == [1e-4, 0.0, 1e-3]
        assert len(array) == 3
        assert array.transducers == (ss.NormalStrain(),) * 3

    def test_a_lone_sensor(self):
        assert len(ss.SensorArray(y=0, depth=1)) == 1
        assert ss.SensorArray(y=0, depth=1).y.tolist() == [0.0]

    def test_line_is_centred(self):
        array = ss.SensorArray.line(count=4, pitch=2e-3, depth=1e-3, centre=5e-3, gain=3.0)
        np.testing.assert_allclose(array.y, [2e-3, 4e-3, 6e-3, 8e-3])
        assert (array.gain == 3.0).all()

    def test_arrays_are_its_own_and_read_only(self):
        y = np.array([0.0, 1e-3])
        array = ss.SensorArray(y=y, depth=1e-3)
        y[:] = 9.0
        assert array.y.tolist() == [0.0, 1e-3]
        for name in ("y", *PER_SENSOR):
            with pytest.raises(ValueError, match="read-only"):
                getattr(array, name)[0] = 1.0

    def test_select(self):
        kinds = (ss.NormalStrain(), ss.MeanPressure(), ss.ShearStrain())
        array = row(transducer=kinds, depth=[1e-3, 2e-3, 3e-3], offset=[1.0, 2.0, 3.0])
        for chosen in ([0, 2], np.array([True, False, True])):
            part = array.select(chosen)
            assert part.y.tolist() == [-1e-3, 2e-3]
            assert part.depth.tolist() == [1e-3, 3e-3]
            assert part.offset.tolist() == [1.0, 3.0]
            assert part.transducers == (kinds[0], kinds[2])


class TestRefusals:
    @pytest.mark.parametrize("name", ["depth", "gain", "offset", "noise", "width", "resolution"])
    @pytest.mark.parametrize("bad", [np.nan, "much", [1.0, np.nan, 1.0]])
    def test_what_is_no_number(self, name, bad):
        with pytest.raises(ss.errors.InvalidValueError, match=name):
            row(**{name: bad})

    @pytest.mark.parametrize(("name", "bad"), [("depth", 0.0), ("depth", -1e-3), ("noise", -1.0), ("width", -1.0)])
    def test_out_of_range(self, name, bad):
        with pytest.raises(ss.errors.InvalidValueError, match=f"{name} = .*has to be >"):
            row(**{name: bad})

    def test_nan_position(self):
        with pytest.raises(ss.errors.InvalidValueError, match=r"y\[1\] = nan: has to be finite \[m\]"):
            ss.SensorArray(y=[0.0, np.nan], depth=1.0)

    @pytest.mark.parametrize("name", PER_SENSOR)
    def test_wrong_count(self, name):
        with pytest.raises(
            ss.errors.GeometryError, match=rf"{name} of shape \(2,\): one value, or one for each of the 3"
        ):
            row(**{name: [1.0, 2.0]})

    @pytest.mark.parametrize("y", [[], [[0.0, 1.0]]])
    def test_shape_of_positions(self, y):
        with pytest.raises(ss.errors.GeometryError, match="one position a sensor"):
            ss.SensorArray(y=y, depth=1.0)

    def test_range_upside_down(self):
        with pytest.raises(ss.errors.InvalidValueError, match="low has to be < high"):
            row(low=1.0, high=[2.0, 1.0, 2.0])

    @pytest.mark.parametrize("kinds", [(ss.NormalStrain(),), (ss.NormalStrain(),) * 4, ("strain",) * 3])
    def test_transducers(self, kinds):
        with pytest.raises(ss.SubskinError, match="Transducer"):
            row(transducer=kinds)

    @pytest.mark.parametrize("count", [0, -1, 2.5, True])
    def test_count(self, count):
        with pytest.raises(ss.errors.InvalidValueError, match="count"):
            ss.SensorArray.line(count=count, pitch=1e-3, depth=1e-3)

    @pytest.mark.parametrize("pitch", [0.0, -1e-3, np.nan])
    def test_pitch(self, pitch):
        with pytest.raises(ss.errors.InvalidValueError, match="pitch"):
            ss.SensorArray.line(count=3, pitch=pitch, depth=1e-3)


class TestReadings:
    def test_gain_and_offset(self):
        array = row(gain=[1.0, -2.0, 0.0], offset=[0.0, 1.0, 5.0])
        assert array.digitise(np.array([3.0, 4.0, 5.0])).tolist() == [3.0, -7.0, 5.0]
        assert array.live.tolist() == [True, True, False]

    def test_noise_is_normal_and_each_sensors_own(self):
        array = row(noise=[0.1, 0.0, 2.0], offset=[1.0, 2.0, 3.0])
        measured = np.zeros((40_000, 3))
        readings = array.digitise(measured, np.random.default_rng(11))
        off = readings - array.offset
        assert (off[:, 1] == 0).all()
        for k, sigma in ((0, 0.1), (2, 2.0)):
            z = off[:, k] / sigma
            assert abs(z.mean()) < 4 / 200
            assert abs(z.std() - 1) < 4 / np.sqrt(2 * 40_000)
            assert abs((np.abs(z) < 1.96).mean() - 0.95) < 4 * np.sqrt(0.95 * 0.05 / 40_000)
        assert abs(np.corrcoef(off[:, 0], off[:, 2])[0, 1]) < 4 / 200
        assert not measured.any()

    def test_noise_is_reproducible(self):
        array = row(noise=1.0)
        one, two = (array.digitise(np.zeros(3), np.random.default_rng(3)) for _ in range(2))
        np.testing.assert_array_equal(one, two)

    def test_saturates_at_the_ends_of_its_range(self):
        array = row(gain=10.0, low=-5.0, high=[5.0, 6.0, np.inf])
        readings = array.digitise(np.array([[1.0, 1.0, 1.0], [-1.0, 0.2, 0.1]]))
        assert readings.tolist() == [[5.0, 6.0, 10.0], [-5.0, 2.0, 1.0]]
        assert array.usable(readings).tolist() == [[False, False, True], [False, True, True]]

    def test_noise_saturates_too(self):
        array = row(noise=1.0, low=-0.5, high=0.5)
        readings = array.digitise(np.zeros((500, 3)), np.random.default_rng(1))
        assert readings.min() == -0.5
        assert readings.max() == 0.5

    def test_rounds_to_its_resolution(self):
        array = row(resolution=[0.5, 0.0, 0.2], high=[np.inf, np.inf, 1.1])
        values = np.random.default_rng(2).uniform(-3, 3, (200, 3))
        readings = array.digitise(values)
        assert np.abs(readings[:, 0] - values[:, 0]).max() <= 0.25
        np.testing.assert_array_equal(readings[:, 0] * 2, np.round(readings[:, 0] * 2))
        np.testing.assert_array_equal(readings[:, 1], values[:, 1])
        assert readings[:, 2].max() <= 1.1  # rounding does not leave the range

    def test_usable(self):
        array = row(gain=[1.0, 0.0, 1.0])
        assert array.usable(np.array([np.nan, 1.0, 2.0])).tolist() == [False, False, True]
        assert array.usable(np.array([[np.inf, 1.0, -np.inf]])).tolist() == [[False, False, False]]


def test_a_saturated_reading_is_the_end_of_the_range_whatever_the_resolution():
    array = ss.SensorArray(y=[0.0, 1.0], depth=1.0, low=-100.5, high=100.5, resolution=[8.0, 0.0])
    readings = array.digitise(np.array([[100.4, 100.4], [101.0, 101.0], [-101.0, -101.0], [3.9, 3.9]]))
    np.testing.assert_array_equal(readings, [[100.5, 100.4], [100.5, 100.5], [-100.5, -100.5], [0.0, 3.9]])
    assert array.usable(readings).tolist() == [[False, True], [False, False], [False, False], [True, True]]


def test_what_lies_beyond_the_range_does_not_come_back_into_it_by_rounding():
    """In steps of 8, 99.5 and 99 are nearest to 96, which a range of 99 has; a sensor at its end still says so."""
    array = ss.SensorArray(y=0.0, depth=1.0, low=-99.0, high=99.0, resolution=8.0)
    readings = array.digitise(np.array([[99.5], [-99.5], [99.0], [98.5], [-98.5]]))
    assert readings[:, 0].tolist() == [99.0, -99.0, 99.0, 96.0, -96.0]
    assert array.usable(readings)[:, 0].tolist() == [False, False, False, True, True]


def test_arrays_and_fingers_are_compared_by_identity():
    array = ss.SensorArray(y=[0.0, 1.0], depth=1.0)
    finger = ss.Finger(ss.HalfPlane(ss.Material(young=1.0)), array)
    assert array == array
    assert array != ss.SensorArray(y=[0.0, 1.0], depth=1.0)
    assert {finger: 1}[finger] == 1


@pytest.mark.parametrize(
    ("make", "given", "said"),
    [
        ("line", {"count": 8, "pich": 1e-3}, "'pich' of SensorArray.line.*Fix: pitch="),
        ("line", {"count": 8, "pitch": 1e-3, "depth": 1e-3, "nois": 1.0}, "'nois' of SensorArray.line.*Fix: noise="),
        ("grid", {"shape": (3, 3), "pitch": 1e-3, "dept": 1e-3}, "'dept' of SensorArray.grid.*Fix: depth="),
        ("hexagonal", {"shape": (3, 3), "pitch": 1e-3}, "SensorArray.hexagonal: missing a required argument: 'depth'"),
    ],
)
def test_a_misspelt_or_missing_argument_is_said_of_the_public_class(make, given, said):
    with pytest.raises(TypeError, match=said):
        getattr(ss.SensorArray, make)(**given)
