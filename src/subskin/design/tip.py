"""How wrong is the flat layer on a round tip? A table, worked out once, for a cylinder and for a ball."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache
from importlib import resources
from typing import Any, Literal

import numpy as np

from .. import _check
from .._check import FloatArray
from .._declared import Length, checked
from ..errors import GeometryError, InvalidValueError
from ..finger import Finger
from ..transducer import kind_of

__all__ = ["TipError", "tip_error", "tip_map"]

Shape = Literal["cylinder", "sphere"]
_QUANTITIES = ("reading", "position", "force", "angle")


@dataclass(frozen=True)
class TipError:
    """What `tip_error` found: the worst errors of a flat layer on a round tip.

    Parameters
    ----------
    shape : {"cylinder", "sphere"}
        What the tip is: a cylinder under long contacts, or a ball under touches.
    radius, thickness, depth : float
        Of the surface, of the skin, and of the sensors on average [m].
    kinds : tuple of str
        The kinds of sensors of the table that were looked up.
    reading : float
        Largest difference of a reading, over the largest reading [-].
    position, force, angle : float
        Errors of `locate` with the flat layer: of the position [m], of the force over the true one [-], of the angle
        [rad]. Angles beyond 45 degrees are never found, so an error of 0.4 rad or more may stand for any.
    """

    shape: Shape
    radius: float
    thickness: float
    depth: float
    kinds: tuple[str, ...]
    reading: float
    position: float
    force: float
    angle: float


@checked
def tip_error(finger: Finger, radius: Length, shape: Shape | None = None) -> TipError:
    """Worst errors made by taking the skin of `finger`, bent to a tip of a `radius`, for a flat layer.

    They are those of one incompressible layer on a rigid core, looked up by radius and depth in thicknesses: sensors
    one depth apart, six in a row under line loads, or 4 x 4 under touches, straight down and leaning by 0.4 rad, free
    of noise (benchmarks/study_tips.py). Between the table's numbers they are interpolated; for larger radii they
    fall as 1 / radius. Depths below 0.2 and above 0.8 thicknesses are taken for these.

    Parameters
    ----------
    finger : Finger
        With a flat skin on a rigid base.
    radius : float
        Radius of the tip's surface [m], at least 2 thicknesses.
    shape : {"cylinder", "sphere"}, optional
        What the tip is; a ball where the sensors lie on an area, else a cylinder.

    Raises
    ------
    InvalidValueError, GeometryError
        A skin that is round or has no base, another shape, a radius that is too small for the table.

    Examples
    --------
    Four millimetres of rubber on a ball of 16 mm, sensors half way down.

    >>> import subskin as ss
    >>> skin = ss.Layered(ss.Layer(ss.Material(young=0.4e6), thickness=4e-3))
    >>> array = ss.SensorArray.grid((4, 4), pitch=2e-3, depth=2e-3, transducer=ss.MeanPressure())
    >>> error = tip_error(ss.Finger(skin, array), radius=16e-3)
    >>> round(error.reading, 2), error.shape
    (0.11, 'sphere')
    """
    skin, array = finger.skin, finger.array
    if skin.curvature or not np.isfinite(skin.thickness):
        rule = "the table compares a flat layer on a rigid base with the same on a tip"
        fix = 'kind = "layers" without [skin.base]'
        raise InvalidValueError(f"a tip's radius beside {skin}", rule, fix)
    form: Shape = ("sphere" if array.on_area else "cylinder") if shape is None else shape
    least = float(_table()["radius"][0])
    if radius < least * skin.thickness:
        seen = f"radius = {radius:.6g} m of a skin of {skin.thickness:.6g} m"
        raise GeometryError(seen, f"the table begins at {least:g} thicknesses", "a larger radius, or a thinner skin")
    own = {kind_of(kind) for kind in array.transducers}
    looked_up = tuple(kind for kind in sorted(_known(form)) if kind in own or not own <= _known(form))
    depth = float(np.asarray(array.depth).mean())
    found = np.max([_at(form, name, radius / skin.thickness, depth / skin.thickness) for name in looked_up], axis=0)
    reading, position, force, angle = found.tolist()
    return TipError(form, radius, skin.thickness, depth, looked_up, reading, position * depth, force, angle)


@checked
def tip_map(shape: Shape, kind: str) -> dict[str, FloatArray]:
    """The table behind `tip_error`.

    Parameters
    ----------
    shape : {"cylinder", "sphere"}
        What the tip is.
    kind : {"normal_strain", "mean_pressure"}
        What the sensors measure.

    Returns
    -------
    dict
        `radius` (m,) and `depth` (k,), in thicknesses of the skin, and arrays (m, k): `reading`, `position` [depths],
        `force` and `angle` [rad], as in `TipError`.

    Examples
    --------
    >>> tip_map("sphere", "normal_strain")["reading"].shape
    (6, 4)
    """
    table = _table()
    _check.choice("kind", kind, sorted(_known(shape)))
    errors = table["errors"][shape][kind]
    return {
        "radius": table["radius"],
        "depth": table["depth"],
        **{name: errors[:, :, i] for i, name in enumerate(_QUANTITIES)},
    }


def _known(shape: str) -> set[str]:
    return set(_table()["errors"][shape])


def _at(shape: str, kind: str, radius: float, depth: float) -> FloatArray:
    """The errors at a radius and a depth in thicknesses, straight in the logarithms of errors and radius."""
    table = _table()
    radii, depths = table["radius"], table["depth"]
    logs = np.log(np.maximum(table["errors"][shape][kind], 1e-6))
    along = np.array([[np.interp(depth, depths, row) for row in values.T] for values in logs])
    beyond = max(radius / radii[-1], 1.0)
    errors = [np.interp(np.log(radius), np.log(radii), column) for column in along.T]
    return np.asarray(np.exp(errors) / beyond)


@lru_cache(maxsize=1)
def _table() -> Mapping[str, Any]:
    read = json.loads(resources.files(__package__).joinpath("tips.json").read_bytes())
    errors = {s: {k: _check.read_only(np.array(v)) for k, v in kinds.items()} for s, kinds in read["errors"].items()}
    lengths = {name: _check.read_only(np.array(read[name])) for name in ("radius", "depth")}
    return {**lengths, "errors": errors}
