"""`subskin calibrate --response table`: touches at known positions -> a finger that reads by a table, no model."""

from __future__ import annotations

import argparse
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, TextIO

from .. import io
from .._lazy import np
from ..errors import FileError, InvalidValueError
from ..io.files import apart
from ..io.kept_arrays import response_path
from .common import give, inputs_of, number, show
from .frames import forces_said

if TYPE_CHECKING:
    import numpy.typing as npt

    from ..calibration import Score

__all__ = ["add_response", "run_table", "save_apart"]

_UNUSED = {"fit": None, "choose": False, "accept_misfit": False}
_NO_DRAG = "touches that press straight down teach nothing of drags"


def add_response(parser: argparse.ArgumentParser) -> None:
    """--response."""
    parser.add_argument(
        "--response",
        choices=("field", "table"),
        default="field",
        help="on an area: table makes the response of the touches alone, without a model of the skin (field)",
    )


def run_table(
    options: argparse.Namespace,
    file: io.FingerFile,
    readings: npt.NDArray[np.float64],
    positions: npt.NDArray[np.float64],
    used: npt.NDArray[np.bool_],
    loads: dict[str, Any],
) -> int:
    """Run the command on what was read: readings (m, n), positions (m, 2), which touches are used, their loads."""
    from ..calibration.calibration import score
    from ..measured import MeasuredResponse

    for name, usual in _UNUSED.items():
        if getattr(options, name) != usual:
            rule = "a table has no model that is fitted, compared or refused"
            raise InvalidValueError(f"--{name.replace('_', '-')} with --response table", rule, "leave one of them out")
    if not file.finger.array.on_area:
        rule, fix = "a table is of touches on an area", "z = [...] in [sensors]; or leave --response out"
        raise InvalidValueError(f"{options.finger}: a row with --response table", rule, fix)
    forces = _components(file, loads, len(readings))
    drags = forces.shape[1] == 3
    if not drags and file.options.get("friction", 1.0) > 0:
        raise FileError(f"{options.finger}: [locate] friction is not 0", _NO_DRAG, "friction = 0 under [locate]")
    at, live = file.on_finger(positions), _live(file, readings[used])
    whole = np.isfinite(readings[:, live]).all(axis=1)
    taken, held = used & whole, ~used & whole
    array = file.finger.array
    offset = np.asarray(array.offset)
    filled = np.where(live, readings, offset)  # what is dead reads nothing
    table = MeasuredResponse.from_touches(filled[taken], at[taken], components=forces[taken], offset=offset)
    array = replace(array, gain=np.where(live, array.gain, 0.0))
    finger = replace(file.finger, array=array, spread=None, trusted=True, measured=table, relative="force" not in loads)
    model = (table(at) * forces[:, None, :]).sum(axis=-1) + offset
    known, new = score(filled[taken], model[taken], live), None
    if held.any():
        new = score(filled[held], model[held], live)
    dead = [name for name, on in zip(file.names, live, strict=True) if not on]
    facts: dict[str, Any] = {"source": Path(options.touches).name, "touches": known.touches, "r2": float(known.r2)}
    facts |= {"dead": dead} | ({} if new is None else {"r2_held_out": float(new.r2)})
    left = int((~whole).sum())

    def people(out: TextIO) -> None:
        _show(out, file, table, known, new)
        if left:
            print(f"{left} touches left out: a sensor that works has no reading", file=out)
        if dead:
            print(f"dead: {', '.join(dead)} (left out from now on)", file=out)
        if said := forces_said(file, loads, options.force_column):
            print(said, file=out)

    def as_json() -> dict[str, Any]:
        each = {name: {"r2": known.r2_sensor[i], "noise": table.noise[i]} for i, name in enumerate(file.names)}
        return {
            "touches": known.touches, "left_out": left, "r2": known.r2, "dead": dead, "sensors": each,
            "held_out": None if new is None else new.touches, "r2_held_out": None if new is None else new.r2,
            "nodes": [len(table.y), len(table.z)], "components": table.components,
        }  # fmt: skip

    def write(to: str) -> None:
        save_apart(options, file.with_finger(finger, file.origin, facts, turn=file.turn), to)

    return give(options, as_json, people, {options.out: write})


def save_apart(options: argparse.Namespace, file: io.FingerFile, to: str) -> None:
    """Write a finger, and its response beside it, which must not fall on a file that the command has read.

    Raises
    ------
    FileError
        It would, or one of them cannot be written.
    """
    if file.finger.measured is not None and to != "-":
        inputs = inputs_of(options) | {"the response of the finger": str(response_path(options.finger))}
        apart(inputs, {"the response beside -o,": str(response_path(to))})
    io.save_finger(file, to)


def _components(file: io.FingerFile, loads: dict[str, Any], count: int) -> npt.NDArray[np.float64]:
    """The force of each touch on the finger: N, shape (m, 1), or with drags (N, Ty, Tz), shape (m, 3)."""
    force, angle, azimuth = (np.broadcast_to(loads.get(k, v), count) for k, v in _LOAD.items())
    normal = np.asarray(force * np.cos(angle))
    if not angle.any():
        return normal[:, None]
    own = azimuth - file.turn
    return np.stack([normal, *(force * np.sin(angle) * f(own) for f in (np.cos, np.sin))], axis=-1)


_LOAD = {"force": 1.0, "angle": 0.0, "azimuth": 0.0}


def _live(file: io.FingerFile, readings: npt.NDArray[np.float64]) -> npt.NDArray[np.bool_]:
    """Which sensors are not dead already, and move, shape (n,)."""
    with np.errstate(all="ignore"):
        moves = np.array([np.ptp(c[np.isfinite(c)]) > 0 if np.isfinite(c).any() else False for c in readings.T])
    return np.asarray(file.finger.array.live & moves)


def _show(out: TextIO, file: io.FingerFile, table: Any, known: Score, new: Score | None) -> None:
    rows = [
        [name, number(known.r2_sensor[i], 5), "-" if new is None else number(new.r2_sensor[i], 5), number(noise, 3)]
        for i, (name, noise) in enumerate(zip(file.names, table.noise, strict=True))
    ]
    show(out, "sensors", ["sensor", "R^2", "R^2 held out", "noise"], rows)
    ends = (f"{n} = {1e3 * v[0]:.4g} to {1e3 * v[-1]:.4g} mm" for n, v in (("y", table.y), ("z", table.z)))
    print(f"a table of {len(table.y)} x {len(table.z)} nodes, {', '.join(ends)} on the finger", file=out)
    print(f"R^2 {known.r2:.5f} on the {known.touches} touches used", file=out)
    if new is not None:
        print(f"R^2 {new.r2:.5f} on the {new.touches} held out", file=out)
