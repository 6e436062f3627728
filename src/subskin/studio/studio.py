"""The views, and what is asked of each: the one thing that all pages share."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any, Protocol

from ..errors import InvalidValueError
from ..io.finger_file import load, parse_finger
from .answer import FingerAnswers
from .calibrate import CalibrateView
from .design import DesignView
from .finger import EXAMPLE, FingerView
from .live import LiveView
from .state import FingerState
from .view import Answer, StudioView

__all__ = ["Studio"]

_DEVICE = ("live", "calibrate")
"""Views of which one alone has the device."""


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

    def __init__(self, file: str | Path | None = None, device: str | None = None) -> None:
        self._hands: dict[str, ThreadPoolExecutor] = {}
        self.clients: set[Woken] = set()
        own = parse_finger(EXAMPLE, "the example") if file is None else load(file)
        answers = FingerAnswers(own)
        self._views: dict[str, StudioView] = {
            "finger": FingerView(answers, "finger.toml" if file is None else Path(file).name),
            "answer": answers,
            "live": LiveView(self.wake, answers.file, device),
            "design": DesignView(self.wake),
            "calibrate": CalibrateView(self.wake, answers.file, device),
        }
        # loops are compiled while the browser opens
        self.hand("answer").submit(answers.find, FingerState(text=own.text))

    def view(self, name: str) -> StudioView:
        """The view of a name.

        Parameters
        ----------
        name : str
            Such as "finger".

        Raises
        ------
        InvalidValueError
            There is none.
        """
        if name == "memo" and name not in self._views:
            from .memo_view import MemoView  # what it draws takes a while to import

            self._views[name] = MemoView()
        if name not in self._views:
            raise InvalidValueError(name, "the studio has no such view", "load the page again")
        return self._views[name]

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
        SubskinError
            Something that cannot be.
        """
        asked = self.view(view)
        if do == "start" and view in _DEVICE:
            for other in _DEVICE:
                if other != view:
                    self._views[other].close()
        said = asked.answer(do, given)
        return said if isinstance(said, tuple) else (said, [])

    def does(self, view: str, do: str) -> bool:
        """Whether what is asked changes something, and is therefore done each time.

        Parameters
        ----------
        view, do : str
            What is asked of which view.
        """
        return view in self._views and self._views[view].does(do)

    def wake(self) -> None:
        """Something is new: called from any thread."""
        for client in list(self.clients):
            client.wake()

    def hand(self, view: str) -> ThreadPoolExecutor:
        """The one thread in which a view's answers are worked out."""
        return self._hands.setdefault(view, ThreadPoolExecutor(1, f"subskin studio {view}"))

    def close(self) -> None:
        """Stop what runs."""
        for view in self._views.values():
            view.close()
        for hand in self._hands.values():
            hand.shutdown(wait=False, cancel_futures=True)

    def number_of(self, view: str) -> int:
        """How often what `view` tells of itself has changed; -1 of a view that tells nothing."""
        return self._views[view].number if view in self._views else -1

    def news(self, view: str) -> Answer:
        """What `view` tells of itself now."""
        return self.view(view).told(), []
