"""What every transducer has to say: its unit, and what it makes of the state at its position; transducers by name."""

from __future__ import annotations

import difflib
from abc import ABC, abstractmethod
from dataclasses import dataclass, fields
from importlib import import_module
from inspect import isabstract
from operator import attrgetter
from typing import Any, ClassVar

from .. import _check
from .._check import FloatArray
from .._declared import Noun
from .._frozen import Named
from ..errors import InvalidValueError, NotLinearError
from ..tensor import State

__all__ = ["Quantity", "Transducer", "class_of", "kind_of", "kinds", "transducer_of"]


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


def kinds() -> dict[str, type[Transducer]]:
    """The transducers by the names that files use, one's own among them.

    Examples
    --------
    >>> kinds()["mean_pressure"].__name__
    'MeanPressure'
    """
    return dict(Transducer._by_name)


def kind_of(transducer: Transducer) -> str:
    """The name by which `transducer_of` finds the class of `transducer`: that of `kinds`, else "module:Class".

    Examples
    --------
    >>> from subskin.transducer import MeanPressure
    >>> kind_of(MeanPressure())
    'mean_pressure'
    """
    own = type(transducer)
    named = (name for name, kind in kinds().items() if kind is own)
    return next(named, f"{own.__module__}:{own.__qualname__}")


def class_of(kind: str) -> type[Transducer]:
    """The class of transducers of a name of `kinds`, or one's own by its dotted name.

    Parameters
    ----------
    kind : str
        As in `transducer_of`.

    Raises
    ------
    InvalidValueError
        An unknown name; a module that cannot be imported; something that is no Transducer.

    Examples
    --------
    >>> class_of("mean_pressure").__name__
    'MeanPressure'
    """
    if not isinstance(kind, str):
        _check.noun("kind", kind, str, 'kind="mean_pressure"')
    known, seen = kinds(), f'kind = "{kind}"'
    if kind in known:
        return known[kind]
    module, _, name = kind.partition(":") if ":" in kind else kind.rpartition(".")
    if not (module and name):
        close = difflib.get_close_matches(kind, list(known), n=1)
        fix = f'did you mean "{close[0]}"' if close else f"known: {', '.join(known)}, or mypackage.mymodule:MyGauge"
        holding = [name for name in known if kind and kind in name.split("_")]
        if len(holding) > 1:  # "strain": along the depth, along the surface, or of shear
            about = {name: str(known[name].__doc__).split(" [")[0] for name in holding}
            fix = f"one of {', '.join(f'{name} ({what[0].lower()}{what[1:]})' for name, what in about.items())}"
        raise InvalidValueError(seen, "no such kind of sensor is known", fix)
    try:
        home = import_module(module)
    except Exception as error:  # what a module of one's own does when it is imported is not ours to foresee
        fix = "install it, or put its folder on PYTHONPATH"
        raise InvalidValueError(seen, f"{module} cannot be imported ({error})", fix) from error
    try:
        found = attrgetter(name)(home)
    except AttributeError:
        raise InvalidValueError(seen, f"{module} has no {name}", "mypackage.mymodule:MyGauge") from None
    if not (isinstance(found, type) and issubclass(found, Transducer)):
        raise InvalidValueError(seen, "it is no Transducer", f"class {name}(subskin.Transducer)")
    if isabstract(found):
        raise InvalidValueError(seen, f"it lacks {', '.join(sorted(found.__abstractmethods__))}", "define them")
    return found


def transducer_of(kind: str, **arguments: Any) -> Transducer:
    """The transducer of a name of `kinds`, or of a class of one's own by its dotted name.

    Parameters
    ----------
    kind : str
        "mean_pressure", or "mypackage.mymodule:MyGauge" or "mypackage.mymodule.MyGauge", whose module is imported.
    **arguments
        What the class takes, in SI units: the axis of a displacement, the direction of a gauge.

    Raises
    ------
    InvalidValueError
        As `class_of`; an argument that is missing, is not known, or is out of range.

    Examples
    --------
    >>> transducer_of("mean_pressure"), transducer_of("displacement", axis="z")
    (MeanPressure(), Displacement(axis='z'))
    """
    found = class_of(kind)
    try:
        return found(**arguments)
    except TypeError as error:
        names = [f.name for f in fields(found)]
        rule = f"it needs {'other ' if arguments else ''}arguments ({error})"
        fix = (
            f'kind = {{name = "{kind}", {", ".join(f"{n} = ..." for n in names)}}}'
            if names
            else "a subclass or defaults"
        )
        raise InvalidValueError(f'kind = "{kind}"', rule, fix) from None
