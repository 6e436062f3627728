"""Rates of an afferent against those that each strain explains."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from .. import _check
from ..afferents import MEASURES, AfferentFit
from .style import DOUBLE, Figure, Ink, finished, new_figure

__all__ = ["afferent_figure"]


@finished
def afferent_figure(fits: Sequence[AfferentFit], rates: npt.ArrayLike) -> Figure:
    """Measured rates against fitted ones, a panel for each strain, the best first.

    Parameters
    ----------
    fits : sequence of AfferentFit
        What `afferents.fit_rates` found.
    rates : array_like, shape (rows,)
        What was measured [1/s].

    Examples
    --------
    >>> from subskin.afferents import Stimulus, fit_rates
    >>> gratings = [Stimulus("grating", width=0.5e-3, gap=gap * 1e-3) for gap in (0.5, 1.0, 2.0, 4.0)]
    >>> rates = [5.0, 20.0, 45.0, 60.0]
    >>> len(afferent_figure(fit_rates(gratings, rates, depth=0.7e-3), rates).axes)
    4
    """
    seen = _check.real("rates", rates, unit="1/s")
    figure = new_figure(DOUBLE, 58.0)
    panels = np.atleast_1d(figure.subplots(1, len(fits), sharex=True, sharey=True))
    most = 1.05 * max(float(seen.max()), *(float(fit.rates.max()) for fit in fits))
    for axes, fit in zip(panels, fits, strict=True):
        axes.plot([0, most], [0, most], color=Ink.GREY, linewidth=0.8)
        axes.plot(fit.rates, seen, "o", color=Ink.BLUE, markersize=2.5, alpha=0.6)
        axes.set_title(
            f"{MEASURES[fit.measure].said}\n$R^2$ = {fit.r2:.2f}, {1e3 * fit.depth:.2f} mm deep", fontsize="small"
        )
        axes.set(xlim=(0, most), ylim=(0, most), aspect="equal")
    panels[0].set(ylabel="measured [1/s]")
    figure.supxlabel("fitted rate [1/s]", fontsize="medium")
    return figure
