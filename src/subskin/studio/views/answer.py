"""The touch found again, apart from the picture: a finger's first answer waits for its tables and compiled loops."""

from __future__ import annotations

from collections import OrderedDict
from typing import Any

import numpy as np

from ..._check import FloatArray
from ...io.finger_file import FingerFile
from .finger_state import FingerState
from .form import finger_of
from .found import fitted_family, told
from .touch import Touch, fitting

__all__ = ["FingerAnswers", "read"]

_KEPT = 64
"""Fingers of which it is known that they answer at once: as many as `finger_of` keeps."""
_LATER: dict[str, Any] = {
    "status": "",
    "words": "The touch is being looked for …",
    "rows": [],
    "ellipse": None,
    "rival": None,
    "fitted": None,
    "pending": True,
}


class FingerAnswers:
    """What the readings of a state say: at once where the finger has answered before.

    Parameters
    ----------
    own : FingerFile, optional
        The finger of the command: what lies beside its file belongs to it.
    """

    def __init__(self, own: FingerFile | None = None) -> None:
        self._own = own
        self._ready: OrderedDict[tuple[str, str, str], None] = OrderedDict()

    def file(self, text: str) -> FingerFile:
        """The finger of a text; that of the command where it is that text.

        Parameters
        ----------
        text : str
            A finger.toml.

        Raises
        ------
        FileError
            As `finger_of`.
        """
        return self._own if self._own is not None and self._own.text == text else finger_of(text)

    def at_once(self, state: FingerState, touch: Touch, readings: FloatArray) -> dict[str, Any]:
        """The answer where the finger has answered before; else that it is looked for: `find` then answers.

        Parameters
        ----------
        state : FingerState
            What a page shows.
        touch : Touch
            What presses, as it is shown.
        readings : ndarray, shape (n,)
            What the sensors read of it [reading].
        """
        known = _kind(state, touch) in self._ready
        return told(self.file(state.text), touch, readings, state.find) if known else _LATER

    def find(self, state: FingerState) -> dict[str, Any]:
        """The answer, however long it takes.

        Parameters
        ----------
        state : FingerState
            What a page shows.

        Raises
        ------
        SubskinError
            A finger or a touch that cannot be.
        """
        file = self.file(state.text)
        touch = fitting(state.touch, file.finger)
        found, kind = told(file, touch, read(state, file, touch), state.find), _kind(state, touch)
        self._ready[kind] = None
        self._ready.move_to_end(kind)
        if len(self._ready) > _KEPT:
            self._ready.popitem(last=False)
        return found


def read(state: FingerState, file: FingerFile, touch: Touch) -> FloatArray:
    """What the sensors read of a touch, with the noise that the state has, if any.

    Parameters
    ----------
    state : FingerState
        What a page shows.
    file : FingerFile
        Its finger.
    touch : Touch
        What presses.
    """
    noise = None if state.seed is None else np.random.default_rng(state.seed)
    return file.finger.read(touch.contact(), noise)


def _kind(state: FingerState, touch: Touch) -> tuple[str, str, str]:
    """The finger, and which of its estimators is asked."""
    return state.text, state.find, fitted_family(touch) if state.find == "fit" else ""
