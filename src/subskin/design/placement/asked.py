"""What placements are asked, and what they tell: touches, the bounds of Cramer and Rao, and what it comes to."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, NamedTuple, TypeAlias

import numpy as np
import numpy.typing as npt

from ... import _check
from ..._check import FloatArray
from ..._declared import Real
from ...errors import GeometryError, InvalidValueError
from ...skin import Skin
from .._common import widest
from ..touches import Touches

AMBIGUITY = 13.8
FALSE_ALARM = 1e-6
MARGIN = 1.5
"""As `finger.locate` has them if nothing else is stated."""
_FARTHEST = 100.0
"""Depths beyond the sensors from which nothing is felt."""

SAMPLES, AREA_SAMPLES = 100_000, 300
"""Touches by which shares are found of a row, and on an area."""
GRID, AREA_GRID = (101, 41), (9, 6)
"""The grid on which bounds are found: positions and angles of a row; positions along y and z, and azimuths."""
_MOST_SAMPLES = 10**7

Margin: TypeAlias = Annotated[
    float, Real(at_least=0.0, at_most=_FARTHEST, fix=f"margin={MARGIN}: farther out a load is hardly felt")
]
"""How far beyond the sensors loads are looked for, in depths."""

SHARES = ("ambiguous", "wrong", "unfelt")
_KINDS = ("worst", "95", "mean")
PLACEMENT_MEASURES = (*(f"{name}_{k}" for name in ("position", "angle", "force") for k in _KINDS), *SHARES, "log_det")
"""Names of the numbers in which a placement is judged; `study_at_depth` describes them."""
AREA_MEASURES = (*PLACEMENT_MEASURES[:9], *(f"radius_{k}" for k in _KINDS), *SHARES, "log_det", "rank")
"""Those in which one on an area is."""


class Judged(NamedTuple):
    """What a placement does: maps over positions (...) and loads (k,) [m, N/m or N], and its numbers by name.

    `maps` has the `SHARES`, or nothing where they were not asked for; covariance (..., k, u, u) and rank (..., k) are
    None of a row.
    """

    position: FloatArray
    load: FloatArray
    weight: FloatArray
    std: dict[str, FloatArray]
    maps: dict[str, FloatArray]
    values: dict[str, float]
    covariance: FloatArray | None = None
    rank: npt.NDArray[np.intp] | None = None


class AskedTouches(NamedTuple):
    """Touches, the grid on which bounds are found, the `ambiguity` of `locate`, and touches drawn at random.

    Those are at `shares` of the span (p,), or of the sides of the area (s, 2), and lean by shares of the cone, (p, k)
    or (s,), on an area to an `azimuth`. There are none where shares are found on the grid.
    """

    touches: Touches
    grid: tuple[int, int]
    ambiguity: float
    shares: FloatArray
    lean: FloatArray
    azimuth: FloatArray

    @classmethod
    def of(
        cls,
        touches: Touches,
        grid: tuple[int, int] | None,
        samples: int | None,
        rng: np.random.Generator | int,
        ambiguity: float,
        *,
        draws: bool = True,
    ) -> AskedTouches:
        """From what a study is given, where None is what is usual; nothing is drawn at random unless it `draws`."""
        row = touches.area is None
        shape = checked_grid((GRID if row else AREA_GRID) if grid is None else grid)
        most = _check.scalar("ambiguity", ambiguity, at_least=0.0)
        usual = SAMPLES if row else AREA_SAMPLES
        amount = usual if samples is None else samples
        drawn = _check.random(rng)
        if not draws:
            return cls(touches, shape, most, *np.empty((3, 0)))
        amount = _check.whole("samples", amount, at_least=1, at_most=_MOST_SAMPLES, fix="samples=2000")
        along, across = _jittered(amount, drawn)
        if row:
            return cls(touches, shape, most, along, 2 * across - 1, np.zeros(0))
        sides = np.stack([np.repeat(along, across.shape[1]), drawn.random(across.size)], axis=-1)
        return cls(touches, shape, most, sides, across.reshape(-1), drawn.uniform(-np.pi, np.pi, across.size))


def _jittered(count: int, rng: np.random.Generator) -> tuple[FloatArray, FloatArray]:
    """At least `count` touches, one at random in each of equal cells of the unit square: positions (p,), angles (p, k).

    The angles of a position share it. There are more positions than angles, for what is ambiguous is so along narrow
    strips that run with the angle.
    """
    across = max(round(np.sqrt(count / 10)), 1)
    along = -(-count // across)
    positions = (np.arange(along) + rng.random(along)) / along
    return positions, (np.arange(across) + rng.random((along, across))) / across


def summed_up(
    std: Mapping[str, FloatArray],
    weight: FloatArray,
    most: Mapping[str, float],
    worst: Mapping[str, float] | None = None,
) -> dict[str, float]:
    """The largest, the 95 % quantile and the mean of each standard deviation, by the names of the measures.

    A touch that is known less well than by its being one of `touches` counts in the mean as one known so well: `most`.
    """
    out: dict[str, float] = {}
    for name, values in std.items():
        out[f"{name}_worst"] = float(values.max()) if worst is None else worst[name]
        out[f"{name}_95"] = _quantile_95(values, weight)
        out[f"{name}_mean"] = float((np.minimum(values, most[name]) * weight).sum())
    return out


def _quantile_95(values: FloatArray, weight: FloatArray) -> float:
    order = np.argsort(values, axis=None)
    passed = np.cumsum(weight.ravel()[order])
    return float(values.ravel()[order[min(np.searchsorted(passed, 0.95 * passed[-1]), order.size - 1)]])


def trapezoid(count: int) -> FloatArray:
    """Weights of the trapezoidal rule, of sum 1."""
    weight = np.ones(count)
    if count > 1:
        weight[[0, -1]] = 0.5
    return weight / float(weight.sum())


def touched(touches: Touches, points: FloatArray) -> FloatArray:
    """Ends (d, 2) of where touches lie [m]: the area, the span, or from the first of `points` (n, d) to the last."""
    given = touches.area if touches.span is None else (touches.span,)
    return np.stack([points.min(axis=0), points.max(axis=0)], axis=-1) if given is None else np.array(given)


def searched(points: FloatArray, depth: float, skin: Skin, touches: Touches, margin: float) -> FloatArray:
    """Ends (d, 2) of where loads are looked for [m]: all that is touched, and `margin` depths beyond sensors (n, d).

    Round a finger they go about it once.
    """
    own = touched(touches, points)
    low = np.minimum(points.min(axis=0) - margin * depth, own[:, 0])
    high = np.maximum(points.max(axis=0) + margin * depth, own[:, 1])
    if (high - low <= skin.period).all():
        return np.stack([low, high], axis=-1)
    middle = 0.5 * (low + high)
    return np.stack([middle - 0.5 * skin.period, middle + 0.5 * skin.period], axis=-1)


def reach_of(points: FloatArray, box: FloatArray) -> float:
    """The largest distance of a load in the `box` (d, 2) from one of the sensors (n, d) [m]."""
    return float(np.linalg.norm(np.abs(box - points[:, :, None]).max(axis=(0, 2))))


def checked_grid(grid: tuple[int, int]) -> tuple[int, int]:
    """Two whole numbers, >= 2 positions and >= 1 angle."""
    values = _check.real("grid", grid)
    if values.shape != (2,) or not (values == np.round(values)).all() or values[0] < 2 or values[1] < 1:
        raise InvalidValueError(f"grid = {grid!r}", "numbers of positions and of angles are needed", f"grid={GRID}")
    return int(values[0]), int(values[1])


def check_where(skin: Skin, touches: Touches) -> None:
    """Refuses touches that go round the skin and on, and those on an area where the skin takes none."""
    if touches.span is not None and touches.span[1] - touches.span[0] > skin.period * (1 + 1e-12):
        raise GeometryError(f"span = {touches.span} m", f"the finger is {skin.period:.6g} m about", "a shorter span")
    if touches.area is not None and not skin.takes_local:
        rule = "it is solved in a plane and takes no touch on an area"
        raise InvalidValueError(f"the skin {skin}", rule, "HalfSpace(material), or Layered")


def check_count(count: int, touches: Touches) -> None:
    """Refuses fewer sensors in a row than a touch has unknowns."""
    needed = 2 if touches.friction == 0 else 3
    if count < needed and touches.area is None:
        rule = f"a touch has {needed} unknowns, and takes as many sensors that respond"
        raise InvalidValueError(f"{count} sensors", rule, "more sensors")


_BLIND = 1e-10
"""Share of the information of the best seen combination of unknowns below which another is not seen at all."""


class Told(NamedTuple):
    """Bounds at touches of shape (...): covariance of (y, z, (a), N, Ty, Tz), infinite where one is open; rank."""

    covariance: FloatArray
    rank: npt.NDArray[np.intp]
    log_det: FloatArray

    @classmethod
    def of(cls, information: FloatArray, units: FloatArray, known: int = 0) -> Told:
        """From Fisher's information (..., u, u); units (u,) are those beside which errors are small.

        The last `known` unknowns are known to be 0: the drag where there is no friction.
        """
        u = information.shape[-1] - known
        scale = units[:u]
        whole = information[..., :u, :u] * (scale[:, None] * scale)
        covariance = np.full(information.shape, 0.0)
        with np.errstate(all="ignore"):
            sizes = np.trace(whole, axis1=-2, axis2=-1)
            lifted = whole + 1e-15 * sizes[..., None, None] * np.eye(u)
            inverse = np.linalg.inv(lifted)
            blind = ~(np.trace(inverse, axis1=-2, axis2=-1) * sizes * _BLIND < 1.0) | ~(sizes > 0)
        rank = np.full(blind.shape, u)
        if blind.any():
            values = np.linalg.eigvalsh(whole[blind])
            rank[blind] = (values > _BLIND * values[:, -1:]).sum(axis=-1)
        covariance[..., :u, :u] = np.where(blind[..., None, None], np.inf, inverse * (scale[:, None] * scale))
        sign, log_det = np.linalg.slogdet(lifted)
        return cls(covariance, rank, np.where(sign > 0, log_det, -np.inf) - 4 * np.log(scale[0]))

    def stds(self, load: FloatArray) -> dict[str, FloatArray]:
        """Standard deviations by `AREA_STDS`, of touches under loads (..., 3).

        Of the position in the direction in which it is worst, of the angle of the load to that side to which it is
        worst [rad], of the force relative to it, of the half width [m] (0 where it is known).
        """
        c = self.covariance
        bad = ~np.isfinite(c[..., 0, 0])
        at, forces = np.where(bad[..., None, None], 0.0, c), np.broadcast_to(load, (*c.shape[:-2], 3))
        size = np.linalg.norm(forces, axis=-1)
        along = forces / size[..., None]
        turn = np.eye(3) - along[..., :, None] * along[..., None, :]
        f = at[..., -3:, -3:]
        across = turn @ f @ turn
        out = {
            "position": widest(at[..., :2, :2]),
            "angle": np.sqrt(np.maximum(np.linalg.eigvalsh(across)[..., -1], 0.0)) / size,
            "force": np.sqrt(np.maximum(np.einsum("...i,...ij,...j->...", along, f, along), 0.0)) / size,
            "radius": np.sqrt(np.maximum(at[..., 2, 2], 0.0)) if c.shape[-1] == 6 else np.zeros(bad.shape),
        }
        known = "radius" if c.shape[-1] == 5 else ""
        return {name: value if name == known else np.where(bad, np.inf, value) for name, value in out.items()}
