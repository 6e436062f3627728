"""What may press where the shape is not known: many pressures of one size, on the nodes of a lattice."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..._check import FloatArray

__all__ = ["Tractions", "tractions"]

_LEAN, _TURN = 0.3, 0.25
"""Standard deviations of a drag and of a moment, in normal forces and in these times the root mean square radius."""
_SIZES, _ASPECT, _NARROW = 0.2, 0.35, 0.6
"""Of the logarithm of a size, either way; of that of a side over the mean one, its standard deviation and its most."""
_CORNERS, _ENDS = np.array([2.0, 2.0, 4.0, 8.0]), np.array([0.0, 0.5, 1.0, 2.0])
"""Exponents of an outline, from an ellipse to a rectangle, and of the fall towards it: even, of a ball, a cone."""
_ROUGH, _WAVES, _LENGTHS = np.array([0.0, 0.0, 0.5, 1.0]), 8, (2.4, 10.0)
"""Standard deviations of the pressure's logarithm, waves that it is made of, and their lengths in half sizes."""
_REACH = 2.3
"""Half sizes from its middle up to which a pressure reaches."""


class Tractions(NamedTuple):
    """Tractions on the nodes of a window: of each pressure of force 1, and of drags and moments that may go with it.

    nodes (w, d): whole steps from the middle of the window; values (pressures, loads, w, d + 1): the share of a node,
    inwards and along y and z. Each load stands for a standard deviation of its own.
    """

    nodes: FloatArray
    values: FloatArray


def tractions(size: float, cell: float, dim: int, count: int) -> Tractions:
    """Pressures of about one half size, whose middles lie in a cell of the surface; both in steps of the lattice.

    They are ellipses and rectangles, long, short and turned, even or falling towards their edges, smooth or rough, in
    islands too. They are always the same ones.

    Examples
    --------
    >>> some = tractions(size=2.0, cell=2.0, dim=2, count=5)
    >>> some.values.shape[:2], some.values[:, 0, :, 0].sum(axis=-1).round(12).tolist()
    ((5, 4), [1.0, 1.0, 1.0, 1.0, 1.0])
    """
    rng = np.random.default_rng([771, dim, round(1e3 * size)])
    half = int(np.ceil(_REACH * size + 0.5 * cell))
    line = np.arange(-half, half + 1.0)
    nodes = np.stack(np.meshgrid(*dim * [line], indexing="ij"), axis=-1).reshape(-1, dim)
    pressure = np.stack([_pressure(nodes - cell * rng.uniform(-0.6, 0.6, dim), size, rng) for _ in range(count)])
    values = np.zeros((count, 2 * dim, len(nodes), dim + 1))
    values[:, 0, :, 0] = pressure
    for along in range(dim):
        values[:, 1 + along, :, 1 + along] = _LEAN * pressure
    if dim > 1:
        away = nodes - (pressure @ nodes)[:, None]
        radius = np.sqrt(np.einsum("pw,pwd->p", pressure, away**2))
        twist = _TURN * pressure / np.where(radius > 0, radius, np.inf)[:, None]
        values[:, -1, :, 1], values[:, -1, :, 2] = -twist * away[..., 1], twist * away[..., 0]
    pressed = pressure.any(axis=0)
    return Tractions(nodes[pressed], values[:, :, pressed])


def _pressure(at: FloatArray, size: float, rng: np.random.Generator) -> FloatArray:
    """Shares of the nodes (w,) in a pressure about 0."""
    dim = at.shape[1]
    size *= float(np.exp(rng.uniform(-_SIZES, _SIZES)))
    lean, turn = np.clip(rng.normal(0.0, _ASPECT), -_NARROW, _NARROW), rng.uniform(0.0, np.pi)
    sides = size * np.exp(lean * np.array([1.0, -1.0])[:dim]) if dim > 1 else np.array([size])
    cos, sin = np.cos(turn), np.sin(turn)
    own = at @ np.array([[cos, -sin], [sin, cos]]) if dim > 1 else at
    left = 1.0 - (np.abs(own / sides) ** rng.choice(_CORNERS)).sum(axis=1)
    lengths, angles = size * rng.uniform(*_LENGTHS, _WAVES), rng.uniform(0.0, 2 * np.pi, (2, _WAVES))
    along = np.stack([np.cos(angles[0]), np.sin(angles[0])])[:dim] if dim > 1 else np.ones((1, _WAVES))
    waves = np.cos(at @ (2 * np.pi / lengths * along) + angles[1]).sum(axis=1) / np.sqrt(0.5 * _WAVES)
    out = np.where(left > 0, np.maximum(left, 0.0) ** rng.choice(_ENDS) * np.exp(rng.choice(_ROUGH) * waves), 0.0)
    if rng.random() < _ISLANDS:
        out = np.where(waves > 0, out, 0.0)
    if not out.any():  # smaller than a step
        out[np.argmin((at**2).sum(axis=1))] = 1.0
    return np.asarray(out / out.sum())


_ISLANDS = 0.4
"""Share of the pressures that press in islands alone."""
