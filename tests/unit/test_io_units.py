"""Units are turned into SI at one door, and what is no unit is refused there."""

import math
import subprocess
import sys

import pytest

from subskin.errors import InvalidValueError
from subskin.io.units import _PLAIN, format_quantity, quantity, si_unit, unit_scale


@pytest.mark.parametrize(
    ("text", "to", "value"),
    [
        ("2 mm", "m", 2e-3),
        ("2mm", "m", 2e-3),
        (" 7 mm ", "m", 7e-3),
        ("3 µm", "m", 3e-6),
        ("1 inch", "m", 25.4e-3),
        ("0.4 MPa", "Pa", 0.4e6),
        ("58 psi", "Pa", 58 * 4.4482216152605 / 25.4e-3**2),
        ("30 deg", "rad", math.pi / 6),
        ("4 N/mm", "N/m", 4000.0),
        ("3 kN*m/m^2", "N/m", 3000.0),
        ("20 %", "", 0.2),
        ("67 Hz", "Hz", 67.0),
        ("1.5", "m", 1.5),
        ("-1e-3", "m", -1e-3),
        (3, "Pa", 3.0),
    ],
)
def test_quantity(text, to, value):
    assert quantity(text, to, "x") == pytest.approx(value, rel=1e-12)


@pytest.mark.parametrize("count", range(1, 100))
def test_whole_millimetres_are_the_same_number_as_metres(count):
    assert quantity(f"{count} mm", "m", "x") == count / 1000
    assert quantity(f"{count} um", "m", "x") == count / 1000000


@pytest.mark.parametrize(
    ("value", "to", "said"),
    [
        ("2 kg", "m", 'x = "2 kg": a value in m is needed'),
        ("2 milimeter", "m", 'did you mean "millimeter"'),
        ("0.4 Mpa", "Pa", 'did you mean "MPa"'),
        ("2 furlongz", "m", 'no unit "furlongz" is known'),
        ("mm", "m", "begin with a number"),
        ("", "m", "begin with a number"),
        ("2 mm mm", "m", "a unit is a name"),
        ("33 N/15mm", "N/m", 'write e.g. "40 N/m"'),
        ("2 m**99999", "m", "a unit is a name"),
        ("2 __import__('os')", "m", "a unit is a name"),
        ("20 degC", "K", "no fixed ratio"),
        ("1e999 m", "m", "finite"),
        (float("nan"), "m", "finite"),
        (10**400, "m", "finite"),
        (True, "m", "a number with its unit"),
        ([1], "m", "a number with its unit"),
        (None, "m", "a number with its unit"),
        ("2 mm", "", "a plain number"),
        ("30 deg", "", "this is an angle"),
        ("1 mrad", "", "this is an angle"),
    ],
)
def test_what_is_no_quantity_is_refused(value, to, said):
    with pytest.raises(InvalidValueError) as caught:
        quantity(value, to, "x")
    assert said in str(caught.value)


@pytest.mark.parametrize(("to", "unit"), [(to, unit) for to, units in _PLAIN.items() for unit in units])
def test_a_plain_unit_is_what_pint_says(to, unit, monkeypatch):
    plain = quantity(f"3 {unit}", to, "x"), unit_scale(unit, to, "x"), unit_scale(unit, None, "x"), si_unit(unit, "x")
    monkeypatch.setattr("subskin.io.units._PLAIN", {})
    assert plain == (
        quantity(f"3 {unit}", to, "x"),
        unit_scale(unit, to, "x"),
        unit_scale(unit, None, "x"),
        si_unit(unit, "x"),
    )


def test_files_in_plain_units_need_no_pint():
    program = """
import sys
from subskin.io.units import quantity, si_unit, unit_scale
assert (quantity("2 mm", "m", "x"), unit_scale("1e-3 mm", "m", "x"), si_unit("kPa", "x")) == (0.002, 1e-6, "Pa")
assert "pint" not in sys.modules
"""
    subprocess.run([sys.executable, "-c", program], check=True)


def test_counts():
    assert unit_scale("1e-3 mm", "m", "x") == 1e-6
    assert unit_scale("1/320 mm", "m", "z") == pytest.approx(1e-3 / 320, rel=1e-15)
    assert unit_scale("-1/320 mm", "m", "z") == -unit_scale("1/320 mm", "m", "z")
    assert unit_scale("psi", None, "p") == pytest.approx(6894.757293168, rel=1e-12)
    assert si_unit("3 psi", "p") == "Pa"
    assert si_unit("0.1 mV", "p") == "V"
    assert si_unit("percent", "p") == ""


@pytest.mark.parametrize("text", ["0 mm", "1/0 mm", "", "3", "s", 3, None, "degC", "e" * 200])
def test_what_is_no_count_is_refused(text):
    with pytest.raises(InvalidValueError):
        unit_scale(text, "m", "x")


def test_text_comes_back_as_the_same_value():
    for value, unit in ((5.4e-3, "m"), (-8.98625352e-3, "m"), (4e5, "Pa"), (0.3, "rad"), (12.5, "")):
        assert quantity(format_quantity(value, unit), unit, "x") == pytest.approx(value, rel=5e-9)  # nine digits
