"""Arguments of contacts of one shape: what is declared of them, and the two forms of a force."""

from __future__ import annotations

from inspect import Parameter, Signature
from typing import Any

import numpy as np
import numpy.typing as npt

from .. import _check
from .._check import FloatArray
from .._declared import Ruled
from ..errors import GeometryError, InvalidValueError

__all__ = ["Row", "SignatureOf", "resolved"]

_TURN = 2.0 * np.pi


def Row(count: int, unit: str, what: str, above: float | None = None, fix: str = "") -> Ruled:
    """A declaration: an array whose last axis has `count` numbers."""

    def rule(name: str, value: Any) -> FloatArray:
        array = _check.real(name, value, unit=unit, above=above, fix=fix)
        if array.shape[-1:] != (count,):
            raise GeometryError(f"{name} of shape {array.shape}", f"(..., {count}) is needed, {what} [{unit}]", fix)
        return array

    return Ruled(rule)


class SignatureOf:
    """The signature of a class of contacts, for `help` and editors: a force, where it acts, and the class's lengths."""

    def __init__(self, *first: str) -> None:
        self._first = first  # what comes before the force

    def __get__(self, contact: object, kind: Any) -> Signature:
        either, alone = Parameter.POSITIONAL_OR_KEYWORD, Parameter.KEYWORD_ONLY
        own = kind._lengths()
        first = [Parameter(name, either) for name in self._first]
        first += [Parameter(name, either, default=None) for name in ("force", "angle", "azimuth")]
        first += [Parameter("position", either, default=(0.0, 0.0))]
        first += [Parameter(f.name, either, default=f.default) for f in own if not f.kw_only]
        last = [Parameter(f.name, alone, default=f.default) for f in own if f.kw_only]
        last += [Parameter("components", alone, default=None), Parameter("moment", alone, default=0.0)]
        return Signature([*first, *last])


def resolved(
    force: npt.ArrayLike | None,
    angle: npt.ArrayLike | None,
    azimuth: npt.ArrayLike | None,
    components: npt.ArrayLike | None,
) -> npt.ArrayLike:
    """(N, Ty, Tz) from either form."""
    if components is not None:
        if any(value is not None for value in (force, angle, azimuth)):
            raise InvalidValueError("components and force, angle or azimuth", "they say the same: one form is needed")
        return components
    if force is None:
        fix = "force=1.5, angle=0.3, azimuth=0.8, or components=(1.4, 0.3, 0.3)"
        raise InvalidValueError("no force", "a magnitude, or its components, is needed", fix)
    p = _check.real("force", force, unit="N", at_least=0.0, fix="turn the angle instead")
    fix = "angles are in radians, from the inward normal: np.deg2rad(30); the azimuth says to which side"
    alpha = _check.real("angle", 0.0 if angle is None else angle, unit="rad", at_least=0.0, at_most=np.pi, fix=fix)
    fix = "angles are in radians: np.deg2rad(90)"
    given = 0.0 if azimuth is None else azimuth
    theta = _check.real("azimuth", given, unit="rad", at_least=-_TURN, at_most=_TURN, fix=fix)
    out = np.empty((*_check.broadcast(force=p, angle=alpha, azimuth=theta), 3))
    out[..., 0] = p * np.where(alpha == 0.5 * np.pi, 0.0, np.cos(alpha))
    drag = p * np.where(alpha == np.pi, 0.0, np.sin(alpha))
    out[..., 1], out[..., 2] = drag * np.cos(theta), drag * np.sin(theta)
    return out
