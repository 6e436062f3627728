"""The placement study of docs/placement.md in full, and its throughput beside scipy.optimize per touch.

    python benchmarks/study_placement.py [--depths 20] [--samples 100000] [--touches 200] [--json FILE]

The full study is three kinds of sensor, 20 depths, 30 pitches, 3 to 16 sensors, and 100 000 touches of each; with
`--depths 2` a tenth of it is run.

The peer looks for rivals of each touch by itself: `least_squares` within the friction cone from twelve places, on
readings free of noise, from the closed form of a line load. A touch is ambiguous to it where one of its minima, apart
from the true one, has a chi-square of less than 13.8.
"""

from __future__ import annotations

import time
from concurrent.futures import ThreadPoolExecutor

import numpy as np
from scipy.optimize import least_squares

import subskin as ss
from _common import FULL_SCALE, arguments, show
from subskin.design import Touches, placement_quality
from subskin.design.placement import Channel, study_at_depth

STARTS = 12
KINDS = {"normal strain": ss.NormalStrain(), "pressure": ss.MeanPressure(), "shear strain": ss.ShearStrain()}
FORCE, YOUNG, DEEPEST = 40.0, 0.4e6, 4e-3


def noises() -> np.ndarray:
    """1e-3 of each kind's largest reading under the touch at the deepest place."""
    skin = ss.HalfPlane(ss.Material(YOUNG))
    y = np.linspace(-5 * DEEPEST, 5 * DEEPEST, 401)
    out = []
    for kind in KINDS.values():
        finger = ss.Finger(skin, ss.SensorArray(y, DEEPEST, kind))
        out.append(1e-3 * np.abs(finger.read(ss.LineLoad(FORCE, [0.0, np.pi / 4]))).max())
    return np.array(out)


def study(depths: int, samples: int) -> list[str]:
    """The study, all cores: a kind and a depth a thread."""
    skin, touches = ss.HalfPlane(ss.Material(YOUNG)), Touches(FORCE)
    depth = np.linspace(0.2e-3, DEEPEST, 20)[np.linspace(0, 19, depths).astype(int)]
    ratio, counts = np.linspace(0.1, 3.0, 30), list(range(3, 17))
    study_at_depth(skin, Channel(ss.NormalStrain(), 1e-3), 1e-3, [1e-3], [3], touches, samples=10)  # compiles
    begun, cpu = time.perf_counter(), time.process_time()
    channels = [Channel(kind, float(noise)) for kind, noise in zip(KINDS.values(), noises(), strict=True)]
    rows = [(channel, float(d)) for channel in channels for d in depth]
    with ThreadPoolExecutor() as pool:
        found = list(pool.map(lambda r: study_at_depth(skin, *r, ratio * r[1], counts, touches, samples=samples), rows))
    wall, cpu = time.perf_counter() - begun, time.process_time() - cpu
    designs = sum(row["wrong"].size for row in found)
    return [
        f"{designs} designs", f"{wall:.0f}", f"{cpu:.0f}", f"{1e3 * cpu / designs:.1f}",
        f"{designs * samples / wall / 1e6:.2f} million", f"{wall * 20 / depths:.0f}",
    ]  # fmt: skip


def rivals(finger: ss.Finger, touch: tuple[float, float], search: tuple[float, float]) -> float:
    """Least chi-square of a minimum apart from the true one."""
    s, sigma = np.asarray(finger.array.y), np.asarray(finger.array.noise)

    def readings(y: float, n: float, lean: float) -> np.ndarray:
        t = s - y
        return -FULL_SCALE * n * (1 + lean * t) * (1 - t * t) / (1 + t * t) ** 2 / sigma

    y, angle = touch
    frame = readings(y, np.cos(angle), np.tan(angle))
    least = np.inf
    for start in np.linspace(*search, STARTS + 2)[1:-1]:
        found = least_squares(
            lambda p: readings(*p) - frame,
            [start, 1.0, 0.0],
            bounds=([search[0], 0.0, -1.0], [search[1], np.inf, 1.0]),
            x_scale=[0.1, 1.0, 1.0],
            xtol=1e-12,
            ftol=1e-12,
            gtol=1e-12,
        )
        if abs(found.x[0] - y) > 0.02:
            least = min(least, 2 * found.cost)
    return least


def peer(touches: int) -> list[list[str]]:
    """Both on the same touches."""
    rows = []
    rng = np.random.default_rng(0)
    for count, pitch in ((3, 1.0), (4, 0.4), (4, 2.0), (6, 2.0), (8, 0.75)):
        array = ss.SensorArray.line(count, pitch, 1.0, noise=1e-3 * FULL_SCALE)
        finger = ss.Finger(ss.HalfPlane(ss.Material(1.0)), array)
        quality = placement_quality(finger, Touches(1.0), grid=(401, 161))
        at = rng.integers(0, 401, touches), rng.integers(0, 161, touches)
        positions, angles = quality.position[at[0]], quality.angle[at[1]]
        begun = time.process_time()
        chi2 = np.array([rivals(finger, t, quality.search) for t in zip(positions, angles, strict=True)])
        each = (time.process_time() - begun) / touches
        begun = time.process_time()
        gauge = Channel(ss.NormalStrain(), 1e-3 * FULL_SCALE)
        study_at_depth(finger.skin, gauge, 1.0, [pitch], [count], Touches(1.0))
        own = (time.process_time() - begun) / 1e5
        ours, theirs = quality.ambiguous[at] >= 0.5, chi2 < 13.8
        shares = [f"{100 * share.mean():.1f} %" for share in (ours, theirs, ours == theirs)]
        times = [f"{1e3 * each:.0f} ms", f"{1e6 * own:.2f} us", f"{each / own:,.0f}"]
        rows.append([f"{count} sensors, {pitch} depths", *shares, *times])
    return rows


def main() -> None:
    """Both tables."""
    given = arguments(__doc__, depths=20, samples=100_000, touches=200)
    columns = ["", "wall [s]", "CPU [s]", "CPU a design [ms]", "touches / s", "all 20 depths [s]"]
    show("Placement: 3 kinds, 30 pitches, 14 counts", columns, [study(given.depths, given.samples)], given.json)
    columns = ["", "ambiguous", "scipy", "the same touches", "scipy a touch", "a touch", "times"]
    show(f"Ambiguous touches, {given.touches} a row, beside scipy.optimize", columns, peer(given.touches), given.json)


if __name__ == "__main__":
    main()
