"""A finger file with another kind of sensor in it: what it reads stays in the units of its readings."""

import numpy as np
import pytest

import subskin as ss
from subskin.io import parse_finger
from subskin.io.changed import remodelled

SKIN = '[skin]\nyoung = "0.2 MPa"\n[sensors]\ncount = 3\npitch = "6 mm"\ndepth = "5 mm"\n'
PA = '[recording]\nsensors = ["a", "b", "c"]\nunit = "Pa"\n'


@pytest.mark.parametrize("kind", ["normal_stress", "mean_pressure"])
@pytest.mark.parametrize(
    ("gain", "per_strain"), [('"-1 MPa"', -1e6), ("-1e6", -1e6), ('["-1 MPa", -2e6, "3 MPa"]', [-1e6, -2e6, 3e6])]
)
def test_a_gain_follows_the_kind_of_sensor(kind, gain, per_strain):
    """Under stress s the strain is s/E: gain per strain x s/E = gain per stress x s. The noise keeps its unit."""
    file = parse_finger(f'{SKIN}kind = "normal_strain"\ngain = {gain}  # guessed\nnoise = "10 Pa"\n{PA}')
    other = remodelled(file, kind=kind)
    np.testing.assert_allclose(
        other.finger.array.gain * 2e5, np.broadcast_to(per_strain, 3), rtol=1e-9, equal_nan=False
    )
    np.testing.assert_array_equal(other.finger.array.noise, 10.0)
    assert "# guessed" in other.text
    assert 'noise = "10 Pa"' in other.text
    back = remodelled(other, kind="normal_strain").finger.array
    np.testing.assert_allclose(back.gain, file.finger.array.gain, rtol=1e-8, equal_nan=False)


def test_a_gain_between_kinds_of_one_unit_stays_as_it_is_written():
    file = parse_finger(f'{SKIN}kind = "normal_stress"\ngain = "0.9 Pa/Pa"\n{PA}')
    assert 'gain = "0.9 Pa/Pa"' in remodelled(file, kind="mean_pressure").text


def test_readings_without_a_unit_of_their_own_keep_their_numbers():
    given = 'kind = "normal_stress"\nnoise = "2 kPa"\nresolution = "5 Pa"\nlow = "-1 MPa"\n'
    array = remodelled(parse_finger(SKIN + given), kind="normal_strain").finger.array
    for name, value in (("noise", 2e3), ("resolution", 5.0), ("low", -1e6), ("high", np.inf)):
        np.testing.assert_array_equal(getattr(array, name), value)


def test_differences_stay_differences():
    """What `segment` wrote has no range: a candidate may not take raw limits for it."""
    file = parse_finger(f'{SKIN}offset = "1 bar"\nlow = "0.9 bar"\nhigh = "2 bar"\ngain = "-1 MPa"\n{PA}')
    other = remodelled(file.of_differences(), kind="mean_pressure")
    assert other.differences
    np.testing.assert_array_equal(other.finger.array.low, -np.inf)
    np.testing.assert_array_equal(other.finger.array.offset, 0.0)
    assert isinstance(other.finger.array.transducers[0], ss.MeanPressure)
    assert 'low = "0.9 bar"' in other.text
