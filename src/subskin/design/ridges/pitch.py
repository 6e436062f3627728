"""The pitch of ridges that a sensor reads most (memo section 6.1)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from ... import _check
from ..._check import FloatArray
from ..._frozen import Result
from ...finger import Finger, finger_needed
from .._common import refuse_ridges
from ..response import spatial_response

__all__ = ["RidgePitch", "best_ridge_pitch"]

_LEAST, _MOST, _SCAN = 1e-3, 60.0, 481
_CLOSER, _ROUNDS = 41, 6
_SHARE = 0.5
"""A maximum has to have this share of the largest reading: a wide sensor has others, ever smaller."""


@dataclass(frozen=True, eq=False)
class RidgePitch(Result):
    """What `best_ridge_pitch` found, for each of the n sensors.

    Attributes
    ----------
    pitch : ndarray, shape (n,)
        The best pitch [m]; infinite where a pressure without ridges reads most.
    normal, tangential : ndarray, shape (n,)
        Size of the reading of a wave of pressure and of a wave of shear of that pitch [its unit / Pa].
    """

    pitch: FloatArray
    normal: FloatArray
    tangential: FloatArray


def best_ridge_pitch(finger: Finger) -> RidgePitch:
    """The finest pitch at which the reading of a wave of pressure has a maximum, sensor by sensor.

    For normal strain on a half plane it is pi / nu depths, 2 pi at nu = 1/2 (memo section 6.1), and a wave of shear of
    that pitch is not read at all. On any other finger it is found from
    `spatial_response`. A layer that is squeezed, or a ring bent oval, has a coarser maximum as well, of waves longer
    than the skin is thick; the finer one is meant, if it has half the size. On a round finger a whole number of ridges
    goes round. It is the best of waves without end: a contact that spans few ridges shifts it (`ridge_gain`).

    Raises
    ------
    NotLinearError
        A transducer that is not linear.

    Examples
    --------
    >>> import subskin as ss
    >>> skin = ss.HalfPlane(ss.Material(young=0.4e6))
    >>> best = best_ridge_pitch(ss.Finger(skin, ss.SensorArray(y=[0.0], depth=0.5e-3)))
    >>> (best.pitch * 1e3).round(4).tolist(), bool(best.tangential[0] < 1e-6 * best.normal[0])
    ([3.1416], True)
    """
    finger_needed(finger)
    refuse_ridges(finger.skin, "the best pitch of ridges")
    depth = np.asarray(finger.array.depth)
    shortest = _MOST / float(depth.min())
    if turn := finger.skin.curvature:
        k = turn * np.arange(max(int(shortest / turn), 4))
        sizes = spatial_response(finger, k).magnitude
        at = _finest(sizes[..., 0])
        return _found(np.asarray(k[at]), sizes[at, np.arange(depth.size)], at == 0)
    logs = np.linspace(np.log(_LEAST / float(depth.max())), np.log(shortest), _SCAN)
    at = _finest(spatial_response(finger, np.exp(logs)).magnitude[..., 0])
    best, half, own = logs[at], logs[1] - logs[0], np.arange(depth.size)
    for _ in range(_ROUNDS):
        near = best[:, None] + half * np.linspace(-1, 1, _CLOSER)
        sizes = spatial_response(finger, np.exp(near)).magnitude[own, :, own]
        best = near[own, np.argmax(sizes[..., 0], axis=1)]
        half *= 3 / _CLOSER
    return _found(np.asarray(np.exp(best)), spatial_response(finger, np.exp(best)).magnitude[own, own], at == 0)


def _finest(sizes: FloatArray) -> npt.NDArray[np.intp]:
    """Index of the last large maximum of each column (waves, n); 0 where it is largest at its start."""
    rises = np.diff(sizes, axis=0, prepend=np.inf, append=0.0)
    tops = (rises[:-1] > 0) & (rises[1:] <= 0) & (sizes >= _SHARE * sizes.max(axis=0))
    last = len(sizes) - 1 - np.argmax(tops[::-1], axis=0)
    return np.where(np.argmax(sizes, axis=0) == 0, 0, last)


def _found(k: FloatArray, sizes: FloatArray, endless: npt.NDArray[np.bool_]) -> RidgePitch:
    pitch = np.where(endless, np.inf, 2 * np.pi / np.where(endless, 1.0, k))
    return RidgePitch(*(_check.read_only(a.copy()) for a in (pitch, sizes[:, 0], sizes[:, 1])))
