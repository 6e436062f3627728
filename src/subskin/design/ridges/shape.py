"""Ridges: the share of a contact's pressure that they let through, position by position."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Annotated, Any, ClassVar, Literal, get_args

import numpy as np
import numpy.typing as npt

from ... import _check
from ..._check import FloatArray
from ..._declared import Noun, Real, Ruled, checked
from ...errors import InvalidValueError

__all__ = ["Ridges"]

ShapeName = Literal["abs_cos", "cos_squared", "raised_cosine", "square"]

_KNOWN: dict[str, tuple[Callable[[FloatArray], FloatArray], float]] = {
    "abs_cos": (lambda u: np.abs(np.cos(np.pi * u)), 2 / np.pi),
    "cos_squared": (lambda u: np.asarray(np.cos(np.pi * u) ** 2), 0.5),
    "raised_cosine": (lambda u: np.asarray((2 + np.cos(2 * np.pi * u)) / 3), 2 / 3),
}
"""Shapes by name, over a pitch, with their means."""
_DUTY = 2 / 3
_SAMPLES = 513
_MOST = 10**6
_NEAR = 8.0 ** -np.arange(1, 5)
"""Distances from a kink of one's own shape, in pitches, at which panels end."""

_SMOOTH = 1e-5


def _shape(name: str, value: Any) -> Any:
    """One of the known shapes, or a function."""
    fix = 'shape="raised_cosine", or a function of the distance in pitches'
    return value if callable(value) else _check.choice(name, value, get_args(ShapeName), fix)


@dataclass(frozen=True, eq=False)
class Ridges(Noun):
    """Ridges over a contact: the share of the pressure, and of the drag, that they let through at each position.

    They belong to the skin, or to what touches it: to first order only the sum of the two profiles counts.

    Parameters
    ----------
    pitch : array_like
        From crest to crest [m], > 0.
    shape : {"abs_cos", "cos_squared", "raised_cosine", "square"} or callable, optional
        |cos(pi u)|, its square, (2 + cos(2 pi u))/3, or 1 for |u| < duty/2 and else 0, u being the distance from the
        crest in pitches; or one's own, a function of u in [-1/2, 1/2] with values from 0 to 1 and 1 at u = 0.
    crest : array_like, optional
        Position y of a crest [m].
    duty : float, optional
        Share of a pitch that a "square" ridge is wide, in (0, 1]; 2/3 if left out.
    kinks : sequence of float, optional
        Where one's own shape is not smooth besides crests and troughs, in [-1/2, 1/2].

    Raises
    ------
    InvalidValueError, GeometryError
        A value out of range, a shape of no known name, shares that are no shares; arrays that do not broadcast.

    Examples
    --------
    >>> ridges = Ridges(pitch=3e-3)
    >>> ridges.share([0.0, 1e-3, 1.5e-3]).round(6).tolist(), round(ridges.mean, 6)
    ([1.0, 0.5, 0.0], 0.63662)
    """

    pitch: Annotated[npt.ArrayLike, Real("m", above=0.0)]
    shape: Annotated[ShapeName | Callable[[FloatArray], FloatArray], Ruled(_shape)] = "abs_cos"
    crest: Annotated[npt.ArrayLike, Real("m")] = 0.0
    duty: Annotated[float | None, Real(above=0.0, at_most=1.0)] = None
    kinks: tuple[Annotated[float, Real(at_least=-0.5, at_most=0.5)], ...] = ()

    EXAMPLE: ClassVar = "Ridges(pitch=3e-3)"

    def __post_init__(self) -> None:
        super().__post_init__()
        self._common_shape()
        with_shape = f"with shape = {self.shape!r}"
        if self.shape == "square":
            object.__setattr__(self, "duty", _DUTY if self.duty is None else self.duty)
        elif self.duty is not None:
            rule = "only square ridges have a duty"
            raise InvalidValueError(f"duty = {self.duty!r} {with_shape}", rule, 'shape="square"')
        if not callable(self.shape):
            if self.kinks:
                rule = "the kinks of that shape are known"
                raise InvalidValueError(f"kinks = {self.kinks!r} {with_shape}", rule, "leave out kinks")
            return
        share = self._unit(np.linspace(-0.5, 0.5, _SAMPLES))
        low, high, top = (float(v) for v in (share.min(), share.max(), share[_SAMPLES // 2]))
        if not (low >= 0 and high <= 1 + 1e-12 and abs(top - 1) < 1e-12):  # NaN is none of them
            seen = f"shares from {low:.6g} to {high:.6g}, {top:.6g} at the crest"
            rule = "a ridge lets through from 0 to 1 of the pressure, and all of it at its crest, u = 0"
            raise InvalidValueError(seen, rule, "divide the shape by its value at u = 0")
        whole, halves = self._integral(1), self._integral(2)
        if abs(whole - halves) > _SMOOTH:
            seen = f"a mean share of {whole:.6g} or {halves:.6g}, as the nodes lie"
            rule = "the shape has to be smooth between u = -1/2, 0, 1/2 and its kinks"
            raise InvalidValueError(seen, rule, "kinks=, the positions where it is not")

    @property
    def batch(self) -> tuple[int, ...]:
        """Shape that pitch and crest have together."""
        return np.broadcast_shapes(np.shape(self.pitch), np.shape(self.crest))

    @checked
    def share(self, y: Annotated[npt.ArrayLike, Real("m")]) -> FloatArray:
        """Share of the smooth pressure that is left at `y` [m], which broadcasts against the pitch."""
        u = (np.asarray(y) - np.asarray(self.crest)) / np.asarray(self.pitch)
        return _check.read_only(self._unit(u - np.round(u)))

    @property
    def mean(self) -> float:
        """Mean of the share over a pitch."""
        if callable(self.shape):
            return self._integral(2)
        return _KNOWN[self.shape][1] if self.shape in _KNOWN else float(self.duty or 0.0)

    @property
    def _corners(self) -> FloatArray:
        """Positions [pitches] between which the share is smooth, in [-1/2, 1/2]."""
        half = [0.5 * self.duty] if self.duty is not None else []
        kinks = np.asarray(self.kinks, dtype=np.float64)
        near = np.add.outer(kinks, np.concatenate([-_NEAR, [0.0], _NEAR])).reshape(-1)
        return np.unique([-0.5, 0.0, 0.5, *half, *(-h for h in half), *near[np.abs(near) <= 0.5]])

    def _integral(self, parts: int) -> float:
        """Integral of the share over a pitch, each stretch between corners in so many parts."""
        corners = self._corners
        ends = np.append((corners[:-1, None] + np.outer(np.diff(corners), np.arange(parts) / parts)), 0.5)
        t, w = np.polynomial.legendre.leggauss(16)
        half = 0.5 * np.diff(ends)[:, None]
        return float((self._unit(ends[:-1, None] + half * (1 + t)) * half * w).sum())

    def _unit(self, u: FloatArray) -> FloatArray:
        if callable(self.shape):
            values = np.asarray(self.shape(u))
            if values.dtype.kind not in "biuf":
                seen = f"shape(u) gave {_check.shown(values)}"
                raise InvalidValueError(seen, "real numbers are needed", "np.vectorize(shape)")
            if values.shape != u.shape:
                seen = f"shares of shape {values.shape} from distances of shape {u.shape}"
                rule = "the shape of a ridge has to be a function of an array"
                raise InvalidValueError(seen, rule, "np.vectorize(shape)")
            return values
        if self.shape in _KNOWN:
            return _KNOWN[self.shape][0](u)
        return np.where(np.abs(u) <= 0.5 * float(self.duty or 0.0), 1.0, 0.0)

    def breaks(self, low: FloatArray, high: FloatArray) -> FloatArray:
        """Crests, troughs and kinks from `low` to `high` [m], shape (..., k); what is too many lies beyond them."""
        low, high = _check.real("low", low, unit="m"), _check.real("high", high, unit="m")
        pitch, crest = np.asarray(self.pitch)[..., None], np.asarray(self.crest)[..., None]
        first = np.floor((low[..., None] - crest) / pitch)
        most = float(((high - low) / np.asarray(self.pitch)).max(initial=0.0))
        if most > _MOST:
            seen = f"{most:.3g} ridges from low to high"
            raise InvalidValueError(seen, f"at most {_MOST} are counted", "a shorter piece, or a larger pitch")
        count = int(np.ceil(most)) + 2
        u = np.add.outer(np.arange(count), np.unique(self._corners % 1.0))
        return np.asarray(crest + pitch * (first + u.reshape(-1)))
