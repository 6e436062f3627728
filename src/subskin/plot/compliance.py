"""A particle on a flat read through skins of different softness: the memo's Fig. 17, from solved contacts."""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np
import numpy.typing as npt
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.gridspec import GridSpec
from matplotlib.patches import Patch

from .._check import FloatArray
from ..array import SensorArray
from ..design import skin_compliance
from ..design.compliance import Regime, SkinCompliance
from ..errors import GeometryError
from ..finger import Finger
from ..material import Material
from ..pressing import ParticleOnFlat, press
from ..skin import Round
from .style import DASHED, DOUBLE, MM, Ink, finished, new_figure, plain

__all__ = ["compliance_figure", "figure_17"]

_LOOKS = {
    Regime.TOLD: ("#D9F0E6", "width estimated"),
    Regime.TIP: ("#F7E3D6", "too stiff"),
    Regime.MIXED: ("#EFE6F2", "width hidden"),
    Regime.BLURRED: ("#D6E8F5", "too soft"),
    Regime.STRAINED: ("#EEEEEE", "strained too far"),
    Regime.SATURATED: ("#EEEEEE", "saturated"),
}
_NODES = 1024


@finished
def compliance_figure(found: SkinCompliance, thickness: int = 0, force: int = 0) -> Figure:
    """Three skins against the particle, and width, shares and regime against the modulus.

    Parameters
    ----------
    found : SkinCompliance
        From `subskin.design.skin_compliance`, with three moduli or more.
    thickness, force : int, optional
        Which of its thicknesses and forces.

    Raises
    ------
    GeometryError
        Fewer than three moduli.

    Examples
    --------
    >>> import subskin as ss
    >>> skin = ss.Round(ss.Material(young=0.4e6), radius=8e-3, core_radius=4e-3)
    >>> finger = ss.Finger(skin, ss.SensorArray.line(count=8, pitch=0.5e-3, depth=0.8e-3, noise=2e-5))
    >>> particle = ss.pressing.ParticleOnFlat(half_width=0.4e-3, protrusion=30e-6)
    >>> found = ss.design.skin_compliance(finger, particle, force=40.0, young=[0.05e6, 0.2e6, 2e6])
    >>> [axes.get_title(loc="left") for axes in compliance_figure(found).axes[:3]]
    ['a  E = 2 MPa', 'b  E = 0.2 MPa', 'c  E = 0.05 MPa']
    """
    if found.young.size < 3:
        raise GeometryError(
            f"{found.young.size} moduli", "three or more are needed to draw a change", "young=np.geomspace(1e5, 1e6, 6)"
        )
    figure = new_figure(DOUBLE, 140.0)
    grid = figure.add_gridspec(3, 3, height_ratios=[1.0, 0.8, 1.9])
    sketches = _row(figure, grid, 0)
    pressures = _row(figure, grid, 1, beneath=sketches[0])
    chosen = _three(found, thickness, force)
    for i, (axes, beneath, m) in enumerate(zip(sketches, pressures, chosen, strict=True)):
        _sketch(axes, beneath, found, thickness, m, force)
        axes.set_title(f"{'abc'[i]}  E = {found.young[m] / 1e6:.2g} MPa")
        if not i:
            axes.set_ylabel("height [µm]")
            beneath.set_ylabel("pressure [kPa]")
    _curves(figure.add_subplot(grid[2, :]), found, thickness, force, chosen)
    return figure


def _row(figure: Figure, grid: GridSpec, row: int, beneath: Axes | None = None) -> list[Axes]:
    """Three panels of one scale."""
    first = figure.add_subplot(grid[row, 0], sharex=beneath)
    others = [figure.add_subplot(grid[row, i], sharex=first, sharey=first) for i in (1, 2)]
    for axes in others:
        axes.tick_params(labelleft=False)
    return [first, *others]


def _three(found: SkinCompliance, t: int, f: int) -> tuple[int, int, int]:
    """A stiff skin, the one that tells most, and a soft one."""
    spread = np.where(np.isfinite(found.width_std[t, :, f]), found.width_std[t, :, f], np.inf)
    best = int(np.clip(np.argmin(spread), 1, found.young.size - 2))
    known = np.flatnonzero(np.isfinite(found.half_width[t, :, f]))
    return int((best + known.max() + 1) // 2), best, int(known.min() + (best - known.min()) // 4)


def _sketch(axes: Axes, beneath: Axes, found: SkinCompliance, t: int, m: int, f: int) -> None:
    """The skin on the flat and its particle, upside down as on a table; and the pressure below it."""
    particle, skin = found.particle, found.finger.skin
    if np.isfinite(skin.thickness):
        skin = skin.with_(thickness=float(found.thickness[t]))
    scale = float(found.young[m] / found.own_young)
    reach = 1.15 * float(np.nanmax(found.half_width[t, :, f]))
    force = float(found.force[f]) / scale
    pressed = press(skin, particle, force=force, window=2 * reach, nodes=_NODES, max_strain=None)
    y, um = pressed.y * MM, 1e6
    height = particle.height(pressed.y)
    ended = ~np.isfinite(height)  # beyond the flat there is nothing
    body = np.where(ended, np.nan, particle.protrusion - height) * um
    top = body + np.where(ended, 0.0, pressed.gap) * um
    floor, ceiling = -0.6 * particle.protrusion * um, 3.5 * particle.protrusion * um
    axes.fill_between(y, np.minimum(top, ceiling), ceiling, color=Ink.SKY, alpha=0.5, linewidth=0)
    axes.plot(y, top, color=Ink.BLUE)
    axes.fill_between(y, body, floor, color=Ink.GREY, alpha=0.6, linewidth=0)
    axes.set(xlim=(-reach * MM, reach * MM), ylim=(floor, ceiling))
    axes.tick_params(labelbottom=False)
    pressure = pressed.pressure * scale / 1e3
    beneath.fill_between(y, pressure, color=Ink.VERMILLION, alpha=0.25, linewidth=0)
    beneath.plot(y, pressure, color=Ink.VERMILLION)
    beneath.set(ylim=(0, None), xlabel="position along the skin [mm]")


def _curves(axes: Axes, found: SkinCompliance, t: int, f: int, chosen: tuple[int, ...]) -> None:
    """Shares against the modulus, over bands of what can be estimated; the half width on an axis of its own."""
    moduli = found.young / 1e6
    ends = _between(moduli)
    regimes = found.regime[t, :, f]
    bands: list[Artist] = []
    for r in dict.fromkeys(int(v) for v in regimes):
        colour, name = _LOOKS[Regime(r)]
        for first, last in _runs(regimes == r):
            axes.axvspan(ends[first], ends[last + 1], color=colour, linewidth=0, zorder=0)
        bands.append(Patch(color=colour, label=name))
    axes.set(xscale="log", xlim=(ends[0], ends[-1]))
    lines = axes.plot(moduli, 100 * found.load_share[t, :, f], color=Ink.VERMILLION, label="force on the particle")
    lines += axes.plot(
        moduli, 100 * found.reading_share[t, :, f], color=Ink.GREEN, label="change of the readings by it"
    )
    axes.set(ylim=(0, 112), yticks=[0, 25, 50, 75, 100], xlabel="modulus of the skin [MPa]", ylabel="share [%]")
    wide = axes.twinx()
    wide.spines["right"].set_visible(True)
    ratio = found.half_width[t, :, f] / found.particle.half_width
    lines += wide.plot(moduli, ratio, color=Ink.BLUE, linestyle=DASHED, label="half width of the contact (right)")
    wide.set(yscale="log", ylabel="half width / particle's")
    plain(wide.yaxis)
    plain(axes.xaxis)
    wide.axhline(1.0, color=Ink.BLUE, linewidth=0.5)
    for letter, m in zip("abc", chosen, strict=True):
        above: dict[str, Any] = {
            "transform": axes.get_xaxis_transform(),
            "ha": "center",
            "va": "bottom",
        }  # where no curve goes
        axes.text(moduli[m], 1.01, letter, fontweight="bold", color=Ink.BLACK, **above)
    # beneath the axes: bands can be narrower than their names, and curves go anywhere
    beneath: dict[str, Any] = {"loc": "upper center", "ncols": 3, "frameon": False}
    axes.add_artist(axes.legend(handles=lines, bbox_to_anchor=(0.5, -0.22), **beneath))
    axes.legend(handles=bands, bbox_to_anchor=(0.5, -0.32), **beneath | {"ncols": len(bands)})


def _between(values: FloatArray) -> FloatArray:
    """Geometric means of neighbours, and the ends."""
    middle = np.sqrt(values[1:] * values[:-1])
    return np.concatenate([[values[0] ** 2 / middle[0]], middle, [values[-1] ** 2 / middle[-1]]])


def _runs(member: npt.NDArray[np.bool_]) -> list[tuple[int, int]]:
    at = np.flatnonzero(member)
    parts = np.split(at, np.flatnonzero(np.diff(at) > 1) + 1)
    return [(int(p[0]), int(p[-1])) for p in parts if p.size]


@cache
def _study() -> SkinCompliance:
    """A round finger of 8 mm with 4 mm of rubber on its core, 40 N/m, a particle 0.8 mm wide and 30 um high."""
    skin = Round(Material(0.4e6), radius=8e-3, core_radius=4e-3)
    finger = Finger(skin, SensorArray.line(8, pitch=0.5e-3, depth=0.8e-3, noise=2e-5))
    return skin_compliance(
        finger, ParticleOnFlat(half_width=0.4e-3, protrusion=30e-6), 40.0, young=np.geomspace(0.03e6, 4e6, 22)
    )


def figure_17() -> Figure:
    """Three skins of different softness pressed on a flat with a particle by the same force."""
    return compliance_figure(_study())
