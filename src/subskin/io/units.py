"""Quantities with units, as files and the command line write them -> SI. The only door for units."""

from __future__ import annotations

import difflib
import math
import re
from collections.abc import Callable
from functools import cache
from typing import Any

from ..errors import InvalidValueError

__all__ = ["format_quantity", "line_load", "line_load_scale", "of_field", "quantity", "si_unit", "unit_scale"]

_EXAMPLES = {"m": "2 mm", "Pa": "0.4 MPa", "rad": "30 deg", "N/m": "40 N/m", "": "0.5"}
_DIGITS = r"[+-]?(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][+-]?[0-9]{1,3})?"
_NUMBER = re.compile(rf"\s*({_DIGITS})\s*(.*?)\s*", re.DOTALL)
_COUNT = re.compile(rf"\s*({_DIGITS})(?:\s*/\s*({_DIGITS}))?\s*(\D.*?)\s*", re.DOTALL)
# Names with powers of one digit, joined by * or /: what a unit needs, and nothing that could keep pint busy.
_WORD, _POWER = r"[A-Za-zµμ°Ω%]+", r"(?:\^-?\d|\*\*-?\d)?"
_UNIT = re.compile(rf"(?:1|{_WORD}){_POWER}(?:\s*[*/·]\s*{_WORD}{_POWER}){{0,4}}")
_COMMON = (  # what a misspelt unit may have meant
    *("m", "mm", "cm", "um", "µm", "inch", "thou", "meter", "metre", "millimeter", "millimetre", "centimeter"),
    *("micrometer", "Pa", "kPa", "MPa", "GPa", "hPa", "bar", "mbar", "psi", "pascal", "N", "mN", "kN", "newton"),
    *("deg", "rad", "degree", "radian", "s", "ms", "us", "min", "Hz", "kHz", "V", "mV", "ohm", "kohm", "percent"),
)
_DIVIDE = "0.5 N over a contact 20 mm long is 25 N/m: write that, or give length under [touch]"
_SI = ("m", "Pa", "N", "V", "ohm", "A", "s", "Hz", "F", "T", "K", "N/m")
_PLAIN = {
    "m": {"m": 1.0, "cm": 1e-2, "mm": 1e-3, "um": 1e-6},
    "Pa": {"Pa": 1.0, "hPa": 1e2, "kPa": 1e3, "MPa": 1e6, "GPa": 1e9},
    "N": {"N": 1.0, "mN": 1e-3},
    "N/m": {"N/m": 1.0, "N/mm": 1e3, "mN/mm": 1.0},
    "s": {"s": 1.0, "ms": 1e-3},
    "Hz": {"Hz": 1.0, "kHz": 1e3},
    "rad": {"rad": 1.0, "deg": math.pi / 180},
}
"""Units of most files, in SI: pint, which knows all of them, takes long to import."""


@cache
def _registry() -> Any:
    import pint

    registry: Any = pint.UnitRegistry()
    return registry


def _unit(text: str, name: str, to: str = "m") -> Any:
    """The pint unit that `text` names, where one of the dimension of `to` is wanted."""
    import pint

    seen = f"{name}: unit {_short(text)}"
    if len(text) > 40 or not _UNIT.fullmatch(text):
        raise InvalidValueError(seen, "a unit is a name such as mm, kPa or N/m", f'write e.g. "{_example(to)}"')
    try:
        return _registry().parse_units(text.replace("·", "*"))
    except pint.UndefinedUnitError:
        bad = next((word for word in re.findall(_WORD, text) if not _known(word)), text)
        names = {name.lower(): name for name in reversed(_COMMON)}
        close = difflib.get_close_matches(bad.lower(), list(names), n=1)
        fix = f'did you mean "{names[close[0]]}"' if close else "e.g. mm, kPa, deg, N/m"
        raise InvalidValueError(seen, f'no unit "{bad}" is known', fix) from None
    except Exception:  # pint lets many kinds of error through, of its parser and of what lies below it
        raise InvalidValueError(seen, "it cannot be understood", 'write e.g. "mm" or "N/m"') from None


def _known(word: str) -> bool:
    try:
        _registry().parse_units(word)
    except Exception:
        return False
    return True


def _factor(text: str, to: str, name: str, seen: str) -> float:
    """SI value of the one unit that `text` names, which has to have the dimension of `to`."""
    plain = _PLAIN.get(to, {}).get(text)
    if plain is not None:
        return plain
    unit, registry = _unit(text, name, to), _registry()
    target = registry.parse_units(to) if to else registry.dimensionless
    fix = f'write e.g. "{_example(to)}"'
    if unit.dimensionality != target.dimensionality:
        if to == "N/m" and unit.dimensionality == registry.newton.dimensionality:
            raise InvalidValueError(seen, "a force per length of contact, in N/m, is needed", _DIVIDE)
        rule = f"a value in {to} is needed" if to else "a plain number is needed"
        raise InvalidValueError(seen, rule, fix)
    try:
        one, zero = (float(registry.Quantity(v, unit).to(target).magnitude) for v in (1.0, 0.0))
    except Exception:
        one = zero = math.nan
    if zero != 0 or not math.isfinite(one) or one == 0:
        raise InvalidValueError(seen, "its unit has no fixed ratio to SI", fix)
    return one


def _is_angle(text: str) -> bool:
    registry = _registry()
    return bool(registry.get_base_units(registry.parse_units(text.replace("·", "*")))[1] == registry.radian)


def _example(to: str) -> str:
    return _EXAMPLES.get(to, f"1.5 {to}".strip())


def quantity(value: object, to: str, name: str) -> float:
    """A number with its unit, such as "2 mm", in the SI unit `to`; a bare number is in `to` already.

    Parameters
    ----------
    value : str, int or float
        What was written [`to`, if a bare number].
    to : str
        SI unit of the result: "m", "Pa", "rad", "N/m", ...; "" for a plain number.
    name : str
        What it is called, for the message.

    Raises
    ------
    InvalidValueError
        No number, no known unit, a unit of another dimension, or a number that is not finite.

    Examples
    --------
    >>> quantity("2 mm", "m", "depth"), quantity("0.4 MPa", "Pa", "young"), quantity(0.002, "m", "depth")
    (0.002, 400000.0, 0.002)
    >>> try:
    ...     quantity("2 milimeter", "m", "depth")
    ... except ValueError as error:
    ...     print(error)
    depth: unit "milimeter": no unit "milimeter" is known. Fix: did you mean "millimeter".
    """
    if type(value) is float and math.isfinite(value):
        return value
    fix = f'write e.g. "{_example(to)}"' + (f", or a bare number in {to}" if to else "")
    seen = f"{name} = {_short(value)}"
    if isinstance(value, bool) or not isinstance(value, (int, float, str)):
        raise InvalidValueError(seen, "a number with its unit is needed", fix)
    if isinstance(value, str):
        if ".." in value:
            rule = "a single value is needed, and this is a range"
            raise InvalidValueError(seen, rule, f'where two are taken: ["20 {to}", "40 {to}"]')
        match = _NUMBER.fullmatch(value)
        if match is None or len(value) > 100:
            raise InvalidValueError(seen, "it has to begin with a number", fix)
        number = float(match[1])
        if match[2]:
            factor = _factor(match[2], to, name, seen)
            if not to and _is_angle(match[2]):  # of no dimension to pint
                rule = "a plain number is needed, and this is an angle"
                raise InvalidValueError(seen, rule, "of an angle of friction write its tangent")
            inverse = round(1 / factor) if 1e-15 < factor < 1 else 0
            # divide where that is exact: 7 mm is then the same number as 0.007
            exact = inverse and math.isclose(1 / factor, inverse, rel_tol=1e-12)
            number = number / inverse if exact else number * factor
    else:
        try:
            number = float(value)
        except OverflowError:
            number = math.inf
    if not math.isfinite(number):
        raise InvalidValueError(seen, "it has to be finite", fix)
    return number


def of_field(to: str, *, lists: bool = False) -> Callable[[object, Any], float | list[float]]:
    """What reads a field of a pydantic model as a `quantity` in the SI unit `to`, or with `lists` as a list of them."""

    def convert(value: object, info: Any) -> float | list[float]:
        name = str(info.field_name)
        if lists and isinstance(value, list):
            return [quantity(item, to, f"{name}[{i}]") for i, item in enumerate(value)]
        return quantity(value, to, name)

    return convert


def unit_scale(text: object, to: str | None, name: str) -> float:
    """What one count is worth in SI, from a unit ("mm", "psi") or a multiple of one ("1e-3 mm", "1/320 mm").

    Parameters
    ----------
    text : str
        The unit. A number, or the ratio of two, may stand before it; a negative one turns the axis round.
    to : str or None
        The SI unit it has to be a multiple of; None for that of whatever dimension it has.
    name : str
        What it is called, for the message.

    Raises
    ------
    InvalidValueError
        No unit, an unknown one, one of another dimension, or a number that is 0.

    Examples
    --------
    >>> unit_scale("1e-3 mm", "m", "x"), unit_scale("1/320 mm", "m", "z")
    (1e-06, 3.125e-06)
    """
    number, unit = _counted(text, name)
    return number * _factor(unit, _si_name(unit, name) if to is None else to, name, f"{name} = {_short(text)}")


def line_load(value: object, length: float | None, name: str) -> float:
    """A force per length of contact [N/m]; where the contact's `length` [m] is known, a force in N is divided by it.

    Parameters
    ----------
    value, name
        As in `quantity`; a bare number is in N/m.
    length : float or None
        Length of the contact [m].

    Raises
    ------
    InvalidValueError
        As `quantity`; a force in N over a length that is not known.

    Examples
    --------
    >>> line_load("0.5 N", 0.02, "force"), line_load("25 N/m", 0.02, "force"), line_load("25 N/m", None, "force")
    (25.0, 25.0, 25.0)
    """
    match = _NUMBER.fullmatch(value) if isinstance(value, str) and len(value) <= 100 else None
    if length is not None and match is not None and match[2] and si_unit(match[2], name) == "N":
        return quantity(value, "N", name) / length
    return quantity(value, "N/m", name)


def line_load_scale(text: object, length: float | None) -> float:
    """What one count of a column of forces is worth [N/m]; forces in N are divided by the contact's `length` [m].

    Raises
    ------
    InvalidValueError
        As `unit_scale`; a unit of force where the length is not known.

    Examples
    --------
    >>> line_load_scale("mN", 0.02), line_load_scale("N/m", None)
    (0.05, 1.0)
    """
    whole = length is not None and si_unit(text, "unit") == "N"
    return unit_scale(text, "N", "unit") / length if whole and length is not None else unit_scale(text, "N/m", "unit")


def si_unit(text: object, name: str) -> str:
    """The SI unit of the dimension of `text`, which is a unit or a multiple of one.

    Examples
    --------
    >>> si_unit("psi", "unit"), si_unit("0.1 mV", "unit")
    ('Pa', 'V')
    """
    return _si_name(_counted(text, name)[1], name)


def _counted(text: object, name: str) -> tuple[float, str]:
    """The number before a unit (1 if there is none) and what should be a unit."""
    seen, fix = f"{name} = {_short(text)}", 'write e.g. "mm", "1e-3 mm" or "1/320 mm"'
    if not isinstance(text, str) or len(text) > 100:
        raise InvalidValueError(seen, "a unit is needed", fix)
    match = _COUNT.fullmatch(text)
    if match is None:
        return 1.0, text.strip()
    try:
        number = float(match[1]) / float(match[2] or 1)
    except ZeroDivisionError:
        number = 0.0
    if number == 0 or not math.isfinite(number):
        raise InvalidValueError(seen, "the number before the unit has to be finite and not 0", fix)
    return number, match[3]


def _si_name(text: str, name: str) -> str:
    """The SI unit of the dimension of the unit that `text` names."""
    plain = next((si for si, units in _PLAIN.items() if text in units and si in _SI), None)
    if plain is not None:
        return plain
    unit, registry = _unit(text, name), _registry()
    if unit.dimensionless:
        return ""
    for name in _SI:
        if registry.parse_units(name).dimensionality == unit.dimensionality:
            return name
    return f"{registry.get_base_units(unit)[1]:~C}"


def format_quantity(value: float, unit: str) -> str:
    """`value` in the SI `unit` as text in the unit that people use for it, to nine digits.

    Examples
    --------
    >>> format_quantity(0.0054, "m"), format_quantity(4e5, "Pa")
    ('5.4 mm', '0.4 MPa')
    """
    from .. import _check  # here, so that who only converts a text need not load NumPy

    value = _check.scalar("value", value, finite=False)
    _check.noun("unit", unit, str, 'unit="m"')
    scale, name = {"m": (1e-3, "mm"), "Pa": (1e6, "MPa"), "rad": (math.pi / 180, "deg")}.get(unit, (1.0, unit))
    return f"{value / scale:.9g} {name}".strip()


def rounded(value: float) -> float:
    """`value` without the last digits of rounding."""
    return float(f"{value:.9g}")


def _short(value: object) -> str:
    text = f'"{value}"' if isinstance(value, str) else repr(value)
    return text if len(text) <= 60 else text[:57] + "..."
