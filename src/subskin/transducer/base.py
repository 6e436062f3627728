"""What every transducer has to say: its unit, and what it makes of the state at its position."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass, fields
from operator import attrgetter
from typing import ClassVar

from .._check import FloatArray
from .._declared import Noun
from .._frozen import Named
from ..errors import NotLinearError
from ..tensor import State

__all__ = ["Quantity", "Transducer"]


@dataclass(frozen=True)
class Transducer(Named, Noun, ABC):
    """What is measured at a point of the skin.

    One of your own gives `unit` and `measure`; defined with a name, `class Tilt(Transducer, name="tilt")`, it is found
    by it in files. One that is not proportional to the load sets `linear = False`.

    Attributes
    ----------
    component : str
        The component of the field that a picture of the skin shows beside it, such as "strain.xx".

    Examples
    --------
    >>> import subskin as ss
    >>> class Stretch(ss.Transducer):
    ...     unit = ""
    ...     def measure(self, state):
    ...         return state.strain.yy
    >>> skin, load = ss.HalfPlane(ss.Material(young=0.4e6)), ss.LineLoad(force=40.0)
    >>> round(float(Stretch().measure(skin.state(load, x=2e-3, y=0.0))), 6)
    0.023873
    """

    component: ClassVar[str] = "strain.xx"

    def __repr__(self) -> str:
        """The class and what is not as usual."""
        own = ((f.name, getattr(self, f.name), f.default) for f in fields(self))
        return (
            f"{type(self).__name__}({', '.join(f'{name}={value!r}' for name, value, usual in own if value != usual)})"
        )

    @property
    @abstractmethod
    def unit(self) -> str:
        """Unit of the measured quantity; "" for a strain or a ratio."""

    @property
    def linear(self) -> bool:
        """Whether the measured quantity is proportional to the load."""
        return True

    @abstractmethod
    def measure(self, state: State) -> FloatArray:
        """The quantity, in `unit`, at each point of `state`.

        Parameters
        ----------
        state : State
            Stress [Pa] and strain [-] at points of shape (...).

        Returns
        -------
        ndarray, shape (...)
        """

    def linearise(self, measured: FloatArray) -> FloatArray:
        """A quantity proportional to the load, from a measured one.

        Parameters
        ----------
        measured : ndarray, shape (...)
            What `measure` returns [`unit`].

        Raises
        ------
        NotLinearError
            Where no such quantity follows from this transducer alone.
        """
        if self.linear:
            return measured
        raise NotLinearError(
            f"transducer {type(self).__name__}",
            "its reading is not proportional to the load and cannot be made so",
            "simulate with it, but locate with a linear one such as NormalStrain() or MeanPressure()",
        )

    @property
    def linear_part(self) -> Transducer:
        """The transducer that measures what `linearise` returns."""
        return self


class Quantity(Transducer):
    """A transducer that is one quantity of the state, of the name `_of`."""

    _of: ClassVar[str]

    def measure(self, state: State) -> FloatArray:  # noqa: D102
        quantity: FloatArray = attrgetter(self._of)(state)
        return quantity
