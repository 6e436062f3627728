"""What a view of the studio is: questions that a page may ask, by the names of methods, and what it tells of itself."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeVar

import numpy as np
import numpy.typing as npt
from pydantic import BaseModel, ConfigDict, ValidationError, validate_call

from ..errors import InvalidValueError
from ..estimate.on_row import usual
from ..io.finger_file import FingerFile
from ..loads import force_unit

__all__ = ["LARGEST", "Answer", "FromPage", "StudioView", "asked", "done", "drawn"]

Answer = tuple[dict[str, Any], list[npt.NDArray[np.uint8]]]
"""What goes as JSON, and fields that go as they are."""
LARGEST = 256 * 1024
"""Bytes of a message from the page; a larger one ends the connection."""
_Method = TypeVar("_Method", bound=Callable[..., Any])
_STRICT = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False)


class FromPage(BaseModel):
    """What a page sends: nothing that is not known here, and no number without end."""

    model_config = _STRICT


def asked(method: _Method) -> _Method:
    """A method that a page may ask for: what it gives is checked by the annotations. The latest question counts."""
    checked: Any = validate_call(config=ConfigDict(allow_inf_nan=False))(method)
    checked.changes = False  # by which it is known, too
    return checked  # type: ignore[no-any-return]


def done(method: _Method) -> _Method:
    """The same of what changes something: it is done each time that it is asked."""
    checked: Any = asked(method)
    checked.changes = True
    return checked  # type: ignore[no-any-return]


class StudioView:
    """One view, the same for all pages.

    Parameters
    ----------
    wake : callable, optional
        Called, from any thread, when there is something new to tell.

    Examples
    --------
    >>> class Lamp(StudioView):
    ...     on = False
    ...     @done
    ...     def switch(self, on: bool) -> None:
    ...         self.on = on
    ...     @asked
    ...     def see(self) -> dict[str, bool]:
    ...         return {"light": self.on}
    >>> lamp = Lamp()
    >>> lamp.answer("switch", {"on": True}), lamp.answer("see", {})
    ({'done': True}, {'light': True})
    >>> lamp.answer("switch", {"on": "blue"})
    Traceback (most recent call last):
    subskin.errors.InvalidValueError: switch: on: Input should be a valid boolean, unable to interpret input.
    """

    number = -1
    """How often what is told has changed; -1 of a view that tells nothing."""

    def __init__(self, wake: Callable[[], object] = lambda: None) -> None:
        self._wake = wake

    def does(self, do: str) -> bool:
        """Whether what is asked by this name is `done` each time.

        Parameters
        ----------
        do : str
            The name.
        """
        return bool(getattr(getattr(type(self), do, None), "changes", False))

    def answer(self, do: str, given: dict[str, Any]) -> Any:
        """What a page is answered.

        Parameters
        ----------
        do : str
            What it asks.
        given : dict
            With what.

        Raises
        ------
        SubskinError
            Something that cannot be, or that is not known.
        """
        method: Any = getattr(type(self), do, None)
        if not hasattr(method, "changes"):
            raise InvalidValueError(do, "the studio knows no such thing", "load the page again")
        try:
            said = method(self, **given)
        except ValidationError as error:
            first = error.errors(include_url=False, include_input=False)[0]
            where = ".".join(map(str, first["loc"]))
            raise InvalidValueError(f"{do}: {where}", first["msg"]) from None
        return {"done": True} if said is None else said

    def told(self) -> dict[str, Any]:
        """What a page that watches is told."""
        return {}

    def close(self) -> None:
        """Stop what runs."""

    def _tell(self) -> None:
        self.number += 1
        self._wake()


def drawn(file: FingerFile, relative: bool = False) -> dict[str, Any]:
    """What the drawing of a finger needs: where its sensors are, and the units.

    Parameters
    ----------
    file : FingerFile
        The finger.
    relative : bool, optional
        Of forces that were found by a finger which knows none in N.
    """
    array, units = file.finger.array, {kind.unit for kind in file.finger.array.transducers}
    found = force = force_unit(array.on_area, relative)
    if not (array.on_area or relative) and (file.load or usual(file.finger)) == "either":
        found = f"{force}, of a point {force_unit(True)}"
    return {
        "area": array.on_area,
        "sensors": {
            "y": array.points[:, 0],
            "z": array.points[:, 1],
            "depth": np.broadcast_to(np.asarray(array.depth), (len(array),)),
            "live": np.asarray(array.live),
            "names": list(file.names),
        },
        "units": {"force": force, "found": found, "reading": units.pop() if len(units) == 1 else ""},
    }
