"""The views, and what is asked of each: the one thing that all pages share."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any, ClassVar, Protocol

import numpy as np
import numpy.typing as npt

from ..io.finger_file import FingerFile, load, parse_finger
from .views.answer import FingerAnswers
from .views.calibrate import CalibrateView
from .views.design import DesignView
from .views.finger import EXAMPLE, FingerView, Look, Window
from .views.finger_state import FingerState
from .views.form import finger_of
from .views.live.view import LiveView
from .views.script import script_of

__all__ = ["Studio"]

Answer = tuple[dict[str, Any], list[npt.NDArray[np.uint8]]]


class Woken(Protocol):
    """A page, as the studio knows it."""

    def wake(self) -> None:
        """There may be something to tell; called from any thread."""


class Studio:
    """What is asked of the views, whichever page asks.

    Parameters
    ----------
    file : path-like, optional
        The finger.toml that is shown at the beginning; an example if left out.
    device : str, optional
        A device or a recording that the live view begins with; a device is calibrated too.

    Raises
    ------
    FileError
        The file cannot be read, or holds something wrong.
    """

    DOES: ClassVar[frozenset[str]] = LiveView.DOES | DesignView.DOES | CalibrateView.DOES
    """What changes something, and is therefore done each time that it is asked."""

    def __init__(self, file: str | Path | None = None, device: str | None = None) -> None:
        self._hands: dict[str, ThreadPoolExecutor] = {}
        self.clients: set[Woken] = set()
        self.file = parse_finger(EXAMPLE, "the example") if file is None else load(file)
        self.text = self.file.text
        self.name = "finger.toml" if file is None else Path(file).name
        self._answers = FingerAnswers(self.file)
        self._finger = FingerView(self._answers)
        self._live = LiveView(self.wake, device)
        self._design = DesignView(self.wake)
        self._calibrate = CalibrateView(self.wake, device)
        self._told: dict[str, LiveView | DesignView | CalibrateView] = {
            "live": self._live,
            "design": self._design,
            "calibrate": self._calibrate,
        }
        # loops are compiled while the browser opens
        self.hand("answer").submit(self._answers.find, FingerState(text=self.text))

    def answer(self, view: str, do: str, given: dict[str, Any]) -> Answer:
        """What a page is answered.

        Parameters
        ----------
        view, do : str
            What is asked of which view.
        given : dict
            With what.

        Raises
        ------
        SubskinError, ValidationError
            Something that cannot be.
        """
        if view == "finger":
            return self._of_finger(do, given)
        if (view, do) == ("answer", "find"):
            return {"found": self._answers.find(FingerState.model_validate(given.get("state")))}, []
        if (view, do) == ("memo", "look"):
            from .views.memo.view import MemoState, look

            return look(MemoState.model_validate(given.get("state", {}))), []
        if view == "live":
            if do == "start":
                self._calibrate.close()  # one of the two has the device
            return self._live.answer(do, given, self._file(given.get("finger"))), []
        if view == "design":
            return self._design.answer(do, given), []
        if view == "calibrate":
            if do == "start":
                self._live.close()
            return self._calibrate.answer(do, given, self._file(given.get("finger"))), []
        raise _unknown(view, do)

    def _file(self, text: object) -> FingerFile:
        """The finger of a text; the one of the command where it is that, with what lies beside its file."""
        return self.file if not isinstance(text, str) or text == self.text else finger_of(text)

    def wake(self) -> None:
        """Something is new: called from any thread."""
        for client in list(self.clients):
            client.wake()

    def _of_finger(self, do: str, given: dict[str, Any]) -> Answer:
        if do == "begin":
            return {"begin": {"text": self.text}, "name": self.name}, []
        state = FingerState.model_validate(given.get("state"))
        if do == "look":
            how = Look.model_validate(given.get("how", {}))
            window = None if how.window is None else Window(*how.window)
            return self._finger.look(state, edits=how.edits, window=window, moving=how.moving, refine=how.refine)
        if do == "script":
            return {"script": script_of(state)}, []
        raise _unknown("finger", do)

    def hand(self, view: str) -> ThreadPoolExecutor:
        """The one thread in which a view's answers are worked out."""
        return self._hands.setdefault(view, ThreadPoolExecutor(1, f"subskin studio {view}"))

    def close(self) -> None:
        """Stop what runs."""
        for view in self._told.values():
            view.close()
        for hand in self._hands.values():
            hand.shutdown(wait=False, cancel_futures=True)

    def number_of(self, view: str) -> int:
        """How often what `view` tells of itself has changed; -1 of a view that tells nothing."""
        return self._told[view].number if view in self._told else -1

    def news(self, view: str) -> Answer:
        """What `view` tells of itself now."""
        if view in self._told:
            return self._told[view].told(), []
        raise _unknown(view, "news")


def _unknown(view: str, do: str) -> Exception:
    from ..errors import InvalidValueError

    return InvalidValueError(f"{view}.{do}", "the studio knows no such thing", "load the page again")
