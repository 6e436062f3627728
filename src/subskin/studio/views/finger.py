"""The view of a finger: what presses, the field that it makes, what the sensors read, and the touch found again."""

from __future__ import annotations

import warnings
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from ..._check import FloatArray
from ...contact import Contact, LocalContact, families, local_families
from ...errors import SubskinError
from ...finger import Finger
from ...io.finger_file import FingerFile
from ..view import Answer, View, asked, drawn
from .answer import FingerAnswers, fitted_family, read, searched
from .fields import QUANTITIES, RANGE, FieldGrid, FieldKind, Picture, UnitFields, nice, offered, quantised
from .form import edited, finger_of, form_of
from .state import FingerState, Look, Touch, Window, first_touch, fitting

__all__ = ["EXAMPLE", "FingerShown", "FingerView", "shown_of", "window_of"]

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
_ALONG, _DOWN = 200, 80
"""Points of a field that are seen along the skin, and downwards."""
_MARGIN = 2.2
"""What is seen on both sides of the sensors, in depths."""
_BOTTOM, _TALL, _NEAR_BASE = 2.0, 0.26, 1.6
"""How deep is seen: in depths of the sensors, in widths of what is seen, and up to a base which is not much deeper."""
_MISFIT = "This finger was accepted although its model is not that of its touches: no answer of it is OK."
_NEAR = 0.3
"""The bar's end is the largest value deeper than this share of the shallowest sensor's depth."""
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
    touch = _inside(fitting(state.touch, file.finger), window_of(file.finger))
    try:
        found = searched(file, touch, read(state, file, touch), state.find)
    except SubskinError:
        found = None
    shown = _quantity(state.show, file.finger, touch).name
    return FingerShown(file.finger, touch, touch.contact, found, shown, fitted_family(touch))


class FingerView(View):
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
        from .kept import script_of

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
            window = scene.window if how.window is None else _held(how.window, finger)
            touch = _inside(fitting(state.touch, finger), window)
            shown = _quantity(state.show, finger, touch)
            readings = read(state, file, touch)
            metas, fields, coarse = self._drawn(finger, touch, shown, window, how)
            said = {
                **scene.said,
                "state": {**state.model_dump(), "touch": touch.model_dump(), "show": shown.name},
                "wide": touch.wide,
                "window": window._asdict(),
                "pressure": _pressure(touch),
                "readings": readings,
                "clean": finger.read(touch.contact),
                "found": self._answers.at_once(state, touch, readings),
                "fields": metas,
                "coarse": coarse,
            }
        notes = list(dict.fromkeys(str(one.message) for one in caught)) + ([] if finger.trusted else [_MISFIT])
        return {**said, "notes": notes}, fields

    def _drawn(
        self, finger: Finger, touch: Touch, shown: FieldKind, window: Window, how: Look
    ) -> tuple[list[dict[str, Any]], list[npt.NDArray[np.uint8]], bool]:
        """The fields of the section and, on an area, from above; whether they are still coarse."""
        metas, fields, coarse = [], [], False
        for name, grid in _grids(finger, window).items():
            ridged = finger.skin.ridges is not None  # not the same at every position
            picture = Picture(finger.skin, touch, shown, grid)
            missing = 0 if ridged else len(self._fields.missing(picture))
            if missing and how.refine and not coarse:
                self._fields.prepare(picture)
                missing -= 1
            if missing and not (how.moving or how.refine) and not touch.local and finger.skin.endless:
                missing = 0  # a whole field is a matter of milliseconds
            if ridged or missing:
                # the map from above changes with the depth of the sensors
                every = 3 if missing and how.moving and grid.depth is not None else 2
                coarse, grid = coarse or not ridged, _coarse(grid, touch, window, every)
                values = picture._replace(grid=grid).values(touch.components, there=ridged)
            else:
                values = self._fields.field(picture)
            most = nice(float(np.abs(_deep(values, grid, finger)).max()))
            values, grid = _seen(values, grid, touch, window)
            along, down = grid.along, grid.down
            across = 0.0 if grid.depth is None else touch.position[1]
            metas.append(
                {
                    "name": name,
                    "shape": [down[2], along[2]],
                    "most": most,
                    "range": RANGE,
                    "unit": shown.unit,
                    "label": shown.label,
                    "x": [touch.position[0] + along[0] - 0.5 * along[1], along[1] * along[2]],
                    "y": [across + down[0] - 0.5 * down[1], down[1] * down[2]],
                }
            )
            fields.append(quantised(values, most))
        return metas, fields, coarse


class Scene(NamedTuple):
    """What a finger itself gives to each of its pictures."""

    window: Window
    said: dict[str, Any]


@lru_cache(maxsize=64)
def _scene(file: FingerFile) -> Scene:
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
    return Scene(window_of(finger), said)


def window_of(finger: Finger) -> Window:
    """What is seen of a finger: its sensors and what is around them.

    Parameters
    ----------
    finger : Finger
        Which one.
    """
    points, depth = finger.array.points, float(np.asarray(finger.array.depth).max())
    margin = _MARGIN * depth
    low, high = points.min(axis=0) - margin, points.max(axis=0) + margin
    bottom, base = max(_BOTTOM * depth, _TALL * float(high[0] - low[0])), float(finger.skin.thickness)
    bottom = base if base < _NEAR_BASE * bottom else bottom
    if finger.skin.curvature:
        middle, half = 0.5 * (low[0] + high[0]), 0.45 * finger.skin.period
        low[0], high[0] = max(low[0], middle - half), min(high[0], middle + half)
    return Window(float(low[0]), float(high[0]), float(low[1]), float(high[1]), bottom, depth)


def _held(window: Window, finger: Finger) -> Window:
    """A window that a page holds, as far as the skin reaches."""
    usual = window_of(finger)
    sane = window.left < window.right and window.front < window.back and 0 < window.bottom < 1e3 * usual.bottom
    return (
        window._replace(bottom=min(window.bottom, float(finger.skin.thickness)), level=usual.level) if sane else usual
    )


def _grids(finger: Finger, window: Window) -> dict[str, FieldGrid]:
    """Points fixed to the contact which cover what is seen, wherever it lies."""
    step = (window.right - window.left) / _ALONG
    half = _ALONG if not finger.skin.curvature else int(min(_ALONG, 0.49 * finger.skin.period / step))
    along = (-half * step, step, 2 * half + 1)
    deep = window.bottom / _DOWN
    out = {"section": FieldGrid(along, (0.5 * deep, deep, _DOWN))}
    if finger.array.on_area:
        down = (window.back - window.front) / _DOWN
        out["above"] = FieldGrid(along, (-_DOWN * down, down, 2 * _DOWN + 1), window.level)
    return out


def _coarse(grid: FieldGrid, touch: Touch, window: Window, every: int = 2) -> FieldGrid:
    """Every second or third point, of what is seen alone."""
    step, down, rows = every * grid.along[1], every * grid.down[1], round(_DOWN / every)
    first = window.left - touch.position[0]
    along = (first + 0.5 * step, step, round((window.right - window.left) / step))
    if grid.depth is None:
        return FieldGrid(along, (0.5 * down, down, rows))
    return FieldGrid(along, (window.front - touch.position[1] + 0.5 * down, down, rows), grid.depth)


def _seen(values: FloatArray, grid: FieldGrid, touch: Touch, window: Window) -> tuple[FloatArray, FieldGrid]:
    """The part of a field that is seen."""

    def part(axis: tuple[float, float, int], low: float, high: float) -> tuple[slice, tuple[float, float, int]]:
        first, step, count = axis
        begin = int(np.clip(np.floor((low - first) / step), 0, count - 1))
        end = int(np.clip(np.ceil((high - first) / step) + 1, begin + 1, count))
        return slice(begin, end), (first + begin * step, step, end - begin)

    columns, along = part(grid.along, window.left - touch.position[0], window.right - touch.position[0])
    rows, down = slice(None), grid.down
    if grid.depth is not None:
        rows, down = part(grid.down, window.front - touch.position[1], window.back - touch.position[1])
    return values[rows, columns], FieldGrid(along, down, grid.depth)


def _deep(values: FloatArray, grid: FieldGrid, finger: Finger) -> FloatArray:
    """The values by which the colour bar is chosen."""
    if grid.depth is not None:
        return values
    first, step, count = grid.down
    deep = first + step * np.arange(count) >= _NEAR * float(np.asarray(finger.array.depth).min())
    return values[deep] if deep.any() else values  # a window that is held while sensors go deeper than it shows


def _inside(touch: Touch, window: Window) -> Touch:
    """The touch where it can be seen, and no wider than what is seen."""
    ends = ((window.left, window.right), (window.front, window.back))
    where = [float(np.clip(at, *end)) for at, end in zip(touch.position, ends)]
    width = min(touch.half_width, 0.25 * (window.right - window.left))
    return touch.model_copy(update={"position": where, "half_width": width})


def _quantity(name: str | None, finger: Finger, touch: Touch) -> FieldKind:
    """What is shown: what was chosen, or what the first sensor feels."""
    known = offered(local=touch.local)
    felt = finger.array.transducers[0].component
    return known.get(name or "", known.get(felt or "", QUANTITIES["strain.xx"]))


def _pressure(touch: Touch) -> dict[str, Any] | None:
    """The pressure along the surface, in shares of its largest finite value."""
    if not touch.wide:
        return None
    contact = touch.contact
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
