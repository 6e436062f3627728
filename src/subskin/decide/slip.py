"""From an estimate and a coefficient of friction: how close to slipping, and how surely."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import Any

import numpy as np
import numpy.typing as npt

from .. import _check
from .._check import FloatArray
from .._frozen import Frozen
from .._shown import Drawing
from ..errors import InvalidValueError
from ..estimate import Estimate, Layout, Status
from ..estimate.shown import Shown, in_html, in_words
from ..pressing import Indenter, LocalIndenter
from ..skin import Skin
from ._cone import BoolArray, beyond, checked, forces_of, levels, margin, picked
from ._cone_kernel import CUT_OFF, JUDGED, PROBABILITY, RATIO, UNSURE, VERDICT, SlipVerdict, judge_frames
from ._drag_kernel import judge_drags
from .friction import Friction, density_of, friction_of, rows_of
from .stick import checked_contact, friction_arm, stick_share, stick_zone

__all__ = ["Slip", "slip"]

_INTERVAL = (0.025, 0.975)
_THRESHOLDS = (1e-3, 0.5)
_USUAL = _check.read_only(np.array(_THRESHOLDS))
_COLUMNS = ("normal", "tangential", "margin", "margin_std", "probability", "ratio")
_ALL = np.s_[:]
_NAMES = {int(verdict): verdict.name for verdict in SlipVerdict}


@dataclass(frozen=True, eq=False, repr=False)
class Slip(Frozen):
    """How close to slipping each frame is; every field has the batch's shape (...). NaN where there is no answer.

    Attributes
    ----------
    normal, tangential : ndarray
        N and T of the load found [N/m]; on an area N and |T| [N].
    margin, margin_std : ndarray
        mu N - |T| [N/m], and its standard deviation by the errors of N, T and mu together. Here and below, where a
        moment was fitted, |T| is the drag alone that would be as near to slipping (docs/slip.md).
    probability : ndarray
        That |T| > mu N.
    ratio : ndarray
        |T| / (mu N), at the mean mu; 1 is the edge of the cone.
    at_edge : ndarray of bool
        The load lies on the edge of the estimator's own cone: it may be steeper than was found.
    verdict : ndarray of int
        `SlipVerdict`.
    status : ndarray of int
        `Status` of the estimate.
    estimate : Estimate
        What was judged.
    friction : Friction
        By which.
    contact, bodies
        What decides on the stick zone: a contact's name, and the skin and indenter where these were given.
    """

    normal: FloatArray
    tangential: FloatArray
    margin: FloatArray
    margin_std: FloatArray
    probability: FloatArray
    ratio: FloatArray
    at_edge: BoolArray
    verdict: npt.NDArray[np.int8]
    status: npt.NDArray[np.int8]
    estimate: Estimate
    friction: Friction
    contact: str
    bodies: tuple[Skin, Indenter | LocalIndenter] | None

    plot = Drawing("slip_figure")

    def __repr__(self) -> str:
        return in_words("Slip", self.verdict, _NAMES, self._shown())

    def _repr_html_(self) -> str:
        return in_html("Slip", self.verdict, _NAMES, self._shown())

    def _shown(self) -> list[Shown]:
        none = np.full(self.shape, np.nan)
        return [
            Shown("probability", self.probability, none, ""),
            Shown("ratio", self.ratio, none, ""),
            Shown("margin", self.margin, self.margin_std, self.estimate.force_unit),
        ]

    @property
    def shape(self) -> tuple[int, ...]:
        """Shape of the batch."""
        return self.probability.shape

    @property
    def covariance(self) -> FloatArray:
        """Covariance of (N, T) [(N/m)^2], (..., 2, 2); on an area of (N, Ty, Tz) [N^2], and a moment, (..., 3 or 4)."""
        d = self.estimate.layout.dim
        square = np.asarray(self.estimate.load.covariance)[..., d:, d:]
        return _check.read_only(np.where(np.isnan(self.probability)[..., None, None], np.nan, square))

    def probability_at(
        self, frame: int | tuple[int, ...], normal: npt.ArrayLike, tangential: npt.ArrayLike
    ) -> FloatArray:
        """Probability of slip of a load found at (normal, tangential) [N/m] with the errors of one frame.

        `frame` is its index, () where there is no batch; the result has the shape of the forces.

        Raises
        ------
        InvalidValueError, GeometryError
            No frame of the batch; forces that do not broadcast.
        """
        try:
            index = np.array([np.ravel_multi_index(np.atleast_1d(frame), self.shape)]) if self.shape else np.array([0])
        except (TypeError, ValueError):
            rule = f"the index of a frame of a batch of shape {self.shape} is needed, from 0"
            raise InvalidValueError(f"frame = {_check.shown(frame)}", rule, "frame=0") from None
        n, t = _check.real("normal", normal), _check.real("tangential", tangential)
        n, t = (np.broadcast_to(part, _check.broadcast(normal=n, tangential=t)) for part in (n, t))
        own = forces_of(self.estimate, self.contact)[0].at(np.repeat(index, n.size))
        values = beyond(own.with_(n.ravel(), t.ravel()), *density_of(self.friction, self.shape, index))
        return _check.read_only(values.reshape(n.shape))

    @cached_property
    def torsion(self) -> FloatArray:
        """Moment over the largest that friction holds without a drag, |M| / (arm mu N a); NaN where it is not known."""
        if self.estimate.load.moment is None:
            return _check.read_only(np.full(self.shape, np.nan))
        load = forces_of(self.estimate, self.contact)[0]
        with np.errstate(divide="ignore", invalid="ignore"):
            share = np.where(np.isnan(self.probability), np.nan, load.turning / (self.friction.mean * load.normal))
        return _check.read_only(share)

    @cached_property
    def ratio_interval(self) -> FloatArray:
        """95 % interval of |T| / (mu N), by the errors of N, T and mu together, shape (..., 2)."""
        out = np.full((self.probability.size, 2), np.nan)
        told = np.flatnonzero(np.isfinite(self.probability))
        if told.size:
            load = forces_of(self.estimate, self.contact)[0].at(told)
            edges, masses = density_of(self.friction, self.shape, told)
            for column, below in enumerate(_INTERVAL):
                out[told, column] = levels(load, edges, masses, 1 - below, by_ratio=True)
        return _check.read_only(out.reshape(*self.shape, 2))

    @cached_property
    def stick(self) -> FloatArray:
        """Part of the contact's width that sticks, 1 at no drag, 0 where it slides; NaN for a line or with a moment."""
        return self._stick(self.ratio)

    @cached_property
    def stick_interval(self) -> FloatArray:
        """95 % interval of `stick`, shape (..., 2)."""
        return _check.read_only(np.stack([self._stick(self.ratio_interval[..., k]) for k in (1, 0)], axis=-1))

    def _stick(self, ratio: FloatArray) -> FloatArray:
        if self.estimate.layout.twist:  # drag and moment together leave no ring
            return _check.read_only(np.full_like(ratio, np.nan))
        if self.bodies is None:
            return _check.read_only(stick_share(self.contact, ratio, on_area=self.estimate.layout.dim == 2))
        mean = np.maximum(self.friction.mean, 1e-12)
        drag = np.minimum(ratio, 1.0) * mean * self.normal
        if self.estimate.layout.dim == 2:
            azimuth = self.estimate.load.azimuth[..., None]
            drag = drag[..., None] * np.concatenate([np.cos(azimuth), np.sin(azimuth)], axis=-1)
        return stick_zone(*self.bodies, self.normal, drag, mean)


def slip(
    estimate: Estimate,
    friction: Friction | float,
    *,
    contact: str = "hertz",
    skin: Skin | None = None,
    indenter: Indenter | LocalIndenter | None = None,
    thresholds: tuple[float, float] = _THRESHOLDS,
) -> Slip:
    """How close to slipping: margin to the friction cone, probability of slip, and what of the contact still sticks.

    The probability is that of |T| > mu N, for (N, T) normal with the estimate's covariance and mu with the friction's
    density; on an area (N, Ty, Tz), and T is both components of the drag. Where a moment about the normal was fitted as
    well it is the probability that drag and moment together lie beyond the contact's limit surface. Source:
    docs/slip.md.

    Parameters
    ----------
    estimate : Estimate
        From `Finger.locate` or `Finger.fit`, shape (...). Its own `friction`, the cone that was searched, has to be
        wider than the skin's: a load on its edge may be steeper than was found, and where friction might hold that,
        nothing can be told.
    friction : Friction or float
        What is known of the coefficient; a number is taken as known.
    contact : {"hertz", "wedge", "punch", "line"}, optional
        What presses, for the stick zone: a round body, a wedge, a flat punch, or a line, which has none. Where a moment
        was fitted, what holds it: a round body, a cone ("wedge") or a flat disc.
    skin, indenter : Skin and Indenter, optional
        For other bodies and skins: the contact solver finds the stick zone, when it is asked for.
    thresholds : (float, float), optional
        Probabilities of slip below which a frame HOLDS and from which it SLIPS.

    Returns
    -------
    Slip

    Raises
    ------
    InvalidValueError, GeometryError
        Something that is no estimate, thresholds out of order, an unknown contact, frictions of another shape.

    Examples
    --------
    >>> import numpy as np, subskin as ss
    >>> skin = ss.HalfPlane(ss.Material(young=0.4e6))
    >>> finger = ss.Finger(skin, ss.SensorArray.line(count=6, pitch=1.5e-3, depth=2e-3, noise=2e-4))
    >>> touch = ss.LineLoad(force=40.0, angle=[0.1, 0.4, 0.6], position=0.8e-3)
    >>> found = finger.locate(finger.read(touch, rng=np.random.default_rng(1)))
    >>> judged = ss.decide.slip(found, ss.decide.Friction.between(0.4, 0.6))
    >>> [ss.decide.SlipVerdict(v).name for v in judged.verdict]
    ['HOLDS', 'AT_RISK', 'SLIPS']
    """
    mu = friction_of(friction)
    limits = _thresholds(thresholds)
    checked_contact(contact)
    if (skin is None) != (indenter is None):
        seen = f"skin = {skin!r}, indenter = {indenter!r}"
        raise InvalidValueError(seen, "the solver needs both", "skin=finger.skin")
    table = checked(estimate).table
    on_area = estimate.layout.dim == 2
    if indenter is not None and isinstance(indenter, LocalIndenter) != on_area:
        kind = "of an area, a body in space" if on_area else "of a row, a body of the plane"
        fix = "ss.pressing." + ("Sphere(radius=8e-3)" if on_area else "Cylinder(radius=8e-3)")
        raise InvalidValueError(f"indenter = {indenter!r}", f"{kind} is needed", fix)
    judged = np.empty((*table.shape[:-1], JUDGED))
    rows, every = judged.reshape(-1, JUDGED), rows_of(mu, estimate.shape)
    if on_area:
        if estimate.layout.twist:
            friction_arm(contact)
        _judge_area(estimate, contact, every, limits, rows)
    else:
        columns = _columns(estimate.layout)
        judge_frames(table.reshape(-1, table.shape[-1]), columns, estimate.friction, *every, limits, rows)
    if rows.item(0, UNSURE) if len(rows) == 1 else rows[:, UNSURE].any():
        index = np.flatnonzero(rows[:, UNSURE])
        rows[index, PROBABILITY] = beyond(forces_of(estimate)[0].at(index), *(picked(v, index) for v in every[:2]))
        sure = rows[index, VERDICT] != SlipVerdict.CANNOT_TELL
        rows[index[sure], VERDICT] = np.searchsorted(limits, rows[index[sure], PROBABILITY], side="right")
    judged.setflags(write=False)
    made = {name: judged[..., column] for column, name in enumerate(_COLUMNS)}
    made["at_edge"], made["verdict"] = rows[:, CUT_OFF] != 0, rows[:, VERDICT].astype(np.int8)
    for name in ("at_edge", "verdict"):
        made[name].shape = table.shape[:-1]
        made[name].setflags(write=False)
    bodies = None if skin is None or indenter is None else (skin, indenter)
    rest = {"status": estimate.status, "estimate": estimate, "friction": mu, "contact": contact, "bodies": bodies}
    return Slip.filled(made | rest)


def _judge_area(
    estimate: Estimate, contact: str, every: tuple[FloatArray, FloatArray, FloatArray], limits: FloatArray,
    rows: FloatArray,
) -> None:  # fmt: skip
    """Fill `rows` (frames, JUDGED), as `judge_frames` does, from loads on an area."""
    edges, masses, facts = every
    load, told, edge = forces_of(estimate, contact)
    told, edge = told.reshape(-1), edge.reshape(-1)
    if not load.turns:
        flat, status = load.at(_ALL), estimate.table[..., estimate.layout.status].reshape(-1)
        judge_drags(*flat[:2], told, edge, status, estimate.friction, *every, limits, rows)
        return
    rows[:], rows[:, VERDICT], rows[:, UNSURE], rows[:, CUT_OFF] = np.nan, SlipVerdict.CANNOT_TELL, 0.0, edge
    most = np.broadcast_to(facts[:, 2], told.shape)
    index = np.flatnonzero(told & (load.normal.reshape(-1) > 0) & ~(edge & (estimate.friction < most)))
    if not index.size:
        return
    part = load.at(index)
    n, t = part.normal, part.tangential
    mean, std, _ = np.moveaxis(np.broadcast_to(picked(facts, index), (index.size, 3)), -1, 0)
    total = beyond(part, picked(edges, index), picked(masses, index))
    left, left_std, ratio = margin(part, mean, std)
    rows[index, : RATIO + 1] = np.stack([n, t, left, left_std, total, ratio], axis=-1)
    ok = estimate.status.reshape(-1)[index] == Status.OK
    rows[index[ok], VERDICT] = np.searchsorted(limits, total[ok], side="right")


@lru_cache(maxsize=16)
def _columns(layout: Layout) -> tuple[int, int, int, int, int]:
    square = layout.square
    return layout.components, int(square[1, 1]), int(square[1, 2]), int(square[2, 2]), layout.status


def _thresholds(values: Any) -> FloatArray:
    if values is _THRESHOLDS:
        return _USUAL
    pair = _check.real("thresholds", values, at_least=0.0, at_most=1.0)
    if pair.shape != (2,) or not pair[0] <= pair[1]:
        seen = f"thresholds = {values!r}"
        raise InvalidValueError(seen, "two probabilities, ascending, are needed", "thresholds=(1e-3, 0.5)")
    return pair
