"""The pressure found along the surface or on an area: its band, its drag, how finely it is resolved; and a movie."""

from __future__ import annotations

from os import PathLike
from typing import Any

import numpy as np
import numpy.typing as npt
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.collections import QuadMesh
from matplotlib.figure import Figure
from PIL import Image

from .._axes import on_touches, turned
from .._check import FloatArray
from ..contact import Contact, LocalContact
from ..errors import GeometryError, InvalidValueError
from ..estimate import PressureImage, PressureMap, Status
from ..io.files import replacing
from ..loads import force_unit
from .style import (
    DOUBLE,
    MM,
    NORMAL_95,
    SINGLE,
    Ink,
    finished,
    house_style,
    legend,
    new_figure,
    settled,
    single,
    zero_line,
)

__all__ = ["pressure_figure", "pressure_image_figure", "pressure_movie"]

_SCALES = ((1e6, "MPa"), (1e3, "kPa"), (1.0, "Pa"))


@finished
def pressure_figure(found: PressureMap, *, truth: Contact | None = None, origin: float = 0.0) -> Figure:
    """The pressure of one frame along the surface with its 95 % band, the shear, and the resolution below.

    Full marks on the lower edge are the sensors that were used, hollow ones those that were not. The bar is as long as
    a narrow pressure at the centre looks wide.

    Parameters
    ----------
    found : PressureMap, shape ()
        What `pressure_map` found in one frame.
    truth : Contact, optional
        What pressed, drawn dashed.
    origin : float, optional
        The finger's y = 0 on the axis of the figure [m].

    Raises
    ------
    GeometryError
        More than one frame, or contacts.
    InvalidValueError
        A frame in which no pressure was found.

    Examples
    --------
    >>> import subskin as ss
    >>> skin = ss.HalfPlane(ss.Material(young=0.4e6))
    >>> finger = ss.Finger(skin, ss.SensorArray.line(count=13, pitch=1e-3, depth=2e-3, noise=2e-5))
    >>> roller = ss.Hertz(force=40.0, half_width=2e-3)
    >>> figure = pressure_figure(ss.pressure_map(finger, finger.read(roller)), truth=roller)
    >>> [axes.get_ylabel() for axes in figure.axes]
    ['pressure and shear [kPa]', 'resolution [mm]']
    """
    _check_one("maps", found, truth)
    figure = new_figure(SINGLE, 88.0)
    upper, lower = figure.subplots(2, 1, sharex=True, height_ratios=(3, 1))
    _tractions(upper, found, truth, origin)
    _sensors(upper, found, origin)
    lower.plot(MM * (found.y + origin), MM * found.resolution, color=Ink.GREY)
    # where next to nothing is seen the width is any; what lies beyond four times the centre's is cut off
    there = float(np.interp(found.centre, found.y, found.resolution))
    lower.set_ylim(0, MM * min(1.1 * float(found.resolution.max()), 4 * there))
    lower.set(xlabel="position along the surface $y$ [mm]", ylabel="resolution [mm]")
    legend(figure, upper, loc="outside upper center", ncols=2)
    return figure


def _check_one(what: str, found: PressureMap | PressureImage, truth: Contact | LocalContact | None) -> None:
    """Refuses more than one frame or contact, and a frame without a pressure."""
    single(what, found.shape, "one frame is drawn", "pressure_map(finger, frames[0])")
    single("contacts", () if truth is None else truth.shape, "one is compared with one frame", "a single contact")
    if not np.isfinite(found.normal_force):
        seen = f"a frame of status {Status(int(found.status)).name}"
        raise InvalidValueError(seen, "there is no pressure in it to draw", "a frame with status OK")


def _tractions(axes: Axes, found: PressureMap, truth: Contact | None, origin: float) -> None:
    y, fine = found.y, np.linspace(found.y[0], found.y[-1], 1601)
    largest = float(found.pressure.max())
    scale, unit = scale_of(largest, found.mapper.relative)
    dragged = found.mapper.shear != "none"
    curves = [("pressure", found.pressure, found.pressure_interval, Ink.BLUE)]
    if dragged:
        half = NORMAL_95 * found.shear_std
        curves.append(("shear", found.shear, np.stack([found.shear - half, found.shear + half], -1), Ink.VERMILLION))
    for name, values, band, colour in curves:
        look: dict[str, Any] = {"alpha": 0.2, "linewidth": 0, "label": f"{name}, 95 %"}
        axes.fill_between(MM * (y + origin), *band.T / scale, color=colour, **look)
        axes.plot(MM * (y + origin), values / scale, color=colour, label=f"{name} found")
    highest = 1.15 * float(found.pressure_interval.max())
    lowest = 1.15 * min(float(np.min(curves[-1][2])), 0.0)
    if truth is not None:
        for k, name in enumerate(("pressure", "shear")[: 1 + dragged]):
            real: FloatArray = np.array(getattr(truth, name)(fine))
            real[~np.isfinite(real)] = np.nan
            label = "what pressed" if k == 0 else None
            axes.plot(MM * (fine + origin), real / scale, color=Ink.BLACK, linestyle="--", linewidth=0.9, label=label)
            highest = max(highest, min(1.05 * float(np.nanmax(real)), 2 * highest))
    zero_line(axes)
    axes.set_ylim(lowest / scale - 0.08 * (highest - lowest) / scale, highest / scale)
    apart = "\n" if found.mapper.relative else " "  # a long unit is on a line of its own
    axes.set_ylabel(f"{'pressure and shear' if dragged else 'pressure'}{apart}[{unit}]")
    width = float(np.interp(found.centre, y, found.resolution))
    ends, label = MM * (found.centre + origin + width * np.array([-0.5, 0.5])), f"resolution {MM * width:.2g} mm"
    axes.plot(ends, np.full(2, 0.94 * highest / scale), color=Ink.GREY, lw=2.5, solid_capstyle="butt", label=label)


def _sensors(axes: Axes, found: PressureMap, origin: float) -> None:
    position, used = MM * (np.asarray(found.mapper.array.y) + origin), np.asarray(found.used)
    edge: dict[str, Any] = {"color": Ink.GREEN, "ms": 3, "transform": axes.get_xaxis_transform()}
    for at, face, name in ((position[used], Ink.GREEN, "sensors"), (position[~used], "none", "not used")):
        if at.size:
            axes.plot(at, np.full(at.size, 0.03), "^", mfc=face, label=name, **edge)


def scale_of(largest: float, relative: bool, per: str = "m") -> tuple[float, str]:
    """What pressures up to the `largest` [Pa] are divided by, and their unit; `relative` ones are loads `per` area."""
    if relative:
        return 1.0, f"{force_unit(local=False, relative=True)} / {per}"
    return next((s, u) for s, u in _SCALES if largest >= s or s == 1.0)


_MOST = 500  # frames
_DPI = 100
_FINER = 4  # the truth is drawn, than the nodes
_FAINT = 0.1  # of the largest drag: shorter arrows are left out
_Floats = npt.NDArray[np.float64]


@finished
def pressure_image_figure(
    found: PressureImage, *, truth: LocalContact | None = None, origin: npt.ArrayLike = (0.0, 0.0), turn: float = 0.0
) -> Figure:
    """The image of one frame with its drag, and beside it the half of its 95 % band, or the truth.

    Arrows are the drag; where it is free, of the truth too. Dots are the sensors that were used, rings those that were
    not. The bar is as long as a narrow pressure at the centre looks wide.

    Parameters
    ----------
    found : PressureImage, shape ()
        What `pressure_map` found in one frame.
    truth : LocalContact, optional
        What pressed, drawn instead of the band.
    origin : (float, float), optional
        The finger's (0, 0) on the axes of the figure [m].
    turn : float, optional
        Angle from the axes of the figure to the finger's, from +y towards +z [rad].

    Raises
    ------
    GeometryError
        More than one frame, or contacts.
    InvalidValueError
        A frame in which no pressure was found.

    Examples
    --------
    >>> import subskin as ss
    >>> array = ss.SensorArray.grid(shape=(4, 4), pitch=2e-3, depth=2e-3, transducer=ss.MeanPressure(), noise=20.0)
    >>> pad = ss.Finger(ss.HalfSpace(ss.Material(young=0.4e6)), array)
    >>> tip = ss.RoundHertz(force=2.0, half_width=2e-3)
    >>> figure = pressure_image_figure(ss.pressure_map(pad, pad.read(tip), shear="none"), truth=tip)
    >>> [axes.get_title(loc="left") for axes in figure.axes[:2]]
    ['found', 'truth']
    """
    _check_one("images", found, truth)
    at = _Axes(origin, turn)
    y, z = np.meshgrid(found.y, found.z, indexing="ij")
    axes_beside: tuple[npt.NDArray[np.float64], ...] = found.y, found.z
    if truth is None:
        beside = NORMAL_95 * found.pressure_std
        largest = float(found.pressure.max())
    else:
        axes_beside = tuple(np.linspace(one[0], one[-1], _FINER * (one.size - 1) + 1) for one in axes_beside)
        beside = truth.pressure(*np.meshgrid(*axes_beside, indexing="ij"))
        largest = float(max(found.pressure.max(), np.where(np.isfinite(beside), beside, 0.0).max()))
    scale, unit = scale_of(largest, found.mapper.relative, "m²")
    wide, high = at.size(found)
    figure = new_figure(DOUBLE, min(22.0 + 66.0 * high / wide, 160.0))
    left, right = figure.subplots(1, 2, sharex=True, sharey=True)
    titles = "found", "half of the 95 % band" if truth is None else "truth"
    shown = (left, (found.y, found.z), found.pressure, titles[0]), (right, axes_beside, beside, titles[1])
    for axes, nodes, values, title in shown:
        picture = _image(axes, nodes, at, values / scale, largest / scale)
        axes.set_title(title)
        axes.set_xlabel("position $y$ [mm]")
    left.set_ylabel("position $z$ [mm]")
    _sensors_above(left, found, at)
    _drag(left, found, at, found.shear)
    if truth is not None and found.mapper.shear == "free":
        _drag(right, found, at, truth.shear(y, z))
    cell = np.unravel_index(
        np.hypot(y - found.centre[0], z - found.centre[1]).argmin(), y.shape
    )  # where the centre of pressure is
    seen = float(found.resolution[cell])
    low = found.y[0] + 0.05 * np.ptp(found.y), found.z[0] + 0.05 * np.ptp(found.z)
    bar = at.of(np.array([low[0], low[0] + seen]), np.full(2, low[1]))
    left.plot(*bar, color="white", linewidth=2.0)
    said, at_bar = f"resolution {MM * seen:.2g} mm", (bar[0][0], bar[1][0])
    left.annotate(
        said, at_bar, (0, 3), textcoords="offset points", fontsize=6.5, color="white",
        rotation=np.rad2deg(turn), rotation_mode="anchor",
    )  # fmt: skip
    figure.colorbar(picture, ax=[left, right], label=f"pressure [{unit}]", shrink=0.8)
    return figure


class _Axes:
    """The axes of a figure, on which the finger lies moved and turned, in mm."""

    def __init__(self, origin: npt.ArrayLike, turn: float) -> None:
        self._origin, self._turn = origin, turn

    def turned(self, vectors: _Floats) -> _Floats:
        """Vectors on the finger, of shape (..., 2), as (2, ...)."""
        return np.moveaxis(vectors @ turned(self._turn).T, -1, 0)

    def of(self, y: _Floats, z: _Floats) -> _Floats:
        """Positions on the finger [m], as (2, ...)."""
        return np.moveaxis(MM * on_touches(np.stack([y, z], axis=-1), self._origin, self._turn), -1, 0)

    def size(self, found: PressureImage) -> tuple[float, float]:
        """Width and height of an image."""
        y, z = self.of(*np.meshgrid(found.y[[0, -1]], found.z[[0, -1]]))
        return float(np.ptp(y)), float(np.ptp(z))


def _image(
    axes: Axes, nodes: tuple[_Floats, ...], at: _Axes, values: npt.NDArray[np.float64], largest: float
) -> QuadMesh:
    picture = axes.pcolormesh(
        *at.of(*np.meshgrid(*nodes)), values.T, shading="gouraud",
        cmap="viridis", vmin=0.0, vmax=largest, rasterized=True,
    )  # fmt: skip
    axes.set_aspect("equal")
    return picture


def _sensors_above(axes: Axes, found: PressureImage, at: _Axes) -> None:
    points = found.mapper.array.points
    for used, face in ((True, "white"), (False, "none")):
        axes.plot(
            *at.of(*points[found.used == used].T), "o", markersize=1.6, markerfacecolor=face, markeredgecolor="white",
            markeredgewidth=0.4, alpha=0.6,
        )  # fmt: skip


def _drag(axes: Axes, found: PressureImage, at: _Axes, drag: _Floats) -> None:
    size = np.hypot(drag[..., 0], drag[..., 1])
    every, largest = max(1, len(found.y) // 16), float(np.hypot(*np.moveaxis(found.shear, -1, 0)).max())
    shown = np.zeros_like(size, dtype=bool)
    shown[::every, ::every] = size[::every, ::every] > _FAINT * largest
    if largest > 0 and shown.any():
        y, z = np.meshgrid(found.y, found.z, indexing="ij")
        axes.quiver(
            *at.of(y[shown], z[shown]), *at.turned(drag[shown]), color="white", width=0.005, pivot="mid",
            angles="xy", scale_units="xy", scale=largest / (1.5 * every * MM * (found.y[1] - found.y[0])),
        )  # fmt: skip


def pressure_movie(
    found: PressureImage,
    path: str | PathLike[str],
    *,
    rate: float = 10.0,
    origin: npt.ArrayLike = (0.0, 0.0),
    turn: float = 0.0,
) -> None:
    """Write the images of frames as an animated GIF, all on one scale; frames without a contact are dark.

    Parameters
    ----------
    found : PressureImage, shape (frames,)
        What `pressure_map` found.
    path : path-like
        The file, .gif.
    rate : float, optional
        Frames per second [Hz].
    origin : (float, float), optional
        The finger's (0, 0) on the axes of the figure [m].
    turn : float, optional
        Angle from the axes of the figure to the finger's, from +y towards +z [rad].

    Raises
    ------
    GeometryError
        No frames, or too many; none with a contact.
    FileError
        A file that cannot be written.

    Examples
    --------
    >>> import subskin as ss
    >>> array = ss.SensorArray.grid(shape=(4, 4), pitch=2e-3, depth=2e-3, transducer=ss.MeanPressure(), noise=20.0)
    >>> pad = ss.Finger(ss.HalfSpace(ss.Material(young=0.4e6)), array)
    >>> growing = ss.RoundHertz(force=[1.0, 2.0], half_width=2e-3)
    >>> film = getfixture("tmp_path") / "film.gif"
    >>> pressure_movie(ss.pressure_map(pad, pad.read(growing), shear="none"), film)
    >>> film.stat().st_size > 1000
    True
    """
    there = np.isfinite(found.normal_force)
    if len(found.shape) != 1 or not 0 < found.shape[0] <= _MOST or not there.any():
        seen = f"images of shape {found.shape}, {int(there.sum())} with a contact"
        raise GeometryError(seen, f"a movie has 1 to {_MOST} frames, some with a contact", "found[::10]")
    at = _Axes(origin, turn)
    pressure = np.where(there[:, None, None], found.pressure, 0.0)
    largest = float(pressure.max())
    scale, unit = scale_of(largest, found.mapper.relative, "m²")
    with house_style():
        wide, high = at.size(found)
        figure = new_figure(100.0, min(25.0 + 75.0 * high / wide, 120.0))
        axes = figure.subplots()
        picture = _image(axes, (found.y, found.z), at, pressure[0] / scale, largest / scale)
        axes.set(xlabel="position $y$ [mm]", ylabel="position $z$ [mm]")
        axes.plot(*at.of(*found.mapper.array.points.T), "o", markersize=1.2, color=Ink.GREY)
        figure.colorbar(picture, ax=axes, label=f"pressure [{unit}]", shrink=0.8)
        title = axes.set_title(" ")
        settled(figure)
        figure.set_dpi(_DPI)
        frames = []
        for i, values in enumerate(pressure):
            picture.set_array(np.transpose(values / scale))
            title.set_text(f"frame {i}: {found.normal_force[i]:.3g} N" if there[i] else f"frame {i}")
            frames.append(drawn(figure))
    with replacing(str(path)) as part:
        frames[0].save(part, format="GIF", save_all=True, append_images=frames[1:], duration=1e3 / rate, loop=0)


def drawn(figure: Figure) -> Image.Image:
    """The figure as a picture."""
    canvas: Any = FigureCanvasAgg(figure)
    canvas.draw()
    return Image.fromarray(np.asarray(canvas.buffer_rgba())[..., :3].copy())
