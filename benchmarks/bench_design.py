"""What a search of designs waits for: rows and areas of a layered skin, the first of it and those that follow.

    python benchmarks/bench_design.py [--json FILE]

A row is `study_at_depth` of two pitches and two counts; 2000 touches, 0.02 s of it. An area is the table of a 4 x 4
grid.
"""

from __future__ import annotations

import time
from collections.abc import Callable

import subskin as ss
from _common import arguments, show
from subskin.design import Touches
from subskin.design.placement import Channel, study_at_depth
from subskin.radial import tabulate_radial

STRAIN, PRESSURE = ss.NormalStrain(), ss.MeanPressure()


def skin(thickness: float = 5e-3) -> ss.Layered:
    """Rubber bonded to bone; equal ones are objects of their own."""
    return ss.Layered(ss.Layer(ss.Material(young=0.4e6), thickness))


def row(medium: ss.Skin, kind: ss.Transducer, depth: float, pitches: tuple[float, float], width: float = 0.0) -> object:
    """A row of the study."""
    asked = Touches(20.0, 0.8, (-6e-3, 6e-3))
    return study_at_depth(medium, Channel(kind, 1e-4, width), depth, pitches, [6, 8], asked, samples=2000)


def area(medium: ss.Skin, kind: ss.Transducer, depth: float, pitch: float) -> object:
    """The table of a grid."""
    array = ss.SensorArray.grid((4, 4), pitch=pitch, depth=depth, transducer=kind)
    return tabulate_radial(ss.Finger(medium, array), 28e-3)


def spent(work: Callable[[], object]) -> list[str]:
    """CPU and wall time [ms] of work done once."""
    begun, cpu = time.perf_counter(), time.process_time()
    work()
    both = time.process_time() - cpu, time.perf_counter() - begun
    return [f"{1e3 * value:.0f}" for value in both]


def main() -> None:
    """Rows, then areas; what is compiled is compiled before, on another skin."""
    given = arguments(__doc__)
    half, other = ss.HalfPlane(ss.Material(young=0.4e6)), ss.HalfSpace(ss.Material(young=0.4e6))
    row(half, STRAIN, 2e-3, (1e-3, 2e-3)), area(other, STRAIN, 2e-3, 2e-3), area(skin(7e-3), STRAIN, 2e-3, 2e-3)
    rows = [
        ["row, the first of a skin", *spent(lambda: row(skin(), STRAIN, 2e-3, (1e-3, 2e-3)))],
        ["row, other pitches", *spent(lambda: row(skin(), STRAIN, 2e-3, (1.2e-3, 1.9e-3)))],
        ["row, another kind", *spent(lambda: row(skin(), PRESSURE, 2e-3, (1e-3, 2e-3)))],
        ["row, another depth", *spent(lambda: row(skin(), STRAIN, 2.3e-3, (1e-3, 2e-3)))],
        ["row, sensors 0.4 mm wide", *spent(lambda: row(skin(), STRAIN, 2.3e-3, (1e-3, 2e-3), 0.4e-3))],
        ["row, the first of pitches to 3 depths", *spent(lambda: row(skin(), STRAIN, 2.6e-3, (1e-3, 7e-3)))],
        ["area, the first of a skin", *spent(lambda: area(skin(), STRAIN, 2e-3, 2e-3))],
        ["area, another pitch", *spent(lambda: area(skin(), STRAIN, 2e-3, 2.5e-3))],
        ["area, another kind", *spent(lambda: area(skin(), PRESSURE, 2e-3, 2e-3))],
        ["area, another depth", *spent(lambda: area(skin(), STRAIN, 2.3e-3, 2e-3))],
    ]
    show("A layered skin in a search", ["", "CPU [ms]", "wall [ms]"], rows, given.json)


if __name__ == "__main__":
    main()
