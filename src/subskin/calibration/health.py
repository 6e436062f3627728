"""Which sensors have died or changed since the finger was calibrated, from touches of which nothing is known."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import numpy.typing as npt

from .. import _check
from .._check import FloatArray
from .._frozen import Frozen
from .._shown import Tabled, with_error
from ..errors import ConvergenceError
from ..estimate.answer import Status
from ..estimate.beside import points_on
from ..estimate.search import Locator
from ..finger import Finger, finger_needed
from ..response import tabulate
from .calibration import Health, checked_readings, weak

__all__ = ["SensorHealth", "sensor_health"]

_EXPLAINED = (Status.OK, Status.AMBIGUOUS)
_ROUNDS = 20  # of gains and touches in turn
_SETTLED = 1e-6
_INFLATED, _MOSTLY = (1.0, 3.0, 10.0, 30.0, 100.0), 0.8
_ENOUGH = 0.98  # of the touches explained: no sensor has to be suspected
_BETTER = 0.02  # share of the touches that leaving out a sensor has to explain, to be worth it
_SIGMA = 4.0
_FEWEST = 10
_MOST, _CELLS = 20_000, 8_000_000
"""Touches that are looked at, at most, and numbers in a matrix over all of them."""

_RATIOS = np.array([0.1, 0.15, 0.2, 0.3, 0.4, 0.5, 0.65, 0.8, 1.25, 1.6])
"""Of one gain alone, tried with the others as they were."""
_SCANNED, _CAPPED = 1000, 50.0
"""Touches of the trial, and the chi-square that a touch counts for at most: a wild reading says nothing of a gain."""

_MUCH_AS_IT_WAS = 0.25
_WEAK, _GONE, _TOLD, _BLIND = 0.9, 0.02, 0.2, 0.25


@dataclass(frozen=True, eq=False, repr=False)
class SensorHealth(Tabled, Frozen):
    """What `sensor_health` found.

    Parameters
    ----------
    finger : Finger
        The finger with the gains, and offsets, that it seems to have now; dead sensors have gain 0.
    gain_ratio, std : ndarray, shape (n,)
        Each sensor's gain now, relative to what it was, and its standard error; infinite where the touches do not
        determine it. Of those that have changed, with the others as they were. A change of all gains alike looks like
        another force of the touches: the median sensor has 1.
    shift : ndarray, shape (n,)
        By how much the offset of a sensor seems to have changed [reading]; 0 but for those left out at first.
    explained, explained_now : float
        Share of the touches that a load explains, with the finger as it was and as it is now.
    touches : int
        Number of frames that are no free skin; of more than 20 000, as many are looked at.
    health : tuple of Health
        OK; WEAK: its gain has fallen by a tenth or more, or is below half of the median; DEAD: its gain is 0 within its
        error, or it gave no readings.
    """

    finger: Finger
    gain_ratio: FloatArray
    std: FloatArray
    shift: FloatArray
    explained: float
    explained_now: float
    touches: int
    health: tuple[Health, ...]

    def _title(self) -> str:
        now, then = (f"{100 * share:.3g} %" for share in (self.explained_now, self.explained))
        return f"SensorHealth from {self.touches} touches: {now} explained ({then} by the finger as it was)"

    _HEADS = ("sensor", "state", "gain over what it was")

    def _shown(self) -> list[tuple[str, str, str]]:
        each = zip(self.health, self.gain_ratio, self.std, strict=True)
        return [(str(i), state.name, with_error(ratio, std, "")) for i, (state, ratio, std) in enumerate(each)]

    @property
    def changed(self) -> npt.NDArray[np.bool_]:
        """Whose gain has changed by more than 4 standard errors, either way, shape (n,)."""
        return _changed(self.gain_ratio, self.std)


def sensor_health(
    finger: Finger, readings: npt.ArrayLike, *, friction: float = 1.0, search: tuple[float, float] | None = None
) -> SensorHealth:
    """Find sensors that have died, weakened or strengthened, from frames of ordinary use.

    Positions and forces of the touches need not be known, but they have to be many, all over the row. Where loads
    explain too few of them, sensors are left out, first the one without which most are explained. Then gains are fitted
    to the touches that are explained, by Gauss-Newton: a sensor's residual against its reading, both without what a
    change of the touch would do to all sensors, so that a weak one does not spoil the others' gains. Those that have
    not changed by more than 4 standard errors are then held, and the others fitted again.

    That descent can end where touches have moved to take up the change. So one gain alone is tried over its whole range
    too, for each sensor; where it explains as much as the changes of several, it is what is believed.

    Standard errors are those of independent noise. Where the model does not quite fit, as on most real skins, they are
    too small. Where a touch moves only two or three sensors, its position takes up a change of gain. So believe a
    change if it explains touches that were unexplained before (`explained`, `explained_now`).

    Parameters
    ----------
    finger : Finger
        As it was calibrated.
    readings : array_like, shape (m, n)
        Frames in units of each gain, their drift taken off (`Tare`); NaN is a missing reading. Frames of free skin do
        no harm.
    friction, search
        As in `Finger.locate`.

    Returns
    -------
    SensorHealth

    Raises
    ------
    GeometryError, InvalidValueError
        Shapes that do not match, a sensor without noise.
    ConvergenceError
        Fewer than 10 touches that some load explains, whichever sensors are left out; fewer than four sensors, or
        three where friction is 0.

    Examples
    --------
    >>> import numpy as np, subskin as ss
    >>> skin = ss.HalfPlane(ss.Material(young=0.4e6))
    >>> row = {"pitch": 1.5e-3, "depth": 2e-3, "noise": 1e-4}
    >>> then = ss.Finger(skin, ss.SensorArray.line(6, **row))
    >>> now = ss.Finger(skin, ss.SensorArray.line(6, gain=[1, 1, 0.6, 1, 1, 1], **row))
    >>> rng = np.random.default_rng(0)
    >>> touches = ss.LineLoad(40.0, rng.uniform(-0.5, 0.5, 500), rng.uniform(-4e-3, 4e-3, 500))
    >>> found = sensor_health(then, now.read(touches, rng))
    >>> found.gain_ratio.round(2).tolist(), found.health[2].name
    ([1.0, 1.0, 0.6, 1.0, 1.0, 1.0], 'WEAK')
    """
    finger_needed(finger)
    data = checked_readings(readings, len(finger.array))
    needed, live = 3 if _check.friction(friction) == 0 else 4, int(finger.array.live.sum())
    if live < needed:
        fix = "a finger with more sensors, or calibrate again at known positions"
        raise ConvergenceError(f"{live} live sensors", f"at least {needed} are needed: one more than unknowns", fix)
    return _Check(finger, data, {"friction": friction, "search": search}).result()


class _Check:
    """Ratios of the gains, shifts of the offsets and sensors left out, as they are found."""

    def __init__(self, finger: Finger, data: FloatArray, options: dict[str, Any]) -> None:
        self.was, self.options = finger, options
        self.field = tabulate(finger, options["search"])
        self.unknowns = 2 if options["friction"] == 0 else 3
        n = len(finger.array)
        self.live = finger.array.live & np.isfinite(data).any(axis=0)
        self.ratio, self.shift, self.out = np.ones(n), np.zeros(n), ~self.live
        found = self.locator()(data)
        if finger.skin.takes_local:  # lines, or points on the row: what leaves less
            lines, self.field = self.field, points_on(finger, (self.field.start, self.field.stop))
            points = self.locator()(data)
            if np.median(np.nan_to_num(points.residual, nan=np.inf)) < np.median(
                np.nan_to_num(found.residual, nan=np.inf)
            ):
                found = points
            else:
                self.field = lines
        status = found.status
        touched = data[np.isin(status, (*_EXPLAINED, Status.UNEXPLAINED))]
        # spread evenly, no more than is worth the time and the memory
        self.touches = len(touched)
        most = max(min(_MOST, _CELLS // n**2), _FEWEST)
        self.data = touched[:: max(-(-len(touched) // most), 1)]
        if self.touches < _FEWEST:
            seen = f"{self.touches} touches in {len(data)} frames"
            raise ConvergenceError(seen, f"at least {_FEWEST} are needed", "more frames")
        self.explained = self.share()

    def finger(self) -> Finger:
        """As it seems to be now; sensors left out have gain 0."""
        array = self.was.array
        gain = np.where(self.out, 0.0, np.asarray(array.gain) * self.ratio)
        offset, lift = np.asarray(array.offset) + self.shift, np.asarray(array.lift) * self.ratio
        return replace(self.was, array=replace(array, gain=gain, offset=offset, lift=lift))

    def locator(self, inflated: float = 1.0) -> Locator:
        array = self.finger().array
        table = replace(self.field, coefficients=self.field.coefficients * self.ratio[:, None])
        wide = replace(array, noise=inflated * np.asarray(array.noise))
        return Locator(table, wide, friction=self.options["friction"])

    def share(self) -> float:
        """Of the touches that a load explains now."""
        return float(np.isin(self.locator()(self.data).status, _EXPLAINED).mean())

    def leave_out(self) -> None:
        """Sensors, the one that helps most first, until the touches are explained or no more can go."""
        here = self.explained
        while here < _ENOUGH and (~self.out).sum() > self.unknowns + 1:
            trials = []
            for i in np.flatnonzero(~self.out):
                self.out[i] = True
                trials.append((self.share(), i))
                self.out[i] = False
            best, i = max(trials)
            if best < here + _BETTER:
                break
            self.out[i], here = True, best

    def fit(self, varied: npt.NDArray[np.bool_], shifted: npt.NDArray[np.bool_]) -> FloatArray:
        """Change the gains `varied` and the offsets `shifted` until they settle; standard errors of these gains."""
        noise, count = np.asarray(self.was.array.noise), int(varied.sum())
        scaled = self.live & ~self.out
        common = np.concatenate([scaled[varied], np.zeros(int(shifted.sum()))])
        loose = bool(varied[scaled].all())
        std = np.zeros(count)
        for _ in range(_ROUNDS):
            matrix, right, excess = self.normal(varied, shifted)
            # next to nothing is known of the gains beforehand: it keeps those in place of which the touches say less
            before = np.zeros(len(right))
            before[:count] = 1.0
            matrix += np.diag(before)
            right[:count] -= self.ratio[varied] - 1
            if loose:
                # the scale that all have in common is nobody's: held here, and then put where the median sensor has it
                matrix += np.trace(matrix) / common.sum() * np.outer(common, common)
            inverse = _inverse(matrix)
            step = inverse @ right
            self.ratio[varied] += step[:count]
            self.shift[shifted] += step[count:] * noise[shifted]
            if loose:
                middle = float(np.median(self.ratio[scaled]))
                if not middle > 0:
                    rule = "most sensors have to be as they were"
                    raise ConvergenceError("gains that do not settle", rule, "calibrate again at known positions")
                self.ratio /= middle
            known = np.diag(inverse)[:count]
            std = np.where(known < _BLIND, np.sqrt(known * excess), np.inf)
            if not count or np.abs(step[:count]).max() < _SETTLED:
                break
        return std

    def normal(
        self, varied: npt.NDArray[np.bool_], shifted: npt.NDArray[np.bool_]
    ) -> tuple[FloatArray, FloatArray, float]:
        """Normal equations of the ratios' changes, then of the shifts in units of the noise; how much is left.

        The rows of each touch are projected across the touch's own unknowns.
        """
        # gains that are still wrong explain little: noise is taken to be larger until most touches are explained
        for inflated in _INFLATED:
            locator = self.locator(inflated)
            found = locator(self.data)
            if np.isin(found.status, _EXPLAINED).mean() >= _MOSTLY:
                break
        good = found.status == Status.OK
        if good.sum() < _FEWEST:
            few = f"{good.sum()} touches that one load explains"
            raise ConvergenceError(few, f"at least {_FEWEST} are needed", "more frames, with their drift off")
        array, n = self.finger().array, self.ratio.size
        raw = self.data[good]
        seen = array.inside(raw) & self.live
        if not locator._linear:
            raw = locator._linearised(raw)
            seen &= np.isfinite(raw)
        noise = np.where(self.live, array.noise, 1.0)
        load = found.components[good]
        value = self.field(found.position[good])
        slope = self.field(found.position[good], derivative=1)
        unit = np.einsum("mnl,ml->mn", value, load) / noise
        unknowns = [np.einsum("mnl,ml->mn", slope, load), *(value[..., k] for k in range(self.unknowns - 1))]
        touch = np.stack(unknowns, axis=-1) * (seen * self.ratio / noise)[..., None]
        touch /= np.maximum(np.linalg.norm(touch, axis=1, keepdims=True), 1e-300)
        basis = np.linalg.qr(touch)[0]
        across = np.eye(n) - basis @ np.swapaxes(basis, 1, 2)
        rest = np.where(seen, (raw - np.asarray(array.offset)) / noise - self.ratio * unit, 0.0)
        jacobian = np.concatenate(
            [(across * (seen * unit)[:, None, :])[..., varied], (across * seen[:, None, :])[..., shifted]], axis=-1
        )
        # touches that fit badly for other reasons count for less
        degrees = np.maximum(seen.sum(axis=1) - self.unknowns, 1)
        misfit = found.residual[good] * inflated**2
        trust = np.sqrt(np.minimum(1.0, 5 * degrees / np.maximum(misfit, 1e-300)))
        rows = (jacobian * trust[:, None, None]).reshape(-1, jacobian.shape[-1])
        left = (np.einsum("mij,mj->mi", across, rest) * trust[:, None]).reshape(-1)
        return rows.T @ rows, rows.T @ left, max(float((left**2).sum() / degrees.sum()), 1.0)

    def alone(self, changed: int, std: FloatArray) -> bool:
        """Take the change of one gain alone if it explains as much as those of the `changed`; whether it does.

        `std` becomes the standard errors. The offset stays, or changes with the gain: of presses cut out of a recording
        it is but a part of the fit, and the reading of a weak sensor is less as a whole.
        """
        if self.out.any() and not (self.out == ~self.live).all():
            return False
        data = self.data[:: max(-(-len(self.data) // _SCANNED), 1)]
        kept, here = (self.ratio, self.shift), self._left(data)
        offset, unmoved, ones = np.asarray(self.was.array.offset), np.zeros_like(self.shift), np.ones_like(self.ratio)
        best, state = np.inf, kept
        for i in np.flatnonzero(self.live):
            for along in (False, True) if offset[i] else (False,):
                grid = _RATIOS
                for _ in range(2):  # finer about the best
                    left = []
                    for r in grid:
                        self.ratio, self.shift = ones.copy(), unmoved.copy()
                        self.ratio[i], self.shift[i] = r, along * (r - 1) * offset[i]
                        left.append(self._left(data))
                        if left[-1] < best:
                            best, state = left[-1], (self.ratio, self.shift)
                    k = int(np.argmin(left))
                    grid = np.linspace(grid[max(k - 1, 0)], grid[min(k + 1, grid.size - 1)], 9)
        degrees = max(float((np.isfinite(data) & self.live).sum()) - len(data) * self.unknowns, 1.0)
        # no more may be left than now; where but one has changed anyway, clearly less
        enough = here - (_SIGMA**2 * max(best / degrees, 1.0) if changed < 2 else 0.0)
        self.ratio, self.shift = state if best <= enough else kept
        if best > enough:
            return False
        one = self.ratio != 1.0
        matrix, _, excess = self.normal(one, np.zeros_like(one))
        std[:] = np.where(self.live, 0.0, np.inf)
        std[one] = np.sqrt(excess / np.maximum(np.diag(matrix), 1e-300))
        return True

    def _left(self, data: FloatArray) -> float:
        """Chi-square that the best loads leave of `data`, with the gains and offsets as they are taken to be."""
        left = self.locator()(data).residual
        return float(np.minimum(np.where(np.isfinite(left), left, _CAPPED), _CAPPED).sum())

    def result(self) -> SensorHealth:
        self.leave_out()
        suspects = self.out & self.live
        std = np.full(self.ratio.size, np.inf)
        std[self.live] = self.fit(self.live, suspects)
        told = self.ratio > np.maximum(_SIGMA * std, _GONE)
        for i in np.flatnonzero(suspects & told):
            before = self.share()
            self.out[i] = False
            if abs(self.ratio[i] - 1) < _MUCH_AS_IT_WAS:  # it works: what does not fit is the model
                continue
            if self.share() < before - _BETTER:  # what it reads has little to do with the touches
                self.out[i] = True
        if (suspects & ~self.out).any():
            std[self.live] = self.fit(self.live, suspects)
        ratio = np.where(self.live, self.ratio, np.nan)
        # what has not changed for certain is as it was calibrated, which tells more of what has
        varied = self.live
        while (changed := varied & (suspects | _changed(ratio, std))).sum() < varied.sum():
            varied = changed
            self.ratio = np.where(varied, self.ratio, 1.0)
            if varied.any():
                std[varied] = self.fit(varied, suspects)
            ratio[varied] = self.ratio[varied]
        if self.alone(int(_changed(ratio, std).sum()), std):
            ratio = np.where(self.live, self.ratio, np.nan)
        self.out |= (std < _TOLD) & ~(self.ratio > np.maximum(_SIGMA * std, _GONE))
        self.shift[self.out] = 0.0
        feeble = np.zeros(ratio.size, dtype=bool)
        feeble[self.live] = weak(
            (self.ratio * np.asarray(self.was.array.gain))[self.live], self.was.array.select(self.live).transducers
        )
        feeble = (_changed(ratio, std) & (ratio < _WEAK)) | feeble
        health = np.where(self.out, Health.DEAD, np.where(feeble, Health.WEAK, Health.OK))
        ratio, std, shift = (_check.read_only(values) for values in (ratio, std, self.shift))
        said = tuple(Health(int(h)) for h in health)
        return SensorHealth(self.finger(), ratio, std, shift, self.explained, self.share(), self.touches, said)


def _changed(ratio: FloatArray, std: FloatArray) -> npt.NDArray[np.bool_]:
    with np.errstate(invalid="ignore"):
        return np.asarray(np.abs(ratio - 1) > _SIGMA * std)


def _inverse(matrix: FloatArray) -> FloatArray:
    """Of a matrix that may be singular in the shifts, whose size is another than the gains'."""
    size = np.sqrt(np.diag(matrix))
    size[size == 0] = 1.0
    return np.asarray(np.linalg.pinv(matrix / np.outer(size, size), rcond=1e-13, hermitian=True) / np.outer(size, size))
