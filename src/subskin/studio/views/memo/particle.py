"""A particle on a flat, pressed by skins of three softnesses (Fig. 17): contacts as `subskin.pressing` solves them."""

from __future__ import annotations

from functools import lru_cache
from typing import Any

import numpy as np

from ...._check import FloatArray
from ....material import Material
from ....pressing import ContactSolution, ParticleOnFlat, press
from ....skin import Round
from .figure import Figure, Number, curve, mark, panel

__all__ = ["FIGURES"]

_SKIN = Round(Material(young=0.4e6), radius=8e-3, core_radius=4e-3)
"""The finger of `subskin figures`: 4 mm of rubber on a core."""
_APART = 4.0
"""The stiffer skin's modulus over the middle one's, and that over the softer one's."""
_LADDER = np.geomspace(4e-6, 2e-3, 25)
"""Forces over moduli of the curves [m]."""
_WINDOW, _NODES = 12e-3, 1024
_REACH = 1.6
"""What is seen on each side of the particle, in mm."""


@lru_cache(maxsize=256)
def _pressed(wide: float, tall: float, softness: float) -> ContactSolution:
    """The skin pressed on the particle, `softness` its force over its modulus [m]: on these alone strains depend."""
    body = ParticleOnFlat(half_width=1e-3 * wide, protrusion=1e-6 * tall)
    young = _SKIN.materials[0].young
    # no question of strains: the softest strain more than Hooke's law allows
    return press(_SKIN, body, force=softness * young, window=_WINDOW, nodes=_NODES, max_strain=None)


def _share(found: ContactSolution, wide: float) -> float:
    """Share of the force that the particle takes."""
    on_top = np.abs(found.y) <= 1e-3 * wide
    return float(found.pressure[on_top].sum() / found.pressure.sum())


def _particle(young: float, force: float, wide: float, tall: float) -> dict[str, Any]:
    body = ParticleOnFlat(half_width=1e-3 * wide, protrusion=1e-6 * tall)
    moduli = [_APART * young, young, young / _APART]
    skins = [_pressed(wide, tall, float(f"{1e-6 * force / modulus:.9g}")) for modulus in moduli]
    at = np.linspace(-_REACH, _REACH, 401)
    surfaces, pressures, told = [], [], []
    for kind, modulus, found in zip("123", moduli, skins):
        name, share = f"{modulus:.3g} MPa", _share(found, wide)
        height = 1e6 * (body.protrusion - body.height(found.y) + found.gap)
        surfaces.append(curve(f"skin of {name}", kind, at, _at(at, found, height)))
        scale = 1e6 * modulus / _SKIN.materials[0].young
        pressures.append(curve(name, kind, at, _at(at, found, scale * found.pressure / 1e3)))
        told.append(
            f"{name}: the contact is {2e3 * found.half_width:.2f} mm wide, the particle {2 * wide:.2f} mm; "
            f"it takes {100 * share:.0f} % of the force. {_word(1e3 * found.half_width, wide, share)}"
        )
    ground = 1e6 * (body.protrusion - body.height(1e-3 * at))
    ladder = [_pressed(wide, tall, float(f"{softness:.9g}")) for softness in _LADDER]
    along = np.log10(1e-6 * force / _LADDER)
    share_of = [100 * _share(found, wide) for found in ladder]
    width_of = [100 * min(1e3 * found.half_width / wide, 1.0) for found in ladder]
    seen = (along >= np.log10(young) - 1.0) & (along <= np.log10(young) + 1.0)
    curves = [
        curve("share of the force on the particle", "2", along[seen], np.array(share_of)[seen]),
        curve("share of the particle’s width that is touched", "1", along[seen], np.array(width_of)[seen]),
    ]
    return {
        "panels": [
            panel(
                "Three skins on a flat with a particle",
                "position along the skin, y [mm]",
                "height [µm]",
                [curve("flat and particle", "body", at, ground), *surfaces],
                low=-0.6 * tall,
                high=3.5 * tall,
            ),
            panel("Pressure", "position along the skin, y [mm]", "p [kPa]", pressures, low=0.0),
            panel(
                "What is estimated of the particle",
                "log₁₀ of the modulus in MPa",
                "share [%]",
                curves,
                marks=[mark(f"{young:.3g} MPa", "right", float(np.log10(young)), 100 * _share(skins[1], wide))],
                low=0.0,
                high=108.0,
            ),
        ],
        "told": told,
    }


def _at(y: FloatArray, found: ContactSolution, values: FloatArray) -> FloatArray:
    return np.interp(1e-3 * y, found.y, values)


def _word(half: float, wide: float, share: float) -> str:
    """What the memo says of such a contact."""
    if half < 0.95 * wide:
        return "The skin is too stiff: no more than the particle’s top is touched, and its width is hidden."
    return "Most is taken by the flat around it." if share < 0.5 else "It is touched all over."


FIGURES = (
    Figure(
        "17",
        "Fig. 17: skins of three softnesses",
        "All press a flat with a particle by the same force. A stiff skin hides its width, a soft one its force.",
        (
            Number("young", "modulus of the middle skin", 0.4, 0.1, 2.0, 0.05, "MPa"),
            Number("force", "force", 40.0, 10.0, 60.0, 1.0, "N/m"),
            Number("wide", "half width of the particle", 0.4, 0.2, 0.8, 0.05, "mm"),
            Number("tall", "height of the particle", 30.0, 10.0, 80.0, 5.0, "µm"),
        ),
        (),
        _particle,
    ),
)
