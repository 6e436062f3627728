"""What unlabelled touches teach of a finger, what they cannot, and what that leaves in later answers."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import cached_property

import numpy as np

from .._check import FloatArray
from .._frozen import Frozen
from ._blind_model import BlindModel, Linearised

__all__ = ["Learning"]

_NULL = 1e-11
"""Share of the largest information below which a direction has none: differences lose the rest."""
_IN_NULL = 1e-4
_MOST_NAMED = 3
_MOST_TOUCHES = 1e15


class Learning(Frozen):
    """The Fisher information of x in the touches used, in units of the prior, and what follows from it.

    Parameters
    ----------
    model : BlindModel
        The finger as a function of x.
    x : ndarray, shape (p,)
        The finger found.
    near : Linearised
        The model there.
    factor : float
        Of the noise.
    """

    def __init__(self, model: BlindModel, x: FloatArray, near: Linearised, factor: float) -> None:
        self.model, self.x, self.count = model, x, len(near.rest)
        seen = (near.by_force[..., 0] != 0).sum(axis=1)
        self.spare = float((seen - near.force.shape[1] - model.dim).mean())
        self.information = near.information() / factor**2
        self.turn = model.turn(x)
        self._effects = _effects(near, factor)

    @cached_property
    def null(self) -> FloatArray:
        """Orthonormal directions of x of which touches tell nothing, be there ever so many, shape (p, z)."""
        values, vectors = np.linalg.eigh(self.information)
        return np.asarray(vectors[:, values <= _NULL * max(float(values[-1]), np.finfo(float).tiny)])

    def covariance(self, touches: float | None = None) -> FloatArray:
        """Of x after as many touches of the same kind, shape (p, p)."""
        share = 1.0 if touches is None else touches / self.count
        if np.isinf(share):
            return np.asarray(self.null @ self.null.T)
        # the null directions keep the prior, exactly: many touches would else blow up what rounding puts there
        taught = np.eye(len(self.x)) - self.null @ self.null.T
        return np.asarray(np.linalg.inv(np.eye(len(self.x)) + share * taught @ self.information @ taught))

    def std(self, touches: float | None = None) -> FloatArray:
        """Standard deviations of what is reported."""
        variance = np.einsum("rp,pq,rq->r", self.turn, self.covariance(touches), self.turn)
        return np.asarray(np.sqrt(variance))

    def touches_for(self, row: int, std: float) -> float:
        """How many touches it takes until the standard deviation of a reported number is `std`; inf for never."""
        return self._least(lambda touches: bool(self.std(touches)[row] <= std))

    def error_ratio(self, touches: float | None = None) -> tuple[float, float]:
        """RMS errors of position and of angle over those that a finger known exactly makes, on touches like these.

        Positions up to what no touches can tell (a common shift, on a half plane a scale).
        """
        covariance = self.covariance(touches)
        ratios = []
        for effect, variance in self._effects:
            unseen, size, _ = np.linalg.svd(effect @ self.null, full_matrices=False)
            unseen = unseen[:, size > 1e-6 * np.abs(effect).max()] if size.size else unseen
            left = effect - unseen @ (unseen.T @ effect)
            by_finger = np.einsum("mp,pq,mq->m", left, covariance, left)
            ratios.append(float(np.sqrt(1 + by_finger.mean() / variance.mean())))
        return ratios[0], ratios[1] if len(ratios) > 1 else np.nan

    def touches_for_ratio(self, ratio: float) -> float:
        """How many touches until both of `error_ratio` are at most `ratio`; inf for never."""
        return self._least(lambda touches: bool(np.nanmax(self.error_ratio(touches)) <= ratio))

    def _least(self, enough: Callable[[float], bool]) -> float:
        """The least number of touches that is `enough`; inf where none is.

        Not fewer than have as many readings to spare as there are numbers to learn.
        """
        if not enough(np.inf):
            return np.inf
        if enough(0.0):
            return 0.0
        low = high = int(np.ceil((len(self.x) - self.null.shape[1]) / self.spare))
        while not enough(high):
            low, high = high, 4 * high
            if high > _MOST_TOUCHES:
                return np.inf
        while high - low > 1:
            middle = (low + high) // 2
            low, high = (low, middle) if enough(middle) else (middle, high)
        return float(high)

    def unknown(self, names: Sequence[str]) -> tuple[str, ...]:
        """The null directions in words; `names` of what is reported."""
        said, found = [], np.zeros((len(self.x), 0))
        for text, pattern in self._patterns():
            inside = self.null @ (self.null.T @ pattern)
            if (np.linalg.norm(pattern - inside, axis=0) < _IN_NULL * np.linalg.norm(pattern, axis=0)).all():
                said.append(text)
                found = np.column_stack([found, inside])
        basis = np.linalg.qr(found)[0]
        rest = self.null - basis @ (basis.T @ self.null)
        vectors, size, _ = np.linalg.svd(rest, full_matrices=False)
        for vector in vectors.T[size > 0.5]:
            moved = np.abs(self.turn @ vector) / np.linalg.norm(self.turn, axis=1)
            largest = [i for i in np.argsort(-moved, kind="stable") if moved[i] > 0.1][:_MOST_NAMED]
            listed = ", ".join(names[i] for i in sorted(largest))
            said.append(listed if len(largest) == 1 else f"a change of {listed} together")
        return tuple(said)

    def _patterns(self) -> list[tuple[str, FloatArray]]:
        """Directions that have a name, as columns."""
        model, out = self.model, []
        array, dim = model.finger(self.x).array, model.dim
        arm = array.points[:, :dim] - array.points[:, :dim].mean(axis=0)

        def direction(**moves: FloatArray | float) -> FloatArray:
            x = np.zeros(len(self.x))
            for name, move in moves.items():
                part = model.slices[name]
                x[part] = np.asarray(move).reshape(-1) / model.prior[part]
            return x[:, None]

        if "gain" in model.slices:
            out.append(("the common scale of the gains: forces are found up to a factor", direction(gain=1.0)))
        if "position" in model.slices:
            moves = [direction(position=np.tile(unit, (len(arm), 1))) for unit in np.eye(dim)]
            out.append(("a common shift of all sensors: positions are found up to it", np.concatenate(moves, axis=1)))
        if "position" in model.slices and dim == 2:
            turn = direction(position=np.stack([-arm[:, 1], arm[:, 0]], axis=-1))
            out.append(("a common turn of all sensors: directions along the surface are found up to it", turn))
        deep = "depths" if "depths" in model.slices else "depth"
        if "position" in model.slices and deep in model.slices:
            depth = np.asarray(array.depth)
            lengths: dict[str, FloatArray | float] = {"position": arm}
            lengths[deep] = depth if deep == "depths" else float(depth.mean())
            said = "depths and positions"
            if "thickness" in model.slices:
                lengths["thickness"] = model.finger(self.x).skin.thickness - float(depth.max())
                said = "depths, positions and thickness"
            out.append((f"the common scale of {said}: lengths are found up to a factor", direction(**lengths)))
        return out


def _effects(near: Linearised, factor: float) -> list[tuple[FloatArray, FloatArray]]:
    """For position, then angle: how a change of x moves each touch's estimate (e, p), its variance by noise (e,).

    Of each touch d coordinates, and as many tilts of its force.
    """
    own, dim = np.concatenate([near.by_position, near.by_force], axis=-1), near.by_position.shape[2]
    # positions and forces differ in size by far
    size = np.linalg.norm(own, axis=1, keepdims=True)
    q, r = np.linalg.qr(own / size)
    back = np.linalg.inv(r) @ np.swapaxes(q, 1, 2) / np.swapaxes(size, 1, 2)  # (m, d + k, n)
    rows = [back[:, :dim]]
    if near.force.shape[1] > 1:
        across = np.linalg.svd(near.force[:, None])[2][:, 1:]
        rows.append(across @ back[:, dim:] / np.linalg.norm(near.force, axis=1)[:, None, None])
    return [
        (-(row @ near.by_finger).reshape(-1, near.by_finger.shape[2]), factor**2 * (row**2).sum(axis=2).reshape(-1))
        for row in rows
    ]
