r"""
How far apart should the sensors be?
====================================

For a given skin two things follow from the spacing of the sensors: how accurately a load is located, and
whether it is located at all, that is, whether no other load explains the readings as well. Lengths are in
depths and noise in parts of full scale, the strain beneath a normal load, so the answer holds for any
finger.
"""

import numpy as np

import subskin as ss
from subskin.plot.style import BLUE, GREEN, ORANGE, VERMILLION, house_style, new_figure

skin = ss.HalfPlane(ss.Material(young=1.0))
full_scale = 3 / (2 * np.pi)  # |strain| one depth beneath a unit normal line load
noise = 2e-3 * full_scale
rng = np.random.default_rng(0)


def trial(count: int, spacing: float, touches: int = 1500) -> tuple[float, float]:
    """Median std of the place [depths]; share of touches that are not told for sure."""
    finger = ss.Finger(
        skin, ss.SensorArray.line(count=count, pitch=spacing, depth=1.0, noise=noise)
    )
    reach = 0.5 * spacing * (count - 1)
    load = ss.LineLoad(
        1.0, rng.uniform(-0.7, 0.7, touches), rng.uniform(-reach, reach, touches)
    )
    found = finger.locate(finger.read(load, rng=rng))
    sure = found.status == ss.Status.OK
    return float(np.sqrt(np.median(found.covariance[sure, 0, 0]))), 1 - float(sure.mean())


spacings = np.linspace(0.3, 2.5, 23)
results = {count: np.array([trial(count, s) for s in spacings]) for count in (3, 4, 6, 8)}

# %%
# Three sensors do best at a spacing of one depth, where the false roots of the memo's eq. (13) are far away
# or known, but do not do well. A fourth sensor removes them over a wide range of spacings. More sensors at
# the same spacing hardly locate a load better, for only those near it feel it; they cover more skin. Beyond
# 1.5 depths there are gaps in which too few sensors feel enough.

with house_style():
    figure = new_figure(174, 76)
    left, right = figure.subplots(1, 2)
    for (count, result), colour in zip(
        results.items(), (VERMILLION, ORANGE, GREEN, BLUE), strict=True
    ):
        left.plot(spacings, 100 * result[:, 1], color=colour, label=f"{count} sensors")
        if count > 3:  # of three sensors too few touches are left to compare
            right.plot(spacings, result[:, 0], color=colour)
    left.set(
        xlabel="spacing / depth",
        ylabel="not told for sure [% of touches]",
        ylim=(-2, 102),
    )
    left.set_title("ambiguity")
    right.set(
        xlabel="spacing / depth", ylabel="std of the place / depth", ylim=(0, 0.012)
    )
    right.set_title("accuracy of the others")
    figure.legend(*left.get_legend_handles_labels(), loc="outside lower center", ncols=4)
