"""The problem that the benchmarks of `locate` share, its peers, and a table."""

from __future__ import annotations

import argparse
import json
import os
import platform
from pathlib import Path

import numpy as np
from rich.console import Console
from rich.table import Table
from scipy.optimize import least_squares

import subskin as ss

FULL_SCALE = 3 / (2 * np.pi)  # strain beneath a unit normal load at unit depth, E = 1 (memo eq. 8)


def finger(sensors: int, pitch: float, noise: float) -> ss.Finger:
    """`sensors` at unit depth, `pitch` in depths, noise in shares of the full scale."""
    array = ss.SensorArray.line(sensors, pitch=pitch, depth=1.0, noise=noise * FULL_SCALE)
    return ss.Finger(ss.HalfPlane(ss.Material(young=1.0)), array)


def search(sensors: int, pitch: float) -> tuple[float, float]:
    """The array and half a depth beyond it."""
    half = 0.5 * (sensors - 1) * pitch + 0.5
    return -half, half


def touches(sensors: int, pitch: float, count: int, seed: int) -> ss.LineLoad:
    """Unit loads over the array, leaning within 40 degrees."""
    rng = np.random.default_rng(seed)
    half = 0.5 * (sensors - 1) * pitch
    angle = rng.uniform(-np.deg2rad(40), np.deg2rad(40), count)
    return ss.LineLoad(force=np.ones(count), angle=angle, position=rng.uniform(-half, half, count))


def bound(tip: ss.Finger, load: ss.LineLoad) -> np.ndarray:
    """Cramer-Rao bound of (position, force, angle), (m, 3, 3), from differences of the forward model."""
    h = 1e-5
    y, n = np.asarray(load.position), np.stack([load.normal_force, load.tangential_force], -1)
    turned = np.stack([-n[:, 1], n[:, 0]], -1)
    field = tip.receptive_field(y)
    slope = (tip.receptive_field(y + h) - tip.receptive_field(y - h)) / (2 * h)
    unit = n / np.asarray(load.force)[:, None]
    columns = [np.einsum("mnl,ml->mn", a, b) for a, b in ((slope, n), (field, unit), (field, turned))]
    jacobian = np.stack(columns, -1) / np.asarray(tip.array.noise)[:, None]
    return np.linalg.inv(np.einsum("mni,mnj->mij", jacobian, jacobian))


def multi_start(tip: ss.Finger, frame: np.ndarray, ends: tuple[float, float], starts: int = 8) -> np.ndarray:
    """The peer: position, force, angle by scipy.optimize.least_squares from `starts` places, the best of them."""
    s, sigma = np.asarray(tip.array.y), np.asarray(tip.array.noise)

    def residual(p: np.ndarray) -> np.ndarray:
        t = s - p[0]
        q = 1 + t * t
        return (-FULL_SCALE * (p[1] + p[2] * t) * (1 - t * t) / (q * q) - frame) / sigma

    best = min(
        (least_squares(residual, [y, 1.0, 0.0], method="lm") for y in np.linspace(*ends, starts)),
        key=lambda r: r.cost + 1e9 * (r.x[1] <= 0 or abs(r.x[2]) > r.x[1] or not ends[0] <= r.x[0] <= ends[1]),
    ).x
    return np.array([best[0], np.hypot(best[1], best[2]), np.arctan2(best[2], best[1])])


def eq13_roots(tip: ss.Finger, frame: np.ndarray) -> np.ndarray:
    """The other peer: numpy.roots on the memo's eq. (13), for the first three sensors."""
    b = float(tip.array.y[1] - tip.array.y[0])
    square = np.polynomial.Polynomial([0, 0, 1])
    y = np.polynomial.Polynomial([0, 1])
    e = frame[:3]

    def near(t: np.polynomial.Polynomial) -> np.polynomial.Polynomial:
        return 1 - t * t

    def far(t: np.polynomial.Polynomial) -> np.polynomial.Polynomial:
        return (1 + t * t) ** 2

    f = 2 * e[1] * (1 + square) ** 2 * near(y - b) * near(y + b)
    f = f - e[0] * far(y + b) * near(y) * near(y - b) - e[2] * far(y - b) * near(y) * near(y + b)
    roots = np.roots(f.coef[::-1])
    return roots[np.abs(roots.imag) < 1e-9].real


def machine() -> str:
    """Processor, cores and versions, on a line."""
    info = Path("/proc/cpuinfo")
    names = (
        [ln.split(":")[1].strip() for ln in info.read_text().splitlines() if ln.startswith("model name")]
        if info.exists()
        else []
    )
    load = f", load {os.getloadavg()[0]:.1f}" if hasattr(os, "getloadavg") else ""
    versions = f"Python {platform.python_version()}, NumPy {np.__version__}"
    return f"{names[0] if names else platform.machine()}, {os.cpu_count()} cores{load}, {versions}"


def show(title: str, columns: list[str], rows: list[list[str]], target: Path | None = None) -> None:
    """Print a table, and append it to a JSON file where one is named."""
    table = Table(title=title, title_justify="left", caption=machine(), caption_justify="left")
    for i, name in enumerate(columns):
        table.add_column(name, justify="left" if i == 0 else "right")
    for row in rows:
        table.add_row(*row)
    Console(width=None if os.isatty(1) else 150).print(table)
    if target:
        old = json.loads(target.read_text()) if target.exists() else []
        target.write_text(
            json.dumps([*old, {"title": title, "machine": machine(), "columns": columns, "rows": rows}], indent=1)
        )


def arguments(about: str | None, **options: int | str | Path) -> argparse.Namespace:
    """`--json FILE` and the whole numbers, words and folders of a benchmark, with their defaults."""
    parser = argparse.ArgumentParser(description=about)
    parser.add_argument("--json", type=Path, help="append the tables to this file")
    for name, default in options.items():
        parser.add_argument(f"--{name}", type=type(default), default=default, help=f"({default})")
    return parser.parse_args()
