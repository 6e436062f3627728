"""What can be off in a finger as it is made, the finger that it then is, and the rows of a budget of tolerances."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Annotated, Any, Literal, NamedTuple, TypeAlias

import numpy as np

from ... import _check
from ..._check import FloatArray
from ..._declared import Fix, checked
from ...errors import InvalidValueError
from ...finger import Finger
from ...skin import Skin

__all__ = [
    "SOURCES", "TOLD", "Cost", "Needed", "Recovery", "Source", "as_made", "checked_tolerances", "of_each_sensor",
    "usual_tolerances",
]  # fmt: skip


class Source(NamedTuple):
    """A source of error: `unit` of its amount, what has a value of its own (`spread`), its name in words (`text`).

    Examples
    --------
    >>> SOURCES["depth"]
    Source(unit='m', spread='finger', text='depth of all')
    """

    unit: str
    spread: Literal["finger", "fixed", "sensor", "reading"]
    text: str


SOURCES = {
    "position": Source("m", "sensor", "each sensor's position"),
    "depth": Source("m", "finger", "depth of all"),
    "depths": Source("m", "sensor", "each sensor's depth"),
    "young": Source("", "finger", "Young's modulus"),
    "poisson": Source("", "finger", "Poisson's ratio"),
    "gain": Source("", "finger", "gain of all"),
    "gains": Source("", "sensor", "each sensor's gain"),
    "offset": Source("reading", "sensor", "each sensor's offset"),
    "width": Source("m", "fixed", "width of the sensors"),
    "thickness": Source("m", "finger", "thickness of the skin"),
    "radius": Source("m", "finger", "radius of the finger"),
    "resolution": Source("reading", "reading", "step of the readings"),
    "noise": Source("reading", "reading", "noise"),
}
"""Every source, in the order of a budget's rows."""


@checked
def usual_tolerances(finger: Finger) -> dict[str, float]:
    """What is usually not known better of a finger that is moulded and not measured, by source.

    Amounts are standard deviations, but for `width` and `resolution`: by how much the sensors are wider than the model
    takes them, and the step of a reading. In the finger's own terms, with d the mean depth: `position` 2 % of d,
    `depth` 5 % of d, `gains` 5 %, as `calibrate_blind` takes them; `depths` 2 % of d, `young` 10 %, `poisson` 0.02,
    `gain` 5 %, `offset` as much as the noise, `width` a fifth of d, `thickness` 5 % of itself, `radius` 2 % of itself,
    `resolution` and `noise` those of the array. What a finger has not is left out.

    Examples
    --------
    >>> import subskin as ss
    >>> array = ss.SensorArray.line(count=4, pitch=2e-3, depth=2e-3, noise=1e-4)
    >>> usual = usual_tolerances(ss.Finger(ss.HalfPlane(ss.Material(young=0.4e6)), array))
    >>> round(usual["position"] * 1e6), usual["gains"], "thickness" in usual
    (40, 0.05, False)
    """
    array, skin = finger.array, finger.skin
    depth, noise = float(np.asarray(array.depth).mean()), _typical(array.noise, array.live)
    usual = {
        "position": 0.02 * depth, "depth": 0.05 * depth, "depths": 0.02 * depth, "young": 0.1, "poisson": 0.02,
        "gain": 0.05, "gains": 0.05, "offset": noise, "width": 0.2 * depth,
        "resolution": _typical(array.resolution, array.live), "noise": noise,
    }  # fmt: skip
    if np.isfinite(skin.thickness) and skin.single_material is not None:
        usual["thickness"] = 0.05 * skin.thickness
    if skin.curvature:
        usual["radius"] = 0.02 / skin.curvature
    return {name: usual[name] for name in SOURCES if usual.get(name, 0.0) > 0}


Amounts: TypeAlias = Annotated[Mapping[str, float] | None, Fix('tolerances={"depth": 0.05e-3}')]
"""Amount of each source, a standard deviation; of the usual sources if left out."""


def checked_tolerances(finger: Finger, tolerances: Mapping[str, float] | None) -> dict[str, float]:
    """Amounts > 0 in the order of `SOURCES`; what is 0 is left out, what the finger has not is refused."""
    given = usual_tolerances(finger) if tolerances is None else tolerances
    for name in given:
        if name not in SOURCES:
            raise InvalidValueError(f"tolerance of {name!r}", f"there are {', '.join(SOURCES)}", '{"depth": 0.05e-3}')
    amounts = {name: _check.scalar(name, given[name], at_least=0.0) for name in SOURCES if name in given}
    amounts = {name: amount for name, amount in amounts.items() if amount > 0}
    if not amounts:
        raise InvalidValueError("no tolerance > 0", "at least one is needed", "usual_tolerances(finger)")
    for name in amounts:
        if name in ("young", "poisson", "thickness", "radius"):
            _skin_off(finger.skin, {name: 0.0})  # refuses what the skin has not
    return amounts


def as_made(finger: Finger, off: Mapping[str, Any]) -> Finger:
    """The finger with each source of `off` off by the value given: a number, or one a sensor.

    A `position` of shape (n, 2), or (1, 2), moves the sensors along y and along z. A SubskinError is raised where there
    is no such finger: a depth below 0, Poisson's ratio above 1/2.
    """
    a, moved = finger.array, np.asarray(off.get("position", 0.0))
    y, z = moved.T if moved.ndim == 2 else (moved, 0.0)
    array = replace(
        a,
        y=np.asarray(a.y) + y,
        z=np.asarray(a.z) + z,
        depth=np.asarray(a.depth) + off.get("depth", 0.0) + off.get("depths", 0.0),
        gain=np.asarray(a.gain) * (1 + off.get("gain", 0.0)) * (1 + off.get("gains", 0.0)),
        offset=np.asarray(a.offset) + off.get("offset", 0.0),
        width=np.asarray(a.width) + off.get("width", 0.0),
    )
    return Finger(_skin_off(finger.skin, off), array)


def _skin_off(skin: Skin, off: Mapping[str, Any]) -> Skin:
    """The skin with all moduli off by a share, all of Poisson's ratios, its thickness or its radius by an amount."""
    if "young" in off or "poisson" in off:
        factor, more = 1 + float(off.get("young", 0.0)), float(off.get("poisson", 0.0))
        new = [replace(m, young=factor * m.young, poisson=m.poisson + more) for m in skin.materials]
        skin = skin.with_(materials=new)
    if "radius" in off:
        skin = skin.with_(radius=skin.period / (2 * np.pi) + float(off["radius"]))
    if "thickness" in off:
        skin = skin.with_(thickness=skin.thickness + float(off["thickness"]))
    return skin


def of_each_sensor(values: Any, amount: float) -> FloatArray:
    """`amount` shared out as `values` of the array are, or alike where these are 0."""
    each = np.asarray(values, dtype=np.float64)
    size = float(np.sqrt(np.mean(each**2)))
    return each * (amount / size) if size > 0 else np.full(each.shape, amount)


def _typical(values: Any, live: Any) -> float:
    """Root mean square over the sensors that respond."""
    each = np.asarray(values, dtype=np.float64)[live]
    return float(np.sqrt(np.mean(each**2))) if each.size else 0.0


TOLD = ("position", "force", "angle", "radius")
"""What a touch is asked for."""


@dataclass(frozen=True)
class Cost:
    """What a source of error costs in locating: one row of a budget.

    Parameters
    ----------
    source : str
        One of `SOURCES`, or "total" or "together".
    amount : float
        Its standard deviation, in `unit`: metres, readings, or "" for shares and for Poisson's ratio. Of `width`, the
        value itself; of `resolution`, the step.
    spread : {"finger", "fixed", "sensor", "reading"}
        Whether it is one number for the whole finger, one that is the same in all of them, each sensor's own, or each
        reading's.
    position_rms, angle_rms, force_rms : float
        Root mean square over touches and fingers [m, rad, share of the force]; on an area an error of the position is
        a distance, that of the angle one between directions.
    position_worst, angle_worst, force_worst : float
        At the worst touch, the error that the budget's `quantile` of the fingers (of the frames, for the noise) stay
        within; for `resolution` and `width` simply the largest.
    lost : float
        Share of the frames that are not OK any more.
    position_linear, angle_linear, force_linear : float
        Root mean square to first order: (J^T W J)^-1 J^T W times the change of the readings. Infinite where J is
        singular at one of the touches.
    radius_rms, radius_worst, radius_linear : float
        The same of the radius of touches that have one [m]; NaN of others.
    """

    source: str
    amount: float
    unit: str
    spread: str
    position_rms: float
    position_worst: float
    angle_rms: float
    angle_worst: float
    force_rms: float
    force_worst: float
    lost: float
    position_linear: float
    angle_linear: float
    force_linear: float
    radius_rms: float = np.nan
    radius_worst: float = np.nan
    radius_linear: float = np.nan


@dataclass(frozen=True)
class Needed:
    """How tight a tolerance has to be.

    Parameters
    ----------
    source, amount, unit
        As in `Cost`: as given.
    alone : float
        Amount with which this source alone would use up the wanted accuracy; infinite where that is more than ten times
        what was given.
    shared : float
        Amount with which it takes an equal share of the variance, beside the others that matter.
    """

    source: str
    amount: float
    unit: str
    alone: float
    shared: float


@dataclass(frozen=True)
class Recovery:
    """What self-calibration wins back of the errors that a source makes.

    Parameters
    ----------
    source : str
        One of `SOURCES`, or "together".
    drawn : Cost
        With the finger as drawn, on the same fingers.
    known, blind : Cost or None
        After calibrating at known positions, and from touches of which nothing is known; None where that was not asked.
    failed : tuple of (str, int)
        How many calibrations of each kind did not settle; these fingers count as drawn.
    """

    source: str
    drawn: Cost
    known: Cost | None
    blind: Cost | None
    failed: tuple[tuple[str, int], ...]
