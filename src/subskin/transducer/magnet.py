"""A magnet in the skin above a magnetometer: how far it moves is read from its field."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Annotated, Literal

import numpy as np

from .._check import FloatArray
from .._declared import Length, Real
from ..errors import InvalidValueError, NotLinearError
from ..tensor import State, Tilt
from .base import Transducer

__all__ = ["MagnetDisplacement"]

_MU_0_4PI = 1.25663706127e-6 / (4 * np.pi)  # T m/A, CODATA 2022


@dataclass(frozen=True, repr=False)
class MagnetDisplacement(Transducer, name="magnet_displacement"):
    """Change of one component of the field of a magnet that moves with the skin [T], three of them a magnetometer.

    The magnet lies at the sensor's position and depth, magnetised along the depth; the magnetometer lies `gap` beneath
    it and does not move. A dipole's field at r from it is

        B = (mu_0 / 4 pi) [3 (m . r) r / r^2 - m] / r^3,    r = (gap, 0, 0) - u,

    u being the displacement of the skin (Jackson, Classical Electrodynamics, 1999, eq. 5.56). To first order
    B_x changes by 6 c u_x / gap^4, B_y by -3 c u_y / gap^4 and B_z by -3 c u_z / gap^4, c = mu_0 m / 4 pi. With
    `tilts` the magnet turns with the material, by t (`State.tilt`): m = |m| (cos |t|, t sin |t| / |t|), and to first
    order B_y changes by -c t_y / gap^3 more, B_z by -c t_z / gap^3. The magnet is small beside the gap. Known where the
    skin knows its displacement.

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
    tilts : bool, optional
        False (the default) for a magnet that stays upright; True for one that turns as the material around it does.

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
    >>> leans = MagnetDisplacement("y", moment=7.9e-3, gap=3e-3, tilts=True)
    >>> round(1e3 * float(leans.measure(felt)), 2)
    -4.63
    """

    axis: Literal["x", "y", "z"]
    moment: Annotated[float, Real("A*m^2")] = field(metadata={"unit": "A*m^2"})
    gap: Length = field(metadata={"unit": "m"})
    exact: bool = False
    tilts: bool = False

    unit = "T"

    def __post_init__(self) -> None:
        super().__post_init__()
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
        seen = f"{self!r} under such a contact"
        moved, strength = state.moved(seen), _MU_0_4PI * self.moment
        leans = state.tilted(seen) if self.tilts else Tilt(np.zeros(()), np.zeros(()))
        deep = self.axis == "x"
        along: FloatArray = getattr(moved, self.axis)
        if not self.exact:
            if deep:
                return np.asarray(6 * strength / self.gap**4 * along)
            lean: FloatArray = getattr(leans, self.axis)
            return np.asarray(-strength / self.gap**4 * (3 * along + self.gap * lean))
        # r = (down, -u_y, -u_z); up + the leaning part is the magnet's direction
        down, angle = self.gap - moved.x, np.hypot(leans.y, leans.z)
        share, up = np.sinc(angle / np.pi), np.cos(angle)
        my, mz = share * leans.y, share * leans.z
        far = down**2 + moved.y**2 + moved.z**2
        across = up * down - my * moved.y - mz * moved.z
        own, distance = {"x": (up, down), "y": (my, -moved.y), "z": (mz, -moved.z)}[self.axis]
        with np.errstate(divide="ignore", invalid="ignore"):
            field = (3 * across * distance - own * far) * strength / far**2.5
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
