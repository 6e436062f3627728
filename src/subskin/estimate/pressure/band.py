"""How far the pressure on an area may be off where it presses: by noise, by the smoothing, and by the drag.

At a weight w the heights are p = H^-1 (A^T b - cost) on the elements that press, H = A^T A + w K. The true ones have
loads q = w K p, in the picture of a stretched membrane, of which the smoothing leaves A^T A H^-1 q. So the error is

    H^-1 A^T (noise) - H^-1 q,        of variance  diag(H^-1 A^T A H^-1) + (H^-1)^2 s

where the loads are independent and have the variances s. Those follow from the loads of the image itself: the load at
i has the expected square (P A^T A P^T)_ii + sum_k Q_ik^2 s_k, with P = w K H^-1 and Q = A^T A H^-1 = 1 - P. What
exceeds the noise's part is put back by Q^2, such that equal variances come out as they are. It is a local form of what
White (Econometrica 48, 1980, 817) does for regressions whose errors differ.

The prior of the evidence, slopes that are Gaussian with one variance all over the search, is not asked: most of the
search is empty there, so that the weight is too large for what is pressed, and the smoothing counts for too little.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from ..._check import FloatArray

__all__ = ["deviations"]


def deviations(parts: FloatArray, drag: FloatArray, form: Any, heights: FloatArray) -> FloatArray:
    """Standard deviations of the heights of elements about a contact.

    Parameters
    ----------
    parts : ndarray, shape (1, k, n) or (3, k, n)
        Whitened readings per Pa of the pressure at each element, and of drags along y and z.
    drag : ndarray, shape (2,)
        Tangents of the drag; of no account without its parts.
    form : sparse matrix, shape (k, k)
        Weight times the smoothness form, w K.
    heights : ndarray, shape (k,)
        Pressure found [Pa].

    Returns
    -------
    ndarray, shape (k,)
        [Pa]
    """
    columns = parts[0] + sum(t * part for t, part in zip(drag, parts[1:], strict=False))
    inverse = np.linalg.inv(columns @ columns.T + form.toarray())
    kept = form @ inverse  # P
    by_noise = inverse - inverse @ kept  # H^-1 A^T A H^-1
    seen = (np.eye(len(heights)) - kept) ** 2  # Q^2
    excess = (form @ heights) ** 2 - np.asarray(form.multiply(form @ by_noise).sum(axis=1)).reshape(-1)
    loads = np.maximum(seen.T @ excess / (seen.T @ seen.sum(axis=1)), 0.0)
    variance = np.diagonal(by_noise) + inverse**2 @ loads
    if len(parts) > 1:
        leans = parts[1:].transpose(0, 2, 1) @ heights  # what the readings gain by a tangent
        crossed = columns @ leans.T
        follows = inverse @ crossed  # minus what the heights lose by it
        curve = leans @ leans.T - crossed.T @ follows
        variance = variance + np.einsum("ka,ab,kb->k", follows, np.linalg.pinv(curve, hermitian=True), follows)
    return np.asarray(np.sqrt(np.maximum(variance, 0.0)))
