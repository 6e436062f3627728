"""Two-point touches of one finger, and how far their readings are from those of any one contact."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from ... import _check
from ..._check import FloatArray
from ...finger import Finger
from ..touches import Touches
from ._one_contact import OneContact

__all__ = ["Pairs"]


class Pairs:
    """Pairs of points over positions of the middle, splits of the force and angles.

    Parameters
    ----------
    finger, touches : Finger, Touches
        As of `two_point_limen`.
    wide : bool
        Whether the one contact has a width.
    angle : {"normal", "known", "free"}
        What is known of the angles.
    positions, angles : int
        How many of each.
    share : ndarray, shape (q,)
        Shares of the point at lower y.
    largest : float
        Largest separation [m].
    """

    def __init__(
        self,
        finger: Finger,
        touches: Touches,
        *,
        wide: bool,
        angle: str,
        positions: int,
        angles: int,
        share: FloatArray,
        largest: float,
    ) -> None:
        low, high = touches.span_on(finger)
        position, _ = touches.grid(positions, 1, finger)
        single = angle == "normal" or angles == 1
        # the ends of the cone among them, for it is there that two points are told worst
        cone = np.zeros(1) if single else touches.cone * np.linspace(-1.0, 1.0, angles)
        first, second = np.meshgrid(cone, cone, indexing="ij") if angle == "free" else (cone, cone)
        self.position, self.share = _check.read_only(position), _check.read_only(share)
        self.lean = _check.read_only(np.stack([first.ravel(), second.ravel()], axis=-1))
        self._force = touches.force
        self._one = OneContact(
            finger,
            (low - 0.5 * largest, high + 0.5 * largest),
            wide=wide,
            friction=touches.friction if angle == "free" else None,
            largest=largest,
        )
        self.spare, self._known = self._one.spare, angle != "free"

    @property
    def shape(self) -> tuple[int, int, int]:
        """Numbers of positions, shares and pairs of angles."""
        return self.position.size, self.share.size, len(self.lean)

    def distance(self, separation: FloatArray, pairs: npt.NDArray[np.intp]) -> FloatArray:
        """Distance to the nearest one contact, of some pairs (k,) at separations (s, k) [m], shape (s, k).

        Pairs are numbered as `shape` is read. In standard deviations of the noise; 0 where there are fewer readings
        than unknowns, for then one contact explains them all.
        """
        out = np.zeros(separation.shape)
        if self.spare < 0:
            return out
        position, share, lean = np.unravel_index(pairs, self.shape)
        middle, part, angles = self.position[position], self.share[share, None], self.lean[lean]
        lower = self._one.line(middle - 0.5 * separation, angles[:, 0])
        upper = self._one.line(middle + 0.5 * separation, angles[:, 1])
        readings = self._force * (part * lower + (1 - part) * upper)
        for angle in np.unique(angles[:, 0]) if self._known else (0.0,):
            chosen = angles[:, 0] == angle if self._known else slice(None)
            out[:, chosen] = self._one.distance(readings[:, chosen], float(angle))
        return out
