"""Contact points of MuJoCo in the axes of a geom; and readings of forces at points, by a lattice of known readings."""

from __future__ import annotations

import numpy as np

from .._compiled import compiled

__all__ = ["contacts_of", "read_points"]


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


@compiled(borrows=True)
def contacts_of(geom, elliptic, contacts, forces, pose, others, out):
    """Fill `others` (k,) with the geoms that press on a geom, and `out` (k, 3, 3): force, twist and point in its axes.

    contacts: of MuJoCo's contact points geom (c, 2), pos (c, 3), frame (c, 9), dim, efc_address (c,) and friction
    (c, 5); forces: its efc_force; pose: centre (3,) and axes (9,) of the geom. Pyramids are decoded as MuJoCo does:
    the normal force is the sum over their edges, a tangential one the difference of two times its friction. Returns
    their count k.
    """
    pairs, points, frames, dims, addresses, frictions = contacts
    centre, turn = pose
    count = 0
    force_at, twist_at = out[out.shape[0] - 1, 0], out[out.shape[0] - 1, 1]  # scratch behind what is filled
    for c in range(pairs.shape[0]):
        first = pairs[c, 0] == geom
        start = addresses[c]
        if (not first and pairs[c, 1] != geom) or start < 0:
            continue
        dim = dims[c]
        force_at[:] = 0.0
        twist_at[:] = 0.0
        for i in range(dim if elliptic else max(dim - 1, 1)):
            one, part = forces[start + i], i
            if not elliptic and dim > 1:
                one, two, part = forces[start + 2 * i], forces[start + 2 * i + 1], i + 1
                force_at[0] += one + two
                one = (one - two) * frictions[c, i]
            if part < 3:
                force_at[part] = one
            else:
                twist_at[part - 3] = one
        sign = -1.0 if first else 1.0
        others[count] = pairs[c, 1] if first else pairs[c, 0]
        for j in range(3):
            force, twist, at = 0.0, 0.0, 0.0
            for i in range(3):
                axis = 0.0
                for k in range(3):
                    axis += frames[c, 3 * i + k] * turn[3 * k + j]
                force += force_at[i] * axis
                twist += twist_at[i] * axis
                at += (points[c, i] - centre[i]) * turn[3 * i + j]
            out[count, 0, j] = sign * force
            out[count, 1, j] = sign * twist
            out[count, 2, j] = at
        count += 1
    return count
