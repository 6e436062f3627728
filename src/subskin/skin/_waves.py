"""Each skin under a wave of traction that goes on for ever: what its closed form or its modes say of one wavenumber."""

from __future__ import annotations

import numpy as np

from .._check import ComplexArray, FloatArray
from ..errors import InvalidValueError
from ..tensor import State
from ._ring_modes import Ring
from ._synthesis import hooke
from .base import Skin
from .half_plane import HalfPlane
from .layered import Layered
from .round import Round

__all__ = ["wave_state"]

# sigma_x and eps_y go with cos(k y) under p = cos(k y), tau_xy with sin(k y); under q = sin(k y) likewise. Under p and
# q of exp(i k y) they are these times the amplitudes, first sigma_x, tau_xy, eps_y, then p, q.
_TURNS = np.array([[1, 1j], [-1j, 1], [1, 1j]])
_LONG = 1e-9
"""Waves so many times as long as a stack is thick stand for those without end."""


def wave_state(skin: Skin, k: FloatArray, x: FloatArray) -> State:
    """State at y = 0 under tractions exp(i k y) of 1 Pa, at k >= 0 [1/m], shape (m,), and depths x [m], shape (d,).

    Components have the shape (m, d, 2, 2): the load (p, q), then the real and the imaginary part. Whatever is linear in
    a state does not mix the two.

    Raises
    ------
    InvalidValueError
        A skin of another kind; waves that do not close round a finger; k = 0 where a layer slides, for a drag without
        end then stretches it without bound.
    """
    if isinstance(skin, HalfPlane):
        # the transform of exp(i k t) is 2 pi i exp(i k z), and that of its real part half of it (docs/theory.md)
        kx = (k[:, None] * x)[..., None]
        fall = np.exp(-kx)
        mean, half = fall * np.array([-1, 1j]), fall * np.concatenate([kx, 1j * (1 - kx)], axis=-1)
        shear = fall * np.concatenate([1j * kx, kx - 1], axis=-1)
        parts = [_parts(a) for a in (mean, half, shear)]
        return State(skin._stress(*parts), skin._strain(*parts))
    if isinstance(skin, Layered):
        if not k.all() and any(layer.bond == "frictionless" for layer in skin.stack):
            raise InvalidValueError(
                "a wave without end, k = 0", "under a layer that slides its drag has no limit", "k > 0"
            )
        waves = np.where(k > 0, k, _LONG / skin.modes.tops[-1])
        y = skin.modes.amplitudes(waves, x).transpose(1, 0, 2, 3)
        along = waves[:, None, None] * y[:, :, 1] / (2 * skin.stack[0].material.shear)
        fields = _parts(_TURNS * np.stack([y[:, :, 2], y[:, :, 3], along], axis=2))
        depths = np.broadcast_to(x[:, None, None], (k.size, x.size, 2, 2))
        return skin._state(np.moveaxis(fields, 2, 0), depths)
    if isinstance(skin, Round):
        skin.surface_compliance(k)  # refuses waves that do not close round the finger
        ring, n = Ring(skin.material.poisson, skin.radius, skin.core_radius), np.round(k * skin.radius)
        answer = ring.stresses(n, x)
        for i, depth in enumerate(x):
            answer[i] += ring._shown(ring._disk(n, skin.radius - depth))
        answer[:, :, 2] /= 2 * skin.material.shear
        fields = _parts(np.asarray(_TURNS * answer.transpose(1, 0, 2, 3)))
        return hooke(np.moveaxis(fields, 2, 0), skin.material)
    raise InvalidValueError(f"a skin of kind {type(skin).__name__}", "its answer to a wave is not known")


def _parts(values: ComplexArray) -> FloatArray:
    return np.stack([values.real, values.imag], axis=-1)
