"""`subskin calibrate --choose`: kinds of sensors and skins, compared by the positions that they find."""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING, Any, TextIO

import numpy as np

from ..errors import InvalidValueError
from ..io.changed import remodelled
from ..transducer import kind_of
from .common import number, progress_bar, show

if TYPE_CHECKING:
    from ..calibration import Choice
    from ..io import FingerFile

__all__ = ["add_choose", "choice_as_json", "chosen", "show_choice"]

_KINDS = ("normal_strain", "normal_stress", "mean_pressure")
_OF_STRAIN = "normal_strain"


def add_choose(parser: argparse.ArgumentParser) -> None:
    """--choose."""
    parser.add_argument(
        "--choose",
        action="store_true",
        help="compare kinds of sensors and skins by the positions that they find, and take the best (minutes)",
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
