r"""
A round finger on a table, and on its edge
==========================================

The memo's Figs. 7, 8 and 10: a round, elastic finger is pressed on something rigid. The contact is solved, not assumed:
where they touch, and how hard, follows from the finger's roundness, its rubber and its core.
"""

import numpy as np

import subskin as ss
from subskin.plot.style import Ink, house_style, new_figure

rubber = ss.Material(young=0.4e6)
skin = ss.Round(rubber, radius=8e-3, core_radius=4e-3)
finger = ss.Finger(skin, ss.SensorArray.line(count=8, pitch=0.75e-3, depth=1.5e-3))
positions = {
    "table": (ss.pressing.Flat(), 0.0),
    "edge at 0.3 mm": (ss.pressing.Edge(), 0.3e-3),
    "edge at 0": (ss.pressing.Edge(), 0.0),
}
pressed = {
    name: ss.press(skin, body, force=40.0, position=position)
    for name, (body, position) in positions.items()
}
for name, found in pressed.items():
    print(f"{name:14} {found.status.name}: {found.reason}")

# %%
# At the edge the pressure is infinite, as beneath a punch; the rest of the contact is that of a cylinder. The sensors
# feel the edge as a load that is narrower and lies aside.

with house_style():
    figure = new_figure(174, 72)
    above, below = figure.subplots(1, 2)
    for (name, found), colour in zip(
        pressed.items(), (Ink.BLUE, Ink.GREEN, Ink.VERMILLION), strict=True
    ):
        above.plot(1e3 * found.y, found.pressure / 1e3, color=colour, label=name)
        below.plot(
            1e3 * np.asarray(finger.array.y),
            100 * finger.read(found.contact),
            "o-",
            color=colour,
            lw=0.8,
        )
    above.set(
        xlabel="position along the finger [mm]",
        ylabel="pressure [kPa]",
        xlim=(-1.3, 1.3),
        ylim=(0, 90),
    )
    above.set_title("pressure")
    above.legend()
    below.axhline(0, color=Ink.GREY, lw=0.5)
    below.set(
        xlabel="position along the finger [mm]", ylabel="strain along the depth [%]"
    )
    below.set_title("eight sensors, 1.5 mm deep")

# %%
# Friction remembers
# ------------------
#
# A roller on the finger, pushed to and fro beneath its normal load. Near its edges it slips, in the middle it holds;
# the way back is not the way there. The slide is that of the roller against the finger's core.

roller = ss.pressing.Cylinder(radius=8e-3)
far = 150e-6
ways = np.concatenate(
    [
        np.linspace(0, far, 21),
        np.linspace(far, -far, 41)[1:],
        np.linspace(-far, far, 41)[1:],
    ]
)
state, loop = None, []
for way in ways:
    state = ss.press(skin, roller, force=40.0, friction=0.4, slide=way, after=state)
    stuck = float(np.diff(state.stick).sum()) / (2 * state.half_width)
    loop.append((state.tangential, stuck))
drags, stuck = np.array(loop).T

with house_style():
    figure = new_figure(174, 70)
    left, right = figure.subplots(1, 2)
    left.plot(1e6 * ways, drags, color=Ink.VERMILLION, marker=".", lw=0.8)
    left.set(xlabel="slide of the roller [µm]", ylabel="drag [N/m]")
    left.axhline(0.4 * 40, color=Ink.GREY, lw=0.5)
    left.axhline(-0.4 * 40, color=Ink.GREY, lw=0.5)
    left.set_title("drag, between the limits of friction")
    right.plot(1e6 * ways, 100 * stuck, color=Ink.BLUE, marker=".", lw=0.8)
    right.set(
        xlabel="slide of the roller [µm]",
        ylabel="part of the contact that sticks [%]",
        ylim=(-3, 103),
    )
    right.set_title("stick")
