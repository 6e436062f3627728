"""How far a calibrated finger's positions are really off, over what independent noise would make of them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, ClassVar

import numpy as np
import numpy.typing as npt

from . import _check
from ._check import FloatArray
from ._declared import Noun, Real, Ruled
from .errors import InvalidValueError

__all__ = ["Spread"]

_RATIO = Ruled(lambda name, value: _check.real(f"spread.{name}", value, above=0.0))


@dataclass(frozen=True, eq=False)
class Spread(Noun):
    """Standard errors of positions over those of independent noise, along the row; between nodes they go straight.

    Parameters
    ----------
    y : array_like, shape (k,)
        Nodes along the row [m], rising.
    straight, leaning : array_like, shape (k,)
        The ratio there [-]: of loads that press straight down (friction 0), and of loads that may lean.

    Raises
    ------
    InvalidValueError
        Nodes that do not rise, ratios that are not above 0, or not one of each for each node.

    Examples
    --------
    >>> spread = Spread([-9e-3, 0.0, 9e-3], straight=[3.0, 1.0, 3.0], leaning=[4.0, 1.0, 4.0])
    >>> spread.at([-4.5e-3, 0.0, 20e-3], friction=0).tolist()
    [2.0, 1.0, 3.0]
    """

    y: Annotated[FloatArray, Real("m")]
    straight: Annotated[FloatArray, _RATIO]
    leaning: Annotated[FloatArray, _RATIO]

    EXAMPLE: ClassVar = "Spread([0.0], straight=[1.0], leaning=[1.0])"

    def __post_init__(self) -> None:
        super().__post_init__()
        for name, values in self.__dict__.items():
            if values.ndim != 1 or not values.size or values.shape != self.y.shape:
                rule = "y, straight and leaning are lists of numbers, one for each node"
                raise InvalidValueError(f"spread.{name} of shape {values.shape}", rule)
        if (np.diff(self.y) <= 0).any():
            raise InvalidValueError("spread.y that does not rise", "nodes go along the row", "sort them")

    def at(self, position: npt.ArrayLike, friction: float = 1.0) -> FloatArray:
        """The ratio at positions (...) [m] for loads within a cone of `friction`; beyond the nodes that of the last.

        Parameters
        ----------
        position : array_like, shape (...)
            Along the row [m].
        friction : float, optional
            As in `Finger.locate` [-]: 0 for loads that press straight down.

        Returns
        -------
        ndarray, shape (...)
            The ratio [-].

        Examples
        --------
        >>> Spread([0.0, 1e-3], straight=[1.0, 2.0], leaning=[1.0, 4.0]).at(0.5e-3).tolist()
        2.5
        """
        ratio = self.leaning if _check.friction(friction) > 0 else self.straight
        return np.asarray(np.interp(_check.real("position", position, unit="m", finite=False), self.y, ratio))
