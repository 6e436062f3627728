"""Locate the touches, settle the finger, and again: until neither moves.

The finger and all touches settle at once, by Levenberg and Marquardt, each touch's own unknowns eliminated.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from .._check import FloatArray
from ..errors import ConvergenceError
from ..estimate.answer import Status
from ..estimate.area.observable import refuse_blind
from ..estimate.estimate import Estimate
from ..finger import Finger
from ._blind_model import BlindModel, Linearised, UnknownTouch, Whitened

__all__ = ["Rounds"]

_MOST = 12
_SAME, _NEAR = 0.05, 1.5
"""Change of the noise's factor that ends the rounds, and ratio to the last below which it is halved."""

_ROUGHLY = 0.1
"""Largest misfit of a drawn finger to begin with, of its readings: more would drown the touches."""

_SURE = 0.3
"""Share of the touches that has to be told apart for the noise's factor to rest on those alone."""

_SILENT, _DEAD = 0.1, 0.1
"""A sensor that reads less than this of the typical one is looked at; less than this of what it should is dead."""

_BY_CHANCE = 1.5
"""Three standard deviations of the share of heads in as many throws, times their root."""

_TELLING = 10.0
"""What a sensor has to read in units of its noise, that silence should count."""


_STEPS = 60
_SETTLED = 1e-7
"""Fall of chi-square that a further step promises; its root is that step in standard deviations."""
_STUCK = 1e10
_LONGEST = 0.25
"""Furthest that one step moves a touch, in depths."""


class Rounds:
    """Locates every touch with the finger at hand, over the whole search, and fits the finger to those that are OK.

    The noise is taken `factor` times as large as drawn, by which residuals exceed it: to begin with for a finger that
    is not yet the real one, in the end for a model that does not fit. So touches that might lie elsewhere wait until
    the finger is good enough to tell.

    Parameters
    ----------
    finger : Finger
        As drawn.
    data : ndarray, shape (m, n)
        Readings, NaN where there are none.
    shares : mapping of str to ndarray
        The prior's standard deviation of each term, as `calibrate_blind` takes it.
    touch : UnknownTouch
        What touches are.
    ends : ndarray, shape (d, 2)
        Where touches are looked for [m].
    """

    def __init__(
        self, finger: Finger, data: FloatArray, shares: Mapping[str, FloatArray], touch: UnknownTouch, ends: FloatArray
    ) -> None:
        self.touch, self.ends = touch, ends
        usable = finger.array.usable(data)
        clean = np.where(usable, data, np.nan)
        self.factor = _first_factor(finger, clean, shares)
        self.live = self._live(finger, clean)
        seen = usable[:, self.live]
        self.readings = clean[:, self.live]
        self.spare = seen.sum(axis=1) - touch.unknowns
        self._refuse_too_few(len(data), shares)
        part = Finger(finger.skin, finger.array.select(self.live))
        if touch.dim == 2:
            refuse_blind(part)
        self.model = BlindModel(part, tuple(shares), _in_units(part, shares, self.live), touch)
        noise, offset = np.asarray(part.array.noise), np.asarray(part.array.offset)
        self.touches = Whitened(np.where(seen, (self.readings - offset) / noise, 0.0), seen)
        self.x = np.zeros(self.model.size)

    def _refuse_too_few(self, touches: int, shares: Mapping[str, FloatArray]) -> None:
        live, unknowns = int(self.live.sum()), self.touch.unknowns
        if live <= unknowns:
            rule = "only readings beyond a touch's own unknowns show the finger: one sensor more is needed"
            fix = "more sensors" + ", or friction=0 where touches press straight down" * (self.touch.loads > 1)
            raise ConvergenceError(f"{live} live sensors, and {unknowns} unknowns a touch", rule, fix)
        each = {name: live * (self.touch.dim if name == "position" else 1) for name in shares}
        size = sum(each[name] if share.shape else 1 for name, share in shares.items())
        over = int(np.maximum(self.spare, 0).sum())
        if over <= size:
            seen = f"{touches} touches, which have {over} readings more than unknowns, for {size} numbers of the finger"
            fix = f"at least {size // (live - unknowns) + 1} touches of all sensors, or fit less"
            raise ConvergenceError(seen, "more are needed", fix)

    def locate(self, finger: Finger, readings: FloatArray) -> Estimate:
        """Touches (m,) on `finger`, its noise taken `factor` times as large."""
        array = replace(finger.array, noise=self.factor * np.asarray(finger.array.noise))
        return self.touch.locate(finger, array, self.ends, readings)

    def run(self) -> tuple[Settled, npt.NDArray[np.bool_]]:
        """The finger and the touches that taught it, shape (m,)."""
        self.steady = False
        before, learnt = np.zeros(len(self.readings), dtype=bool), 0.0
        for _ in range(_MOST):
            finger, last = self.model.finger(self.x), self.factor
            self.factor = self._excess(self.locate(finger, self.readings), learnt)
            if 1 < self.factor < _NEAR * last and last < _NEAR * self.factor:
                self.factor = float(np.sqrt(self.factor * last))  # prior and noise else take turns
            found = self.locate(finger, self.readings)
            used = (found.status == Status.OK) & (self.spare > 0)
            enough = bool(self.spare[used].sum() > self.model.size)
            if not enough:  # to begin with
                used |= (found.status == Status.AMBIGUOUS) & (self.spare > 0)
            if self.spare[used].sum() <= self.model.size:
                raise self._too_few(found, used)
            positions = found.position[used].reshape(-1, self.touch.dim)
            settled = settle(self.model, self.touches.of(used), self.x, positions, self.ends, self.factor)
            self.steady = np.array_equal(used, before) and abs(self.factor - last) < _SAME * last
            if self.steady:
                break
            self.x, before = settled.x, used
            taught = np.eye(self.model.size) + settled.near.information() / self.factor**2
            learnt = self.model.size - float(np.trace(np.linalg.inv(taught)))
        if not enough:
            raise self._too_few(found, used)
        return settled, used

    def _excess(self, found: Estimate, learnt: float) -> float:
        """The noise's factor anew, at least 1: by medians, which a few odd touches do not move.

        From touches that are explained and touches that are not: were it from the former alone, it would shut out ever
        more of them. `learnt` is how many numbers they settled by themselves.
        """
        from scipy.special import chdtri

        sure = (found.status == Status.OK) | (found.status == Status.UNEXPLAINED)
        rows = sure & (self.spare > 0)
        if rows.sum() < _SURE * len(rows):
            rows = np.isfinite(found.residual) & (self.spare > 0)
        if not rows.any():
            return self.factor
        chi2, spare = self.factor**2 * found.residual[rows], self.spare[rows]
        total = float(spare.sum())
        shares = chi2 / chdtri(spare, 0.5) * total / max(total - learnt, 1.0)
        # half of them are above 1 by chance, give or take
        if (shares > 1).mean() < 0.5 + _BY_CHANCE / np.sqrt(len(shares)):
            return 1.0
        return max(float(np.sqrt(np.median(shares))), 1.0)

    def _too_few(self, found: Estimate, used: npt.NDArray[np.bool_]) -> ConvergenceError:
        counts = np.bincount(found.status.astype(np.intp), minlength=len(Status))
        listed = ", ".join(f"{counts[s]} {s.name.lower()}" for s in Status if counts[s])
        return ConvergenceError(
            f"touches: {listed}",
            f"{int(self.spare[used].sum())} readings more than unknowns in those that are sure, for {self.model.size} "
            "numbers of the finger",
            "more touches, larger errors allowed of the drawing, less to fit, or another skin or kind of sensor",
        )

    def _live(self, finger: Finger, data: FloatArray) -> npt.NDArray[np.bool_]:
        """Sensors that read what the others say they should, at least a tenth of it."""
        array = finger.array
        live = array.live & (np.isfinite(data).sum(axis=0) >= 2)
        size = np.zeros(len(array))
        rise = (data - np.asarray(array.offset)) / np.where(array.live, np.asarray(array.noise), 1.0)
        size[live] = np.sqrt(np.nanmean(rise[:, live] ** 2, axis=0))
        for i in np.flatnonzero(live & (size <= _SILENT * np.median(size[live]) if live.any() else live)):
            others = live.copy()
            others[i] = False
            if others.sum() < self.touch.unknowns:
                continue
            part = Finger(finger.skin, array.select(others))
            found = self.locate(part, data[:, others])
            rows = np.isfinite(found.force) & np.isfinite(rise[:, i])
            alone = Finger(finger.skin, array.select([i]))
            field = self.touch.fields(alone, found.position[rows].reshape(-1, self.touch.dim))[:, 0]
            field = field / np.asarray(alone.array.noise)
            expected = (field * found.components[rows, : self.touch.loads]).sum(axis=1)
            power = float((expected**2).sum())
            if power > _TELLING**2 * max(rows.sum(), 1) and float(expected @ rise[rows, i]) < _DEAD * power:
                live[i] = False
        return np.asarray(live)


def _first_factor(finger: Finger, data: FloatArray, shares: Mapping[str, FloatArray]) -> float:
    """By how much the drawing's errors may exceed the noise, roughly."""
    live = finger.array.live & np.isfinite(data).any(axis=0)
    if not live.any():
        return 1.0
    noise, offset = (np.asarray(getattr(finger.array, name))[live] for name in ("noise", "offset"))
    rise = (data[:, live] - offset) / noise
    share = min(sum(float((s**2).mean()) for name, s in shares.items() if name != "offset"), _ROUGHLY**2)
    lift = shares.get("offset", np.zeros(live.size)) + np.zeros(live.size)
    square = share * float(np.nanmean(rise**2)) + float(((lift[live] / noise) ** 2).mean())
    return max(float(np.sqrt(square)), 1.0)


def _in_units(finger: Finger, shares: Mapping[str, FloatArray], live: npt.NDArray[np.bool_]) -> dict[str, FloatArray]:
    """Standard deviations in the units of `BlindModel`, for the live sensors."""
    depth = np.asarray(finger.array.depth)
    unit = dict.fromkeys(("depth", "depths", "position"), float(depth.mean()))
    below = finger.skin.thickness - float(depth.max())
    unit["thickness"] = below if np.isfinite(below) else 1.0
    return {name: unit.get(name, 1.0) * (share[live] if share.shape else share) for name, share in shares.items()}


class Settled(NamedTuple):
    """The finger x, the positions of the touches (m, d) [m], and the model there."""

    x: FloatArray
    positions: FloatArray
    near: Linearised


def settle(
    model: BlindModel, touches: Whitened, x: FloatArray, positions: FloatArray, ends: FloatArray, factor: float
) -> Settled:
    """Minimise sum |rest|^2 / factor^2 + |x|^2 over the finger x and the touches' positions (m, d).

    `ends` (d, 2) bound the positions. Forces are eliminated exactly at every trial (variable projection; Golub and
    Pereyra 1973, with the derivative of Kaufman 1975), and the positions from each step's linear system: a Schur
    complement whose blocks, one a touch, are d by d. What is left is as large as x.
    """
    weight = 1 / factor**2
    longest = _LONGEST * float(np.asarray(model.drawn.array.depth).min())
    near = model.linearise(touches, x, positions)
    cost = weight * float((near.rest**2).sum()) + float(x @ x)
    damping = 1e-3
    for _ in range(_STEPS):
        step = _Step(near, x, weight)
        following = np.inf
        while damping < _STUCK:
            by_finger, by_position, promised = step.solve(damping)
            if promised < _SETTLED:
                return Settled(x, positions, near)
            trial = np.clip(x + by_finger, model.low, model.high)
            moved = np.clip(positions + np.clip(by_position, -longest, longest), *ends.T)
            rest = model.fit_forces(touches, trial, moved)[3]
            following = weight * float((rest**2).sum()) + float(trial @ trial)
            if following < cost:
                break
            damping *= 4
        else:  # rounding hides what is left to be gained
            break
        damping = max(0.2 * damping, 1e-9)
        x, positions, cost = trial, moved, following
        near = model.linearise(touches, x, positions)
    return Settled(x, positions, near)


class _Step:
    """The linear system of a step, for any damping."""

    def __init__(self, near: Linearised, x: FloatArray, weight: float) -> None:
        position, finger = near.free()
        self.x, self.weight = x, weight
        across = np.swapaxes(position, 1, 2)
        self.own, self.mixed = across @ position, across @ finger
        self.full = np.einsum("mnp,mnq->pq", finger, finger)
        self.pull_position = across @ near.rest[..., None]
        self.pull_finger = np.einsum("mnp,mn->p", finger, near.rest)

    def solve(self, damping: float) -> tuple[FloatArray, FloatArray, float]:
        """Changes of x and of the positions, and the fall of chi-square that they promise."""
        own, each = self.own.copy(), np.arange(self.own.shape[1])
        own[:, each, each] *= 1 + damping
        own[:, each, each] += own[:, each, each] == 0
        inverse = np.linalg.inv(own)
        pulled, mixed = inverse @ self.pull_position, inverse @ self.mixed
        left = self.weight * (self.full - np.einsum("mdp,mdq->pq", self.mixed, mixed))
        left[np.diag_indices_from(left)] += 1.0 + damping * self.weight * np.diag(self.full)
        right = self.weight * (self.pull_finger - np.einsum("mdp,md->p", self.mixed, pulled[..., 0])) - self.x
        by_finger = np.linalg.solve(left, right)
        by_position = pulled[..., 0] - mixed @ by_finger
        promised = float(right @ by_finger) + self.weight * float((self.pull_position * pulled).sum())
        return by_finger, by_position, promised
