"""The touch found again from what the sensors read: in numbers, in words, and with the rival."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from ..._check import FloatArray
from ..._shown import with_error
from ...contact import family_of, local_family_of
from ...errors import SubskinError
from ...estimate import Status
from ...io.finger_file import FingerFile
from ...loads import force_unit
from .touch import Touch

__all__ = ["STATUS", "fitted_family", "rows_of", "told"]

STATUS = {
    Status.OK: "One touch explains the readings.",
    Status.AMBIGUOUS: "Two touches explain the readings nearly as well.",
    Status.NO_CONTACT: "Nothing touches: the readings are no more than noise.",
    Status.UNEXPLAINED: "No such touch explains the readings.",
    Status.INCOMPLETE: "Too few sensors can be used.",
}
"""What each status says to a person."""
_UNITS = {
    "position": (1e3, "mm"),
    "position_y": (1e3, "mm"),
    "position_z": (1e3, "mm"),
    "half_width": (1e3, "mm"),
    "beside": (1e3, "mm"),
    "angle": (180 / np.pi, "°"),
    "azimuth": (180 / np.pi, "°"),
}
_LETTERS = {"position_y": "position y", "position_z": "position z"}


def told(file: FingerFile, touch: Touch, readings: FloatArray, find: str) -> dict[str, Any]:
    """What the readings of a single frame say.

    Parameters
    ----------
    file : FingerFile
        The finger, and how to search with it.
    touch : Touch
        What was pressed: the truth beside which the answer stands.
    readings : ndarray, shape (n,)
        The frame [reading].
    find : {"locate", "fit"}
        Whether the half width is found too, of the touch's family.
    """
    family = fitted_family(touch)
    try:
        found = file.fit(readings, family) if find == "fit" else file.locate(readings)
    except SubskinError as error:
        return {"status": "", "words": str(error), "rows": [], "ellipse": None, "rival": None, "fitted": None}
    status = Status(int(found.status))
    values = found.to_dict()
    return {
        "status": status.name,
        "words": STATUS[status],
        "rows": rows_of(values, touch.local, _true(touch)),
        "fit": _quality(values),
        **_drawing(file, touch, found, family if find == "fit" else None),
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
    unit, true_of = values.get("force_unit", force_unit(area)), truth or {}
    out = []
    for name in (
        "position",
        "position_y",
        "position_z",
        "force",
        "line_force",
        "point_force",
        "angle",
        "azimuth",
        "half_width",
        "beside",
    ):
        if name not in values:
            continue
        scale, own = _UNITS.get(name, (1.0, values.get("force_unit", "N") if name == "point_force" else unit))
        value, std = scale * values[name], scale * values.get(f"{name}_std", np.nan)
        text = with_error(value, std, own).replace("+-", "±").replace(" °", "°").replace("-", "−")
        out.append(
            {
                "name": name,
                "label": _LETTERS.get(name, name.replace("_", " ")),
                "unit": own,
                "value": value,
                "std": std,
                "truth": scale * true_of.get(name, np.nan),
                "text": text,
            }
        )
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
    width = getattr(found, "half_width", None)
    if local:
        kind: Any = local_family_of(family or "point")
        more = {"half_width": max(float(width), 1e-9)} if family and width is not None else {}
        again = kind(components=parts, position=where, **more)
    elif family and width is not None and float(width) > 0:
        again = family_of(family).of_components(parts, where[0], half_width=float(width))
    else:
        again = family_of("line").of_components(parts, where[0])
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
