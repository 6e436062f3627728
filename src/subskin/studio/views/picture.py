"""What a page shows of a finger as a figure to keep: that of `subskin.plot`."""

from __future__ import annotations

from .finger import shown_of
from .finger_state import FingerState

__all__ = ["picture_of"]


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
