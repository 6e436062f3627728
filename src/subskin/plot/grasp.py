"""Skins in simulation: what presses on one, a lift over time, and a film of it."""

from __future__ import annotations

from os import PathLike
from typing import Any

import numpy as np
from matplotlib.patches import Ellipse, Rectangle

from ..grasp import Hand, Lifted, Phase, Thing, lift
from ..io.files import replacing
from ..mujoco import Felt
from .above import mark_drag
from .pressure import drawn
from .style import DOUBLE, MM, SINGLE, Figure, Ink, finished, house_style, new_figure, settled

__all__ = ["felt_figure", "lift_figure", "lift_movie"]

_PHASES = {Phase.CLOSE: "close", Phase.LOAD: "load", Phase.HOLD: "lift and hold", Phase.LOWER: "lower"}
_EVERY = 40
"""Frames between two pictures of a film."""
_RATE = 12.5
"""Pictures of a film a second: it runs at its own speed."""
_CELLS, _BLUR = 32, 1.2
"""Cells along the longer side of a skin, in a picture of its pressure, and over how many of them it is smoothed."""
_DPI = 90
"""Of a film."""


@finished
def felt_figure(felt: Felt) -> Figure:
    """The skin from above: pressure, drags as arrows, and the sensors.

    Parameters
    ----------
    felt : Felt
        What a skin feels, as of `contact_to_skin`.

    Examples
    --------
    >>> import mujoco, subskin as ss
    >>> model = mujoco.MjModel.from_xml_string(
    ...     '<mujoco><worldbody><geom name="pad" type="box" size=".01 .01 .005"/></worldbody></mujoco>')
    >>> array = ss.SensorArray.grid(shape=(4, 4), pitch=4e-3, depth=2.5e-3)
    >>> finger = ss.Finger(ss.HalfSpace(ss.Material(young=0.4e6)), array)
    >>> data = mujoco.MjData(model)
    >>> len(felt_figure(ss.mujoco.contact_to_skin(model, data, "pad", finger, "+z")).axes)
    2
    """
    figure = new_figure(SINGLE + 16.0, 84.0)
    axes = figure.subplots()
    values, (low, high) = _pressures(felt)
    picture = axes.imshow(
        values.T / 1e3,
        origin="lower",
        extent=(low[0], high[0], low[1], high[1]),
        cmap="viridis",
        vmin=0.0,
        vmax=max(values.max() / 1e3, 1e-3),
    )
    figure.colorbar(picture, ax=axes, label="pressure [kPa]", shrink=0.8)
    y, z = MM * np.unique(felt.skin.finger.array.points, axis=0).T
    axes.plot(y, z, "o", markersize=3.0, markerfacecolor="none", color="white", label="sensors")
    for touch in felt.touches:
        shares = touch.forces[:, 0] / touch.force[0]
        mark_drag(axes, shares @ touch.points, touch.force, high.max(), Ink.ORANGE)
    n, ty, tz = felt.force
    axes.set_title(f"{n:.3g} N, drag ({ty:.2g}, {tz:.2g}) N".replace("-", "−"))
    axes.set(xlabel="position $y$ [mm]", ylabel="position $z$ [mm]")
    return figure


def _pressures(felt: Felt) -> tuple[Any, tuple[Any, Any]]:
    """Pressure in cells of the skin, smoothed over one of them [Pa], and its lowest and its highest corner [mm]."""
    half = felt.skin.surface.half
    cell = 2 * half.max() / _CELLS
    counts = np.maximum(np.round(2 * half / cell).astype(int), 1)
    shares = []
    for at, reach, count in zip(felt.points.T, half, counts, strict=True):
        middles = reach * (np.arange(0.5, count) * 2 / count - 1)
        shares.append(np.exp(-0.5 * ((middles[:, None] - at) / (_BLUR * cell)) ** 2))
    y, z = shares
    return (y * felt.forces[:, 0]) @ z.T / (2 * np.pi * (_BLUR * cell) ** 2), (-MM * half, MM * half)


@finished
def lift_figure(lifted: Lifted) -> Figure:
    """A lift over time: force against the least that holds, and how far the thing slid in the hand.

    Parameters
    ----------
    lifted : Lifted
        What came of it.

    Examples
    --------
    >>> from subskin.grasp import FixedHand, Thing, lift, pad_finger
    >>> ball = Thing("ball", (0.02, 0.02, 0.02), mass=0.1, friction=0.7)
    >>> len(lift_figure(lift(ball, FixedHand([pad_finger()] * 2, grip=4.0))).axes)
    3
    """
    time, phase, _, normal, drag, thing, gripper = lifted.trace.T
    figure = new_figure(DOUBLE, 110.0)
    force, height, slid = figure.subplots(3, 1, sharex=True, height_ratios=(2.0, 1.0, 1.0))
    force.plot(time, normal, color=Ink.BLUE, label="normal force of a finger")
    force.plot(time, drag / lifted.thing.friction, color=Ink.VERMILLION, label="the least that holds, drag / friction")
    force.set_ylabel("force [N]")
    force.legend(loc="upper left", fontsize="small")
    height.plot(time, MM * (thing - lifted.thing.half_height), color=Ink.BLACK)
    height.set_ylabel("height [mm]")
    moved = thing - gripper
    pulled = (phase >= Phase.LOAD) & (phase < Phase.OPEN)
    start = moved[pulled][0] if pulled.any() else 0.0
    slid.plot(time, np.where(pulled, MM * (moved - start), np.nan), color=Ink.GREEN)
    slid.set(ylabel="slid [mm]", xlabel="time [s]")
    for each, name in _PHASES.items():
        when = time[phase == each]
        if when.size:
            for axes in (force, height, slid):
                axes.axvline(when[0], color=Ink.GREY, linewidth=0.5)
            force.text(
                when[0], 1.01, f" {name}", transform=force.get_xaxis_transform(), fontsize="x-small", va="bottom"
            )
    return figure


def lift_movie(thing: Thing, hand: Hand, path: str | PathLike[str], seed: int = 0) -> Lifted:
    """Lift a thing, and write it as an animated GIF: the scene from the front, a pad's pressure, the forces.

    Parameters
    ----------
    thing, hand, seed
        As of `lift`.
    path : path-like
        The file, .gif.

    Raises
    ------
    FileError
        A file that cannot be written.

    Examples
    --------
    >>> from subskin.grasp import Thing, hand_of
    >>> ball, film = Thing("ball", (0.02, 0.02, 0.02), mass=0.1, friction=0.7), getfixture("tmp_path") / "film.gif"
    >>> lift_movie(ball, hand_of("cone"), film).dropped, film.stat().st_size > 10_000
    (False, True)
    """
    shots: list[tuple[Any, ...]] = []
    count = 0

    def watch(data: Any, felt: list[Felt], asked: float) -> None:
        nonlocal count
        if count % _EVERY == 0:
            at = {name: data.body(name).xpos[[0, 2]].copy() for name in ("thing", "left", "right")}
            turn = np.degrees(np.arctan2(data.body("thing").xmat[6], data.body("thing").xmat[0]))
            shots.append((data.time, at, turn, _pressures(felt[0])[0], [each.force for each in felt], asked))
        count += 1

    lifted = lift(thing, hand, seed, watch)
    with house_style():
        frames = _film(thing, shots)
    with replacing(str(path)) as part:
        frames[0].save(part, format="GIF", save_all=True, append_images=frames[1:], duration=1e3 / _RATE, loop=0)
    return lifted


def _film(thing: Thing, shots: list[tuple[Any, ...]]) -> list[Any]:
    figure = new_figure(150.0, 75.0)
    scene, pad, bars = figure.subplots(1, 3, width_ratios=(1.6, 1.3, 0.7))
    largest = max(shot[3].max() for shot in shots) / 1e3
    most = 1.1 * max(force[0] for shot in shots for force in shot[4])
    picture = pad.imshow(shots[0][3].T, origin="lower", extent=(-8, 8, -8, 8), cmap="viridis", vmin=0.0, vmax=largest)
    pad.set(title="pressure on a pad", xlabel="$y$ [mm]", ylabel="$z$ [mm]")
    figure.colorbar(picture, ax=pad, label="kPa", shrink=0.6)
    drawn_bars = bars.bar([0, 1], [0, 0], color=[Ink.BLUE, Ink.VERMILLION], width=0.7)
    bars.set(ylim=(0, most), ylabel="N", title="a finger")
    bars.set_xticks([0, 1], ["force", "least\nthat holds"], fontsize="x-small")
    wide = MM * (float(np.asarray(thing.size)[0]) + 30e-3)
    scene.set(xlim=(-wide, wide), ylim=(-5, 2 * MM * thing.half_height + 105), aspect="equal", xlabel="$x$ [mm]")
    scene.axhspan(-5, 0, color=Ink.GREY, alpha=0.4)
    body = _outline(thing)
    scene.add_patch(body)
    pads = [Rectangle((0, 0), 10, 16, color=Ink.SKY) for _ in range(2)]
    for each in pads:
        scene.add_patch(each)
    title = scene.set_title(" ")
    settled(figure)
    figure.set_dpi(_DPI)
    frames = []
    for time, at, turn, pressure, forces, _ in shots:
        _put(body, MM * at["thing"], turn)
        for each, side in zip(pads, ("left", "right"), strict=True):
            each.set_xy(MM * at[side] - (5.0, 8.0))
        picture.set_array(pressure.T / 1e3)
        normal = np.mean([force[0] for force in forces])
        drag = max(float(np.hypot(*force[1:])) for force in forces)
        for bar, value in zip(drawn_bars, (normal, drag / thing.friction), strict=True):
            bar.set_height(value)
        title.set_text(f"{thing.shape}, {1e3 * thing.mass:.0f} g, {time:.1f} s")
        frames.append(drawn(figure))
    return frames


def _outline(thing: Thing) -> Any:
    x, _, z = MM * np.asarray(thing.size)
    if thing.shape in ("ball", "egg"):
        return Ellipse((0, 0), 2 * x, 2 * (x if thing.shape == "ball" else z), color=Ink.ORANGE)
    return Rectangle((-x, -z), 2 * x, 2 * z, color=Ink.ORANGE, rotation_point="center")


def _put(body: Any, at: Any, turn: float) -> None:
    if isinstance(body, Ellipse):
        body.set_center(tuple(at))
    else:
        body.set_xy((at[0] - body.get_width() / 2, at[1] - body.get_height() / 2))
    body.set_angle(turn)
