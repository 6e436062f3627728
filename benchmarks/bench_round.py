"""`Finger.fit` on an area: round contacts beside the Cramer-Rao bound, how sure the width is, and how quick.

    python benchmarks/bench_round.py [--frames 10000] [--peer 10] [--json FILE]

Grids of sensors at unit depth and pitch in a half space (nu = 1/2), oblique unit Hertz contacts of half widths 0.02
to 1.3 depths within 40 degrees anywhere over the grid, noise in shares of the reading beneath a normal point load (of
shear in shares of the normal strain there). Sensors of shear strain in the surface also see a moment about the
normal, at most 95 % of what friction of 1 holds. Errors are those of frames of status OK. The bound is that of the
five unknowns, of the square of the half width and of the moment, over contacts wider than three standard deviations;
`begins at 0` counts intervals of the width that do, over contacts narrower than one. A gross error is beyond 6
standard deviations, in position or in the square of the half width, and beyond 0.1 depth. The peer is
`scipy.optimize.least_squares` from the true contact, on the closed form. Time is that of the process.
"""

from __future__ import annotations

import time

import numpy as np
from scipy.optimize import least_squares

import subskin as ss
from _common import arguments, show

KINDS = {
    "strain": (ss.NormalStrain(), 3 / (2 * np.pi)),
    "pressure": (ss.MeanPressure(), 1 / (2 * np.pi)),
    "shear yz": (ss.transducer.ShearStrain("yz"), 3 / (2 * np.pi)),
}
TWISTS = {"shear yz"}
FRICTION_ARM = 3 * np.pi / 16  # of a Hertz contact, in half widths


def finger(side: int, noise: float, kind: str) -> ss.Finger:
    """`side` x `side` sensors at unit depth."""
    transducer, full_scale = KINDS[kind]
    array = ss.SensorArray.grid((side, side), 1.0, 1.0, transducer=transducer, noise=noise * full_scale)
    return ss.Finger(ss.HalfSpace(ss.Material(young=1.0)), array)


def touches(side: int, count: int, seed: int, kind: str) -> ss.RoundHertz:
    """Unit contacts over the array."""
    rng = np.random.default_rng(seed)
    half = 0.5 * (side - 1)
    angle, azimuth = rng.uniform(0, np.deg2rad(40), count), rng.uniform(-np.pi, np.pi, count)
    position, width = rng.uniform(-half, half, (count, 2)), rng.uniform(0.02, 1.3, count)
    moment = 0.95 * FRICTION_ARM * width * rng.uniform(-1, 1, count) if kind in TWISTS else 0.0
    return ss.RoundHertz(np.ones(count), angle, azimuth, position, width, moment=moment)


def bound(tip: ss.Finger, touch: ss.RoundHertz, twists: bool) -> np.ndarray:
    """Cramer-Rao bound of (y, z, N, Ty, Tz, square of the half width[, moment]), (m, k, k), from differences."""
    square, unknowns = np.asarray(touch.half_width) ** 2, 6 + twists

    def read(step: np.ndarray, wider: np.ndarray | float) -> np.ndarray:
        return tip.measure(
            ss.RoundHertz(
                components=touch.components + step[2:5],
                position=touch.position + step[:2],
                half_width=np.sqrt(square + wider),
                moment=touch.moment + step[6],
            )
        )

    columns = []
    for k in range(unknowns):
        step, change = np.zeros(7), 1e-2 * square if k == 5 else np.full(square.size, 1e-4)
        step[k] = 1e-4 * (k != 5)
        wider = change if k == 5 else 0.0
        columns.append((read(step, wider) - read(-step, -wider)) / (2 * change[:, None]))
    jacobian = np.stack(columns, -1) / np.asarray(tip.array.noise)[:, None]
    return np.linalg.inv(np.einsum("mni,mnj->mij", jacobian, jacobian))


def least_chi2(tip: ss.Finger, frame: np.ndarray, start: np.ndarray) -> float:
    """Chi-square of the peer, from `start` (y, z, N, Ty, Tz, half width[, moment])."""
    noise = np.asarray(tip.array.noise)

    def left(p: np.ndarray) -> np.ndarray:
        moment = p[6] if p.size > 6 else 0.0
        touch = ss.RoundHertz(components=p[2:5], position=p[:2], half_width=max(abs(p[5]), 1e-6), moment=moment)
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
                touch, twists = touches(side, count, side, kind), kind in TWISTS
                frames = tip.read(touch, np.random.default_rng(1))
                locator = tip.locator("round_hertz", search=((-half, half), (-half, half)))
                locator(frames[:2])
                start = time.process_time()
                found = locator(frames)
                spent = (time.process_time() - start) / count
                width = np.asarray(touch.half_width)
                truth = np.column_stack([touch.position, touch.components, *[touch.moment] * twists])
                answer = np.column_stack([found.position, found.load.components, *[found.load.moment] * twists])
                error = answer - truth
                variance = np.diagonal(bound(tip, touch, twists), axis1=1, axis2=2)
                spread = np.sqrt(np.diagonal(found.load.covariance, axis1=1, axis2=2))
                ok, (low, high) = found.ok, np.moveaxis(found.half_width_interval, -1, 0)
                squares = found.half_width**2 - width**2
                seen = ok & (width**2 > 3 * np.sqrt(variance[:, 5]))
                unseen = ok & (width**2 < np.sqrt(variance[:, 5]))
                every = np.insert(error, 5, squares, axis=1)
                ratio = np.sqrt((every[seen] ** 2).mean(0) / variance[seen].mean(0))
                inside = (np.abs(error[ok]) < 1.959964 * spread[ok]).mean(0)
                away = np.abs(np.column_stack([error[:, :2], found.half_width - width]))
                told = np.maximum(high**2 - found.half_width**2, found.half_width**2 - low**2) / 1.959964
                beyond = np.column_stack([np.abs(error[:, :2]) > 6 * spread[:, :2], np.abs(squares) > 6 * told])
                gross = ~np.isfinite(away).all(-1) | (beyond & (away > 0.1)).any(-1)
                few = range(min(options.peer, count))
                start_at = np.insert(truth, 5, width, axis=1)
                worse = [float(found.residual[i]) - least_chi2(tip, frames[i], start_at[i]) for i in few]
                rows.append(
                    [
                        f"{kind}, {side} x {side}, {noise:.1%}",
                        *(f"{part.max():.3f}" for part in (ratio[:2], ratio[2:5], ratio[5:6])),
                        f"{ratio[6]:.3f}" if twists else "-",
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
    columns = [
        "OK frames",
        "position / bound",
        "force",
        "square of width",
        "moment",
        "in 95 %",
        "width in 95 %",
        "begins at 0",
    ]
    columns += ["ambiguous", "gross", "gross, OK", "chi-square over the peer's", "1000 frames/s"]
    show(f"round contacts on an area, {options.frames} frames", columns, rows, options.json)


if __name__ == "__main__":
    main()
