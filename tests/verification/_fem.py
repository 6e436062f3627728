"""A finite-element skin in plane strain: it shares nothing with subskin but what presses, given as functions of y.

Displacements are biquadratic on quadrilaterals, pressures linear within each and free to jump (Q2/P1): stable up to
Poisson's ratio 1/2 exactly, where the pressure's own block is zero, and fit for layers of different stiffness. A round
skin is meshed in Cartesian coordinates with curved elements; its local frame enters only with loads and readings.

As in subskin: x into the skin, y along the surface, tension positive, strain.xy the tensor's component.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
import skfem
from scipy.sparse import bsr_matrix
from scipy.sparse.linalg import splu
from skfem.helpers import div, dot
from skfem.refdom import RefQuad

_VECTOR = skfem.ElementVector(skfem.ElementQuad2())
_STIFFEST = 1e4


class Linear(skfem.ElementH1):
    """Linear within an element, with no regard to its neighbours."""

    interior_dofs = 3
    maxdeg = 1
    dofnames = ["p", "p_1", "p_2"]  # noqa: RUF012
    doflocs = np.full((3, 2), 0.5)
    refdom = RefQuad

    def lbasis(self, X, i):
        slope = np.zeros_like(X)
        if i == 0:
            return np.ones(X.shape[1:]), slope
        slope[i - 1] = 2.0
        return 2 * X[i - 1] - 1, slope


@skfem.BilinearForm
def _distortion(u, v, w):
    # 2 mu e(u) : e(v), written out: the helpers make arrays of every component first
    (a, b), (c, d) = u.grad
    (e, f), (g, h) = v.grad
    return w.modulus * (2 * (a * e + d * h) + (b + c) * (f + g))


@skfem.BilinearForm
def _expansion(u, p, w):
    return -p * div(u)


@skfem.BilinearForm
def _product(p, q, w):
    return p * q


@skfem.LinearForm
def _work(v, w):
    return dot(w.traction, v)


@skfem.BilinearForm
def _inward(p, v, w):
    return p * dot(w.inwards, v)


@skfem.LinearForm
def _share(p, w):
    return w.factor * p


def along(low, high, count, start, end, growth=1.2):
    """Edges of elements along a surface: `count` even ones from low to high, then growing out to start and end."""
    first = (high - low) / count

    def outwards(length):
        number = int(np.ceil(np.log1p(length / first * (growth - 1)) / np.log(growth)))
        steps = np.cumsum(growth ** np.arange(1.0, number + 1))
        return length * steps / steps[-1:]

    left, right = low - outwards(low - start)[::-1], high + outwards(end - high)
    return np.concatenate([left, np.linspace(low, high, count + 1), right])


def split(edges, parts):
    """Each element cut into `parts`."""
    share = np.arange(parts) / parts
    return np.append((edges[:-1, None] + np.diff(edges)[:, None] * share).ravel(), edges[-1])


def within(edges, at):
    """The element in which a place lies, the earlier one at an edge, and its share of it."""
    i = np.clip(np.searchsorted(edges, at) - 1, 0, edges.size - 2)
    return i, (at - edges[i]) / (edges[i + 1] - edges[i])


def per_row(layers, depths, stress):
    """Shear modulus, and 1 / Lame's first constant, of each row of elements between depths, in units of `stress`."""
    bottoms, young, nu = np.array(layers, dtype=float).T
    which = np.searchsorted(bottoms, 0.5 * (depths[1:] + depths[:-1]))
    return (young / (2 * (1 + nu)))[which] / stress, ((1 + nu) * (1 - 2 * nu) / (young * nu))[which] * stress


class Saddle:
    """A stiffness, factorised, with the pressures eliminated as if no bulk modulus were beyond `_STIFFEST`.

    With it what `solve` needs to make up for that: the expansion, the elements' moduli on it and the pressure kept.

    k, b, mass: distortion, expansion, and the product of pressures. modulus, over_lame: of each element.
    """

    def __init__(self, k, b, mass, modulus, over_lame):
        bulk = 1 / (over_lame + 1 / (_STIFFEST * modulus))
        mass = mass.tobsr((3, 3))  # nothing but blocks on the diagonal
        inverse = np.linalg.inv(mass.data) * bulk[:, None, None]
        self.b, self.moduli = b, bsr_matrix((inverse, mass.indices, mass.indptr), shape=mass.shape)
        options = {"permc_spec": "MMD_AT_PLUS_A", "diag_pivot_thresh": 0.0, "options": {"SymmetricMode": True}}
        self.kept = np.repeat(bulk / (_STIFFEST * modulus), 3)
        self.factors = splu((k + b.T @ self.moduli @ b).tocsc(), **options)

    def solve(self, work):
        """The displacement."""
        return self.solved(work)[0]

    def solved(self, work):
        """Displacement and pressure, by the method of multipliers (Hestenes 1969): it converges to the pressure that
        makes up for the finite bulk modulus in a few turns, by the factor 1 / _STIFFEST each or so.
        """
        kept = self.kept.reshape(-1, *(1,) * (work.ndim - 1))
        p = np.zeros((self.b.shape[0], *work.shape[1:]))
        for _ in range(20):
            u = self.factors.solve(work - self.b.T @ (kept * p))
            before, p = p, self.moduli @ (self.b @ u) + kept * p
            if np.abs(p - before).max() <= 1e-9 * np.abs(p).max():
                return u, p
        raise AssertionError("the pressure does not settle")


class Body:
    """Layers held at the bottom: flat, or round a core.

    depths, places: the elements' edges, from the surface down and along it; those of a round skin go once around.
    layers: (depth of the bottom, Young's modulus, Poisson's ratio), from the surface down; each bottom an edge.
    radius: of the surface. sides: whether the ends of a flat skin are "clamped" or "free".
    """

    def __init__(self, depths, positions, layers, radius=np.inf, sides="clamped"):
        self.depths, self.positions = np.asarray(depths), np.asarray(positions)
        self.layers, self.radius, self.sides = layers, radius, sides
        # inside, lengths are in thicknesses and stresses in the first modulus: in SI rounding would show
        self.length, self.stress = self.depths[-1], layers[0][1]
        if self.round:
            assert np.isclose(self.positions[-1] - self.positions[0], 2 * np.pi * radius, rtol=1e-12)
        assert np.isin([bottom for bottom, _, _ in layers], self.depths).all()
        self.basis = skfem.CellBasis(self.mesh, _VECTOR, intorder=5)

    @property
    def round(self):
        return np.isfinite(self.radius)

    def cartesian(self, x, y):
        """Places, in `length`, in a plane whose axes point inwards and along +y at y = 0."""
        if not self.round:
            return np.stack([x, y]) / self.length
        r, phi = self.radius - x, y / self.radius
        return np.stack([self.radius - r * np.cos(phi), r * np.sin(phi)]) / self.length

    def frame(self, y):
        """Unit vectors inwards and along +y, first and second: shape (2, 2, ...)."""
        phi = np.asarray(y) / self.radius
        return np.array([[np.cos(phi), -np.sin(phi)], [np.sin(phi), np.cos(phi)]])

    @cached_property
    def mesh(self):
        """Columns of elements, from the surface down."""
        rows, columns = self.depths.size, self.positions.size - self.round
        nodes = np.arange(rows * columns).reshape(columns, rows)
        if self.round:
            nodes = np.vstack([nodes, nodes[:1]])
        corners = [nodes[:-1, :-1], nodes[:-1, 1:], nodes[1:, 1:], nodes[1:, :-1]]
        x, y = np.tile(self.depths, columns), np.repeat(self.positions[:columns], rows)
        straight = skfem.MeshQuad1(self.cartesian(x, y), np.stack([c.ravel() for c in corners]))
        mesh = skfem.MeshQuad2.from_mesh(straight)
        if not self.round:
            return mesh
        # the middles of chords move out to their arcs
        r, centre = (self.radius - x) / self.length, np.array([[self.radius / self.length], [0.0]])
        r = np.concatenate([r, r[straight.facets].mean(axis=0), r[straight.t].mean(axis=0)])
        arm = mesh.doflocs - centre
        return replace(mesh, doflocs=centre + arm * r / np.hypot(*arm))

    def best(self, x, y):
        """The places nearest to x and y where the strains of such elements are one order better: two by two in each."""
        out = []
        for edges, at in ((self.depths, x), (self.positions, y)):
            i, share = within(edges, np.asarray(at))
            share = 0.5 + np.where(share < 0.5, -1, 1) / np.sqrt(12)
            out.append(edges[i] + share * (edges[i + 1] - edges[i]))
        return out

    def _row(self, row):
        """Facets at the edge `row` of the depths."""
        return np.flatnonzero((self.mesh.facets % self.depths.size == row).all(axis=0))

    @cached_property
    def free(self):
        """Displacements that are not held."""
        facets = self._row(self.depths.size - 1)
        if not self.round and self.sides == "clamped":
            column = self.mesh.facets // self.depths.size
            ends = ((column == 0) | (column == self.positions.size - 1)) & (column[0] == column[1])
            facets = np.append(facets, np.flatnonzero(ends.all(axis=0)))
        return np.setdiff1d(np.arange(self.basis.N), self.basis.get_dofs(facets).all())

    @property
    def unknowns(self):
        return self.free.size + 3 * self.mesh.nelements

    @cached_property
    def _system(self):
        modulus, over_lame = per_row(self.layers, self.depths, self.stress)
        columns = self.positions.size - 1
        linear = self.basis.with_element(Linear())
        points = np.ones((1, self.basis.X.shape[1]))
        k = _distortion.assemble(self.basis, modulus=np.tile(modulus, columns)[:, None] * points)
        return Saddle(
            k[self.free][:, self.free],
            _expansion.assemble(self.basis, linear)[:, self.free],
            _product.assemble(linear),
            np.tile(modulus, columns),
            np.tile(over_lame, columns),
        )

    def solve(self, work):
        """Displacements at the nodes, as many as `work`: the virtual work of loads, one or a column each."""
        out = np.zeros_like(work)
        out[self.free] = self._system.solve(work[self.free])
        return out

    @cached_property
    def surface(self):
        """Quadrature on the surface."""
        return skfem.FacetBasis(self.mesh, _VECTOR, facets=self._row(0), intorder=20)

    @cached_property
    def _surface_positions(self):
        """Places y of the surface's quadrature."""
        first, second = self.length * np.asarray(self.surface.global_coordinates())
        return self.radius * np.arctan2(second, self.radius - first) if self.round else second

    def pull(self, pressure, shear):
        """The solution under tractions given as functions of y."""
        y = self._surface_positions
        inwards, onwards = self.frame(y)
        traction = (pressure(y) * inwards + shear(y) * onwards) / self.stress
        work = _work.assemble(self.surface, traction=traction)
        return Solution(self, self.solve(work))

    def press(self, height, force, window):
        """A rigid body pressed in without friction by a force, its undeformed gap `height(y)`, within a window of y.

        The pressure is linear between the surface's vertices. Where it is not zero the gap is, weighed with the hat of
        each vertex; elsewhere the weighed gap is positive. Which is which is found by turns.
        """
        y = self._surface_positions
        hats = self.surface.with_element(skfem.ElementQuad1())
        chosen = np.flatnonzero((self.positions > window[0]) & (self.positions < window[1]))
        nodes = hats.nodal_dofs[0, chosen * self.depths.size]
        load = _inward.assemble(hats, self.surface, inwards=self.frame(y)[0])[:, nodes].toarray()
        lift = load.T @ self.solve(load)
        weight, gap = (_share.assemble(hats, factor=f)[nodes] for f in (np.ones_like(y), height(y) / self.length))
        touches = np.ones(nodes.size, dtype=bool)
        for _ in range(60):
            n = touches.sum()
            system = np.zeros((n + 1, n + 1))
            system[:n, :n], system[:n, n], system[n, :n] = (
                lift[touches][:, touches],
                -weight[touches],
                weight[touches],
            )
            *p, depth = np.linalg.solve(system, np.append(-gap[touches], force / self.length / self.stress))
            pressure = np.zeros(nodes.size)
            pressure[touches] = p
            open_by = lift @ pressure - depth * weight + gap
            now = np.where(touches, pressure > 0, open_by < 0)
            if (now == touches).all():
                break
            touches = now
        else:
            raise AssertionError("the contact does not settle")
        assert not touches[[0, -1]].any(), "the window is too narrow"
        solution = Solution(self, self.solve(load @ pressure))
        return Pressed(solution, self.positions[chosen], pressure * self.stress, depth * self.length)


@dataclass(frozen=True)
class Solution:
    """The displacement of a body, read anywhere."""

    body: Body
    nodal: np.ndarray  # in the body's length

    def _at(self, x, y):
        """Displacement (2, n) and its gradient (2, 2, n), in the plane, and the frame (2, 2, n)."""
        body, mapping = self.body, self.body.basis.mapping
        x, y = np.ravel(x), np.ravel(y)
        if body.round:
            turn = 2 * np.pi * body.radius
            y = body.positions[0] + np.mod(y - body.positions[0], turn)
        (row, down), (column, onwards) = within(body.depths, x), within(body.positions, y)
        cells = column * (body.depths.size - 1) + row
        local = np.stack([down, onwards])[:, :, None]
        value, slope = np.zeros((2, x.size)), np.zeros((2, 2, x.size))
        for i, dofs in enumerate(body.basis.element_dofs[:, cells]):
            field = _VECTOR.gbasis(mapping, local, i, cells)[0]
            value += np.asarray(field)[..., 0] * self.nodal[dofs]
            slope += field.grad[..., 0] * self.nodal[dofs]
        return value, slope, body.frame(y)

    def strain(self, x, y):
        """Strains xx, yy and xy, shape (3, ...), at depth x and place y; at an interface above it."""
        x, y = np.broadcast_arrays(x, y)
        _, slope, frame = self._at(x, y)
        e = np.einsum("ai...,ij...,bj...->ab...", frame, slope, frame)
        return np.stack([e[0, 0], e[1, 1], 0.5 * (e[0, 1] + e[1, 0])]).reshape(3, *x.shape)

    def displacement(self, x, y):
        """Displacement into the skin and along +y, shape (2, ...)."""
        x, y = np.broadcast_arrays(x, y)
        value, _, frame = self._at(x, y)
        return self.body.length * np.einsum("ai...,i...->a...", frame, value).reshape(2, *x.shape)


@dataclass(frozen=True)
class Pressed:
    """A rigid body pressed in: its depth, and pressures at the surface's vertices `y`, linear between them."""

    solution: Solution
    y: np.ndarray
    pressure: np.ndarray
    depth: float

    @property
    def force(self):
        return np.trapezoid(self.pressure, self.y)

    @property
    def edges(self):
        """Where the contact ends: p^2 falls linearly there under a smooth body. Only the last vertex is left out."""
        inside = np.flatnonzero(self.pressure > 0)
        assert inside.size >= 12, "too few elements to tell the edges by"
        out = []
        for near in (inside[1:5], inside[-5:-1]):
            slope, level = np.polyfit(self.y[near], self.pressure[near] ** 2, 1)
            out.append(-level / slope)
        return tuple(out)
