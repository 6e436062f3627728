"""What a page shows of a finger, to keep: a figure as of `subskin.plot`, and a Python program that does the same."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from ...contact import Contact, LocalContact
from ...errors import SubskinError
from ...finger import Finger
from .answer import fitted_family, read, searched
from .form import finger_of
from .state import FingerState, Touch, fitting
from .window import inside, quantity_of, window_of

__all__ = ["FingerShown", "picture_of", "script_of", "shown_of"]

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
    from ...plot import finger_figure
    from ...plot.style import encoded

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
