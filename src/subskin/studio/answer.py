"""The touch found again from what the sensors read: in numbers, in words, and with the rival.

A finger's first answer waits for its tables and compiled loops, so it comes apart from the picture.
"""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Mapping
from typing import Any

import numpy as np

from .._check import FloatArray
from .._shown import with_error
from ..contact import Contact, LocalContact
from ..errors import SubskinError
from ..estimate import Either, Status
from ..io.finger_file import FingerFile
from ..loads import force_unit
from .form import finger_of
from .state import FingerState, Touch, fitting, pressing
from .view import StudioView, asked

__all__ = ["STATUS", "FingerAnswers", "fitted_family", "read", "rows_of", "searched"]

STATUS = {
    Status.OK: "One touch explains the readings.",
    Status.AMBIGUOUS: "Two touches explain the readings nearly as well.",
    Status.NO_CONTACT: "Nothing touches: the readings are no more than noise.",
    Status.UNEXPLAINED: "No such touch explains the readings.",
    Status.INCOMPLETE: "Too few sensors can be used.",
}
"""What each status says to a person."""
_MM, _DEGREES, _FORCE = (1e3, "mm"), (180 / np.pi, "°"), (1.0, "")
_ROWS = {
    "position": ("position", *_MM),
    "position_y": ("position y", *_MM),
    "position_z": ("position z", *_MM),
    "force": ("force", *_FORCE),
    "angle": ("angle", *_DEGREES),
    "azimuth": ("azimuth", *_DEGREES),
    "half_width": ("half width", *_MM),
    "beside": ("beside", *_MM),
}
"""What is told of an estimate: its label, scale and unit; forces have the unit of the estimate."""
_NONE: dict[str, Any] = {"status": "", "rows": [], "ellipse": None, "rival": None, "fitted": None}
_LATER = _NONE | {"words": "The touch is being looked for …", "pending": True}
_LEFT_OPEN = "Several touches explain the readings, or none explains them well."
"""What AMBIGUOUS says of a line or a point."""
_KEPT = 64
"""Fingers of which it is known that they answer at once: as many as `finger_of` keeps."""


class FingerAnswers(StudioView):
    """What the readings of a state say: at once where the finger has answered before.

    Parameters
    ----------
    own : FingerFile, optional
        The finger of the command: what lies beside its file belongs to it.
    """

    def __init__(self, own: FingerFile | None = None) -> None:
        super().__init__()
        self.own = own
        self._ready: OrderedDict[tuple[str, str, str], None] = OrderedDict()

    def file(self, text: str | None) -> FingerFile:
        """The finger of a text; that of the command where it is that text, or there is none.

        Parameters
        ----------
        text : str or None
            A finger.toml.

        Raises
        ------
        FileError
            As `finger_of`.
        """
        if self.own is not None and text in (None, self.own.text):
            return self.own
        return finger_of(text or "")

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
        return _told(self.file(state.text), touch, readings, state.find) if known else _LATER

    @asked
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
        found, kind = _told(file, touch, read(state, file, touch.contact), state.find), _kind(state, touch)
        self._ready[kind] = None
        self._ready.move_to_end(kind)
        if len(self._ready) > _KEPT:
            self._ready.popitem(last=False)
        return {"found": found}


def read(state: FingerState, file: FingerFile, contact: Contact | LocalContact) -> FloatArray:
    """What the sensors read of a touch, with the noise that the state has, if any.

    Parameters
    ----------
    state : FingerState
        What a page shows.
    file : FingerFile
        Its finger.
    contact : Contact or LocalContact
        What presses.
    """
    noise = None if state.seed is None else np.random.default_rng(state.seed)
    return file.finger.read(contact, noise)


def searched(file: FingerFile, touch: Touch, readings: FloatArray, find: str) -> Any:
    """What is found of a frame.

    Parameters
    ----------
    file : FingerFile
        The finger, and how to search with it.
    touch : Touch
        What was pressed.
    readings : ndarray, shape (n,)
        The frame [reading].
    find : {"locate", "fit"}
        Whether the half width is found too, of the touch's family.

    Raises
    ------
    SubskinError
        A finger that cannot answer.
    """
    return file.fit(readings, fitted_family(touch)) if find == "fit" else file.locate(readings)


def _kind(state: FingerState, touch: Touch) -> tuple[str, str, str]:
    """The finger, and which of its estimators is asked."""
    return state.text, state.find, fitted_family(touch) if state.find == "fit" else ""


def _told(file: FingerFile, touch: Touch, readings: FloatArray, find: str) -> dict[str, Any]:
    """What the readings of a single frame say, the touch beside it as the truth."""
    try:
        found = searched(file, touch, readings, find)
    except SubskinError as error:
        return _NONE | {"words": str(error)}
    status, values = Status(int(found.status)), found.to_dict()
    return {
        "status": status.name,
        "words": _LEFT_OPEN if isinstance(found, Either) and status == Status.AMBIGUOUS else STATUS[status],
        "rows": rows_of(values, touch.local, _true(touch)),
        "fit": _quality(values),
        **_drawing(file, touch, found, fitted_family(touch) if find == "fit" else None),
    }


def fitted_family(touch: Touch) -> str:
    """The family whose half width `fit` finds: that of the touch, or what a ball or a roller makes.

    Parameters
    ----------
    touch : Touch
        What presses.
    """
    return touch.family if touch.wide else "round_hertz" if touch.local else "hertz"


def rows_of(values: dict[str, Any], area: bool, truth: Mapping[str, float] | None = None) -> list[dict[str, Any]]:
    """A row for each quantity: found, its standard deviation, the truth where it is known.

    Parameters
    ----------
    values : dict
        A single frame, as `Estimate.to_dict` gives it.
    area : bool
        Whether forces are in N.
    truth : mapping, optional
        True values [SI], by the same names.
    """
    true_of, out = truth or {}, []
    for name, (label, scale, unit) in _ROWS.items():
        if name not in values:
            continue
        own = unit or values.get("force_unit", force_unit(area))
        value, std = scale * values[name], scale * values.get(f"{name}_std", np.nan)
        text = with_error(value, std, own).replace("+-", "±").replace(" °", "°").replace("-", "−")
        said = {"name": name, "label": label, "unit": own, "value": value, "std": std, "text": text}
        out.append({**said, "truth": scale * true_of.get(name, np.nan)})
    return out


def _true(touch: Touch) -> dict[str, float]:
    """The touch by the names of an estimate."""
    truth = {
        "position": touch.position[0],
        "position_y": touch.position[0],
        "position_z": touch.position[-1],
        "force": touch.force,
        "angle": touch.angle,
        "half_width": touch.half_width if touch.wide else 0.0,
    }
    if touch.local:
        truth |= {"angle": abs(touch.angle), "azimuth": _turn(touch.azimuth + (np.pi if touch.angle < 0 else 0.0))}
    return truth


def _quality(values: dict[str, Any]) -> str:
    if not np.isfinite(values.get("residual", np.nan)):
        return ""
    return f"χ² {_whole(values['residual'])} with {int(values['spare'])} readings to spare"


def _drawing(file: FingerFile, touch: Touch, found: Any, family: str | None) -> dict[str, Any]:
    """Position, components, the ellipse of its errors, the rival, and what the sensors would read of it."""
    none = {"load": None, "ellipse": None, "rival": None, "fitted": None}
    found = getattr(found, "best", found)
    load = getattr(found, "load", None)
    if load is None or found.layout.aside or not np.isfinite(load.components).all():
        return none
    parts, where = load.components, np.atleast_1d(load.position)
    square = found.covariance
    local = load.dim == 2
    labels = [("y", 1e3, "mm"), ("z", 1e3, "mm") if local else ("force", 1.0, "N/m")]
    second = found.second
    rival: dict[str, Any] | None = None
    if np.isfinite(second.chi2):
        at, pushed = np.atleast_1d(second.position), np.asarray(second.components)
        worse = float(second.chi2)
        there = ", ".join(f"{'yz'[i]} = {1e3 * v:.2f} mm" for i, v in enumerate(at.tolist()))
        rival = {
            "position": at,
            "components": pushed,
            "worse": worse,
            "words": f"Next best: {there.replace('-', '−')}; its χ² is {_whole(worse)} larger.",
        }
    centre = where if local else np.array([where[0], float(load.force)])
    truth = touch.position if local else [touch.position[0], touch.force]
    other = None
    if rival is not None:
        other = rival["position"] if local else [rival["position"][0], float(np.hypot(*rival["components"]))]
    axes = [{"label": label, "scale": scale, "unit": unit} for label, scale, unit in labels]
    ellipse = {"centre": centre, "covariance": square[:2, :2], "truth": truth, "rival": other, "axes": axes}
    width = getattr(found, "half_width", None) if family else None
    if width is not None and (local or float(width) > 0):
        again = pressing(str(family), parts, where, max(float(width), 1e-9))
    else:
        again = pressing("point" if local else "line", parts, where, None)
    return {
        "load": {"position": where, "components": parts, "std": found.std},
        "ellipse": ellipse if np.isfinite(square[:2, :2]).all() else None,
        "rival": rival,
        "fitted": file.finger.read(again),
    }


def _whole(value: float) -> str:
    """Three digits, and no power of ten."""
    return f"{value:.3g}" if value < 100 else f"{float(f'{value:.3g}'):,.0f}".replace(",", " ")


def _turn(angle: float) -> float:
    """The same direction between -pi and pi."""
    return float(np.arctan2(np.sin(angle), np.cos(angle)))
