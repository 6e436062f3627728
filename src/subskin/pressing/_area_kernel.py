"""Loops over a grid on an area: over spectra, for the pressure beneath a body, for the drag (bounded.py).

Maps by transforms may be wider than the grid. A spectrum is given as real numbers: real and imaginary parts in turn
along a row. A body may sink and lean, or slide and turn: the multipliers of these rigid motions, level + lean_y y +
lean_z z and (slide_y - turn z, slide_z + turn y), come as three numbers. Where a node sticks both components of its
drag are free, where it slips what is along its `tangent` is.
"""

from __future__ import annotations

import math

import numpy as np

from .._compiled import compiled

__all__ = [
    "advance",
    "answered",
    "curve",
    "drag_advance",
    "drag_left",
    "drag_projected",
    "inner",
    "keep",
    "left",
    "less",
    "open_beyond",
    "projected",
    "scaled",
    "sorted_out",
    "sums",
    "turned",
    "wrong_way",
]


@compiled(borrows=True)
def scaled(waves, by):
    """A spectrum times a real one."""
    for i in range(by.shape[0]):
        for j in range(by.shape[1]):
            waves[i, 2 * j] *= by[i, j]
            waves[i, 2 * j + 1] *= by[i, j]


@compiled(borrows=True)
def turned(waves, yy, zz, yz):
    """Spectra of two components times a symmetric matrix of real ones."""
    for i in range(yy.shape[0]):
        for j in range(yy.shape[1]):
            for part in range(2 * j, 2 * j + 2):
                y, z = waves[0, i, part], waves[1, i, part]
                waves[0, i, part] = yy[i, j] * y + yz[i, j] * z
                waves[1, i, part] = yz[i, j] * y + zz[i, j] * z


@compiled(borrows=True)
def sums(values, free, y, z):
    """Sums of a map over the nodes that touch: plain, times y, times z."""
    plain, by_y, by_z = 0.0, 0.0, 0.0
    for i in range(free.shape[0]):
        row, across = 0.0, 0.0
        for j in range(free.shape[1]):
            value = values[i, j] * free[i, j]
            row += value
            across += value * z[j]
        plain += row
        by_y += row * y[i]
        by_z += across
    return plain, by_y, by_z


@compiled(borrows=True)
def left(gradient, free, y, z, level, lean_y, lean_z, residual):
    """The gap where nodes touch, 0 elsewhere."""
    for i in range(free.shape[0]):
        base = level + lean_y * y[i]
        for j in range(free.shape[1]):
            residual[i, j] = (gradient[i, j] - base - lean_z * z[j]) * free[i, j]


@compiled(borrows=True)
def open_beyond(gradient, outside, y, z, level, lean_y, lean_z):
    """The deepest overlap of the bodies where nodes do not touch."""
    least = 0.0
    for i in range(outside.shape[0]):
        base = level + lean_y * y[i]
        for j in range(outside.shape[1]):
            if outside[i, j]:
                least = min(least, gradient[i, j] - base - lean_z * z[j])
    return -least


@compiled(borrows=True)
def projected(answer, residual, free, y, z, level, lean_y, lean_z, out):
    """The answer where nodes touch less a rigid motion, and its product with the residual."""
    total = 0.0
    for i in range(free.shape[0]):
        base = level + lean_y * y[i]
        for j in range(free.shape[1]):
            value = np.float32((answer[i, j] - base - lean_z * z[j]) * free[i, j])
            out[i, j] = value
            total += value * residual[i, j]
    return total


@compiled(borrows=True)
def inner(one, wide):
    """Sum of products of two maps, of which the second may be wider."""
    total = 0.0
    for i in range(one.shape[0]):
        for j in range(one.shape[1]):
            total += one[i, j] * wide[i, j]
    return total


@compiled()
def advance(x, gradient, direction, moved, length):
    """One step along a direction: the greatest displacement by it, and the least pressure after it."""
    n, k = x.shape
    most, least = np.zeros(k), np.zeros(k)
    for i in range(n):
        for j in range(k):
            by = length * moved[i, j]
            gradient[i, j] += by
            x[i, j] += length * direction[i, j]
            most[j] = max(most[j], abs(by))
            least[j] = min(least[j], x[i, j])
    return most.max(), least.min()


@compiled(borrows=True)
def drag_left(gradient, stick, tangent, stiff, turned, y, z, motion, weights, residual, totals):
    """What is left of the slip where it may not be, and its products with the weights of the rigid motions."""
    totals[:] = 0.0
    for i in range(stick.shape[0]):
        for j in range(stick.shape[1]):
            a = gradient[0, i, j] - (motion[0] - motion[2] * z[j])
            b = gradient[1, i, j] - (motion[1] + motion[2] * y[i])
            t, u = tangent[0, i, j], tangent[1, i, j]
            across = a * t + b * u + stiff[i, j] * turned[i, j]
            residual[0, i, j] = a * stick[i, j] + across * t
            residual[1, i, j] = b * stick[i, j] + across * u
        for c in range(weights.shape[0]):
            total = 0.0
            for j in range(stick.shape[1]):
                total += weights[c, 0, i, j] * residual[0, i, j] + weights[c, 1, i, j] * residual[1, i, j]
            totals[c] += total


@compiled(borrows=True)
def less(residual, stick, tangent, y, z, motion, soft, softened):
    """Take a rigid motion off what is left; the same, softened."""
    for i in range(stick.shape[0]):
        for j in range(stick.shape[1]):
            a, b = motion[0] - motion[2] * z[j], motion[1] + motion[2] * y[i]
            t, u = tangent[0, i, j], tangent[1, i, j]
            across = a * t + b * u
            residual[0, i, j] -= a * stick[i, j] + across * t
            residual[1, i, j] -= b * stick[i, j] + across * u
            softened[0, i, j] = residual[0, i, j] * soft[i, j]
            softened[1, i, j] = residual[1, i, j] * soft[i, j]


@compiled(borrows=True)
def keep(maps, stick, tangent):
    """Leave of maps what may change: all where it sticks, what is across the drag where it slips."""
    for c in range(maps.shape[0]):
        for i in range(stick.shape[0]):
            for j in range(stick.shape[1]):
                a, b = maps[c, 0, i, j], maps[c, 1, i, j]
                across = a * tangent[0, i, j] + b * tangent[1, i, j]
                maps[c, 0, i, j] = a * stick[i, j] + across * tangent[0, i, j]
                maps[c, 1, i, j] = b * stick[i, j] + across * tangent[1, i, j]


@compiled(borrows=True)
def answered(nearly, residual, stick, tangent, soft, direct, y, z, out):
    """The answer on what may change, and its sums: along y, along z, turning."""
    along_y, along_z, turning = 0.0, 0.0, 0.0
    for i in range(stick.shape[0]):
        row, column, torsion = 0.0, 0.0, 0.0
        for j in range(stick.shape[1]):
            a, b = nearly[0, i, j] * soft[i, j], nearly[1, i, j] * soft[i, j]
            t, u = tangent[0, i, j], tangent[1, i, j]
            across = a * t + b * u
            a = np.float32(a * stick[i, j] + across * t + direct[i, j] * residual[0, i, j])
            b = np.float32(b * stick[i, j] + across * u + direct[i, j] * residual[1, i, j])
            out[0, i, j], out[1, i, j] = a, b
            row += a
            column += b
            torsion -= a * z[j]
        along_y += row
        along_z += column
        turning += torsion + column * y[i]
    return along_y, along_z, turning


@compiled(borrows=True)
def drag_projected(out, residual, weights, shares):
    """The answer less shares of the weights, and its product with the residual."""
    total = 0.0
    for part in range(2):
        for i in range(out.shape[1]):
            for c in range(weights.shape[0]):
                share = np.float32(shares[c])
                for j in range(out.shape[2]):
                    out[part, i, j] -= share * weights[c, part, i, j]
            for j in range(out.shape[2]):
                total += out[part, i, j] * residual[part, i, j]
    return total


@compiled(borrows=True)
def curve(direction, moved, tangent, stiff):
    """What a step along a direction costs: by displacements, and by turning where it slips."""
    total = 0.0
    for i in range(stiff.shape[0]):
        for j in range(stiff.shape[1]):
            a, b = direction[0, i, j], direction[1, i, j]
            across = a * tangent[0, i, j] + b * tangent[1, i, j]
            total += a * moved[0, i, j] + b * moved[1, i, j] + stiff[i, j] * across * across
    return total


@compiled()
def drag_advance(q, gradient, turned, direction, moved, length, tangent, held):
    """One step along a direction: the greatest displacement by it, and by how much drags leave the cone after it."""
    n, k = held.shape
    most, over = np.zeros(k), np.zeros(k)
    for i in range(n):
        for j in range(k):
            a, b = length * direction[0, i, j], length * direction[1, i, j]
            by, bz = length * moved[0, i, j], length * moved[1, i, j]
            gradient[0, i, j] += by
            gradient[1, i, j] += bz
            q[0, i, j] += a
            q[1, i, j] += b
            turned[i, j] += a * tangent[0, i, j] + b * tangent[1, i, j]
            most[j] = max(most[j], abs(by), abs(bz))
            over[j] = max(over[j], math.sqrt(q[0, i, j] ** 2 + q[1, i, j] ** 2) - held[i, j])
    return most.max(), over.max()


@compiled(borrows=True)
def wrong_way(gradient, y, z, motion, slides, tangent):
    """The greatest slip along the drag where nodes slip."""
    most = 0.0
    for i in range(slides.shape[0]):
        for j in range(slides.shape[1]):
            if slides[i, j]:
                a = gradient[0, i, j] - (motion[0] - motion[2] * z[j])
                b = gradient[1, i, j] - (motion[1] + motion[2] * y[i])
                most = max(most, a * tangent[1, i, j] - b * tangent[0, i, j])
    return most


@compiled(borrows=True)
def sorted_out(q, gradient, y, z, motion, held, sticks, least, tangent, stiff, change):
    """Let nodes slip whose drag is too great, and stick that slip along it: how many stick again, and the most across.

    Writes tangents, by how much a drag that turns answers, and what brings drags that slip to the greatest.
    """
    back, across = 0, 0.0
    for i in range(held.shape[0]):
        for j in range(held.shape[1]):
            tangent[0, i, j] = tangent[1, i, j] = stiff[i, j] = change[0, i, j] = change[1, i, j] = 0.0
            if held[i, j] <= 0:
                continue
            a = gradient[0, i, j] - (motion[0] - motion[2] * z[j])
            b = gradient[1, i, j] - (motion[1] + motion[2] * y[i])
            size = math.sqrt(q[0, i, j] ** 2 + q[1, i, j] ** 2)
            along = (q[0, i, j] * a + q[1, i, j] * b) / max(size, 1e-300)
            if sticks[i, j]:
                if size > held[i, j]:
                    sticks[i, j] = False
            else:
                across = max(across, abs(q[0, i, j] * b - q[1, i, j] * a) / max(size, 1e-300))
                if along > least or size == 0.0:
                    sticks[i, j] = True
                    back += 1
            if not sticks[i, j]:
                tangent[0, i, j], tangent[1, i, j] = -q[1, i, j] / size, q[0, i, j] / size
                stiff[i, j] = max(-along, 0.0) / held[i, j]
                grow = held[i, j] / size - 1
                change[0, i, j], change[1, i, j] = grow * q[0, i, j], grow * q[1, i, j]
    return back, across
