"""The compiled loop of `project.py` for frames of which each has noise of its own, as after a touch that was held.

All that the search has prepared is in units of the sensors' noise. A frame with a doubt has more of it, by another
ratio at each sensor: what was prepared is put into its units, and the frame goes through the same loop by itself.
"""

from __future__ import annotations

import math

import numpy as np

from .._compiled import compiled
from .project import project_frames

_OPEN = 0.5
"""Of the share `near` of `Stretches`, which was measured in the units of the sensors' noise: nodes are climbed from
that explain so much less."""


@compiled(frames="readings")
def doubted_frames(readings, doubt, arrays, fields, out):
    """Fill `out` as `project_frames` does, with noise sqrt(noise^2 + doubt^2) of each reading.

    doubt (f, n) [reading]; arrays: those of `project_frames` between the readings and `out`; fields (k, n, 2): the
    columns at the nodes of the scan, and of what lies beyond, in units of the noise.
    """
    sensors, basis, edges, shapes, squares, far, nodes, table, settings = arrays
    frames, n = readings.shape
    ranged, mu = shapes.shape[1], settings[0].friction
    size = squares.size * settings[0].positions
    mine, white, edge, shape = sensors.copy(), basis.copy(), edges.copy(), shapes.copy()
    beyond, tabled, told = far.copy(), table.copy(), settings.copy()
    told[0].near *= _OPEN
    largest = np.abs(fields[:size]).max()
    ratio = np.empty(n)
    cells, own_cells = table.reshape(-1, n), tabled.reshape(-1, n)
    far_cells, own_far = far.reshape(-1, n), beyond.reshape(-1, n)
    for f in range(frames):
        for i in range(n):
            more = doubt[f, i] * sensors[1, i]
            ratio[i] = 1.0 / math.sqrt(1.0 + more * more)
            mine[1, i] = sensors[1, i] * ratio[i]
        for k in range(cells.shape[0]):
            for i in range(n):
                own_cells[k, i] = cells[k, i] * ratio[i]
        for k in range(far_cells.shape[0]):
            for i in range(n):
                own_far[k, i] = far_cells[k, i] * ratio[i]
        top = 0.0
        for k in range(fields.shape[0]):
            # as `scan_geometry`
            normal2 = both = 0.0
            for i in range(n):
                a, b = fields[k, i, 0] * ratio[i], fields[k, i, 1] * ratio[i]
                normal2 += a * a
                both += a * b
                if k < size:
                    top = max(top, abs(a), abs(b))
            length = math.sqrt(normal2)
            scale = 1.0 / length if length > 0.0 else 1.0
            along = both * scale
            rest2 = 0.0
            for i in range(n):
                rest = (fields[k, i, 1] - along * scale * fields[k, i, 0]) * ratio[i]
                rest2 += rest * rest
            across = math.sqrt(rest2)
            turn = 1.0 / across if across > 0.0 else 1.0
            for i in range(n):
                a = fields[k, i, 0] * ratio[i] * scale
                white[i, 0, k] = a
                white[i, 1, k] = (fields[k, i, 1] * ratio[i] - along * a) * turn
            for side in range(2):
                sign = 2.0 * side - 1.0
                one, other = (1.0, sign * mu) if mu < math.inf else (0.0, sign)
                x, y = one * length + other * along, other * across
                far_off = math.sqrt(x * x + y * y)
                unit = 1.0 / far_off if far_off > 0.0 else 1.0
                edge[2 * side, k], edge[2 * side + 1, k] = x * unit, y * unit
            if k < ranged:
                shape[0, k], shape[1, k], shape[2, k] = length, along, across
        if largest > 0.0:
            told[0].fine = settings[0].fine * (top / largest) ** 2
        project_frames(
            readings[f : f + 1], mine, white, edge, shape, squares, beyond, nodes, tabled, told, out[f : f + 1]
        )
