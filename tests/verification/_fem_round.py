"""Layers under a round contact by finite elements, flat or on a ball: depth and arc, times cos and sin of m theta.

A round contact at the origin, of pressure p(r), drag q(r) along an axis and twist -f'(r), excites m = 0 and m = 1.
The unknowns are (U, S, D): u_x = U cos m theta, u_r = V cos m theta, u_theta = W sin m theta, S = V + W, D = V - W
(W itself under a twist). S and D go with exp(i (m + 1) theta) and exp(i (1 - m) theta) of u_y + i u_z: on the axis
what turns with theta is zero. Elements and pressures as in `_fem`, with which this shares nothing but them.
"""

from __future__ import annotations

from dataclasses import replace
from functools import cached_property

import numpy as np
import skfem
from scipy.sparse import coo_matrix

from ._fem import Linear, Saddle, per_row, within

_VECTOR = skfem.ElementVector(skfem.ElementQuad2(), 3)


def _strains(value, slope, r, m):
    """xx, rr, tt, xr, xt, rt; the first four go with cos m theta, the others with sin m theta."""
    (ux, ur), (sx, sr), (dx, dr) = slope
    u, s, d = value
    v, w = 0.5 * (s + d), 0.5 * (s - d)
    around = (v + m * w) / r
    turned = 0.5 * (0.5 * (sr - dr) - (w + m * v) / r)
    return ux, 0.5 * (sr + dr), around, 0.5 * (ur + 0.5 * (sx + dx)), 0.5 * (0.5 * (sx - dx) - m * u / r), turned


@skfem.LinearForm
def _work(v, w):
    u, s, d = v
    (_, sr), (_, dr) = v.grad[1:]
    out, around = 0.5 * (s + d), 0.5 * (s - d)
    push = w.pressure * (w.cos * u - w.sin * out) + w.drag * (w.sin * u + w.cos * out - around)
    # the twist is -f' of a function f that may have a root at its edge: integrated by parts
    return w.x[1] * (push + 0.5 * w.twist * (sr - dr)) + 0.5 * w.twist * (s - d)


def _assembled(local, rows, columns, count):
    """Element matrices (elements, i, j) added up; `count` columns."""
    i, j = (np.broadcast_to(a, local.shape).ravel() for a in (rows[:, :, None], columns[:, None, :]))
    return coo_matrix((local.ravel(), (i, j)), shape=(rows.max() + 1, count)).tocsr()


class RoundBody:
    """Layers held at the bottom and at a large radius, in one mode.

    depths, radii: the elements' edges, from the surface down and from the axis out, on a ball along its arc.
    layers: (depth of the bottom, Young's modulus, Poisson's ratio), from the surface down; each bottom an edge.
    m: how often the load repeats around the axis, 0 or 1.
    ball: radius of the surface of a ball.
    """

    def __init__(self, depths, radii, layers, m, ball=np.inf):
        # inside, lengths are in thicknesses and stresses in the first modulus: in SI rounding would show
        self.length, self.stress, self.layers, self.m = depths[-1], layers[0][1], layers, m
        self.depths, self.radii, self.ball = np.asarray(depths), np.asarray(radii), ball
        self.plain = skfem.MeshQuad.init_tensor(self.depths / self.length, self.radii / self.length)
        self.mesh = self.plain
        if np.isfinite(ball):
            curved = skfem.MeshQuad2.from_mesh(self.plain)
            self.mesh = replace(curved, doflocs=self.cylindrical(*(self.length * curved.doflocs)))
        self.basis = skfem.CellBasis(self.mesh, _VECTOR, intorder=6)

    def cylindrical(self, x, s):
        """Distances along the axis and from it, in `length`, of a depth and an arc."""
        if not np.isfinite(self.ball):
            return np.stack([x, s]) / self.length
        r, phi = self.ball - x, s / self.ball
        return np.stack([self.ball - r * np.cos(phi), r * np.sin(phi)]) / self.length

    def _facets(self, axis, edge):
        """Facets at an edge of the depths (axis 0) or of the radii (1)."""
        return self.plain.facets_satisfying(lambda x: np.abs(x[axis] - edge / self.length) < 1e-9)

    @cached_property
    def free(self):
        """Displacements that are not held: at the base and far out all, on the axis those that turn with theta."""
        held = np.append(self._facets(0, self.depths[-1]), self._facets(1, self.radii[-1]))
        held, axis = self.basis.get_dofs(held).all(), self.basis.get_dofs(self._facets(1, 0.0))
        zero = ["u^2", "u^3"] if self.m == 0 else ["u^1", "u^2"]
        return np.setdiff1d(np.arange(self.basis.N), np.concatenate([held, axis.all(zero)]))

    @cached_property
    def _system(self):
        """2 G e(u) : e(v) and -p div v, weighed with the radius: 27 strains of each element, multiplied at once."""
        rows = np.searchsorted(self.depths, self.length * self.plain.p[0, self.plain.t].mean(axis=0)) - 1
        modulus, over_lame = (each[rows] for each in per_row(self.layers, self.depths, self.stress))
        r = np.asarray(self.basis.global_coordinates())[1]
        fields = [field[0] for field in self.basis.basis]
        e = np.array([_strains(np.asarray(field), field.grad, r, self.m) for field in fields]).transpose(2, 0, 1, 3)
        weight = (self.basis.dx * r)[:, None, None]
        flat = (e * np.sqrt([1, 1, 1, 2, 2, 2])[:, None] * np.sqrt(weight)).reshape(len(e), len(fields), -1)
        k = 2 * modulus[:, None, None] * (flat @ flat.transpose(0, 2, 1))
        linear = self.basis.with_element(Linear())
        p = np.array([np.broadcast_to(field[0], r.shape) for field in linear.basis]).transpose(1, 0, 2)
        b = -(weight[:, 0] * p) @ e[:, :, :3].sum(axis=2).transpose(0, 2, 1)
        mass = (weight[:, 0] * p) @ p.transpose(0, 2, 1)
        u, q = self.basis.element_dofs.T, linear.element_dofs.T
        stiffness = _assembled(k, u, u, self.basis.N)[self.free][:, self.free]
        return Saddle(
            stiffness,
            _assembled(b, q, u, self.basis.N)[:, self.free],
            _assembled(mass, q, q, linear.N),
            modulus,
            over_lame,
        )

    @property
    def unknowns(self):
        """How many."""
        return self.free.size + 3 * self.mesh.nelements

    def pull(self, pressure=None, drag=None, twist=None):
        """The solution under tractions of the radius: `pressure`, `drag` along theta = 0, -d twist/dr around the axis.

        The twist is in Pa m, as it stands before its derivative.
        """
        surface = skfem.FacetBasis(self.mesh, _VECTOR, facets=self._facets(0, 0.0), intorder=60)
        along, out = self.length * np.asarray(surface.global_coordinates())
        phi = np.arctan2(out, self.ball - along) if np.isfinite(self.ball) else np.zeros_like(out)
        r, unit = self.ball * phi if np.isfinite(self.ball) else out, (1.0, 1.0, self.length)
        given = [np.zeros_like(r) if f is None else f(r) / self.stress for f in (pressure, drag, twist)]
        given = {name: f / one for name, f, one in zip(("pressure", "drag", "twist"), given, unit, strict=True)}
        given |= {"cos": np.cos(phi), "sin": np.sin(phi)}
        nodal = np.zeros(self.basis.N)
        nodal[self.free], pressure = self._system.solved(_work.assemble(surface, **given)[self.free])
        return RoundSolution(self, nodal, pressure)

    def best(self, x, r):
        """The points nearest to x and r where the strains of such elements are one order better: two by two in each."""
        out = []
        for edges, at in ((self.depths, x), (self.radii, r)):
            i, share = within(edges, np.asarray(at))
            share = 0.5 + np.where(share < 0.5, -1, 1) / np.sqrt(12)
            out.append(edges[i] + share * (edges[i + 1] - edges[i]))
        return out


class Touched:
    """Layers under a touch of the round unit shape f(r): N f and (Ty, Tz) f, and a moment whose drag is -(M / 2) f'.

    depths, radii, layers: as of a `RoundBody`. components: N, Ty, Tz [N]. moment: M [N m].
    """

    def __init__(self, depths, radii, layers, shape, components, moment):
        n, drag = components[0], components[1] + 1j * components[2]
        self.azimuth = np.angle(drag)
        self.even, one = (RoundBody(depths, radii, layers, m) for m in (0, 1))
        self.modes = [
            self.even.pull(lambda r: n * shape(r), twist=lambda r: 0.5 * moment * shape(r)),
            one.pull(drag=lambda r: abs(drag) * shape(r)),
        ]

    def at(self, x, r, theta):
        """Strains xx, yy, zz, xy, xz, yz, shape (6, n), and displacements, (3, n), at n points off the axis."""
        (strain, moved), (more, also) = (mode.at(x, r, theta - m * self.azimuth) for m, mode in enumerate(self.modes))
        c, s = np.cos(self.azimuth), np.sin(self.azimuth)
        back = np.array([[1, 0, 0], [0, c, -s], [0, s, c]])
        turned = np.einsum("ai,ijn,bj->abn", back, more[[[0, 3, 4], [3, 1, 5], [4, 5, 2]]], back)
        return strain + turned[[0, 1, 2, 0, 0, 1], [0, 1, 2, 1, 2, 2]], moved + back @ also


class RoundSolution:
    """The displacement of a body in one mode, and its pressure, three numbers an element, read anywhere."""

    def __init__(self, body, nodal, pressure):
        self.body, self.nodal, self.pressure = body, nodal, pressure.reshape(-1, 3)

    @cached_property
    def _cells(self):
        """Which element stands in which row and column."""
        x, r = self.body.length * self.body.plain.p[:, self.body.plain.t].mean(axis=1)
        out = np.empty((self.body.depths.size - 1, self.body.radii.size - 1), dtype=int)
        out[np.searchsorted(self.body.depths, x) - 1, np.searchsorted(self.body.radii, r) - 1] = np.arange(x.size)
        return out

    def _local(self, x, r):
        """The elements of n points off the axis, and the points within them, (2, n, 1)."""
        cells = self._cells[within(self.body.depths, x)[0], within(self.body.radii, r)[0]]
        points = np.stack([x, r])[:, :, None] / self.body.length
        return cells, self.body.plain.mapping().invF(points, tind=cells)

    def normal(self, x, r):
        """Strain along the depth, and the pressure of an incompressible body, over cos m theta; shape (n,) each."""
        cells, local = self._local(x, r)
        phi = r / self.body.ball
        (xx, rr, _, xr, _, _), _ = self._strains(cells, local, self.body.cylindrical(x, r)[1])
        (a, b), p = local[..., 0], self.pressure[cells].T
        inwards = xx * np.cos(phi) ** 2 - 2 * xr * np.cos(phi) * np.sin(phi) + rr * np.sin(phi) ** 2
        return inwards, self.body.stress * (p[0] + p[1] * (2 * a - 1) + p[2] * (2 * b - 1))

    def _strains(self, cells, local, r):
        """As `_strains`, and the displacement (3, n), at points of the elements."""
        value, slope = np.zeros((3, r.size)), np.zeros((3, 2, r.size))
        for i, dofs in enumerate(self.body.basis.element_dofs[:, cells]):
            field = _VECTOR.gbasis(self.body.basis.mapping, local, i, cells)[0]
            value += np.asarray(field)[..., 0] * self.nodal[dofs]
            slope += field.grad[..., 0] * self.nodal[dofs]
        return _strains(value, slope, r, self.body.m), value

    def at(self, x, r, theta):
        """Strains xx, yy, zz, xy, xz, yz, shape (6, n), and displacements, (3, n), at n points off the axis."""
        body = self.body
        (xx, rr, tt, xr, xt, rt), value = self._strains(*self._local(x, r), r / body.length)
        even, odd = np.cos(body.m * theta), np.sin(body.m * theta) if body.m else np.ones_like(theta)
        u, v, w = value[0] * even, 0.5 * (value[1] + value[2]) * even, 0.5 * (value[1] - value[2]) * odd
        turn = np.exp(1j * theta)
        shear, difference = turn * (xr * even + 1j * xt * odd), turn**2 * ((rr - tt) * even + 2j * rt * odd)
        half = 0.5 * (rr + tt) * even
        strains = [xx * even, half + 0.5 * difference.real, half - 0.5 * difference.real]
        along = turn * (v + 1j * w)
        return (
            np.stack([*strains, shear.real, shear.imag, 0.5 * difference.imag]),
            body.length * np.stack([u, along.real, along.imag]),
        )
