r"""
A fingertip: layers on a core, and ridges
=========================================

A finger of 8 mm radius has an epidermis on its rubber, and a core. What does a sensor 1.5 mm deep read of a press and
of a drag, on a flat layer of the same thickness, on the round tip, and with ridges on it?
"""

import numpy as np

import subskin as ss
from subskin.plot.style import Ink, house_style, new_figure
from subskin.skin import Ridged

rubber, stiff = ss.Material(young=0.4e6), ss.Material(young=2e6, poisson=0.48)
epidermis = ss.Layer(stiff, thickness=0.3e-3)
tip = ss.Round(rubber, radius=8e-3, core_radius=4e-3, layers=epidermis)
skins = {
    "flat": ss.Layered([epidermis, ss.Layer(rubber, 3.7e-3)]),
    "round": tip,
    "round, with ridges": Ridged(tip, pitch=tip.period / 80, height=0.4e-3),
}
array = ss.SensorArray([0.0], depth=1.5e-3)
y = np.linspace(-6e-3, 6e-3, 241)
fields = {
    name: ss.Finger(skin, array).receptive_field(y)[:, 0] for name, skin in skins.items()
}

# %%
# The core's roundness makes a press stronger. The epidermis and the ridges change what a drag does: a ridge is a lever,
# so a drag presses on one side of it and pulls on the other.

with house_style():
    figure = new_figure(174, 72)
    panels = figure.subplots(1, 2)
    for axes, load, title in zip(panels, (0, 1), ("a press", "a drag"), strict=True):
        for (name, field), colour in zip(
            fields.items(), (Ink.GREY, Ink.BLUE, Ink.VERMILLION), strict=True
        ):
            axes.plot(1e3 * y, 1e6 * field[:, load], color=colour, label=name)
        axes.axhline(0, color=Ink.GREY, lw=0.5)
        axes.set(xlabel="position of the load [mm]", ylabel="strain [1e-6 per N/m]")
        axes.set_title(title)
    panels[0].legend()

# %%
# Layers that stick, and layers that slide
# ----------------------------------------
#
# The strain along the depth beneath a roller that drags, from the surface to the core.

loose = ss.Layer(stiff, epidermis.thickness, bond="frictionless")
bonds = {"it sticks": tip, "it slides": ss.Round(rubber, 8e-3, 4e-3, layers=loose)}
roller = ss.Hertz(force=40.0, angle=0.4, half_width=1e-3)
x, across = np.linspace(0, 4e-3, 161), np.linspace(-4e-3, 4e-3, 161)

with house_style():
    figure = new_figure(174, 72)
    for axes, (name, skin) in zip(figure.subplots(1, 2), bonds.items(), strict=True):
        shear = 100 * skin.strain(roller, x[:, None], across).xy
        angle = across / tip.radius
        image = axes.pcolormesh(
            1e3 * (tip.radius - x[:, None]) * np.sin(angle),
            1e3 * (tip.radius - x[:, None]) * np.cos(angle),
            shear,
            cmap="PuOr",
            vmin=-3.5,
            vmax=3.5,
            shading="gouraud",
        )
        axes.plot(
            1e3 * (tip.radius - epidermis.thickness) * np.sin(angle),
            1e3 * (tip.radius - epidermis.thickness) * np.cos(angle),
            color=Ink.GREEN,
            lw=0.8,
        )
        axes.set(aspect="equal", xlabel="[mm]", ylabel="[mm]")
        axes.set_title(f"shear strain [%], {name}")
        figure.colorbar(image, ax=axes, shrink=0.8)
