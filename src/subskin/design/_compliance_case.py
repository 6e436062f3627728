"""Which fingers and particles the study of compliance can answer for."""

from __future__ import annotations

import numpy as np

from .. import _check
from ..errors import GeometryError, InvalidValueError, NotLinearError
from ..finger import Finger
from ..pressing import ParticleOnFlat

__all__ = ["check_case"]


def check_case(finger: Finger, particle: ParticleOnFlat) -> None:
    """Refuse a finger whose readings do not determine the particle, and a skin that would touch all along."""
    if len(finger.array) < 4:
        raise InvalidValueError(
            f"{len(finger.array)} sensors",
            "width, height, position and force are four unknowns",
            "a finger with four sensors or more",
        )
    if not (np.asarray(finger.array.noise) > 0).all():
        raise InvalidValueError("noise = 0", "the answer depends on the noise of the sensors", "noise=1e-4")
    if not all(t.linear for t in finger.array.transducers):
        raise NotLinearError(
            "a transducer that is not linear", "a modulus scales the readings of linear ones only", "NormalStrain()"
        )
    _check.noun("particle", particle, ParticleOnFlat, "pressing.ParticleOnFlat(4e-4, 3e-5, flat_half_width=1e-2)")
    if np.isinf(finger.skin.period) and np.isinf(particle.flat_half_width):
        raise GeometryError(
            f"a flat skin, {type(finger.skin).__name__}, on a flat without end", "they would touch all along",
            "flat_half_width= of the particle's flat, or a round skin",
        )  # fmt: skip
    if _differing(finger) < 3:
        raise InvalidValueError(
            f"{len(finger.array)} sensors, alike on both sides of the particle",
            "they have two different readings for its width, its height and the force",
            "a finger with five sensors or more",
        )


def _differing(finger: Finger) -> int:
    """How many readings of a particle at the middle differ: two sensors alike on both sides of it read the same."""
    a = finger.array
    rows = np.stack([np.asarray(v, dtype=np.float64) for v in (a.y, a.depth, a.gain, a.noise)])[:, np.argsort(a.y)]
    mirrored = rows[:, ::-1] * [[-1.0], [1.0], [1.0], [1.0]]
    alike = bool(np.allclose(rows, mirrored, rtol=1e-9, atol=1e-9 * float(np.abs(rows[0]).max())))
    return (len(a) + 1) // 2 if alike else len(a)
