"""The view of a finger: what presses, its field, what the sensors read, the touch found again; and what is kept."""

from __future__ import annotations

import warnings
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np

from ..contact import Contact, LocalContact, families, local_families
from ..errors import SubskinError
from ..finger import Finger
from ..io.finger_file import FingerFile
from .answer import FingerAnswers, fitted_family, read, searched
from .fields import UnitFields, held, inside, offered, quantity_of, window_of
from .form import edited, finger_of, form_of
from .state import FingerState, Look, Touch, Window, first_touch, fitting
from .view import Answer, StudioView, asked, drawn

__all__ = ["EXAMPLE", "FingerShown", "FingerView", "picture_of", "script_of", "shown_of"]

_TOP = {"LineLoad", "Hertz", "FlatPunch", "Strip", "Wedge", "PointLoad", "RoundHertz", "Patch"}


class FingerShown(NamedTuple):
    """What a state shows, as the library has it."""

    finger: Finger
    touch: Touch
    contact: Contact | LocalContact
    estimate: Any
    component: str
    family: str


def shown_of(state: FingerState) -> FingerShown:
    """What a state shows, as the library has it.

    Parameters
    ----------
    state : FingerState
        What a page shows.

    Raises
    ------
    SubskinError
        A finger or a touch that cannot be.
    """
    file = finger_of(state.text)
    touch = inside(fitting(state.touch, file.finger), window_of(file.finger))
    try:
        found = searched(file, touch, read(state, file, touch.contact), state.find)
    except SubskinError:
        found = None
    shown = quantity_of(state.show, file.finger, touch).name
    return FingerShown(file.finger, touch, touch.contact, found, shown, fitted_family(touch))


def picture_of(state: FingerState, kind: str) -> bytes:
    """The file of the figure.

    Parameters
    ----------
    state : FingerState
        What the page shows.
    kind : {"svg", "png"}
        Of which kind.

    Raises
    ------
    SubskinError
        A finger or a touch that cannot be.
    """
    from ..plot import finger_figure
    from ..plot.style import encoded

    shown = shown_of(state)
    figure = finger_figure(shown.finger, shown.contact, shown.estimate, component=shown.component)
    return encoded(figure, kind)


def script_of(state: FingerState) -> str:
    """A program that reads the same finger, makes the same touch, and finds it again.

    Parameters
    ----------
    state : FingerState
        What the page shows.

    Raises
    ------
    SubskinError
        A finger or a touch that cannot be.
    """
    shown = shown_of(state)
    touch = shown.touch
    name = type(shown.contact).__name__
    local = touch.local
    where = f"({touch.position[0]:.6g}, {touch.position[1]:.6g})" if local else f"{touch.position[0]:.6g}"
    lean = f"angle={touch.angle:.6g}"
    if isinstance(shown.contact, LocalContact):
        lean = f"angle={abs(touch.angle):.6g}, azimuth={np.arctan2(*shown.contact.components[:0:-1]):.6g}"
    width = f", half_width={touch.half_width:.6g}" if touch.wide else ""
    units = "N, rad, m" if local else "N/m, rad, m"
    noise = "" if state.seed is None else f", np.random.default_rng({state.seed})"
    text = state.text.replace("\\", "\\\\").replace('"""', '\\"""')
    find = f'file.fit(readings, "{shown.family}")' if state.find == "fit" else "file.locate(readings)"
    numpy = "" if state.seed is None else "import numpy as np\n\n"
    room = "" if name in _TOP else "contact."
    return f'''{numpy}import subskin as ss

file = ss.io.parse_finger("""\\
{text.rstrip()}
""")
touch = ss.{room}{name}(force={touch.force:.6g}, {lean}, position={where}{width})  # {units}
readings = file.finger.read(touch{noise})
found = {find}

print(found)
ss.plot.save(file.finger.plot(touch, found, component="{shown.component}"), "finger.svg")
'''


EXAMPLE = """\
# A finger of silicone rubber: eight strain gauges in a row.
[skin]
young = "0.4 MPa"
poisson = 0.5

[sensors]
count = 8
pitch = "1.5 mm"
depth = "2 mm"
kind = "normal_strain"
noise = 5e-4
"""
"""The finger that is shown where no file is named."""
_MISFIT = "This finger was accepted although its model is not that of its touches: no answer of it is OK."
_NAMES = {
    "line": "a line",
    "hertz": "a roller (Hertz)",
    "punch": "a flat punch",
    "strip": "an even strip",
    "wedge": "a blunt wedge",
    "point": "a point",
    "round_hertz": "a ball (Hertz)",
    "round_punch": "a flat disc",
    "cone": "a blunt cone",
}
_AS_IT_IS = Look()


class FingerView(StudioView):
    """Draws what is asked of a finger; what it keeps makes pictures quicker, and changes none.

    Parameters
    ----------
    answers : FingerAnswers
        What the readings say.
    name : str, optional
        What the file of the command is called.
    """

    def __init__(self, answers: FingerAnswers, name: str = "finger.toml") -> None:
        super().__init__()
        self._fields, self._answers, self._name = UnitFields(), answers, name

    @asked
    def begin(self) -> dict[str, Any]:
        """The file that is shown at the beginning."""
        return {"begin": {"text": self._answers.file(None).text}, "name": self._name}

    @asked
    def script(self, state: FingerState) -> dict[str, Any]:
        """A program that does what the page shows.

        Parameters
        ----------
        state : FingerState
            What is shown.
        """
        return {"script": script_of(state)}

    @asked
    def look(self, state: FingerState, how: Look = _AS_IT_IS) -> Answer:
        """What a page draws, and its fields.

        Parameters
        ----------
        state : FingerState
            What is shown.
        how : Look, optional
            How it is looked at.

        Raises
        ------
        SubskinError
            A finger, a touch or a change that cannot be.
        """
        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always")
            text = state.text
            for key, value in how.edits:
                text = edited(text, key, value)
            state = state.model_copy(update={"text": text})
            file = self._answers.file(text)
            scene, finger = _scene(file), file.finger
            window = scene.window if how.window is None else held(how.window, finger)
            touch = inside(fitting(state.touch, finger), window)
            shown = quantity_of(state.show, finger, touch)
            contact = touch.contact
            readings = read(state, file, contact)
            metas, fields, coarse = self._fields.drawn(finger, touch, shown, window, how)
            said = {
                **scene.said,
                "state": {**state.model_dump(), "touch": touch.model_dump(), "show": shown.name},
                "wide": touch.wide,
                "window": window._asdict(),
                "pressure": _pressure(touch, contact),
                "readings": readings,
                "clean": finger.read(contact),
                "found": self._answers.at_once(state, touch, readings),
                "fields": metas,
                "coarse": coarse,
            }
        notes = list(dict.fromkeys(str(one.message) for one in caught)) + ([] if finger.trusted else [_MISFIT])
        return {**said, "notes": notes}, fields


class FingerScene(NamedTuple):
    """What a finger itself gives to each of its pictures."""

    window: Window
    said: dict[str, Any]


@lru_cache(maxsize=64)
def _scene(file: FingerFile) -> FingerScene:
    finger, about = file.finger, drawn(file)
    local, skin = about["area"], finger.skin
    base = float(skin.thickness)
    said = {
        **about,
        "form": form_of(file),
        "families": {
            name: _NAMES.get(name, name.replace("_", " ")) for name in (local_families if local else families)()
        },
        "quantities": {q.name: f"{q.label} [{q.unit}]" for q in offered(local=local).values()},
        "usual": first_touch(finger).force,
        "skin": {
            "says": str(skin),
            "interfaces": [float(depth) for depth in skin.interfaces],
            "base": base if np.isfinite(base) else None,
            "curved": bool(skin.curvature),
        },
        "noise": np.asarray(finger.array.noise),
    }
    return FingerScene(window_of(finger), said)


def _pressure(touch: Touch, contact: Contact | LocalContact) -> dict[str, Any] | None:
    """The pressure along the surface, in shares of its largest finite value."""
    if not touch.wide:
        return None
    reach = 1.02 * touch.half_width
    y = touch.position[0] + reach * np.sin(0.5 * np.pi * np.linspace(-1.0, 1.0, 81))
    pressed = contact.pressure(y, touch.position[1]) if touch.local else contact.pressure(y)  # type: ignore[call-arg]
    finite = pressed[np.isfinite(pressed)]
    peak = float(np.quantile(finite[finite > 0], 0.9)) if (finite > 0).any() else 1.0
    return {"y": y, "share": np.clip(np.nan_to_num(pressed / peak, posinf=2.0), 0.0, 2.0), "mean": _mean(touch)}


def _mean(touch: Touch) -> float:
    """Mean pressure [Pa]."""
    normal = touch.force * float(np.cos(touch.angle))
    return normal / (np.pi * touch.half_width**2 if touch.local else 2 * touch.half_width)
