"""Figures: the memo's redrawn, truth against estimate, a finger cut open, and what a design comes to.

The only part of `subskin` that imports matplotlib. The user's own settings of it are left as they are:
figures are made without pyplot, in a style of their own. Each function returns a `matplotlib.figure.Figure`;
`save` writes it.
"""

from __future__ import annotations

from collections.abc import Iterable
from os import PathLike
from pathlib import Path

from matplotlib.figure import Figure

from ..errors import InvalidValueError
from ..io.files import path_of
from .above import finger_above
from .afferents import afferent_figure
from .compliance import compliance_figure, figure_17
from .grasp import felt_figure, lift_figure, lift_movie
from .half_plane import half_plane_map_figure, tip_map_figure
from .memo_filter import figure_14, figure_15
from .memo_lines import figure_2, figure_3, figure_6, figure_9, figure_11, figure_12, figure_13
from .pieces import COMPONENTS
from .placement import design_map_figure, placement_figure, placement_study_figure
from .pressure import pressure_figure, pressure_image_figure, pressure_movie
from .response import aliasing_figure, density_figure, response_figure
from .ridges import figure_16, pressed_ridges_figure, ridge_figure
from .section import finger_section
from .shown import estimate_figure, field_map, finger_figure
from .slip import side_angle_figure, slip_figure
from .strips import contact_strip, drift_figure, probability_strip
from .style import finished, save
from .tolerance import blind_figure, tolerance_figure
from .truth import truth_above, truth_against_estimate
from .two_point import figure_18, figure_19, two_point_figure, two_point_study_figure

__all__ = [
    "COMPONENTS",
    "MEMO_FIGURES",
    "afferent_figure",
    "aliasing_figure",
    "blind_figure",
    "compliance_figure",
    "contact_strip",
    "density_figure",
    "design_map_figure",
    "drift_figure",
    "estimate_figure",
    "felt_figure",
    "field_map",
    "finger_above",
    "finger_figure",
    "finger_section",
    "half_plane_map_figure",
    "lift_figure",
    "lift_movie",
    "memo_figure",
    "placement_figure",
    "placement_study_figure",
    "pressed_ridges_figure",
    "pressure_figure",
    "pressure_image_figure",
    "pressure_movie",
    "probability_strip",
    "response_figure",
    "ridge_figure",
    "save",
    "save_memo_figures",
    "side_angle_figure",
    "slip_figure",
    "tip_map_figure",
    "tolerance_figure",
    "truth_above",
    "truth_against_estimate",
    "two_point_figure",
    "two_point_study_figure",
]

_MEMO = {2: figure_2, 3: figure_3, 6: figure_6, 9: figure_9, 11: figure_11, 12: figure_12, 13: figure_13}
_MEMO |= {14: figure_14, 15: figure_15, 16: figure_16, 17: figure_17, 18: figure_18, 19: figure_19}

MEMO_FIGURES = tuple(_MEMO)
"""Numbers of the memo's figures that can be redrawn."""


@finished
def memo_figure(number: int) -> Figure:
    """One of the memo's figures, drawn anew from the physics of this package.

    Angles follow this package: positive drags the skin towards +y. What the memo prints wrongly is drawn
    right, with the printed form dashed beside it where that matters (Figs. 11 and 13).

    Parameters
    ----------
    number : int
        Its number in the memo, one of `MEMO_FIGURES`: 2 and 3 (strain beneath a line load), 6 (three sensors, four
        roots), 9 (vertices), 11 (cylinder), 12 (drag in proportion to pressure), 13 (dragged cylinder), 14 (strain
        measured at discrete positions), 15 (response of the skin to waves), 16 (ridges), 17 (a particle read through
        three skins), 18 (what two sensors confuse), 19 (what a third sensor adds).

    Raises
    ------
    InvalidValueError
        A number that is not among them.

    Examples
    --------
    >>> figure = memo_figure(2)
    >>> figure.axes[1].get_title(loc="left"), figure.axes[1].get_xlabel()
    ('', 'position of the sensor, from the load, $y/d$')
    """
    _known(number)
    return _MEMO[number]()


def save_memo_figures(
    numbers: Iterable[int] | None, folder: str | PathLike[str], formats: Iterable[str] = ("svg", "png")
) -> list[Path]:
    """Write figures of the memo into `folder`, which is made where it is missing.

    Parameters
    ----------
    numbers : iterable of int, or None
        Which, of `MEMO_FIGURES`; None for all.
    folder : path-like
        Where to. Fig. 2 becomes memo_figure_02.svg and memo_figure_02.png.
    formats : iterable of {"svg", "png", "pdf"}, optional
        What to write.

    Returns
    -------
    list of pathlib.Path
        The files written.

    Raises
    ------
    InvalidValueError
        An unknown number or format; nothing is written then.
    FileError
        A folder or file that cannot be written.

    Examples
    --------
    >>> [path.name for path in save_memo_figures([2], getfixture("tmp_path"), formats=["svg"])]
    ['memo_figure_02.svg']
    """
    wanted = MEMO_FIGURES if numbers is None else tuple(numbers)
    kinds = (formats,) if isinstance(formats, str) else tuple(formats)
    for number in wanted:
        _known(number)
    files = (save(memo_figure(number), path_of(folder) / f"memo_figure_{number:02d}", kinds) for number in wanted)
    return [path for written in files for path in written]


def _known(number: int) -> None:
    if isinstance(number, bool) or number not in _MEMO:
        available = ", ".join(map(str, MEMO_FIGURES))
        raise InvalidValueError(f"memo figure {number!r}", f"there are {available}", "memo_figure(2)")
