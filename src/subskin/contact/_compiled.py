"""Sums over many loads, compiled; imported only where there are many."""

from __future__ import annotations

import numpy as np

from .._compiled import compiled, formula
from .functions import line, line_shear

_line, _shear = formula(line), formula(line_shear)


@compiled()
def add_lines(z, loads, out, field):
    """Transforms of line loads, F = -1/z and F' = 1/z^2 each, added up.

    z (m,); loads (3, n): position, normal and tangential force. Fills out (4, m), p, dp, q, dq, and field (m,),
    Im(q + i x dq), which for one load is T 2 x y^2 / r^4.
    """
    n = loads.shape[1]
    for k in range(z.size):
        x, y = z[k].imag, z[k].real
        pr = pi = dr = di = qr = qi = er = ei = h = 0.0
        for j in range(n):
            normal, tangential = loads[1, j], loads[2, j]
            (a, b), (c, d) = _line(np, x, y - loads[0, j])
            pr += normal * a
            pi += normal * b
            dr += normal * c
            di += normal * d
            qr += tangential * a
            qi += tangential * b
            er += tangential * c
            ei += tangential * d
            h += tangential * _shear(x, a)
        out[0, k] = complex(pr, pi)
        out[1, k] = complex(dr, di)
        out[2, k] = complex(qr, qi)
        out[3, k] = complex(er, ei)
        field[k] = h
