"""Contact solves: time and accuracy of `press` beside Tamaas and ContactMechanics, and how time grows with nodes.

    python benchmarks/bench_press.py [--repeats 20] [--largest 18] [--json FILE]

A rigid sinusoid pressed into a half plane, periodic, to a tolerance of 1e-9, one thread: the problem that all three
solve. Westergaard's pressure is the reference. A call of ours is all of `ss.press`, its certificate included; the peers
are timed from their solver's call on. Asked for: 1 ms on 2^10 nodes and 20 ms on 2^14, three times that with friction.

The peers come with `pip install -e ".[bench]"`; a table leaves out one that is not installed. Tamaas is under the AGPL:
it is run here, and nothing of it is in subskin.
"""

from __future__ import annotations

import importlib.util
import os
import time
import warnings
from collections.abc import Callable
from typing import Any

os.environ.setdefault("OMP_NUM_THREADS", "1")

import numpy as np

import subskin as ss
from _common import arguments, show

MODULUS, PITCH, AMPLITUDE, SHARE = 1e6, 1e-2, 1e-4, 0.3
SKIN = ss.HalfPlane(ss.Material(MODULUS, 0.5))
PLANE_STRAIN = MODULUS / 0.75
FULL = np.pi * PLANE_STRAIN * AMPLITUDE / PITCH  # mean pressure at which a sinusoid touches everywhere
TOLERANCE = 1e-9

Answer = tuple[float, np.ndarray, np.ndarray]  # seconds, places from a crest, pressures


def westergaard(y: np.ndarray) -> np.ndarray:
    """Pressure beneath a sinusoid whose mean pressure is SHARE of the one that closes the contact."""
    sine = np.sin(np.pi * y / PITCH) ** 2
    return 2 * FULL * np.cos(np.pi * y / PITCH) * np.sqrt(np.maximum(SHARE - sine, 0.0))


def ours(nodes: int, **more: Any) -> Answer:
    """`ss.press`."""
    start = time.perf_counter()
    pressed = ss.press(
        SKIN, ss.pressing.SineRidges(PITCH, AMPLITUDE), force=SHARE * FULL * PITCH, period=PITCH, nodes=nodes,
        tolerance=TOLERANCE, **more,
    )  # fmt: skip
    taken = time.perf_counter() - start
    assert pressed.status == ss.pressing.PressStatus.OK, pressed.reason
    return taken, pressed.y, pressed.pressure


def tamaas(nodes: int) -> Answer:
    """Polonsky and Keer's conjugate gradients, in C++."""
    import tamaas as tm

    tm.set_log_level(tm.LogLevel.error)
    model = tm.ModelFactory.createModel(tm.model_type.basic_1d, [PITCH], [nodes])
    model.E, model.nu = MODULUS, 0.5
    y = np.arange(nodes) / nodes * PITCH
    solver = tm.PolonskyKeerRey(model, AMPLITUDE * np.cos(2 * np.pi * y / PITCH), TOLERANCE)
    start = time.perf_counter()
    solver.solve(SHARE * FULL)
    taken = time.perf_counter() - start
    return taken, wrapped(y), np.array(model.traction).ravel()


def contact_mechanics(nodes: int) -> Answer:
    """Constrained conjugate gradients, in Python on an FFT in C."""
    from ContactMechanics import PeriodicFFTElasticHalfSpace
    from ContactMechanics.Systems import NonSmoothContactSystem
    from SurfaceTopography import UniformLineScan

    y = np.arange(nodes) / nodes * PITCH
    substrate = PeriodicFFTElasticHalfSpace((nodes,), PLANE_STRAIN, (PITCH,))
    surface = UniformLineScan(AMPLITUDE * np.cos(2 * np.pi * y / PITCH), PITCH, periodic=True)
    system = NonSmoothContactSystem(substrate=substrate, surface=surface)
    start = time.perf_counter()
    found = system.minimize_proxy(external_force=SHARE * FULL * PITCH, pentol=TOLERANCE * AMPLITUDE, maxiter=10_000)
    taken = time.perf_counter() - start
    assert found.success
    return taken, wrapped(y), np.abs(np.asarray(substrate.force)).ravel() * nodes / PITCH


def wrapped(y: np.ndarray) -> np.ndarray:
    """Places from the nearest crest."""
    return (y + PITCH / 2) % PITCH - PITCH / 2


def timed(call: Callable[[], Answer], repeats: int) -> tuple[list[float], Answer]:
    """Times in ms of `repeats` calls after one that is not counted, and the last answer."""
    call()
    answers = [call() for _ in range(repeats)]
    return [1e3 * a[0] for a in answers], answers[-1]


def beside_peers(repeats: int) -> list[list[str]]:
    """Rows: who, nodes, median and least time, error of the pressure."""
    drag = {"friction": 0.5, "tangential": 0.25 * SHARE * FULL * PITCH}
    contenders: list[tuple[str, Callable[[int], Answer]]] = [
        ("subskin", ours),
        ("subskin, friction, nu = 1/2", lambda n: ours(n, **drag)),
    ]
    for name, module, solve in (
        ("Tamaas", "tamaas", tamaas),
        ("ContactMechanics", "ContactMechanics", contact_mechanics),
    ):
        if importlib.util.find_spec(module):
            contenders.append((name, solve))
        else:
            print(f'{name} is not installed: pip install -e ".[bench]"')
    rows = []
    for power in (10, 14):
        for name, solve in contenders:
            times, (_, y, pressure) = timed(lambda solve=solve, power=power: solve(1 << power), repeats)
            exact = westergaard(y)
            mean = np.abs(pressure - exact).sum() / exact.sum()
            rows.append([name, f"2^{power}", f"{np.median(times):.2f}", f"{min(times):.2f}", f"{mean:.1e}"])
    return rows


def growth(largest: int, repeats: int) -> list[list[str]]:
    """Rows: nodes, time, time over n log2 n, steps."""
    rows = []
    for power in range(8, largest + 1, 2):
        n = 1 << power
        times, _ = timed(lambda n=n: ours(n), max(3, repeats // 4))
        best = float(np.median(times))
        rows.append([f"2^{power}", f"{best:.2f}", f"{1e6 * best / (n * power):.1f}"])
    return rows


def on_other_skins(repeats: int) -> list[list[str]]:
    """Rows: a cylinder pressed into each skin, by force, without and with friction, the grid found by the program."""
    rubber, firm = ss.Material(0.4e6, 0.5), ss.Material(4e6, 0.4)
    skins = {
        "half plane, nu = 1/2": ss.HalfPlane(rubber),
        "half plane, nu = 0.3": ss.HalfPlane(ss.Material(0.4e6, 0.3)),
        "bonded layer, nu = 1/2": ss.Layered(ss.Layer(rubber, 3e-3)),
        "firm on soft on rigid": ss.Layered([ss.Layer(firm, 0.3e-3), ss.Layer(rubber, 3e-3)]),
        "round finger, nu = 1/2": ss.Round(rubber, 8e-3, 4e-3),
    }
    rows = []
    for name, skin in skins.items():
        row = [name]
        for more in ({}, {"friction": 0.5, "tangential": 10.0}):
            firsts = []
            for i in range(repeats + 1):
                start = time.perf_counter()
                pressed = ss.press(skin, ss.pressing.Cylinder(8e-3), force=40.0, **more)
                firsts.append(1e3 * (time.perf_counter() - start))
                assert pressed.status == ss.pressing.PressStatus.OK, (i, pressed.reason)
            if not more:
                row.append(f"{firsts[0]:.0f}")
            row.append(f"{np.median(firsts[1:]):.1f}")
        rows.append([*row, f"{pressed.certificate.worst:.0e}", f"{pressed.refined().penetration:.0e}"])
    return rows


def main() -> None:
    """Run and print."""
    options = arguments(__doc__, repeats=20, largest=18)
    warnings.simplefilter("ignore", DeprecationWarning)
    show(
        "A rigid sinusoid, periodic, tolerance 1e-9",
        ["solver", "nodes", "ms, median", "least", "mean error of the pressure"],
        beside_peers(options.repeats),
        options.json,
    )
    show(
        "Growth with the number of nodes",
        ["nodes", "ms, median", "ns per node and doubling"],
        growth(options.largest, options.repeats),
        options.json,
    )
    show(
        "A cylinder by force, 1024 nodes, all of ss.press",
        ["skin", "first call, ms", "next, ms", "with friction, ms", "worst of certificate", "overlap between nodes"],
        on_other_skins(options.repeats),
        options.json,
    )


if __name__ == "__main__":
    main()
