"""A magnet in the skin above a magnetometer: how far it moves is read from its field."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Literal

import numpy as np

from .. import _check
from .._check import FloatArray
from ..errors import InvalidValueError, NotLinearError
from ..tensor import State
from .base import Transducer
from .directed import known_axis

__all__ = ["MagnetDisplacement"]

_MU_0_4PI = 1.25663706127e-6 / (4 * np.pi)  # T m/A, CODATA 2022


@dataclass(frozen=True, repr=False)
class MagnetDisplacement(Transducer, name="magnet_displacement"):
    """Change of one component of the field of a magnet that moves with the skin [T], three of them a magnetometer.

    The magnet lies at the sensor's position and depth, magnetised along the depth; the magnetometer lies `gap` beneath
    it and does not move. A dipole's field at r from it is

        B = (mu_0 / 4 pi) [3 (m . r) r / r^2 - m] / r^3,    r = (gap, 0, 0) - u,

    u being the displacement of the skin (Jackson, Classical Electrodynamics, 1999, eq. 5.56). To first order
    B_x changes by 6 c u_x / gap^4, B_y by -3 c u_y / gap^4 and B_z by -3 c u_z / gap^4, c = mu_0 m / 4 pi. The magnet
    is small beside the gap, and is taken to stay upright. Known where the skin knows its displacement.

    Parameters
    ----------
    axis : {"x", "y", "z"}
        The component of the field.
    moment : float
        Magnetic moment [A m^2], not 0, positive into the skin: remanence times volume over mu_0.
    gap : float
        Distance of the magnetometer beneath the magnet [m], > 0.
    exact : bool, optional
        False (the default) for the first order, which is linear in the load; True for the whole field, NaN where the
        magnet would pass the magnetometer.

    Raises
    ------
    InvalidValueError
        Another axis, a moment of 0, a gap <= 0; on measuring, a displacement that is not known.

    Examples
    --------
    A disc of 3 mm by 1 mm with a remanence of 1.4 T, 3 mm above the magnetometer, pressed down with 1 N beside it.

    >>> import subskin as ss
    >>> three = [MagnetDisplacement(axis, moment=7.9e-3, gap=3e-3) for axis in "xyz"]
    >>> felt = ss.HalfSpace(ss.Material(young=0.4e6)).state(ss.PointLoad(force=1.0), x=2e-3, y=2e-3, z=0.0)
    >>> [round(1e3 * float(kind.measure(felt)), 2) + 0.0 for kind in three]  # mT
    [18.52, -3.09, 0.0]
    """

    axis: Literal["x", "y", "z"]
    moment: float = field(metadata={"unit": "A*m^2"})
    gap: float = field(metadata={"unit": "m"})
    exact: bool = False

    unit = "T"

    def __post_init__(self) -> None:
        known_axis(self.axis)
        object.__setattr__(self, "moment", _check.scalar("moment", self.moment, unit="A*m^2"))
        object.__setattr__(self, "gap", _check.scalar("gap", self.gap, unit="m", above=0.0))
        if not self.moment:
            raise InvalidValueError("moment = 0", "a magnet is needed: its moment is not 0 [A m^2]", "moment=5e-3")

    @property
    def component(self) -> str:  # type: ignore[override]
        """The component of the field that a picture of the skin shows beside it."""
        return f"displacement.{self.axis}"

    @property
    def linear(self) -> bool:  # noqa: D102
        return not self.exact

    def measure(self, state: State) -> FloatArray:  # noqa: D102
        moved, strength = state.moved(f"{self!r} under such a contact"), _MU_0_4PI * self.moment
        along: FloatArray = getattr(moved, self.axis)
        deep = self.axis == "x"
        if not self.exact:
            return np.asarray((6 if deep else -3) * strength / self.gap**4 * along)
        down, square = self.gap - moved.x, moved.y**2 + moved.z**2
        far = down**2 + square
        with np.errstate(divide="ignore", invalid="ignore"):
            field = (2 * down**2 - square if deep else -3 * down * along) * strength / far**2.5
        rest = 2 * strength / self.gap**3 if deep else 0.0
        return np.where(down > 0, field - rest, np.nan)

    def linearise(self, measured: FloatArray) -> FloatArray:
        """The same where it is of the first order.

        Parameters
        ----------
        measured : ndarray, shape (...)
            Change of the field [T].

        Raises
        ------
        NotLinearError
            The whole field: one component of it does not tell the displacement.
        """
        if self.linear:
            return measured
        rule = "one component of the whole field is not proportional to the load and cannot be made so"
        raise NotLinearError(f"transducer {self!r}", rule, "exact=False to locate, exact=True to simulate")

    @property
    def linear_part(self) -> MagnetDisplacement:  # noqa: D102
        return replace(self, exact=False)
