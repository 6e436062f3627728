"""`Finger.locate` on an area: how near to the Cramer-Rao bound, how quick, and beside least squares.

    python benchmarks/bench_area.py [--frames 20000] [--peer 50] [--singles 2000] [--json FILE]

Grids of sensors at unit depth in a half space (nu = 1/2), oblique unit loads within 40 degrees anywhere over the grid,
noise in shares of the reading beneath a normal load; the search is the default one. Errors are those of frames of
status OK. Asked for: rms error / rms bound at most 1.03, 94 to 96 % inside the 95 % interval, gross errors (beyond 6
standard deviations and 0.1 depth) at most 1e-3, unflagged at most 1e-4; 0.35, 0.2 and 0.12 M frames/s with 4 x 4, 8 x 8
and 16 x 16 sensors; a frame by itself 20 us at 4 x 4. The peer is `scipy.optimize.least_squares` from the true load, on
the closed form; the last columns have the errors of both on its frames that are OK and whose load by the peer lies in
the cone of friction. Time is that of the process; other work on the same cores still slows it.
"""

from __future__ import annotations

import math
import time

import numpy as np
from scipy.optimize import least_squares

import subskin as ss
from _common import arguments, show

KINDS = {"strain": (ss.NormalStrain(), 3 / (2 * np.pi)), "pressure": (ss.MeanPressure(), 1 / (2 * np.pi))}


def finger(side: int, pitch: float, noise: float, kind: str) -> ss.Finger:
    """`side` x `side` sensors at unit depth."""
    transducer, full_scale = KINDS[kind]
    array = ss.SensorArray.grid((side, side), pitch, 1.0, transducer=transducer, noise=noise * full_scale)
    return ss.Finger(ss.HalfSpace(ss.Material(young=1.0)), array)


def touches(side: int, pitch: float, count: int, seed: int) -> ss.PointLoad:
    """Unit loads over the array, leaning within 40 degrees to all sides."""
    rng = np.random.default_rng(seed)
    half = 0.5 * (side - 1) * pitch
    angle, azimuth = rng.uniform(0, np.deg2rad(40), count), rng.uniform(-np.pi, np.pi, count)
    at = rng.uniform(-half, half, (count, 2))
    return ss.PointLoad(force=np.ones(count), angle=angle, azimuth=azimuth, position=at)


def bound(tip: ss.Finger, load: ss.PointLoad) -> np.ndarray:
    """Cramer-Rao bound of (y, z, N, Ty, Tz), (m, 5, 5), from differences of the forward model."""
    h, at, force = 1e-4, load.position, load.components
    slopes = [
        np.einsum("mnl,ml->mn", tip.receptive_field(at + step) - tip.receptive_field(at - step), force) / (2 * h)
        for step in (np.array([h, 0.0]), np.array([0.0, h]))
    ]
    jacobian = np.concatenate([np.stack(slopes, -1), tip.receptive_field(at)], -1)
    jacobian /= np.asarray(tip.array.noise)[:, None]
    return np.linalg.inv(np.einsum("mni,mnj->mij", jacobian, jacobian))


def least(tip: ss.Finger, frame: np.ndarray, start: np.ndarray) -> np.ndarray:
    """The peer's (y, z, N, Ty, Tz) and chi-square, from `start`."""
    noise = np.asarray(tip.array.noise)

    def left(p: np.ndarray) -> np.ndarray:
        return (tip.receptive_field(p[:2]) @ p[2:] - frame) / noise

    found = least_squares(left, start, method="lm", xtol=1e-12, ftol=1e-12)
    return np.append(found.x, 2 * found.cost)


def over_bound(error: np.ndarray, variance: np.ndarray) -> list[float]:
    """Largest rms error over the rms bound, of (y, z) and of the force."""
    ratio = np.sqrt((error**2).mean(0) / variance.mean(0))
    return [ratio[:2].max(), ratio[2:].max()]


def main() -> None:
    """Run and print."""
    options = arguments(__doc__, frames=20_000, peer=50, singles=2000)
    rows, speeds = [], []
    for kind in KINDS:
        for side, pitch in ((3, 0.75), (3, 1.0), (4, 0.75), (4, 1.0), (8, 1.0), (16, 1.0)):
            for noise in (1e-3, 1e-2):
                tip = finger(side, pitch, noise, kind)
                count = max(options.frames // (1 if side <= 4 else 4 if side == 8 else 20), 1)
                load = touches(side, pitch, count, seed=side)
                frames = tip.read(load, np.random.default_rng(1))
                locator = tip.locator()
                locator(frames[:2])
                spent = math.inf
                for _ in range(5):  # the quickest: the machine has other work
                    start = time.process_time()
                    found = locator(frames)
                    spent = min(spent, (time.process_time() - start) / count)
                truth = np.concatenate([load.position, load.components], -1)
                error = np.concatenate([found.position, found.load.components], -1) - truth
                variance = np.diagonal(bound(tip, load), axis1=1, axis2=2)
                spread = np.sqrt(np.diagonal(found.load.covariance, axis1=1, axis2=2))
                ok = found.ok
                ratio = over_bound(error[ok], variance[ok])
                inside = (np.abs(error[ok]) < 1.959964 * spread[ok]).mean(0)
                away = np.abs(error[:, :2])
                gross = ~np.isfinite(away).all(-1) | ((away > 6 * spread[:, :2]) & (away > 0.1)).any(-1)
                few = min(options.peer, count)
                peer = np.array([least(tip, frames[i], truth[i]) for i in range(few)])
                worse = found.residual[:few] - peer[:, 5]
                both = ok[:few] & (np.hypot(peer[:, 3], peer[:, 4]) <= peer[:, 2])  # the peer knows no friction
                pair = [over_bound(e[both], variance[:few][both]) for e in (error[:few], peer[:, :5] - truth[:few])]
                name = f"{kind}, {side} x {side}, {pitch} depth, {noise:.1%}"
                rows.append(
                    [
                        name,
                        *(f"{part:.3f}" for part in ratio),
                        *(f"{100 * inside.min():.1f} to {100 * inside.max():.1f}",),
                        f"{(found.status == ss.Status.AMBIGUOUS).mean():.2%}",
                        f"{gross.mean():.1e}",
                        f"{(gross & ok).mean():.1e}",
                        f"{worse.max():.1e}",
                        *("{:.3f}, {:.3f}".format(*part) for part in pair),
                    ]
                )
                one, single = frames[0].copy(), []
                for _ in range(options.singles):
                    start = time.perf_counter_ns()
                    tip.locate(one)
                    single.append(time.perf_counter_ns() - start)
                speeds.append([name, f"{1e-6 / spent:.3f}", f"{1e-3 * np.median(single):.1f}"])
                print(rows[-1], speeds[-1][1:], flush=True)
    columns = ["OK frames", "position / bound", "force / bound", "in 95 %", "ambiguous", "gross", "gross, unflagged"]
    columns += ["chi-square over the peer's", "first frames / bound", "the peer / bound"]
    show(f"locate on an area, {options.frames} frames", columns, rows, options.json)
    show("Speed of locate on an area", ["sensors", "M frames/s a core", "Finger.locate, us"], speeds, options.json)


if __name__ == "__main__":
    main()
