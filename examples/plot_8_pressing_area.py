r"""
A corner of a box, pressed and dragged
======================================

A box is pressed with a blunt corner into a rubber layer, and dragged before it slips. Pressure, drag and the part that
still sticks are solved, not assumed. Then an array of sensors in the layer feels the contact.
"""

import numpy as np

import subskin as ss
from subskin.plot.style import Ink, house_style, new_figure

skin = ss.Layered(ss.Layer(ss.Material(young=0.4e6), thickness=3e-3))
corner = ss.pressing.BoxCorner(slope=0.35, edge_radius=2e-3)
drag = {"friction": 0.6, "tangential": (0.0, 0.08)}
pressed = ss.press(skin, corner, force=0.25, nodes=64, **drag)
print(pressed.status.name, pressed.reason)
touches = pressed.pressure > 0
print(f"{pressed.stick.sum() / touches.sum():.0%} of the contact sticks")

# %%
# Left: the pressure, the drag as arrows, and the part that sticks within the line. Right: the strain along the depth
# at 25 sensors, 1.5 mm deep. The corner's three edges show in the pressure, and hardly in the strain.

array = ss.SensorArray.grid(shape=(5, 5), pitch=1e-3, depth=1.5e-3, noise=1e-4)
readings = ss.Finger(skin, array).read(pressed.thinned(24))

y, z = 1e3 * pressed.y, 1e3 * pressed.z
with house_style():
    figure = new_figure(174, 80)
    left, right = figure.subplots(1, 2)
    drawn = left.pcolormesh(
        y, z, pressed.pressure.T / 1e3, cmap="Blues", shading="nearest"
    )
    left.contour(y, z, pressed.stick.T, levels=[0.5], colors="black", linewidths=1.2)
    every = slice(None, None, 4)
    drags = np.where(touches[..., None], pressed.shear, np.nan)[every, every]
    left.quiver(y[every], z[every], *drags.T, color=Ink.GREY, width=0.004)
    figure.colorbar(drawn, ax=left, label="pressure [kPa]", shrink=0.8)
    at, most = 1e3 * array.points, 100 * np.abs(readings).max()
    dots = right.scatter(
        *at.T, c=100 * readings, s=220, cmap="RdBu_r", vmin=-most, vmax=most
    )
    figure.colorbar(dots, ax=right, label="strain along the depth [%]", shrink=0.8)
    right.set(xlim=(-2.6, 2.6), ylim=(-2.6, 2.6))
    for axes, title in (
        (left, "pressure, drag, what sticks"),
        (right, "what the sensors read"),
    ):
        axes.set(aspect="equal", xlabel="y [mm]", ylabel="z [mm]", title=title)
