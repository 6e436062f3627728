"""The skin as a filter: what each sensor reads of a wave of pressure or of shear (memo section 6.0, eqs. 23 to 25)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated

import numpy as np
import numpy.typing as npt

from .. import _check
from .._check import ComplexArray, FloatArray
from .._declared import Real, checked
from ..finger import Finger
from ._common import Found

__all__ = ["SpatialResponse", "spatial_response"]

_SHORT, _WAVES = 12.0, 240
"""Largest k d that is drawn, where the reading has fallen ten thousandfold, and into how many waves it is cut."""


@dataclass(frozen=True, eq=False)
class SpatialResponse(Found):
    """What `spatial_response` found, at wavenumbers k of shape (...), for n sensors.

    Attributes
    ----------
    finger : Finger
    wavenumber : ndarray, shape (...)
        k = 2 pi / wavelength [rad/m].
    amplitude : ndarray of complex, shape (..., n, 2)
        Reading per Pa of a wave of pressure ([..., 0]) and of shear ([..., 1]). A traction cos(k (y - c)) reads
        Re(amplitude exp(-i k c)): the amplitude is the transform of the receptive field r, integral of r(y) exp(i k y).
    """

    finger: Finger
    wavenumber: FloatArray
    amplitude: ComplexArray

    @property
    def frequency(self) -> FloatArray:
        """Waves per metre, k / 2 pi [1/m]: the memo's s."""
        return _check.read_only(self.wavenumber / (2 * np.pi))

    @property
    def wavelength(self) -> FloatArray:
        """2 pi / k [m]; infinite for k = 0."""
        with np.errstate(divide="ignore"):
            return _check.read_only(2 * np.pi / self.wavenumber)

    @property
    def magnitude(self) -> FloatArray:
        """Size of the reading per Pa, shape (..., n, 2)."""
        return _check.read_only(np.abs(self.amplitude))

    @property
    def phase(self) -> FloatArray:
        """Phase of the reading against the traction straight above the sensor [rad], shape (..., n, 2).

        0 where the reading is largest with a crest above the sensor, pi (or -pi) where it is then most negative; pi/2
        where it is largest with the crest a quarter of a wave further towards +y. 0 where nothing is read.
        """
        turn = np.exp(-1j * self.wavenumber[..., None] * np.asarray(self.finger.array.y))
        own = self.amplitude * turn[..., None]
        # a part that is rounding alone must not turn pi into -pi, nor nothing into some angle
        small = 1e-12 * np.abs(own)
        real = np.where(np.abs(own.real) > small, own.real, 0.0)
        imaginary = np.where(np.abs(own.imag) > small, own.imag, 0.0)
        return _check.read_only(np.arctan2(imaginary, real + 0.0))


@checked
def spatial_response(
    finger: Finger, wavenumber: Annotated[npt.ArrayLike, Real("rad/m", at_least=0.0)] | None = None
) -> SpatialResponse:
    """Amplitude and phase of every reading under a wave of pressure and under a wave of shear.

    The skin answers each wavenumber by itself: a half plane in closed form, layers and a round finger by their modes. A
    sensor's position turns the phase; its width w takes the mean over it, a factor sin(k w / 2) / (k w / 2). For a half
    plane at nu = 1/2 and normal strain at depth d this is -(3 / 2E) k d exp(-k d) for pressure, the memo's eq. (25)
    over E, and -(3i / 2E) (1 - k d) exp(-k d) for shear. Source: memo section 6.0; docs/theory.md and docs/skins.md.

    Parameters
    ----------
    finger : Finger
        Any skin; transducers that are linear, or have a linear part.
    wavenumber : array_like, shape (...), optional
        k = 2 pi / wavelength [rad/m], >= 0; 2 pi times the memo's s. k = 0 is the limit of long waves. On a round
        finger whole numbers over its radius. If left out, what is worth drawing: 240 waves, or all that close round the
        finger, up to 12 over the depth of the shallowest sensor.

    Raises
    ------
    InvalidValueError
        k < 0; waves that do not close round a finger; k = 0 where a layer slides.
    NotLinearError
        A transducer that has no linear part.

    Examples
    --------
    >>> import subskin as ss
    >>> skin = ss.HalfPlane(ss.Material(young=0.4e6, poisson=0.5))
    >>> finger = ss.Finger(skin, ss.SensorArray(y=[0.0], depth=2e-3))
    >>> found = ss.design.spatial_response(finger, [0.0, 1 / 2e-3])  # no end, and a wave of 2 pi depths
    >>> (found.magnitude[:, 0] * 0.4e6).round(6).tolist()
    [[0.0, 1.5], [0.551819, 0.0]]
    """
    k = _check.read_only(_drawn(finger) if wavenumber is None else wavenumber)
    array = finger.array
    for kind in array.transducers:
        kind.linearise(np.zeros(0))  # refuses what cannot be made linear
    flat = k.reshape(-1)
    depths, which = np.unique(np.asarray(array.depth), return_inverse=True)
    halves = finger.skin.wave(flat, depths).halves
    kinds = [kind.linear_part for kind in array.transducers]
    out = np.empty((flat.size, len(array), 2), dtype=np.complex128)
    for kind in dict.fromkeys(kinds):
        chosen = np.array([i for i, own in enumerate(kinds) if own == kind], dtype=np.intp)
        even, odd = (kind.measure(half)[:, which[chosen]] for half in halves)
        # under exp(i k y) of pressure what goes with sin(k y) lags a quarter of a wave; of a drag the rest leads by one
        out[:, chosen] = np.stack([even[..., 0] - 1j * odd[..., 0], odd[..., 1] + 1j * even[..., 1]], axis=-1)
    seen = np.asarray(array.gain) * np.sinc(flat[:, None] * np.asarray(array.width) / (2 * np.pi))
    out *= (seen * np.exp(1j * flat[:, None] * np.asarray(array.y)))[..., None]
    return SpatialResponse(finger, k, out.reshape(*k.shape, len(array), 2))


def _drawn(finger: Finger) -> FloatArray:
    """Wavenumbers from long waves to those that the shallowest sensor no longer feels."""
    last = _SHORT / float(np.asarray(finger.array.depth).min())
    if turn := finger.skin.curvature:
        return turn * np.arange(np.ceil(last / turn * (1 - 1e-12)) + 1)
    return last * np.arange(1, _WAVES + 1) / _WAVES
