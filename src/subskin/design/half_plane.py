"""How wrong is the half plane? A finger's own skin against the half plane that the memo assumes."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Annotated

import numpy as np
import numpy.typing as npt

from .._check import FloatArray
from .._declared import Extent, Positive, Real, checked
from ..array import SensorArray
from ..calibration.known import explained, fitted
from ..contact import Hertz, LineLoad
from ..contact.base import Contact
from ..errors import ConvergenceError, InvalidValueError
from ..estimate import Estimate, Locator, Status
from ..finger import Finger
from ..material import Material
from ..response import tabulate
from ..skin import HalfPlane, Layer, Layered, Round, Skin
from ._common import Found, listed

__all__ = ["MAP_RADIUS", "MAP_THICKNESS", "HalfPlaneError", "LocatingError", "half_plane_error", "half_plane_map"]

_POSITIONS = 41
_ANGLES = (-0.4, 0.0, 0.4)
_NOISE_SHARE = 0.05
"""Noise, of each sensor's largest reading, with which biases are found: a wrong skin still 'explains' the readings."""

_BLIND = 1e-9
"""Share of the largest reading below which a sensor straight beneath a touch reads nothing: a gauge of shear."""

MAP_THICKNESS = (1.1, 1.3, 1.6, 2.0, 2.5, 3.0, 4.0, 6.0, 10.0, 20.0, 50.0)
MAP_RADIUS = (2.5, 3.0, 4.0, 5.0, 7.0, 10.0, 15.0, 20.0, 30.0, 50.0, 100.0, np.inf)
"""Thickness and radius of a map, in depths of the sensors."""

_CORE = 0.05
"""Thinnest core of a map's round finger, of its radius."""


@dataclass(frozen=True, eq=False)
class LocatingError(Found):
    """Errors of `locate` on readings free of noise, over touches all along the row at several angles.

    Parameters
    ----------
    position, force, angle : ndarray, shape (positions, angles)
        Error of the position [m], of the force relative to the true one [-], of the angle [rad]. The sensors' noise is
        taken for 5 % of each one's largest reading, so that a wrong skin explains the readings too; NaN where it does
        not.
    status : dict of str to int
        How many touches come out with each status where each sensor's largest reading is `snr` times its noise.
    """

    position: FloatArray
    force: FloatArray
    angle: FloatArray
    status: dict[str, int]

    @property
    def unanswered(self) -> int:
        """How many touches come out without a load: they are in none of the errors."""
        return int(np.isnan(self.position).sum())

    def summary(self) -> dict[str, dict[str, float]]:
        """Median and worst size of each error."""
        out = {}
        for name in ("position", "force", "angle"):
            size = np.abs(getattr(self, name))
            found = size[np.isfinite(size)] if np.isfinite(size).any() else np.array([np.nan])
            out[name] = {"median": float(np.median(found)), "worst": float(found.max())}
        return out


@dataclass(frozen=True, eq=False)
class HalfPlaneError(Found):
    """What `half_plane_error` found.

    Parameters
    ----------
    finger : Finger
        The finger in question; its skin is taken for the truth.
    half_width : float
        Half width of the touches [m]; 0 for line loads.
    positions, angles : ndarray
        Where the touches were [m] and at which angles [rad].
    beneath : ndarray, shape (n,)
        Reading of each sensor straight beneath a normal touch, over the half plane's; NaN for a sensor that reads
        nothing there.
    normal, tangential : float
        Largest difference of the readings anywhere along the row, relative to the largest reading, under a normal and
        under a tangential load.
    as_drawn, calibrated, own : LocatingError
        What `locate` makes of the readings with the half plane as drawn, with a half plane whose gains and depth were
        fitted to touches at known positions, and with the finger's own skin (what is left is the touches' width). NaN
        where that calibration does not settle.
    depth : float
        Mean depth that this calibration finds [m]: where it differs from the true one, depth makes up for the skin.
    """

    finger: Finger
    half_width: float
    positions: FloatArray
    angles: FloatArray
    beneath: FloatArray
    normal: float
    tangential: float
    as_drawn: LocatingError
    calibrated: LocatingError
    own: LocatingError
    depth: float


@checked
def half_plane_error(finger: Finger, *, half_width: Extent = 0.0, snr: Positive = 1000.0) -> HalfPlaneError:
    """Errors made by taking the skin of `finger` for a half plane of the material around its sensors.

    Touches are spread over the row, out to its outermost sensors, at angles of -0.4, 0 and 0.4 rad. Their readings in
    the finger's own skin are free of noise, neither rounded nor cut off, so every error is the model's.

    Parameters
    ----------
    finger : Finger
        With a skin that is not a half plane, e.g. `Layered` or `Round`.
    half_width : float, optional
        Half width of the touches [m], as Hertz contacts; 0, the default, for line loads.
    snr : float, optional
        Largest reading of each sensor over its noise [-], which decides how many touches are said to be unexplained.

    Raises
    ------
    InvalidValueError
        A half plane, which is not wrong about itself; fewer than three sensors that respond.
    NotLinearError
        A transducer with no linear part, with which nothing can be located.

    Examples
    --------
    Rubber of three depths on bone, sensors one depth apart: read as a half plane, touches are misplaced a little, and
    their angles by much more.

    >>> import numpy as np, subskin as ss
    >>> skin = ss.Layered(ss.Layer(ss.Material(young=0.4e6), thickness=6e-3))
    >>> finger = ss.Finger(skin, ss.SensorArray.line(count=6, pitch=2e-3, depth=2e-3, noise=1e-4))
    >>> found = ss.design.half_plane_error(finger)
    >>> found.beneath.round(3).tolist()[0], round(float(np.rad2deg(np.abs(found.as_drawn.angle).max())), 1)
    (1.073, 9.3)
    """
    if finger.skin.endless:
        fix = 'describe the real skin: kind = "layers" or "round" in finger.toml'
        raise InvalidValueError("a finger whose skin is a half plane", "its error against itself is 0", fix)
    live = int(finger.array.live.sum())
    if live < 3:
        raise InvalidValueError(f"{live} sensors that respond", "locate needs at least 3", "more sensors")
    finger = replace(finger, array=replace(finger.array, low=-np.inf, high=np.inf, resolution=0.0))
    y = np.asarray(finger.array.y)
    positions, angles = np.linspace(y.min(), y.max(), _POSITIONS), np.array(_ANGLES)
    flat = Finger(half_plane_of(finger), finger.array)
    difference, beneath = _readings(finger, flat, positions, half_width)
    readings = finger.read(_touch(angles, positions[:, None], half_width))
    largest = _largest(readings - np.asarray(finger.array.offset))
    # the half plane with gains and depth fitted to normal touches of the true finger at known positions
    straight = finger.read(_touch(0.0, positions, half_width))
    noisy = Finger(flat.skin, replace(finger.array, noise=largest / snr))
    none = np.full((positions.size, angles.size), np.nan)
    calibrated, depth = LocatingError(none, none, none, {s.name.lower(): 0 for s in Status}), np.nan
    try:
        solution = fitted(noisy, straight, positions, fit=("gain", "depth"), force=1.0, origin=0.0, load="line")
        model = explained(solution).finger  # of which nobody asks for standard errors
        calibrated = _locating(model, readings, positions, angles, largest, snr)
        depth = float(np.asarray(model.array.depth).mean())
    except ConvergenceError:
        pass
    drawn, own = (_locating(f, readings, positions, angles, largest, snr) for f in (flat, finger))
    normal, tangential = difference.tolist()
    found = drawn, calibrated, own, depth
    return HalfPlaneError(finger, half_width, positions, angles, beneath, normal, tangential, *found)


def _readings(finger: Finger, flat: Finger, positions: FloatArray, half_width: float) -> tuple[FloatArray, FloatArray]:
    """Largest difference under a normal and a tangential touch over the largest reading; factors straight beneath."""
    normal, tangential = _touch(0.0, positions, half_width), _touch(0.5 * np.pi, positions, half_width)
    fields = [
        np.stack([f.measure(touch, linear=True) for touch in (normal, tangential)], axis=-1) for f in (finger, flat)
    ]
    difference = np.abs(fields[0] - fields[1]).max(axis=(0, 1)) / np.abs(fields[0]).max(axis=(0, 1))
    above = _touch(0.0, np.asarray(finger.array.y), half_width)  # one touch above each sensor
    own, flats = (np.diagonal(f.measure(above, linear=True)) for f in (finger, flat))
    seen = np.abs(flats) > _BLIND * np.abs(fields[1]).max()
    return difference, np.where(seen, own / np.where(seen, flats, 1.0), np.nan)


def half_plane_of(finger: Finger) -> HalfPlane:
    """The half plane of the material in which the sensors of a finger lie: what one would take the skin for."""
    return HalfPlane(finger.skin.material_at(float(np.asarray(finger.array.depth).mean())))


@checked
def half_plane_map(
    thickness: npt.ArrayLike = MAP_THICKNESS,
    radius: npt.ArrayLike = MAP_RADIUS,
    *,
    poisson: float = 0.5,
    half_width: Annotated[float, Real(at_least=0.0)] = 0.0,
    count: int = 6,
    progress: Callable[[], object] | None = None,
) -> dict[str, FloatArray]:
    """How wrong the half plane is, over the skin's thickness and the finger's radius, both in depths of the sensors.

    Sensors of normal strain, `count` of them one depth apart, in a skin of one material on a rigid base or core.

    Parameters
    ----------
    thickness : array_like, shape (m,), optional
        Thickness [depths], > 1.
    radius : array_like, shape (k,), optional
        Radius [depths], > 1; `inf` for a flat skin.
    poisson, half_width : float, optional
        Poisson's ratio [-], and half width of the touches [depths].
    count : int, optional
        Number of sensors.
    progress : callable, optional
        Called before each of the k * m cells.

    Returns
    -------
    dict
        `thickness` and `radius`, as given, and arrays (k, m): `beneath`, the strain straight beneath a normal touch
        over the half plane's; `reading`, the largest difference of a reading relative to the largest one, normal or
        tangential; `position`, the worst error of position in depths, and `angle`, that of the angle [rad], of `locate`
        with the half plane as drawn. NaN where there is no such finger: a core thinner than a twentieth of its radius,
        or touches that reach round it.

    Examples
    --------
    >>> import subskin as ss
    >>> found = ss.design.half_plane_map(thickness=[2.0, 20.0], radius=[float("inf")], count=4)
    >>> found["reading"].round(3).tolist()
    [[0.271, 0.026]]
    """
    heights = listed("thickness", thickness, above=1.0)
    radii = listed("radius", radius, above=1.0, finite=False)
    array = SensorArray.line(count, pitch=1.0, depth=1.0)
    out = {"thickness": heights, "radius": radii}
    for name in ("beneath", "reading", "position", "angle"):
        out[name] = np.full((radii.size, heights.size), np.nan)
    material = Material(1.0, poisson)
    flat = Finger(HalfPlane(material), array)
    y, angles = np.asarray(array.y), np.array(_ANGLES)
    positions = np.linspace(y.min(), y.max(), _POSITIONS)
    for i, r in enumerate(radii):
        for j, h in enumerate(heights):
            if progress is not None:
                progress()
            if h >= (1 - _CORE) * r or half_width > 0.5 * np.pi * r:
                continue
            skin: Skin = Layered(Layer(material, h)) if np.isinf(r) else Round(material, r, r - h)
            finger = Finger(skin, array)
            difference, beneath = _readings(finger, flat, positions, half_width)
            readings = finger.read(_touch(angles, positions[:, None], half_width))
            errors = _locating(flat, readings, positions, angles, _largest(readings)).summary()
            out["beneath"][i, j], out["reading"][i, j] = beneath[count // 2], difference.max()
            for name in ("position", "angle"):
                out[name][i, j] = errors[name]["worst"]
    return out


def _touch(angle: npt.ArrayLike, position: npt.ArrayLike, half_width: float) -> Contact:
    if half_width:
        return Hertz(1.0, angle, position, half_width=half_width)
    return LineLoad(1.0, angle, position)


def _largest(readings: FloatArray) -> FloatArray:
    """Largest reading of each sensor; 1 for a dead one, whose noise does not matter."""
    size = np.abs(readings).max(axis=(0, 1))
    return np.where(size > 0, size, 1.0)


def _locating(
    finger: Finger,
    readings: FloatArray,
    positions: FloatArray,
    angles: FloatArray,
    largest: FloatArray,
    snr: float | None = None,
) -> LocatingError:
    """Errors of `finger`, which is told that the noise is a share of the largest reading; statuses at `snr`."""
    table = tabulate(finger)

    def found(noise: FloatArray) -> Estimate:
        return Locator(table, replace(finger.array, noise=noise))(readings)

    estimate = found(_NOISE_SHARE * largest)
    status = (estimate if snr is None else found(largest / snr)).status
    counts = np.bincount(status.reshape(-1), minlength=len(Status))
    return LocatingError(
        estimate.position - positions[:, None],
        estimate.force - 1,
        estimate.angle - angles,
        {s.name.lower(): int(counts[s]) for s in Status},
    )
