r"""
A touch on an area
==================

A finger tip touches a point of the skin, presses and drags. The stress beneath it is shown from above and cut open;
then how well an array of sixteen sensors tells where such a touch is; and two touches that a row of sensors cannot
tell apart.
"""

import numpy as np

import subskin as ss
from subskin.plot import field_map, truth_above
from subskin.plot.style import DOUBLE, Ink, house_style, new_figure

skin = ss.HalfSpace(ss.Material(young=0.4e6, poisson=0.5))
touch = ss.PointLoad(force=1.0, angle=0.7, position=(0.0, 0.0))  # N, rad, m

figure = field_map(skin, touch, "stress.xx", span=(-6e-3, 6e-3), depth=6e-3)

# %%
# The touch leans, and so does the stress: the compression (blue) goes where the force points, and behind it the skin
# is pulled (red). Sixteen strain sensors feel that. Each cross is a touch, each dot where it was found from one noisy
# frame, and the ellipse holds the truth in 95 % of cases. Doubt grows beyond the edge of the array.

array = ss.SensorArray.grid(shape=(4, 4), pitch=3e-3, depth=3e-3, noise=2e-4)
finger = ss.Finger(skin, array)
along = np.linspace(-5e-3, 5e-3, 5)
truth = np.stack(np.meshgrid(along, along), axis=-1).reshape(-1, 2)
many = ss.PointLoad(force=np.ones(25), angle=0.4, azimuth=0.7, position=truth)
found = finger.locate(finger.read(many, rng=np.random.default_rng(1)))
figure_doubt = truth_above(
    found.position, truth, status=found.status,
    covariance=found.load.covariance[:, :2, :2], sensors=array.points,
)  # fmt: skip

# %%
# A row of sensors has a blind side. A press of 1 N beside it reads as one of 0.7 N on the other side that drags
# towards the row: at every sensor, to all digits. No number of sensors in the row tells them apart; a second row does.

row = ss.SensorArray.line(count=7, pitch=1.5e-3, depth=2e-3)
pressed = ss.PointLoad(components=(1.0, 0.0, 0.0), position=(1e-3, 2e-3))
dragged = ss.PointLoad(components=(0.7, 0.0, 0.3), position=(1e-3, -2e-3))
read = [ss.Finger(skin, row).read(each) for each in (pressed, dragged)]
print(f"largest difference of the readings: {np.abs(read[0] - read[1]).max():.0e}")

with house_style():
    figure_row = new_figure(DOUBLE, 62.0)
    above, strain = figure_row.subplots(1, 2, width_ratios=(1, 1.2))
    above.plot(1e3 * row.y, 0 * row.y, "s", color=Ink.GREY)
    for touch, readings, colour, side, words in (
        (pressed, read[0], Ink.BLUE, -1, "1 N, straight down"),
        (dragged, read[1], Ink.VERMILLION, 1, "0.76 N, towards the row"),
    ):
        (y, z), (_, _, drag) = 1e3 * touch.position, touch.components
        above.plot(y, z, "o", color=colour)
        above.text(y + 0.4, z, words, color=colour, va="center")
        if drag:
            arrow = {"arrowstyle": "-|>", "color": colour, "lw": 1.8}
            above.annotate("", (y, z + 1.6), (y, z), arrowprops=arrow)
        strain.bar(1e3 * row.y + 0.28 * side, 100 * readings, 0.5, color=colour)
    strain.axhline(0.0, color=Ink.GREY, linewidth=0.8)
    above.set(xlabel="y [mm]", ylabel="z [mm]", ylim=(-3.2, 3.2), xlim=(-5.5, 7.5))
    above.set(aspect="equal", title="seen from above: a row (grey), two touches")
    strain.set(xlabel="sensor at y [mm]", ylabel="strain along the depth [%]")
    strain.set(title="what the row reads of each: the same")
