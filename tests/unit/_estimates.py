"""Estimates with the load and the covariance that a test wants."""

from __future__ import annotations

import numpy as np

import subskin as ss
from subskin.estimate.estimate import ANGLE, COVARIANCE, FORCE, POSITION, RIVAL, STATUS, WIDTH


def estimate(normal, tangential, covariance=(0.04, 0.0, 0.09), status=ss.Status.OK, friction=np.inf):
    """An estimate with these forces and this covariance (NN, NT, TT) of them."""
    normal, tangential = np.broadcast_arrays(np.asarray(normal, float), np.asarray(tangential, float))
    nn, nt, tt = covariance
    force = np.hypot(normal, tangential)
    cos, sin = normal / force, tangential / force
    table = np.full((*normal.shape, WIDTH), np.nan)
    table[..., POSITION], table[..., FORCE], table[..., ANGLE] = 0.0, force, np.arctan2(tangential, normal)
    table[..., COVARIANCE : COVARIANCE + 3] = [1e-10, 0.0, 0.0]
    table[..., COVARIANCE + 3] = cos**2 * nn + 2 * cos * sin * nt + sin**2 * tt
    table[..., COVARIANCE + 4] = (cos * sin * (tt - nn) + (cos**2 - sin**2) * nt) / force
    table[..., COVARIANCE + 5] = (sin**2 * nn - 2 * cos * sin * nt + cos**2 * tt) / force**2
    table[..., RIVAL + 3], table[..., STATUS] = np.inf, status
    return ss.Estimate(table, np.ones((*normal.shape, 6), bool), friction)
