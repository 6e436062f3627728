"""The resultant of whatever presses: force, drag, centre and moments, without its shape."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
import numpy.typing as npt

from ..._check import FloatArray
from ...errors import InvalidValueError
from ...finger import Finger, finger_needed
from ...prepared import prepared
from ...spread import Spread
from ..area.search import search_of
from ..estimate import Estimate
from ..frames import Framewise, sensor_rows
from ..layout import AREA, LINE
from ..shown import Shown
from .bank import bank_of

__all__ = ["Resultant", "ResultantReader", "resultant"]

_FALSE_ALARM = 1e-6
"""Probability with which an untouched skin is called a contact, or readings in a Gaussian scatter unexplained."""


@dataclass(frozen=True, eq=False, repr=False, init=False)
class Resultant(Estimate):
    """The load of whatever presses, frame by frame: an `Estimate` whose position is the centre of pressure.

    Its covariance counts the noise and all that is not known of the pressure's shape. `residual` is chi-square in the
    scatter of the likeliest pressures. There is no rival. Frames that are not `OK` or `AMBIGUOUS` have NaN.

    Parameters
    ----------
    table, used, friction, unknowns, layout, relative
        As in `Estimate`; behind the columns of the layout stand the questions of `bank.py` and their covariance.
    """

    @property
    def centre(self) -> FloatArray:
        """Centre of pressure: y [m], shape (...); on an area (y, z), shape (..., 2)."""
        return self.position

    @cached_property
    def _asked(self) -> tuple[FloatArray, FloatArray]:
        """What was asked (..., q) and its covariance (..., q, q): components, first moments, on an area torsion."""
        d = self.layout.dim
        q = 2 * d + 1 + (d > 1)
        every = self.table[..., self.layout.columns :]
        return every[..., :q], every[..., q:].reshape(*self.shape, q, q)

    @property
    def moments(self) -> FloatArray:
        """Moments of the load about the origin of the surface: about z of a row [N], shape (...).

        On an area about x, y and z [N m], shape (..., 3): the first is torsion.
        """
        values, turn = self._asked[0], self._turn
        return values @ turn if self.layout.dim > 1 else (values @ turn)[..., 0]

    @property
    def moments_covariance(self) -> FloatArray:
        """Covariance of `moments`: shape (...) of a row, (..., 3, 3) on an area."""
        square = np.swapaxes(self._turn, 0, 1) @ self._asked[1] @ self._turn
        return square if self.layout.dim > 1 else square[..., 0, 0]

    @property
    def _turn(self) -> FloatArray:
        """From what was asked to the moments: a force inwards at (y, z) turns by z about y, and by -y about z."""
        if self.layout.dim == 1:
            return np.array([[0.0], [0.0], [-1.0]])
        out = np.zeros((6, 3))
        out[-1, 0], out[4, 1], out[3, 2] = 1.0, 1.0, -1.0
        return out

    @property
    def torsion(self) -> FloatArray:
        """Moment about the inward normal through the centre [N m], shape (...); 0 of a row."""
        if self.layout.dim == 1:
            return np.where(np.isfinite(self.position), 0.0, np.nan)
        y, z, (_, along, across) = *np.moveaxis(self.position, -1, 0), np.moveaxis(self.components, -1, 0)
        return np.asarray(self._asked[0][..., -1] - y * across + z * along)

    @property
    def torsion_std(self) -> FloatArray:
        """Standard deviation of the torsion [N m], shape (...). Where sensors tell nothing of it, it is what may be."""
        if self.layout.dim == 1:
            return self.torsion
        y, z, (n, along, across) = *np.moveaxis(self.position, -1, 0), np.moveaxis(self.components, -1, 0)
        # of N through the centre, of the drag, of the centre's moments
        slope = np.stack([(y * across - z * along) / n, z, -y, -across / n, along / n, np.ones_like(n)], axis=-1)
        return np.asarray(np.sqrt(np.einsum("...i,...ij,...j->...", slope, self._asked[1], slope)))

    def _shown(self) -> list[Shown]:
        more = super()._shown()
        if self.layout.dim > 1:
            more.append(Shown("torsion", 1e3 * self.torsion, 1e3 * self.torsion_std, f"{self.force_unit} mm"))
        return more

    def _columns(self) -> dict[str, Any]:
        columns = {k: v for k, v in super()._columns().items() if not k.startswith("second_")}
        if self.layout.dim > 1:
            columns |= {"torsion": self.torsion, "torsion_std": self.torsion_std}
        return columns


class ResultantReader(Framewise):
    """Finds resultants in frames of readings; prepared once, then called on a frame or on many.

    Parameters
    ----------
    finger : Finger
        The skin, and the sensors in it, each with its noise.

    Raises
    ------
    InvalidValueError
        A finger that goes by a response measured in place; a sensor without noise.
    NotLinearError
        A transducer without a linear part.

    Examples
    --------
    >>> import subskin as ss
    >>> array = ss.SensorArray.grid(shape=(4, 4), pitch=4e-3, depth=2.5e-3, noise=2e-4)
    >>> reader = ResultantReader(ss.Finger(ss.HalfSpace(ss.Material(young=0.4e6)), array))
    >>> ss.Status(reader([0.0] * 16).status).name
    'NO_CONTACT'
    """

    _extent = False
    """Whether second moments of the normal force are asked for, on an area."""

    def __init__(self, finger: Finger) -> None:
        finger_needed(finger)
        if finger.measured is not None:
            seen, rule = "a finger with a response measured in place", "a resultant goes by the skin's field"
            raise InvalidValueError(seen, rule, "dataclasses.replace(finger, measured=None), if that field will do")
        self.layout = AREA if finger.array.on_area else LINE
        d = self.layout.dim
        self.unknowns, self._finger = 2 * d + 1, finger
        q = self.unknowns + (d > 1) + 3 * self._extent
        super().__init__(
            finger.array, needed=self.unknowns, columns=self.layout.columns + q * (q + 1), status=self.layout.status,
            layout=self.layout,
        )  # fmt: skip
        self._square = self.layout.columns + q
        self._box = np.ascontiguousarray(search_of(finger.array, None)[0][:d])
        self.allow_for(finger, 1.0)

    def __call__(self, readings: npt.ArrayLike) -> Resultant:
        """The resultant in each frame.

        Parameters
        ----------
        readings : array_like, shape (..., n)
            Raw readings, as in `Locator`.

        Returns
        -------
        Resultant
            Fields of shape (...).

        Raises
        ------
        GeometryError
            A last axis that is not the number of sensors.
        """
        table, used = self._frames(readings)
        return Resultant(table, used, np.inf, self.unknowns, self.layout, self.relative)

    def _kernel(self) -> Any:
        from .kernel import resultant_frames

        return resultant_frames

    def _prepare(self, pattern: npt.NDArray[np.bool_]) -> tuple[Any, ...]:
        from scipy.special import chdtri

        array, told = self.array.select(pattern), self._finger.tolerances
        if told is not None:
            drift = told.of("offset", pattern.size)[pattern]
            array = replace(array, noise=np.hypot(told.noise * np.asarray(array.noise), drift))
        most = float(chdtri(int(pattern.sum()), _FALSE_ALARM))
        return (
            sensor_rows(array),
            *bank_of(self._finger, pattern, np.asarray(array.noise), self._extent),
            most,
            self._box,
        )

    def _fill(self, frames: FloatArray, arrays: tuple[Any, ...], out: FloatArray) -> None:
        columns = self.layout.columns
        self._compiled(frames, *arrays, out[:, :columns], out[:, columns:])

    def _allow(
        self, out: FloatArray, spread: Spread | None, friction: float, trusted: bool, doubted: FloatArray | float
    ) -> None:
        super()._allow(out, spread, friction, trusted, doubted)
        if spread is not None:
            out[:, self._square :] *= spread.at(out[:, :1], friction) ** 2


def resultant(finger: Finger, readings: npt.ArrayLike) -> Resultant:
    """Force, drag, centre and moments of whatever presses, without its shape; as `finger.resultant(readings)` too.

    A pressure of any outline, even or not, in one piece or in some, explains the readings; the answer is the mean over
    all that may, and its covariance says by how much they differ (docs/resultant.md). On an area it is there where no
    family of `fit` explains a frame. Along a row loads are taken to be long.

    Parameters
    ----------
    finger : Finger
        The forward model, with the sensors' noise.
    readings : array_like, shape (..., n)
        Raw readings, each in units of its gain; NaN marks a missing one.

    Returns
    -------
    Resultant
        An `Estimate` of shape (...): its position is the centre of pressure.

    Raises
    ------
    InvalidValueError, GeometryError
        As in `ResultantReader`; a last axis that is not the number of sensors.

    Examples
    --------
    >>> import numpy as np, subskin as ss
    >>> array = ss.SensorArray.grid(shape=(4, 4), pitch=4e-3, depth=2.5e-3, noise=2e-4)
    >>> finger = ss.Finger(ss.HalfSpace(ss.Material(young=0.4e6)), array)
    >>> pad = ss.Patch(force=4.0, angle=0.2, position=(1e-3, 0.5e-3), half_widths=(3e-3, 2e-3))
    >>> readings = finger.read(pad, np.random.default_rng(0))
    >>> ss.Status(finger.locate(readings).status).name
    'UNEXPLAINED'
    >>> found = ss.estimate.resultant(finger, readings)
    >>> ss.Status(found.status).name, bool(abs(found.force - 4.0) < 0.3)
    ('OK', True)
    """
    finger_needed(finger)
    return prepared(finger).get(("resultant",), lambda: ResultantReader(finger))(readings)
