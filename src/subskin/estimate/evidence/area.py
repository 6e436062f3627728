"""Readings on an area -> how probable each kind of contact makes them: what `decide.contact_type` weighs."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from ... import _check
from ..._check import FloatArray
from ...contact import PointLoad, RoundContact, RoundHertz
from ...contact.families import local_family_of
from ...errors import InvalidValueError
from ...finger import Finger
from ...radial_round import tabulate_round
from ..area.edge import EdgeModel
from ..area.judge import Settings
from ..area.locator import RoundLocator, search_of
from ..area.observable import refuse_blind
from ..area.round_contact import model_of
from ..estimate import Status
from ..frames import Framewise
from .columns import LOCAL, STATUS
from .edge import edge_box, edge_model, pair_models
from .kind import NONE, PAIR, STRETCH, Kind

__all__ = ["AreaEvidence"]

_NODES, _EDGE_NODES = 6, 4
"""Of Gauss and Legendre's rule over the half width, on each side of the best; over an edge's length and width."""
_ERRORS = np.array([0.01, 0.03, 0.1, 0.3])
"""As in a plane: model errors of what is none of the kinds, in shares of the readings' root mean square."""
_LONG = 0.02
"""Wavenumber, over the half width, at which a spectrum is 1 less its square and half the second moment of the shape."""
_PAIRS, _GAP, _NEAR = 0.5, (0.25, 1.5), 12.0
"""Share of two touches in what is none of the kinds, beside edges; half their distance, in depths; they are weighed
where an edge is not less likely than the likeliest kind by more than this, in logarithms."""
_BEYOND = 0.5
"""Depths beyond the outermost sensors up to which contacts are, if nothing else is said."""
_LARGEST = 1e100
"""Noises: what reads more is unexplained as well, and sums of squares stay finite."""


class AreaEvidence(Framewise):
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

    def __init__(
        self,
        finger: Finger,
        kinds: Sequence[Kind],
        *,
        search: Any = None,
        friction: float = 1.0,
        false_alarm: float = 1e-6,
    ) -> None:
        self.kinds = tuple(kinds)
        names, families = [kind.name for kind in self.kinds], [kind.family for kind in self.kinds]
        if len(set(names)) < len(names):
            raise InvalidValueError(f"kinds = {names}", "each needs its own name", 'Kind("ball", "round_hertz", ...)')
        if PAIR in families:
            rule = "two touches are no kind on an area: there they are none of the others"
            raise InvalidValueError('family = "pair"', rule, 'Kind("none of these", "none")')
        self._single = [i for i, family in enumerate(families) if family != NONE]
        none = [i for i, family in enumerate(families) if family == NONE]
        if not self._single or len(none) > 1:
            rule = 'at least one kind of a family, and at most one "none", can be weighed'
            raise InvalidValueError(f"families = {families}", rule, "leave the others out")
        self._none = none[0] if none else -1
        refuse_blind(finger)
        array = finger.array
        depth = float(np.asarray(array.depth).min())
        if search is None:
            reach, points = _BEYOND * float(np.asarray(array.depth).max()), array.points
            search = np.stack([points.min(axis=0) - reach, points.max(axis=0) + reach], axis=-1)
        self._box = search_of(array, search)[0]
        self._gap = (_GAP[0] * depth, _GAP[1] * depth)
        self.friction = _check.friction(friction)
        self._false_alarm = _check.scalar("false_alarm", false_alarm, above=0.0, at_most=0.5)
        size = LOCAL.first + LOCAL.each * len(names)
        super().__init__(array, needed=4 + 2 * (self.friction > 0), columns=size, status=STATUS)
        self.allow_for(finger, self.friction)
        self._families = [_tabulated(families[i]) for i in self._single]
        radius = np.sqrt(2.0) * max(float(np.abs(array.points - corner).max()) for corner in self._box.T)
        radius += max(kind.half_length[1] for kind in self.kinds)
        widest = max(1.5 * depth, *(kind.half_width[1] for kind in self.kinds))
        every: set[type[RoundContact]] = {RoundHertz, *self._families}
        tables = {kind: tabulate_round(finger, kind, radius, widest) for kind in every}
        self._tables = [tables[kind] for kind in self._families]
        (y, z) = (tuple(ends) for ends in self._box.tolist())
        widths = (0.0, widest)
        self._first = _Loose(tables[RoundHertz], array, (y, z), widths, friction=friction, false_alarm=false_alarm)

    def __call__(self, readings: npt.ArrayLike) -> tuple[FloatArray, npt.NDArray[np.bool_]]:
        """Packed results, shape (..., 1 + 11 kinds), and the sensors used, shape (..., n).

        Parameters
        ----------
        readings : array_like, shape (..., n)
            As in `Locator`.
        """
        return self._frames(readings)

    def _kind(self, number: int) -> Kind:
        """One of those that are a contact."""
        return self.kinds[self._single[number]]

    def _kernel(self) -> Any:
        return self._weigh

    def _prepare(self, pattern: npt.NDArray[np.bool_]) -> tuple[Any, ...]:
        from scipy.special import chdtri

        array = self.array.select(pattern)
        tables = [table.select(pattern) for table in self._tables]
        models = [
            edge_model(table, array, self._kind(j)) if self._kind(j).family == STRETCH else model_of(table, array)
            for j, table in enumerate(tables)
        ]
        spare = np.array([len(array) - self.kinds[i].unknowns(self.friction) for i in self._single])
        most = np.array([float(chdtri(max(k, 1), self._false_alarm)) for k in spare])
        edges = [model for model in models if isinstance(model, EdgeModel)]
        pairs = pair_models(edges[0]) if edges and self._none >= 0 else []
        return array, pattern, models, pairs, np.maximum(spare, 0), most

    def _weigh(
        self,
        frames: FloatArray,
        array: Any,
        pattern: npt.NDArray[np.bool_],
        models: list[Any],
        pairs: list[Any],
        spare: npt.NDArray[np.intp],
        most: FloatArray,
        out: FloatArray,
    ) -> None:
        """Fill `out`, one row a frame."""
        from ._area_kernel import weigh_kind
        from ._edge_kernel import weigh_edge

        out[:] = np.nan
        usable = ((frames > np.asarray(array.low)) & (frames < np.asarray(array.high))).all(axis=1)
        with np.errstate(over="ignore"):
            w = np.clip((frames - np.asarray(array.offset)) / np.asarray(array.noise), -_LARGEST, _LARGEST)
        w[~usable] = 0.0  # these come again, without the sensors that are out
        total = (w * w).sum(axis=1)
        whole = np.full((len(frames), pattern.size), np.nan)
        whole[:, pattern] = frames
        found = self._first(whole)
        at = np.column_stack([found.position, found.half_width])
        rule, short = (_rule(count) for count in (_NODES, _EDGE_NODES))
        parts = np.empty((len(self._single), len(frames), LOCAL.each))
        largest = np.full(len(frames), -np.inf)
        # edges last: they ask how likely the others are
        for j in sorted(range(len(parts)), key=lambda j: self._kind(j).family == STRETCH):
            kind, model, part = self._kind(j), models[j], parts[j]
            if kind.family == STRETCH:
                box = edge_box(self._box, kind)
                weigh_edge(w, at[:, :2], model, self.friction, box, largest, *short, part)
            else:
                box = np.array([*self._box.reshape(-1), *np.square(kind.half_width)])
                weigh_kind(w, at, model, self.friction, box, _ratio(self._families[j]), *rule, part)
            largest = np.maximum(largest, part[:, 0])
            slot = LOCAL.first + self._single[j] * LOCAL.each
            out[:, slot : slot + LOCAL.each] = part
        evidence, chi2 = parts[..., 0].T - 0.5 * total[:, None], parts[..., 1].T
        explained = np.isfinite(evidence) & (chi2 <= most)
        evidence = np.where(explained, evidence, -np.inf)
        if self._none >= 0:
            none = self._of_none(evidence, chi2, total / len(array), spare)
            if pairs:
                edge = self._best_edge(parts)
                near = edge[:, 0] > largest - _NEAR
                two = self._of_pairs(w[near], edge[near], pairs, short) - 0.5 * total[near]
                none += np.log1p(-_PAIRS)
                none[near] = np.logaddexp(none[near], two + np.log(_PAIRS))
            out[:, LOCAL.first + self._none * LOCAL.each] = none
        out[:, [LOCAL.first + i * LOCAL.each for i in self._single]] = evidence
        status = np.where(explained.any(axis=1), Status.OK, Status.UNEXPLAINED)
        status = np.where(found.status == Status.NO_CONTACT, Status.NO_CONTACT, status)
        nothing = status != Status.OK
        out[nothing] = np.nan
        out[np.ix_(nothing, [LOCAL.first + i * LOCAL.each for i in range(len(self.kinds))])] = -np.inf
        out[:, STATUS] = np.where(usable, status, -1)

    def _of_none(
        self, evidence: FloatArray, chi2: FloatArray, power: FloatArray, spare: npt.NDArray[np.intp]
    ) -> FloatArray:
        """Log of the evidence of what is near to one of the kinds, were the noise larger by a model error.

        What fits is as much more as the noise is larger, so that only the spare readings pay.
        """
        priors = np.array([self.kinds[i].prior for i in self._single])
        inflated = 1 + _ERRORS**2 * power[:, None]  # (f, errors)
        here = evidence[..., None] + 0.5 * np.where(np.isfinite(evidence), chi2, 0.0)[..., None] * (
            1 - 1 / inflated[:, None]
        )
        here = (
            here
            + np.log(priors / priors.sum() / _ERRORS.size)[:, None]
            - 0.5 * spare[:, None] * np.log(inflated[:, None])
        )
        return np.asarray(np.logaddexp.reduce(here, axis=(1, 2)))

    def _best_edge(self, parts: FloatArray) -> FloatArray:
        """The likeliest edge, shape (f, columns)."""
        edges = np.stack([part for j, part in enumerate(parts) if self._kind(j).family == STRETCH])
        return np.asarray(edges[edges[:, :, 0].argmax(axis=0), np.arange(edges.shape[1])])

    def _of_pairs(self, w: FloatArray, edge: FloatArray, pairs: list[Any], rule: FloatArray) -> FloatArray:
        """Log of the evidence of two touches that read like an edge, about those of its second moment."""
        from ._edge_kernel import weigh_edge

        y, z, length, direction = edge[:, [*LOCAL.position, *LOCAL.edge[:2]]].T
        at, floor = np.column_stack([y, z, direction, length / np.sqrt(3)]), np.full(len(w), np.inf)
        box = edge_box(self._box, Kind("two touches", STRETCH, half_length=self._gap))
        found, part = np.empty((len(pairs), len(w))), np.empty((len(w), LOCAL.each))
        for each, model in zip(found, pairs, strict=True):
            weigh_edge(w, at, model, self.friction, box, floor, *rule, part)
            each[:] = part[:, 0]
        return np.asarray(np.logaddexp.reduce(found, axis=0) - np.log(len(pairs)))


class _Loose(RoundLocator):
    """Finds the nearest sphere, however little it explains."""

    def _settings(self, array: Any, response: Any, error: float, told: float = np.inf) -> Settings:
        return super()._settings(array, response, error, told)._replace(largest=1e300)


def _rule(count: int) -> FloatArray:
    """Nodes and weights of Gauss and Legendre's rule on (0, 1)."""
    nodes, weights = np.polynomial.legendre.leggauss(count)
    return np.stack([0.5 * (1 + nodes), 0.5 * weights])


def _tabulated(family: Any) -> type[RoundContact]:
    """Of which round contacts the readings of a kind are made: a point is a sphere of no width, an edge is spheres."""
    if family == STRETCH:
        return RoundHertz
    kind = local_family_of(family)
    return RoundHertz if issubclass(kind, PointLoad) else kind


def _ratio(family: type[RoundContact]) -> float:
    """Half width of a family's contact over a sphere's with the same second moment of pressure along one direction."""
    sphere, other = (
        1 - float(kind(1.0, half_width=1.0).disc_spectrum(np.array(_LONG))) for kind in (RoundHertz, family)
    )
    return float(np.sqrt(sphere / other))
