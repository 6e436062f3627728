"""`subskin compliance`: which modulus and thickness let a finger find a particle on a flat."""

from __future__ import annotations

import argparse
import math
from typing import TYPE_CHECKING, Any, TextIO

from .. import design, io
from .._lazy import np
from ..errors import InvalidValueError
from ..io.units import quantity
from .common import give, number, progress_bar, show
from .options import JSON, command, figure, option, positive

if TYPE_CHECKING:
    from .._check import FloatArray

_EXAMPLES = """\
  subskin compliance finger.toml --width "0.8 mm" --height "30 um" --force "10..100 N/m"
  subskin compliance finger.toml --width "0.8 mm" --height "30 um" --force "40 N/m" --young "0.05..2 MPa" \\
      --thickness "2 mm, 4 mm" --figure compliance.png
"""
_NOTES = """\
The finger is pressed on a flat with a particle at its middle, and on the flat alone, through skins of many moduli. The
particle is found where it changes the readings by five times their error, and where they give its width although its
height, its position and the force are unknown. Errors are the sensors' noise and a share of the largest reading.
"""


@command(
    _EXAMPLES,
    option("finger", "finger.toml"),
    option("--width LENGTH", "width of the particle", required=True),
    option("--height LENGTH", "how far the particle stands out of the flat", required=True),
    option("--force RANGE", 'force per length of contact, "40 N/m" or "10..100 N/m"', required=True),
    option("--flat LENGTH", "width of the flat (default: endless); needed for a flat skin"),
    option("--young RANGE", "moduli to try (0.03..30 MPa)", "0.03..30 MPa"),
    option("--moduli N", "number of moduli (16)", 16),
    option("--thickness LIST", 'thicknesses to try, "2 mm, 4 mm" (the finger\'s own)'),
    option("--accuracy X", "error of a reading beside its noise, as a share of the largest reading (0.01)", 0.01),
    option("--wanted X", "wanted standard deviation of the width, as a share of the width (0.5)", 0.5),
    figure("draw it, as the memo's Fig. 17"),
    JSON,
    notes=_NOTES,
)
def run_compliance(options: argparse.Namespace) -> int:
    """Run the command."""
    from ..pressing import ParticleOnFlat

    file = io.load(options.finger)
    finger = file.finger
    if options.flat is None and math.isinf(finger.skin.period):
        seen, rule = f"{options.finger}: a flat skin on a flat without end", "they would touch all along"
        raise InvalidValueError(seen, rule, '--flat "20 mm", the width of the flat, or a round skin')
    if not 1 <= options.moduli <= 1000:
        raise InvalidValueError(f"--moduli {options.moduli}", "has to be from 1 to 1000", "--moduli 16")
    forces = _spread(positive(options.force, "N/m", "--force", length=file.length), 3)
    young = _spread(positive(options.young, "Pa", "--young"), options.moduli)
    if options.figure is not None and young.size < 3:
        raise InvalidValueError(
            f"--figure with {young.size} moduli", "three or more are needed to draw a change", "--moduli 16"
        )
    thickness = None
    if options.thickness is not None:
        thickness = [quantity(part.strip(), "m", "--thickness") for part in options.thickness.split(",")]
    particle = ParticleOnFlat(
        half_width=quantity(options.width, "m", "--width") / 2,
        protrusion=quantity(options.height, "m", "--height"),
        flat_half_width=math.inf if options.flat is None else quantity(options.flat, "m", "--flat") / 2,
    )
    count = forces.size * young.size * (1 if thickness is None else len(thickness))
    with progress_bar("presses", count) as advance:
        how = {"accuracy": options.accuracy, "width_wanted": options.wanted, "progress": advance}
        found = design.skin_compliance(finger, particle, forces, young=young, thickness=thickness, **how)
    return give(
        options,
        lambda: _as_json(found),
        lambda out: _show(out, found),
        figure=lambda plot: plot.compliance_figure(found, found.best[0], forces.size // 2),
    )


def _spread(ends: tuple[float, float], count: int) -> FloatArray:
    """Values from end to end, equal ratios apart, without the last digits of rounding; one where the ends are one."""
    values = np.geomspace(*ends, 1 if ends[0] == ends[1] else count)
    return np.array([float(f"{v:.12g}") for v in values])


def _as_json(found: design.compliance.SkinCompliance) -> dict[str, Any]:
    names = ("thickness", "young", "force", "half_width", "load_share", "reading_share", "seen", "width_std")
    return {
        **{name: getattr(found, name) for name in names},
        "regime": [[[_regime(r).lower() for r in row] for row in plane] for plane in found.regime],
        "best": {"thickness": found.thickness[found.best[0]], "young": found.young[found.best[1]]},
        "reason": found.reason,
    }


def _regime(number: int) -> str:
    return design.compliance.Regime(int(number)).name


def _show(out: TextIO, found: design.compliance.SkinCompliance) -> None:
    forces = [f"at {number(force, 3)} N/m" for force in found.force]
    for t, thickness in enumerate(found.thickness):
        rows = [
            [number(young / 1e6, 3), *(_told(found, t, m, f) for f in range(found.force.size))]
            for m, young in enumerate(found.young)
        ]
        title = f"a skin {number(1e3 * thickness, 3)} mm thick: how well the particle's width is found"
        show(out, title, ["E [MPa]", *forces], rows)
    t, m = found.best
    rows = []
    for f, force in enumerate(found.force):
        at = (t, m, f)
        shares = 100 * found.load_share[at], 100 * found.reading_share[at]
        values = (force, 1e3 * found.half_width[at], *shares, found.seen[at])
        rows.append([*(number(value, 3) for value in values), _told(found, t, m, f)])
    heads = ["force [N/m]", "half width [mm]", "share of force [%]", "of readings [%]"]
    title = f"E = {number(found.young[m] / 1e6, 3)} MPa, {number(1e3 * found.thickness[t], 3)} mm thick"
    show(out, title, [*heads, "change / error", "width"], rows)
    print(f"-> {found.reason}", file=out)


def _told(found: design.compliance.SkinCompliance, t: int, m: int, f: int) -> str:
    """The width's deviation where it is told, or why it is not."""
    words = {
        "TOLD": f"+-{100 * found.width_std[t, m, f]:.0f} %",
        "TIP": "too stiff",
        "MIXED": "width hidden",
        "BLURRED": "too soft",
        "STRAINED": "strained too far",
        "SATURATED": "saturated",
    }
    return words[_regime(found.regime[t, m, f])]
