"""`subskin orient`: whether cable, board, axes, sign and gains are as the file says, by presses at told positions."""

from __future__ import annotations

import argparse
from dataclasses import asdict
from datetime import date
from typing import TYPE_CHECKING, TextIO

from .. import calibration, io
from .._lazy import np
from ..errors import FileError
from ..io.units import quantity
from .common import give, said_of
from .options import JSON, command, option

if TYPE_CHECKING:
    from .._check import FloatArray
    from ..calibration import Orientation
    from ..io import FingerFile, Table

_EXAMPLES = """\
  subskin orient finger.toml                       where to press
  subskin orient finger.toml presses.csv
  subskin orient finger.toml presses.csv --write   keep the result in finger.toml
"""
_NOTES = """\
Symmetry hides a cable in reversed order, a mirrored board, swapped axes and a wrong sign from every status: answers are
OK and far off. Two or three presses whose position is known tell. Each row of the table is one press: the readings, and
in a column `near` the name of the sensor that was pressed on, or the position in `position`, on an area in `position_y`
and `position_z` [m]. A column `force` [N/m, on an area N], where it is known, tells the scale of the gains.

exit codes: 0 as the file says; 1 not as the file says, or not sure; 2 bad input
"""
_FAR = 1.3
"""Factor from which the forces are another scale."""


@command(
    _EXAMPLES,
    option("finger", "finger.toml"),
    option("presses?", "table of presses; without it the command says where to press"),
    option("--reach LENGTH", "how far a press may be from what was told (half the depth)"),
    option("--write", "keep the result, with its date, in finger.toml"),
    JSON,
    notes=_NOTES,
)
def run_orient(options: argparse.Namespace) -> int:
    """Run the command."""
    file = io.load(options.finger)
    if options.presses is None:
        sites = calibration.telling(file.finger, min(3, len(file.names)))
        names = [file.names[i] for i in sites]
        return give(
            options, lambda: {"press": names}, lambda out: print(f"press near {', then near '.join(names)}", file=out)
        )
    table = io.read_table(options.presses)
    reach = None if options.reach is None else quantity(options.reach, "m", "--reach")
    with said_of(options.presses):
        near, force = _near(file, table), table.numbers("force") if "force" in table.columns else None
        found = calibration.orient(file.finger, table.readings(file.names), near, force=force, reach=reach)
    other = bool(np.isfinite(found.scale)) and not 1 / _FAR < found.scale < _FAR
    confirmed = found.as_drawn and not other
    if options.write and confirmed:
        io.save_finger(io.with_orientation(file, date.today().isoformat(), len(near)), options.finger)

    def people(out: TextIO) -> None:
        print(found, file=out)
        for line in _to_do(file, found, other):
            print(f"-> {line}", file=out)
        if options.write:
            print(f"-> {options.finger} {'says so now' if confirmed else 'was left as it was'}", file=out)

    return give(options, lambda: asdict(found) | {"confirmed": confirmed}, people) or int(not confirmed)


def _near(file: FingerFile, table: Table) -> FloatArray:
    """Where was pressed, on the finger's own axes."""
    array = file.finger.array
    if "near" not in table.columns:
        axes = ("position_y", "position_z") if array.on_area else ("position",)
        columns = [table.numbers(axis, finite=True, why="the position of a press") for axis in axes]
        return file.on_finger(np.stack(columns, axis=-1) if array.on_area else columns[0])
    names = table.texts("near")
    for row, name in enumerate(names):
        if name not in file.names:
            known = ", ".join(file.names)
            raise FileError(
                f'{table.position(row)}: near = "{name}"', f"sensors are {known}", f"near = {file.names[0]}"
            )
    points = array.points[[file.names.index(name) for name in names]]
    return points if array.on_area else points[:, 0]


def _to_do(file: FingerFile, found: Orientation, other: bool) -> list[str]:
    """What a person has to change or to press, in words."""
    if found.press is not None:
        near = file.names[found.press]
        if not found.probability:
            return [f"press again, near {near} too, one touch a row; subskin check says whether the skin is right"]
        return [f"press near {near} as well, and add a row"]
    said = []
    if not (found.order == np.arange(len(file.names))).all():
        names = ", ".join(f'"{file.names[i]}"' for i in found.order)
        said.append(f"the columns of the sensors, in their order, are [{names}]: under [recording] sensors = [...]")
    if found.sign < 0:
        said.append("all readings have the wrong sign: multiply gain under [sensors] by -1")
    if other:
        factor = f"{found.scale:.3g}"
        said.append(f"forces are {factor} times what was told: multiply gain under [sensors] by {factor}")
    return said or ["the sensors are as the file says"]
