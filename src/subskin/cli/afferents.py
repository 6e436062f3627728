"""`subskin afferents`: which strain explains the rates of a touch receptor."""

from __future__ import annotations

import argparse
from typing import TextIO

import numpy as np

from .. import io
from .._check import FloatArray
from ..afferents import Stimulus
from ..errors import FileError, SubskinError
from ..io.units import quantity
from .common import give, number, show
from .options import JSON, command, figure, option

_EXAMPLES = """\
  subskin afferents stimulus.csv --unit mm
  subskin afferents stimulus.csv --unit mm --depth "0.7 mm" -o fitted.csv --figure fitted.png
"""
_NOTES = """\
A row is a presentation. `shape` is bar, edge or grating (a grating where there is a gap or a period, else a bar).
`width` is that of a bar; a grating has a `gap` too, or a `period`, of which half is bar if there is no width.
`indentation` is how deep it is pressed (1 mm). `position` is the receptor's on the axis of the stimulus, 0 in the
middle of a bar, or at the edge; without it the stimulus moved over the receptor, and the rate is its mean. `rate` is in
impulses a second. Slope, rest and depth are fitted; rates are max(0, slope * strain + rest).
"""


@command(
    _EXAMPLES,
    option("stimulus", "stimulus.csv"),
    option("--unit UNIT", "of the lengths in the table (m)", "m"),
    option("--depth DEPTH", "of the receptor; else 0.3 to 1.2 mm is sought"),
    option("--thickness LENGTH", "of the skin on its bone", "10 mm"),
    option("--poisson NU", "Poisson's ratio of the skin (0.5)", 0.5),
    option("-o --out FILE", "rates as fitted by each strain; CSV, or Parquet for .parquet"),
    figure("draw rates against the fitted ones"),
    JSON,
    notes=_NOTES,
)
def run_afferents(options: argparse.Namespace) -> int:
    """Run the command."""
    from .. import afferents

    table = io.read_table(options.stimulus)
    scale = quantity(f"1 {options.unit}", "m", "--unit")
    stimuli, positions = _stimuli(table, scale)
    skin = afferents.finger_skin(quantity(options.thickness, "m", "--thickness"), options.poisson)
    depth = None if options.depth is None else quantity(options.depth, "m", "--depth")
    rates = table.numbers("rate", finite=True, why="impulses a second")
    fits = afferents.fit_rates(stimuli, rates, positions, depth=depth, skin=skin)

    def people(out: TextIO) -> None:
        rows = [
            [
                afferents.MEASURES[fit.measure].said,
                f"{fit.r2:.3f}",
                number(1e3 * fit.depth, 3),
                number(fit.slope),
                number(fit.rest, 3),
            ]
            for fit in fits
        ]
        heads = ["strain", "R2", "depth [mm]", "slope [1/s per unit]", "rest [1/s]"]
        show(out, f"{len(rates)} rates, best first", heads, rows)

    def data() -> dict[str, object]:
        keys = ("measure", "r2", "depth", "slope", "rest")
        return {"rows": len(rates), "fits": [{key: getattr(fit, key) for key in keys} for fit in fits]}

    fitted = {"rate": rates} | {fit.measure: fit.rates for fit in fits}
    files = {options.out: lambda path: io.write_table(path, fitted)}
    return give(options, data, people, files, lambda plot: plot.afferent_figure(fits, rates))


def _stimuli(table: io.Table, scale: float) -> tuple[list[Stimulus], FloatArray]:
    """What was pressed in, and where the receptor was, row by row."""

    def lengths(name: str, otherwise: float) -> FloatArray:
        if name not in table.columns:
            return np.full(len(table), otherwise)
        values = scale * table.numbers(name)
        return np.where(np.isnan(values), otherwise, values)

    width, gap, period = (lengths(name, 0.0) for name in ("width", "gap", "period"))
    width = np.where((width == 0) & (period > 0), 0.5 * period, width)
    gap = np.where((gap == 0) & (period > 0), period - width, gap)
    deep, at = lengths("indentation", 1e-3), lengths("position", np.nan)
    shapes = table.texts("shape") if "shape" in table.columns else ["grating" if g > 0 else "bar" for g in gap]
    stimuli: list[Stimulus] = []
    for i, shape in enumerate(shapes):
        try:
            stimuli.append(Stimulus(shape.strip().lower(), width[i], gap[i], deep[i]))  # type: ignore[arg-type]
        except SubskinError as error:
            raise FileError(f"{table.position(i)}: {error.seen}", error.rule, error.fix) from None
    return stimuli, at
