"""The compiled heart of `Relaxation`: a Prony series run forwards or backwards, exactly, between any two times."""

from __future__ import annotations

import math

import numpy as np

from .._compiled import compiled

# Rows of the state, one value a sensor; the memory of each term follows.
REST, TIME, ELASTIC, MEMORY = range(4)
"""The reading at rest, the time of the last reading, and what an elastic skin would have read then, from the rest."""


@compiled(exact=True)
def relax(readings, time, share, constants, backwards, rows, out, taken):
    """Fill `out` (m, n) with what relaxes, or backwards with what an elastic skin would have read.

    readings (m, n); time (m,); share (k, n); constants (k,) [s]; rows (3 + k, n): the state, changed in place. Between
    two readings of a sensor the elastic one is taken to change linearly: the memory h of a term obeys h' = u' - h/tau.
    A reading that is not finite gives NaN, and the next one goes on from the last good one. The first good reading of a
    sensor whose rest is not known is its rest. taken (m, n), or (0, n) where nobody asks: the sum over the terms of how
    much each makes of the reading, |share (u - h)|; 0 where there is no reading.
    """
    frames, n = readings.shape
    terms = constants.size
    decay, gain = np.empty(terms), np.empty(terms)
    before = math.nan
    asked = taken.shape[0] > 0
    for k in range(frames):
        for i in range(n):
            if asked:
                taken[k, i] = 0.0
            if not math.isfinite(readings[k, i]):
                out[k, i] = math.nan
                continue
            if rows[REST, i] != rows[REST, i]:
                rows[REST, i] = readings[k, i]
            value = readings[k, i] - rows[REST, i]
            if rows[TIME, i] != rows[TIME, i]:  # from rest, at once
                rows[ELASTIC, i] = value
                for j in range(terms):
                    rows[MEMORY + j, i] = value
                rows[TIME, i] = time[k]
                out[k, i] = readings[k, i]
                continue
            step = time[k] - rows[TIME, i]
            if step != before:  # most sensors share their steps
                before = step
                for j in range(terms):
                    ratio = step / constants[j]
                    decay[j] = math.exp(-ratio)
                    gain[j] = -math.expm1(-ratio) / ratio if ratio > 0 else 1.0
            kept, held = 1.0, 0.0
            for j in range(terms):
                kept -= share[j, i] * (1.0 - gain[j])
                held += share[j, i] * (decay[j] * rows[MEMORY + j, i] - gain[j] * rows[ELASTIC, i])
            elastic = (value - held) / kept if backwards else value
            change = elastic - rows[ELASTIC, i]
            for j in range(terms):
                rows[MEMORY + j, i] = decay[j] * rows[MEMORY + j, i] + gain[j] * change
            rows[ELASTIC, i], rows[TIME, i] = elastic, time[k]
            out[k, i] = rows[REST, i] + (elastic if backwards else kept * elastic + held)
            if asked:
                for j in range(terms):
                    taken[k, i] += abs(share[j, i] * (elastic - rows[MEMORY + j, i]))
