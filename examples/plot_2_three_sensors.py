r"""
Three sensors: Fig. 6 of the memo
=================================

Three strain sensors leave a polynomial of degree eight in the place of the load, the memo's eq. (13). Each
of its real roots is a load that would explain the readings exactly, or a position that came in when
denominators were cleared. The memo's Fig. 6 takes the sensors at a depth of 3 and a pitch of 2.5, and
gives three readings.

The memo prints them positive in compression, against its own eq. (12); here they are negated, so that
tension is positive as everywhere else (see the :doc:`conventions </conventions>`).
"""

import numpy as np

import subskin as ss
from subskin.memo.three_sensors import Verdict, three_sensor
from subskin.plot.style import Ink, house_style, new_figure

sensors = np.array([-2.5, 0.0, 2.5])
depth = 3.0
readings = np.array([0.048, -0.18, -0.19])
found = three_sensor(readings, y=sensors, depth=depth, young=1.0, friction=1.0)

for root in found.roots:
    size, lean = f"P/E = {root.force:7.3f}", f"{np.degrees(root.angle):8.2f} deg"
    print(f"y = {root.position:7.4f}   {size}   {lean}   {root.verdict.name}")

# %%
# Four real roots. Two would have to pull on the skin, one leans further than friction can hold, and one is
# left. All four explain the readings, as the drawing shows: each curve is the strain at the sensors' depth
# under one root's load, and all of them pass through the three readings.

skin = ss.HalfPlane(ss.Material(young=1.0))
colours = {
    Verdict.ACCEPTED: Ink.GREEN,
    Verdict.PULLS: Ink.VERMILLION,
    Verdict.SLIPS: Ink.ORANGE,
}
y = np.linspace(-8, 9, 600)

with house_style():
    figure = new_figure(174, 100)
    above, below = figure.subplots(2, 1, sharex=True, height_ratios=[0.7, 1])
    for i, root in enumerate(found.roots):
        style = {
            "color": colours[root.verdict],
            "lw": 2 if root.verdict is Verdict.ACCEPTED else 1,
        }
        load = ss.LineLoad(root.force, root.angle, root.position)
        lean = f"{np.degrees(root.angle):.0f}°"
        label = f"y = {root.position:.2f}, {lean}: {root.verdict.name.lower()}"
        below.plot(
            y,
            skin.strain(load, x=depth, y=y).xx,
            ls=["-", "--", "-", "-."][i],
            label=label,
            **style,
        )
        # a load that presses ends on the surface, one that pulls starts there
        along = 2.2 * np.array([np.sin(root.angle), np.cos(root.angle)])
        ends = [np.array([root.position, 0]), np.array([root.position, 0]) + along]
        if root.normal_force > 0:
            ends = [end - along for end in ends]
        arrow = {
            "arrowstyle": "-|>",
            "shrinkA": 0,
            "shrinkB": 0,
            "mutation_scale": 12,
            **style,
        }
        above.annotate("", xy=ends[1], xytext=ends[0], arrowprops=arrow)
    above.axhline(0, color=Ink.BLACK)
    above.plot(sensors, np.full(3, depth), "s", color=Ink.BLACK, ms=5)
    above.set(
        ylim=(3.6, -2.6),
        yticks=[0, 3],
        ylabel="depth",
        title="the four loads (the arrows are of one length)",
    )
    above.spines["left"].set_bounds(3.6, 0)
    below.plot(sensors, readings, "o", color=Ink.BLACK, ms=5, zorder=5)
    below.axhline(0, color=Ink.GREY, lw=0.5, zorder=0)
    below.set(
        xlim=(-8, 9),
        ylim=(-0.6, 0.6),
        xlabel="position along the skin",
        ylabel=r"strain $\varepsilon_x$",
    )
    below.set_title("what each makes at the sensors' depth")
    figure.legend(*below.get_legend_handles_labels(), loc="outside lower center", ncols=4)
