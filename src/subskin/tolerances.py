"""How far a finger may be from its drawing: standard deviations of what nobody measured."""

from __future__ import annotations

from dataclasses import dataclass, fields, replace
from typing import Annotated, ClassVar

import numpy as np
import numpy.typing as npt

from . import _check
from ._check import FloatArray
from ._declared import Noun, Real
from ._shown import span
from .array import SensorArray
from .errors import InvalidValueError
from .skin.base import Skin

__all__ = ["Tolerances"]

_LARGEST = 0.3
"""Beyond this an error is no small change of the readings."""


@dataclass(frozen=True, repr=False)
class Tolerances(Noun):
    """Standard deviations of what is not known of a finger; estimators count them with the noise.

    The errors of the readings that follow grow with the load, and the estimators weigh them frame by frame
    (docs/real_fingers.md). Each tolerance is one number for all sensors, or one for each; Poisson's ratio has one.

    Parameters
    ----------
    gain : array_like, optional
        Of a sensor's gain, as a share of it [-].
    depth : array_like, optional
        Of a sensor's depth [depths].
    position : array_like, optional
        Of a sensor's position along y, and along z on an area [depths].
    poisson : float, optional
        Of Poisson's ratio of the skin [-].
    offset : array_like, optional
        Of a sensor's offset, drifted since the tare [reading].
    noise : float, optional
        The factor by which the noise may be larger than it is said to be [-], >= 1.
    common : float, optional
        The share of the variances of gain and depth that all sensors have in common [-], 0 to 1: a batch of sensors, a
        mould that was filled too high. Errors of position and of offset are each sensor's own.

    Raises
    ------
    InvalidValueError
        A tolerance below 0, or one above 0.3; a factor of noise below 1; a share beyond 0 to 1.

    Examples
    --------
    >>> import numpy as np, subskin as ss
    >>> array = ss.SensorArray.grid(shape=(4, 4), pitch=3e-3, depth=3e-3, noise=4e-5)
    >>> drawn = ss.Finger(ss.HalfSpace(ss.Material(young=0.4e6)), array)
    >>> told = ss.Tolerances(gain=0.02, depth=0.05, position=0.05)
    >>> told
    Tolerances(gain=0.02, depth=0.05, position=0.05)
    >>> made = ss.Finger(*told.draw(drawn.skin, array, np.random.default_rng(0)))
    >>> readings = made.read(ss.PointLoad(force=1.0, position=(1e-3, 0.0)))
    >>> ss.Status(drawn.locate(readings).status).name  # to the noise, no load explains them
    'UNEXPLAINED'
    >>> found = ss.Finger(drawn.skin, array, tolerances=told).locate(readings)
    >>> ss.Status(found.status).name, bool(np.abs(found.position - [1e-3, 0.0]).max() < 0.3e-3)
    ('OK', True)
    """

    gain: Annotated[npt.ArrayLike, Real(at_least=0.0, at_most=_LARGEST)] = 0.0
    depth: Annotated[npt.ArrayLike, Real(at_least=0.0, at_most=_LARGEST)] = 0.0
    position: Annotated[npt.ArrayLike, Real(at_least=0.0, at_most=_LARGEST)] = 0.0
    poisson: Annotated[float, Real(at_least=0.0, at_most=_LARGEST)] = 0.0
    offset: Annotated[npt.ArrayLike, Real(at_least=0.0)] = 0.0
    noise: Annotated[float, Real(at_least=1.0)] = 1.0
    common: Annotated[float, Real(at_least=0.0, at_most=1.0)] = 0.25

    EXAMPLE: ClassVar = "Tolerances(gain=0.02, depth=0.05, position=0.05, poisson=0.05)"

    def __repr__(self) -> str:
        told = {field.name: np.asarray(getattr(self, field.name)).tolist() for field in fields(self)}
        usual = {field.name: field.default for field in fields(self)}
        return f"Tolerances({', '.join(f'{name}={v}' for name, v in told.items() if v != usual[name])})"

    def __str__(self) -> str:
        """Those that are not zero, as a person reads them."""
        told = {name: np.asarray(getattr(self, name)) for name in ("gain", "depth", "position", "poisson", "offset")}
        found = [f"{name} {span(values)}" for name, values in told.items() if values.any()]
        found += [f"noise times {self.noise:g}"] if self.noise > 1 else []
        return ", ".join(found) or "none, a touch may have a size"

    def of(self, name: str, sensors: int) -> FloatArray:
        """A tolerance as one number for each sensor.

        Parameters
        ----------
        name : str
            E.g. "gain".
        sensors : int
            How many there are.

        Raises
        ------
        InvalidValueError
            A tolerance of another number of sensors.

        Examples
        --------
        >>> Tolerances(gain=0.02).of("gain", 2).tolist()
        [0.02, 0.02]
        """
        values = np.asarray(getattr(self, name), dtype=np.float64)
        if values.shape not in ((), (1,), (sensors,)):
            rule = f"one value, or one for each of the {sensors} sensors, is needed"
            raise InvalidValueError(f"{name} of shape {values.shape}", rule, f"{name}=0.05")
        return np.asarray(np.broadcast_to(values, sensors))

    def draw(self, skin: Skin, array: SensorArray, rng: np.random.Generator) -> tuple[Skin, SensorArray]:
        """A skin and its sensors as they may have been made: gains, depths, positions, ratio, offsets and noise.

        Parameters
        ----------
        skin, array : Skin, SensorArray
            As they are drawn.
        rng : numpy.random.Generator
            Draws the errors, which are normal. Depths stay in the skin, and Poisson's ratio below 1/2.

        Raises
        ------
        InvalidValueError
            A tolerance of another number of sensors.

        Examples
        --------
        >>> import numpy as np, subskin as ss
        >>> row = ss.SensorArray.line(count=4, pitch=2e-3, depth=2e-3, noise=1e-4)
        >>> drawn = ss.HalfPlane(ss.Material(young=0.4e6)), row
        >>> made = ss.Finger(*ss.Tolerances(depth=0.05).draw(*drawn, np.random.default_rng(0)))
        >>> bool(np.ptp(made.array.depth) > 0)
        True
        """
        _check.generator(rng)
        count, depth = len(array), np.asarray(array.depth)

        def errors(name: str) -> FloatArray:
            together = rng.standard_normal() * np.sqrt(self.common)
            own = rng.standard_normal(count) * np.sqrt(1 - self.common)
            return np.asarray(self.of(name, count) * (together + own))

        deeper = np.minimum(depth * np.exp(errors("depth")), skin.thickness)
        moved = (self.of("position", count) * depth)[:, None] * rng.standard_normal((count, 2))
        made = replace(
            array, gain=np.asarray(array.gain) * (1 + errors("gain")), depth=deeper,
            y=np.asarray(array.y) + moved[:, 0],
            z=np.asarray(array.z) + (moved[:, 1] if array.on_area else 0.0),
            offset=np.asarray(array.offset) + self.of("offset", count) * rng.standard_normal(count),
            noise=np.asarray(array.noise) * self.noise,
        )  # fmt: skip
        if self.poisson:
            shift = self.poisson * float(rng.standard_normal())
            skin = skin.with_(
                materials=[replace(m, poisson=min(max(m.poisson + shift, 0.0), 0.5)) for m in skin.materials]
            )
        return skin, made
