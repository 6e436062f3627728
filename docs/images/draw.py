"""Draws the pictures of the README and of the documentation's pages; `make figures` runs it."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Arc, Rectangle

import subskin as ss
from subskin.design import rank_fingers, search_grid
from subskin.design.placement import Channel, study_at_depth
from subskin.io.goals_file import parse_goals
from subskin.plot import (
    aliasing_figure,
    contact_strip,
    design_map_figure,
    drift_figure,
    felt_figure,
    finger_section,
    half_plane_map_figure,
    lift_figure,
    memo_figure,
    placement_figure,
    placement_study_figure,
    pressed_ridges_figure,
    pressure_figure,
    pressure_image_figure,
    probability_strip,
    ridge_figure,
    side_angle_figure,
    slip_figure,
    tip_map_figure,
    tolerance_figure,
    two_point_study_figure,
)
from subskin.plot.style import Ink, house_style, new_figure, save

HERE = Path(__file__).parent
SKIN = "#F6E9DC"


def arrow(axes: Axes, tail: tuple[float, float], tip: tuple[float, float], colour: str, **more: object) -> None:
    """An arrow in data units, both ends exactly where they are said to be."""
    style = {"arrowstyle": "-|>", "mutation_scale": 10, "shrinkA": 0, "shrinkB": 0, "lw": 1.2, "color": colour, **more}
    axes.annotate("", xy=tip, xytext=tail, arrowprops=style, annotation_clip=False)


def span(axes: Axes, left: float, right: float, x: float, text: str, colour: str, above: bool = True) -> None:
    """A dimension line along y at depth x."""
    arrow(axes, (left, x), (right, x), colour, arrowstyle="<|-|>", mutation_scale=7, lw=0.8)
    va, dx = ("bottom", -0.1) if above else ("top", 0.1)
    axes.text((left + right) / 2, x + dx, text, ha="center", va=va, color=colour)


def conventions() -> Figure:
    """x, y, angle, the memo's three sensors and its two meanings of y."""
    figure = new_figure(174, 92)
    axes = figure.subplots()
    axes.set(xlim=(-4.6, 6.9), ylim=(4.25, -2.55), aspect="equal")
    axes.axis("off")
    axes.add_patch(Rectangle((-4.3, 0), 10.9, 4.15, facecolor=SKIN, edgecolor="none", zorder=0))
    axes.plot([-4.3, 6.6], [0, 0], color=Ink.BLACK, lw=1.4)
    f, b, depth, angle = 1.5, 2.5, 2.2, np.deg2rad(35)

    # the axes
    arrow(axes, (0, 0), (0, 1.25), Ink.BLACK)
    arrow(axes, (5.1, 0), (6.6, 0), Ink.BLACK, mutation_scale=13)
    axes.text(0.12, 1.18, "$x$, depth", va="bottom")
    axes.text(6.6, 0.14, "$y$, along the surface", ha="right", va="top")
    axes.plot(0, 0, "o", color=Ink.BLACK, ms=3)

    # the load, its angle and its parts
    tail = (f - 2.1 * np.sin(angle), -2.1 * np.cos(angle))
    axes.plot([f, f], [0, -2.2], ls=(0, (4, 3)), color=Ink.GREY, lw=0.7)
    arrow(axes, tail, (f, 0), Ink.BLUE, lw=2.2, mutation_scale=15)
    axes.add_patch(Arc((f, 0), 2.9, 2.9, theta1=270 - np.rad2deg(angle), theta2=270, color=Ink.BLUE, lw=0.9))
    axes.text(f - 0.42, -1.52, r"$\alpha$", color=Ink.BLUE, ha="center", va="bottom", fontsize=9)
    axes.text(tail[0] - 0.1, tail[1] + 0.1, r"force $P$ at angle $\alpha > 0$", color=Ink.BLUE, ha="right", va="bottom")
    normal, tangential = 2.1 * np.cos(angle), 2.1 * np.sin(angle)
    arrow(axes, (f, -normal), (f, 0), Ink.BLUE, lw=1.1, mutation_scale=12)
    arrow(axes, (f, 0), (f + tangential, 0), Ink.BLUE, lw=2.0, mutation_scale=12)
    axes.text(f + 0.12, -1.05, r"$N = P\,\cos\alpha$ presses in", color=Ink.BLUE, va="center")
    axes.text(f + 0.75, -0.16, r"$T = P\,\sin\alpha$ drags towards $+y$", color=Ink.BLUE, va="bottom")

    # the sensors
    for number, s in enumerate((-b, 0.0, b), start=1):
        axes.add_patch(Rectangle((s - 0.13, depth - 0.13), 0.26, 0.26, facecolor=Ink.GREEN, edgecolor="none", zorder=3))
        axes.text(s, depth + 0.22, str(number), ha="center", va="top", color=Ink.GREEN, fontweight="bold")
        axes.plot([s, s], [depth - 0.5, depth], color=Ink.GREEN, lw=0.6)
    span(axes, -b, 0, depth - 0.38, "$b$", Ink.GREEN)
    span(axes, 0, b, depth - 0.38, "$b$", Ink.GREEN)
    arrow(axes, (4.3, 0), (4.3, depth), Ink.GREEN, arrowstyle="<|-|>", mutation_scale=7, lw=0.8)
    axes.plot([b + 0.2, 4.45], [depth, depth], ls=":", color=Ink.GREEN, lw=0.8)
    axes.text(4.42, depth / 2 + 0.35, "depth $x$\nof the sensors", color=Ink.GREEN, va="center")

    # the two meanings of the memo's y
    axes.plot([f, f], [0, 3.55], ls=":", color=Ink.GREY, lw=0.7)
    axes.plot([-b, -b], [depth + 0.65, 3.55], ls=":", color=Ink.VERMILLION, lw=0.7)
    span(axes, 0, f, 0.42, "$f$", Ink.BLACK, above=False)
    arrow(axes, (-b, 3.4), (f, 3.4), Ink.VERMILLION, lw=1.0)
    axes.text(-b + 0.1, 3.32, r"$y_\mathrm{memo} = f - s$", color=Ink.VERMILLION, va="bottom")
    text = "the memo's $y$ in (1) to (8): from a field point, here sensor 1 at $s = -b$, to the load"
    axes.text(-b, 3.55, text, color=Ink.VERMILLION, va="top")
    axes.text(
        f + 0.15, 0.5, "position of the load;\nthis is the memo's $y$\nin (12) and (13)", color=Ink.BLACK, va="top"
    )
    return figure


def contacts() -> Figure:
    """What presses, and what of it arrives at two depths; lengths in half widths."""
    kinds = {
        "uniform strip": (ss.Strip(1.0, half_width=1.0), Ink.GREEN),
        "Hertz": (ss.Hertz(1.0, half_width=1.0), Ink.BLUE),
        "flat punch": (ss.FlatPunch(1.0, half_width=1.0), Ink.VERMILLION),
        "wedge": (ss.Wedge(1.0, half_width=1.0), Ink.ORANGE),
        "line load": (ss.LineLoad(1.0), Ink.BLACK),
    }
    skin = ss.HalfPlane(ss.Material(young=1.0))
    y = np.linspace(-3, 3, 1201)
    figure = new_figure(174, 62)
    panels = figure.subplots(1, 3)
    for name, (contact, colour) in kinds.items():
        line = name == "line load"
        style = {"color": colour, "ls": "--" if line else "-", "lw": 0.9 if line else 1.3}
        if line:
            arrow(panels[0], (0, 1.15), (0, 0), Ink.BLACK, ls="--", lw=0.9)
        else:
            within = np.abs(y) <= 1
            panels[0].plot(y[within], np.minimum(contact.pressure(y[within]), 1.3), **style)
        for panel, depth in zip(panels[1:], (0.5, 2.0), strict=True):
            panel.plot(y, skin.strain(contact, x=depth, y=y).xx, label=name, **style)
    panels[0].set(title="pressure", ylabel="$p\\,a/N$", ylim=(0, 1.2), xlim=(-1.6, 1.6))
    panels[1].set(title="strain at depth $0.5\\,a$", ylabel=r"$\varepsilon_x\,E\,a/N$", ylim=(-1.05, 0.28))
    panels[2].set(title="strain at depth $2\\,a$", ylabel=r"$\varepsilon_x\,E\,a/N$")
    for panel in panels:
        panel.set_xlabel("$y / a$")
        panel.axhline(0, color=Ink.GREY, lw=0.5, zorder=0)
    figure.legend(*panels[2].get_legend_handles_labels(), loc="outside lower center", ncols=5)
    return figure


def finger() -> Figure:
    """The picture of the README: what its own program makes and finds."""
    text = (HERE.parents[1] / "README.md").read_text(encoding="utf-8")
    program = text.split("```python\n")[1].split("```")[0]
    made: dict[str, Any] = {}
    exec(program, made)
    return finger_section(made["finger"], made["touch"], made["found"], readings=made["readings"])


def half_plane() -> Figure:
    """How wrong the half plane is over thickness and radius: the map that `subskin check --map` draws."""
    return half_plane_map_figure(ss.design.half_plane_map())


def tip() -> Figure:
    """What flat layers cost on a ball: the map that `subskin check --tip-map` draws."""
    return tip_map_figure(ss.design.tip.tip_map("sphere", "mean_pressure"), here=(4.0, 0.5))


def compliance() -> Figure:
    """The memo's Fig. 17, as `subskin figures` draws it."""
    return memo_figure(17)


def ridges() -> Figure:
    """The memo's Fig. 16, as `subskin figures` draws it."""
    return memo_figure(16)


def _ridged() -> ss.Finger:
    """A sensor at the depth that the memo gives for the macaque's."""
    skin = ss.HalfPlane(ss.Material(young=0.4e6))
    return ss.Finger(skin, ss.SensorArray(y=[0.0], depth=0.5e-3))


def ridge_map() -> Figure:
    """Gain over pitch and half width of the contact."""
    widths, pitches = 0.5e-3 * np.geomspace(0.3, 20, 32), 0.5e-3 * np.geomspace(1, 30, 40)
    touch = ss.Hertz(40.0, half_width=widths[:, None])
    return ridge_figure(ss.design.ridge_gain(_ridged(), touch, ss.design.Ridges(pitches)))


def pressed_ridges() -> Figure:
    """Ridges of many heights under a cylinder."""
    heights = np.geomspace(2e-6, 150e-6, 14)
    found = ss.design.press_ridges(_ridged(), np.pi * 1e-3, heights, force=200.0, radius=52e-3)
    return pressed_ridges_figure(found)


def two_sensors() -> Figure:
    """The memo's Fig. 18, as `subskin figures` draws it."""
    return memo_figure(18)


def three_sensors() -> Figure:
    """The memo's Fig. 19, as `subskin figures` draws it."""
    return memo_figure(19)


def two_points() -> Figure:
    """Least separations over pitch, count and noise: the study of docs/two_points.md."""
    unit = ss.Finger(ss.HalfPlane(ss.Material(young=1.0)), ss.SensorArray(y=[0.0], depth=1.0))
    touches = ss.design.Touches(force=1.0, span=(-1.0, 1.0))
    return two_point_study_figure(ss.design.two_point_study(unit, touches))


def side_angle() -> Figure:
    """The memo's Fig. 13 and its correction, and where each way to the angle is blind."""
    return side_angle_figure()


def slip() -> Figure:
    """The load of docs/slip.md in its friction cone, and what of the contact sticks."""
    page = (HERE.parent / "slip.md").read_text(encoding="utf-8")
    program = page.split("```python\n")[1].split("```")[0]
    made: dict[str, Any] = {}
    exec(program, made)
    return slip_figure(made["judged"])


def drift() -> Figure:
    """What the first block of docs/robust.md makes: a stream with drift, and the offsets that were followed."""
    text = (HERE.parent / "robust.md").read_text(encoding="utf-8")
    program = text.split("```python\n")[1].split("```")[0]
    made: dict[str, Any] = {}
    exec(program, made)
    true = made["drift"][:, 2] + made["array"].offset[2]
    return drift_figure(made["raw"], made["time"], made["tared"], sensor=2, truth=true, unit="strain")


def _stroke() -> tuple[ss.Finger, np.ndarray]:
    """Readings of an edge that goes along the skin, of a roller pressed harder and harder, of nothing, of a box."""
    row = ss.SensorArray.line(count=6, pitch=1e-3, depth=2e-3, noise=2e-5)
    tip = ss.Finger(ss.HalfPlane(ss.Material(young=0.4e6)), row)
    y, rng = np.linspace(-2e-3, 2e-3, 40), np.random.default_rng(0)
    force = np.linspace(8.0, 60.0, 40)
    touches = (
        ss.Wedge(15.0, 0.3, y, half_width=0.3e-3),
        ss.Hertz(force, -0.2, 0.5e-3, half_width=2.2e-3 * np.sqrt(force / 60)),
        ss.LineLoad(np.full(10, 1e-6), 0.0, 0.0),
        ss.FlatPunch(30.0, 0.1, 0.2 * y, half_width=1.5e-3),
    )
    return tip, np.concatenate([tip.read(touch, rng) for touch in touches])


def widths() -> Figure:
    """Contacts of some width along a stream, as `subskin fit --figure` draws them."""
    tip, stream = _stroke()
    return contact_strip(tip.fit(stream, "hertz"))


def kinds() -> Figure:
    """The probabilities of the kinds along the same stream, as `subskin decide --figure` draws them."""
    tip, stream = _stroke()
    return probability_strip(ss.decide.contact_type(tip, stream))


def pressure() -> Figure:
    """What the first block of docs/pressure.md finds, beside what pressed."""
    text = (HERE.parent / "pressure.md").read_text(encoding="utf-8")
    program = text.split("```python\n")[1].split("```")[0]
    made: dict[str, Any] = {}
    exec(program, made)
    return pressure_figure(made["found"], truth=made["two"])


def pressure_area() -> Figure:
    """What the block on an area of docs/pressure.md finds, beside what pressed."""
    return _image_of("## On an area", truth="touch")


def pressure_free() -> Figure:
    """What the block on a free drag of docs/pressure.md finds, beside what pressed."""
    return _image_of("**A free drag.**", truth="twist")


def _image_of(heading: str, *, truth: str) -> Figure:
    """The image that the first block below a heading of docs/pressure.md makes, and its contact of that name."""
    text = (HERE.parent / "pressure.md").read_text(encoding="utf-8")
    program = text.split(heading)[1].split("```python\n")[1].split("```")[0]
    made: dict[str, Any] = {"ss": ss, "np": np}
    exec(program, made)
    return pressure_image_figure(made["image"], truth=made[truth])


def response() -> Figure:
    """The memo's Fig. 15, as `subskin figures` draws it."""
    return memo_figure(15)


def sampling() -> Figure:
    """The memo's Fig. 14, as `subskin figures` draws it."""
    return memo_figure(14)


def density() -> Figure:
    """A dragged roller over sensors one depth apart, which is too far for what lies between them."""
    tip = ss.Finger(ss.HalfPlane(ss.Material(young=0.4e6)), ss.SensorArray(y=[0.0], depth=2e-3))
    return aliasing_figure(ss.design.aliasing_error(tip, ss.Hertz(40.0, 0.4, half_width=1e-3), 2e-3))


def tolerances() -> Figure:
    """What tolerances cost and what self-calibration leaves: the finger of docs/tolerances.md."""
    row = ss.SensorArray.line(count=8, pitch=1.5e-3, depth=2e-3, noise=5e-5)
    tip = ss.Finger(ss.HalfPlane(ss.Material(young=0.4e6)), row)
    budget = ss.design.tolerance_budget(
        tip, ss.design.Touches(force=20.0, friction=0.8), self_calibration=("known", "blind")
    )
    return tolerance_figure(budget, position=0.1e-3, angle=np.radians(2))


def placement() -> Figure:
    """Four sensors one depth apart: the finger of docs/placement.md."""
    row = ss.SensorArray.line(count=4, pitch=2e-3, depth=2e-3, noise=2e-5)
    tip = ss.Finger(ss.HalfPlane(ss.Material(young=0.4e6)), row)
    return placement_figure(ss.design.placement_quality(tip, ss.design.Touches(force=40.0)))


def rows() -> Figure:
    """Rows of three to sixteen sensors over their pitch: the study of docs/placement.md, pitches closer."""
    skin, touches = ss.HalfPlane(ss.Material(young=0.4e6)), ss.design.Touches(force=40.0)
    gauge, counts = Channel(ss.NormalStrain(), noise=2e-5), [3, 4, 5, 6, 8, 16]
    pitches = 2e-3 * np.linspace(0.2, 2.5, 47)
    study = study_at_depth(skin, gauge, 2e-3, pitches, counts, touches)
    return placement_study_figure(study, 2e-3, pitches, counts)


def design() -> Figure:
    """All designs of docs/designing.md, whose goals stand on that page."""
    page = (HERE.parent / "designing.md").read_text(encoding="utf-8")
    goals = parse_goals(page.split("```toml\n")[1].split("```")[0]).goals
    return design_map_figure(rank_fingers(search_grid(goals)))


def felt() -> Figure:
    """A cylinder that leans on a pad in MuJoCo (docs/mujoco.md)."""
    import mujoco

    model = mujoco.MjModel.from_xml_string(
        '<mujoco><worldbody><geom name="pad" type="box" size=".01 .01 .005"/>'
        '<body pos=".002 .002 .0299" euler="0 90 20"><freejoint/>'
        '<geom type="cylinder" size=".025 .006" mass=".2" condim="4"/></body></worldbody></mujoco>'
    )
    data = mujoco.MjData(model)
    data.xfrc_applied[1, :3] = 0.3, 0.5, -1.0
    mujoco.mj_step(model, data, 30)
    array = ss.SensorArray.grid((4, 4), 4e-3, depth=2.5e-3)
    finger = ss.Finger(ss.HalfSpace(ss.Material(young=0.4e6)), array)
    return felt_figure(ss.mujoco.contact_to_skin(model, data, "pad", finger, "+z"))


def lifted() -> Figure:
    """A box that is lifted, shaken, filled and put down by what two skins tell (docs/grasp.md)."""
    from subskin.grasp import hand_of, lift, things

    hand = hand_of("skin")
    hand.warm_up()
    return lift_figure(lift(things(1)[0], hand))


def main() -> None:
    with house_style():
        for draw, kind in (
            (conventions, "svg"),
            (contacts, "svg"),
            (finger, "png"),
            (half_plane, "svg"),
            (tip, "png"),
            (compliance, "png"),
            (slip, "svg"),
            (ridges, "png"),
            (ridge_map, "svg"),
            (pressed_ridges, "svg"),
            (two_sensors, "png"),
            (three_sensors, "png"),
            (two_points, "svg"),
            (side_angle, "svg"),
            (drift, "png"),
            (pressure, "png"),
            (pressure_area, "png"),
            (pressure_free, "png"),
            (widths, "png"),
            (kinds, "png"),
            (tolerances, "svg"),
            (response, "svg"),
            (sampling, "svg"),
            (density, "svg"),
            (placement, "png"),
            (rows, "svg"),
            (design, "svg"),
            (felt, "png"),
            (lifted, "png"),
        ):
            save(draw(), HERE / draw.__name__, [kind])


if __name__ == "__main__":
    main()
