"""Compiled: readings of a `RadialResponse` under unit forces, one load and sensor after the other."""

from __future__ import annotations

import math

import numpy as np

from ._compiled import compiled

__all__ = ["readings_at"]


@compiled()
def readings_at(points, depth, gain, kind, coefficients, terms, per_octave, positions, out):
    """Fill out (m, n, 3): N, Ty and Tz at positions (m, 2); all else as of `RadialResponse`, cells an octave given.

    A position that is not finite has no reading.
    """
    _, cells, functions, powers = coefficients.shape
    highest, values = (cells - 1) // per_octave, np.empty(functions)
    for m in range(len(positions)):
        for i in range(len(points)):
            dy, dz = points[i, 0] - positions[m, 0], points[i, 1] - positions[m, 1]
            v = 1.0 + (dy * dy + dz * dz) / (depth[i] * depth[i])
            if not v < math.inf:
                out[m, i, :] = math.nan
                continue
            octave = min(math.frexp(v)[1] - 1, highest)
            share = (math.ldexp(v, -octave) - 1.0) * per_octave
            inner = int(min(share, per_octave - 1.0))  # a share may be beyond all whole numbers
            t, cell = share - inner - 0.5, coefficients[kind[i], octave * per_octave + inner]
            for f in range(functions):
                total = cell[f, powers - 1]
                for k in range(powers - 2, -1, -1):
                    total = total * t + cell[f, k]
                values[f] = gain[i] * total
            out[m, i, :] = 0.0
            for j in range(len(terms)):
                re, im = 1.0, 0.0  # (dy + i dz)^order
                for _ in range(terms[j, 1]):
                    re, im = re * dy - im * dz, re * dz + im * dy
                out[m, i, terms[j, 0]] += terms[j, 4] * values[terms[j, 3]] * (im if terms[j, 2] else re)
