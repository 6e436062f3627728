"""What a touch receptor in the skin answers to: bars, edges and gratings pressed in, strains at its depth, its rate.

Phillips and Johnson (J. Neurophysiol. 46 (1981) 1192 and 1204) pressed rigid bars, edges and gratings into a monkey's
finger, and compared the rate of afferents with strains where the receptors are. The memo names their work for its own
maximum compressive strain. Here the skin is a soft layer on bone; a stimulus is pressed in by `press`; and the rate is
max(0, slope * strain + rest), whose slope, rest and depth are fitted.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Annotated, ClassVar, Literal, NamedTuple

import numpy as np
import numpy.typing as npt

from . import _check
from ._check import FloatArray
from ._declared import Length, Noun, Real
from .contact import PressureProfile
from .errors import GeometryError, InvalidValueError
from .material import Material
from .pressing import Indenter, Profile, RoundedFlat, press
from .skin import Layer, Layered, Skin
from .transducer import EnergyDensity, MaxCompressiveStrain, NormalStrain, ShearStrain, Transducer

__all__ = ["MEASURES", "AfferentFit", "Measure", "Stimulus", "finger_skin", "fit_rates", "strain_at"]


class Measure(NamedTuple):
    """What a receptor may answer to.

    Parameters
    ----------
    kind : Transducer
        What measures it; compression counts as positive, of shear the magnitude.
    power : int
        Of the indentation, with which it grows [-].
    said : str
        Its name for people.

    Examples
    --------
    >>> MEASURES["energy_density"].said, MEASURES["energy_density"].power
    ('strain energy density', 2)
    """

    kind: Transducer
    power: int
    said: str


MEASURES: Mapping[str, Measure] = {
    "max_compressive_strain": Measure(MaxCompressiveStrain(), 1, "maximum compressive strain"),
    "energy_density": Measure(EnergyDensity(), 2, "strain energy density"),
    "normal_strain": Measure(NormalStrain(), 1, "strain along the depth"),
    "shear_strain": Measure(ShearStrain(), 1, "shear strain"),
}
"""In an incompressible skin the stretch along the surface is the compression along the depth."""
_EDGE = 20e-3
"""Width of what stands for an edge [m]: a bar that ends at 0, and reaches to -y."""
_PHASES = 48
"""Positions over a period of a grating, or across a bar, that a scan is averaged over."""
_BEYOND = 3e-3
"""How far beyond a bar a scan goes [m]."""
_DEPTHS = (0.3e-3, 1.2e-3, 19)
"""From where to where a receptor's depth is sought, and how many are tried [m]."""
_FINGER, _GROOVE, _WALL = 12e-3, 1e-2, 1e-6
"""Width of a fingertip on a grating, depth of its grooves, and width of their walls [m]."""
_PRESSED = 1e-4
"""Indentation at which stimuli are pressed [m]; strains go with it."""
_NODES = 4096
"""Over a grating: some 150 across a bar of half a millimetre."""
_LEAST = 3


@dataclass(frozen=True, eq=False)
class Stimulus(Noun):
    """A rigid body that is pressed into the skin.

    Parameters
    ----------
    shape : {"bar", "edge", "grating"}
        A bar about y = 0; an edge at y = 0, the body at y < 0; bars one beside the other on the
        12 mm of a fingertip, one of them about y = 0.
    width : float, optional
        Of a bar, or of each bar of a grating [m]. An edge has none.
    gap : float, optional
        Between two bars of a grating [m].
    indentation : float, optional
        How deep it is pressed [m].

    Raises
    ------
    GeometryError
        A bar without a width, a grating without a gap.

    Examples
    --------
    >>> Stimulus("grating", width=0.5e-3, gap=2e-3).period
    0.0025
    """

    shape: Literal["bar", "edge", "grating"]
    width: Annotated[float, Real("m", at_least=0.0)] = 0.0
    gap: Annotated[float, Real("m", at_least=0.0)] = 0.0
    indentation: Length = 1e-3

    EXAMPLE: ClassVar = 'Stimulus("bar", width=1e-3)'

    def __post_init__(self) -> None:
        super().__post_init__()
        if (self.shape != "edge" and not self.width > 0) or (self.shape == "grating" and not self.gap > 0):
            seen = f"a {self.shape} of width {self.width:g} m and gap {self.gap:g} m"
            raise GeometryError(seen, "a bar needs a width, a grating a width and a gap", self.EXAMPLE)

    @property
    def period(self) -> float:
        """Of a grating [m]; 0 of the others."""
        return self.width + self.gap if self.shape == "grating" else 0.0

    def scan(self) -> FloatArray:
        """Positions of a receptor that the stimulus is moved over [m], shape (48,)."""
        if self.period:
            return (np.arange(_PHASES) + 0.5) / _PHASES * self.period
        half = 0.5 * self.width + _BEYOND
        return np.linspace(-half, half, _PHASES)


@lru_cache(maxsize=8)
def finger_skin(thickness: float = 10e-3, poisson: float = 0.5) -> Layered:
    """The pulp of a fingertip on bone. Its modulus does not matter, since stimuli are pressed by their indentation.

    Parameters
    ----------
    thickness : float, optional
        [m]
    poisson : float, optional
        Poisson's ratio [-].

    Examples
    --------
    >>> finger_skin().thickness
    0.01
    """
    return Layered(Layer(Material(young=1e5, poisson=poisson), thickness=thickness))


def strain_at(
    stimulus: Stimulus, position: npt.ArrayLike, depth: float, measure: str, skin: Skin | None = None
) -> FloatArray:
    """One of `MEASURES` at a receptor, shape (...).

    Parameters
    ----------
    stimulus : Stimulus
        What is pressed in.
    position : array_like, shape (...)
        Positions y of the receptor [m].
    depth : float
        Of the receptor [m].
    measure : str
        A key of `MEASURES`.
    skin : Skin, optional
        One with a ground; `finger_skin()` if left out.

    Raises
    ------
    InvalidValueError, GeometryError
        Another measure, a depth beyond the skin.

    Examples
    --------
    >>> bar = Stimulus("bar", width=3e-3)
    >>> beneath, beside = strain_at(bar, [0.0, 1.5e-3], 0.7e-3, "max_compressive_strain")
    >>> bool(beside > beneath > 0)  # its edges are felt most
    True
    """
    _check.choice("measure", measure, MEASURES)
    skin = finger_skin() if skin is None else skin
    within = _check.scalar("depth", depth, unit="m", above=0.0, at_most=skin.thickness)
    return _felt(stimulus, _check.real("position", position, unit="m"), within, skin, [measure])[measure]


def _felt(
    stimulus: Stimulus, at: FloatArray, depth: float, skin: Skin, measures: Sequence[str]
) -> dict[str, FloatArray]:
    """Some measures at positions [m]."""
    pressed = _pressed(skin, stimulus.shape, stimulus.width, stimulus.gap)
    if stimulus.period:  # the bar in the middle
        at = at - np.round(at / stimulus.period) * stimulus.period
    state = skin.at(depth, at)(pressed)
    deeper, out = stimulus.indentation / _PRESSED, {}
    for measure in measures:
        kind, power, _ = MEASURES[measure]
        values = np.asarray(kind.measure(state)) * deeper**power
        out[measure] = {"normal_strain": np.negative, "shear_strain": np.abs}.get(measure, np.asarray)(values)
    return out


@lru_cache(maxsize=256)
def _pressed(skin: Skin, shape: str, width: float, gap: float) -> PressureProfile:
    """What a stimulus does to the skin at the indentation `_PRESSED`."""
    if shape == "grating":
        period = width + gap
        most = int(0.5 * (_FINGER - width) / period + 1e-9)
        ends = np.arange(-most, most + 1)[:, None] * period + 0.5 * width * np.array([-1.0, -1.0, 1.0, 1.0])
        ends += _WALL * np.array([-1.0, 0.0, 0.0, 1.0])
        body: Indenter = Profile(ends.ravel(), np.tile([_GROOVE, 0.0, 0.0, _GROOVE], 2 * most + 1))
        return press(skin, body, depth=_PRESSED, nodes=_NODES, max_strain=None).contact
    wide, at = (_EDGE, -0.5 * _EDGE) if shape == "edge" else (width, 0.0)
    return press(skin, RoundedFlat(0.5 * wide, 0.0), depth=_PRESSED, position=at, max_strain=None).contact


class AfferentFit(NamedTuple):
    """How well one measure explains the rates.

    Parameters
    ----------
    measure : str
        A key of `MEASURES`.
    r2 : float
        Share of the variance of the rates that it explains [-].
    depth : float
        Of the receptor [m].
    slope, rest : float
        Of the rate: per unit of the measure [1/s per unit], and without a stimulus [1/s].
    rates : ndarray, shape (rows,)
        As fitted [1/s].
    """

    measure: str
    r2: float
    depth: float
    slope: float
    rest: float
    rates: FloatArray


def fit_rates(
    stimuli: Sequence[Stimulus],
    rates: npt.ArrayLike,
    positions: npt.ArrayLike | None = None,
    *,
    depth: float | None = None,
    skin: Skin | None = None,
    measures: Sequence[str] = tuple(MEASURES),
) -> list[AfferentFit]:
    """Fit the rates of an afferent by each measure, the best first.

    Parameters
    ----------
    stimuli : sequence of Stimulus
        What was pressed in, row by row.
    rates : array_like, shape (rows,)
        Impulses a second [1/s].
    positions : array_like, shape (rows,), optional
        Of the receptor on the axis of each stimulus [m]; where it is NaN, or left out, the stimulus moved over the
        receptor, and the rate is its mean.
    depth : float, optional
        Of the receptor [m]; if left out it is sought from 0.3 to 1.2 mm, for each measure its own.
    skin : Skin, optional
        As of `strain_at`.
    measures : sequence of str, optional
        Which of `MEASURES`.

    Raises
    ------
    InvalidValueError, GeometryError
        Fewer than three rows, rates that are all alike, other shapes.

    Examples
    --------
    >>> gratings = [Stimulus("grating", width=0.5e-3, gap=gap * 1e-3) for gap in (0.5, 1.0, 2.0, 4.0)]
    >>> fits = fit_rates(gratings, [5.0, 20.0, 45.0, 60.0], depth=0.7e-3, measures=["max_compressive_strain"])
    >>> fits[0].measure, fits[0].r2 > 0.5
    ('max_compressive_strain', True)
    """
    seen = _check.real("rates", rates, unit="1/s", at_least=0.0)
    if seen.ndim != 1 or len(seen) != len(stimuli) or len(seen) < _LEAST:
        rule = f"one rate a stimulus, and at least {_LEAST} of them"
        raise GeometryError(f"rates of shape {seen.shape}, {len(stimuli)} stimuli", rule, "a row for each presentation")
    if np.ptp(seen) == 0:
        raise InvalidValueError("rates that are all alike", "no measure explains what does not vary", "other stimuli")
    at = np.full(len(seen), np.nan) if positions is None else np.asarray(positions, dtype=np.float64)
    if at.shape != seen.shape:
        raise GeometryError(f"positions of shape {at.shape}", f"{seen.shape} is needed", "NaN where it moved")
    on = finger_skin() if skin is None else skin
    depths = np.linspace(*_DEPTHS) if depth is None else [_check.scalar("depth", depth, unit="m", above=0.0)]
    for measure in measures:
        _check.choice("measure", measure, MEASURES)
    best: dict[str, AfferentFit] = {}
    for each in map(float, depths):
        for measure, strains in _rows(stimuli, at, each, on, measures).items():
            fit = _fitted(measure, each, strains, seen)
            if measure not in best or fit.r2 > best[measure].r2:
                best[measure] = fit
    return sorted(best.values(), key=lambda fit: -fit.r2)


def _rows(
    stimuli: Sequence[Stimulus], at: FloatArray, depth: float, skin: Skin, measures: Sequence[str]
) -> dict[str, FloatArray]:
    """Of each measure the strains of all rows, (rows, positions of a scan); each stimulus is asked once."""
    out = {measure: np.empty((len(stimuli), _PHASES)) for measure in measures}
    alike: dict[tuple[object, ...], list[int]] = {}
    for i, each in enumerate(stimuli):
        alike.setdefault((each.shape, each.width, each.gap, each.indentation), []).append(i)
    for rows in alike.values():
        one = stimuli[rows[0]]
        still = [i for i in rows if np.isfinite(at[i])]
        for values, chosen in ((at[still], still), (one.scan(), [i for i in rows if np.isnan(at[i])])):
            if chosen:
                for measure, felt in _felt(one, values, depth, skin, measures).items():
                    out[measure][chosen] = felt[:, None] if chosen is still else felt
    return out


def _fitted(measure: str, depth: float, strains: FloatArray, rates: FloatArray) -> AfferentFit:
    """Slope and rest of one measure at one depth."""
    from scipy.optimize import least_squares

    unit = float(np.abs(strains).max()) or 1.0

    def rate(p: FloatArray) -> FloatArray:
        return np.asarray(np.maximum(p[0] * strains / unit + p[1], 0.0).mean(axis=1))

    def missed(p: FloatArray) -> FloatArray:
        return rate(p) - rates

    line = np.linalg.lstsq(np.stack([strains.mean(axis=1) / unit, np.ones(len(rates))], axis=1), rates, rcond=None)[0]
    peak = np.array([rates.max(), 0.0])
    tried = [least_squares(missed, start) for start in (line, peak, peak * 2 - rates.mean())]
    best = min(tried, key=lambda each: each.cost)
    r2 = 1.0 - 2.0 * best.cost / float(((rates - rates.mean()) ** 2).sum())
    return AfferentFit(measure, float(r2), depth, float(best.x[0]) / unit, float(best.x[1]), rate(best.x))
