"""Rows of a budget of tolerances."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

__all__ = ["TOLD", "Cost", "Needed", "Recovery"]

TOLD = ("position", "force", "angle", "radius")
"""What a touch is asked for."""


@dataclass(frozen=True)
class Cost:
    """What a source of error costs in locating: one row of a budget.

    Parameters
    ----------
    source : str
        One of `SOURCES`, or "total" or "together".
    amount : float
        Its standard deviation, in `unit`: metres, readings, or "" for shares and for Poisson's ratio. Of `width`, the
        value itself; of `resolution`, the step.
    spread : {"finger", "fixed", "sensor", "reading"}
        Whether it is one number for the whole finger, one that is the same in all of them, each sensor's own, or each
        reading's.
    position_rms, angle_rms, force_rms : float
        Root mean square over touches and fingers [m, rad, share of the force]; on an area an error of the position is
        a distance, that of the angle one between directions.
    position_worst, angle_worst, force_worst : float
        At the worst touch, the error that the budget's `quantile` of the fingers (of the frames, for the noise) stay
        within; for `resolution` and `width` simply the largest.
    lost : float
        Share of the frames that are not OK any more.
    position_linear, angle_linear, force_linear : float
        Root mean square to first order: (J^T W J)^-1 J^T W times the change of the readings. Infinite where J is
        singular at one of the touches.
    radius_rms, radius_worst, radius_linear : float
        The same of the radius of touches that have one [m]; NaN of others.
    """

    source: str
    amount: float
    unit: str
    spread: str
    position_rms: float
    position_worst: float
    angle_rms: float
    angle_worst: float
    force_rms: float
    force_worst: float
    lost: float
    position_linear: float
    angle_linear: float
    force_linear: float
    radius_rms: float = np.nan
    radius_worst: float = np.nan
    radius_linear: float = np.nan


@dataclass(frozen=True)
class Needed:
    """How tight a tolerance has to be.

    Parameters
    ----------
    source, amount, unit
        As in `Cost`: as given.
    alone : float
        Amount with which this source alone would use up the wanted accuracy; infinite where that is more than ten times
        what was given.
    shared : float
        Amount with which it takes an equal share of the variance, beside the others that matter.
    """

    source: str
    amount: float
    unit: str
    alone: float
    shared: float


@dataclass(frozen=True)
class Recovery:
    """What self-calibration wins back of the errors that a source makes.

    Parameters
    ----------
    source : str
        One of `SOURCES`, or "together".
    drawn : Cost
        With the finger as drawn, on the same fingers.
    known, blind : Cost or None
        After calibrating at known positions, and from touches of which nothing is known; None where that was not asked.
    failed : tuple of (str, int)
        How many calibrations of each kind did not settle; these fingers count as drawn.
    """

    source: str
    drawn: Cost
    known: Cost | None
    blind: Cost | None
    failed: tuple[tuple[str, int], ...]
