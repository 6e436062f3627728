"""The finger: a skin with sensors in it. The only forward model; all estimation and design rides on it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
import numpy.typing as npt

from . import _check
from ._check import FloatArray
from .array import SensorArray
from .contact.base import Contact
from .contact.line import LineLoad
from .errors import GeometryError, InvalidValueError
from .receptive_field import ReceptiveField
from .skin.base import Skin
from .transducer import Transducer

if TYPE_CHECKING:
    from .estimate.estimate import Estimate
    from .estimate.locate import Locator
    from .estimate.shape.shape import ShapeEstimate

__all__ = ["Finger"]


_FARTHEST = 100.0


class _Group(NamedTuple):
    """Sensors of one transducer and one number of averaging nodes, evaluated together."""

    transducer: Transducer
    sensors: npt.NDArray[np.intp]
    x: FloatArray  # (k, 1)
    y: FloatArray  # (k, nodes)
    weights: FloatArray  # (nodes,)


@dataclass(frozen=True, eq=False)
class Finger:
    """A skin and the sensors in it.

    Parameters
    ----------
    skin : Skin
        The medium, e.g. `HalfPlane`.
    array : SensorArray
        The sensors.

    Examples
    --------
    >>> import numpy as np, subskin as ss
    >>> skin = ss.HalfPlane(ss.Material(young=0.4e6))
    >>> finger = ss.Finger(skin, ss.SensorArray.line(count=4, pitch=2e-3, depth=2e-3, noise=1e-4))
    >>> finger.read(ss.LineLoad(force=40.0, position=0.5e-3)).round(4).tolist()
    [0.003, -0.0043, -0.0198, 0.002]
    """

    skin: Skin
    array: SensorArray

    def __post_init__(self) -> None:
        if not isinstance(self.skin, Skin):
            raise InvalidValueError(
                f"skin = {self.skin!r}", "a Skin is needed", "HalfPlane(Material(young=0.4e6))"
            )
        if not isinstance(self.array, SensorArray):
            raise InvalidValueError(f"array = {self.array!r}", "a SensorArray is needed")
        deepest = float(np.asarray(self.array.depth).max())
        if deepest > self.skin.thickness * (1 + 1e-12):
            raise GeometryError(
                f"depth = {deepest:.6g} m",
                f"the sensors have to lie in the skin, which is {self.skin.thickness:.6g} m thick",
                "a thicker skin or shallower sensors",
            )

    def _groups(self, linear: bool) -> list[_Group]:
        a = self.array
        ys, depths, widths = np.asarray(a.y), np.asarray(a.depth), np.asarray(a.width)
        # Gauss-Legendre over the width: the field is analytic within a depth of the sensor, so the error falls
        # geometrically with the number of nodes, at a rate set by width / depth.
        nodes = np.where(widths > 0, np.ceil(8 + 12 * widths / depths), 1).astype(int)
        kinds = [t.linear_part if linear else t for t in a.transducers]
        groups: list[_Group] = []
        for kind in dict.fromkeys(kinds):
            for count in np.unique(nodes):
                index = np.array(
                    [i for i, k in enumerate(kinds) if k == kind and nodes[i] == count], dtype=np.intp
                )
                if index.size:
                    t, w = np.polynomial.legendre.leggauss(int(count))
                    y = ys[index, None] + 0.5 * widths[index, None] * t
                    groups.append(_Group(kind, index, depths[index, None], y, 0.5 * w))
        return groups

    def measure(self, contact: Contact, *, linear: bool = False) -> FloatArray:
        """What the transducers measure under `contact`, before gain and offset, shape (..., n).

        With `linear`, each transducer's linear part (`Transducer.linear_part`).
        """
        out = np.empty((*contact.shape, len(self.array)))
        wide = contact.expand(2)
        for group in self._groups(linear):
            state = self.skin.state(wide, group.x, group.y)
            out[..., group.sensors] = group.transducer.measure(state) @ group.weights
        return out

    def read(self, contact: Contact, rng: np.random.Generator | None = None) -> FloatArray:
        """Readings of the sensors under `contact`.

        Parameters
        ----------
        contact : Contact
            What presses; a batch of shape (...) gives readings of shape (..., n).
        rng : numpy.random.Generator, optional
            Adds each sensor's noise; without it readings are free of noise.

        Returns
        -------
        ndarray, shape (..., n)
            Readings, in each sensor's unit times its gain.
        """
        return self.array.digitise(self.measure(contact), rng)

    def receptive_field(self, position: npt.ArrayLike) -> FloatArray:
        """Change of each reading per unit normal and per unit tangential line load at `position` [m].

        Gain included, offset not. This is all that estimators know of a finger.

        Parameters
        ----------
        position : array_like, shape (...)
            Places y of the load [m].

        Returns
        -------
        ndarray, shape (..., n, 2)
            Reading per N/m of normal ([..., 0]) and of tangential load ([..., 1]).

        Raises
        ------
        NotLinearError
            Where a transducer has no linear part.

        Examples
        --------
        >>> import subskin as ss
        >>> skin = ss.HalfPlane(ss.Material(young=0.4e6))
        >>> finger = ss.Finger(skin, ss.SensorArray(y=[0.0], depth=2e-3))
        >>> field = finger.receptive_field([0.0, 1e-3])
        >>> field.shape, round(float(field[0, 0, 0] * 40), 6)
        ((2, 1, 2), -0.023873)
        """
        for kind in self.array.transducers:
            kind.linearise(np.zeros(0))  # refuses what cannot be made linear
        y = _check.real("position", position, unit="m")
        fields = [self.measure(LineLoad(1.0, angle, y), linear=True) for angle in (0.0, np.pi / 2)]
        return np.asarray(self.array.gain)[:, None] * np.stack(fields, axis=-1)

    def tabulate(self, search: tuple[float, float] | None = None) -> ReceptiveField:
        """The receptive field as a table over the load positions `search` [m].

        The default reaches 1.5 depths beyond the outermost sensors. Tables are kept: the next call with the same
        `search` costs nothing.

        Raises
        ------
        InvalidValueError
            Where `search` is not two ascending places, or goes more than once round a finger.
        """
        tables: dict[tuple[float, ...] | None, ReceptiveField] = self.__dict__.setdefault("_tables", {})
        key = _check.ends("search", search, "search=(-5e-3, 5e-3)")
        if key not in tables:
            tables[key] = self._tabulate(search)
        return tables[key]

    def _tabulate(self, search: tuple[float, float] | None) -> ReceptiveField:
        y, depth = np.asarray(self.array.y), np.asarray(self.array.depth)
        reach = 1.5 * float(depth.max())
        whole = (y.min() - reach, y.max() + reach)
        middle = 0.5 * (whole[0] + whole[1])
        half = min(0.5 * (whole[1] - whole[0]), 0.5 * self.skin.period)
        ends = _check.real("search", (middle - half, middle + half) if search is None else search, unit="m")
        if ends.shape != (2,) or not ends[0] < ends[1]:
            raise InvalidValueError(
                f"search = {search!r}", "two ascending places are needed", "search=(-5e-3, 5e-3)"
            )
        if ends[1] - ends[0] > self.skin.period * (1 + 1e-12):
            raise InvalidValueError(
                f"search = {search!r}",
                f"the finger is {self.skin.period:.6g} m about, and places repeat after that",
                "a narrower search",
            )
        if ends[1] - ends[0] > np.ptp(y) + _FARTHEST * float(depth.max()):
            raise InvalidValueError(
                f"search = {search!r} m",
                f"it is wider than the row by more than {_FARTHEST:g} depths, beyond which nothing is felt",
                "search in metres, such as (-5e-3, 5e-3)",
            )
        return ReceptiveField.from_function(
            self.receptive_field, float(ends[0]), float(ends[1]), step=float(depth.min()) / 16
        )

    def locator(self, *, search: tuple[float, float] | None = None, **options: Any) -> Locator:
        """A `Locator` for this finger, prepared once for many calls.

        Parameters
        ----------
        search : (float, float), optional
            Where loads are looked for, y [m]; the default reaches 1.5 depths beyond the outermost sensors.
        **options
            Those of `Locator`: `friction`, `scan_step`, `false_alarm`, `ambiguity`, `outliers`.
        """
        from .estimate.locate import Locator

        return Locator(self.tabulate(search), self.array, **options)

    def locate(
        self, readings: npt.ArrayLike, *, search: tuple[float, float] | None = None, **options: Any
    ) -> Estimate:
        """Where, how hard and at what angle a line load presses, from readings of shape (..., n).

        The locator is prepared on the first call and kept, so later calls with the same options cost little more than
        the search. Options are those of `locator`.

        Returns
        -------
        Estimate
            Position, force, angle, covariance, rival, residual and status, each of shape (...).

        Examples
        --------
        >>> import numpy as np, subskin as ss
        >>> skin = ss.HalfPlane(ss.Material(young=0.4e6))
        >>> finger = ss.Finger(skin, ss.SensorArray.line(count=6, pitch=1.5e-3, depth=2e-3, noise=1e-5))
        >>> found = finger.locate(finger.read(ss.LineLoad(force=40.0, angle=0.3, position=0.8e-3)))
        >>> ss.Status(found.status).name, round(float(found.position) * 1e3, 4)
        ('OK', 0.8)
        """
        key = (_check.ends("search", search, "search=(-5e-3, 5e-3)"), *sorted(options.items()))
        locators = self.__dict__.setdefault("_locators", {})
        if key not in locators:
            locators[key] = self.locator(search=search, **options)
        found: Estimate = locators[key](readings)
        return found

    def fit(
        self,
        readings: npt.ArrayLike,
        family: str | type = "hertz",
        *,
        search: tuple[float, float] | None = None,
        width: tuple[float, float] | None = None,
        **options: Any,
    ) -> ShapeEstimate:
        """A contact of one family in readings of shape (..., n): where, how hard, at what angle, how wide.

        Global in place and width. Four unknowns: with four readings everything is explained, and only what more
        sensors say can speak against the family. The fitter is prepared on the first call and kept.

        Parameters
        ----------
        readings : array_like, shape (..., n)
            Raw readings; NaN marks a missing one.
        family : {"line", "wedge", "hertz", "strip", "punch"} or subclass of SpreadContact
            What presses, the drag being in proportion to the pressure.
        search : (float, float), optional
            Where contacts are looked for, y [m]; 1.5 depths beyond the outermost sensors if left out.
        width : (float, float), optional
            Least and largest half width [m]; 0 to 1.5 depths of the shallowest sensor if left out.
        **options
            Those of `Fitter`: `friction`, `false_alarm`, `ambiguity`, `outliers`.

        Returns
        -------
        ShapeEstimate
            Position, force, angle, half width, their covariance, an interval of the half width, rival, residual,
            status.

        Raises
        ------
        InvalidValueError
            An unknown family, widths out of order, sensors without noise.

        Examples
        --------
        >>> import numpy as np, subskin as ss
        >>> skin = ss.HalfPlane(ss.Material(young=0.4e6))
        >>> finger = ss.Finger(skin, ss.SensorArray.line(count=6, pitch=1e-3, depth=2e-3, noise=1e-5))
        >>> roller = ss.Hertz(force=40.0, angle=0.3, position=0.4e-3, half_width=1.2e-3)
        >>> found = finger.fit(finger.read(roller), "hertz")
        >>> ss.Status(found.status).name, round(float(found.half_width) * 1e3, 3)
        ('OK', 1.2)
        """
        from .estimate.shape.fit import Fitter, widths_of
        from .estimate.shape.shape_field import ShapeField, family_of

        ends = _check.ends("width", width, "width=(0.0, 3e-3)")
        key = (family, _check.ends("search", search, "search=(-5e-3, 5e-3)"), ends, *sorted(options.items()))
        fitters = self.__dict__.setdefault("_fitters", {})
        if key not in fitters:
            kind = family_of(family)
            table = self.tabulate(search)
            widths = widths_of(kind, ends, float(np.asarray(self.array.depth).min()))
            field = ShapeField.of(self, kind, (table.start, table.stop), max(widths[1], 1e-3 * table.step))
            fitters[key] = Fitter(field, self.array, width=widths, **options)
        found: ShapeEstimate = fitters[key](readings)
        return found
