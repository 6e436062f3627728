"""`pressure_map` on an area: how near the truth and how fast, beside `cm` and `nnls`, in one run.

    python benchmarks/bench_pressure_area.py [--frames 40] [--peer 3] [--largest 16] [--json FILE]

Barometers on a square grid 0.75 depths apart beneath a round Hertz contact; the noise is a thousandth of the largest
reading. Errors are relative, in the L2 norm over the nodes, of the frames that have an image. Asked for: at most 1 ms a
frame at 16 x 16 sensors. Times are of the processor, of frames in a batch and one by one, the band not counted.

`cm` is what the University of Genova publishes for robot skins: W. Wasko et al., Contact Modelling and Tactile Data
Processing for Robot Skins, Sensors 19 (2019) 814, with the C++ library github.com/wojciechwasko/contact-modelling. It
takes the pseudo-inverse of the matrix from loads on cells to readings, made once: smallest loads of any sign, of all
three components where there is a drag; or nnls on that matrix ("p >= 0" here, without a drag). Its matrix is of its own
sensors, so its method is written down here, with the columns of `pressure_map`. The last peer solves the problem of
`pressure_map` by nnls, at the weights and drags found, and is checked to agree.
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


class Peers:
    """The columns of a mapper, whitened, for methods of others."""

    def __init__(self, mapper: ss.estimate.ImageMapper, drag: bool) -> None:
        hats = mapper._hats(mapper.array.live)
        self.mapper, self.noise = mapper, np.asarray(mapper.array.noise)
        self.parts = [hats.columns(i) for i in range(3 if drag else 1)]

    def cm(self, frames: np.ndarray, true: np.ndarray) -> tuple[float, float]:
        """Error, and processor seconds a frame, of the pseudo-inverse."""
        whole = np.concatenate(self.parts).T
        inverse = np.linalg.pinv(whole, rcond=max(whole.shape) * np.finfo(float).eps)
        frames = frames / self.noise
        took = spent(lambda: [inverse @ frame for frame in frames])
        found = (frames @ inverse.T)[:, : len(self.parts[0])]
        return far(found, true), took / len(frames)

    def positive(self, frames: np.ndarray, true: np.ndarray) -> tuple[float, float]:
        """The same of nnls on the matrix of the pressures."""
        matrix = self.parts[0].T
        start = time.thread_time()
        found = [nnls(matrix, frame, maxiter=10 * matrix.shape[1])[0] for frame in frames / self.noise]
        return far(np.array(found), true), (time.thread_time() - start) / len(frames)

    def same(self, frames: np.ndarray, found: ss.estimate.PressureImage) -> float:
        """Processor seconds a frame of nnls with the factor of the whole Hessian; checks that the pressures agree."""
        mapper = self.mapper
        stiff, cost = mapper._surface.prior.form.toarray(), mapper._pull(mapper._hats(mapper.array.live))
        start = time.thread_time()
        answers = []
        for f, frame in enumerate(frames / self.noise):
            t = found.tangential_force[f] / found.normal_force[f]
            columns = self.parts[0] + sum(a * part for a, part in zip(t, self.parts[1:], strict=False))
            root = np.linalg.cholesky(columns @ columns.T + found.weight[f] * stiff)
            answers.append(nnls(root.T, np.linalg.solve(root, columns @ frame - cost), maxiter=10 * len(stiff))[0])
        took = (time.thread_time() - start) / len(frames)
        mine = found.pressure[:, 1:-1, 1:-1].reshape(len(frames), -1)
        assert np.abs(mine - answers).max() < 1e-6 * mine.max()
        return took


def far(pressure: np.ndarray, true: np.ndarray) -> float:
    """Mean relative error of images (f, m) that there are."""
    return float(np.nanmean(np.linalg.norm(pressure - true, axis=1) / np.linalg.norm(true, axis=1)))


def main() -> None:
    """Print the table."""
    options = arguments(__doc__, frames=40, peer=3, largest=16)
    rows = []
    for side in (4, 8, 16, 32):
        for shear in ("none", "proportional"):
            for wide in (1.0, 2.0):
                if side <= options.largest:
                    rows.append(row(side, shear, wide, options.frames, options.peer if side <= 16 else 0))
    head = ["sensors", "shear", "half width", "OK", "error", "in band", "ms, batch", "ms, single"]
    show("pressure on an area", [*head, "cm error", "cm ms", "p >= 0 error", "p >= 0 ms", "nnls ms"], rows)


def row(side: int, shear: str, wide: float, count: int, few: int) -> list[str]:
    """One array and one contact, `few` frames for the peers."""
    skin, kind = ss.HalfSpace(ss.Material(young=0.4e6)), ss.MeanPressure()
    array = ss.SensorArray.grid(shape=(side, side), pitch=0.75 * DEPTH, depth=DEPTH, transducer=kind)
    rng = np.random.default_rng(0)
    touch = ss.RoundHertz(
        force=np.ones(count),
        angle=0.3 * (shear != "none"),
        azimuth=0.8,
        position=rng.uniform(-0.5, 0.5, (count, 2)) * DEPTH,
        half_width=wide * DEPTH,
    )
    clean = ss.Finger(skin, array).read(touch)
    noise = 1e-3 * np.abs(clean).max()
    array = ss.SensorArray.grid((side, side), 0.75 * DEPTH, DEPTH, transducer=kind, noise=noise)
    frames = clean + noise * rng.standard_normal(clean.shape)
    mapper = ss.estimate.ImageMapper(ss.Finger(skin, array), shear=shear)
    found = mapper(frames)
    true = touch.expand(2).pressure(*np.meshgrid(found.y, found.z, indexing="ij"))
    inside = (np.abs(found.pressure - true) <= 1.96 * found.pressure_std)[true > 0].mean()
    batch = spent(lambda: mapper(frames)) / count
    single = spent(lambda: [mapper(one) for one in frames]) / count
    out = [
        f"{side} x {side}", shear, f"{wide:g}", f"{(found.status == 0).mean():.2f}",
        f"{far(found.pressure.reshape(count, -1), true.reshape(count, -1)):.3f}",
        f"{inside:.2f}", f"{1e3 * batch:.2f}", f"{1e3 * single:.2f}",
    ]  # fmt: skip
    if not few:
        return [*out, *5 * ["-"]]
    peers, some = Peers(mapper, shear != "none"), frames[:few]
    inner = true[:, 1:-1, 1:-1].reshape(count, -1)
    (cm, cm_took) = peers.cm(frames, inner)
    positive = ["-", "-"]
    if shear == "none":
        wrong, took = peers.positive(some, inner[:few])
        positive = [f"{wrong:.2f}", f"{1e3 * took:.0f}"]
    return [*out, f"{cm:.2g}", f"{1e3 * cm_took:.2f}", *positive, f"{1e3 * peers.same(some, found[:few]):.0f}"]


if __name__ == "__main__":
    main()
