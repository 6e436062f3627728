"""`Finger.fit` on an area: round contacts beside the Cramer-Rao bound, how sure the width is, and how quick.

    python benchmarks/bench_round.py [--frames 10000] [--peer 10] [--json FILE]

Grids of sensors at unit depth and pitch in a half space (nu = 1/2), oblique unit Hertz contacts of half widths 0.02 to
1.3 depths within 40 degrees anywhere over the grid, noise in shares of the reading beneath a normal point load. Errors
are those of frames of status OK. The bound is that of the five unknowns and of the square of the half width, over
contacts wider than three of its standard deviations; `begins at 0` counts intervals of the width that do, over contacts
narrower than one. A gross error is beyond 6 standard deviations, in position or in the square of the half width, and
beyond 0.1 depth. The peer is `scipy.optimize.least_squares` from the true contact, on the closed form. Time is that of
the process.
"""

from __future__ import annotations

import time

import numpy as np
from scipy.optimize import least_squares

import subskin as ss
from _common import arguments, show

KINDS = {"strain": (ss.NormalStrain(), 3 / (2 * np.pi)), "pressure": (ss.MeanPressure(), 1 / (2 * np.pi))}


def finger(side: int, noise: float, kind: str) -> ss.Finger:
    """`side` x `side` sensors at unit depth."""
    transducer, full_scale = KINDS[kind]
    array = ss.SensorArray.grid((side, side), 1.0, 1.0, transducer=transducer, noise=noise * full_scale)
    return ss.Finger(ss.HalfSpace(ss.Material(young=1.0)), array)


def touches(side: int, count: int, seed: int) -> ss.RoundHertz:
    """Unit contacts over the array."""
    rng = np.random.default_rng(seed)
    half = 0.5 * (side - 1)
    return ss.RoundHertz(
        force=np.ones(count),
        angle=rng.uniform(0, np.deg2rad(40), count),
        azimuth=rng.uniform(-np.pi, np.pi, count),
        position=rng.uniform(-half, half, (count, 2)),
        half_width=rng.uniform(0.02, 1.3, count),
    )


def bound(tip: ss.Finger, touch: ss.RoundHertz) -> np.ndarray:
    """Cramer-Rao bound of (y, z, N, Ty, Tz, square of the half width), (m, 6, 6), from differences."""
    at, force, square = touch.position, touch.components, np.asarray(touch.half_width) ** 2

    def read(at: np.ndarray, force: np.ndarray, square: np.ndarray) -> np.ndarray:
        return tip.measure(ss.RoundHertz(components=force, position=at, half_width=np.sqrt(square)))

    columns = []
    for k in range(6):
        step = np.zeros(6)
        step[k] = 1e-4
        change = 1e-4 if k < 5 else 1e-2 * square
        ends = [
            read(at + s * step[:2], force + s * step[2:5], square + (s * change if k == 5 else 0.0)) for s in (1, -1)
        ]
        columns.append((ends[0] - ends[1]) / (2 * np.reshape(change, (-1, 1))))
    jacobian = np.stack(columns, -1) / np.asarray(tip.array.noise)[:, None]
    return np.linalg.inv(np.einsum("mni,mnj->mij", jacobian, jacobian))


def least_chi2(tip: ss.Finger, frame: np.ndarray, start: np.ndarray) -> float:
    """Chi-square of the peer, from `start` (y, z, N, Ty, Tz, half width)."""
    noise = np.asarray(tip.array.noise)

    def left(p: np.ndarray) -> np.ndarray:
        touch = ss.RoundHertz(components=p[2:5], position=p[:2], half_width=max(abs(p[5]), 1e-6))
        return (tip.measure(touch) - frame) / noise

    return float(2 * least_squares(left, start, method="lm", xtol=1e-12, ftol=1e-12).cost)


def main() -> None:
    """Run and print."""
    options = arguments(__doc__, frames=10_000, peer=10)
    rows = []
    for kind in KINDS:
        for side in (3, 4, 8):
            for noise in (1e-3, 1e-2):
                tip, half = finger(side, noise, kind), 0.5 * (side - 1) + 0.5
                count = max(options.frames // (1 if side <= 4 else 4), 1)
                touch = touches(side, count, seed=side)
                frames = tip.read(touch, np.random.default_rng(1))
                locator = tip.locator("round_hertz", search=((-half, half), (-half, half)))
                locator(frames[:2])
                start = time.process_time()
                found = locator(frames)
                spent = (time.process_time() - start) / count
                width = np.asarray(touch.half_width)
                truth = np.concatenate([touch.position, touch.components], -1)
                error = np.concatenate([found.position, found.load.components], -1) - truth
                variance = np.diagonal(bound(tip, touch), axis1=1, axis2=2)
                spread = np.sqrt(np.diagonal(found.load.covariance, axis1=1, axis2=2))
                ok, (low, high) = found.ok, np.moveaxis(found.half_width_interval, -1, 0)
                squares = found.half_width**2 - width**2
                seen = ok & (width**2 > 3 * np.sqrt(variance[:, 5]))
                unseen = ok & (width**2 < np.sqrt(variance[:, 5]))
                every = np.concatenate([error, squares[:, None]], -1)
                ratio = np.sqrt((every[seen] ** 2).mean(0) / variance[seen].mean(0))
                inside = (np.abs(error[ok]) < 1.959964 * spread[ok]).mean(0)
                away = np.abs(np.column_stack([error[:, :2], found.half_width - width]))
                told = np.maximum(high**2 - found.half_width**2, found.half_width**2 - low**2) / 1.959964
                beyond = np.column_stack([np.abs(error[:, :2]) > 6 * spread[:, :2], np.abs(squares) > 6 * told])
                gross = ~np.isfinite(away).all(-1) | (beyond & (away > 0.1)).any(-1)
                few = range(min(options.peer, count))
                start_at = np.column_stack([truth, width])
                worse = [float(found.residual[i]) - least_chi2(tip, frames[i], start_at[i]) for i in few]
                rows.append(
                    [
                        f"{kind}, {side} x {side}, {noise:.1%}",
                        *(f"{part.max():.3f}" for part in (ratio[:2], ratio[2:5], ratio[5:])),
                        f"{100 * inside.min():.1f} to {100 * inside.max():.1f}",
                        f"{100 * ((low <= width) & (width <= high))[ok].mean():.1f}",
                        f"{(low[unseen] == 0).mean():.1%}",
                        f"{(found.status == ss.Status.AMBIGUOUS).mean():.2%}",
                        f"{gross.mean():.1e}",
                        f"{(gross & ok).mean():.1e}",
                        f"{max(worse):.0e}",
                        f"{1e-3 / spent:.1f}",
                    ]
                )
                print(rows[-1], flush=True)
    columns = ["OK frames", "position / bound", "force", "square of width", "in 95 %", "width in 95 %", "begins at 0"]
    columns += ["ambiguous", "gross", "gross, OK", "chi-square over the peer's", "1000 frames/s"]
    show(f"round contacts on an area, {options.frames} frames", columns, rows, options.json)


if __name__ == "__main__":
    main()
