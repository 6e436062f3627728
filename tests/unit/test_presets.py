"""Rubbers and barometers by name: the numbers of their sources, in Python and in files."""

from __future__ import annotations

import pickle

import numpy as np
import pytest

import subskin as ss
from subskin._presets import RUBBERS, SENSORS, shore_a_modulus
from subskin.errors import FileError, InvalidValueError
from subskin.io import parse_finger

ROW = "[sensors]\ncount = 4\npitch = 6e-3\ndepth = 5e-3\n"


@pytest.mark.parametrize(
    ("name", "kilopascals"),  # the bulletins' own 100 % modulus, in their kPa
    [("Ecoflex 00-10", 55), ("Ecoflex 00-30", 69), ("Ecoflex 00-50", 83), ("Dragon Skin 10", 151),
     ("Dragon Skin 20", 338), ("Dragon Skin 30", 593)],
)  # fmt: skip
def test_silicones_lie_between_the_secant_and_the_tangent(name, kilopascals):
    rubber = RUBBERS[name]
    np.testing.assert_allclose(rubber.low, 1e3 * kilopascals, rtol=0.007)
    # a neo-Hookean rubber of the upper modulus has that very stress at twice its length
    shear = rubber.high / 3
    np.testing.assert_allclose(shear * (2 - 1 / 2**2), rubber.low, rtol=1e-12)
    assert rubber.low < rubber.young < rubber.high
    assert ss.Material.preset(name).young == rubber.young


def test_gents_relation_is_that_of_the_durometer():
    """By its derivation: a spring of 0.55 + 0.075 S N on a flat punch that sinks in 2.54 - 0.0254 S mm.

    The punch is as wide as the durometer's truncated cone in the mean: 0.79 mm at its tip, 1.27 mm at its shank.
    """
    shore = np.array([20.0, 40.0, 60.0, 80.0])
    force, depth, radius = 0.55 + 0.075 * shore, 1e-3 * 2.54 * (1 - shore / 100), 1e-3 * (0.79 + 1.27) / 4
    flat = force * (1 - 0.5**2) / (2 * radius * depth)  # Boussinesq's
    np.testing.assert_allclose(shore_a_modulus(shore), flat, rtol=0.01)


def test_all_presets_have_sources_and_sense():
    for rubber in RUBBERS.values():
        assert 1e4 < rubber.low < rubber.young < rubber.high < 5e6
        assert len(rubber.source) > 20
    for sensor in SENSORS.values():
        rest, most = (101_325, 1013) if sensor.unit == "Pa" else (0.0, 1e-6)
        assert 0 < sensor.noise < most
        assert sensor.low < rest < sensor.high
        assert len(sensor.source) > 20
    table = ss.SensorArray.presets()
    assert "126000  Pa" in repr(table)
    assert "<th>noise</th>" in table._repr_html_()
    assert pickle.loads(pickle.dumps(table)) == table


def test_a_barometer_in_python_and_in_a_file():
    array = ss.SensorArray.line(count=4, pitch=6e-3, depth=5e-3, **ss.SensorArray.preset("ms5611"))
    file = parse_finger(f'[skin]\nmaterial = "dragon skin 20"\n{ROW}sensor = "MS5611"')
    for name in ("noise", "offset", "low", "high", "gain"):
        np.testing.assert_array_equal(getattr(file.finger.array, name), getattr(array, name))
    assert file.finger.array.transducers == array.transducers
    assert file.finger.skin.materials[0] == ss.Material.preset("Dragon Skin 20")
    assert array.inside(array.digitise(np.zeros(4))).all()  # the free skin is within the range


def test_a_gauge_reads_strain_by_its_bridge():
    file = parse_finger(f'[skin]\nmaterial = "Ecoflex 00-30"\n{ROW}sensor = "HX711 10 Hz"')
    array = file.finger.array
    assert array.transducers[0] == ss.NormalStrain()
    strained, at_rest = 120.0 * (1 + 2.0 * 1e-3), 120.0  # ohm, a factor of 2
    volts = 5.0 * (strained / (strained + 120.0) - at_rest / 240.0)
    # a bridge is not quite straight
    np.testing.assert_allclose(array.noise, 50e-9 / (volts / 1e-3), rtol=2e-3, equal_nan=False)
    np.testing.assert_allclose(array.high, 20e-3 / (volts / 1e-3), rtol=2e-3, equal_nan=False)
    np.testing.assert_array_equal(array.low, -array.high)
    np.testing.assert_array_equal(array.offset, 0.0)


def test_a_key_beside_a_preset_takes_its_place():
    skin = '[skin]\nmaterial = "Sylgard 184"\nyoung = "1.5 MPa"\n'
    file = parse_finger(f'{skin}{ROW}sensor = "BMP280"\nnoise = 5\nkind = "normal_strain"')
    assert file.finger.skin.materials[0].young == 1.5e6
    np.testing.assert_array_equal(file.finger.array.noise, 5.0)
    np.testing.assert_array_equal(file.finger.array.high, 110e3)
    assert file.finger.array.transducers[0] == ss.NormalStrain()
    layers = '[skin]\nkind = "layers"\nlayers = [{material = "Ecoflex 00-50", thickness = 8e-3}]\n'
    assert parse_finger(layers + ROW).finger.skin.materials[0] == ss.Material.preset("Ecoflex 00-50")


@pytest.mark.parametrize(
    ("skin", "sensor", "said"),
    [
        ('material = "dragon skn 20"', "", 'line 2: .*Fix: did you mean "Dragon Skin 20"'),
        ('material = "butter"', "", "known: Ecoflex 00-10, "),
        ('kind = "layers"\nmaterial = "Sylgard 184"\nlayers = [{young = 1e5, thickness = 8e-3}]', "", "each layer has"),
        ('kind = "layers"\nlayers = [{thickness = 8e-3}]', "", '"young" is missing'),
        ("young = 1e5", 'sensor = "BMP28"', 'did you mean "BMP280"'),
    ],
)
def test_a_wrong_name_is_said(skin, sensor, said):
    with pytest.raises(FileError, match=said):
        parse_finger(f"[skin]\n{skin}\n{ROW}{sensor}")


def test_a_name_that_is_none_is_refused():
    with pytest.raises(InvalidValueError, match="no material of this name"):
        ss.Material.preset(3)
