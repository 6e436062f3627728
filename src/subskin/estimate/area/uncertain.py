"""What is not known of an area's finger, and of a touch's size, made ready for the loop that settles (`../settle`)."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import numpy.typing as npt

from ..._check import FloatArray
from ...array import SensorArray
from ...contact import RoundHertz
from ...finger import Finger
from ...radial import RadialResponse, tabulate_radial
from ...radial_round import tabulate_round
from ...tolerances import Tolerances
from ..layout import SIZED
from ..settle.given import Variants
from ..settle.uncertain import POWERS, SQUARES, Uncertain, deeper_than, other_than
from .judge import Beyond, Settings
from .point import laid_out

__all__ = ["exactly", "on_area", "to_settle"]


def on_area(finger: Finger, response: RadialResponse, reach: float, *, sized: bool) -> Uncertain | None:
    """What is not known of a finger whose `response` reaches so far; None where it is exact."""
    told, depth = finger.tolerances, np.asarray(finger.array.depth)
    if told is None:
        return None
    deeper, (other, ratios), less = deeper_than(finger), other_than(finger), None
    if other is not None:
        less = _difference(response, [(1.0, tabulate_radial(other, reach))])
    widest = float(depth.min())
    sizes: tuple[RadialResponse, ...] = ()
    if sized:
        table = tabulate_round(finger, RoundHertz, reach, 1.5 * widest)
        wider = [table.at(float(np.sqrt(q)) * widest) for q in SQUARES]
        sizes = tuple(_difference(response, list(zip(row, wider, strict=True))) for row in POWERS)
    made = None
    if deeper is not None:  # as far in depths, so that the cells are the same
        made = tabulate_radial(deeper, reach * float(np.asarray(deeper.array.depth).min()) / widest)
    return Uncertain(told, _tables, response, ratios, made, less, sizes, widest)


def exactly(response: RadialResponse) -> Uncertain:
    """That of a finger of which nothing is unknown, touched by points: what is left are doubts of single readings."""
    widest = float(np.asarray(response.depth).min())
    return Uncertain(Tolerances(), _tables, response, (0.0, 0.0), None, None, (), widest)


def to_settle(
    uncertain: Uncertain, array: SensorArray, pattern: npt.NDArray[np.bool_], step: float, away: float,
    settings: Settings, beyond: Beyond,
) -> tuple[Any, ...]:  # fmt: skip
    """Arguments of the loop that settles, for the sensors of `pattern`, which are `array`.

    Another load is looked for in the search at such a `step`, and as far `away` from it at the nodes of `beyond`.
    """
    box = settings.box.reshape(2, 2)
    sides = (np.arange(low, high + 0.5 * step, step) for low, high in box)
    grid = np.stack(np.meshgrid(*sides, indexing="ij"), axis=-1).reshape(-1, 2)
    told = {
        "friction": settings.limits[0], "largest": settings.largest, "ambiguity": settings.ambiguity,
        "apart": settings.apart, "box": settings.box,
        "beyond": (box + away * np.array([-1.0, 1.0])).reshape(-1),
    }  # fmt: skip
    nodes = np.concatenate([grid, beyond.nodes[:, :2]])
    return uncertain.to_settle(array, pattern, SIZED, nodes, **told)


def _tables(every: list[RadialResponse], noise: FloatArray, at: dict[str, int]) -> Variants:
    """Tables of responses of an area, as loops want them."""
    every = [one.separate() if i == 0 else one for i, one in enumerate(every)]
    if {len(one.coefficients) for one in every} != {1}:  # a table for each sensor
        every = [_alone(one.separate()) for one in every]
    pairs = all(one.pair is not None for one in every)
    made = [laid_out(one, one.cubics()[0], pairs) for one in every]
    numbers = max(table.shape[1] for table, _, _ in made)
    most = max(len(terms) for _, terms, _ in made)
    table = np.stack([np.pad(table, ((0, 0), (0, numbers - table.shape[1]))) for table, _, _ in made])
    terms = np.stack([np.pad(terms, ((0, most - len(terms)), (0, 0))) for _, terms, _ in made]).astype(np.int64)
    sensors = np.stack([np.stack([*one.points.T, one.depth**-2.0, one.gain / noise]) for one in every])
    cells = made[0][2]
    first = np.append(every[0].kind * cells, cells - 1).astype(np.int64)
    return Variants(np.ascontiguousarray(sensors), np.ascontiguousarray(table), first, terms, 0.0, 1.0, **at)


def _alone(one: RadialResponse) -> RadialResponse:
    """The same response with a table for each sensor."""
    return replace(one, kind=np.arange(one.sensors), coefficients=np.ascontiguousarray(one.coefficients[one.kind]))


def _difference(base: RadialResponse, parts: list[tuple[float, RadialResponse]]) -> RadialResponse:
    """Sums of so much of responses less that of `base`, as a response of its own."""
    if all(np.array_equal(one.terms, base.terms) for _, one in parts):
        total = sum(share * (one.coefficients - base.coefficients) for share, one in parts)
        return replace(base, coefficients=np.ascontiguousarray(total), lift=0.0)
    every = [(-sum(share for share, _ in parts), base), *parts]
    terms, tables, count = [], [], 0
    for share, one in every:
        terms.append(one.terms + np.array([0, 0, 0, count, 0]))
        tables.append(share * one.coefficients)
        count += one.coefficients.shape[2]
    return replace(base, terms=np.concatenate(terms), coefficients=np.concatenate(tables, axis=2), lift=0.0)
