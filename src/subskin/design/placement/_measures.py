"""Which touches are looked at, and what their maps come to in one number each."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from ... import _check
from ..._check import FloatArray
from ...errors import GeometryError, InvalidValueError
from ...skin import Skin
from ..touches import Touches
from ._table import MAPS, RowField

GRID = (101, 41)
"""Positions and angles of the grid on which bounds are found."""

SHARES = ("ambiguous", "wrong", "unfelt")
_STDS = ("position", "angle", "force")
PLACEMENT_MEASURES = (*(f"{name}_{s}" for name in _STDS for s in ("worst", "95", "mean")), *SHARES, "log_det")
"""Names of the numbers in which a placement is judged; `study_row` describes them."""


def jittered(count: int, rng: np.random.Generator) -> tuple[FloatArray, FloatArray]:
    """At least `count` touches, one at random in each of equal cells of the unit square: positions (p,), angles (p, k).

    The angles of a position share it. There are more positions than angles, for what is ambiguous is so along narrow
    strips that run with the angle.
    """
    across = max(round(np.sqrt(count / 10)), 1)
    along = -(-count // across)
    positions = (np.arange(along) + rng.random(along)) / along
    return positions, (np.arange(across) + rng.random((along, across))) / across


def judged(
    field: RowField, touches: Touches, span: tuple[float, float], grid: tuple[int, int], ambiguity: float
) -> tuple[FloatArray, FloatArray, FloatArray, dict[str, float]]:
    """Positions (p,) and angles (k,) from end to end, `MAPS` of these touches, and their `PLACEMENT_MEASURES`."""
    shape = checked_grid(grid)
    positions = np.linspace(*span, shape[0])
    angles = np.linspace(-touches.cone, touches.cone, shape[1]) if touches.cone > 0 else np.zeros(1)
    weight = _trapezoid(positions.size)[:, None] * _trapezoid(angles.size)
    maps = field.survey(touches, positions, angles, ambiguity)
    worst = field.worst(touches, positions, angles, maps)
    # a touch that is known less well than by its being one of `touches` counts as one known so well
    most = {"position": (span[1] - span[0]) / 12**0.5, "angle": touches.cone / 3**0.5, "force": 1.0}
    out = {}
    for name in _STDS:
        std = maps[MAPS.index(name)]
        out[f"{name}_worst"] = float(worst[MAPS.index(name)])
        out[f"{name}_95"] = _quantile_95(std, weight)
        out[f"{name}_mean"] = float((np.minimum(std, most[name]) * weight).sum())
    out |= {name: float((maps[MAPS.index(name)] * weight).sum()) for name in (*SHARES, "log_det")}
    return positions, angles, maps, out


def _trapezoid(count: int) -> FloatArray:
    """Weights of the trapezoidal rule, of sum 1."""
    weight = np.ones(count)
    if count > 1:
        weight[[0, -1]] = 0.5
    return weight / float(weight.sum())


def _quantile_95(values: FloatArray, weight: FloatArray) -> float:
    order = np.argsort(values, axis=None)
    passed = np.cumsum(weight.ravel()[order])
    return float(values.ravel()[order[np.searchsorted(passed, 0.95 * passed[-1])]])


def checked_grid(grid: tuple[int, int]) -> tuple[int, int]:
    """Two whole numbers, >= 2 positions and >= 1 angle."""
    values = _check.real("grid", grid)
    if values.shape != (2,) or not (values == np.round(values)).all() or values[0] < 2 or values[1] < 1:
        raise InvalidValueError(f"grid = {grid!r}", "numbers of positions and of angles are needed", f"grid={GRID}")
    return int(values[0]), int(values[1])


def checked_counts(counts: npt.ArrayLike, touches: Touches) -> npt.NDArray[np.int_]:
    """Numbers of sensors: whole ones, and no fewer than a touch has unknowns."""
    numbers = np.atleast_1d(_check.real("counts", counts))
    if numbers.ndim != 1 or not numbers.size or not (numbers == np.round(numbers)).all():
        raise InvalidValueError(f"counts = {counts!r}", "a list of whole numbers is needed", "counts=[4, 6, 8]")
    needed = 2 if touches.friction == 0 else 3
    if numbers.min() < needed:
        raise InvalidValueError(
            f"{int(numbers.min())} sensors", f"a touch has {needed} unknowns, and takes as many sensors that respond"
        )
    return numbers.astype(np.int_)


def check_span(skin: Skin, touches: Touches) -> None:
    """Refuses touches that go round the skin and on."""
    if touches.span is not None and touches.span[1] - touches.span[0] > skin.period * (1 + 1e-12):
        raise GeometryError(f"span = {touches.span} m", f"the finger is {skin.period:.6g} m about", "a shorter span")
