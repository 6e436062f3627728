"""Readings under many loads at once, in pieces that an executor can share out."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import partial

import numpy as np
import numpy.typing as npt

from .. import _check
from .._check import FloatArray
from .._tasks import Executor, run_tasks
from ..contact import Contact, LocalContact
from ..errors import GeometryError, InvalidValueError
from ..finger import Finger, finger_needed

__all__ = ["measured", "simulate_readings"]

_BLOCK = 5000
"""Loads in a piece: the same for one process and for many, so that the numbers are the same to the last bit."""


def simulate_readings(
    finger: Finger,
    contact: Callable[..., Contact | LocalContact],
    loads: Mapping[str, npt.ArrayLike],
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
    finger_needed(finger)
    if not isinstance(loads, Mapping):
        fix = 'loads={"force": np.full(1000, 40.0)}'
        raise InvalidValueError(f"loads = {_check.shown(loads)}", "arrays by the names of parameters are needed", fix)
    if progress is not None and not callable(progress):
        raise InvalidValueError(f"progress = {_check.shown(progress)}", "a function is needed", "progress=None")
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
