"""Input checked once, at the door: ints become floats, copies are taken, rules are enforced with a readable message."""

from __future__ import annotations

import sys
import warnings
from collections.abc import Iterable, Mapping
from typing import Any, TypeAlias, TypedDict, Unpack

import numpy as np
import numpy.typing as npt

from .errors import GeometryError, InvalidValueError, UnknownOptionError, ValidityWarning, printable

FloatArray: TypeAlias = npt.NDArray[np.float64]
ComplexArray: TypeAlias = npt.NDArray[np.complex128]

LARGEST, SMALLEST = 1e75, 1e-75
"""Magnitudes between which a number lies, or above 0: its fourth power, and one over that, are floats still."""

_PASSED = {__name__.partition(".")[0], "numpy", *sys.stdlib_module_names}
_STICKIEST = 10.0  # coefficient of friction beyond any rubber's
_SHOWN = 80  # letters of a value in a message
_NO_NUMBERS = "bSUMmc"
"""Kinds of arrays that NumPy would take for numbers: truths, text, dates, complex ones without their imaginary part."""


class NumberBounds(TypedDict, total=False):
    """What bounds a number, whether it has to be finite (it has), and what an error proposes."""

    above: float | None
    at_least: float | None
    at_most: float | None
    finite: bool
    fix: str


class NumberLimits(NumberBounds, total=False):
    """The same, and its SI unit."""

    unit: str


def real(name: str, value: npt.ArrayLike, **limits: Unpack[NumberLimits]) -> FloatArray:
    """`value` as a read-only float array that is not the caller's own, within the stated limits and those of all.

    A quantity of pint is converted to the unit; one of another dimension is refused.
    """
    plain = type(value) in (float, np.float64) or (type(value) is np.ndarray and value.dtype == np.float64)
    array = np.array(value) if plain else _floats(name, value, limits.get("unit", ""), limits.get("fix", ""))
    above, at_least, at_most = limits.get("above"), limits.get("at_least"), limits.get("at_most")
    low = -LARGEST if at_least is None else at_least
    low = low if above is None else max(low, above or SMALLEST)
    usual = array.size and low < np.minimum.reduce(array, axis=None)
    if not (usual and np.maximum.reduce(array, axis=None) <= (LARGEST if at_most is None else at_most)):
        _keep(name, array, limits)
    array.flags.writeable = False
    return array


def _keep(name: str, array: FloatArray, limits: NumberLimits) -> None:
    """Refuse the first number that is out of bounds; one that is not finite passes where it need not be."""
    if not array.size:
        return
    above, at_least, at_most = limits.get("above"), limits.get("at_least"), limits.get("at_most")
    least, most = np.minimum.reduce(array, axis=None), np.maximum.reduce(array, axis=None)  # NaN where one is NaN

    def refuse(good: npt.NDArray[np.bool_], bound: str) -> None:
        if not np.all(good):
            rule = f"has to be {bound}" + (f" [{unit}]" if (unit := limits.get("unit")) else "")
            raise InvalidValueError(_seen(name, array, ~np.asarray(good)), rule, limits.get("fix", ""))

    if not -LARGEST <= least <= most <= LARGEST:
        known = np.isfinite(array)
        if limits.get("finite", True):
            refuse(known, "finite")
        refuse(~known | (np.abs(array) <= LARGEST), f"at most {LARGEST:g} in magnitude")
    if above is not None and not least > above:
        refuse(array > above, f"> {above:g}")
    if above == 0.0 and at_most is None and not least >= SMALLEST:  # a share, or a chance, may be as small as it likes
        refuse(array >= SMALLEST, f"at least {SMALLEST:g}")
    if at_least is not None and not least >= at_least:
        refuse(array >= at_least, f">= {at_least:g}")
    if at_most is not None and not most <= at_most:
        refuse(array <= at_most, f"<= {at_most:g}")


def _seen(name: str, array: FloatArray, bad: npt.NDArray[np.bool_]) -> str:
    """`name = value`, with the index of the first offender where the value is an array."""
    if array.ndim == 0:
        return f"{name} = {float(array):.6g}"
    where = tuple(int(i) for i in np.argwhere(bad)[0])
    return f"{name}[{', '.join(map(str, where))}] = {array[where]:.6g}"


def _floats(name: str, value: Any, unit: str, fix: str) -> FloatArray:
    """A copy of what is given, in floats."""
    value = without_unit(name, value, unit, fix)
    unmasked(name, value)
    try:
        if np.asarray(value).dtype.kind in _NO_NUMBERS:
            raise TypeError
        return np.array(value, dtype=np.float64)
    except OverflowError:
        raise InvalidValueError(f"{name} = {shown(value)}", "it is beyond the largest float", fix) from None
    except (TypeError, ValueError):
        rule = "a real number or an array of them is needed"
        raise InvalidValueError(f"{name} = {shown(value)}", rule, fix) from None


def readings(value: npt.ArrayLike, name: str = "readings") -> FloatArray:
    """Readings as floats: NaN where one is missing, or masked. Not copied where they are floats already."""
    if type(value) is np.ndarray and value.dtype == np.float64:
        return value
    value = without_unit(name, value, "", 'numbers in the unit of the gain: q.m_as("Pa")')
    try:
        if np.asarray(value).dtype.kind in _NO_NUMBERS:
            raise TypeError
        if isinstance(value, np.ma.MaskedArray):
            return np.ma.filled(value.astype(np.float64), np.nan)
        return np.asarray(value, dtype=np.float64)
    except OverflowError:
        raise InvalidValueError(f"{name} = {shown(value)}", "it is beyond the largest float") from None
    except (TypeError, ValueError):
        rule = "real numbers are needed, NaN for a missing one"
        raise InvalidValueError(f"{name} = {shown(value)}", rule, f"{name}=[0.1, 0.2]") from None


def unmasked(name: str, value: object, fix: str = "") -> None:
    """Refuse a masked array with values that are masked: NumPy would take what is behind the mask."""
    if isinstance(value, np.ma.MaskedArray) and np.ma.is_masked(value):
        seen = f"{name} with {int(np.ma.getmaskarray(value).sum())} masked values"
        raise InvalidValueError(seen, "only readings can be missing", fix or f"{name}.compressed()")


def noun(name: str, value: Any, kind: type | tuple[type, ...], fix: str) -> Any:
    """One of the nouns that are needed; another thing is refused, and the class instead of one of it."""
    if not isinstance(value, kind):
        kinds = " or ".join(one.__name__ for one in (kind if isinstance(kind, tuple) else (kind,)))
        raise InvalidValueError(f"{name} = {shown(value)}", f"a{'n' * (kinds[0] in 'AEIOU')} {kinds} is needed", fix)
    return value


def choice(name: str, value: Any, known: Iterable[str], fix: str = "") -> Any:
    """One of the `known` texts; all else is refused, be it no text at all: an array has no single answer to `==`."""
    names = tuple(known)
    if not isinstance(value, str) or value not in names:
        import difflib

        near = difflib.get_close_matches(value, names, n=1) if isinstance(value, str) else ()
        listed = [f'"{one}"' for one in names]
        rule = f"has to be {' or '.join(filter(None, (', '.join(listed[:-1]), listed[-1])))}"
        meant = f'{name}="{near[0]}"' if near else fix or f'{name}="{names[0]}"'
        raise InvalidValueError(f"{name} = {shown(value)}", rule, meant)
    return value


def several(name: str, values: Any, kind: type, fix: str) -> tuple[Any, ...]:
    """Several things of one `kind`, as a tuple; a text is none of several."""
    try:
        each = () if isinstance(values, str | bytes) else tuple(values)
    except TypeError:
        each = (None,)
    if (isinstance(values, str | bytes) and values) or [one for one in each if not isinstance(one, kind)]:
        rule = f"a list is needed, each of it a {kind.__name__}"
        raise InvalidValueError(f"{name} = {shown(values)}", rule, fix)
    return each


def returned(said: str, values: Any, shape: tuple[int, ...], *, exactly: bool = False) -> Any:
    """What a method of somebody else's class gave: numbers that NumPy can spread over `shape`.

    Where they have to be of that shape `exactly`, real ones are spread over it.
    """
    if type(values) is np.ndarray and values.shape == shape and values.dtype == np.float64:
        return values
    try:
        array = np.asarray(values)
        fits = array.dtype.kind in ("biuf" if exactly else "biufc") and np.broadcast_shapes(array.shape, shape) == shape
    except ValueError:  # rows of different lengths, or a shape that does not go with the other
        fits = False
    if not fits:
        gave = f"an array of shape {values.shape}" if isinstance(values, np.ndarray) else shown(values)
        rule = f"{'real ' * exactly}numbers of the shape {shape} are needed"
        raise InvalidValueError(f"{said} gave {gave}", rule, "return what NumPy makes of the arguments")
    return np.broadcast_to(array, shape) if exactly else array


def of_sensors(sensors: Any, count: int) -> npt.NDArray[np.intp]:
    """Indices, or a mask, of some of `count` sensors, as a row of indices."""
    rule, fix = f"indices from 0 to {count - 1} are needed, or a mask of shape ({count},)", "sensors=[0, 2]"
    try:
        index: npt.NDArray[np.intp] = np.arange(count)[np.asarray(sensors)]
    except (IndexError, ValueError):
        raise InvalidValueError(f"sensors = {shown(sensors)}", rule, fix) from None
    if index.ndim != 1:
        raise GeometryError(f"sensors of shape {np.shape(sensors)}", "a row of indices is needed", fix)
    return index


def flag(name: str, value: object) -> bool:
    """Yes or no: an array is neither, and a text is always yes in Python."""
    if not isinstance(value, bool | np.bool_):
        raise InvalidValueError(f"{name} = {shown(value)}", "True or False is needed", f"{name}=True")
    return bool(value)


def function(name: str, value: Any) -> Any:
    """What can be called, or None, which is left out."""
    if value is not None and not callable(value):
        raise InvalidValueError(f"{name} = {shown(value)}", "a function is needed", f"leave out {name}")
    return value


def random(rng: object) -> np.random.Generator:
    """A source of random numbers, or the one that a seed makes."""
    if isinstance(rng, np.random.Generator):
        return rng
    if not isinstance(rng, int | np.integer) or isinstance(rng, bool) or rng < 0:
        raise InvalidValueError(f"rng = {shown(rng)}", "a seed >= 0 or a Generator is needed", "rng=0")
    return np.random.default_rng(int(rng))


def generator(rng: object) -> None:
    """Refuse what is no source of random numbers; None is one that is left out."""
    if rng is not None:
        noun("rng", rng, np.random.Generator, "rng=np.random.default_rng(0)")


def without_unit(name: str, value: Any, unit: str, fix: str = "") -> Any:
    """A quantity of pint, or a list of them, as numbers in the SI `unit`; anything else as it is.

    Examples
    --------
    >>> import pint
    >>> without_unit("depth", pint.UnitRegistry().Quantity(2.0, "mm"), "m")
    0.002
    """
    if isinstance(value, list | tuple):
        if set(map(type, value)) <= {float, int} or not any(_has_unit(item) for item in value):
            return value
        return [without_unit(f"{name}[{i}]", item, unit, fix) for i, item in enumerate(value)]
    if value is None or isinstance(value, float | int | np.ndarray) or not _has_unit(value):
        return value
    try:
        return value.to(unit).magnitude
    except Exception:  # pint lets many kinds of error through
        rule = f"a quantity in {unit} is needed" if unit else "a plain number is needed: no unit is known for it"
        raise InvalidValueError(f"{name} = {shown(value)}", rule, fix) from None


def _has_unit(value: object) -> bool:
    """Whether it is a quantity of pint, which need not be imported for that; or a list that begins with one."""
    if isinstance(value, list | tuple):
        return bool(value) and _has_unit(value[0])
    return not isinstance(value, float | int | np.ndarray) and hasattr(value, "magnitude") and hasattr(value, "units")


def shown(value: object) -> str:
    """A value as a message has it, its end left off where it is long, be it one that cannot be written out."""
    try:
        return printable(" ".join(part.strip() for part in repr(value).splitlines()), _SHOWN)
    except Exception:  # an int of more digits than Python writes, or an object whose own way fails
        return f"a {type(value).__name__}"


def doubt(name: str, value: float, unit: str, meant: float, meant_unit: str) -> None:
    """Warn of a value so far from any finger's that another unit was probably meant, which is `meant` in `unit`."""
    said = f"{name} = {value:.6g} {unit}: if {value:.6g} {meant_unit} was meant, write {value * meant:.6g}."
    warn(f"{said} Values are in {unit}")


def warn(message: str, category: type[Warning] = ValidityWarning) -> None:
    """Warn at the caller's line: the nearest one that is neither of this package nor of what it calls itself through.

    Python 3.12 has `skip_file_prefixes` for that; dataclasses and caches write frames of their own between.
    """
    frame, level = sys._getframe(), 1
    while frame.f_back and frame.f_globals.get("__name__", "").partition(".")[0] in _PASSED:
        frame, level = frame.f_back, level + 1
    warnings.warn(message, category, stacklevel=level)


def scalar(name: str, value: npt.ArrayLike, **limits: Unpack[NumberLimits]) -> float:
    """Like `real`, for a value that has to be a single number."""
    array = real(name, value, **limits)
    if array.ndim:
        raise InvalidValueError(f"{name} of shape {array.shape}", "a single number is needed", limits.get("fix", ""))
    return float(array)


def friction(value: npt.ArrayLike) -> float:
    """A coefficient of friction, which may be infinite; one too small to be squared is none."""
    found = scalar("friction", value, at_least=0.0, finite=False, fix="friction=1.0")
    no_degrees("friction", found)
    return found if found >= SMALLEST else 0.0


def no_degrees(name: str, value: npt.ArrayLike) -> None:
    """Warn of coefficients of friction that were meant as angles in degrees."""
    array = np.asarray(value)
    large = array[(array > _STICKIEST) & np.isfinite(array)]
    if large.size:
        meant = f"of an angle of friction in degrees it is np.tan(np.deg2rad({large.flat[0]:.6g}))"
        warn(f"{name} = {large.flat[0]:.6g} is a coefficient, and rubber has 0.3 to 3: {meant}")


def read_only(values: npt.ArrayLike) -> FloatArray:
    """The same values as a float array that is closed to writing; no copy is made of one."""
    array = np.asarray(values, dtype=np.float64)
    array.setflags(write=False)
    return array


def each_read_only(*values: npt.ArrayLike) -> list[FloatArray]:
    """Several values, each as by `read_only`."""
    return [read_only(value) for value in values]


def broadcast(**arrays: FloatArray) -> tuple[int, ...]:
    """The common shape of the arrays; an error gives each one's."""
    try:
        return np.broadcast_shapes(*[a.shape for a in arrays.values()])
    except ValueError:
        seen = ", ".join(f"{name} {a.shape}" for name, a in arrays.items())
        raise GeometryError(
            f"shapes {seen}", "they have to broadcast as in NumPy", "an axis of length 1, such as y[:, None]"
        ) from None


def for_each(name: str, array: FloatArray, count: int, what: str) -> FloatArray:
    """One number for all, or one for each of `count` things of the kind `what`, as an array (count,)."""
    if array.shape not in ((), (1,), (count,)):
        rule = f"one number is needed, or one for each {what}, of which there are {count}"
        raise GeometryError(f"{name} of shape {array.shape}", rule, f"shape ({count},)")
    return np.broadcast_to(array, (count,))


def ends(name: str, value: object, fix: str) -> tuple[float, float] | None:
    """Two numbers as a pair that can be a key, or None; whether they ascend is for others to say."""
    if value is None:
        return None
    if type(value) is tuple and len(value) == 2 and type(value[0]) is type(value[1]) is float:
        return value  # the usual case, in no time
    return pair(name, value, fix, "m")


def pair(name: str, value: object, fix: str, unit: str = "") -> tuple[float, float]:
    """Two numbers in the SI `unit`; whether they ascend is for others to say."""
    value = without_unit(name, value, unit, fix)
    unmasked(name, value)
    try:
        both = np.asarray(value)
    except ValueError:  # rows of different lengths
        both = np.empty(0)
    if both.shape != (2,) or both.dtype.kind not in "iuf":
        raise InvalidValueError(f"{name} = {shown(value)}", "two ascending numbers are needed", fix)
    return float(both[0]), float(both[1])


def values(**options: Any) -> dict[str, float | None]:
    """Options as numbers that can be a key: a number of any kind as a float, or as an int where it is one."""
    plain = dict(options)
    for name, given in options.items():
        if given is None or type(given) is float:
            continue  # the usual case, in no time
        plain[name] = given = without_unit(name, given, "m" if name == "scan_step" else "")
        unmasked(name, given)
        try:
            number = given is None or (np.asarray(given).ndim == 0 and np.asarray(given).dtype.kind in "biuf")
        except ValueError:  # rows of different lengths
            number = False
        if not number:
            raise InvalidValueError(f"{name} = {shown(given)}", "a single number is needed", f"{name}=1.0")
        plain[name] = np.asarray(given).item()
    return plain


def whole(name: str, value: object, *, at_least: int, at_most: int, fix: str = "") -> int:
    """A whole number within its limits."""
    fits = isinstance(value, int | float | np.integer | np.floating) and not isinstance(value, bool | np.timedelta64)
    if not fits or not at_least <= value <= at_most or value != int(value):  # type: ignore[operator, call-overload]
        rule = f"a whole number from {at_least} to {at_most} is needed"
        raise InvalidValueError(f"{name} = {shown(value)}", rule, fix)
    return int(value)  # type: ignore[call-overload, no-any-return]


def no_options(unknown: Mapping[str, object], known: str, of: str = "") -> None:
    """Refuse options that do not exist, and say which do; `of` is what they were given to."""
    for name in unknown:
        import difflib

        near = difflib.get_close_matches(name, known.split(", "), n=1)
        seen = f"option {name!r} of {of}" if of else f"option {name!r}"
        raise UnknownOptionError(seen, f"there are {known}", f"{near[0]}=..." if near else "")
