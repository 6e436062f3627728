"""Transducers by name: those that files and commands know, and one's own."""

from __future__ import annotations

import difflib
from dataclasses import fields
from importlib import import_module
from inspect import isabstract
from operator import attrgetter
from typing import Any

from .. import _check
from ..errors import InvalidValueError
from .base import Transducer

__all__ = ["class_of", "kind_of", "kinds", "transducer_of"]


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
