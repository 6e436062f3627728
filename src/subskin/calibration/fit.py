"""The least-squares problem of a calibration on touches at known positions."""

from __future__ import annotations

from dataclasses import replace
from functools import cached_property
from itertools import groupby
from typing import Any, TypeAlias

import numpy as np
import numpy.typing as npt

from .. import _check
from .._check import FloatArray
from .._frozen import Frozen
from ..errors import ConvergenceError, GeometryError
from ..finger import Finger
from ._forward import LINEAR, Forward
from .alike import AlikeGains
from .calibration import Calibration, Health, Parameter, score, tells_order, weak
from .uncertainty import Misfit, Uncertainty, misfit_of, neighbours, stretched

__all__ = ["Fit"]

_ORDER = (1, 2, 0)
"""In which `LINEAR` is made orthogonal: what is the same everywhere first, for gains stand for what changes."""
_Shares: TypeAlias = dict[tuple[int, int], FloatArray]
_ROUNDS = 4  # of re-weighting sensors by their residuals
_DEAD_SIGMA = 4.0
_ENOUGH, _LOST, _ALONE, _RARE, _FITS = 12, 0.1, 3.0, 32, 0.95
"""A reading is lost, of so many touches at least, that is off by this share of the sensor's range and so many times as
far as the others; of every 32 touches one may have lost a reading too. The model fits the others by this R^2: one that
does not fit is not mended by leaving out what it fits worst."""
_MOVES = 10.0
"""Noises from lowest to highest reading (noise alone: 8 in ten thousand touches) beyond which a sensor works."""
_HEIGHTS = (1.3, 2.0, 5.0, 20.0)
"""Thicknesses tried, in depths: a base near the sensors and one far below may both be local minima."""


class Fit(Frozen):
    """One weighted least-squares problem, for the sensors that are thought alive."""

    def __init__(
        self,
        finger: Finger,
        names: tuple[str, ...],
        data: FloatArray,
        positions: FloatArray,
        load: FloatArray,
        live: npt.NDArray[np.bool_],
        origin: Any,
        turn: float = 0.0,
        *,
        scan: bool,
        gain_error: float = np.inf,
        left_out: tuple[tuple[int, int], ...] = (),
        points: bool = False,
    ) -> None:
        self.finger, self.names, self.positions, self.load = finger, names, positions, load
        self.live, self.scan, self.origin, self.turn, self.gain_error = live, scan, origin, turn, gain_error
        self.given, self.data = data, data[:, live]
        self.seen = np.isfinite(self.data)
        self.forward = Forward(self._part(), names, turn, points=points)
        self.unknowns = self.forward.size + sum(name in names for name in LINEAR) * int(live.sum())
        self.spare = int(self.seen.sum()) - self.unknowns
        if self.spare < live.sum():
            seen = f"{self.seen.sum()} readings for {self.unknowns} parameters"
            rule = "more readings than parameters are needed, by one a sensor at least: they alone show the misfit"
            raise ConvergenceError(seen, rule, "calibrate on more touches or fit fewer parameters")
        self.stated = np.asarray(self.forward.finger.array.noise)
        self.noise, self.left_out = np.ones(int(live.sum())), left_out
        self.alike = AlikeGains(self.forward.finger.array, gain_error if "gain" in names else np.inf)
        """Of no gain until the noise is known, to which what is known of gains is held."""

    @property
    def anew(self) -> bool:
        """Whether the finger itself is fitted; otherwise it is one that was known and has been moved, say."""
        return "gain" in self.names and self.forward.depth is not None

    @property
    def in_place(self) -> bool:
        """Whether only where the finger lies is fitted, of a finger whose response is known: that goes by it."""
        return self.finger.measured is not None and set(self.names) <= {"origin", "turn"}

    def _part(self) -> Finger:
        """The finger of the live sensors."""
        array, known = self.finger.array.select(self.live), self.finger.measured
        if known is None or not self.in_place:
            return replace(self.finger, array=array, measured=None)
        if known.components == 1 and self.load[:, 1:].any():
            rule = "the finger's response in place is that of normal forces"
            raise GeometryError("touches that drag", rule, "angle=0, or dataclasses.replace(finger, measured=None)")
        known = known.select(self.live)
        return replace(self.finger, array=replace(array, offset=known.offset, lift=0.0), measured=known)

    def unit_readings(self, p: FloatArray, positions: FloatArray, load: FloatArray) -> FloatArray:
        """What unit gains would read of touches at `positions` (m,) on the motor's axis, with `load` (m, 2)."""
        return self.forward.unit(p, *self.forward.moved(p, self.origin, positions, load))

    def linear(self, unit: FloatArray) -> FloatArray:
        """Gains, offsets and lifts that fit best to what unit gains would read, (3, n): by Gram and Schmidt.

        Gains are those that are likeliest, with what is known of them beforehand.
        """
        fitted, found, shares, information = self._eliminated(unit)
        if "gain" in self.names:
            found[0] = self.alike.settled(found[0], information)
        for k, i in reversed([*enumerate(fitted)]):
            for j in fitted[k + 1 :]:
                found[i] -= shares[i, j] * found[j]
        return found

    def _eliminated(self, unit: FloatArray) -> tuple[list[int], FloatArray, _Shares, FloatArray]:
        """What is fitted of `LINEAR`, in turn; each by itself (3, n); its shares of the next; the last's information.

        The last is the gain, where it is fitted: it is what the touches alone say.
        """
        array = self.forward.finger.array
        found = np.stack([np.asarray(getattr(array, name)) for name in LINEAR])
        columns = np.where(self.seen, self._columns(unit), 0.0)
        rest = np.where(self.seen, self.data, 0.0)
        fitted = [i for i in _ORDER if LINEAR[i] in self.names]
        for i in {*_ORDER} - {*fitted}:
            rest = rest - found[i] * columns[i]
        shares = {}
        for k, i in enumerate(fitted):
            square = _divisor((columns[i] ** 2).sum(axis=0))
            found[i] = (columns[i] * rest).sum(axis=0) / square
            rest = rest - found[i] * columns[i]
            for j in fitted[k + 1 :]:
                shares[i, j] = (columns[i] * columns[j]).sum(axis=0) / square
                columns[j] -= shares[i, j] * columns[i]
        information = (columns[fitted[-1]] ** 2).sum(axis=0) / self.noise**2 if fitted else np.zeros(0)
        return fitted, found, shares, information

    def _columns(self, unit: FloatArray) -> FloatArray:
        """What gains, offsets and lifts are multiplied by, (3, m, n)."""
        return np.stack(np.broadcast_arrays(unit, 1.0, self.load[:, :1]))

    def model(self, unit: FloatArray, linear: FloatArray) -> FloatArray:
        """Readings (m, n) by these linear numbers, where unit gains would read `unit`."""
        return np.asarray((linear[:, None] * self._columns(unit)).sum(axis=0))

    @property
    def rest(self) -> FloatArray:
        """What the solution leaves of the readings, (m, n)."""
        return self.data - self.modelled

    def residual(self, p: FloatArray, unit: FloatArray | None = None) -> FloatArray:
        """What parameters p leave of the readings that there are, in noises; then of gains that are alike."""
        unit = self.unit_readings(p, self.positions, self.load) if unit is None else unit
        linear = self.linear(unit)
        rest = ((self.data - self.model(unit, linear)) / self.noise)[self.seen]
        return np.concatenate([rest, self.alike.rest(linear[0])])

    def without(self, rows: npt.NDArray[np.intp]) -> Fit:
        """The same, fitted to the other touches, from where this one came to lie."""
        kept = np.setdiff1d(np.arange(len(self.given)), rows)
        parts = (self.given[kept], self.positions[kept], self.load[kept])
        whole = (self.live, self.origin, self.turn)
        more: dict[str, Any] = {"gain_error": self.gain_error, "points": self.forward.points}
        part = Fit(self.finger, self.names, *parts, *whole, scan=False, **more)
        part.noise, part.alike = self.noise, self.alike
        return part.solve(self.p)

    def solve(self, near: FloatArray | None = None) -> Fit:
        """Settle parameters and noise; `near` a solution of nearly the same touches, where one is known."""
        starts = self._starts() if near is None else [near]
        p = starts[0]
        if len(starts) > 1:
            p = min((self._least(start, 1e-5) for start in starts), key=lambda found: float(found.cost)).x
        for _ in range(_ROUNDS if near is None else 1):
            if p.size:
                found = self._least(p, 1e-12 if near is None else 1e-6)
                if not found.success:
                    raise ConvergenceError("the fit did not settle", found.message, "fit fewer parameters")
                p = found.x
            unit = self.unit_readings(p, self.positions, self.load)
            linear = self.linear(unit)
            self.gain, self.offset, self.lift = linear
            self.modelled = self.model(unit, linear)
            rest = np.where(self.seen, self.rest, 0.0)
            degrees = np.maximum(self.seen.sum(axis=0) - self.unknowns / self.noise.size, 1.0)
            noise = np.sqrt((rest**2).sum(axis=0) / degrees)
            # touches that happen to fit tell less of the noise than the finger as it was
            noise = self.forward.pooled(np.maximum(noise, self.stated), self.gain)
            # a floor keeps one sensor that happens to fit exactly from taking all the weight
            self.noise = np.maximum(
                noise, max(1e-2 * float(np.median(noise)), 1e-12 * float(np.abs(self.data[self.seen]).max()))
            )
            if "gain" in self.names and near is None:
                _, found, _, information = self._eliminated(unit)
                self.alike = self.alike.judged(found[0], information)
        self.p, self.unit = p, unit
        return self

    def _least(self, p: FloatArray, tolerance: float) -> Any:
        from scipy.optimize import least_squares

        lower, upper = self.forward.bounds()
        options: dict[str, Any] = dict.fromkeys(("xtol", "ftol", "gtol"), tolerance)
        options |= {"bounds": (lower, upper), "x_scale": self.forward.scale(), "method": "trf", "max_nfev": 400}
        return least_squares(self.residual, np.clip(p, lower, upper), **options)

    def _starts(self) -> list[FloatArray]:
        """The best of a scan over origin (where it is fitted and not given), turn and depth; one for each thickness."""
        tried: list[tuple[Any, float]] = [(self.origin, self.turn)]
        if "origin" in self.names and self.scan:
            tried = self.forward.starts(self.data, self.positions, self.origin)
        depths = (0.6, 1.0, 1.6) if self.forward.depth else (1.0,)
        best = []
        for height in _HEIGHTS if "thickness" in self.names else (1.0,):
            starts: list[FloatArray] = []
            costs: list[float] = []
            for depth in depths:
                begin = self.forward.start(self.origin, depth, height)
                starts += [self.forward.placed(begin, *each) for each in tried]
                for turn, alike in groupby(tried, key=lambda each: each[1]):
                    still = self.forward.placed(begin, self.origin, turn)
                    costs += self._costs(still, [origin for origin, _ in alike])
            best.append(starts[int(np.argmin(np.nan_to_num(costs, nan=np.inf)))])
        return best

    def _costs(self, p: FloatArray, origins: list[float]) -> list[float]:
        """What each origin leaves, squared and summed."""
        units = self.forward.from_origins(p, origins, self.positions, self.load)
        return [float((self.residual(p, unit) ** 2).sum()) for unit in units]

    def jacobian(self, positions: FloatArray, load: FloatArray) -> FloatArray:
        """Change of readings with all parameters, in noises, (m, n, p): forward model, gains, offsets, lifts."""
        touches = (positions, load)
        return self.forward.jacobian(self.p, self.origin, touches, self.gain, self.names) / self.noise[:, None]

    @cached_property
    def uncertainty(self) -> Uncertainty:
        """How far all of it is off."""
        return Uncertainty(self)

    def _reported_covariance(self) -> FloatArray:
        """The covariance of what is reported: infinite variances stay, and reach what rests on them."""
        own = self.forward.expansion(self.p)
        covariance = self.uncertainty.covariance
        more = len(covariance) - self.forward.size
        turn = np.zeros((len(own) + more, len(covariance)))
        turn[: len(own), : self.forward.size] = own
        turn[len(own) :, self.forward.size :] = np.eye(more)
        blind = np.isinf(np.diag(covariance))
        out = turn @ np.where(np.isinf(covariance), 0.0, covariance) @ turn.T
        reached = np.flatnonzero((turn[:, blind] != 0).any(axis=1))
        out[reached, reached] = np.inf
        return np.asarray(out)

    def dead(self) -> npt.NDArray[np.bool_]:
        """Which sensors' gains are zero within their errors, while their readings do not move beyond noise.

        Of a kind of which several are alike, one of which the touches say little is no dead one.
        """
        out = np.zeros(self.live.size, dtype=bool)
        if "gain" in self.names:
            std = self._gain_std()
            low = weak(self.gain, self.forward.finger.array.transducers, std) | ~self.alike.known
            out[self.live] = low & (np.abs(self.gain) < _DEAD_SIGMA * std) & ~self._moves()
        return out

    def without_lost(self) -> Fit | None:
        """The fit without its farthest reading, where this is far off what all others say; else None.

        By what the fit without it makes of it. A model that does not quite fit is off too, but not in one reading.
        """
        off = self.off(self.data)
        if len(off) < _ENOUGH or off.max() <= _LOST:
            return None
        touch, i = np.unravel_index(int(np.argmax(off)), off.shape)
        sensor, given = int(np.flatnonzero(self.live)[i]), self.given.copy()
        given[touch, sensor] = np.nan
        part = Fit(
            self.finger, self.names, given, self.positions, self.load, self.live, self.origin, self.turn,
            scan=self.scan, gain_error=self.gain_error, left_out=(*self.left_out, (int(touch), sensor)),
            points=self.forward.points,
        ).solve()  # fmt: skip
        off = part.off(self.data)
        own, off[touch, i] = float(off[touch, i]), 0.0
        others = float(np.sort(off.max(axis=1))[-1 - len(off) // _RARE])
        fits = score(part.data, part.modelled, np.ones(len(part.noise), dtype=bool)).r2 > _FITS
        return part if fits and own > max(_LOST, _ALONE * others) else None

    def off(self, data: FloatArray) -> FloatArray:
        """How far readings `data` (m, n) are off the fit, as a share of what each sensor ranges over."""
        span = np.array([max(float(np.ptp(c[np.isfinite(c)])), 1e-300) for c in data.T])
        return np.asarray(np.nan_to_num(np.abs(data - self.modelled) / span))

    def _gain_std(self) -> FloatArray:
        """Standard errors of the gains; 0 where they are not fitted."""
        if "gain" not in self.names:
            return np.zeros(self.noise.size)
        first = self.forward.size
        return np.asarray(np.sqrt(np.diag(self.uncertainty.covariance))[first : first + self.noise.size])

    def _moves(self) -> npt.NDArray[np.bool_]:
        """Which sensors' readings move by many noises."""
        out = []
        one, next_ = neighbours(self.positions)
        for values, noise in zip(self.data.T, self.stated, strict=True):
            steps = values[next_] - values[one]
            # where no noise is stated, the steps between neighbouring touches are no smaller than it
            least = noise if noise > 0 else np.sqrt(np.nanmean(steps**2) / 2)
            out.append(np.nanmax(values) - np.nanmin(values) > _MOVES * least)
        return np.array(out)

    def _at_end(self) -> set[str]:
        """Names of what is fitted and has come to an end of its range."""
        lower, upper = self.forward.bounds()
        near = 1e-3 * self.forward.scale()
        at_end = (self.p <= lower + near) | (self.p >= upper - near)
        return {name for name, part in self.forward.slices.items() if at_end[part].any()}

    def _misfit(self, rest: FloatArray, r2: float, depth: float, at_end: bool) -> Misfit:
        stated = np.where(self.stated > 0, self.stated, np.nan)
        return misfit_of(
            rest,
            self.gain * self.unit,
            self.positions,
            self.noise,
            share=float(np.sqrt(max(1.0 - r2, 0.0))),
            over_noise=float(np.sqrt(np.sum((rest / stated)[self.seen] ** 2) / self.spare)),
            stretched=stretched("depth", float(np.mean(np.asarray(self.forward.finger.array.depth))), depth, at_end),
            alike=bool((self.load == self.load[0]).all()) and "gain" in self.names,
        )

    def finger_found(self) -> Finger:
        """The finger with the fitted values; gains of dead sensors are 0."""
        index = np.flatnonzero(self.live)
        fitted, whole = self.forward.apply(self.p), self.finger.array
        fields: dict[str, Any] = {
            name: np.array(getattr(whole, name)) for name in ("y", "z", "depth", "width", "noise", *LINEAR)
        }
        for name in ("y", "z", "depth", "width"):
            fields[name][index] = np.asarray(getattr(fitted.array, name))
        fields["gain"][:] = 0.0
        for name in LINEAR:
            fields[name][index] = getattr(self, name)
        fields["noise"][index] = self.noise
        return Finger(fitted.skin, replace(whole, **fields), relative=self.finger.relative)

    def result(self) -> Calibration:
        """What was found, without a spread or a response in place."""
        index = np.flatnonzero(self.live)
        parameters = self.forward.parameters(self.p, index)
        for name in LINEAR:
            if name in self.names:
                values = getattr(self, name)
                parameters += [(name, int(i), float(v), "") for i, v in zip(index, values, strict=True)]
        covariance = self._reported_covariance()
        std = np.sqrt(np.diag(covariance))
        finger = self.finger_found()
        live = finger.array.select(self.live)
        health = [Health.DEAD] * self.live.size
        for i, feeble in zip(index, weak(self.gain, live.transducers, self._gain_std()), strict=True):
            health[i] = Health.WEAK if feeble else Health.OK
        ends = self._at_end()
        data = np.full((len(self.data), self.live.size), np.nan)
        data[:, self.live] = self.data
        model = np.full_like(data, np.nan)
        model[:, self.live] = self.modelled
        fit = score(data, model, self.live)
        depth = float(np.mean(np.asarray(live.depth)))
        drag = self.load[:, 1] if self.load.shape[1] == 2 else np.hypot(self.load[:, 1], self.load[:, 2])
        return Calibration(
            finger=finger,
            origin=self.forward.origin(self.p, self.origin),
            parameters=tuple(
                Parameter(name, sensor, value, float(error), unit, _term(name, sensor) in ends)
                for (name, sensor, value, unit), error in zip(parameters, std, strict=True)
            ),
            covariance=_check.read_only(covariance),
            health=tuple(health),
            score=fit,
            spare=self.spare,
            misfit=self._misfit(self.data - model[:, self.live], fit.r2, depth, bool(ends & {"depth", "depths"})),
            force=_check.read_only(np.hypot(self.load[:, 0], drag)),
            angle=_check.read_only(np.arctan2(drag, self.load[:, 0])),
            turn=self.forward.turn(self.p),
            left_out=self.left_out,
            load="point" if self.forward.dim == 2 or self.forward.points else "line",
            tells_order=tells_order(self.forward.finger.array.points, self.positions, fit.r2),
        )


def _term(name: str, sensor: int | None) -> str:
    """What `fit` calls a reported number."""
    each = {"depth": "depths", "y": "position"}
    return name if sensor is None else each.get(name, name)


def _divisor(square: FloatArray) -> FloatArray:
    return np.where(square > 0, square, 1.0)
