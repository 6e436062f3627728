"""The memo's three strain sensors: every load that could have made their readings (memo eqs. 12 and 13)."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum, IntEnum
from typing import Annotated, Literal, NamedTuple

import numpy as np
import numpy.typing as npt

from .. import _check
from .._check import FloatArray
from .._declared import Length, Real, checked
from .._frozen import Frozen
from ..errors import GeometryError
from ..material import Material
from ._three_sensor_roots import SAME, BlindPair, Determinant, RealRoot, real_roots

__all__ = ["Degeneracy", "Note", "Root", "Sensitivity", "ThreeSensorSolution", "Verdict", "three_sensor"]

# A root where two sensors are blind at once is a load only if both read nothing. "Where" is to 1e-9 depths; a
# load that far away makes them read far less than 1e-7 of the third.
_BLIND_PLACE = 1e-9
_BLIND_READING = 1e-7
# Rounding must not push a load at the very edge of the friction cone out of it.
_CONE_SLACK = 1e-9


class Verdict(IntEnum):
    """What to make of a root."""

    ACCEPTED = 0
    """A load that presses, within the friction cone, and makes these readings."""
    PULLS = 1
    """It would have to pull on the skin (N < 0): not without glue."""
    SLIPS = 2
    """It presses, but leans beyond the friction cone, abs(T) > friction * N."""
    NOT_A_SOLUTION = 3
    """A root of eq. (13) but of no load: it came in when the denominators of eq. (12) were cleared."""


class Degeneracy(Enum):
    """What is special about a row of sensors, its readings, or one of the roots."""

    PITCH_IS_DEPTH = "pitch = depth"
    PITCH_IS_TWO_DEPTHS = "pitch = 2 depths"
    PITCH_IS_SQRT3_DEPTHS = "pitch = sqrt(3) depths"
    BLIND_TOGETHER = "two sensors blind to one position"
    NO_CONTACT = "all readings are zero"
    DEGREE_DROPS = "the degree drops"
    NORMAL_LOAD_OVER_MIDDLE = "normal load over the middle sensor"
    DOUBLE_ROOT = "double root"
    FORCE_UNDETERMINED = "the force is not determined"


@dataclass(frozen=True)
class Note:
    """A degeneracy that was met, its `kind`, and what it means here, as `text`; `three_sensor` makes them."""

    kind: Degeneracy
    text: str

    def __str__(self) -> str:
        return f"{self.kind.value}: {self.text}"


class Sensitivity(NamedTuple):
    """Standard deviations to first order, per unit standard deviation of independent errors of the readings.

    Of `position` [m], `force` [N/m] and `angle` [rad]: infinite where the Jacobian is singular, NaN where there is no
    load.
    """

    position: float
    force: float
    angle: float


@dataclass(frozen=True)
class Root:
    """One real root of eq. (13) and the load that it stands for.

    Parameters
    ----------
    position : float
        Position y of the load [m], on the axis of the sensors' positions.
    force, angle : float
        Magnitude P >= 0 [N/m] and angle in (-pi, pi] [rad], positive where it drags the skin towards +y; NaN
        where the root is not a solution.
    verdict : Verdict
        What to make of it.
    multiplicity : int
        How often the root counts: 2 for a double root, where two loads coincide.
    residual : float
        Largest reading that the load leaves unexplained, relative to the largest reading.
    det_jacobian : float
        Determinant of d(readings) / d(position / depth, N / (E depth), T / (E depth)) [-]; 0 at a double root.
    sensitivity : Sensitivity
        How errors of the readings come through.
    """

    position: float
    force: float
    angle: float
    verdict: Verdict
    multiplicity: int
    residual: float
    det_jacobian: float
    sensitivity: Sensitivity

    @property
    def normal_force(self) -> float:
        """N = P cos(angle) [N/m], positive where the load presses."""
        return self.force * float(np.cos(self.angle))

    @property
    def tangential_force(self) -> float:
        """T = P sin(angle) [N/m], positive towards +y."""
        return self.force * float(np.sin(self.angle))


@dataclass(frozen=True)
class ThreeSensorSolution:
    """Every real root of eq. (13), ascending in position, and what is special about them.

    Parameters
    ----------
    roots : tuple of Root
        All of them, whatever their verdict.
    degree : int
        Degree of the polynomial in the load's position; -1 where it is zero throughout.
    notes : tuple of Note
        Degeneracies of the geometry, of the readings, and of single roots.
    """

    roots: tuple[Root, ...]
    degree: int
    notes: tuple[Note, ...]

    @property
    def accepted(self) -> tuple[Root, ...]:
        """The roots that may be the load: none, one, or, where a fourth sensor is needed, several."""
        return tuple(root for root in self.roots if root.verdict is Verdict.ACCEPTED)

    def has(self, kind: Degeneracy) -> bool:
        """Whether a note of this `kind` was made."""
        return any(note.kind is kind for note in self.notes)


@checked
def three_sensor(
    readings: npt.ArrayLike,
    y: Annotated[npt.ArrayLike, Real("m")],
    depth: Length,
    *,
    young: float,
    poisson: float = 0.5,
    plane: Literal["strain", "stress"] = "strain",
    friction: Annotated[float, Real(at_least=0.0)] = 1.0,
    tolerance: Annotated[float, Real(at_least=0.0, at_most=0.1, fix="1e-3 for readings good to 0.1 %")] = 1e-12,
) -> ThreeSensorSolution:
    """Every line load that explains three readings of normal strain in a half plane.

    Three readings leave a polynomial of degree 8 in the load's position (memo eq. 13), with up to eight real roots. All
    of them are found, each with its load and a verdict. The memo takes nu = 1/2, plane strain and equal pitch; here
    any nu, either plane state and any three positions will do. For other skins, sensors or counts see `Finger.locate`.

    Parameters
    ----------
    readings : array_like, shape (3,)
        Strain along the depth, eps_x [-], of each sensor; tension positive.
    y : array_like, shape (3,)
        Positions of the sensors [m], all different, in any order.
    depth : float
        Depth of all three [m], > 0.
    young : float
        Young's modulus of the skin [Pa], > 0.
    poisson : float, optional
        Poisson's ratio [-], in [0, 0.5].
    plane : {"strain", "stress"}, optional
        Long contact or thin slice.
    friction : float, optional
        Coefficient of friction mu [-], >= 0: a load with abs(T) > mu N is taken to slip.
    tolerance : float, optional
        Relative accuracy of the readings, at most 0.1. What so small a change of them could merge, make complex or send
        to infinity is treated as if it had: two roots as one double root, a leading coefficient as zero.

    Returns
    -------
    ThreeSensorSolution
        `.roots`, `.accepted`, `.degree`, `.notes`.

    Raises
    ------
    InvalidValueError
        A value that is not finite or out of range.
    GeometryError
        Not three readings, not three positions, or two sensors at one position.

    Notes
    -----
    With t_i = (y_i - f)/depth, kappa = nu/(1 - nu) (plane strain) or nu (plane stress) and g_i = (1 - kappa
    t_i^2)/(1 + t_i^2)^2, the readings are eps_i = const g_i (N + t_i T). Three of them allow for N and T if
    det[eps_i, g_i, t_i g_i] = 0, that is eps_1/g_1 (y_2 - y_3) + eps_2/g_2 (y_3 - y_1) + eps_3/g_3 (y_1 -
    y_2) = 0. Its denominators are cleared, so that a sensor may read nothing; for equal pitch this is eq.
    (13). Where two sensors are blind to one position f (1/sqrt(kappa) depths from both), that position is a root
    for whatever readings. Such roots are divided out before the others are sought.

    With pitch = depth and the load over the array, no second load within 45 degrees of the normal has its
    position over the array. With another pitch one often has: a fourth sensor then decides.

    Examples
    --------
    Fig. 6 of the memo: depth 3, pitch 2.5, lengths in any unit, forces in units of E. It prints the
    readings positive in compression, so they are negated. Four roots, and one is left.

    >>> found = three_sensor([0.048, -0.18, -0.19], y=[-2.5, 0.0, 2.5], depth=3.0, young=1.0)
    >>> for root in found.roots:
    ...     print(f"{root.position:8.4f} {root.force:8.4f} {np.rad2deg(root.angle):8.2f} {root.verdict.name}")
     -5.2254   4.5063  -118.59 PULLS
      0.1943   7.6570    77.71 SLIPS
      1.4913   2.0970   -22.50 ACCEPTED
      5.8950  42.3609  -158.77 PULLS
    >>> len(found.accepted), found.degree, found.notes
    (1, 8, ())

    The readings before rounding belong to a load 2 pi/3 at 1.5 and -22.5 degrees.
    """
    eps, positions = _check.read_only(np.array(_check.readings(readings))), np.asarray(y)
    _check.real("readings", np.where(np.isfinite(eps), 0.0, eps))  # finite, be they beyond all sensors
    for name, values in (("readings", eps), ("y", positions)):
        if values.shape != (3,):
            raise GeometryError(f"{name} of shape {values.shape}", "three sensors are needed", "see Finger.locate")
    if np.unique(positions).size < 3:
        raise GeometryError(f"y = {positions.tolist()}", "the three positions have to differ", "y=[-1e-3, 0, 1e-3]")
    skin = Material(young, poisson)
    order = np.argsort(positions)
    middle = float(positions[order[1]])
    s = (positions[order] - middle) / depth
    nu = skin.poisson
    kappa, factor = (nu / (1 - nu), 1 - nu**2) if plane == "strain" else (nu, 1.0)
    scale = float(np.abs(eps).max())
    e = eps[order] / (scale or 1.0)
    determinant = Determinant(s, e, kappa)
    notes = _geometry_notes(s, kappa, determinant.blind_pairs)
    if scale == 0:
        text = "nothing touches the skin, or nothing that these sensors feel"
        return ThreeSensorSolution((), -1, (*notes, Note(Degeneracy.NO_CONTACT, text)))

    found, degree = real_roots(determinant, tolerance)
    model = _Model(s, e, kappa, 2 * factor / np.pi, determinant.blind_pairs, middle, depth, scale, skin.young * depth)
    roots: list[Root] = []
    nominal = 8 if kappa > 0 else 4
    if degree < nominal:
        notes.append(Note(Degeneracy.DEGREE_DROPS, _degree_text(degree, nominal)))
    for item in _with_blind_positions(found, determinant.blind_pairs):
        root, note = model.root(item, friction)
        roots.append(root)
        if note is None and item.multiplicity > 1 and root.verdict is not Verdict.NOT_A_SOLUTION:
            note = _double_root_note(root, item, s, tolerance)
        notes.extend([] if note is None else [note])
    return ThreeSensorSolution(tuple(roots), degree, tuple(notes))


@dataclass(frozen=True)
class _Model(Frozen):
    """Readings, in units of `scale`, as a function of position [depths from the middle] and N, T [E * depth]."""

    s: FloatArray
    e: FloatArray
    kappa: float
    constant: float
    blind_pairs: tuple[BlindPair, ...]
    middle: float
    depth: float
    scale: float
    stiffness: float

    def root(self, item: RealRoot, mu: float) -> tuple[Root, Note | None]:
        """The load at a root, found from all three readings by least squares."""
        t = self.s - item.position
        q = 1 + t * t
        h = 1 - self.kappa * t * t
        g = -self.constant * h / q**2
        position = self.middle + self.depth * item.position
        blind = self._blind(item.position)
        residual = float(np.abs(self.e[blind]).max(initial=0.0))
        if blind.any() and (item.multiplicity == 1 or residual > _BLIND_READING):
            nothing = Sensitivity(np.nan, np.nan, np.nan)
            false = Verdict.NOT_A_SOLUTION
            return Root(position, np.nan, np.nan, false, item.multiplicity, residual, 0.0, nothing), None
        g = np.where(blind, 0.0, g)
        reach = max(1.0, float(np.abs(t).max()))  # columns of like size, else a distant load costs digits
        matrix = g[:, None] * np.stack([np.ones(3), t / reach], axis=-1)
        solution = np.linalg.lstsq(matrix, self.e)[0]
        n, tangential = float(solution[0]), float(solution[1] / reach)

        slope = self.constant * 2 * t * (self.kappa * q + 2 * h) / q**3  # dg/dt
        jacobian = np.stack([-slope * (n + t * tangential) - g * tangential, g, g * t], axis=-1)
        singular = item.multiplicity > 1 or bool(blind.any())
        rows = np.full(3, np.inf) if singular else _sensitivity(jacobian, n, tangential)
        with np.errstate(over="ignore"):
            rows = rows * np.array([self.depth, self.scale * self.stiffness, 1.0]) / self.scale
        root = Root(
            position=position,
            force=self.scale * self.stiffness * float(np.hypot(n, tangential)),
            angle=float(np.arctan2(tangential + 0.0, n)),  # -0.0 would turn pi into -pi
            verdict=_verdict(n, tangential, mu),
            multiplicity=item.multiplicity,
            residual=float(np.abs(matrix @ solution - self.e).max()),
            det_jacobian=self.scale * float(np.linalg.det(jacobian)),
            sensitivity=Sensitivity(*rows.tolist()),
        )
        if not blind.any():
            return root, None
        text = f"only one sensor feels a load at y = {position:.6g} m; the least force is given"
        return root, Note(Degeneracy.FORCE_UNDETERMINED, text)

    def _blind(self, position: float) -> npt.NDArray[np.bool_]:
        """Which sensors feel nothing of a load at `position`, if two of them do; none otherwise."""
        blind = np.zeros(3, dtype=bool)
        for pair in self.blind_pairs:
            if abs(position - pair.position) <= _BLIND_PLACE:
                blind[[pair.low, pair.high]] = True
        return blind


def _verdict(n: float, t: float, mu: float) -> Verdict:
    if n < 0:
        return Verdict.PULLS
    return Verdict.SLIPS if abs(t) > mu * n * (1 + _CONE_SLACK) else Verdict.ACCEPTED


def _sensitivity(jacobian: FloatArray, n: float, t: float) -> FloatArray:
    """Norms of the rows of d(position, P, angle) / d(readings), in the model's units."""
    try:
        inverse = np.linalg.inv(jacobian)
    except np.linalg.LinAlgError:
        return np.full(3, np.inf)
    p = float(np.hypot(n, t))
    turn = np.array([[1, 0, 0], [0, n / p, t / p], [0, -t / p**2, n / p**2]])
    return np.asarray(np.linalg.norm(turn @ inverse, axis=1))


def _with_blind_positions(found: list[RealRoot], pairs: tuple[BlindPair, ...]) -> list[RealRoot]:
    """The roots in order, those that were divided out put back; one that is met again counts once more."""
    roots = list(found)
    for pair in pairs:
        same = [root for root in roots if abs(root.position - pair.position) <= _BLIND_PLACE]
        roots = [root for root in roots if root not in same]
        roots.append(RealRoot(pair.position, 1 + sum(root.multiplicity for root in same)))
    return sorted(roots)


def _geometry_notes(s: FloatArray, kappa: float, pairs: tuple[BlindPair, ...]) -> list[Note]:
    """What is special about the positions s, in depths from the middle sensor."""
    memo = kappa == 1 and abs(s[0] + s[2]) <= SAME * (s[2] - s[0])  # the memo's case: nu = 1/2, equal pitch
    if memo and abs(s[2] - np.sqrt(3)) <= SAME * s[2]:
        text = "over the middle sensor the Jacobian is singular at every angle"
        return [Note(Degeneracy.PITCH_IS_SQRT3_DEPTHS, text)]
    if memo and len(pairs) == 2:
        text = "halfway between neighbours both are blind: two false roots whatever the readings"
        return [Note(Degeneracy.PITCH_IS_TWO_DEPTHS, text)]
    if memo and pairs:
        text = "the outer sensors are both blind to the middle: a false root there whatever the readings"
        return [Note(Degeneracy.PITCH_IS_DEPTH, text)]
    text = "sensors {} and {} are both blind to the position halfway between: a false root whatever the readings"
    return [Note(Degeneracy.BLIND_TOGETHER, text.format(p.low + 1, p.high + 1)) for p in pairs]


def _degree_text(degree: int, nominal: int) -> str:
    if nominal == 8 and degree == 7:
        return "7 in place of 8, the readings lie on a line along y: one root has gone to infinity"
    if nominal == 8 and degree == 6:
        return "6 in place of 8, the readings are all equal: two roots have gone to infinity"
    return f"{degree} in place of {nominal}: roots have gone to infinity"


def _double_root_note(root: Root, item: RealRoot, s: FloatArray, tol: float) -> Note:
    near = max(np.sqrt(tol), 1e-6)
    over = abs(item.position) <= near and abs(s[0] + s[2]) <= SAME * (s[2] - s[0])
    if over and abs(root.tangential_force) <= near * abs(root.normal_force):
        text = "the Jacobian vanishes; the position's error goes with the square root of the readings' error"
        return Note(Degeneracy.NORMAL_LOAD_OVER_MIDDLE, text)
    text = f"at y = {root.position:.6g} m the Jacobian vanishes and two loads coincide"
    return Note(Degeneracy.DOUBLE_ROOT, text)
