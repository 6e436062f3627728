"""The skin as a filter (Figs. 14, 15), ridges (16), a particle (17), two points (18, 19)."""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache
from typing import Any

import numpy as np

from .._check import FloatArray
from ..array import SensorArray
from ..contact import Hertz
from ..design import Ridges, aliasing_error, best_ridge_pitch, metamers
from ..finger import Finger
from ..material import Material
from ..memo import eq24, eq25, eq25_corrected, eq26, eq26_corrected
from ..pressing import ContactSolution, ParticleOnFlat, press
from ..skin import HalfPlane, Round
from .memo_figure import Figure, Number, curve, drawn, mark, panel

__all__ = ["FIGURES"]

_FINGER = Round(Material(young=0.4e6), radius=8e-3, core_radius=4e-3)
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
    young = _FINGER.materials[0].young
    # no question of strains: the softest strain more than Hooke's law allows
    return press(_FINGER, body, force=softness * young, window=_WINDOW, nodes=_NODES, max_strain=None)


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
        scale = 1e6 * modulus / _FINGER.materials[0].young
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
    return drawn(
        told,
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
    )


def _at(y: FloatArray, found: ContactSolution, values: FloatArray) -> FloatArray:
    return np.interp(1e-3 * y, found.y, values)


def _word(half: float, wide: float, share: float) -> str:
    """What the memo says of such a contact."""
    if half < 0.95 * wide:
        return "The skin is too stiff: no more than the particle’s top is touched, and its width is hidden."
    return "Most is taken by the flat around it." if share < 0.5 else "It is touched all over."


_SKIN = HalfPlane(Material(young=1.0, poisson=0.5))
_FULL = -2 * np.pi / 3
"""Gain at which the strain beneath a unit point at unit depth is 1."""


def _row(y: FloatArray, depth: float = 1.0, **more: Any) -> Finger:
    return Finger(_SKIN, SensorArray(y=y, depth=depth, **more))


def _sampled(pitch: float, width: float) -> dict[str, Any]:
    contact = Hertz(1.0, position=-0.9, half_width=width) + Hertz(0.45, position=1.4, half_width=0.3)
    found = aliasing_error(_row(np.zeros(1)), contact, pitch)
    y, strain = found.position, found.reading
    worst = int(np.unravel_index(np.argmax(np.abs(found.error)), found.error.shape)[0])
    seen = np.abs(y) < 4.5
    first = 0.5 * (y[0] + y[-1]) + found.shift[worst]
    sensors = first + pitch * np.arange(-40, 41)
    sensors = sensors[np.abs(sensors) < 4.5]
    curves = [
        curve("strain", "right", y[seen], strain[seen]),
        curve("recovered from the sensors", "2", y[seen], (strain + found.error[worst])[seen]),
    ]
    marks = [mark("", "1", float(at), float(np.interp(at, y, strain))) for at in sensors]
    share = float(np.abs(found.error).max() / np.abs(strain).max())
    return drawn(
        [f"Where the sensors lie worst, the strain between them is off by {100 * share:.2g} % of the largest."],
        panel("What a row of sensors keeps of the strain", "position, y / d", "εx E d / P", curves, marks=marks),
    )


def _filter(depth: float, attenuation: float) -> dict[str, Any]:
    s = np.linspace(-1.5, 1.5, 401)
    y = np.linspace(-4.0, 4.0, 321)
    spectra = [
        curve("eq. (25) corrected", "right", s, eq25_corrected(s=s, d=depth)),
        curve("eq. (25) as printed", "printed", s, eq25(s=s, d=depth)),
    ]
    f = float(eq26_corrected(attenuation))
    density = f / np.pi / depth
    return drawn(
        [
            f"Waves are damped {attenuation:.0f}-fold at f = {f:.3f}: {density * depth:.3f} sensors a depth.",
            f"As printed: f = 10.2 damps {float(eq26(10.2)):.0f}-fold, 3.2 sensors {float(eq26(3.2 * np.pi)):.0f}.",
        ],
        panel(
            "Response to a line load, eq. (24)",
            "position, y",
            "E εx / P",
            [curve("h(y)", "right", y, eq24(d=depth, y=y))],
        ),
        panel("Its spectrum", "waves per length, s", "H(s)", spectra),
    )


@lru_cache(maxsize=1)
def _best_pitch() -> float:
    return float(best_ridge_pitch(_row(np.zeros(1))).pitch[0])


def _ridged(pitch: float, half_width: float) -> dict[str, Any]:
    touch, ridges = Hertz(0.5 * np.pi * half_width, half_width=half_width), Ridges(pitch)
    y = np.linspace(-half_width - 3, half_width + 3, 241)
    pressure = touch.pressure(y)
    smooth, ridged = (_beneath(y, half_width, pitch, share) for share in (np.ones_like, ridges.share))
    curves = [curve("smooth", "1", y, smooth), curve("ridged", "2", y, ridged)]
    loads = [curve("smooth", "1", y, pressure), curve("ridged", "2", y, ridges.share(y) * pressure)]
    gain = float(np.abs(ridged).max() / np.abs(smooth).max())
    return drawn(
        [
            f"The largest strain is {gain:.2f} times that without ridges, at the same peak pressure.",
            f"For waves without end the best pitch is {_best_pitch():.2f} depths, 2π.",
        ],
        panel("Pressure", "position, y / d", "p / p₀", loads, low=0.0),
        panel("Strain at the depth d", "position, y / d", "εx E / p₀", curves),
    )


def _beneath(y: FloatArray, a: float, pitch: float, share: Callable[[FloatArray], FloatArray]) -> FloatArray:
    """Strain at the depth 1, eq. (23) with the response (24), of a cylinder whose pressure is shared out.

    Gauss's rule between the troughs, in the angle whose sine is the position: nothing is left that is not smooth.
    """
    troughs = pitch * (np.arange(-np.ceil(a / pitch) - 1, np.ceil(a / pitch) + 1) + 0.5)
    ends = np.arcsin(np.unique(np.concatenate([[-a, 0.0, a], troughs[np.abs(troughs) < a]])) / a)
    t, w = np.polynomial.legendre.leggauss(24)
    half = 0.5 * np.diff(ends)
    angle = ((0.5 * (ends[1:] + ends[:-1]))[:, None] + half[:, None] * t).reshape(-1)
    position = a * np.sin(angle)
    load = (half[:, None] * w).reshape(-1) * a * np.cos(angle) ** 2 * share(position)
    return np.asarray(eq24(d=1.0, y=y[:, None] - position) @ load)


def _two(apart: float, first: float, second: float, share: float, third: float) -> dict[str, Any]:
    points, forces = np.array([first, second]), np.array([2 * share, 2 * (1 - share)])
    pair = _row(np.array([-0.5, 0.5]) * apart, gain=_FULL, noise=1e-3)
    same = metamers(pair, points, forces, search=(-3.0, 3.0))
    y = np.linspace(-3.0, 3.0, 301)
    sensors = np.array([-0.5, 0.5, *([0.0] if third >= 0.5 else [])]) * apart
    finger = _row(sensors, gain=_FULL, noise=1e-3)
    field = finger.receptive_field(y)[..., 0]
    curves = [curve(f"sensor {i + 1}", str(i + 1), y, field[:, i]) for i in range(sensors.size)]
    marks = [mark(f"point, {force:.2f}", "right", float(at), 1.15) for at, force in zip(points, forces)]
    told = []
    if np.isfinite(same.position).any():
        k = int(np.nanargmin(np.abs(same.position - points.mean())))
        one, force = float(same.position[k]), float(same.force[k])
        marks.append(mark(f"one that reads the same, {force:.2f}", "2", one, 1.15))
        told.append(f"Sensors 1 and 2 read the same of one point of {force:.2f} at y = {one:.2f}.")
        if third >= 0.5:
            both = forces @ finger.receptive_field(points)[..., 0]
            single = force * finger.receptive_field(np.array([one]))[0, :, 0]
            told.append(f"The third sensor tells them: {both[2]:.3f} of two points, {single[2]:.3f} of the one.")
    else:
        told.append("No single point reads the same at both sensors.")
    return drawn(
        told,
        panel(
            "What each sensor reads of a unit point",
            "position of the point, y / d",
            "reading / full scale",
            curves,
            marks=marks,
            high=1.3,
        ),
    )


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
    Figure(
        "14",
        "Fig. 14: strain at discrete sensors",
        "Spread the sensors: what lies between them can no longer be recovered.",
        (
            Number("pitch", "pitch of sensors", 1.0, 0.4, 3.0, 0.05, "d"),
            Number("width", "half width of the larger touch", 1.0, 0.2, 2.0, 0.05, "d"),
        ),
        ("23, 24",),
        _sampled,
    ),
    Figure(
        "15",
        "Fig. 15: the skin as a filter",
        "A deeper sensor hears long waves alone. As printed the spectrum is odd; that of an even response is even.",
        (
            Number("depth", "depth d", 1.0, 0.3, 3.0, 0.05),
            Number("attenuation", "damping that is enough", 1000.0, 10.0, 10000.0, 10.0),
        ),
        ("23, 24", "25", "26"),
        _filter,
    ),
    Figure(
        "16",
        "Fig. 16: ridges",
        "Ridges of the right pitch make the strain larger. Others do nothing, or harm.",
        (
            Number("pitch", "pitch of ridges", 6.3, 1.0, 14.0, 0.1, "d"),
            Number("half_width", "half width of the touch", 10.0, 3.0, 14.0, 0.5, "d"),
        ),
        (),
        _ridged,
    ),
    Figure(
        "18",
        "Figs. 18 and 19: two points",
        "Two sensors take two points for one. A third sensor tells them apart.",
        (
            Number("apart", "sensors 1 and 2 apart", 1.0, 0.4, 2.0, 0.05, "d"),
            Number("first", "one point y", -0.75, -2.5, 2.5, 0.05, "d"),
            Number("second", "other point y", 0.6, -2.5, 2.5, 0.05, "d"),
            Number("share", "share of the first", 0.6, 0.1, 0.9, 0.02),
            Number("third", "third sensor (0 or 1)", 0.0, 0.0, 1.0, 1.0),
        ),
        (),
        _two,
    ),
)
