"""Where to touch next: the touch that leaves the least error in the positions that a calibrated finger will find."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Annotated, Any

import numpy as np
import numpy.typing as npt

from .. import _check
from .._check import FloatArray
from .._declared import Fix, Positive, Real, checked
from .._frozen import Frozen
from ..errors import GeometryError, InvalidValueError, UnknownOptionError
from ..finger import Finger
from ._forward import LINEAR, Forward, checked_names, terms_of

__all__ = ["NextTouch", "next_touch"]

_USUAL = ("gain", "offset", "depth", "origin")
_STEP = 1e-4
"""Step of a difference, of the mean depth."""
_GAIN, _OFFSET = 0.3, 3.0
"""What a drawing is good for: of a gain, and of the largest reading for an offset."""
_KNOWN = {"depth": 0.2, "depths": 0.2, "origin": 1.0, "position": 0.1, "width": 0.5}
"""The same of lengths, in mean depths."""
_ALONE = {"poisson": 0.05, "turn": 0.2}
_THICK = 0.5
"""What a drawing is good for: of the thickness above the base."""


@dataclass(frozen=True, eq=False)
class NextTouch(Frozen):
    """What `next_touch` proposes.

    Parameters
    ----------
    position : float, or ndarray of shape (2,)
        Where to touch next, on the axis (axes) of the touches [m].
    error : float
        Root mean square error of positions that the calibration makes as it is, over the targets [m]: what the noise of
        a frame adds is not in it.
    error_after : float
        The same once this touch has been made [m].

    Examples
    --------
    >>> NextTouch(2e-3, error=0.4e-3, error_after=0.1e-3).error_after < 0.4e-3
    True
    """

    position: Any
    error: float
    error_after: float


@checked
def next_touch(
    finger: Finger,
    positions: npt.ArrayLike,
    candidates: npt.ArrayLike,
    *,
    fit: Sequence[str] | None = None,
    known: Annotated[Mapping[str, float] | None, Fix('known={"gain": 0.05}')] = None,
    force: Positive = 1.0,
    origin: Annotated[npt.ArrayLike, Real("m")] = 0.0,
    targets: npt.ArrayLike | None = None,
) -> NextTouch:
    """Choose the touch after which a calibrated finger will find positions best.

    The numbers that `calibrate` will fit have a covariance: from what is known of the drawing, and from the touches
    made so far. To first order an error of these numbers moves the position that the finger finds. Of all candidates,
    the one is chosen after which these moves are smallest, in the mean square over the targets (a design that is
    optimal for its predictions, "I-optimal").

    Parameters
    ----------
    finger : Finger
        The finger as far as it is known: as drawn, or as calibrated on the touches so far. Its noise counts.
    positions : array_like, shape (m,) or (m, 2)
        Touches made so far, on their axis [m]; (y, z) of sensors on an area. An empty list where there are none.
    candidates : array_like, shape (k,) or (k, 2)
        Where the next touch may be [m].
    fit : sequence of str, optional
        What will be fitted, as in `calibrate`.
    known : mapping of str to float, optional
        Standard deviation to which the drawing is known: of "gain" as a share [-], of "offset" in units of the reading,
        of "lift" in these per unit force, of "poisson" [-], of "turn" [rad], of lengths [m]. By default 30 % of a gain,
        three of the largest readings, a depth for the origin, a fifth of it for depths, a tenth for positions.
    force : float, optional
        Load of each touch [N/m or N].
    origin : float or (float, float), optional
        Where the finger's y = 0 lies on the axis of the touches, as far as it is known [m].
    targets : array_like, shape (t,) or (t, 2), optional
        Where positions shall be right [m]; by default at the candidates.

    Returns
    -------
    NextTouch

    Raises
    ------
    InvalidValueError, GeometryError, UnknownOptionError
        No candidate, names that are not known, numbers that are not positive, shapes that do not match.

    Examples
    --------
    >>> import numpy as np, subskin as ss
    >>> skin = ss.HalfPlane(ss.Material(young=0.4e6))
    >>> drawn = ss.Finger(skin, ss.SensorArray.line(4, pitch=6e-3, depth=5e-3, noise=1e-6))
    >>> made, able = [], np.linspace(-9e-3, 9e-3, 37)
    >>> for _ in range(5):
    ...     proposed = ss.calibration.next_touch(drawn, made, able, force=20.0)
    ...     made.append(proposed.position)
    >>> f"{1e3 * proposed.error:.2f} mm before it, {1e3 * proposed.error_after:.2f} mm after it"
    '... mm before it, ... mm after it'
    """
    area = finger.array.on_area
    usual = _USUAL + ("turn",) * area if fit is None else fit
    names = checked_names(usual, (*LINEAR, *terms_of(finger)))
    live = finger.array.live
    forward = Forward(Finger(finger.skin, finger.array.select(live)), names)
    model = _Model(forward, names, np.asarray(origin), force)
    made = _positions(finger, "positions", positions)
    able = _positions(finger, "candidates", candidates)
    aims = able if targets is None else _positions(finger, "targets", targets)
    if not len(able) or not len(aims):
        raise InvalidValueError("no candidate", "the next touch needs a position to choose", "candidates=[0.0, 1e-3]")
    covariance = np.diag(model.doubt(able, known or {}) ** 2)
    for row in model.of_parameters(made):
        covariance = _told(covariance, row, model.noise)
    aim = model.of_positions(aims)
    now = _mean_square(aim, covariance)
    after = [_mean_square(aim, _told(covariance, row, model.noise)) for row in model.of_parameters(able)]
    best = int(np.argmin(after))
    chosen: Any = np.array(able[best]) if area else float(able[best])
    return NextTouch(chosen, float(np.sqrt(now)), float(np.sqrt(after[best])))


def _positions(finger: Finger, name: str, given: npt.ArrayLike) -> FloatArray:
    """Positions (k,) or (k, 2), checked; none of them where the list is empty."""
    at = _check.real(name, given, unit="m")
    shape = (2,) if finger.array.on_area else ()
    if not at.size:
        return np.empty((0, *shape))
    if at.ndim != 1 + len(shape) or at.shape[1:] != shape:
        rule = "(k, 2), a position (y, z) a row, is needed" if shape else "(k,), a position each, is needed"
        raise GeometryError(f"{name} of shape {at.shape}", rule, f"np.atleast_{1 + len(shape)}d({name})")
    return at


class _Model:
    """What readings of touches that press straight in have to do with what is fitted: p, gains, offsets, lifts."""

    def __init__(self, forward: Forward, names: Sequence[str], origin: Any, force: float) -> None:
        self.forward, self.names, self.force = forward, names, force
        self.fixed: Any = origin
        array = forward.finger.array
        self.p = forward.start(origin)
        self.gain, self.noise = np.asarray(array.gain), np.asarray(array.noise)
        if not (self.noise > 0).all():
            rule = "what a touch tells depends on the noise of the readings"
            raise InvalidValueError("a noise of 0", rule, "SensorArray(..., noise=...)")

    def _load(self, at: FloatArray) -> FloatArray:
        return np.tile(self.force * np.eye(self.forward.dim + 1)[0], (len(at), 1))

    def doubt(self, at: FloatArray, known: Mapping[str, float]) -> FloatArray:
        """Standard deviation of each number before any touch."""
        for name, value in known.items():
            if name not in self.names:
                raise UnknownOptionError(f'known = "{name}"', f"fitted are {', '.join(self.names)}", "")
            _check.scalar(f"known[{name!r}]", value, above=0.0)
        forward = self.forward
        depth = float(np.asarray(forward.finger.array.depth).mean())
        usual = {name: share * depth for name, share in _KNOWN.items()} | _ALONE
        usual["thickness"] = _THICK * forward.finger.skin.thickness
        out = [np.full(part.stop - part.start, known.get(name, usual[name])) for name, part in forward.slices.items()]
        read = self.gain * forward.unit(self.p, *forward.moved(self.p, self.fixed, at, self._load(at)))
        largest = _OFFSET * np.abs(read).max(axis=0)
        each = {"gain": known.get("gain", _GAIN) * np.abs(self.gain), "offset": largest, "lift": largest / self.force}
        for name in LINEAR:
            if name in self.names:
                own = each[name] if name == "gain" else known.get(name, each[name])
                out.append(np.broadcast_to(own, self.gain.shape))
        return np.concatenate(out)

    def of_parameters(self, at: FloatArray) -> FloatArray:
        """Derivative of the readings of touches at `at` with respect to the fitted numbers, shape (k, n, numbers)."""
        if not len(at):
            return np.empty((0, self.gain.size, 0))
        return self.forward.jacobian(self.p, self.fixed, (at, self._load(at)), self.gain, self.names)

    def of_positions(self, at: FloatArray) -> FloatArray:
        """How an error of the fitted numbers moves the position found of loads that may lean, shape (k, d, numbers)."""
        d = self.forward.dim
        finger = self.forward.apply(self.p)
        there, _ = self.forward.moved(self.p, self.fixed, at, np.zeros((len(at), d + 1)))
        step = _STEP * float(np.asarray(finger.array.depth).mean())
        moves = step * (np.eye(2) if d == 2 else np.ones(1))
        along = [
            (finger.receptive_field(there + move) - finger.receptive_field(there - move))[..., 0] for move in moves
        ]
        columns = [0.5 * self.force / step * part for part in along]
        slopes = np.concatenate([np.stack(columns, axis=-1), finger.receptive_field(there)], axis=-1)
        weights = np.linalg.pinv(slopes / self.noise[:, None])[:, :d] / self.noise
        return np.asarray(-weights @ self.of_parameters(at))


def _told(covariance: FloatArray, row: FloatArray, noise: FloatArray) -> FloatArray:
    """The covariance of the numbers after a touch with the derivative `row` (n, numbers)."""
    crossed = row @ covariance
    gain = np.linalg.solve(crossed @ row.T + np.diag(noise**2), crossed)
    after = covariance - crossed.T @ gain
    return np.asarray((after + after.T) / 2)


def _mean_square(aim: FloatArray, covariance: FloatArray) -> float:
    """Mean over the targets of the squared error of a position."""
    return float(np.einsum("kdi,ij,kdj->", aim, covariance, aim)) / len(aim)
