"""`pressure_map` on an area: how near the truth and how fast, beside a loop over `scipy.optimize.nnls`, in one run.

    python benchmarks/bench_pressure_area.py [--frames 40] [--peer 3] [--json FILE]

Barometers on a square grid 0.75 depths apart beneath a round Hertz contact; the noise is a thousandth of the largest
reading. Errors are relative, in the L2 norm over the nodes. Asked for: at most 1 ms a frame at 16 x 16 sensors. Times
are of the processor, of frames in a batch and one by one, the band not counted. The peer is given the weights (and
drags) that `pressure_map` found, and solves for the pressure alone.
"""

from __future__ import annotations

import os

os.environ.setdefault("OMP_NUM_THREADS", "1")
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import time

import numpy as np
from scipy.optimize import nnls

import subskin as ss
from _common import arguments, show

DEPTH = 2e-3


def spent(work: object, runs: int = 3) -> float:
    """Processor seconds of the fastest run."""
    out = []
    for _ in range(runs):
        start = time.thread_time()
        work()
        out.append(time.thread_time() - start)
    return min(out)


def peer(mapper: ss.estimate.ImageMapper, frames: np.ndarray, found: ss.estimate.PressureImage) -> float:
    """Processor seconds a frame of nnls with the factor of the whole Hessian; checks that the pressures agree."""
    level = mapper._prepare(mapper.array.live)[1].fine
    ny, nz = level.sizes[:2]
    m = ny * nz
    stiff = np.zeros((m, m))
    y, z = np.divmod(np.arange(m), nz)
    for dy in (-1, 0, 1):
        for dz in (-1, 0, 1):
            there = (0 <= y + dy) & (y + dy < ny) & (0 <= z + dz) & (z + dz < nz)
            stiff[np.flatnonzero(there), np.flatnonzero(there) + dy * nz + dz] = level.stencil[abs(dy), abs(dz)]
    start = time.thread_time()
    answers = []
    for f, frame in enumerate(frames / np.asarray(mapper.array.noise)):
        t = found.tangential_force[f] / found.normal_force[f]
        columns = level.parts[0] + sum(a * part for a, part in zip(t, level.parts[1:], strict=False))
        root = np.linalg.cholesky(columns @ columns.T + found.weight[f] * stiff)
        answers.append(nnls(root.T, np.linalg.solve(root, columns @ frame - level.cost), maxiter=10 * m)[0])
    took = (time.thread_time() - start) / len(frames)
    mine = found.pressure[:, 1:-1, 1:-1].reshape(len(frames), -1)
    assert np.abs(mine - answers).max() < 1e-6 * mine.max()
    return took


def main() -> None:
    """Print the tables."""
    options = arguments(__doc__, frames=40, peer=3)
    rows = []
    for side in (4, 8, 16):
        for shear in ("none", "proportional"):
            for wide in (1.0, 2.0):
                skin = ss.HalfSpace(ss.Material(young=0.4e6))
                kind = ss.MeanPressure()
                array = ss.SensorArray.grid(shape=(side, side), pitch=0.75 * DEPTH, depth=DEPTH, transducer=kind)
                rng = np.random.default_rng(0)
                touch = ss.RoundHertz(
                    force=np.ones(options.frames),
                    angle=0.3 * (shear != "none"),
                    azimuth=0.8,
                    position=rng.uniform(-0.5, 0.5, (options.frames, 2)) * DEPTH,
                    half_width=wide * DEPTH,
                )
                clean = ss.Finger(skin, array).read(touch)
                noise = 1e-3 * np.abs(clean).max()
                array = ss.SensorArray.grid((side, side), 0.75 * DEPTH, DEPTH, transducer=kind, noise=noise)
                frames = clean + noise * rng.standard_normal(clean.shape)
                mapper = ss.estimate.ImageMapper(ss.Finger(skin, array), shear=shear)
                found = mapper(frames)
                y, z = np.meshgrid(found.y, found.z, indexing="ij")
                true = touch.expand(2).pressure(y, z)
                off = np.linalg.norm(found.pressure - true, axis=(1, 2)) / np.linalg.norm(true, axis=(1, 2))
                inside = (np.abs(found.pressure - true) <= 1.96 * found.pressure_std)[true > 0].mean()
                batch = spent(lambda m=mapper, f=frames: m(f)) / len(frames)
                single = spent(lambda m=mapper, f=frames: [m(one) for one in f]) / len(frames)
                few = slice(0, options.peer)
                beside = peer(mapper, frames[few], found[few]) if options.peer else np.nan
                rows.append(
                    [
                        f"{side} x {side}", shear, f"{wide:g}", f"{(found.status == 0).mean():.2f}",
                        f"{off.mean():.3f}",
                        f"{inside:.2f}", f"{1e3 * batch:.2f}", f"{1e3 * single:.2f}", f"{1e3 * beside:.0f}",
                    ]
                )  # fmt: skip
    head = ["sensors", "shear", "half width", "OK", "error", "in band", "ms, batch", "ms, single", "nnls ms"]
    show("pressure on an area", head, rows)


if __name__ == "__main__":
    main()
