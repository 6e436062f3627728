"""What presses on an area beside finite elements in three dimensions, which share nothing with subskin.

    python benchmarks/study_press_fem.py [--finest 2] [--json FILE]

A rigid body is pressed by a depth into a layer on a rigid base, without friction. The peer is a quarter of a block,
eight thicknesses wide, of hexahedra with 27 nodes (scikit-fem), small beneath the body and growing aside and downwards;
its nodes on top touch or do not so that no force pulls and no node lies above the body (`scipy.optimize.nnls`). Lengths
are in thicknesses, the modulus is 1. Strain is that along the depth beneath the centre, at 0.45.
"""

from __future__ import annotations

import warnings
from time import perf_counter

import numpy as np
import skfem
from scipy.linalg import cholesky, solve_triangular
from scipy.optimize import nnls
from scipy.sparse.linalg import splu
from skfem.helpers import ddot, sym_grad, trace

import subskin as ss
from _common import arguments, show

DEPTH, HALF, NEAR = 0.08, 4.0, 0.48
PLACE, STEP = 0.45, 1e-4
BODIES = {
    "sphere, R = 1.5": ss.pressing.Sphere(1.5),
    "ellipsoid, R = 2 and 0.8": ss.pressing.Ellipsoid(2.0, 0.8),
    "box 0.6 by 0.4, edges of 0.1": ss.pressing.Box(0.3, 0.2, 0.1),
}
SKINS = {f"nu = {nu}": nu for nu in (0.3, 0.45)}


def split(parts: int) -> tuple[np.ndarray, np.ndarray]:
    """Planes of elements aside and along the depth."""
    near = np.linspace(0.0, NEAR, 4 * parts + 1)
    far = NEAR + (HALF - NEAR) * np.linspace(0.0, 1.0, 3 * parts + 1)[1:] ** 2
    deep = np.linspace(0.0, 1.0, 3 * parts + 1) ** 1.5
    return np.concatenate([near, far]), deep


class Block:
    """A quarter of a layer: how far its nodes near the middle of the top move by a unit force on each."""

    def __init__(self, poisson: float, parts: int) -> None:
        aside, deep = split(parts)
        mesh = skfem.MeshHex.init_tensor(deep, aside, aside)  # x is the depth
        self.basis = skfem.Basis(mesh, skfem.ElementVector(skfem.ElementHex2()), intorder=4)
        shear, bulk = 1 / (2 * (1 + poisson)), poisson / ((1 + poisson) * (1 - 2 * poisson))

        @skfem.BilinearForm
        def stiffness(u, v, _):
            e, f = sym_grad(u), sym_grad(v)
            return 2 * shear * ddot(e, f) + bulk * trace(e) * trace(f)

        at = self.basis.doflocs
        axis = np.zeros(self.basis.N, dtype=int)
        for kind in ("nodal", "edge", "facet", "interior"):
            dofs = getattr(self.basis, f"{kind}_dofs")
            for row, dof in enumerate(dofs):
                axis[dof] = row % 3
        held = (at[0] > 1 - 1e-9) | (at[1:] > HALF - 1e-9).any(axis=0)
        for i in (1, 2):
            held |= (at[i] < 1e-9) & (axis == i)  # planes of symmetry
        free = np.flatnonzero(~held)
        matrix = stiffness.assemble(self.basis)[free][:, free].tocsc()
        self.free, self.factor = free, splu(matrix, permc_spec="MMD_AT_PLUS_A", options={"SymmetricMode": True})
        top = (at[0] < 1e-9) & (axis == 0) & (at[1:] < NEAR + 1e-9).all(axis=0)
        self.top = np.flatnonzero(top[free])
        self.y, self.z = at[1:][:, free[self.top]]
        forces = np.zeros((free.size, self.top.size))
        forces[self.top, np.arange(self.top.size)] = 1.0
        self.moves = self.factor.solve(forces)
        self.nodes = free.size

    def pressed(self, body: ss.pressing.Body) -> tuple[float, float]:
        """Force and strain by a body pressed to `DEPTH`."""
        gap = body.height(self.y, self.z) - DEPTH
        compliance = self.moves[self.top]
        half = cholesky(0.5 * (compliance + compliance.T))
        force, _ = nnls(half, -solve_triangular(half, gap, trans="T"))
        u = np.zeros(self.basis.N)
        u[self.free] = self.moves @ force
        ends = [self.basis.probes(np.array([[PLACE + step], [0.0], [0.0]])) @ u for step in (-STEP, STEP)]
        return 4 * float(force.sum()), float((ends[1] - ends[0])[0] / (2 * STEP))


def main() -> None:
    """Print the table."""
    options = arguments(__doc__, finest=2)
    warnings.simplefilter("ignore", ss.errors.ValidityWarning)  # slopes are not small, but the peer is linear too
    rows = []
    for name, poisson in SKINS.items():
        skin = ss.Layered(ss.Layer(ss.Material(1.0, poisson), 1.0))
        true = {}
        for what, body in BODIES.items():
            answer = ss.press(skin, body, depth=DEPTH, nodes=256)
            strain = skin.strain(answer.contact, PLACE, 0.0, 0.0).xx
            true[what] = answer.force, float(strain), answer.status.name
        for parts in range(1, options.finest + 1):
            begin = perf_counter()
            block = Block(poisson, parts)
            for what, body in BODIES.items():
                force, strain = block.pressed(body)
                ours = true[what]
                rows.append(
                    [
                        what, name, str(block.nodes), f"{force:.5f}", f"{ours[0]:.5f}", f"{force / ours[0] - 1:+.2%}",
                        f"{strain / ours[1] - 1:+.2%}", ours[2], f"{perf_counter() - begin:.0f}",
                    ]
                )  # fmt: skip
                print(" ".join(rows[-1]), flush=True)
    heads = ["body", "layer", "unknowns", "force, elements", "subskin", "off", "strain, off", "status", "s"]
    show("A body pressed to 0.08 of the thickness", heads, rows, options.json)


if __name__ == "__main__":
    main()
