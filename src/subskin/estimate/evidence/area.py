"""Readings on an area -> how probable each kind of contact makes them: what `decide.contact_type` weighs."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from ..._check import FloatArray
from ...array import SensorArray
from ...contact import PointLoad, RoundContact, RoundHertz
from ...contact.families import local_family_of
from ...finger import Finger
from ...radial import tabulate_radial
from ...radial_round import tabulate_round
from ..answer import Status
from ..area.judge import Settings
from ..area.locator import RoundLocator
from ..area.observable import refuse_blind
from ..area.point import PointModel, tabulated
from ..area.rectangle import RectangleModel, rules
from ..area.round_contact import model_of
from ..area.search import search_of
from .base import CHI2, LOCAL, LOG_EVIDENCE, STATUS, Weighing
from .kind import PAIR, RECTANGLES, Kind

__all__ = ["AreaEvidence"]

_NODES, _EDGE_NODES = 6, 4
"""Of Gauss and Legendre's rule over the half width, on each side of the best; over an edge's length and width."""
_LONG = 0.02
"""Wavenumber, over the half width, at which a spectrum is 1 less its square and half the second moment of the shape."""
_PAIRS, _GAP, _NEAR = 0.5, (0.25, 1.5), 12.0
"""Share of two touches in what is none of the kinds, beside edges; half their distance, in depths; they are weighed
where an edge is not less likely than the likeliest kind by more than this, in logarithms."""
_FORCES = (0.5, 0.3, 0.7)
"""Of two touches, the share of the force on the first."""
_BEYOND = 0.5
"""Depths beyond the outermost sensors up to which contacts are, if nothing else is said."""
_LARGEST = 1e100
"""Noises: what reads more is unexplained as well, and sums of squares stay finite."""
_NARROW = 0.1
"""Depths up to which half widths of edges are looked at in any case."""


class AreaEvidence(Weighing):
    """The log of the probability of frames of readings under each kind of contact on an area; prepared once.

    Half widths are integrated over by a rule, position and forces by Laplace's method: positions alike over the search,
    half widths alike over the kind's range, magnitudes alike on a logarithmic scale (docs/deciding.md).

    Parameters
    ----------
    finger : Finger
        The forward model, with the sensors' noise, on an area.
    kinds : sequence of Kind
        At least one of a family on an area; at most one "none".
    search : ((float, float), (float, float)), optional
        Where contacts may be [m]; the default reaches half a depth beyond the outermost sensors.
    friction, false_alarm
        As of `Evidence`.

    Raises
    ------
    InvalidValueError, GeometryError
        Sensors without noise, kinds of one name, two touches, sensors that leave a position or a force open.

    Examples
    --------
    >>> import subskin as ss
    >>> array = ss.SensorArray.grid((3, 3), pitch=2e-3, depth=2e-3, noise=1e-4)
    >>> finger = ss.Finger(ss.HalfSpace(ss.Material(young=0.4e6)), array)
    >>> evidence = AreaEvidence(finger, [Kind("tip", "point"), Kind("coin", "round_punch", half_width=(1e-3, 2e-3))])
    >>> table, used = evidence(finger.read(ss.PointLoad(force=1.0)))
    >>> bool(table[1] > table[12])  # the logarithms of their probabilities
    True
    """

    _layout_of = LOCAL
    _example = 'Kind("ball", "round_hertz", ...)'
    _misplaced = (
        (PAIR,),
        "two touches are no kind on an area: there they are none of the others",
        'Kind("none of these", "none")',
    )

    def __init__(
        self,
        finger: Finger,
        kinds: Sequence[Kind],
        *,
        search: Any = None,
        friction: float = 1.0,
        false_alarm: float = 1e-6,
    ) -> None:
        super().__init__(finger, kinds, friction=friction, false_alarm=false_alarm, needed=(4, 6))
        refuse_blind(finger)
        array, depth = finger.array, self._shallowest
        if search is None:
            reach, points = _BEYOND * float(np.asarray(array.depth).max()), array.points
            search = np.stack([points.min(axis=0) - reach, points.max(axis=0) + reach], axis=-1)
        self._box = search_of(array, search)[0]
        self._gap = (_GAP[0] * depth, _GAP[1] * depth)
        self._families: list[Any] = [_tabulated(self._kind(j).family) for j in range(len(self._single))]
        radius = np.sqrt(2.0) * max(float(np.abs(array.points - corner).max()) for corner in self._box.T)
        radius += max(kind.half_length[1] for kind in self.kinds)
        widest = max(1.5 * depth, *(kind.half_width[1] for kind in self.kinds))
        every: set[Any] = {RoundHertz, *(kind for kind in self._families if kind is not None)}
        tables = {kind: tabulate_round(finger, kind, radius, widest) for kind in every}
        flat = tabulate_radial(finger, radius + max(kind.half_width[1] for kind in self.kinds))
        self._tables: list[Any] = [flat if kind is None else tables[kind] for kind in self._families]
        (y, z) = (tuple(ends) for ends in self._box.tolist())
        widths = (0.0, widest)
        self._first = _Loose(tables[RoundHertz], array, (y, z), widths, friction=friction, false_alarm=false_alarm)

    def _kernel(self) -> Any:
        return self._weigh

    def _prepare(self, pattern: npt.NDArray[np.bool_]) -> tuple[Any, ...]:
        from scipy.special import chdtri

        array, spare = self.array.select(pattern), self._spare(int(pattern.sum()))
        models: list[Any] = []
        edges: list[RectangleModel] = []
        for j, table in enumerate(self._tables):
            if self._kind(j).family in RECTANGLES:
                edges.append(_edge_model(tabulated(table.select(pattern), array)[0], self._shallowest, self._kind(j)))
                models.append(edges[-1])
            else:
                models.append(model_of(table.select(pattern), array))
        most = np.array([float(chdtri(max(k, 1), self._false_alarm)) for k in spare])
        pairs = _pair_models(edges[0]) if edges and self._none >= 0 else []
        return array, pattern, models, pairs, np.maximum(spare, 0), most

    def _weigh(
        self,
        frames: FloatArray,
        array: SensorArray,
        pattern: npt.NDArray[np.bool_],
        models: list[Any],
        pairs: list[RectangleModel],
        spare: npt.NDArray[np.intp],
        most: FloatArray,
        out: FloatArray,
    ) -> None:
        """Fill `out`, one row a frame."""
        from ._area_kernel import FOUND, WEIGHED, weigh_edge, weigh_round

        out[:] = np.nan
        usable = ((frames > np.asarray(array.low)) & (frames < np.asarray(array.high))).all(axis=1)
        with np.errstate(over="ignore"):
            w = np.clip((frames - np.asarray(array.offset)) / np.asarray(array.noise), -_LARGEST, _LARGEST)
        w[~usable] = 0.0  # these come again, without the sensors that are out
        total = (w * w).sum(axis=1)
        whole = np.full((len(frames), pattern.size), np.nan)
        whole[:, pattern] = frames
        found = self._first(whole)
        near = np.full(len(frames), np.nan, FOUND)
        (near["y"], near["z"]), near["half_width"] = found.position.T, found.half_width
        rule, short = (_rule(count) for count in (_NODES, _EDGE_NODES))
        parts, largest = np.empty((len(models), len(frames)), WEIGHED), np.full(len(frames), -np.inf)
        # edges last: they ask how likely the others are
        for j in sorted(range(len(models)), key=lambda j: self._kind(j).family in RECTANGLES):
            kind, box = self._kind(j), self._box_of(self._kind(j))
            if kind.family in RECTANGLES:
                weigh_edge(w, near, models[j], self.friction, box, largest, short, parts[j])
            else:
                weigh_round(w, near, models[j], self.friction, box, _ratio(self._families[j]), rule, parts[j])
            largest = np.maximum(largest, parts[j]["log_evidence"])
            out[:, self._slot(j) : self._slot(j) + LOCAL.each] = parts[j].view(float).reshape(-1, LOCAL.each)
        slots = np.array([self._slot(j) for j in range(len(models))])
        evidence, chi2 = out[:, slots + LOG_EVIDENCE] - 0.5 * total[:, None], out[:, slots + CHI2]
        explained = np.isfinite(evidence) & (chi2 <= most)
        evidence = np.where(explained, evidence, -np.inf)
        if self._none >= 0:
            none = self._of_none(evidence, chi2, total / len(array), spare)
            if pairs:
                edges = parts[[self._kind(j).family in RECTANGLES for j in range(len(models))]]
                edge = edges[edges["log_evidence"].argmax(axis=0), np.arange(len(frames))]
                likely = edge["log_evidence"] > largest - _NEAR
                two = self._of_pairs(w[likely], edge[likely], pairs, short) - 0.5 * total[likely]
                none += np.log1p(-_PAIRS)
                none[likely] = np.logaddexp(none[likely], two + np.log(_PAIRS))
            out[:, LOCAL.first + self._none * LOCAL.each] = none
        out[:, slots + LOG_EVIDENCE] = evidence
        status = np.where(explained.any(axis=1), Status.OK, Status.UNEXPLAINED)
        status = np.where(found.status == Status.NO_CONTACT, Status.NO_CONTACT, status)
        nothing = status != Status.OK
        out[nothing] = np.nan
        out[nothing, LOCAL.first :: LOCAL.each] = -np.inf
        out[:, STATUS] = np.where(usable, status, -1)

    def _box_of(self, kind: Kind) -> FloatArray:
        """Ends of the unknowns of a kind: y, z, and the half width's square; of an edge as in `RectangleAt`."""
        of_edge = kind.family in RECTANGLES
        turned, even = ((-np.inf, np.inf, *kind.half_length), np.zeros(6)) if of_edge else ((), ())
        return np.array([*self._box.reshape(-1), *turned, *np.square(kind.half_width), *even])

    def _of_none(
        self, evidence: FloatArray, chi2: FloatArray, power: FloatArray, spare: npt.NDArray[np.intp]
    ) -> FloatArray:
        """Log of the evidence of what is near to one of the kinds, were the noise larger by a model error.

        What fits is as much more as the noise is larger, so that only the spare readings pay.
        """
        from ._kernel import ERRORS

        inflated = 1 + ERRORS**2 * power[:, None, None]  # (f, 1, errors)
        left = np.where(np.isfinite(evidence), chi2, 0.0)[..., None]
        share = np.log(self._shares() / ERRORS.size)
        here = (evidence + share)[..., None] + 0.5 * left * (1 - 1 / inflated)
        return np.asarray(np.logaddexp.reduce(here - 0.5 * spare[:, None] * np.log(inflated), axis=(1, 2)))

    def _of_pairs(
        self, w: FloatArray, edge: Any, pairs: list[RectangleModel], rule: tuple[FloatArray, ...]
    ) -> FloatArray:
        """Log of the evidence of two touches that read like an edge, about those of its second moment."""
        from ._area_kernel import FOUND, WEIGHED, weigh_edge

        near, floor, part = np.zeros(len(w), FOUND), np.full(len(w), np.inf), np.empty(len(w), WEIGHED)
        for name in ("y", "z", "direction"):
            near[name] = edge[name]
        near["length"] = edge["length"] / np.sqrt(3)
        box, found = self._box_of(Kind("two touches", "edge", half_length=self._gap)), np.empty((len(pairs), len(w)))
        for each, model in zip(found, pairs, strict=True):
            weigh_edge(w, near, model, self.friction, box, floor, rule, part)
            each[:] = part["log_evidence"]
        return np.asarray(np.logaddexp.reduce(found, axis=0) - np.log(len(pairs)))


class _Loose(RoundLocator):
    """Finds the nearest sphere, however little it explains."""

    def _settings(self, array: Any, response: Any, error: float, told: float = np.inf) -> Settings:
        return super()._settings(array, response, error, told)._replace(largest=1e300)


def _rule(count: int) -> tuple[FloatArray, FloatArray]:
    """Nodes and weights of Gauss and Legendre's rule on (0, 1)."""
    nodes, weights = np.polynomial.legendre.leggauss(count)
    return 0.5 * (1 + nodes), 0.5 * weights


def _tabulated(family: Any) -> type[RoundContact] | None:
    """Of which round contacts the readings of a kind are made: a point is a sphere of no width; an edge of none."""
    if family in RECTANGLES:
        return None
    kind = local_family_of(family)
    return RoundHertz if issubclass(kind, PointLoad) else kind


def _ratio(family: type[RoundContact]) -> float:
    """Half width of a family's contact over a sphere's with the same second moment of pressure along one direction."""
    sphere, other = (
        1 - float(kind(1.0, half_width=1.0).disc_spectrum(np.array(_LONG))) for kind in (RoundHertz, family)
    )
    return float(np.sqrt(sphere / other))


def _edge_model(points: PointModel, depth: float, kind: Kind) -> RectangleModel:
    """What climbs over rectangles of a kind go by; `depth` of the shallowest sensor."""
    along, across = (rules(half, depth) for half in (kind.half_length[1], max(kind.half_width[1], _NARROW * depth)))
    return RectangleModel(points, along, across, depth, 0.0, np.empty((0, 0)))


def _pair_models(model: RectangleModel) -> list[RectangleModel]:
    """The same of two touches, in place of an edge's two ends, about the middle of their force."""
    found, one = [], np.zeros((2, 2, 1))
    one[1, 1] = 2.0
    for share in _FORCES:
        middle = 1 - 2 * share
        two = np.zeros((3, 2, 2))
        two[2] = [[-1 - middle, 1 - middle], [2 * share, 2 - 2 * share]]
        found.append(model._replace(along=two, across=one))
    return found
