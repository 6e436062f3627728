"""Readings -> the pressure along the surface, and the shear where the array can see it."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from ..._check import FloatArray
from ...finger import Finger
from ..frames import sensor_rows
from ._operator import COARSE, Factors, Surface, shear_seen
from .columns import WIDTH
from .map import PressureMap
from .mapping import RULES, SurfaceMapper, free_only_where_seen, known
from .prior import Bridge

__all__ = ["PressureMapper"]

_LEANS = 17
_STRIPS = (0.75, 1.5, 3.0)
_LEAST_SEEN = 0.2


class PressureMapper(SurfaceMapper):
    """Finds the pressure along the surface in frames of readings; prepared once, then called on a frame or on many.

    The surface is cut into elements much finer than the sensors are deep, and the pressure p at their nodes is the one
    that minimises

        chi-square + weight * integral (dp/dy)^2 dy + 2 least_force * (normal force) / (its least standard deviation)

    over all p >= 0 that are 0 at the ends of the search. The weight follows from each frame by `rule`; the minimum is
    unique and found exactly (docs/pressure.md).

    Parameters
    ----------
    finger : Finger
        The skin, of any kind, and the sensors in it.
    search : (float, float), optional
        Stretch of the surface that is mapped, y [m]; 1.5 depths beyond the outermost sensors if left out.
    step : float, optional
        Largest distance of the nodes [m]; a twelfth of the shallowest sensor's depth if left out.
    shear : {"proportional", "none", "free"}, optional
        Shear q = p tan(angle) with one unknown angle; none, for contacts that are known not to drag (drag would be
        taken for pressure elsewhere); or any shear with |q| <= friction * p, which asks for sensors of two kinds, or in
        two depths.
    friction : float, optional
        Bound of |q| / p [-]; of no account without shear.
    rule : {"evidence", "discrepancy", "gcv"}, optional
        The weight: most probable; the one that leaves a chi-square of n; or generalised cross-validation. Each for the
        smoothest p without regard to its sign, and the largest such weight.
    least_force : float, optional
        How far a line load's force is pulled down, in its standard deviations. Without it a wide and faint pressure, of
        which the sensors read nothing, is added for the sake of smoothness.
    false_alarm : float, optional
        Probability with which an untouched skin, or a pressure >= 0, is called a contact, or unexplained.

    Attributes
    ----------
    y : ndarray
        The nodes [m], (m,).
    shear_seen : float
        Share of the shear's components that are seen beside an unknown pressure; "free" needs 0.2.

    Raises
    ------
    InvalidValueError
        An option out of range; shear "free" where the array cannot separate it from pressure; a sensor without noise.
    GeometryError
        More elements than can be solved for.
    NotLinearError
        A transducer without a linear part.

    Examples
    --------
    >>> import subskin as ss
    >>> skin = ss.HalfPlane(ss.Material(young=0.4e6))
    >>> finger = ss.Finger(skin, ss.SensorArray.line(count=25, pitch=0.5e-3, depth=2e-3, noise=2e-5))
    >>> mapper = PressureMapper(finger, shear="none")
    >>> mapper(finger.read(ss.Hertz(force=40.0, half_width=2e-3))).pressure.shape == mapper.y.shape
    True
    """

    def __init__(
        self,
        finger: Finger,
        *,
        search: tuple[float, float] | None = None,
        step: float | None = None,
        shear: str = "proportional",
        friction: float = 1.0,
        rule: str = "evidence",
        least_force: float = 0.3,
        false_alarm: float = 1e-6,
    ) -> None:
        known(shear, rule)
        self._surface = Surface.of(finger, search, step)
        self.y = self._surface.y
        self._blocks, count = 2 if shear == "free" else 1, len(self.y)
        super().__init__(
            finger, Bridge(count - 2, self._surface.step), drags=1,
            columns=WIDTH + 2 * self._blocks * count, shear=shear, friction=friction, rule=rule,
            least_force=least_force, false_alarm=false_alarm,
        )  # fmt: skip
        normal, tangential = self._columns_of(finger.array.live)
        self.shear_seen = shear_seen(normal, tangential, prior=self._prior, above=1e3)
        if shear == "free":
            free_only_where_seen(self.shear_seen, _LEAST_SEEN, "y, not two", "sensors of another kind or depth as well")
        self.allow_for(finger, self.friction)

    def __call__(self, readings: npt.ArrayLike) -> PressureMap:
        """The pressure in each frame.

        Parameters
        ----------
        readings : array_like, shape (..., n)
            As in `Locator`.

        Returns
        -------
        PressureMap
            Numbers of shape (...), and what lies along the surface of shape (..., m).

        Raises
        ------
        GeometryError
            A last axis that is not the number of sensors.
        """
        return PressureMap(*self._frames(readings), self)

    def factors(self, used: npt.NDArray[np.bool_]) -> list[Factors]:
        """The factors for the sensors `used` (n,), one for each tangent in `tangents`."""

        def make() -> list[Factors]:
            normal, tangential = self._columns_of(used)
            if self.shear == "free":
                return [Factors.of([normal, self.friction * tangential], self._prior)]
            return [Factors.of([normal + t * tangential], self._prior) for t in self.tangents]

        return self._factors.get(used.tobytes(), make)

    def _columns_of(self, used: npt.NDArray[np.bool_]) -> FloatArray:
        """Whitened readings per Pa of the used sensors, of the pressure and of the drag, (2, m, n)."""
        part = self._surface.reading[:, used] / np.asarray(self.finger.array.noise)[used, None]
        return np.ascontiguousarray(np.moveaxis(part, -1, 0))

    @property
    def tangents(self) -> FloatArray:
        """The tangents of the angle at which the factors are known; 0 alone where no angle is sought."""
        if self.shear != "proportional":
            return np.zeros(1)
        return self.friction * np.linspace(-1, 1, _LEANS)

    def _kernel(self) -> Any:
        from ._kernel import map_frames

        return map_frames

    def _prepare(self, pattern: npt.NDArray[np.bool_]) -> tuple[Any, ...]:
        """Arguments of the compiled loop between the frames and the output, for the sensors of `pattern`."""
        from scipy.special import chdtri

        factors, step = self.factors(pattern), self._surface.step
        normal, tangential = self._columns_of(pattern)
        m = len(normal)
        blocks = self._blocks
        if self.shear == "free":
            parts = np.concatenate([normal + self.friction * tangential, normal - self.friction * tangential])[None]
        elif self.shear == "proportional":
            parts = np.stack([normal, tangential])
        else:
            parts = normal[None]
        largest = float(np.linalg.norm(normal, axis=1).max()) / step
        grid = np.arange(COARSE, m + 1, COARSE) - 1
        rows = np.concatenate([grid + k * m for k in range(blocks)])
        most = float(chdtri(int(pattern.sum()), self._false_alarm))
        widths = np.array(_STRIPS) * float(np.asarray(self.finger.array.depth).min()) / step
        basis, squares, shapes = (np.stack([getattr(f, n) for f in factors]) for n in ("basis", "squares", "shapes"))
        starts = np.ascontiguousarray(shapes[:, rows])
        scales = np.array([step, self.friction, blocks, COARSE])
        return (
            sensor_rows(self.finger.array.select(pattern)),
            (self.tangents, basis, squares, shapes**2, factors[0].spread, starts),
            _level(parts, blocks, step, self.least_force * largest),
            _level(_coarsened(parts, blocks), blocks, COARSE * step, self.least_force * largest),
            (self.y[1:-1], scales, *_strips(normal, tangential, widths)),
            np.array([RULES.index(self.rule), most, most]),
        )


def _coarsened(parts: FloatArray, blocks: int) -> FloatArray:
    """Columns of the coarse elements: a wide hat is a sum of narrow ones."""
    count, total, n = parts.shape
    m = total // blocks
    narrow = parts.reshape(count, blocks, m, n)
    share = 1 - np.abs(np.arange(1 - COARSE, COARSE)) / COARSE
    nodes = np.arange(COARSE, m + 1, COARSE) - 1
    wide = sum(s * narrow[:, :, nodes + k] for s, k in zip(share, range(1 - COARSE, COARSE), strict=True))
    return np.ascontiguousarray(np.asarray(wide).reshape(count, -1, n))


def _strips(normal: FloatArray, tangential: FloatArray, widths: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Readings of even pressures over `widths` elements at all positions, from which the angle's search starts."""
    fields = np.stack([normal, tangential])
    sums = np.concatenate([np.zeros_like(fields[:, :1]), np.cumsum(fields, axis=1)], axis=1)
    counts = [1, *(w for w in np.rint(widths).astype(int) if 1 < w < sums.shape[1])]
    strips = np.ascontiguousarray(np.concatenate([(sums[:, w:] - sums[:, :-w])[:, ::2] for w in counts], axis=1))
    products = [np.einsum("mn,mn->m", strips[i], strips[k]) for i, k in ((0, 0), (0, 1), (1, 1))]
    return strips, np.stack(products, axis=1)


def _level(parts: FloatArray, blocks: int, step: float, pull: float) -> tuple[FloatArray, ...]:
    """Columns, Hessian by powers of t, K and the cost of elements of one width."""
    count, total, _ = parts.shape
    gram = [parts[0] @ parts[0].T]
    if count == 2:
        mixed = parts[0] @ parts[1].T
        gram += [mixed + mixed.T, parts[1] @ parts[1].T]
    # with u + v and u - v for the pressure and the shear, the squares of both are twice those of u and v
    beside = np.full(total - 1, -blocks / step)
    beside[total // blocks - 1 :: total // blocks] = 0.0
    return (
        parts,
        np.ascontiguousarray(np.stack(gram)),
        np.full(total, 2.0 * blocks / step),
        beside,
        np.full(total, pull * step),
    )
