"""`subskin calibrate`: --choose compares kinds of sensors and skins, --response table makes a finger with no model."""

from __future__ import annotations

import argparse
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, TextIO

from .. import io
from .._lazy import np
from ..errors import FileError, InvalidValueError
from ..io.changed import remodelled
from ..io.files import apart
from ..io.kept_arrays import response_path
from ..measured import MeasuredResponse
from ..transducer import kind_of
from .common import forces_said, give, number, progress_bar, show
from .options import inputs_of, option

if TYPE_CHECKING:
    import numpy.typing as npt

    from ..calibration import Choice, Score
    from ..io import FingerFile

__all__ = ["CHOOSE", "RESPONSE", "choice_as_json", "chosen", "run_table", "save_apart", "show_choice"]

_KINDS = ("normal_strain", "normal_stress", "mean_pressure")
_OF_STRAIN = "normal_strain"
CHOOSE = option(
    "--choose", "compare kinds of sensors and skins by the positions that they find, and take the best (minutes)"
)


def chosen(
    file: FingerFile, fit: tuple[str, ...], readings: Any, positions: Any, **loads: Any
) -> tuple[FingerFile, tuple[str, ...], Choice]:
    """The file of the best candidate, what was fitted of it, and how it was chosen.

    Raises
    ------
    InvalidValueError
        Gains that are not fitted: from kind to kind they differ in unit.
    """
    from ..calibration import choose

    if "gain" not in fit:
        raise InvalidValueError(
            "--choose without gain in --fit", "each kind of sensor has gains of its own", "add gain to --fit"
        )
    files = _candidates(file, fit)
    options: dict[str, Any] = {"search": file.search, **file.options}
    with progress_bar("candidates", len(files)) as advance:
        found = choose(
            {name: (of.finger, names) for name, (of, names) in files.items()},
            readings,
            positions,
            advance=advance,
            **loads,
            **options,
        )
    return (*files[found.best.name], found)


def _candidates(file: FingerFile, fit: tuple[str, ...]) -> dict[str, tuple[FingerFile, tuple[str, ...]]]:
    """By name: the file as it is and, of one material and one of the kinds, each kind in each skin."""
    skin, kinds = file.finger.skin, {kind_of(kind) for kind in file.finger.array.transducers}
    out = {}
    endless = "half_space" if file.finger.array.on_area else "half_plane"
    skins = (endless, "layers") if skin.single_material is not None and not skin.curvature else ("",)
    for name in skins:
        for kind in _KINDS if len(kinds) == 1 and kinds <= set(_KINDS) else ("",):
            # a skin of that kind is kept as it is drawn
            same = not name or skin.endless == (name == endless)
            of = remodelled(file, skin="" if same else name, kind=kind)
            layer = bool(name) and bool(np.isfinite(of.finger.skin.thickness))
            base = tuple(n for n in fit if n != "thickness" or not name) + ("thickness",) * layer
            where = {"half_plane": "a half plane", "half_space": "a half space", "layers": "a layer"}.get(
                name, "the skin as drawn"
            )
            title = f"{kind or 'sensors as drawn'} of {where}"
            out[title.replace("_", " ")] = (of, base)
            if kind == _OF_STRAIN and "poisson" not in base:
                out[f"{title}, Poisson's ratio fitted".replace("_", " ")] = (of, (*base, "poisson"))
    return out


def show_choice(out: TextIO, choice: Choice) -> None:
    """The table of the candidates, and the reason."""
    rows = [
        [
            t.name,
            "-" if t.reason else number(100 * t.ok, 3),
            *(number(1e3 * value, 3) for value in (t.median, t.rms, t.worst)),
            number(100 * t.held, 3),
            "-" if t.calibration is None else f"{t.calibration.r2:.5f}",
        ]
        for t in choice.trials
    ]
    heads = ["candidate", "OK [%]", "median [mm]", "rms [mm]", "worst [mm]", "in 95 % [%]", "R^2"]
    show(out, "positions of touches held out, by block of neighbours", heads, rows)
    for t in choice.trials:
        if t.reason:
            print(f"{t.name} is out: {t.reason}", file=out)
    print(choice.reason, file=out)


def choice_as_json(choice: Choice) -> dict[str, Any]:
    """For --json."""
    trials = [
        {name: getattr(t, name) for name in ("name", "ok", "median", "worst", "rms", "held", "score", "reason")}
        | {"r2": None if t.calibration is None else t.calibration.r2}
        for t in choice.trials
    ]
    return {"reason": choice.reason, "candidates": trials}


_UNUSED = {"fit": None, "choose": False, "accept_misfit": False}
_NO_DRAG = "touches that press straight down teach nothing of drags"


RESPONSE = option(
    "--response {field,table}",
    "on an area: table makes the response of the touches alone, without a model of the skin (field)",
    "field",
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
