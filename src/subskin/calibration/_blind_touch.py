"""What an unlabelled touch is: a load of d = 1 or 2 coordinates, of a known half width, straight or with drag."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from .._check import FloatArray
from ..array import SensorArray
from ..contact import Hertz, LineLoad, PointLoad, RoundHertz
from ..contact.base import Contact
from ..contact.local import LocalContact
from ..estimate.area import AreaLocator, RoundLocator
from ..estimate.area.locator import reach_of
from ..estimate.estimate import Estimate
from ..estimate.search import Locator
from ..finger import Finger
from ..radial import tabulate_radial
from ..radial_round import tabulate_round
from ..response import Response

__all__ = ["UnknownTouch"]


class UnknownTouch(NamedTuple):
    """The kind of all touches.

    Parameters
    ----------
    dim : {1, 2}
        1 for line loads on a row, 2 for loads on an area.
    friction : float
        0 for touches that press straight down.
    half_width : float
        Of a Hertz contact [m]; 0 for a line or a point.
    """

    dim: int
    friction: float
    half_width: float = 0.0

    @property
    def loads(self) -> int:
        """How many components of force a touch has."""
        return 1 if self.friction == 0 else self.dim + 1

    @property
    def unknowns(self) -> int:
        """How many unknowns a touch has."""
        return self.dim + self.loads

    def fields(self, finger: Finger, positions: FloatArray) -> FloatArray:
        """Readings (m, n, k) under unit forces at `positions` (m, d) [m], without offsets."""
        units = np.eye(self.dim + 1)[: self.loads]
        wide = {"half_width": self.half_width} if self.half_width else {}
        if self.dim == 1:
            long: type[LineLoad | Hertz] = Hertz if wide else LineLoad
            contact: Contact | LocalContact = long.of_components(units, positions, **wide)
        else:
            local: type[PointLoad | RoundHertz] = RoundHertz if wide else PointLoad
            contact = local(components=units, position=positions[:, None], **wide)
        measured = np.swapaxes(finger.measure(contact, linear=True), -1, -2)
        out = np.asarray(finger.array.gain)[:, None] * measured
        out[..., 0] += np.asarray(finger.array.lift)
        return np.asarray(out)

    def locate(self, finger: Finger, array: SensorArray, ends: FloatArray, readings: FloatArray) -> Estimate:
        """Touches (m,) on `finger` within `ends` (d, 2) [m], by the noise of `array`."""
        widths = (self.half_width, self.half_width)
        y = (float(ends[0, 0]), float(ends[0, 1]))
        if self.dim == 1:
            response = Response.of(finger, Hertz if self.half_width else LineLoad, y, self.half_width)
            return Locator(response, array, half_width=widths, friction=self.friction)(readings)
        reach, box = reach_of(array, ends), (y, (float(ends[1, 0]), float(ends[1, 1])))
        if self.half_width:
            table = tabulate_round(finger, RoundHertz, reach, self.half_width)
            return RoundLocator(table, array, box, widths, friction=self.friction)(readings)
        return AreaLocator(tabulate_radial(finger, reach), array, box, friction=self.friction)(readings)
