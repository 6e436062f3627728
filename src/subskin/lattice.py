"""Positions that are set out evenly: in a row, on a grid, on a hexagonal grid; and what a person calls them."""

from __future__ import annotations

import functools
import inspect
from collections.abc import Callable, Sequence
from dataclasses import fields
from typing import Any, Literal, Self, TypeVar, cast

import numpy as np
import numpy.typing as npt

from . import _check
from ._check import FloatArray
from .errors import GeometryError, InvalidValueError
from .transducer import NormalStrain, Transducer

__all__ = ["LaidOut", "even_grid", "even_row", "named_layout"]

_MOST = 10_000  # sensors in an array
_SAME = 1e-6  # pitches: closer points are one
_Make = TypeVar("_Make", bound=Callable[..., Any])


def _checked(make: _Make) -> _Make:
    """A misspelt or a missing argument is said with the name of the public class, and of the argument it is like."""
    signature = inspect.signature(make)
    named = [name for name in signature.parameters if name not in ("cls", "parameters")]

    @functools.wraps(make)
    def checked(cls: Any, *values: Any, **given: Any) -> Any:
        called = f"{cls.__name__}.{make.__name__}"
        known = named + [f.name for f in fields(cls) if f.name not in (*named, "y", "z")]
        if unknown := {name: value for name, value in given.items() if name not in known}:
            _check.no_options(unknown, ", ".join(known), called)
        try:
            signature.bind(cls, *values, **given)
        except TypeError as error:
            raise TypeError(f"{called}: {error}") from None
        return make(cls, *values, **given)

    return cast(_Make, checked)


def even_row(count: int, pitch: float, centre: float = 0.0) -> FloatArray:
    """Positions y [m] of `count` sensors, shape (count,), `pitch` [m] apart about `centre` [m].

    Raises
    ------
    InvalidValueError
        count < 1 or > 10,000, or pitch <= 0.

    Examples
    --------
    >>> even_row(3, pitch=2e-3).tolist()
    [-0.002, 0.0, 0.002]
    """
    sensors = _check.whole("count", count, at_least=1, at_most=_MOST)
    step = _check.scalar("pitch", pitch, unit="m", above=0.0)
    return np.asarray(_check.scalar("centre", centre, unit="m") + step * (np.arange(sensors) - (sensors - 1) / 2))


def even_grid(
    shape: tuple[int, int],
    pitch: npt.ArrayLike,
    centre: npt.ArrayLike = (0.0, 0.0),
    layout: Literal["grid", "hexagonal"] = "grid",
) -> FloatArray:
    """Positions (y, z) [m] of sensors on an area, shape (n, 2): those along z follow each other.

    On a hexagonal grid every second row along y is shifted by half a pitch, and rows are sqrt(3)/2 pitches apart: each
    sensor has six neighbours at the distance of the pitch.

    Parameters
    ----------
    shape : (int, int)
        Sensors along y and along z, n in all, up to 10,000.
    pitch : float or (float, float)
        Distance from one to the next [m], > 0; of a grid also one along y and one along z.
    centre : (float, float), optional
        Middle of the rectangle that holds them, (y, z) [m].
    layout : {"grid", "hexagonal"}, optional
        Which of the two.

    Raises
    ------
    InvalidValueError
        A shape that is not two counts, a pitch <= 0, another layout.

    Examples
    --------
    >>> even_grid((2, 2), pitch=2e-3).tolist()
    [[-0.001, -0.001], [-0.001, 0.001], [0.001, -0.001], [0.001, 0.001]]
    >>> even_grid((2, 2), pitch=2e-3, layout="hexagonal").round(6).tolist()
    [[-0.0015, -0.000866], [-0.0005, 0.000866], [0.0005, -0.000866], [0.0015, 0.000866]]
    """
    _check.choice("layout", layout, ("grid", "hexagonal"))
    if not isinstance(shape, Sequence | np.ndarray) or len(shape) != 2:
        rule = "two counts are needed, of sensors along y and along z"
        raise InvalidValueError(f"shape = {_check.shown(shape)}", rule, "shape=(4, 4)")
    counts = [
        _check.whole(f"shape[{i}]", n, at_least=1, at_most=_MOST, fix="shape=(4, 4)") for i, n in enumerate(shape)
    ]
    if counts[0] * counts[1] > _MOST:
        raise InvalidValueError(f"shape = {tuple(counts)}", f"at most {_MOST} sensors are possible", "shape=(4, 4)")
    steps, middle = _check.real("pitch", pitch, unit="m", above=0.0), _check.real("centre", centre, unit="m")
    if steps.shape not in ((), (2,)[: layout == "grid"]):
        rule = "one number is needed" + (", or one along y and one along z" if layout == "grid" else "")
        raise InvalidValueError(f"pitch of shape {steps.shape}", rule, "pitch=3e-3")
    if middle.shape != (2,):
        raise InvalidValueError(f"centre of shape {middle.shape}", "a position (y, z) is needed", "centre=(0.0, 0.0)")
    y, z = (np.arange(n) - (n - 1) / 2 for n in counts)
    at = np.stack(np.meshgrid(y, z, indexing="ij"), axis=-1)
    if layout == "hexagonal":
        at[..., 0] += np.where(np.arange(counts[1]) % 2, 0.25, -0.25) if counts[1] > 1 else 0.0
        at[..., 1] *= np.sqrt(0.75)
    return np.asarray((middle + steps * at).reshape(-1, 2))


def named_layout(y: FloatArray, z: FloatArray) -> str:
    """What a person calls the layout of points: "4 x 4 grid, pitch 3 mm", "3 x 5 hexagonal grid, ..."; "" of others.

    Parameters
    ----------
    y, z : ndarray, shape (n,)
        Positions [m], in any order; some may be there twice.

    Examples
    --------
    >>> named_layout(*even_grid((4, 3), pitch=(3e-3, 2e-3)).T)
    '4 x 3 grid, pitch 3 mm along y, 2 mm along z'
    >>> named_layout(*even_grid((3, 3), 1e-3, layout="hexagonal").T)
    '3 x 3 hexagonal grid, pitch 1 mm'
    """
    size = max(float(np.ptp(y)), float(np.ptp(z)))
    points = np.unique(np.round(np.stack([z, y], axis=-1) / (_SAME * size or 1.0)), axis=0) * (_SAME * size or 1.0)
    rows = np.unique(points[:, 0])
    count = len(points) // rows.size
    if count * rows.size != len(points) or len(points) < 2:
        return ""
    middle = 0.5 * (points.min(axis=0) + points.max(axis=0))[::-1]
    along = float(points[1, 1] - points[0, 1]) if count > 1 else 0.0
    across = float(rows[1] - rows[0]) if rows.size > 1 else along
    along = along or across
    if not (along > 0 and across > 0):
        return ""
    hexagons = even_grid((count, rows.size), along if count > 1 else across / np.sqrt(0.75), middle, "hexagonal")
    for found, name, pitch in (
        (even_grid((count, rows.size), (along, across), middle), "grid", (along, across)),
        (hexagons, "hexagonal grid", (along, along)),
    ):
        expected = found[np.lexsort(found.T)][:, ::-1]
        if np.abs(expected - points).max() < 10 * _SAME * size:
            apart = " along y, ".join(dict.fromkeys(f"{1e3 * step:.4g} mm" for step in pitch))
            return f"{count} x {rows.size} {name}, pitch {apart}{' along z' if 'along' in apart else ''}"
    return ""


class LaidOut:
    """The ways to lay out an array of sensors, which is made of y, z, depth, transducer and other parameters.

    Examples
    --------
    >>> from subskin import SensorArray
    >>> SensorArray.at([(0.0, 0.0), (2e-3, 1e-3)], depth=2e-3).points.tolist()
    [[0.0, 0.0], [0.002, 0.001]]
    """

    @classmethod
    @_checked
    def line(
        cls,
        count: int,
        pitch: float,
        depth: npt.ArrayLike,
        centre: float = 0.0,
        transducer: Transducer | Sequence[Transducer] | None = None,
        channels: Sequence[Transducer] | None = None,
        **parameters: npt.ArrayLike,
    ) -> Self:
        """Sensors in a row at equal distances.

        Parameters
        ----------
        count : int
            Number of positions, >= 1.
        pitch : float
            Distance from one to the next [m], > 0.
        centre : float, optional
            Position y of the middle of the row [m].
        depth, transducer, channels, **parameters
            As in `at`.

        Raises
        ------
        InvalidValueError, GeometryError
            count < 1 or pitch <= 0; a parameter out of range.

        Examples
        --------
        >>> from subskin import SensorArray
        >>> SensorArray.line(count=3, pitch=2e-3, depth=[1e-3, 2e-3, 1e-3])
        SensorArray(3 sensors, NormalStrain(), y = -0.002 to 0.002 m, depth = 0.001 to 0.002 m)
        """
        y = even_row(count, pitch, centre)
        return cls.at(np.stack([y, np.zeros_like(y)], axis=-1), depth, transducer, channels, **parameters)

    @classmethod
    @_checked
    def grid(
        cls,
        shape: tuple[int, int],
        pitch: npt.ArrayLike,
        depth: npt.ArrayLike,
        centre: npt.ArrayLike = (0.0, 0.0),
        transducer: Transducer | Sequence[Transducer] | None = None,
        channels: Sequence[Transducer] | None = None,
        **parameters: npt.ArrayLike,
    ) -> Self:
        """Sensors on a grid. Readings of one frame are `readings.reshape(shape)`, those along z beside each other.

        Parameters
        ----------
        shape : (int, int)
            Positions along y and along z.
        pitch : float or (float, float)
            Distance from one to the next [m], > 0; or one along y and one along z.
        centre : (float, float), optional
            The middle (y, z) of the grid [m].
        depth, transducer, channels, **parameters
            As in `at`.

        Raises
        ------
        InvalidValueError, GeometryError
            A shape that is not two counts, pitch <= 0; a parameter out of range.

        Examples
        --------
        >>> from subskin import SensorArray
        >>> SensorArray.grid(shape=(4, 4), pitch=3e-3, depth=3e-3)
        SensorArray(16 sensors, NormalStrain(), 4 x 4 grid, pitch 3 mm, depth = 0.003 m)
        """
        return cls.at(even_grid(shape, pitch, centre), depth, transducer, channels, **parameters)

    @classmethod
    @_checked
    def hexagonal(
        cls,
        shape: tuple[int, int],
        pitch: float,
        depth: npt.ArrayLike,
        centre: npt.ArrayLike = (0.0, 0.0),
        transducer: Transducer | Sequence[Transducer] | None = None,
        channels: Sequence[Transducer] | None = None,
        **parameters: npt.ArrayLike,
    ) -> Self:
        """Sensors each of which has six neighbours: rows along y, every second one shifted by half a pitch.

        Parameters
        ----------
        shape : (int, int)
            Positions in a row along y, and rows, sqrt(3)/2 pitches apart along z.
        pitch : float
            Distance of neighbours [m], > 0.
        centre : (float, float), optional
            The middle (y, z) of the rectangle that holds the sensors [m].
        depth, transducer, channels, **parameters
            As in `at`.

        Raises
        ------
        InvalidValueError, GeometryError
            As in `grid`.

        Examples
        --------
        >>> from subskin import SensorArray
        >>> SensorArray.hexagonal(shape=(4, 5), pitch=3e-3, depth=3e-3, noise=1e-4)
        SensorArray(20 sensors, NormalStrain(), 4 x 5 hexagonal grid, pitch 3 mm, depth = 0.003 m)
        """
        return cls.at(even_grid(shape, pitch, centre, "hexagonal"), depth, transducer, channels, **parameters)

    @classmethod
    @_checked
    def at(
        cls,
        points: npt.ArrayLike,
        depth: npt.ArrayLike,
        transducer: Transducer | Sequence[Transducer] | None = None,
        channels: Sequence[Transducer] | None = None,
        **parameters: npt.ArrayLike,
    ) -> Self:
        """Sensors at points of an area; or several channels at each of them.

        Parameters
        ----------
        points : array_like, shape (n, 2)
            Positions (y, z) [m].
        depth : array_like
            Depths [m], > 0.
        transducer : Transducer or sequence of n Transducers, optional
            What each measures; `NormalStrain()` if left out.
        channels : sequence of k Transducers, optional
            What is measured at each of the points, in place of `transducer`. There are n k sensors then, those of a
            point beside each other. Each parameter, the depth too, broadcasts to the shape (n, k): k values are one for
            each channel, values of the shape (n, 1) one for each point; n k values are one for each sensor.
        **parameters
            As in `SensorArray`.

        Raises
        ------
        InvalidValueError, GeometryError
            Points of another shape, parameters that do not broadcast, `transducer` beside `channels`.

        Examples
        --------
        What memo section 8 asks for: shear near the surface, strain along the depth, and how far the skin gives way.

        >>> from subskin import NormalStrain, SensorArray, ShearStrain
        >>> from subskin.transducer import Displacement
        >>> kinds = [ShearStrain("xy"), ShearStrain("xz"), NormalStrain(), Displacement("x")]
        >>> depths = [0.5e-3, 0.5e-3, 2e-3, 1e-3]
        >>> array = SensorArray.grid(shape=(3, 3), pitch=2e-3, depth=depths, channels=kinds)
        >>> len(array), array.depth[:5].tolist()
        (36, [0.0005, 0.0005, 0.002, 0.001, 0.0005])
        """
        at = _check.real("points", points, unit="m")
        if at.ndim != 2 or at.shape[1] != 2:
            rule = "a position (y, z) for each sensor is needed, shape (n, 2)"
            raise GeometryError(f"points of shape {at.shape}", rule, "points=[(-1e-3, 0.0), (1e-3, 0.0)]")
        if channels is None:
            kind = NormalStrain() if transducer is None else transducer
            return cls(  # type: ignore[call-arg]
                y=at[:, 0], z=at[:, 1], depth=depth, transducer=kind, **parameters
            )
        kinds = (
            (channels,)
            if isinstance(channels, Transducer)
            else _check.several("channels", channels, Transducer, "channels=(NormalStrain(), ShearStrain())")
        )
        if transducer is not None:
            raise InvalidValueError("transducer beside channels", "each says what is measured", "leave out one of them")
        each = (len(at), len(kinds))
        values = {
            name: _check.real(name, value, finite=False) for name, value in {"depth": depth, **parameters}.items()
        }
        for name, value in values.items():
            if value.shape == (len(at) * len(kinds),):
                values[name] = value.reshape(each)
            elif value.ndim > 2 or any(a not in (1, b) for a, b in zip(value.shape[::-1], each[::-1], strict=False)):
                rule = f"it has to broadcast to {each}, points and channels, or be one for each sensor"
                raise GeometryError(f"{name} of shape {value.shape}", rule, "one value, or one for each channel")
        spread = {name: np.broadcast_to(value, each).reshape(-1) for name, value in values.items()}
        return cls(  # type: ignore[call-arg]
            y=np.repeat(at[:, 0], each[1]), z=np.repeat(at[:, 1], each[1]), transducer=kinds * each[0], **spread
        )
