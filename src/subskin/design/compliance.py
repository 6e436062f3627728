"""How soft should the skin be? A particle on a flat, read through skins of many moduli (memo section 7, Fig. 17)."""

from __future__ import annotations

import warnings
from collections.abc import Callable
from dataclasses import dataclass, replace
from enum import IntEnum
from typing import Annotated, Any

import numpy as np
import numpy.typing as npt

from .._check import FloatArray
from .._declared import Fix, Positive, Real, checked
from ..contact import Contact, LineLoad, PressureProfile
from ..errors import GeometryError, InvalidValueError, NotLinearError, ValidityWarning
from ..finger import Finger
from ..pressing import ContactSolution, Flat, Indenter, ParticleOnFlat, PressStatus, RoundedFlat, press
from ._common import Found, listed, noise_of

__all__ = ["Regime", "SkinCompliance", "skin_compliance"]

_STEP = 0.05
"""Step of the logarithms by which width, height and force are varied."""
_EXACT = 1e-6
"""To what share of themselves differences of readings are known; what is left below it is nothing."""
_SEEN = 5.0
_BESIDE = 4.0
"""A contact wider than so many particles is one with the flat beside it."""
_ROOM, _RUNG = 1.15, 2**0.25
"""How much wider than the contact a window is, and the ladder on which windows of neighbouring cells are the same."""
_NODES, _FINE, _MOST_NODES = 1024, 24, 4096
"""Nodes of a window: so many at least, and so many across what touches the particle."""
_MODULI = tuple(np.geomspace(0.03e6, 30e6, 16).tolist())


class Regime(IntEnum):
    """What a finger can make of a particle."""

    TOLD = 0
    """The particle is noticed, and its width told."""
    TIP = 1
    """Too stiff: the particle carries most of the force, and the skin touches little beside it."""
    BLURRED = 2
    """Too soft: the flat around the particle carries most, and the particle's share of the readings is too small."""
    STRAINED = 3
    """So soft that the strains are beyond the theory of small ones."""
    SATURATED = 4
    """A sensor reads beyond its range."""
    MIXED = 5
    """The particle carries most of the force, and yet the skin touches the flat far beside it: its height and the force
    do to the readings what its width does."""


@dataclass(frozen=True, eq=False)
class SkinCompliance(Found):
    """What `skin_compliance` found. Arrays of shape (t, m, f): thickness, modulus, force.

    Attributes
    ----------
    finger : Finger
    particle : ParticleOnFlat
    thickness, young, force : ndarray, shapes (t,), (m,), (f,)
        Thickness of the skin [m], modulus of the material in which the sensors lie [Pa], others stiffer in proportion;
        force in N/m.
    half_width : ndarray
        Half width of all that touches [m].
    load_share : ndarray
        Share of the force that the particle carries [-].
    reading_share : ndarray
        Largest change of a reading by the particle, over the largest reading [-].
    seen : ndarray
        The change of all readings by the particle, over their errors.
    width_std : ndarray
        Standard deviation of the particle's width, relative to it, where its height, its position and the force are
        unknown too; infinite where they hide it altogether.
    regime : ndarray of int
        Values of `Regime`.
    best : (int, int)
        Index of the thickness and the modulus that are recommended.
    reason : str
        Why.
    """

    finger: Finger
    particle: ParticleOnFlat
    thickness: FloatArray
    young: FloatArray
    force: FloatArray
    half_width: FloatArray
    load_share: FloatArray
    reading_share: FloatArray
    seen: FloatArray
    width_std: FloatArray
    regime: npt.NDArray[np.int_]
    best: tuple[int, int]
    reason: str

    @property
    def own_young(self) -> float:
        """Modulus of the finger as given [Pa], where its sensors lie."""
        return _own_modulus(self.finger)


@checked
def skin_compliance(
    finger: Finger,
    particle: Annotated[ParticleOnFlat, Fix("pressing.ParticleOnFlat(4e-4, 3e-5, flat_half_width=1e-2)")],
    force: npt.ArrayLike,
    *,
    young: npt.ArrayLike = _MODULI,
    thickness: npt.ArrayLike | None = None,
    accuracy: Annotated[float, Real(at_least=0.0)] = 0.01,
    width_wanted: Positive = 0.5,
    progress: Callable[[], object] | None = None,
) -> SkinCompliance:
    """Which modulus and thickness let a finger see a particle on a flat, over a range of forces.

    The finger is pressed on the flat with the particle at its middle, and on the flat alone, by `press`. A particle is
    found where it changes the readings by five times their error or more and its width follows from them to
    `width_wanted`: by the Fisher information, with the particle's height, its position and the force unknown as well.
    The error of a reading is the sensor's noise, and a share of the largest reading, for nothing is calibrated
    perfectly; without that share a soft skin loses nothing by touching the flat around the particle. Strains depend on
    force over modulus alone, so a range of forces asks for a skin that serves as wide a range of moduli. Source: memo
    section 7, Fig. 17.

    Parameters
    ----------
    finger : Finger
        With the noise of its sensors, four or more of them; five or more, where they lie alike on both sides. A flat
        skin needs a particle on a flat that ends.
    particle : ParticleOnFlat
        The smallest feature of interest.
    force : array_like, shape (f,)
        Forces of the finger [N/m], > 0.
    young : array_like, shape (m,), optional
        Moduli of the material in which the sensors lie [Pa], ascending; 0.03 to 30 MPa if left out.
    thickness : array_like, shape (t,), optional
        Thicknesses of the skin [m]; its own if left out.
    accuracy : float, optional
        Error of a reading beside its noise, in shares of the largest reading.
    width_wanted : float, optional
        Relative standard deviation of the width that is good enough.
    progress : callable, optional
        Called after each of the t * m * f cells.

    Raises
    ------
    InvalidValueError
        No noise, fewer than four sensors, values out of range.
    GeometryError
        A flat skin and a flat without end.
    NotLinearError
        A transducer that is not linear.

    Examples
    --------
    >>> import subskin as ss
    >>> skin = ss.Round(ss.Material(young=0.4e6), radius=8e-3, core_radius=4e-3)
    >>> finger = ss.Finger(skin, ss.SensorArray.line(count=8, pitch=0.5e-3, depth=0.8e-3, noise=2e-5))
    >>> particle = ss.pressing.ParticleOnFlat(half_width=0.4e-3, protrusion=30e-6)
    >>> found = ss.design.skin_compliance(finger, particle, force=40.0, young=[0.05e6, 0.2e6, 2e6])
    >>> [ss.design.compliance.Regime(r).name for r in found.regime[0, :, 0]]
    ['BLURRED', 'TOLD', 'TIP']
    """
    forces, moduli = listed("force", force, "N/m", above=0.0), listed("young", young, "Pa", above=0.0)
    thick = np.array([finger.skin.thickness]) if thickness is None else listed("thickness", thickness, "m", above=0.0)
    _check_case(finger, particle)
    shape = (thick.size, moduli.size, forces.size)
    names = ("half_width", "load_share", "reading_share", "seen", "width_std", "saturated")
    values = {name: np.full(shape, np.nan) for name in names}
    for t, height in enumerate(thick):
        skin = finger.skin if thickness is None else finger.skin.with_(thickness=float(height))
        study = _Study(replace(finger, skin=skin), particle, accuracy)
        for m, f in np.ndindex(shape[1:]):
            for name, value in study.cell(float(moduli[m]), float(forces[f])).items():
                values[name][t, m, f] = value
            if progress is not None:
                progress()
    told = (values["seen"] >= _SEEN) & (values["width_std"] <= width_wanted)
    most = values["load_share"] > 0.5
    beside = values["half_width"] > _BESIDE * particle.half_width
    regime = np.select(
        [np.isnan(values["seen"]), values.pop("saturated") == 1, told, most & beside, most],
        [int(r) for r in (Regime.STRAINED, Regime.SATURATED, Regime.TOLD, Regime.MIXED, Regime.TIP)],
        int(Regime.BLURRED),
    )
    best, reason = _recommended(thick, moduli, forces, regime, values["width_std"], width_wanted)
    return SkinCompliance(finger, particle, thick, moduli, forces, **values, regime=regime, best=best, reason=reason)


def _check_case(finger: Finger, particle: ParticleOnFlat) -> None:
    """Refuse a finger whose readings do not determine the particle, and a skin that would touch all along."""
    if len(finger.array) < 4:
        rule = "width, height, position and force are four unknowns"
        raise InvalidValueError(f"{len(finger.array)} sensors", rule, "a finger with four sensors or more")
    noise_of(finger.array)
    if not all(t.linear for t in finger.array.transducers):
        rule = "a modulus scales the readings of linear ones only"
        raise NotLinearError("a transducer that is not linear", rule, "NormalStrain()")
    if np.isinf(finger.skin.period) and np.isinf(particle.flat_half_width):
        seen, fix = f"a flat skin, {type(finger.skin).__name__}, on a flat without end", "flat_half_width=1e-2"
        raise GeometryError(seen, "they would touch all along", f"{fix} of the particle's flat, or a round skin")
    if _differing(finger) < 3:
        seen = f"{len(finger.array)} sensors, alike on both sides of the particle"
        rule = "they have two different readings for its width, its height and the force"
        raise InvalidValueError(seen, rule, "a finger with five sensors or more")


def _differing(finger: Finger) -> int:
    """How many readings of a particle at the middle differ: two sensors alike on both sides of it read the same."""
    a = finger.array
    rows = np.stack([np.asarray(v, dtype=np.float64) for v in (a.y, a.depth, a.gain, a.noise)])[:, np.argsort(a.y)]
    mirrored = rows[:, ::-1] * [[-1.0], [1.0], [1.0], [1.0]]
    alike = bool(np.allclose(rows, mirrored, rtol=1e-9, atol=1e-9 * float(np.abs(rows[0]).max())))
    return (len(a) + 1) // 2 if alike else len(a)


def _own_modulus(finger: Finger) -> float:
    """Young's modulus where the sensors lie [Pa]."""
    return finger.skin.material_at(float(np.asarray(finger.array.depth).mean())).young


def _signal(finger: Finger, contact: Contact) -> FloatArray:
    """Readings without their offset."""
    return np.asarray(np.asarray(finger.array.gain) * finger.measure(contact))


class _Study:
    """Presses of one finger, kept by force over modulus: twice both, and every displacement is the same."""

    def __init__(self, finger: Finger, particle: ParticleOnFlat, accuracy: float) -> None:
        self.finger, self.particle, self.accuracy = finger, particle, accuracy
        self.own = _own_modulus(finger)
        self._known: dict[float, dict[str, FloatArray]] = {}
        self._probe = LineLoad(1.0, 0.3, 0.1 * float(np.asarray(finger.array.depth).mean()))
        self._probed = _signal(finger, self._probe)

    def cell(self, modulus: float, force: float) -> dict[str, float]:
        """All that is asked of one modulus and force; nothing where the strains are too large."""
        scale = modulus / self.own
        key = float(f"{force / scale:.12g}")
        if key not in self._known:
            try:
                self._known[key] = self._solved(force / scale)
            except InvalidValueError:
                self._known[key] = {}
        found = self._known[key]
        if not found:
            return {}
        skin, a = self.finger.skin, self.finger.array
        stiff = [replace(m, young=scale * m.young) for m in skin.materials]
        # a strain is the same at the same force over modulus; a stress is `scale` times as large
        probed = _signal(replace(self.finger, skin=skin.with_(materials=stiff)), self._probe)
        ratio = scale * float(probed @ self._probed) / float(self._probed @ self._probed)
        reading = ratio * found["reading"]
        error = np.hypot(np.asarray(a.noise), self.accuracy * np.abs(reading).max())
        whole = reading + np.asarray(a.offset)
        return {name: float(found[name]) for name in ("half_width", "load_share", "reading_share")} | {
            "seen": float(np.linalg.norm(ratio * found["change"] / error)),
            "width_std": _deviation(ratio * found["slopes"] / error[:, None]),
            "saturated": float(((whole < np.asarray(a.low)) | (whole > np.asarray(a.high))).any()),
        }

    def _solved(self, force: float) -> dict[str, FloatArray]:
        """Contact and readings at the finger's own modulus, and their slopes by what is unknown."""
        particle = self.particle
        wide, tall, ends = particle.half_width, particle.protrusion, particle.flat_half_width
        flat: Indenter = RoundedFlat(ends) if np.isfinite(ends) else Flat()
        bodies = [(particle, 1.0), (flat, 1.0)]
        # one grid for all, so that a change of the readings is one of the contact, not of the grid
        steps = [np.exp(_STEP), np.exp(-_STEP)]
        bodies += [(replace(particle, half_width=s * wide), 1.0) for s in steps]
        bodies += [(replace(particle, protrusion=s * tall), 1.0) for s in steps]
        bodies += [(particle, s) for s in steps]
        here, alone, *varied = self._on_one_grid([(body, s * force) for body, s in bodies])
        contact, h = here.contact, _STEP * wide
        reading = _signal(self.finger, contact)
        change = reading - _signal(self.finger, alone.contact)
        moved = [PressureProfile(contact.nodes + by, contact.node_pressure, contact.node_shear) for by in (h, -h)]
        others = [found.contact for found in varied]
        pairs = [others[0:2], others[2:4], moved, others[4:6]]
        slopes = [(_signal(self.finger, up) - _signal(self.finger, down)) / (2 * _STEP) for up, down in pairs]
        on_top = np.abs(here.y) <= particle.half_width
        return {
            "half_width": np.asarray(here.half_width),
            "load_share": np.asarray(here.pressure[on_top].sum() / here.pressure.sum()),
            "reading_share": np.asarray(np.abs(change).max() / np.abs(reading).max()),
            "reading": reading,
            "change": change,
            "slopes": np.stack(slopes, axis=-1),
        }

    def _on_one_grid(self, bodies: list[tuple[Indenter, float]]) -> list[ContactSolution]:
        """Presses by forces in a window that is wide enough for all."""
        particle, period = self.particle, self.finger.skin.period
        widest = 2 * particle.flat_half_width if np.isfinite(particle.flat_half_width) else 0.5 * period
        free = [self._pressed(body, force) for body, force in bodies[:2]]  # refused where the strain is too large
        reach = max(2 * float(np.abs(f.y[f.pressure > 0]).max()) for f in free)
        narrow = 2 * float(np.abs(free[0].y[(free[0].pressure > 0) & (np.abs(free[0].y) <= particle.half_width)]).max())
        while True:
            window = min(float(_RUNG ** np.ceil(np.log(_ROOM * reach) / np.log(_RUNG))), widest)
            nodes = int(np.clip(2 ** np.ceil(np.log2(_FINE * window / narrow)), _NODES, _MOST_NODES))
            try:
                return [self._pressed(*pair, window=window, nodes=nodes, max_strain=None) for pair in bodies]
            except GeometryError:  # one of them touches beyond
                if window >= widest:
                    raise
                reach *= 1.3

    def _pressed(self, body: Indenter, force: float, **asked: Any) -> ContactSolution:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", ValidityWarning)
            found = press(self.finger.skin, body, force=force, **asked)
        if found.status not in (PressStatus.OK, PressStatus.COARSE):
            seen, rule = f"a press by {force:.6g} N/m", f"it did not settle: {found.reason}"
            raise InvalidValueError(seen, rule, "another force or modulus, or more nodes")
        return found


def _deviation(slopes: FloatArray) -> float:
    """Standard deviation of the first unknown, the others free: what of its column the others cannot mimic."""
    first, others = slopes[:, 0], slopes[:, 1:]
    left = first - others @ np.linalg.lstsq(others, first, rcond=None)[0]
    size = float(np.linalg.norm(left))
    return 1 / size if size > _EXACT * float(np.linalg.norm(first)) else np.inf


def _recommended(
    thickness: FloatArray,
    moduli: FloatArray,
    forces: FloatArray,
    regime: npt.NDArray[np.int_],
    width_std: FloatArray,
    wanted: float,
) -> tuple[tuple[int, int], str]:
    """The cell whose worst force is least bad, and why."""
    told = regime == Regime.TOLD
    usable = told.sum(axis=2)
    worst = np.where(np.isnan(width_std), np.inf, width_std).max(axis=2)
    order = np.lexsort((worst.ravel(), -usable.ravel()))  # most forces first, then the least deviation
    t, m = (int(i) for i in np.unravel_index(order[0], usable.shape))
    span = f"{forces.min():.3g} to {forces.max():.3g} N/m" if forces.size > 1 else f"{forces[0]:.3g} N/m"
    head = f"E = {moduli[m] / 1e6:.3g} MPa, {thickness[t] * 1e3:.3g} mm thick"

    def why(m: int, f: int) -> str:
        return f"at {forces[f]:.3g} N/m {_WHY[Regime(int(regime[t, m, f]))]}"

    if not usable[t, m]:
        off = worst[t, m]
        error = f"{100 * off:.2g} %" if off < 10 else f"an error of {off:.2g} times the width"
        near = f"{head} comes nearest, with {error}" if np.isfinite(off) else "none comes near"
        return (t, m), (
            f"no skin tried finds the particle's width to {100 * wanted:.0f} % at any of the forces; {near}; "
            "sensors of less error, less deep or closer together would"
        )
    if usable[t, m] < forces.size:
        missing = ", ".join(why(m, int(f)) for f in np.flatnonzero(~told[t, m]))
        served = (forces / moduli[:, None])[told[t]]
        ratio = served.max() / served.min()
        apart = f"a skin of one modulus serves forces of which the largest is {ratio:.2g} times the smallest"
        apart = f"; {apart}" if ratio > 1.005 else ""
        return (t, m), f"{head} comes nearest: no skin tried serves all of {span}; {missing}{apart}"
    serves = np.flatnonzero(usable[t] == forces.size)
    low, high = moduli[serves[0]], moduli[serves[-1]]
    between = f"{low / 1e6:.3g} MPa" if low == high else f"{low / 1e6:.3g} to {high / 1e6:.3g} MPa"
    lines = [
        f"{head}: at all of {span} the particle's width is found to {100 * worst[t, m]:.2g} % or better",
        f"at this thickness {between} would do for {100 * wanted:.0f} %",
    ]
    for end, beside, force_at in (("softer", int(serves[0]) - 1, -1), ("stiffer", int(serves[-1]) + 1, 0)):
        if 0 <= beside < moduli.size:
            lines.append(f"{end}, {why(beside, int(np.flatnonzero(~told[t, beside])[force_at]))}")
    return (t, m), "; ".join(lines)


_WHY = {
    Regime.TIP: "the skin hardly touches more than the particle's top",
    Regime.MIXED: "its width looks like a change of its height or of the force, the flat beside it being touched too",
    Regime.BLURRED: "its width is lost beside the flat around it",
    Regime.STRAINED: "the strains are beyond the theory",
    Regime.SATURATED: "a sensor reads beyond its range",
    Regime.TOLD: "it is found",
}
