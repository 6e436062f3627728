"""Readings -> where, how hard, at what angle: any number of sensors, any receptive field."""

from __future__ import annotations

import logging
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from .. import _check
from .._check import FloatArray
from ..array import SensorArray
from ..errors import GeometryError, InvalidValueError
from ..receptive_field import ReceptiveField
from .estimate import STATUS, WIDTH, Estimate, Status

__all__ = ["Locator"]

_MOST_PATTERNS = 64
_log = logging.getLogger("subskin")


def _kernel() -> Any:
    """The compiled loop, imported on first use; says so when it has to be compiled."""
    from . import _kernel as module

    compiled = module.locate_frames
    cached = Path(str(compiled.stats.cache_path)).glob("_kernel.locate_frames-*.nbi")
    if not compiled.signatures and not any(cached):
        _log.warning("subskin: compiling the locator, once after installation; this takes some seconds")
    return compiled


class Locator:
    """Finds the load in frames of readings; prepared once, then called on a frame or on millions.

    Variable projection: readings are linear in the normal and tangential force, which are eliminated exactly at each
    trial position, within compression and the friction cone; what remains is a search over position (memo section 3;
    docs/locating.md). The two best minima of chi-square are refined; the second is the rival.

    Parameters
    ----------
    field : ReceptiveField
        Readings under unit loads, from a closed form or a table; its ends bound the search.
    array : SensorArray
        Offset, noise and range of each sensor (its gain is in the receptive field; gain 0 marks a dead sensor).
    friction : float, optional
        Coefficient of friction mu: loads lean at most by atan(mu). 0: loads are normal, and the angle is not fitted.
        `inf`: any pressing load.
    scan_step : float, optional
        Step of the search [m]; the default is a thirty-second of the shallowest sensor's depth.
    false_alarm : float, optional
        Probability with which an untouched skin, or a load that the model explains, is called a contact, or
        unexplained.
    ambiguity : float, optional
        A rival whose chi-square is within this of the best one makes a frame AMBIGUOUS.

    Raises
    ------
    InvalidValueError, GeometryError
        A sensor without noise, a table whose sensors do not match the array's, an option out of range.

    Examples
    --------
    >>> import numpy as np, subskin as ss
    >>> skin = ss.HalfPlane(ss.Material(young=0.4e6))
    >>> finger = ss.Finger(skin, ss.SensorArray.line(count=6, pitch=1.5e-3, depth=2e-3, noise=1e-5))
    >>> locator = finger.locator(friction=1.0)
    >>> found = locator(finger.read(ss.LineLoad(force=40.0, angle=0.3, position=0.8e-3)))
    >>> round(float(found.position) * 1e3, 4), round(float(found.force), 2), round(float(found.angle), 4)
    (0.8, 40.0, 0.3)
    """

    def __init__(
        self,
        field: ReceptiveField,
        array: SensorArray,
        *,
        friction: float = 1.0,
        scan_step: float | None = None,
        false_alarm: float = 1e-6,
        ambiguity: float = 13.8,
    ) -> None:
        if field.coefficients.shape[2] != len(array):
            raise GeometryError(
                f"a receptive field of {field.coefficients.shape[2]} sensors, an array of {len(array)}",
                "they have to match",
            )
        noise = np.asarray(array.noise)
        silent = np.flatnonzero((noise == 0) & array.live)
        if silent.size:
            raise InvalidValueError(
                f"noise = 0 of sensor {silent[0]}",
                "estimates weigh sensors by their noise, so each needs one > 0",
                "SensorArray(..., noise=1e-4), or calibrate, which measures it",
            )
        self.field, self.array = field, array
        mu = _check.real("friction", friction, at_least=0.0, finite=False)
        self.friction = float(mu)
        if np.isnan(self.friction):
            raise InvalidValueError("friction = nan", "a coefficient of friction >= 0 is needed")
        shallowest = float(np.asarray(array.depth).min())
        step = (
            shallowest / 32
            if scan_step is None
            else _check.scalar("scan_step", scan_step, unit="m", above=0.0)
        )
        count = max(int(np.ceil((field.stop - field.start) / step - 1e-9)) + 1, 3)
        self._scan = np.linspace(field.start, field.stop, count)
        self._false_alarm = _check.scalar("false_alarm", false_alarm, above=0.0, at_most=0.5)
        self._ambiguity = _check.scalar("ambiguity", ambiguity, at_least=0.0)
        self._shallowest = shallowest
        self._needed = 2 if self.friction == 0 else 3
        self._prepared: dict[bytes, tuple[npt.NDArray[Any], ...]] = {}
        self._all = array.live
        self._all.flags.writeable = False
        self._whole = bool(self._all.all())
        self._whole_key = self._all.tobytes()
        self._sensors = len(array)
        self._compiled: Any = None
        self._linear = all(t.linear for t in array.transducers)

    def __call__(self, readings: npt.ArrayLike) -> Estimate:
        """The load in each frame.

        Parameters
        ----------
        readings : array_like, shape (..., n)
            Raw readings, offset included. NaN marks a missing one; it, and a saturated one, are left out of its frame.

        Returns
        -------
        Estimate
            Fields of shape (...).

        Raises
        ------
        GeometryError
            A last axis that is not the number of sensors.
        """
        raw = np.asarray(readings, dtype=np.float64)
        n = self._sensors
        if raw.ndim == 0 or raw.shape[-1] != n:
            raise GeometryError(f"readings of shape {raw.shape}", f"the last axis has to be the {n} sensors")
        if not self._linear:
            raw = self._linearised(raw)
        frames = np.ascontiguousarray(raw.reshape(-1, n))
        out = np.empty((len(frames), WIDTH))
        if self._whole:
            self._run(frames, self._all, out)
            if raw.ndim == 1 and out[0, STATUS] >= 0:  # the shortest way for a frame by itself
                out.flags.writeable = False
                return Estimate(out[0], self._all)
            pending = out[:, STATUS] < 0
        else:
            pending = np.ones(len(frames), dtype=bool)
        if pending.any():
            used = self.array.usable(frames)
            self._run_patterns(frames, used, pending, out)
            used.flags.writeable = False
        else:
            used = np.broadcast_to(self._all, frames.shape)
        out.flags.writeable = False
        return Estimate(out.reshape((*raw.shape[:-1], WIDTH)), used.reshape(raw.shape))

    def _linearised(self, raw: FloatArray) -> FloatArray:
        """Readings as if each transducer were its linear part; those outside the range stay outside."""
        linear = np.array(raw)
        gain, offset = np.asarray(self.array.gain), np.asarray(self.array.offset)
        for i, kind in enumerate(self.array.transducers):
            if not kind.linear and gain[i] != 0:
                inside = self.array.usable(raw)[..., i]
                value = gain[i] * kind.linearise((raw[..., i] - offset[i]) / gain[i]) + offset[i]
                linear[..., i] = np.where(inside, value, np.nan)
        return linear

    def _run_patterns(
        self, frames: FloatArray, used: npt.NDArray[np.bool_], pending: npt.NDArray[np.bool_], out: FloatArray
    ) -> None:
        """Frames in which a sensor is out, grouped by the sensors that are left."""
        index = np.flatnonzero(pending)
        patterns, group = np.unique(used[index], axis=0, return_inverse=True)
        for g, pattern in enumerate(patterns):
            rows = index[group.reshape(-1) == g]
            if pattern.sum() < self._needed:
                out[rows] = np.nan
                out[rows, WIDTH - 2] = np.inf
                out[rows, STATUS] = Status.INCOMPLETE
                continue
            part = np.empty((len(rows), WIDTH))
            self._run(np.ascontiguousarray(frames[rows][:, pattern]), pattern, part)
            out[rows] = part

    def _run(self, frames: FloatArray, pattern: npt.NDArray[np.bool_], out: FloatArray) -> None:
        key = self._whole_key if pattern is self._all else pattern.tobytes()
        arrays = self._prepared.get(key)
        if arrays is None:
            if len(self._prepared) >= _MOST_PATTERNS:
                self._prepared.pop(next(iter(self._prepared)))
            arrays = self._prepared[key] = self._prepare(pattern)
        if self._compiled is None:
            self._compiled = _kernel()
        self._compiled(frames, *arrays, out)

    def _prepare(self, pattern: npt.NDArray[np.bool_]) -> tuple[npt.NDArray[Any], ...]:
        """Arguments of the compiled loop between the frames and the output, for the sensors of `pattern`."""
        from scipy.special import chdtri

        array, field = self.array.select(pattern), self.field.select(pattern)
        n = len(array)
        scale = 1 / np.asarray(array.noise)
        table = np.ascontiguousarray(np.swapaxes(field.coefficients * scale[:, None], 2, 3))
        basis, edges = _scan_geometry(field(self._scan) * scale[:, None], self.friction)
        degrees = max(n - self._needed, 1)
        options = np.array(
            [
                *(field.start, field.step, self._scan[0], self._scan[1] - self._scan[0], self.friction),
                2 * np.log(1 / self._false_alarm),  # less than this explained: no contact
                float(chdtri(degrees, self._false_alarm)),  # more than this left: unexplained
                self._ambiguity,
                0.02 * self._shallowest,  # two minima nearer than this are one load
                0.1 * self._shallowest,  # a profile wider than this may be ambiguous
            ]
        )
        # a sensor with an infinite range is compared with the largest float: NaN and infinity then fall outside
        big = np.finfo(np.float64).max
        low, high = np.maximum(np.asarray(array.low), -big), np.minimum(np.asarray(array.high), big)
        sensors = np.stack([np.asarray(array.offset), scale, low, high])
        return sensors, basis, edges, table, options


def _scan_geometry(
    fields: FloatArray, friction: float
) -> tuple[npt.NDArray[np.float32], npt.NDArray[np.float32]]:
    """Orthonormal columns of A at each position, shape (n, 2, m), and the cone's unit edges in them, shape (4, m)."""
    normal, tangential = fields[..., 0], fields[..., 1]
    size = np.linalg.norm(normal, axis=1, keepdims=True)
    q1 = normal / np.where(size > 0, size, 1)
    along = np.sum(q1 * tangential, axis=1, keepdims=True)
    rest = tangential - along * q1
    across = np.linalg.norm(rest, axis=1, keepdims=True)
    q2 = rest / np.where(across > 0, across, 1)
    edges = []
    for sign in (-1.0, 1.0):
        n, t = (1.0, sign * friction) if np.isfinite(friction) else (0.0, sign)
        edge = np.stack([n * size[:, 0] + t * along[:, 0], t * across[:, 0]])
        length = np.hypot(*edge)
        edges.append(edge / np.where(length > 0, length, 1))
    basis = np.stack([q1.T, q2.T], axis=1)
    return basis.astype(np.float32, order="C"), np.concatenate(edges).astype(np.float32, order="C")
