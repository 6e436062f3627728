"""Readings -> where, how hard, at what angle: any number of sensors, any receptive field."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from .. import _check
from ..array import SensorArray
from ..errors import GeometryError
from ..receptive_field import ReceptiveField
from ._frames import Framewise, checked_friction, scan_geometry, sensor_rows
from .estimate import RESIDUAL, RIVAL, STATUS, WIDTH, Estimate

__all__ = ["Locator"]


def _kernel() -> Any:
    """The compiled loop, imported on first use."""
    from . import _kernel as module

    return module.locate_frames


class Locator(Framewise):
    """Finds the load in frames of readings; prepared once, then called on a frame or on millions.

    Variable projection: readings are linear in the normal and tangential force, which are eliminated exactly at each
    trial position, within compression and the friction cone; what remains is a search over position (memo section 3;
    docs/locating.md). The two best minima of chi-square are refined; the second is the rival.

    Parameters
    ----------
    field : ReceptiveField
        Readings under unit loads, from a closed form or a table; its ends bound the search.
    array : SensorArray
        Offset, noise and range of each sensor (its gain is in the receptive field; gain 0 marks a dead sensor).
    friction : float, optional
        Coefficient of friction mu: loads lean at most by atan(mu). 0: loads are normal, and the angle is not fitted.
        `inf`: any pressing load.
    scan_step : float, optional
        Step of the search [m]; the default is a thirty-second of the shallowest sensor's depth.
    false_alarm : float, optional
        Probability with which an untouched skin, or a load that the model explains, is called a contact, or
        unexplained.
    ambiguity : float, optional
        A rival whose chi-square is within this of the best one makes a frame AMBIGUOUS.
    outliers : {0, 1}, optional
        With 1, frames that are UNEXPLAINED are tried again without each one reading. Where one omission explains the
        frame, `used` shows which; where another comes within `ambiguity` of its chi-square, the frame is AMBIGUOUS and
        that one's load the rival, if it is the nearest. It takes two readings more than unknowns: five, or four where
        friction is 0 (docs/robust.md).

    Raises
    ------
    InvalidValueError, GeometryError
        A sensor without noise, a table whose sensors do not match the array's, an option out of range.

    Examples
    --------
    >>> import numpy as np, subskin as ss
    >>> skin = ss.HalfPlane(ss.Material(young=0.4e6))
    >>> finger = ss.Finger(skin, ss.SensorArray.line(count=6, pitch=1.5e-3, depth=2e-3, noise=1e-5))
    >>> locator = finger.locator(friction=1.0)
    >>> found = locator(finger.read(ss.LineLoad(force=40.0, angle=0.3, position=0.8e-3)))
    >>> round(float(found.position) * 1e3, 4), round(float(found.force), 2), round(float(found.angle), 4)
    (0.8, 40.0, 0.3)
    """

    def __init__(
        self,
        field: ReceptiveField,
        array: SensorArray,
        *,
        friction: float = 1.0,
        scan_step: float | None = None,
        false_alarm: float = 1e-6,
        ambiguity: float = 13.8,
        outliers: int = 0,
    ) -> None:
        if field.coefficients.shape[2] != len(array):
            raise GeometryError(
                f"a receptive field of {field.coefficients.shape[2]} sensors, an array of {len(array)}",
                "they have to match",
            )
        self.field = field
        self.friction = checked_friction(friction)
        self._ambiguity = _check.scalar("ambiguity", ambiguity, at_least=0.0)
        super().__init__(
            array,
            _kernel,
            needed=2 if self.friction == 0 else 3,
            columns=WIDTH,
            status=STATUS,
            unrivalled=RIVAL + 3,
            residual=RESIDUAL,
            outliers=outliers,
            ambiguity=self._ambiguity,
        )
        shallowest = float(np.asarray(array.depth).min())
        step = (
            shallowest / 32
            if scan_step is None
            else _check.scalar("scan_step", scan_step, unit="m", above=0.0)
        )
        count = max(int(np.ceil((field.stop - field.start) / step - 1e-9)) + 1, 3)
        self._scan = np.linspace(field.start, field.stop, count)
        self._false_alarm = _check.scalar("false_alarm", false_alarm, above=0.0, at_most=0.5)
        self._shallowest = shallowest

    def __call__(self, readings: npt.ArrayLike) -> Estimate:
        """The load in each frame.

        Parameters
        ----------
        readings : array_like, shape (..., n)
            Raw readings, offset included. NaN marks a missing one; it, and a saturated one, are left out of its frame.

        Returns
        -------
        Estimate
            Fields of shape (...).

        Raises
        ------
        GeometryError
            A last axis that is not the number of sensors.
        """
        return Estimate(*self._frames(readings), self.friction)

    def _prepare(self, pattern: npt.NDArray[np.bool_]) -> tuple[npt.NDArray[Any], ...]:
        """Arguments of the compiled loop between the frames and the output, for the sensors of `pattern`."""
        from scipy.special import chdtri

        array, field = self.array.select(pattern), self.field.select(pattern)
        n = len(array)
        scale = 1 / np.asarray(array.noise)
        table = np.ascontiguousarray(np.swapaxes(field.coefficients * scale[:, None], 2, 3))
        basis, edges = scan_geometry(field(self._scan) * scale[:, None], self.friction)
        degrees = max(n - self._needed, 1)
        options = np.array(
            [
                *(field.start, field.step, self._scan[0], self._scan[1] - self._scan[0], self.friction),
                2 * np.log(1 / self._false_alarm),  # less than this explained: no contact
                float(chdtri(degrees, self._false_alarm)),  # more than this left: unexplained
                self._ambiguity,
                0.02 * self._shallowest,  # two minima nearer than this are one load
                0.1 * self._shallowest,  # a profile wider than this may be ambiguous
            ]
        )
        return sensor_rows(array), basis, edges, table, options
