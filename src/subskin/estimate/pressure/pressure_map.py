"""The pressure found in readings, along a row or on an area, by a mapper that is prepared once and kept."""

from __future__ import annotations

from typing import Any, Never

import numpy.typing as npt

from ... import _check
from ...finger import Finger, finger_needed
from ...prepared import prepared
from ..area.search import search_of
from .image import PressureImage
from .map import PressureMap
from .mapper import ImageMapper, PressureMapper
from .mapping import known

__all__ = ["pressure_map", "pressure_mapper"]


def pressure_map(
    finger: Finger,
    readings: npt.ArrayLike,
    *,
    search: tuple[Any, Any] | None = None,
    step: float | None = None,
    shear: str = "proportional",
    friction: float = 1.0,
    rule: str = "evidence",
    least_force: float = 0.3,
    false_alarm: float = 1e-6,
    **_unknown: Never,
) -> PressureMap | PressureImage:
    """The pressure along a row, or on an area, in readings of shape (..., n), and the shear where the array can see it.

    The mapper is prepared on the first call and kept with the finger.

    Parameters
    ----------
    finger : Finger
        The skin and the sensors in it.
    readings : array_like, shape (..., n)
        Raw readings, each in units of its gain; NaN marks a missing one.
    search, step, shear, friction, rule, least_force, false_alarm
        As in `PressureMapper`; on an area as in `ImageMapper`.

    Returns
    -------
    PressureMap or PressureImage
        Pressure, shear, their bands, totals, resolution, residual, status; an image where the sensors are on an area.

    Raises
    ------
    InvalidValueError, GeometryError, NotLinearError
        As in `PressureMapper` and `ImageMapper`.

    Examples
    --------
    >>> import numpy as np, subskin as ss
    >>> skin = ss.HalfPlane(ss.Material(young=0.4e6))
    >>> finger = ss.Finger(skin, ss.SensorArray.line(count=25, pitch=0.5e-3, depth=2e-3, noise=2e-5))
    >>> roller = ss.Hertz(force=40.0, half_width=2e-3)
    >>> found = ss.pressure_map(finger, finger.read(roller, rng=np.random.default_rng(0)))
    >>> ss.Status(found.status).name, round(float(found.normal_force), 1)
    ('OK', 40.0)
    >>> true = roller.pressure(found.y)
    >>> bool(np.linalg.norm(found.pressure - true) < 0.1 * np.linalg.norm(true))
    True
    >>> array = ss.SensorArray.grid(shape=(6, 6), pitch=2e-3, depth=2e-3, transducer=ss.MeanPressure(), noise=20.0)
    >>> pad = ss.Finger(ss.HalfSpace(ss.Material(young=0.4e6)), array)
    >>> tip = ss.RoundHertz(force=2.0, position=(1e-3, 0.5e-3), half_width=2e-3)
    >>> image = ss.pressure_map(pad, pad.read(tip, rng=np.random.default_rng(0)), shear="none")
    >>> image.pressure.shape, round(float(image.normal_force), 1), (1e3 * image.centre).round(1).tolist()
    ((25, 25), 2.0, [1.0, 0.5])
    """
    finger_needed(finger)
    _check.no_options(_unknown, "search, step, shear, friction, rule, least_force, false_alarm")
    known(shear, rule)
    ends: Any
    if finger.array.on_area:
        ends = None if search is None else tuple(map(tuple, search_of(finger.array, search)[0].tolist()))
    else:
        ends = _check.ends("search", search, "search=(-5e-3, 5e-3)")
    numbers: dict[str, Any] = _check.values(
        step=step, friction=friction, least_force=least_force, false_alarm=false_alarm
    )

    def make() -> PressureMapper | ImageMapper:
        return pressure_mapper(finger, search=ends, shear=shear, rule=rule, **numbers)

    return prepared(finger).get(("pressure", ends, shear, rule, *numbers.values()), make)(readings)


def pressure_mapper(finger: Finger, **options: Any) -> PressureMapper | ImageMapper:
    """The mapper of a finger's kind: `ImageMapper` where the sensors are on an area, else `PressureMapper`.

    Parameters
    ----------
    finger : Finger
        The skin and the sensors in it.
    **options
        As of these.

    Raises
    ------
    InvalidValueError, GeometryError, NotLinearError
        As these.

    Examples
    --------
    >>> import subskin as ss
    >>> skin = ss.HalfPlane(ss.Material(young=0.4e6))
    >>> finger = ss.Finger(skin, ss.SensorArray.line(count=13, pitch=1e-3, depth=2e-3, noise=2e-5))
    >>> type(pressure_mapper(finger, shear="none")).__name__
    'PressureMapper'
    """
    return ImageMapper(finger, **options) if finger.array.on_area else PressureMapper(finger, **options)
