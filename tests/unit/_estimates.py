"""Estimates with the load and the covariance that a test wants."""

from __future__ import annotations

import numpy as np

import subskin as ss
from subskin.estimate.layout import LINE


def estimate(normal, tangential, covariance=(0.04, 0.0, 0.09), status=ss.Status.OK, friction=np.inf):
    """An estimate with these forces and this covariance (NN, NT, TT) of them."""
    normal, tangential = np.broadcast_arrays(np.asarray(normal, float), np.asarray(tangential, float))
    table = np.full((*normal.shape, LINE.columns), np.nan)
    table[..., 0], table[..., 1], table[..., 2] = 0.0, normal, tangential
    table[..., LINE.covariance : LINE.covariance + 3] = [1e-10, 0.0, 0.0]
    table[..., LINE.covariance + 3 : LINE.residual] = covariance
    table[..., LINE.rival_chi2], table[..., LINE.status] = np.inf, status
    return ss.Estimate(table, np.ones((*normal.shape, 6), bool), friction)
