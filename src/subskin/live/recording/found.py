"""Estimates and decisions as columns of a recording."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import numpy.typing as npt

from ...decide import Slip
from ...decide.verdict import SlipVerdict
from ...estimate.either import Either
from ...estimate.estimate import Estimate, Status
from .table import contact_of, unknowns_of

__all__ = ["decided_columns", "found_columns"]

Columns = dict[str, npt.NDArray[Any]]

_STATUS: npt.NDArray[np.object_] = np.array([status.name.lower() for status in Status], dtype=object)
_SLIP: Mapping[int, str] = {int(verdict): verdict.name.lower() for verdict in SlipVerdict}


def found_columns(axes: str, parts: list[Any]) -> Columns:
    """The columns of estimates, one after the other.

    Parameters
    ----------
    axes : str
        "y" or "yz".
    parts : list of Estimate or Either
        All of one kind.
    """
    whole = type(parts[0]).join(parts) if len(parts) > 1 else parts[0]
    columns = _either(whole, axes) if isinstance(whole, Either) else _estimate(whole, axes)
    return {**columns, "status": _STATUS[whole.status]}


def _estimate(found: Estimate, axes: str) -> Columns:
    layout, position = found.layout, found.position
    position = position[:, None] if layout.dim == 1 else position
    columns: Columns = dict(zip(contact_of(axes), np.hstack([position, found.components]).T, strict=True))
    unknown, covariance = unknowns_of(axes), found.table[:, layout.square]
    for i, a in enumerate(unknown):
        for j in range(i, len(unknown)):
            columns[f"cov.{a}.{unknown[j]}"] = covariance[:, i, j]
    kind = "point" if layout.dim == 2 or layout.aside else "line"
    columns["load"] = np.where(np.isfinite(columns["normal"]), kind, "").astype(object)
    columns |= {name: getattr(found, name) for name in ("half_width", "beside", "residual")}
    return {**columns, "second_chi2": found.second.chi2}


def _either(found: Either, axes: str) -> Columns:
    """The likelier of the two; the position is that of both together."""
    point = found.point_probability >= 0.5
    line, other = _estimate(found.line, axes), _estimate(found.point, axes)
    columns: Columns = {name: np.where(point, other[name], line[name]) for name in line}
    columns |= {"position_y": found.position, "cov.y.y": found.position_std**2}
    columns["load"] = np.where(np.isfinite(found.position), columns["load"], "").astype(object)
    return {**columns, "point_probability": found.point_probability}


def decided_columns(parts: list[Slip]) -> Columns:
    """The columns of decisions about slip, one after the other.

    Parameters
    ----------
    parts : list of Slip
        Each of shape (n,).
    """
    ratio, told = (np.concatenate([getattr(part, name) for part in parts]) for name in ("ratio", "probability"))
    verdict = np.concatenate([part.verdict for part in parts])
    names = np.array([_SLIP[int(v)] for v in verdict], dtype=object)
    return {"slip": names, "slip_ratio": ratio, "slip_probability": told}
