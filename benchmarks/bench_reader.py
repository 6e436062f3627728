"""Frames a second of 16 x 16 sensors: `Finger.read`, and its reader in NumPy, JAX and PyTorch; digits; gradients.

    python benchmarks/bench_reader.py [--frames 4000] [--json FILE]

Rows of a library that is not installed are left out. Medians of nine turns that alternate, double precision.
"""

from __future__ import annotations

from collections.abc import Callable
from time import perf_counter
from typing import Any

import numpy as np

import subskin as ss
from _common import arguments, show

CONTACTS = {
    "point": (ss.PointLoad, ""),
    "patch": (ss.Patch, "half_widths"),
    "round_hertz": (ss.RoundHertz, "half_width"),
}
TURNS = 9


def in_jax(finger: ss.Finger, name: str, loads: dict[str, Any]) -> dict[str, Callable[[], Any]]:
    """Readings, and the gradient of their sum by loads, compiled."""
    import jax

    jax.config.update("jax_enable_x64", True)
    read, given = finger.reader("jax", contact=name), {k: jax.numpy.asarray(v) for k, v in loads.items()}
    forward, back = jax.jit(read), jax.jit(jax.grad(lambda at: read(at).sum()))
    return {
        "JAX": lambda: forward(given).block_until_ready(),
        "JAX, gradient": lambda: jax.block_until_ready(back(given)),
    }


def in_torch(finger: ss.Finger, name: str, loads: dict[str, Any]) -> dict[str, Callable[[], Any]]:
    """Readings, as they are."""
    import torch

    torch.set_default_dtype(torch.float64)
    torch.set_num_threads(2)
    read, given = finger.reader("torch", contact=name), {k: torch.tensor(v) for k, v in loads.items()}
    return {"PyTorch": lambda: read(given)}


def main() -> None:
    """Print the table."""
    told, rng, rows = arguments(__doc__, frames=4000), np.random.default_rng(0), []
    array = ss.SensorArray.grid((16, 16), 2e-3, 2e-3)
    finger = ss.Finger(ss.HalfSpace(ss.Material(0.4e6, 0.45)), array)
    for name, (kind, size) in CONTACTS.items():
        loads = {
            "components": rng.standard_normal((told.frames, 3)) + np.array([2.0, 0.0, 0.0]),
            "position": rng.uniform(-15e-3, 15e-3, (told.frames, 2)),
        }
        if size:
            shape = (told.frames, 2) if name == "patch" else told.frames
            loads[size] = rng.uniform(0.5e-3, 4e-3, shape)
        contact, plain = kind(**loads), finger.reader(contact=name)
        calls: dict[str, Callable[[], Any]] = {
            "Finger.read": lambda contact=contact: finger.read(contact),
            "NumPy": lambda plain=plain, loads=loads: plain(loads),
        }
        for make in (in_jax, in_torch):
            try:
                calls |= make(finger, name, loads)
            except ModuleNotFoundError as error:
                print(error)
        spent: dict[str, list[float]] = {call: [] for call in calls}
        wanted = finger.read(contact)
        off = {
            call: np.abs(np.asarray(what()) - wanted).max() / np.abs(wanted).max()
            for call, what in calls.items()
            if "gradient" not in call
        }
        for call in calls.values():
            call()
        for _ in range(TURNS):
            for call, what in calls.items():
                start = perf_counter()
                what()
                spent[call].append(perf_counter() - start)
        base = np.median(spent["NumPy"])
        for call, times in spent.items():
            each = float(np.median(times))
            digits = f"{off[call]:.0e}" if call in off else ""
            rows.append([f"{name}, {call}", f"{told.frames / each / 1e3:.0f}", f"{base / each:.1f}", digits])
    show(f"16 x 16, batches of {told.frames}", ["", "k frames/s", "times NumPy's", "off"], rows, told.json)


if __name__ == "__main__":
    main()
