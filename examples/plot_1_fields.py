r"""
The field beneath a contact
===========================

Four objects press on the same skin with the same load and the same width, leaning a little. What arrives
beneath differs close to the surface and is the same further down: a sensor deeper than the contact is wide
feels a resultant, not a shape.

Blue is compressed, red is stretched, along the depth; the dashed lines mark depths of one half and of two
half widths.
"""

import numpy as np

import subskin as ss
from subskin.plot.style import Ink, house_style, new_figure

skin = ss.HalfPlane(ss.Material(young=0.4e6))
a = 1e-3  # half width [m]
load = {"force": 40.0, "angle": 0.3, "half_width": a}
contacts = {
    "uniform strip": ss.Strip(**load),
    "Hertz": ss.Hertz(**load),
    "flat punch": ss.FlatPunch(**load),
    "wedge": ss.Wedge(**load),
}

# %%
# The strain along the depth in a section of the skin. The first row of points lies just beneath the
# surface: on it, the stress at a punch's edges is infinite.

x = np.linspace(0.02, 3.0, 150)[:, None] * a
y = np.linspace(-3.0, 3.0, 301) * a
levels = np.array([-10, -5, -2, -1, -0.5, -0.2, 0.2, 0.5, 1, 2, 5, 10])

with house_style():
    figure = new_figure(174, 122)
    panels = figure.subplots(2, 2, sharex=True, sharey=True)
    for panel, (name, contact) in zip(panels.flat, contacts.items(), strict=True):
        strain = 100 * skin.strain(contact, x, y).xx
        drawn = panel.contourf(
            y / a,
            x[:, 0] / a,
            strain,
            levels,
            cmap="RdBu_r",
            norm="symlog",
            extend="both",
        )
        shown = np.minimum(contact.pressure(y) * a / contact.normal_force, 1.1)
        panel.fill_between(y / a, -shown, 0, where=np.abs(y) <= a, color="#C9C9C9", lw=0)
        panel.axhline(0, color=Ink.BLACK, lw=0.9)
        for depth in (0.5, 2.0):
            panel.axhline(depth, color=Ink.BLACK, lw=0.6, ls=(0, (4, 3)))
        panel.set(title=name, aspect="equal", ylim=(3, -1.15))
        panel.spines["left"].set_bounds(3, 0)
    for panel in panels[:, 0]:
        panel.set(ylabel="depth $x/a$", yticks=[0, 1, 2, 3])
    for panel in panels[1]:
        panel.set(xlabel="position $y/a$")
    figure.colorbar(
        drawn, ax=panels, label=r"strain $\varepsilon_x$ [%]", ticks=levels, format="%g"
    )

# %%
# How soon does the shape stop to matter? The largest difference from a line load of the same force and
# angle, relative to the largest strain at that depth, falls with the square of the depth.

for depth in (0.5, 1.0, 2.0, 4.0, 8.0):
    line = skin.strain(ss.LineLoad(force=40.0, angle=0.3), depth * a, y * depth).xx
    off = [
        np.abs(skin.strain(c, depth * a, y * depth).xx - line).max() / np.abs(line).max()
        for c in contacts.values()
    ]
    print(
        f"depth {depth:3.1f} a: ",
        ", ".join(f"{n} {o:.3f}" for n, o in zip(contacts, off, strict=True)),
    )
