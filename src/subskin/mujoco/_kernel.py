"""Readings of forces at points: each is laid on the nodes of a lattice around it, whose readings are known."""

from __future__ import annotations

import numpy as np

from .._compiled import compiled

__all__ = ["read_points"]


@compiled(borrows=True)
def read_points(points, forces, origin, step, response, share, weights, out):
    """Add to `out` (n,) what forces (m, 3) at points (m, 2) [m] make the sensors read.

    response (j, k, 3, n): readings under unit forces at the nodes origin + step * (j, k). Four nodes along an axis
    take what a cubic through them would: force and moments are kept. share (j, k, 3), 0 before and
    after, and weights (2, 4) are scratch.
    """
    rows, columns, sensors = response.shape[0], response.shape[1], response.shape[3]
    along, across = weights
    low_j, high_j, low_k, high_k = rows, 0, columns, 0
    for i in range(points.shape[0]):
        j = _weights((points[i, 0] - origin[0]) / step, rows, along)
        k = _weights((points[i, 1] - origin[1]) / step, columns, across)
        low_j, high_j, low_k, high_k = min(low_j, j), max(high_j, j + 4), min(low_k, k), max(high_k, k + 4)
        for a in range(4):
            for b in range(4):
                weight = along[a] * across[b]
                for c in range(3):
                    share[j + a, k + b, c] += weight * forces[i, c]
    for j in range(low_j, high_j):
        for k in range(low_k, high_k):
            for c in range(3):
                force = share[j, k, c]
                share[j, k, c] = 0.0
                if force != 0.0:
                    for n in range(sensors):
                        out[n] += force * response[j, k, c, n]


@compiled(borrows=True)
def _weights(at, count, weights):
    """The first of four nodes around `at`, in steps, and the `weights` of the cubic through them."""
    first = min(max(int(np.floor(at)) - 1, 0), count - 4)
    t = at - first - 1.0
    weights[0] = -t * (t - 1.0) * (t - 2.0) / 6.0
    weights[1] = (t + 1.0) * (t - 1.0) * (t - 2.0) / 2.0
    weights[2] = -(t + 1.0) * t * (t - 2.0) / 2.0
    weights[3] = (t + 1.0) * t * (t - 1.0) / 6.0
    return first
