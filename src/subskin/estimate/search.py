"""The estimator of long contacts: prepared once for a response, then called on frames; and what lies beyond its search.

A load two depths beside the row may read like one at its other side, so that `ends.outside` compares both.
docs/locating.md.
"""

from __future__ import annotations

from typing import Any, ClassVar

import numpy as np
import numpy.typing as npt

from .. import _check
from .._check import FloatArray
from ..array import SensorArray
from ..errors import GeometryError, InvalidValueError
from ..response import Response
from .answer import Status
from .estimate import Estimate
from .frames import Framewise, packed, scan_geometry, sensor_rows
from .layout import LINE, SIZED_LINE, WIDE
from .settle.uncertain import Uncertain, fill_settled, in_doubt
from .stretches import Stretches, stretches

__all__ = ["Locator"]

SETTINGS = np.dtype(
    (
        np.record,
        [
            *((name, float) for name in ("start", "step", "widest")),  # of the table
            *((name, float) for name in ("first", "last", "pace")),  # ends of the scan, and its step
            ("positions", int),  # that are scanned
            *(
                (name, float) for name in ("friction", "least", "most", "least_square", "most_square")
            ),  # of loads, of widths
            ("detection", float),  # less than this explained: no contact
            ("nothing", float),  # less than this altogether: nothing
            ("largest", float),  # more than this left: unexplained
            ("fine", float),  # that which the table leaves of a unit force
            ("ambiguity", float),
            ("apart", float),  # two maxima nearer than this are one contact
            ("broad", float),  # a profile wider than this may be ambiguous
            *((name, float) for name in ("far_start", "far_step", "near")),  # of what lies beyond, `Stretches`
        ],
    )
)
"""What a loop goes by besides arrays: a table with one row of these, which it is told quicker than a named tuple."""

_SCAN_WIDTHS = 12
_MOST_SCANNED = 1_000_000
_LIMITS: dict[str, dict[str, Any]] = {
    "half_width": {"unit": "m", "at_least": 0.0},
    "normal_force": {"unit": "N/m", "at_least": 0.0, "finite": False},
}
_WHOLE = 32
"""Positions of the scan are a multiple of these: a loop's remainder goes one by one, and 30 take as long as 200."""

OTHERS = 0.25
"""Steps [least depths] at which another load is looked for where the finger is not known exactly."""


class Locator(Framewise):
    """Finds the contact in frames of readings; prepared once, then called on a frame or on millions.

    Variable projection: readings are linear in the normal and tangential force, which are eliminated exactly at each
    trial position (and half width), within compression and the friction cone; what remains is a search over position,
    and over the square of the half width, on which readings depend smoothly down to no width at all (memo section 3;
    docs/locating.md, docs/fitting.md). It is global: a grid of both, then the best maxima are refined; the second of
    them is the rival.

    Parameters
    ----------
    response : Response
        Readings under unit forces, from a closed form or a table; its ends bound the search.
    array : SensorArray
        Offset, noise and range of each sensor (its gain is in the response; gain 0 marks a dead sensor).
    half_width : (float, float), optional
        Least and largest half width [m] where the response has one; all of the response's if left out.
    normal_force : (float, float), optional
        Least and largest normal force [N/m] that can have pressed; any if left out. An answer at an end of it is
        AMBIGUOUS.
    friction : float, optional
        Coefficient of friction mu: loads lean at most by atan(mu). 0: loads are normal, and the angle is not fitted.
        `inf`: any pressing load.
    scan_step : float, optional
        Step of the search [m]; the default is a thirty-second of the least depth, a sixteenth with widths.
    false_alarm : float, optional
        Probability with which an untouched skin, or a load that the model explains, is called a contact, or
        unexplained.
    ambiguity : float, optional
        A rival whose chi-square is within this of the best one makes a frame AMBIGUOUS.
    outliers : {0, 1}, optional
        With 1, frames that are UNEXPLAINED are tried again without each reading in turn. Where one omission explains
        the frame, `used` shows which. Where another comes within `ambiguity` of its chi-square, the frame is AMBIGUOUS
        and the load of the nearest is the rival. It takes two readings more than unknowns (docs/robust.md).
    uncertain : Uncertain, optional
        What is not known of the finger, and of the width of what presses, for line loads.
    beyond : Response, optional
        Readings under unit forces outside the search, by the distance along each stretch where a load may press; n
        sensors a stretch, one stretch after the other. Where a load there, or at an end of the search, comes within
        `ambiguity` of the best chi-square, the frame is AMBIGUOUS.

    Raises
    ------
    InvalidValueError, GeometryError
        A sensor without noise, a table whose sensors do not match the array's, an option out of range.
    """

    def __init__(
        self,
        response: Response,
        array: SensorArray,
        *,
        half_width: tuple[float, float] | None = None,
        normal_force: tuple[float, float] | None = None,
        friction: float = 1.0,
        scan_step: float | None = None,
        false_alarm: float = 1e-6,
        ambiguity: float = 13.8,
        outliers: int = 0,
        beyond: Response | None = None,
        uncertain: Uncertain | None = None,
    ) -> None:
        _check.noun("response", response, Response, "tabulate(finger)")
        _check.noun("array", array, SensorArray, "finger.array")
        sensors = len(array)
        if response.sensors != sensors:
            seen = f"a response of {response.sensors} sensors, an array of {sensors}"
            raise GeometryError(seen, "they have to match", "array.select(...)")
        wide = response.widest > 0
        usual = {"half_width": (0.0, response.widest), "normal_force": (0.0, np.inf)}
        given = {"half_width": half_width, "normal_force": normal_force}
        ends, forces = (_check.real(k, usual[k] if v is None else v, **_LIMITS[k]) for k, v in given.items())
        if ends.shape != (2,) or not ends[0] <= ends[1] <= response.widest:
            rule = f"two half widths, ascending, up to the response's {response.widest:.6g} m are needed"
            raise InvalidValueError(f"half_width = {half_width!r}", rule, f"half_width=(0.0, {response.widest:.6g})")
        if forces.shape != (2,) or not forces[0] < forces[1]:
            rule = "two ascending normal forces, of 0 or more, are needed [N/m]"
            raise InvalidValueError(f"normal_force = {normal_force!r}", rule, "normal_force=(1.0, 100.0)")
        self.response = self._searched = response
        self.normal_force = (float(forces[0]), float(forces[1]))
        self._beyond = beyond
        if beyond is not None and beyond.sensors % sensors:
            seen = f"beyond of {beyond.sensors} sensors, an array of {sensors}"
            raise GeometryError(seen, "a multiple of these is needed", "beyond=None")
        self.half_width = (float(ends[0]), float(ends[1]))
        self.friction = _check.friction(friction)
        self.unknowns = 2 + (self.friction > 0) + bool(ends[1] > ends[0])
        self._uncertain = uncertain
        self.layout = WIDE if wide else SIZED_LINE if uncertain is not None else LINE
        self._ambiguity = _check.scalar("ambiguity", ambiguity, at_least=0.0)
        self._false_alarm = _check.scalar("false_alarm", false_alarm, above=0.0, at_most=0.5)
        layout = self.layout
        super().__init__(
            array, needed=self.unknowns, columns=layout.columns, status=layout.status, layout=layout,
            outliers=outliers, ambiguity=self._ambiguity,
        )  # fmt: skip
        self._shallowest = float(np.asarray(array.depth).min())
        step = self._shallowest / (16 if wide else 32)
        if scan_step is not None:
            step = _check.scalar("scan_step", scan_step, unit="m", above=0.0)
            if not response.stop - response.start < _MOST_SCANNED * step:
                rule = f"at most {_MOST_SCANNED:.0e} positions are scanned"
                raise InvalidValueError(f"scan_step = {step:.3g} m", rule, "scan_step=None")
        count = max(int(np.ceil((response.stop - response.start) / step - 1e-9)) + 1, 3)
        self._scan = np.linspace(response.start, response.stop, count)
        self._search_ends = (float(response.start), float(response.stop))
        self._squares = np.linspace(*self.half_width, _SCAN_WIDTHS if ends[1] > ends[0] else 1) ** 2

    _without_spare: ClassVar[float] = Status.AMBIGUOUS
    """Status of what explains a frame where no reading is left that could speak against it."""
    takes_doubt = True
    """Whether a call takes the doubts of readings, as a `Pipeline` asks."""

    def __call__(self, readings: npt.ArrayLike, doubt: npt.ArrayLike | None = None) -> Estimate:
        """The contact in each frame.

        Parameters
        ----------
        readings : array_like, shape (..., n)
            Raw readings, offset included, in units of each gain. NaN marks a missing one; it, and a saturated one, are
            left out of its frame.
        doubt : array_like, shape (..., n), optional
            Standard deviation of each reading beside the sensor's noise [reading]: a frame weighs its sensors by both.
            Doubts below a twentieth of the noise are left out.

        Returns
        -------
        Estimate
            Fields of shape (...).

        Raises
        ------
        GeometryError, InvalidValueError
            A last axis that is not the number of sensors; doubts of another shape, or below 0.
        """
        table, used = self._frames(readings, doubt)
        return Estimate(table, used, self.friction, self.unknowns, self.layout, self.relative)

    def covers(self, position: npt.ArrayLike) -> npt.NDArray[np.bool_]:
        """Which positions lie where loads are looked for.

        Parameters
        ----------
        position : array_like, shape (...)
            Positions y [m].
        """
        y = _check.real("position", position, unit="m", finite=False)
        return np.asarray((self.response.start <= y) & (y <= self.response.stop))

    def _kernel(self) -> Any:
        from .project import project_frames

        return project_frames

    def _run(
        self, frames: FloatArray, pattern: npt.NDArray[np.bool_], out: FloatArray, doubt: FloatArray | None = None
    ) -> None:
        super()._run(frames, pattern, out, doubt)
        if frames.shape[1] <= self.unknowns:
            status = out[:, self._status]
            status[status == Status.OK] = self._without_spare

    def _fill(self, frames: FloatArray, arrays: tuple[Any, ...], out: FloatArray) -> None:
        if self._uncertain is None:
            self._compiled(frames, *arrays, self.layout.named(out))
        else:
            self._settle(frames, arrays, out)

    def _settle(
        self, frames: FloatArray, arrays: tuple[Any, ...], out: FloatArray, doubt: FloatArray | None = None
    ) -> None:
        """`_fill` where the finger is not known exactly."""
        assert self._uncertain is not None

        def loop(*given: Any) -> None:
            part = np.empty((len(given[-1]), LINE.columns))
            self._compiled(*given[:-1], LINE.named(part))
            given[-1][:, : LINE.columns] = part

        fill_settled(loop, frames, arrays, bool(self._uncertain.sizes), out, doubt)

    def _doubted(
        self,
        frames: FloatArray,
        doubt: FloatArray,
        arrays: tuple[Any, ...],
        pattern: npt.NDArray[np.bool_],
        out: FloatArray,
    ) -> None:
        if self._uncertain is not None:
            self._settle(frames, arrays, out, doubt)
            return
        rows = in_doubt(doubt, np.asarray(self.array.noise)[pattern])
        many = int(np.count_nonzero(rows))
        if many < len(frames):
            part = np.empty((len(frames) - many, self._columns))
            self._fill(frames[~rows], arrays, part)
            out[~rows] = part
        if many:
            from .project import doubted_frames

            def whole() -> FloatArray:
                return self._fields(self._searched.select(pattern), 1 / np.asarray(self.array.noise)[pattern], pattern)[
                    0
                ]

            fields = self._prepared.get(b"fields" + pattern.tobytes(), whole)
            part = np.empty((many, self._columns))
            doubted_frames(frames[rows], np.ascontiguousarray(doubt[rows]), arrays, fields, self.layout.named(part))
            out[rows] = part

    def _fields(
        self, response: Response, scale: FloatArray, pattern: npt.NDArray[np.bool_]
    ) -> tuple[FloatArray, Stretches]:
        """Readings under unit forces at the nodes of the scan, then beyond it, in units of the noise: (k, n, 2)."""
        fields = response(np.tile(self._scan, self._squares.size), np.repeat(np.sqrt(self._squares), self._scan.size))
        far = stretches(self._beyond, pattern, scale, self.friction)
        return np.concatenate([fields * scale[:, None], far.fields]), far

    def _prepare(self, pattern: npt.NDArray[np.bool_]) -> tuple[Any, ...]:
        """Arguments of the compiled loop between the frames and the output, for the sensors of `pattern`."""
        from scipy.special import chdtri

        array, response = self.array.select(pattern), self._searched.select(pattern)
        scale = 1 / np.asarray(array.noise)
        n, size = scale.size, self._scan.size * self._squares.size
        fields, far = self._fields(response, scale, pattern)
        basis, edges, shapes = scan_geometry(fields, self.friction, _WHOLE)
        shapes = np.ascontiguousarray(shapes[:, : size if self.normal_force != (0.0, np.inf) else 0])
        # as many readings as unknowns: what is left over are the ends of the unknowns, and one of them binds
        largest = float(chdtri(max(n - self.unknowns, 1), self._false_alarm))
        told = np.zeros(1, SETTINGS)
        told["start"], told["step"], told["widest"] = response.start, response.step, response.widest
        told["first"], told["last"], told["pace"] = self._scan[0], self._scan[-1], self._scan[1] - self._scan[0]
        told["positions"], told["friction"] = self._scan.size, self.friction
        (told["least"], told["most"]), told["ambiguity"] = self.normal_force, self._ambiguity
        told["least_square"], told["most_square"] = np.square(self.half_width)
        told["detection"], told["nothing"] = 2 * np.log(1 / self._false_alarm), chdtri(n, self._false_alarm)
        told["largest"], told["fine"] = largest, n * (response.blur * np.abs(fields[:size]).max()) ** 2
        told["apart"], told["broad"] = (0.1 if self.layout.wide else 0.02) * self._shallowest, 0.1 * self._shallowest
        told["far_start"], told["far_step"], told["near"] = far.start, far.step, far.near
        table = packed(response, scale)
        arrays = sensor_rows(array), basis, edges, shapes, self._squares, far.tables, far.nodes, table, told
        if self._uncertain is None:
            return arrays
        thresholds = {
            "friction": self.friction, "largest": largest, "ambiguity": self._ambiguity,
            "apart": float(told[0]["apart"]),
        }  # fmt: skip
        return *arrays, self._to_settle(self._uncertain, array, pattern, thresholds)

    def _to_settle(
        self, uncertain: Uncertain, array: SensorArray, pattern: npt.NDArray[np.bool_], thresholds: dict[str, float]
    ) -> tuple[Any, ...]:
        """Arguments of the loop that settles, for the sensors of `pattern`, which are `array`."""
        low, high = uncertain.base.start, uncertain.base.stop
        nodes = np.arange(low, high, OTHERS * self._shallowest)[:, None]
        ends = {"box": np.array(self._search_ends), "beyond": np.array([low, high])}
        return uncertain.to_settle(array, pattern, self.layout, nodes, **thresholds, **ends)
