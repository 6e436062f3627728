"""What a finger cannot object to: how often readings from outside its model pass as a good answer, and a wrong one."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from .. import _check
from .._shown import html_table, lines
from ..contact.families import Family, LocalFamily, checked_family, families, local_families
from ..estimate import Either, Status
from ..estimate.locate import locator
from ..estimate.on_row import usual as sought
from ..finger import Finger, finger_needed
from ._common import locator_for, widest
from .outside import Drawn, Outside, Scene, outside_of
from .touches import Touches

__all__ = ["BlindSpot", "BlindSpots", "blind_spots"]

_STD, _FAR, _FORCE = 5.0, 0.3, 0.3
"""An answer is wrong when it is off by so many standard errors or depths; a force, by this share.

On an area the standard error is that in the direction in which it is worst.
"""

_OF_LINES = ("half_width", "normal_force", "stick", "moment")
_HEADS = ("", "OK", "OK and wrong", "unexplained")


@dataclass(frozen=True)
class BlindSpot:
    """How a finger answers readings of one kind that its model does not describe.

    Parameters
    ----------
    name, text, group : str
        As in `design.outside.Outside`.
    ok : float
        Share of the touches called OK.
    wrong : float
        Share called OK whose position is off by more than 5 standard errors or 0.3 depths.
    far : float
        Share called OK whose position is off by more than 0.3 depths.
    force : float
        Share called OK whose normal force is off by more than 30 %.
    unexplained : float
        Share called UNEXPLAINED; the rest is ambiguous, or no contact was noticed.
    """

    name: str
    text: str
    group: str
    ok: float
    wrong: float
    far: float
    force: float
    unexplained: float


@dataclass(frozen=True, eq=False)
class BlindSpots:
    """What `blind_spots` found.

    Parameters
    ----------
    rows : tuple of BlindSpot
        The model's own touches first.
    spare : int
        Readings beyond the unknowns.
    sensors : int
        Sensors that respond.
    family : str
        What was fitted.
    count : int
        Touches of each kind.
    """

    rows: tuple[BlindSpot, ...]
    spare: int
    sensors: int
    family: str
    count: int

    def __getitem__(self, name: str) -> BlindSpot:
        """The row of a name.

        Raises
        ------
        KeyError
            There is none.
        """
        for row in self.rows:
            if isinstance(name, str) and row.name == name:
                return row
        raise KeyError(name)

    @property
    def wrong(self) -> float:
        """Largest share of touches of one kind, none of them the model's, that are OK and wrong."""
        return max((row.wrong for row in self.rows if row.group == "touch"), default=0.0)

    @property
    def sentence(self) -> str:
        """The table in one plain sentence or two."""
        unknowns = self.sensors - self.spare
        spare = f"{self.spare} spare reading{'s'[: self.spare != 1]} ({self.sensors} sensors, {unknowns} unknowns)"
        worst = sorted((r for r in self.rows if r.group != "model"), key=lambda row: -row.wrong)[:3]
        named = [f"{row.text} ({100 * row.wrong:.1f} %)" for row in worst if row.wrong >= 0.5 / self.count]
        if not named:
            return f"With {spare} nothing that was tried passes as OK with a wrong position."
        last = f" and {named[-1]}" if len(named) > 1 else ""
        listed = ", ".join(named[:-1]) + last if last else named[0]
        return f"With {spare} this finger is OK and wrong most often about {listed}."

    def __repr__(self) -> str:
        return lines(self.sentence, [_HEADS, *self._shown()])

    def _repr_html_(self) -> str:
        return html_table(self.sentence, self._shown(), _HEADS)

    def _shown(self) -> list[tuple[str, ...]]:
        return [(r.text, *(f"{100 * s:.1f} %" for s in (r.ok, r.wrong, r.unexplained))) for r in self.rows]

    def to_dict(self) -> dict[str, Any]:
        """Everything as plain numbers and texts, for JSON."""
        return {
            "sensors": self.sensors, "spare": self.spare, "family": self.family, "touches": self.count,
            "sentence": self.sentence, "rows": [asdict(row) for row in self.rows],
        }  # fmt: skip


def blind_spots(
    finger: Finger,
    touches: Touches | None = None,
    family: str | Family | LocalFamily | None = None,
    *,
    snr: float = 1000.0,
    count: int = 1000,
    rng: np.random.Generator | int = 0,
    **options: Any,
) -> BlindSpots:
    """How often readings that the model does not describe pass as OK, and wrong: what a finger cannot object to.

    A status can only object with readings that are left over when the unknowns are found. So each of some twenty things
    that are outside the model (two touches, a wide roller, a pull, another skin, a sensor that is stuck, ...;
    `design.outside.OUTSIDE`) is read with noise and answered by `finger.fit(readings, family, **options)`. As
    `finger.blind_spots()` too.

    Parameters
    ----------
    finger : Finger
        With the noise of its sensors.
    touches : Touches, optional
        Force [N/m], friction and span of the touches, or force [N], friction and area; without them the force with
        which the best sensor reads `snr` times its noise, over the row or the rectangle of the sensors.
    family : str or subclass of SpreadContact or of RoundContact, optional
        What is fitted; as `locate` does, "line", or "either" of a row whose skin is known in space, on an area "point",
        or "round_hertz" of touches that have a radius.
    snr : float, optional
        Signal over noise of the usual touch, where no `touches` are given [-].
    count : int, optional
        Touches of each kind.
    rng : Generator or int, optional
        Random generator, or its seed.
    **options
        As in `locator`: search, friction, half_width and so on. Friction is that of the touches if left out.

    Raises
    ------
    InvalidValueError, GeometryError
        As in `locator`; sensors at one position and no span; touches on an area and sensors in a row, or the reverse.
    NotLinearError
        A transducer with no linear part.

    Examples
    --------
    >>> import subskin as ss
    >>> skin = ss.HalfPlane(ss.Material(young=0.4e6))
    >>> few, many = (ss.Finger(skin, ss.SensorArray.line(n, pitch=1.5e-3, depth=2e-3, noise=1e-4)) for n in (4, 8))
    >>> found = ss.blind_spots(few, snr=100, count=300)
    >>> found.spare, found["wide_roller"].wrong > 0.1, many.blind_spots(snr=100, count=300)["wide_roller"].wrong < 0.1
    (1, True, True)
    """
    finger_needed(finger)
    count = _check.whole("count", count, at_least=1, at_most=10**8, fix="count=1000")
    used = _usual(finger, snr, options) if touches is None else touches
    _check.noun("touches", used, Touches, Touches.EXAMPLE)
    _check.random(rng)
    local = used.area is not None
    usual = "point" if used.half_width is None else "round_hertz"
    if not local:
        usual = sought(finger, *(options.get(name) for name in _OF_LINES))
    if family is not None and not (isinstance(family, str) and family == "either"):
        checked_family(family)
    kind: Any = usual if family is None or (local and family == "line") else family
    given, options = "" if local and kind == usual else kind, {"friction": used.friction, **options}
    estimator: Any = (
        locator(finger, kind, **options) if kind == "either" else locator_for(finger, used, given, **options)
    )
    known = local_families() if local else families()
    name = next((key for key, one in known.items() if kind in (key, one)), getattr(kind, "__name__", ""))
    live = int(finger.array.live.sum())
    rows = []
    for i, outside in enumerate(outside_of(used)):
        if outside.family and outside.family in (name, kind, *(("line", "point") if kind == "either" else ())):
            continue
        seed = np.random.default_rng([i, rng]) if isinstance(rng, int) else rng
        drawn = outside.draw(Scene(finger, used, count, seed))
        if drawn is not None:
            rows.append(_judged(outside, drawn, estimator(drawn.readings), finger))
    unknowns = estimator.unknowns
    return BlindSpots(tuple(rows), max(live - unknowns, 0), live, str(name or kind), count)


def _usual(finger: Finger, snr: float, options: dict[str, Any]) -> Touches:
    """Touches over the sensors, so hard that the best sensor reads `snr` times its noise straight above."""
    array = finger.array
    snr = _check.scalar("snr", snr, above=0.0, fix="snr=1000")
    live = array.live
    above = array.points[live]
    fields = np.abs(finger.receptive_field(above if array.on_area else above[:, 0])[..., live, 0])
    force = snr / float((fields / np.asarray(array.noise)[live]).max())
    friction = _check.friction(options.get("friction", 1.0))
    friction = friction if np.isfinite(friction) else 1.0
    if not array.on_area:
        return Touches(force, friction)
    (a, b), (c, d) = np.stack([above.min(axis=0), above.max(axis=0)], axis=-1).tolist()
    return Touches(force, friction, area=((a, b), (c, d)))


def _judged(outside: Outside, drawn: Drawn, found: Any, finger: Finger) -> BlindSpot:
    ok, d = found.status == Status.OK, drawn.positions.shape[-1]
    off = np.linalg.norm(found.position.reshape(-1, 1, d) - drawn.positions, axis=-1).min(axis=1)
    depth = float(np.asarray(finger.array.depth).mean())
    far = ok & (off > _FAR * depth)
    std = found.position_std if isinstance(found, Either) else widest(found.load.covariance[:, :d, :d])
    wrong = far | (ok & (off > _STD * std))
    force = ok & (np.abs(found.components[:, 0] - drawn.normal) > _FORCE * np.abs(drawn.normal))
    shares = (float(np.mean(which)) for which in (ok, wrong, far, force, found.status == Status.UNEXPLAINED))
    return BlindSpot(outside.name, outside.text, outside.group, *shares)
