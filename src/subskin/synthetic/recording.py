"""Readings under many loads at once, and a raw recording as an indenter on a real skin would give it, computed."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import partial
from typing import Annotated, Any, TypeAlias

import numpy as np
import numpy.typing as npt

from .. import _check
from .._axes import on_finger
from .._check import FloatArray
from .._declared import Angle, Fix, Length, Positive, Real, checked
from .._frozen import Frozen
from .._tasks import Executor, run_tasks
from ..contact import Contact, LineLoad, LocalContact
from ..errors import GeometryError, InvalidValueError
from ..finger import Finger
from ..stream.relaxation import Relaxation

__all__ = ["Recording", "measured", "simulate_readings", "simulate_recording"]

_BLOCK = 5000
"""Loads in a piece: the same for one process and for many, so that the numbers are the same to the last bit."""


@checked
def simulate_readings(
    finger: Finger,
    contact: Callable[..., Contact | LocalContact],
    loads: Annotated[Mapping[str, npt.ArrayLike], Fix('loads={"force": np.full(1000, 40.0)}')],
    *,
    rng: np.random.Generator | None = None,
    executor: Executor | None = None,
    progress: Callable[[int], object] | None = None,
) -> FloatArray:
    """Readings of `finger` under many loads, as by `Finger.read`; an executor shares the work out.

    Parameters
    ----------
    finger : Finger
        The skin and the sensors.
    contact : callable
        Makes the contacts from `loads`: a class of contacts, or `subskin.contact.contact_of`. For an executor in other
        processes it has to pickle.
    loads : mapping of str to array_like, shape (m,) or (m, ...)
        What `contact` takes by name, one a load: "force" [N/m], on an area [N], "angle" [rad], "position" [m], ...
    rng : numpy.random.Generator, optional
        Adds the noise, in this process; without it there is none.
    executor : executor, optional
        Anything with `submit` (docs/scale.md); without it this thread does the work. The readings are the same bits.
    progress : callable, optional
        Called with the number of loads that have been finished since the last call.

    Returns
    -------
    ndarray, shape (m, n)
        Readings [reading].

    Raises
    ------
    InvalidValueError, GeometryError
        Loads that are no numbers, or not one a load; what `contact` refuses.
    WorkersError
        The executor has lost its workers.

    Examples
    --------
    >>> import subskin as ss
    >>> skin = ss.HalfPlane(ss.Material(young=0.4e6))
    >>> finger = ss.Finger(skin, ss.SensorArray.line(count=4, pitch=2e-3, depth=2e-3, noise=1e-4))
    >>> loads = {"force": np.full(1000, 40.0), "position": np.linspace(-3e-3, 3e-3, 1000)}
    >>> simulate_readings(finger, ss.LineLoad, loads).shape
    (1000, 4)
    """
    each = {name: _check.real(name, values) for name, values in loads.items()}
    lengths = {values.shape[:1] for values in each.values()}
    if len(lengths) != 1 or () in lengths:
        seen = ", ".join(f"{name} of shape {values.shape}" for name, values in each.items()) or "no loads"
        raise GeometryError(seen, "one value a load is needed, of each the same number", "np.full(1000, 40.0)")
    if "position" in each and len(each["position"]):
        far = int(np.abs(each["position"]).reshape(len(each["position"]), -1).max(axis=1).argmax())
        finger.read(made(contact, {name: values[far] for name, values in each.items()}))  # warns of a unit forgotten
    values = measured(finger, contact, each, executor=executor, progress=progress)
    return finger.array.digitise(values, rng, made(contact, each).normal_force if finger.array.lifted else 0.0)


def measured(
    finger: Finger,
    contact: Callable[..., Contact | LocalContact],
    loads: Mapping[str, FloatArray],
    *,
    executor: Executor | None = None,
    progress: Callable[[int], object] | None = None,
) -> FloatArray:
    """What the transducers measure under the loads, (m, n), piece by piece; options as in `simulate_readings`.

    Examples
    --------
    >>> import subskin as ss
    >>> finger = ss.Finger(ss.HalfPlane(ss.Material(young=0.4e6)), ss.SensorArray(y=[0.0], depth=2e-3))
    >>> measured(finger, ss.LineLoad, {"force": np.full(3, 40.0)}).shape
    (3, 1)
    """
    count = len(next(iter(loads.values())))
    out = np.empty((count, len(finger.array)))
    tasks = [
        partial(_piece, finger, contact, {name: values[first : first + _BLOCK] for name, values in loads.items()})
        for first in range(0, count, _BLOCK)
    ]

    def keep(number: int, part: FloatArray) -> None:
        out[number * _BLOCK : number * _BLOCK + len(part)] = part
        if progress is not None:
            progress(len(part))

    if executor is None:
        for number, task in enumerate(tasks):
            keep(number, task())
    else:
        run_tasks(tasks, keep, executor=executor)
    return out


def _piece(
    finger: Finger, contact: Callable[..., Contact | LocalContact], loads: Mapping[str, FloatArray]
) -> FloatArray:
    return finger.measure(made(contact, loads))


def made(contact: Callable[..., Contact | LocalContact], loads: Mapping[str, FloatArray]) -> Contact | LocalContact:
    """The contact of these loads, where `contact` makes one of them."""
    try:
        return contact(**loads)
    except TypeError as error:
        seen = f"contact = {_check.shown(contact)}, of {', '.join(loads)}: {error}"
        rule = "a class of contacts is needed, or a function, with parameters of these names"
        raise InvalidValueError(seen, rule, "contact=subskin.LineLoad") from error


_TOUCH = 0.3  # share of the stroke at which the indenter meets the skin
_MOST_FRAMES = 10**8
_PERIODS = (0.9, 0.37)  # of the drift, in units of the recording
_Time: TypeAlias = Annotated[float, Real("s", above=0.0)]


@dataclass(frozen=True)
class Recording(Frozen):
    """Frames of a recording: `time` [s] and `press` [m] (m,), `position` [m] (m,) or (m, 2), `readings` (m, n).

    `force` (m,) is what a load cell on the indenter reads [N/m], on an area [N].
    """

    time: FloatArray
    position: FloatArray
    press: FloatArray
    readings: FloatArray
    force: FloatArray


@checked
def simulate_recording(
    finger: Annotated[Finger, Fix("Finger(skin, array)")],
    positions: Annotated[npt.ArrayLike, Real("m")],
    *,
    force: Annotated[float, Real("N/m", at_least=0.0)],
    contact: Callable[..., Contact | LocalContact] = LineLoad,
    angle: Angle = 0.0,
    origin: Annotated[Any, Real("m")] = 0.0,
    turn: Angle = 0.0,
    stroke: Length = 4e-3,
    ramp: _Time = 0.5,
    hold: _Time = 1.5,
    rest: _Time = 0.5,
    rate: Positive = 50.0,
    relaxation: Annotated[float, Real(at_least=0.0, at_most=0.99)] = 0.2,
    relaxation_time: _Time = 1.5,
    drift: Annotated[float, Real(at_least=0.0)] = 0.0,
    rng: np.random.Generator | None = None,
    executor: Executor | None = None,
    progress: Callable[[int], object] | None = None,
) -> Recording:
    """An indenter that steps along the skin and presses at each of `positions`.

    The skin is a standard linear solid: of a load that is held, the share `relaxation` is lost with the time constant
    `relaxation_time`; on release the reading falls below where it began and comes back as slowly.

    Parameters
    ----------
    finger : Finger
        The finger as it really is; its noise is added. A sensor of gain 0 reads only offset, noise and drift.
    positions : array_like, shape (k,) or (k, 2)
        Where the indenter presses, on its motor's axis, or axes (y, z) [m].
    force : float
        Load at the full stroke, before it relaxes [N/m], on an area [N].
    contact : callable, optional
        Makes the contact from force, angle and position; see `subskin.contact.contact_of`.
    angle : float, optional
        Angle of the load [rad].
    origin, turn : float or (float, float), and float, optional
        Where the finger's y = 0 lies on the motor's axis [m]; on an area its (0, 0), and how far it is turned [rad].
    stroke : float, optional
        How far the indenter goes down [m]; it meets the skin at 30 % of that.
    ramp, hold, rest : float, optional
        Time on the way down (and up), on the plateau, and at rest between presses [s].
    rate : float, optional
        Frames per second [Hz].
    relaxation, relaxation_time : float, optional
        Share of the load that is lost, in [0, 1), and its time constant [s].
    drift : float, optional
        Size of a slow drift, each sensor its own, in the unit of the readings.
    rng : numpy.random.Generator, optional
        For noise and drift; without it there is no noise, and drift is the same each time.
    executor, progress : executor and callable, optional
        As in `simulate_readings`, of the frames in which the skin is touched.

    Returns
    -------
    Recording

    Raises
    ------
    InvalidValueError, GeometryError
        A value out of range; an origin that does not go with the positions.
    WorkersError
        The executor has lost its workers.

    Examples
    --------
    >>> import subskin as ss
    >>> skin = ss.HalfPlane(ss.Material(young=0.4e6))
    >>> finger = ss.Finger(skin, ss.SensorArray.line(count=4, pitch=6e-3, depth=5e-3, gain=-1e5, offset=1e5))
    >>> raw = simulate_recording(finger, [0.0, 1e-3], force=40.0)
    >>> raw.readings.shape, float(raw.position[-1]), float(raw.press.max())
    ((325, 4), 0.001, 0.004)
    """
    y, middle = np.atleast_1d(positions), np.asarray(origin)
    if not len(y) or y.shape not in ((len(y),), (len(y), 2)) or middle.shape != y.shape[1:]:
        seen = f"positions of shape {y.shape}, an origin of shape {middle.shape}"
        raise GeometryError(seen, "shapes (k,) and (), or (k, 2) and (2,), are needed", "origin=(0.0, 0.0)")
    own = on_finger(y, middle, turn)
    # one press: rest, down, hold, up; a last rest at the end
    corners = np.cumsum([0.0, rest, ramp, hold, ramp])
    if not (corners[-1] * len(y) + rest) * rate <= _MOST_FRAMES:
        seen = f"{len(y)} presses of {corners[-1]:.6g} s at {rate:.6g} Hz"
        raise InvalidValueError(seen, f"at most {_MOST_FRAMES} frames are simulated", "shorter ones, or a lower rate")
    frames = round((corners[-1] * len(y) + rest) * rate)
    time = np.arange(frames) / rate
    which = np.minimum((time / corners[-1]).astype(int), len(y) - 1)
    press = stroke * np.interp(time - which * corners[-1], [*corners, corners[-1] + rest], [0, 0, 1, 1, 0, 0])
    load = force * np.clip((press / stroke - _TOUCH) / (1 - _TOUCH), 0.0, None)
    rubber = Relaxation([relaxation], [relaxation_time], rest=0.0)
    felt = rubber.apply(load[:, None], time)[:, 0]
    array = finger.array
    # drift adds before the range and the resolution do their part
    unbounded = replace(array, low=-np.inf, high=np.inf, resolution=0.0)
    moving = felt != 0
    felt_by = np.zeros((frames, len(array)))
    loads = {"force": np.abs(felt[moving]), "angle": np.full(moving.sum(), angle), "position": own[which[moving]]}
    felt_by[moving] = measured(finger, contact, loads, executor=executor, progress=progress)
    values = np.where((felt < 0)[:, None], _recoil(finger, felt_by), felt_by)
    pressed = np.maximum(felt, 0.0) * np.cos(angle)
    readings = unbounded.digitise(values, rng, pressed) + drift * _drift(frames, len(array), rng)
    bounds = replace(array, gain=1.0, lift=0.0, offset=0.0)
    cell = np.where(load > 0, np.maximum(felt, 0.0), 0.0)  # of what a skin still feels when let go, it reads nothing
    return Recording(time, y[which], press, bounds.digitise(readings), cell)


def _recoil(finger: Finger, values: FloatArray) -> FloatArray:
    """What is measured after a press: a load turned round, felt by linear transducers only."""
    linear = np.array([kind.linear for kind in finger.array.transducers])
    return np.where(linear, -values, 0.0)


def _drift(frames: int, sensors: int, rng: np.random.Generator | None) -> FloatArray:
    """Slow, smooth, of each sensor its own, of size about 1, and 0 at the start."""
    source: Any = np.random.default_rng(0) if rng is None else rng
    phase = source.uniform(0, 2 * np.pi, (len(_PERIODS), sensors))
    size = source.normal(0, 0.6, (len(_PERIODS), sensors))
    t = np.linspace(0, 1, frames)[:, None]
    waves = [s * (np.sin(2 * np.pi * t / p + q) - np.sin(q)) for s, p, q in zip(size, _PERIODS, phase, strict=True)]
    return np.asarray(sum(waves))
