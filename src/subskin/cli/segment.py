"""`subskin segment`: a raw recording -> its presses."""

from __future__ import annotations

import argparse
from dataclasses import replace
from typing import TYPE_CHECKING, Any, TextIO

from .. import io
from .._lazy import np
from ..io.units import quantity
from .common import AREA_COLUMNS, give, number, said_of, show, warn_of_spread
from .options import command, option, shared

if TYPE_CHECKING:
    from ..stream import Presses, RelaxationFit

_WIDE = 6
"""Sensors that a screen has room for."""
_EXAMPLES = """\
  subskin segment finger.toml raw.csv -o presses.csv
  subskin segment finger.toml raw.csv -o presses.parquet --early 0.2 --before "0.1 s"
  subskin segment finger.toml raw.csv -o presses.csv --relaxation relaxed.toml
"""
_NOTES = """\
The table [recording] of the finger file says how to read the recording. A press is a plateau of the indenter's
approach. Its reading is the mean over the first part of the plateau (rubber relaxes) less the mean just before the
indenter leaves its rest. Where no approach is recorded, presses are found from the readings. On an area [recording]
has two columns of the position, y and z, and the presses have position_y and position_z. Where the file has
[relaxation], it is undone first. --relaxation fits it to the plateaus, writes the file with it, and undoes it.
"""


@command(
    _EXAMPLES,
    option("finger", "finger.toml with a table [recording]"),
    option("recording", "the recording, CSV or Parquet; - for standard input"),
    option("--early SHARE", "averaged share of a plateau (0.4)", type=float),
    option("--before TIME", 'time averaged before a press ("0.3 s")'),
    option("--hold TIME", 'least duration of a plateau ("0.5 s")'),
    option("--relaxation FILE", "fit what each sensor forgets of held presses; the finger with it", dest="relaxed"),
    shared("table of presses"),
    notes=_NOTES,
)
def run_segment(options: argparse.Namespace) -> int:
    """Run the command."""
    file, table = io.load(options.finger), io.read_table(options.recording)
    changed = {"early": options.early} | {
        name: None if (text := getattr(options, name)) is None else quantity(text, "s", f"--{name}")
        for name in ("before", "hold")
    }
    fitted = None
    with said_of(table.name):
        if options.relaxed is not None:
            fitted = io.fit_held(file, table)
            own = replace(fitted.own, doubt=0.0) if file.finger.array.on_area else fitted.own
            file = io.with_relaxation(file, own)
        presses = file.segment(table, **{name: value for name, value in changed.items() if value is not None})
    if presses.depth is not None and presses.force is None:
        warn_of_spread(table.name, presses.depth, 'force = { column = "load_cell", unit = "N" } under [recording]')
    columns = _columns(presses, file.names)
    if options.out is not None:
        io.write_table(options.out, columns)

    def people(out: TextIO) -> None:
        skipped = f" ({presses.skipped} left out: no free skin before them)" if presses.skipped else ""
        print(f"{len(presses)} presses in {len(table)} frames{skipped}", file=out)
        if fitted is not None:
            _show_relaxation(out, fitted, file.names)
        if options.out is None:
            _show(out, presses, file.names)

    return give(
        options,
        lambda: {"presses": len(presses), "skipped": presses.skipped, "columns": columns},
        people,
        {options.relaxed: lambda path: io.save_finger(file, path)},
    )


def _show_relaxation(out: TextIO, fitted: RelaxationFit, names: tuple[str, ...]) -> None:
    """What each sensor loses of a press that is held, and how surely."""
    lost = 100 * fitted.own.of_sensors(len(names))[0].sum(axis=0)
    least, most = names[int(lost.argmin())], names[int(lost.argmax())]
    times = " and ".join(f"{number(v, 3)} s" for v in np.atleast_1d(fitted.own.time).tolist())
    print(f"held long, {least} loses {lost.min():.1f} %, {most} {lost.max():.1f} %, with {times}", file=out)
    print(f"what is undone is in doubt by {100 * float(np.asarray(fitted.own.doubt)):.0f} %", file=out)


def _columns(presses: Presses, names: tuple[str, ...]) -> dict[str, Any]:
    columns: dict[str, Any] = {"press": np.arange(len(presses)), "t_start": presses.start, "t_end": presses.stop}
    if presses.position is not None:
        both = presses.position.ndim == 2
        columns |= dict(zip(AREA_COLUMNS, presses.position.T, strict=True)) if both else {"position": presses.position}
    if presses.depth is not None:
        columns["depth"] = presses.depth
    if presses.force is not None:
        columns["force"] = presses.force
    columns |= {name: presses.reading[:, i] for i, name in enumerate(names)}
    return columns | {f"{name}_std": presses.std[:, i] for i, name in enumerate(names)}


def _show(out: TextIO, presses: Presses, names: tuple[str, ...]) -> None:
    at = np.full((len(presses), 1), np.nan) if presses.position is None else presses.position.reshape(len(presses), -1)
    heads = ["position [mm]"] if at.shape[1] == 1 else ["y [mm]", "z [mm]"]
    rows = [
        [str(i), number(presses.start[i], 6), *map(number, 1e3 * at[i]), *map(number, presses.reading[i, :_WIDE])]
        for i in range(min(len(presses), 20))
    ]
    show(out, "", ["press", "start [s]", *heads, *names[:_WIDE]], rows)
    more = [
        f"{count} {what}"
        for count, what in ((len(presses) - 20, "presses"), (len(names) - _WIDE, "sensors"))
        if count > 0
    ]
    if more:
        print(f"... and {' and '.join(more)} more; -o writes them all", file=out)
