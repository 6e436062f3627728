"""Readings -> how probable each kind of contact is, and the kind, or "cannot tell"."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import numpy.typing as npt

from .. import _check
from .._check import FloatArray
from .._shown import Drawing
from ..errors import InvalidValueError
from ..estimate.answer import FrameTable, Status
from ..estimate.area.search import search_of
from ..estimate.estimate import unit_column
from ..estimate.evidence import EDGE, END, RECTANGLES, AreaEvidence, Evidence, Kind
from ..estimate.evidence.base import CHI2, LOCAL, LOG_EVIDENCE, LONG, STATUS, Columns
from ..estimate.locate import row_locator
from ..estimate.shown import Shown
from ..finger import Finger, finger_needed
from ..loads import Load
from ..prepared import prepared

__all__ = ["UNDECIDED", "TypeDecision", "contact_type", "usual_kinds"]

UNDECIDED = -1
"""In place of a kind's number where no kind is probable enough."""
_AMBIGUITY = 13.8
"""A load beyond the search whose chi-square is within this of the kind's speaks against it, as in `locate`."""
_SEARCHED, _FARTHEST = 0.5, 8.0
"""Depths beside the row: up to which kinds are searched, and up to which a load is thought of, as in `locate`."""

_WEDGE, _PUNCH, _HERTZ = 6**0.5, 2**0.5, 4**0.5
"""Half width over that root: the second moment is a^2/6, a^2/2, a^2/4 (docs/deciding.md)."""
_KINDS = (
    ("line", "line", (0.0, 0.0), 1.0),
    ("vertex", "wedge", (0.1, _WEDGE * EDGE), 1.0),
    ("flat side", "punch", (_PUNCH * EDGE, _PUNCH * END), 1.0),
    ("round side", "hertz", (_HERTZ * EDGE, _HERTZ * END), 1.0),
    ("two touches", "pair", (0.25, 1.5), 0.2),
    ("none of these", "none", (0.0, 0.0), 0.8),
)
"""Name, family, half widths in depths, and prior, of the usual kinds."""
_STICK = 0.3
"""Share of rollers that stick in their middle."""
_CONE, _DISC, _BALL = 6**0.5, 3**0.5, 5**0.5
"""On an area, half width over the root of the second moment along one direction: a^2/6, a^2/3, a^2/5."""
_LAST = 0.6
"""Where the sides end there."""
_LONG, _BAR = (0.6, 2.0), 2**-0.5
"""Half lengths of an edge there, in depths; its largest half width over the least of these: then the second moment
along it is at least twice that across."""
_LOCAL_KINDS = (
    ("point", "point", (0.0, 0.0), 1.0),
    ("vertex", "cone", (0.1, _CONE * EDGE), 1.0),
    ("flat side", "round_punch", (_DISC * EDGE, _DISC * _LAST), 1.0),
    ("round side", "round_hertz", (_BALL * EDGE, _BALL * _LAST), 1.0),
    ("edge", "edge", (0.0, _BAR * _LONG[0]), 1.0),
    ("none of these", "none", (0.0, 0.0), 0.4),
)


def usual_kinds(finger: Finger) -> tuple[Kind, ...]:
    """A line, a vertex (wedge), a flat and a round side, equally likely; two touches and none of these, less likely.

    The edges are stated in depths of the shallowest sensor of `finger`. A vertex is any contact that is narrower than
    a roller of half width 0.4, a flat bar of 0.28 or a wedge of 0.49: these have the same second moment of pressure. A
    side is any wider contact, up to a roller of 2.4 or a bar of 1.7; three in ten rollers stick in their middle. A line
    is narrower than a wedge of 0.1. Two touches are 0.5 to 3 apart, and a fifth as likely as a line; none of these,
    four fifths as likely.

    Of sensors on an area a point, a vertex (cone), a flat and a round side (disc and sphere), and an edge, equally
    likely; none of these, two fifths as likely, half of it two touches. A vertex is narrower than a sphere of half
    width 0.45, a disc of 0.35 or a cone of 0.49; a side is any wider contact, up to a sphere of 1.34 or a disc of 1.04.
    An edge is at least 1.4 times as long as wide: its half length is 0.6 to 2, its half width at most 0.42, its
    direction any.

    Examples
    --------
    >>> import subskin as ss
    >>> skin = ss.HalfPlane(ss.Material(young=0.4e6))
    >>> finger = ss.Finger(skin, ss.SensorArray.line(count=4, pitch=1e-3, depth=2e-3))
    >>> [kind.name for kind in ss.decide.usual_kinds(finger)]
    ['line', 'vertex', 'flat side', 'round side', 'two touches', 'none of these']
    """
    finger_needed(finger)
    depth = float(np.asarray(finger.array.depth).min())
    kinds = _LOCAL_KINDS if finger.array.on_area else _KINDS
    return tuple(
        Kind(
            name,
            family,
            (a * depth, b * depth),
            prior,
            stick=_STICK if family == "hertz" else 0.0,
            half_length=(_LONG[0] * depth, _LONG[1] * depth) if family in RECTANGLES else (0.0, 0.0),
        )
        for name, family, (a, b), prior in kinds
    )


@dataclass(frozen=True, eq=False, repr=False)
class TypeDecision(FrameTable):
    """What kind of contact pressed in each frame; every field has the batch's shape (...).

    Parameters
    ----------
    table : ndarray, shape (..., 1 + 6 kinds), on an area (..., 1 + 11 kinds)
        The packed results, in columns of their own units; read them by name.
    used : ndarray of bool, shape (..., n)
        Which sensors each frame's answer rests on.
    kinds : tuple of Kind
        Those that were weighed against each other.
    sure : float
        Probability from which on a kind is decided for.
    friction : float
        The cone that was searched, |tan(angle)| <= friction [-].
    columns : Columns
        Where in the table what stands: `LONG` or `LOCAL`.
    relative : bool
        Whether forces are multiples of the load of the touches of a calibration, as of the finger.
    """

    kinds: tuple[Kind, ...]
    sure: float
    friction: float = 1.0
    columns: Columns = LONG
    relative: bool = False

    plot = Drawing("probability_strip")

    def _said(self) -> tuple[npt.NDArray[Any], dict[int, str]]:
        words, codes = np.unique(self.name, return_inverse=True)
        return codes.reshape(self.shape), dict(enumerate(words.tolist()))

    def _shown(self) -> list[Shown]:
        none = np.full(self.shape, np.nan)
        share = np.moveaxis(self.probability, -1, 0)
        shown = [Shown(f"p({name})", p, none, "") for name, p in zip(self.names, share, strict=True)]
        if np.isfinite(self.direction).any():
            shown.append(Shown("direction", np.rad2deg(self.direction), np.rad2deg(self.direction_std), "deg"))
        return shown

    def _columns(self) -> dict[str, Any]:
        share = np.moveaxis(self.probability, -1, 0)
        each = {f"p_{name}".replace(" ", "_"): p for name, p in zip(self.names, share, strict=True)}
        found = {key: getattr(self, key) for key in ("position", "force", "angle", "half_width", "residual")}
        if self.columns is LOCAL:
            y, z = np.moveaxis(found.pop("position"), -1, 0)
            more = {key: getattr(self, key) for key in ("azimuth", "half_length", "direction", "direction_std")}
            found = {"position_y": y, "position_z": z, **found, **more}
        return {"kind": self.name, **each, **found, **super()._columns(), **unit_column(self.shape, self.relative)}

    @property
    def names(self) -> tuple[str, ...]:
        """The kinds' names."""
        return tuple(kind.name for kind in self.kinds)

    def _each(self, column: int) -> FloatArray:
        return self.table[..., self.columns.first + column :: self.columns.each]

    @property
    def log_evidence(self) -> FloatArray:
        """Log of the evidence of each kind, up to what all have in common, shape (..., kinds)."""
        return self._each(LOG_EVIDENCE)

    @property
    def probability(self) -> FloatArray:
        """Probability of each kind after the readings, shape (..., kinds); NaN where `status` says there is none."""
        evidence = self._each(LOG_EVIDENCE) + np.log([kind.prior for kind in self.kinds])
        known = np.isfinite(evidence).any(axis=-1, keepdims=True)
        evidence = np.where(known, evidence, 0.0)
        share = np.exp(evidence - evidence.max(axis=-1, keepdims=True))
        return _check.read_only(np.where(known, share / share.sum(axis=-1, keepdims=True), np.nan))

    @property
    def best(self) -> npt.NDArray[np.intp]:
        """Number of the most probable kind, however probable; `UNDECIDED` (-1) where there is no answer."""
        share = self.probability
        return np.asarray(np.where(np.isfinite(share[..., 0]), np.argmax(share, axis=-1), UNDECIDED))

    @property
    def decision(self) -> npt.NDArray[np.intp]:
        """Number of the kind decided for; `UNDECIDED` (-1) where none is as probable as `sure`.

        Also where a load beyond the default search explains the frame about as well.
        """
        share, elsewhere = self.probability, self.table[..., STATUS] == Status.AMBIGUOUS
        with np.errstate(invalid="ignore"):
            sure = (share.max(axis=-1) >= self.sure) & ~elsewhere
        return np.asarray(np.where(sure, self.best, UNDECIDED))

    @property
    def name(self) -> npt.NDArray[np.str_]:
        """The decision in words: the kind's name, "cannot tell", or the status where there is no contact to name."""
        words = np.array([*self.names, "cannot tell"])[self.decision]
        none = {s: s.name.lower().replace("_", " ") for s in Status if s not in (Status.OK, Status.AMBIGUOUS)}
        choices = [self.status == s for s in none]
        return np.asarray(np.select(choices, [np.array(word) for word in none.values()], words))

    @property
    def status(self) -> npt.NDArray[np.int8]:
        """`Status` of each frame; `AMBIGUOUS` where no kind is decided for."""
        status = self.table[..., STATUS].astype(np.int8)
        unsure = (status == Status.OK) & (self.decision == UNDECIDED)
        return np.asarray(np.where(unsure, np.int8(Status.AMBIGUOUS), status))

    def _of_best(self, column: int) -> FloatArray:
        best = self.best[..., None]
        values = np.take_along_axis(self._each(column), np.maximum(best, 0), axis=-1)
        return _check.read_only(np.where(best >= 0, values, np.nan)[..., 0])

    @property
    def spare(self) -> npt.NDArray[np.intp]:
        """Readings beyond the unknowns of the most probable kind, "none of these" aside, shape (...).

        With 0 that kind could not have failed to explain them.
        """
        unknowns = np.array([kind.unknowns(self.friction) for kind in self.kinds])
        share = np.where(unknowns > 0, np.nan_to_num(self.probability), -1.0)
        count = self.used.sum(axis=-1) - unknowns[np.argmax(share, axis=-1)]
        return np.asarray(np.where(self.best >= 0, np.maximum(count, 0), 0))

    @property
    def residual(self) -> FloatArray:
        """Least chi-square of the most probable kind; NaN, as all that follows, where that is none of the others."""
        return self._of_best(CHI2)

    @property
    def position(self) -> FloatArray:
        """Position y of the most probable kind's best contact [m], on an area (..., 2); of two touches, midway."""
        at = [self._of_best(column) for column in self.columns.position]
        return at[0] if len(at) == 1 else _check.read_only(np.stack(at, axis=-1))

    @property
    def load(self) -> Load:
        """Its position and components; of two touches their resultant."""
        parts = np.stack([self._of_best(column) for column in self.columns.components], axis=-1)
        return Load(self.position, _check.read_only(parts))

    @property
    def force(self) -> FloatArray:
        """Its magnitude [N/m], on an area [N]; of two touches, that of their resultant."""
        return self.load.force

    @property
    def angle(self) -> FloatArray:
        """Its angle from the inward normal [rad]."""
        return self.load.angle

    @property
    def azimuth(self) -> FloatArray:
        """Direction of its drag [rad], as of `Load.azimuth`."""
        return self.load.azimuth

    @property
    def half_width(self) -> FloatArray:
        """Its half width [m]; 0 of a line or a point; half the distance of two touches."""
        return self._of_best(self.columns.half_width)

    def _of_edge(self, number: int) -> FloatArray:
        if not self.columns.edge:
            return _check.read_only(np.full(self.shape, np.nan))
        return self._of_best(self.columns.edge[number])

    @property
    def half_length(self) -> FloatArray:
        """Its half length [m], of an edge on an area; NaN, as what follows, where the most probable kind is no edge."""
        return self._of_edge(0)

    @property
    def direction(self) -> FloatArray:
        """Direction of the edge, from +y towards +z, in [0, pi) [rad]."""
        return self._of_edge(1)

    @property
    def direction_std(self) -> FloatArray:
        """Its standard error [rad]; at most pi / sqrt(12), where it may be any."""
        return self._of_edge(2)


def contact_type(
    finger: Finger,
    readings: npt.ArrayLike,
    kinds: Sequence[Kind] | None = None,
    *,
    sure: float = 0.95,
    search: Any = None,
    friction: float = 1.0,
    false_alarm: float = 1e-6,
) -> TypeDecision:
    """What kind of contact pressed, from readings of shape (..., n), by Bayesian evidence.

    For each kind the likelihood of the readings is averaged over the unknowns: position, evenly over `search`; half
    width, evenly over the kind's range; half length and direction of an edge on an area, evenly; angle, evenly within
    the friction cone; force, evenly on a logarithmic scale. Times the kind's prior this is its probability, up to a
    common factor. The averages are prepared on the first call and kept with the finger. "None of these" is a contact of
    another shape or width, or near to one of the kinds but for a model error; it is noticed where readings are left
    beyond the unknowns (`TypeDecision.spare`).
    Source: docs/deciding.md; MacKay, Information Theory, Inference, and Learning Algorithms (2003), chapter 28.

    Parameters
    ----------
    finger : Finger
        The forward model, with the sensors' noise: at least four sensors, three where friction is 0.
    readings : array_like, shape (..., n)
        Raw readings, each in its sensor's unit; NaN marks a missing one.
    kinds : sequence of Kind, optional
        What may have pressed; `usual_kinds` by default.
    sure : float, optional
        Probability from which on a kind is decided for, in (0.5, 1).
    search : (float, float) or ((float, float), (float, float)), optional
        Where contacts may be, y [m], or y and z; from half a depth before the first sensor to half a depth after the
        last. Without it, a line load farther out that explains a frame as well as its kind leaves it undecided.
    friction : float, optional
        |tan(angle)| is at most this [-].
    false_alarm : float, optional
        Chance that noise alone is called a contact, or that a contact of one of the kinds is called unexplained.

    Returns
    -------
    TypeDecision
        Probabilities, decision, the best contact of the most probable kind, status, each of shape (...).

    Raises
    ------
    InvalidValueError, GeometryError
        Sensors without noise, kinds of one name, widths out of order, a last axis that is not the sensors.

    Examples
    --------
    >>> import numpy as np, subskin as ss
    >>> skin = ss.HalfPlane(ss.Material(young=0.4e6))
    >>> finger = ss.Finger(skin, ss.SensorArray.line(count=6, pitch=1e-3, depth=2e-3, noise=2e-5))
    >>> edge = ss.Wedge(force=40.0, angle=0.3, position=0.4e-3, half_width=0.5e-3)
    >>> said = ss.decide.contact_type(finger, finger.read(edge, rng=np.random.default_rng(0)))
    >>> str(said.name), bool(said.probability[1] > 0.99)
    ('vertex', True)
    """
    _check.scalar("sure", sure, above=0.5)
    if not sure < 1:
        raise InvalidValueError(f"sure = {sure}", "has to be in (0.5, 1)", "sure=0.95")
    finger_needed(finger)
    if isinstance(kinds, Kind | str):
        raise InvalidValueError(f"kinds = {kinds!r}", "several kinds are weighed", "kinds=(Kind(...), Kind(...))")
    fix = 'kinds=(Kind("vertex", "wedge", ...), ...)'
    if kinds is None:
        chosen = prepared(finger).get(("usual kinds",), lambda: usual_kinds(finger))
    else:
        chosen = _check.several("kinds", kinds, Kind, fix)
    on_area = finger.array.on_area
    if on_area and finger.measured is not None:
        rule = "a response measured in place knows the contact of its touches alone"
        raise InvalidValueError("the kind of a contact", rule, "finger.locate(readings)")
    ends: Any = None
    if search is not None:
        fix = "search=(-5e-3, 5e-3)"
        ends = search_of(finger.array, search)[0] if on_area else _check.ends("search", search, fix)
    mu, alarm = _check.values(friction=friction, false_alarm=false_alarm).values()

    def make() -> Evidence | AreaEvidence:
        kind: Any = AreaEvidence if on_area else Evidence
        made: Evidence | AreaEvidence = kind(finger, chosen, search=ends, friction=friction, false_alarm=false_alarm)
        return made

    key = ("evidence", chosen, None if ends is None else np.asarray(ends).tobytes(), mu, alarm)
    table, used = prepared(finger).get(key, make)(readings)
    layout = LOCAL if on_area else LONG
    said = TypeDecision(table, used, chosen, float(sure), float(friction), layout, finger.relative)
    if on_area or ends is not None or finger.measured is not None:
        return said
    return _looked_around(finger, said, readings)


def _looked_around(finger: Finger, said: TypeDecision, readings: npt.ArrayLike) -> TypeDecision:
    """The same, AMBIGUOUS where a line load beyond the search explains a frame about as well as its kind."""
    asked = (said.status == Status.OK) & np.isfinite(said.residual)
    y, deepest = np.asarray(finger.array.y), float(np.max(finger.array.depth))
    near = _SEARCHED * deepest
    # about a finger that is round, what is far off comes back
    far = min(_FARTHEST * deepest, 0.5 * (finger.skin.period - float(np.ptp(y))))
    if not asked.any() or not far > near:
        return said
    frames = np.where(said.used, _check.readings(readings), np.nan)[asked]
    sides = ((y.min() - far, y.min() - near), (y.max() + near, y.max() + far))
    left = [row_locator(finger, search=side, friction=said.friction)(frames).residual for side in sides]
    table = np.array(said.table)
    rival = np.fmin(*left) <= said.residual[asked] + _AMBIGUITY
    table[asked, STATUS] = np.where(rival, Status.AMBIGUOUS, Status.OK)
    return replace(said, table=table)
