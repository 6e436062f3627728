"""What a free drag on an area is worth: how far off, and whether its band holds it, by array, noise and sort of touch.

    python benchmarks/study_free_drag.py [--touches 4] [--side 8] [--json FILE]

Random touches of five sorts, of half widths of 1 to 2.5 pitches, within the array as far as they fit: a round Hertz
pressure that twists, q = min(c r, mu p) round its centre; one in partial slip (Cattaneo and Mindlin), dragged only at
its rim; one that slides with q = 0.3 p; one without drag; and two that are dragged against each other. mu is 0.6, and
`friction=0.6`. Noise in shares of each touch's largest reading of its kind of sensor.

Errors are the rms beneath the touch, in shares of its largest pressure. "in band" are the shares of the pressed nodes
whose true pressure, and drag along y and z, are in the 95 % bands. The totals are told in their own standard
deviations, as the rms of all touches. Of `shear="proportional"`, the same errors, of the frames it explains.
"""

from __future__ import annotations

import os

os.environ.setdefault("OMP_NUM_THREADS", "1")
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import time
from collections.abc import Callable
from dataclasses import replace

import numpy as np

import subskin as ss
from _common import arguments, show
from subskin.transducer import Displacement, MagnetDisplacement

DEPTH, FRICTION = 2e-3, 0.6
PITCH = 0.75 * DEPTH
SORTS = ("twist", "slip", "slide", "press", "two")
SKIN = ss.HalfSpace(ss.Material(young=0.4e6))

Field = Callable[[np.ndarray, np.ndarray], tuple[np.ndarray, np.ndarray]]


def array(kind: str, side: int) -> ss.SensorArray:
    """Channels of several kinds at each position."""
    magnets = [MagnetDisplacement(axis, moment=7.9e-3, gap=3e-3) for axis in "xyz"]
    moves = [Displacement(axis) for axis in "xyz"]
    pressure, shears = ss.MeanPressure(), [ss.ShearStrain("xy"), ss.ShearStrain("xz")]
    kinds = {"magnets": magnets, "displacement": moves, "pressure, two shear strains": [pressure, *shears]}[kind]
    return ss.SensorArray.grid((side, side), PITCH, DEPTH, channels=kinds, noise=1.0)


def touch(sort: str, side: int, rng: np.random.Generator) -> Field:
    """The true traction, of largest pressure 1."""
    half = 0.5 * (side - 1) * PITCH
    a = rng.uniform(1.0, min(2.5, 0.9 * half / PITCH)) * PITCH
    away = rng.uniform(-np.pi, np.pi)
    ahead = np.array([np.cos(away), np.sin(away)])
    if sort == "two":
        a = min(a, 0.4 * half)
        middle = (a + rng.uniform(0.2, 1.0) * max(half - 2 * a, 0.0)) * ahead[::-1]
    else:
        middle = rng.uniform(-1, 1, 2) * max(half - a, 0.0)

    def field(y: np.ndarray, z: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        dy, dz = y - middle[0], z - middle[1]
        r = np.hypot(dy, dz)
        p = _dome(r / a)
        if sort == "twist":
            size = np.minimum(0.5 * r / a, FRICTION * p) / np.maximum(r, 1e-9)
            return p, np.stack([-dz * size, dy * size], axis=-1)
        if sort == "slip":
            return p, (FRICTION * (p - 0.7 * _dome(r / (0.7 * a))))[..., None] * ahead
        if sort == "two":
            other = _dome(np.hypot(y + middle[0], z + middle[1]) / a)
            return p + other, 0.5 * (p - other)[..., None] * ahead
        return p, (0.3 * (sort == "slide") * p)[..., None] * ahead

    return field


def _dome(r: np.ndarray) -> np.ndarray:
    return np.sqrt(np.maximum(1 - r**2, 0.0))


def contact(field: Field, side: int) -> tuple[ss.PressureGrid, np.ndarray]:
    """The same on nodes much finer than those of the mapper, and its N, Ty, Tz and moment."""
    half = 0.5 * (side - 1) * PITCH + 0.01 * PITCH
    at = np.linspace(-half, half, 8 * side + 1)
    y, z = np.meshgrid(at, at, indexing="ij")
    inner = np.pad(np.ones((at.size - 2, at.size - 2)), 1)
    p, q = field(y, z)
    p, q = p * inner, q * inner[..., None]
    y, z = (one - (p * one).sum() / p.sum() for one in (y, z))
    sums = np.array([p.sum(), *q.sum(axis=(0, 1)), (y * q[..., 1] - z * q[..., 0]).sum()])
    return ss.PressureGrid(at, at, p, q), sums * (at[1] - at[0]) ** 2


def study(kind: str, side: int, noise: float, sorts: tuple[str, ...], count: int) -> list[list[str]]:
    """Rows of one array, one for each sort."""
    bare, rows = array(kind, side), []
    names = np.array([type(one).__name__ for one in bare.transducers])
    for sort in sorts:
        rng, off, held, width, scores, ok, took, seen = np.random.default_rng(0), [], [], [], [], 0, 0.0, 0.0
        for _ in range(count):
            field = touch(sort, side, rng)
            pressing, totals = contact(field, side)
            felt = ss.Finger(SKIN, bare).read(pressing)
            sigma = np.empty(felt.size)
            for name in set(names):
                sigma[names == name] = noise * np.abs(felt[names == name]).max()
            finger = ss.Finger(SKIN, replace(bare, noise=sigma))
            mapper = ss.estimate.ImageMapper(finger, shear="free", friction=FRICTION)
            seen = mapper.shear_seen
            frame = felt + sigma * rng.standard_normal(felt.size)
            found = mapper(frame)
            start = time.process_time()
            mapper(frame)
            took += time.process_time() - start
            common = ss.pressure_map(finger, frame, friction=FRICTION)
            ok += found.status == ss.Status.OK
            y, z = np.meshgrid(found.y, found.z, indexing="ij")
            true = np.concatenate([part.reshape(*y.shape, -1) for part in field(y, z)], axis=-1)
            on = true[..., 0] > 0
            mine, other = (np.concatenate([f.pressure[..., None], f.shear], axis=-1)[on] for f in (found, common))
            std = np.concatenate([found.pressure_std[..., None], found.shear_std], axis=-1)[on]
            peak = true[..., 0].max()
            far = [np.sqrt(((one - true[on]) ** 2).mean(axis=0)) / peak for one in (mine, other)]
            off.append([far[0][0], np.hypot(*far[0][1:]), far[1][0], np.hypot(*far[1][1:])])
            inside = np.abs(mine - true[on]) <= 1.96 * std
            held.append([inside[:, 0].mean(), inside[:, 1:].mean()])
            width.append([3.92 * std[:, 0].mean() / peak, 3.92 * std[:, 1:].mean() / peak])
            scores.append(_scores(found, totals))
        far, explained = np.array(off), np.isfinite(off)
        rms = np.sqrt((np.where(explained, far, 0.0) ** 2).sum(axis=0) / np.maximum(explained.sum(axis=0), 1))
        inside, wide = np.mean(held, axis=0), np.mean(width, axis=0)
        z = np.sqrt(np.mean(np.array(scores) ** 2, axis=0))
        rows.append([
            kind, f"{side} x {side}", f"{seen:.2f}", f"{100 * noise:g} %", sort, f"{ok / count:.2f}",
            f"{rms[0]:.3f}, {rms[1]:.3f}", f"{inside[0]:.2f}, {inside[1]:.2f}",
            f"{wide[0] / rms[0]:.1f}, {wide[1] / (rms[1] / np.sqrt(2)):.1f}", ", ".join(f"{one:.1f}" for one in z),
            f"{rms[2]:.3f}, {rms[3]:.3f} of {explained[:, 2].sum()}", f"{1e3 * took / count:.1f}",
        ])  # fmt: skip
    return rows


def _scores(found: ss.PressureImage, totals: np.ndarray) -> np.ndarray:
    """Errors of N, of Ty and Tz, and of the moment, in standard deviations."""
    drag = (found.tangential_force - totals[1:3]) / found.tangential_std
    normal, moment = (found.normal_force - totals[0]) / found.normal_std, (found.moment - totals[3]) / found.moment_std
    return np.array([normal, np.sqrt((drag**2).mean()), moment])


def main() -> None:
    """Print the table."""
    options = arguments(__doc__, touches=4, side=8)
    rows = []
    for kind in ("magnets", "displacement", "pressure, two shear strains"):
        for noise in (1e-3, 1e-2):
            rows += study(kind, options.side, noise, SORTS, options.touches)
    head = ["sensors", "array", "seen", "noise", "touch", "OK", "off: p, q", "in band: p, q", "width / rms: p, q"]
    show("free drag on an area", [*head, "totals: N, T, M", "one direction: p, q", "ms a frame"], rows)


if __name__ == "__main__":
    main()
