"""One wavenumber of antiplane shear in a stack of layers: what moves across the direction of the wave.

u = D exp(-k s) p, tau = -G k D exp(-k s) m at a depth s of a layer, with t = thickness - s above its bottom,

    p = P + rho expm1(-2 k t),   m = M - rho expm1(-2 k t),   P + M = 2,   rho = (P - M) / 2.

A rigid base has (M, P) = (2, 0), one without friction (0, 2), a half space (1, 1); from one layer to that above it
M : P = m G_below / G_above : p. All parts are >= 0: nothing cancels, nothing grows (docs/skins.md).
"""

from __future__ import annotations

import numpy as np

from .._check import FloatArray
from ._layer_modes import Stack

__all__ = ["antiplane"]


def antiplane(stack: Stack, k: FloatArray, x: FloatArray) -> FloatArray:
    """Shear stress tau and displacement G k u under a drag of 1 Pa across the wave, shape (x, k, 2) [Pa].

    G is the shear modulus of the first layer. The first layer's are less what a half space of its material would have:
    c exp(-k x) with c = -1 and 1.

    Parameters
    ----------
    stack : Stack
        The layers.
    k : ndarray, shape (k,)
        Wavenumbers [1/m], > 0.
    x : ndarray, shape (x,)
        Depths [m].
    """
    bottoms: list[FloatArray] = []  # M of each layer, from below
    ratios: list[FloatArray] = []  # D beneath it over D exp(-k thickness)
    one = np.ones_like(k)
    m, p, below = one, one, 0.0 if stack.base is None else stack.base.shear
    for layer in reversed(stack.layers):
        if not layer.bonded:
            low, ratio = 0 * one, 0 * one
        elif stack.base is None and not bottoms:
            low, ratio = 2 * one, 0 * one
        else:
            stiff = below / layer.shear
            ratio = 2 / (stiff * m + p)
            low = stiff * m * ratio
        fall = (1 - low) * np.expm1(-2 * k * layer.thickness)
        m, p, below = low - fall, 2 - low + fall, layer.shear
        bottoms.append(low)
        ratios.append(ratio)
    first, tops, positions = stack.layers[0], stack.tops, stack.positions(x)
    out = np.empty((x.size, k.size, 2))
    size = 1 / m  # D of the first layer; that of a half space is 1
    for j, layer in enumerate(stack.layers):
        low, h = bottoms[-1 - j], layer.thickness
        rho = 1 - low
        for i in np.flatnonzero(positions == j):
            s = x[i] - tops[j]
            echo = np.exp(-2 * k * (h - s))
            if j == 0:
                share = rho * np.exp(-k * s) * size
                out[i, :, 0] = -share * echo * np.expm1(-2 * k * s)
                out[i, :, 1] = share * (echo + np.exp(-2 * k * h))
            else:
                here, fall = size * np.exp(-k * s), rho * np.expm1(-2 * k * (h - s))
                out[i, :, 0] = -here * (low - fall) * layer.shear / first.shear
                out[i, :, 1] = here * (2 - low + fall)
        size = size * np.exp(-k * h) * ratios[-1 - j]
    for i in np.flatnonzero(positions == len(stack.layers)):
        here = size * np.exp(-k * (x[i] - tops[-1]))
        stiff = 0.0 if stack.base is None else stack.base.shear / first.shear
        out[i] = np.stack([-stiff * here, here], axis=-1)
    return out
