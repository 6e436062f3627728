"""Contact solves on an area: time, products and accuracy of `press` beside ASPHER, Tamaas, ContactMechanics.

    python benchmarks/bench_press_area.py [--repeats 5] [--json FILE]

A sphere pressed by force into a half space that does not repeat, to a certificate of 1e-8, one thread, CPU time: a call
of ours is all of `ss.press`, the search for the grid and the certificate included; the peers are timed from their
solver's call on, on the same square, Tamaas on a periodic square twice as wide (it knows no other). The error is the
mean of the pressure's against Hertz. Then partial slip, layers, and shapes without a closed form.

The peers come with `pip install -e ".[bench]"`; a table leaves out one that is not installed. ASPHER is built from its
source, by a compiler of C++ and CMake, and has to be asked for: `pip install aspher`. It comes with products by
multipoles; by transforms, in single precision before double, it is quickest here. Tamaas is under the AGPL: it is run
here, and nothing of it is in subskin.
"""

from __future__ import annotations

import importlib.util
import os
import time
import warnings
from collections.abc import Callable
from functools import partial
from typing import Any

os.environ.setdefault("OMP_NUM_THREADS", "1")

import numpy as np

import subskin as ss
from _common import arguments, show

RADIUS, FORCE = 8e-3, 0.3
RUBBER = ss.Material(0.4e6, 0.5)
STIFF = RUBBER.plane_strain_modulus
A = float(np.cbrt(0.75 * FORCE * RADIUS / STIFF))
HALF = ss.HalfSpace(RUBBER)
BALL = ss.pressing.Sphere(RADIUS)
WINDOW = 2.6 * A
TOLERANCE = 1e-8


def timed(call: Callable[[], Any], repeats: int) -> tuple[float, Any]:
    """Median CPU time [ms] of calls after one that is not counted, and the last answer."""
    call()
    times, found = [], None
    for _ in range(repeats):
        start = time.process_time()
        found = call()
        times.append(1e3 * (time.process_time() - start))
    return float(np.median(times)), found


def error(pressure: np.ndarray, step: float) -> float:
    """Mean error of a pressure on nodes about the middle, in shares of the mean pressure."""
    n = len(pressure)
    at = step * (np.arange(n) - 0.5 * (n - 1))
    exact = 1.5 * FORCE / (np.pi * A**2) * np.sqrt(np.maximum(1 - (at[:, None] ** 2 + at**2) / A**2, 0))
    return float(np.abs(pressure - exact).sum() / exact.sum())


def ours(nodes: int, **more: Any) -> ss.pressing.LocalSolution:
    """`ss.press`."""
    return ss.press(HALF, BALL, force=FORCE, nodes=nodes, **more)


def contact_mechanics(nodes: int) -> tuple[float, np.ndarray]:
    """Constrained conjugate gradients on a half space that does not repeat: CPU time [s] and pressure."""
    from ContactMechanics import FreeFFTElasticHalfSpace
    from ContactMechanics.Systems import NonSmoothContactSystem
    from SurfaceTopography import Topography

    step = WINDOW / nodes
    at = step * (np.arange(nodes) - 0.5 * (nodes - 1))
    surface = Topography(-(at[:, None] ** 2 + at**2) / (2 * RADIUS), (WINDOW, WINDOW))
    substrate = FreeFFTElasticHalfSpace((nodes, nodes), STIFF, (WINDOW, WINDOW))
    system = NonSmoothContactSystem(substrate=substrate, surface=surface)
    start = time.process_time()
    found = system.minimize_proxy(external_force=FORCE, pentol=TOLERANCE * A**2 / RADIUS, maxiter=10_000)
    taken = time.process_time() - start
    assert found.success
    return taken, np.abs(np.asarray(substrate.force))[:nodes, :nodes] / step**2


def aspher(nodes: int, **how: str) -> tuple[float, np.ndarray]:
    """Polonsky and Keer's conjugate gradients on nested grids, preconditioned, in C++: CPU time [s] and pressure."""
    import aspher as peer

    at = WINDOW / nodes * (np.arange(nodes) - 0.5 * (nodes - 1))
    gap = ((at[:, None] ** 2 + at**2) / (2 * RADIUS)).ravel()
    sizes = {"domain_size": WINDOW, "E_star": STIFF, "p_nominal": FORCE / WINDOW**2}
    start = time.process_time()
    found = peer.solve_nested(nodes, gap, **sizes, tol=TOLERANCE, **how)
    taken = time.process_time() - start
    assert found.converged
    return taken, np.asarray(found.pressure).reshape(nodes, nodes)


def tamaas(nodes: int) -> tuple[float, np.ndarray]:
    """Polonsky and Keer's conjugate gradients in C++, on a periodic square twice as wide: CPU time [s] and pressure."""
    import tamaas as tm

    tm.set_log_level(tm.LogLevel.error)
    wide, count = 2 * WINDOW, 2 * nodes
    model = tm.ModelFactory.createModel(tm.model_type.basic_2d, [wide, wide], [count, count])
    model.E, model.nu = RUBBER.young, RUBBER.poisson
    at = WINDOW / nodes * (np.arange(count) - 0.5 * (count - 1))
    solver = tm.PolonskyKeerRey(model, -(at[:, None] ** 2 + at**2) / (2 * RADIUS), 1e-12)
    start = time.process_time()
    solver.solve(FORCE / wide**2)
    taken = time.process_time() - start
    half = nodes // 2
    return taken, np.array(model.traction).reshape(count, count)[half : half + nodes, half : half + nodes]


def beside_peers(repeats: int) -> list[list[str]]:
    """Rows: who, CPU time, products, error, worst of the certificate."""
    rows = []
    for nodes in (256, 512):
        for name, more in (("subskin", {}), ("subskin, on the peers' square", {"window": WINDOW})):
            taken, found = timed(lambda nodes=nodes, more=more: ours(nodes, **more), repeats)
            worst = f"{found.certificate.worst:.0e}"
            row = [f"{taken:.0f}", str(found.products), f"{error(found.pressure, found.case.step):.1e}", worst]
            rows.append([name, f"{nodes}^2", *row])
        for name, module, solve in (
            ("ASPHER", "aspher", aspher),
            ("ASPHER, by transforms", "aspher", partial(aspher, backend="fft", precision="float_then_double")),
            ("ContactMechanics", "ContactMechanics", contact_mechanics),
            ("Tamaas, twice as wide", "tamaas", tamaas),
        ):
            if importlib.util.find_spec(module):
                taken, pressure = solve(nodes)
                rows.append(
                    [name, f"{nodes}^2", f"{1e3 * taken:.0f}", "", f"{error(pressure, WINDOW / nodes):.1e}", ""]
                )
            else:
                print(f'{name} is not installed: pip install -e ".[bench]"')
    return rows


def slip_and_layers(repeats: int) -> list[list[str]]:
    """Rows: case, CPU time at 256^2, products, in times the solve without friction, certificate."""
    plain, _ = timed(lambda: ours(256), repeats)
    drag = 0.5 * FORCE  # at which all slides
    cases: list[tuple[str, Callable[[], Any]]] = [
        ("half space", lambda: ours(256)),
        ("half the drag that slides", lambda: ours(256, friction=0.5, tangential=(0.5 * drag, 0.0))),
        ("the same askew, on the whole grid", lambda: ours(256, friction=0.5, tangential=(0.4 * drag, 0.3 * drag))),
        ("torsion", lambda: ours(256, friction=0.5, torsion=0.15 * 0.5 * FORCE * A)),
    ]
    for nu in (0.0, 0.3, 0.45, 0.499, 0.5):
        skin = ss.Layered(ss.Layer(ss.Material(0.4e6, nu), 3e-3))
        cases.append(
            (f"bonded layer, nu = {nu}", lambda skin=skin: ss.press(skin, BALL, force=FORCE, nodes=256))  # type: ignore[misc]
        )
    rows = []
    for name, call in cases:
        taken, found = timed(call, repeats)
        row = [f"{taken:.0f}", str(found.products), f"{taken / plain:.1f}", f"{found.certificate.worst:.0e}"]
        rows.append([name, *row])
    return rows


def awkward(repeats: int) -> list[list[str]]:
    """Rows: shape, CPU time at 256^2, products, certificate."""
    on, side = ss.pressing, np.linspace(-1.5e-3, 1.5e-3, 257)
    rng = np.random.default_rng(1)
    k = np.hypot(*np.meshgrid(*2 * [np.fft.fftfreq(257, 3e-3 / 256)]))
    waves = np.fft.ifft2(np.fft.fft2(rng.standard_normal((257, 257))) * (k + 300) ** -1.8).real
    bodies = {
        "ellipsoid 10:1, askew": on.Ellipsoid(8e-3, 0.8e-3, azimuth=0.4),
        "roller": on.Roller(4e-3, 2e-3),
        "cone": on.ConeTip(0.15),
        "pin": on.Pin(1e-3),
        "rounded box": on.Box(1e-3, 0.6e-3, edge_radius=0.5e-3),
        "edge of a box": on.BoxEdge(0.2, 1e-3, edge_radius=0.1e-3),
        "corner of a box": on.BoxCorner(0.3),
        "ridges on a sphere": on.RidgedBody(BALL, 0.25e-3, 6e-6, azimuth=0.3),
        "two spheres": on.Together([BALL, on.Sphere(3e-3)], [(-2e-3, 0), (2e-3, 5e-4)], [0, 1e-5]),
        "two far apart": on.Together([BALL, BALL], [(-9e-3, 0), (9e-3, 0)]),
        "rough": on.HeightMap(side, side, waves / waves.std() * 8e-6),
    }
    rows = []
    for name, body in bodies.items():
        taken, found = timed(
            lambda body=body: ss.press(HALF, body, force=FORCE, nodes=256, max_strain=2.0), max(1, repeats // 3)
        )
        rows.append([name, f"{taken:.0f}", str(found.products), found.status.name, f"{found.certificate.worst:.0e}"])
    return rows


def main() -> None:
    """Run and print."""
    options = arguments(__doc__, repeats=5)
    warnings.simplefilter("ignore")
    columns = ["solver", "nodes", "CPU ms", "padded products", "mean error of the pressure", "worst of certificate"]
    show("A sphere by force on a half space", columns, beside_peers(options.repeats), options.json)
    columns = ["case, 256^2", "CPU ms", "padded products", "times the first", "worst of certificate"]
    show("Friction and layers", columns, slip_and_layers(options.repeats), options.json)
    columns = ["shape, 256^2", "CPU ms", "padded products", "status", "worst of certificate"]
    show("Shapes", columns, awkward(options.repeats), options.json)


if __name__ == "__main__":
    main()
