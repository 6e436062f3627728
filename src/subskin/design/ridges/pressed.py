"""Ridges as they are pressed: the contact solver's pressure beside the smooth one broken up (memo section 6.1)."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Annotated, TypeAlias

import numpy as np
import numpy.typing as npt

from ... import _check
from ..._check import FloatArray
from ..._declared import Real, checked
from ...contact import PressureProfile
from ...finger import Finger
from ...pressing import SineRidges, press
from ...skin import Skin
from .._common import Found, refuse_ridges
from .gain import Gains, largest, ridge_gain
from .shape import Ridges, ShapeName

__all__ = ["PressedRidges", "closing_pressure", "press_ridges"]

_Pitch: TypeAlias = Annotated[npt.ArrayLike, Real("m", above=0.0)]
_Amplitude: TypeAlias = Annotated[npt.ArrayLike, Real("m", at_least=0.0)]


@checked
def closing_pressure(skin: Skin, pitch: _Pitch, amplitude: _Amplitude) -> FloatArray:
    """Mean pressure [Pa] at which ridges amplitude cos(2 pi y / pitch) are pressed flat: touching all along.

    On a half plane pi E* amplitude / pitch (Westergaard 1939; Johnson, Contact Mechanics (1985), section 13.2); on any
    skin amplitude over the displacement per pressure at that wavelength. On a round finger the nearest whole number of
    ridges goes round.

    Parameters
    ----------
    skin : Skin
        Any.
    pitch, amplitude : array_like, shape (...)
        From crest to crest, and half the height from trough to crest [m].

    Examples
    --------
    >>> import subskin as ss
    >>> skin = ss.HalfPlane(ss.Material(young=0.4e6, poisson=0.5))
    >>> round(float(closing_pressure(skin, pitch=3e-3, amplitude=20e-6)), 3)
    11170.107
    """
    refuse_ridges(skin, "the closing pressure")
    k = 2 * np.pi / np.asarray(pitch)
    if turn := skin.curvature:
        k = np.maximum(np.round(k / turn), 2) * turn
    return _check.read_only(np.asarray(amplitude) / skin.surface_compliance(k)[..., 0, 0])


@dataclass(frozen=True, eq=False)
class PressedRidges(Found):
    """What `press_ridges` found. Arrays have the shape to which pitch, amplitude and force broadcast.

    Attributes
    ----------
    finger : Finger
    pitch, amplitude, force : ndarray
        Pitch and amplitude of the ridges [m, m], and the normal force [N/m].
    status : ndarray of int
        Values of `PressStatus`; anything but OK is to be looked at.
    closing : ndarray
        `closing_pressure` [Pa].
    half_width, pressure : ndarray
        Half width [m] and greatest pressure [Pa] of the smooth contact.
    touching : ndarray
        Share of the width, from the first edge of the ridged contact to its last, that touches.
    valley : ndarray
        Pressure half a pitch from the middle over that at the crest in the middle [-]; NaN where the smooth contact
        does not reach so far.
    crest : ndarray
        Pressure at the crest in the middle over the greatest one of the smooth contact [-].
    shape : str
        The shape that `assumed` takes.
    solved : Gains
        Readings under the ridges over those without, at the same force. The ripple is the difference of the two.
    assumed : Gains
        The same for the smooth pressure times ridges of that shape: `ridge_gain` at equal load.
    """

    finger: Finger
    pitch: FloatArray
    amplitude: FloatArray
    force: FloatArray
    status: npt.NDArray[np.int_]
    closing: FloatArray
    half_width: FloatArray
    pressure: FloatArray
    touching: FloatArray
    valley: FloatArray
    crest: FloatArray
    shape: str
    solved: Gains
    assumed: Gains

    @property
    def filling(self) -> FloatArray:
        """Greatest smooth pressure over `closing`; ridges are pressed flat in the middle from about 1 on."""
        with np.errstate(divide="ignore"):
            return _check.read_only(self.pressure / self.closing)


@checked
def press_ridges(
    finger: Finger,
    pitch: _Pitch,
    amplitude: _Amplitude,
    *,
    force: Annotated[npt.ArrayLike, Real("N/m", above=0.0)],
    radius: Annotated[float, Real("m", above=0.0, finite=False)] = np.inf,
    shape: ShapeName = "abs_cos",
    sensor: int = 0,
    nodes: int | None = None,
) -> PressedRidges:
    """The gain by ridges of a given height, from solved contacts, beside the gain that a shape of pressure assumes.

    Ridges on the skin and ridges on what touches it are the same problem to first order: the gap between the bodies is
    the sum of both profiles, and the skin is a half space beneath either where ridges are low beside their pitch. Only
    what moves with the sensors differs. A crest is at y = 0, in the middle of the contact.

    Parameters
    ----------
    finger : Finger
        Any skin; a linear transducer.
    pitch, amplitude, force : array_like
        From crest to crest [m], half the height from trough to crest [m], normal force [N/m]; they broadcast.
    radius : float, optional
        Radius [m] of the cylinder that is pressed on; a flat if left out, for a round finger.
    shape : {"abs_cos", "cos_squared", "raised_cosine", "square"}, optional
        The share that `assumed` takes.
    sensor : int, optional
        Index of the sensor whose kind this is about.
    nodes : int, optional
        As in `press`.

    Examples
    --------
    >>> import subskin as ss
    >>> skin = ss.HalfPlane(ss.Material(young=0.4e6))
    >>> finger = ss.Finger(skin, ss.SensorArray(y=[0.0], depth=0.5e-3))
    >>> low, high = 5e-6, 60e-6
    >>> found = press_ridges(finger, 3e-3, [low, high], force=200.0, radius=50e-3)
    >>> found.filling.round(1).tolist(), found.touching.round(2).tolist()
    ([9.3, 0.8], [1.0, 0.51])
    """
    given = {"pitch": np.asarray(pitch), "amplitude": np.asarray(amplitude), "force": np.asarray(force)}
    batch = _check.broadcast(**given)
    wide, high, load = (np.broadcast_to(a, batch).copy() for a in given.values())
    status = np.zeros(batch, dtype=int)
    half_width, pressure, touching, valley, crest = [np.full(batch, np.nan) for _ in range(5)]
    gains = np.empty((2, len(Gains._fields), *batch))
    for index in np.ndindex(batch):
        p = float(wide[index])
        bodies = [SineRidges(p, a, radius) for a in (0.0, float(high[index]))]
        smooth, ridged = (press(finger.skin, b, force=float(load[index]), nodes=nodes) for b in bodies)
        status[index] = max(ridged.status, smooth.status)
        half_width[index], pressure[index] = smooth.half_width, smooth.pressure.max()
        touching[index] = np.diff(ridged.edges, axis=1).sum() / (2 * ridged.half_width)
        top = ridged.contact.pressure(0.0)
        crest[index] = top / pressure[index]
        if smooth.half_width > 0.5 * p:
            valley[index] = ridged.contact.pressure(0.5 * p) / top
        assumed = ridge_gain(finger, smooth.contact, Ridges(p, shape), sensor=sensor).equal_load
        solved = _solved(finger, sensor, smooth.contact, ridged.contact, p)
        gains[(slice(None), slice(None), *index)] = solved, assumed
    closing = closing_pressure(finger.skin, wide, high)
    solved_gains, assumed_gains = (Gains(*map(np.asarray, g)) for g in gains)
    return PressedRidges(
        finger, wide, high, load, status, closing, half_width, pressure, touching, valley, crest,
        shape, solved_gains, assumed_gains,
    )  # fmt: skip


def _solved(finger: Finger, sensor: int, smooth: PressureProfile, ridged: PressureProfile, pitch: float) -> Gains:
    """Largest readings under the one pressure over that under the other."""
    chosen = finger.array.select([sensor])
    depth = float(np.asarray(chosen.depth)[0])

    def read(positions: FloatArray) -> FloatArray:
        row = replace(finger.array.select([sensor] * positions.size), y=positions)
        without, with_ = (Finger(finger.skin, row).measure(c, linear=True) for c in (smooth, ridged))
        return np.stack([without, with_, with_ - without])

    ends = min(smooth.nodes[0], ridged.nodes[0]), max(smooth.nodes[-1], ridged.nodes[-1])
    return largest(read, (float(ends[0]), float(ends[1])), depth, pitch, 0.0)[1]
