"""The estimator of local contacts by a response measured in place."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import numpy.typing as npt

from ... import _check
from ..._check import FloatArray
from ...array import SensorArray
from ...errors import InvalidValueError
from ...measured import MeasuredResponse
from ..frames import sensor_rows
from ..varpro import Limits
from .in_place import InPlaceModel, InPlaceSettings
from .locator import LocalLocator

__all__ = ["InPlaceLocator"]

_AGAIN = 1e-3
"""Chance of a chi-square from which a frame is scanned again, at every node: some that no noise needs, too."""


class InPlaceLocator(LocalLocator):
    """Finds the load in frames of readings by a `MeasuredResponse`; prepared once, then called on a frame or on many.

    Chi-square at a position is weighted by the noise of the readings and the doubt of the response there, which grows
    with the force. The force is eliminated exactly; the position is the best of all nodes, then between nodes.

    Parameters
    ----------
    response : MeasuredResponse
        Readings under unit forces, each with its doubt.
    array : SensorArray, optional
        Range of each sensor, and which are dead (gain 0); without it all readings are taken as they are.
    friction : float, optional
        As in `Finger.locate` [-]; 0 for loads that press straight down, and of a response that knows no drag.
    normal_force : (float, float), optional
        Least and largest normal force [N]; ends that are the same say that it is known. Only without friction.
    search : ((float, float), (float, float)), optional
        Ends of the positions y, and of z [m]; by default all nodes.
    false_alarm, ambiguity, outliers
        As in `Finger.locate`.

    Raises
    ------
    InvalidValueError, GeometryError
        Friction where no drag is known, ends out of order, sensors that do not match.

    Examples
    --------
    >>> import numpy as np
    >>> at = np.stack(np.meshgrid(np.arange(6.0), np.arange(6.0)), axis=-1).reshape(-1, 2) * 1e-3
    >>> sensors = np.array([(1e-3, 1e-3), (4e-3, 1e-3), (1e-3, 4e-3), (4e-3, 4e-3)])
    >>> readings = 1e6 / (1.0 + ((at[:, None] - sensors) ** 2).sum(-1) / 4e-6)
    >>> locator = InPlaceLocator(MeasuredResponse.from_touches(readings, at), friction=0)
    >>> (locator(readings[14]).position * 1e3).round(1).tolist()  # the touch at (2, 2) mm
    [2.0, 2.0]
    """

    def __init__(
        self,
        response: MeasuredResponse,
        array: SensorArray | None = None,
        *,
        friction: float = 1.0,
        normal_force: tuple[float, float] | None = None,
        search: tuple[tuple[float, float], tuple[float, float]] | None = None,
        false_alarm: float = 1e-6,
        ambiguity: float = 13.8,
        outliers: int = 0,
    ) -> None:
        own: dict[str, Any] = {"offset": response.offset, "noise": response.noise}
        if array is None:
            array = SensorArray(y=np.zeros(response.sensors), depth=1e-3, **own)
        elif len(array) == response.sensors:
            array = replace(array, **own)
        ends = _check.ends("normal_force", normal_force, "normal_force=(1.0, 1.0)")
        self._force = (0.0, np.inf) if ends is None else ends
        super().__init__(
            response, array, search, friction=friction, false_alarm=false_alarm, ambiguity=ambiguity,
            outliers=outliers, known=int(self._force[0] == self._force[1]),
        )  # fmt: skip
        if self.friction > 0 and response.components == 1:
            rule = "the response knows no drag: it is that of normal forces"
            raise InvalidValueError(f"friction = {friction!r}", rule, "friction=0, or touches with (N, Ty, Tz)")
        if ends is not None and self.friction > 0:
            rule = "bounds on the force are for loads that press straight down"
            raise InvalidValueError(f"normal_force = {normal_force!r}", rule, "friction=0")

    def covers(self, position: npt.ArrayLike) -> npt.NDArray[np.bool_]:  # noqa: D102
        y, z, _ = self._nodes()
        at = np.asarray(position, dtype=np.float64)
        return np.asarray(((at >= [y[0], z[0]]) & (at <= [y[-1], z[-1]])).all(axis=-1))

    def _kernel(self) -> Any:
        from .in_place import in_place_frames

        return in_place_frames

    def _prepare(self, pattern: npt.NDArray[np.bool_]) -> tuple[Any, ...]:
        """Arguments of the compiled loop between the frames and the output, for the sensors of `pattern`."""
        y, z, inside = self._nodes()
        components = 3 if self.friction > 0 else 1
        values, variance = (
            np.ascontiguousarray(table[inside][:, :, pattern, :components])
            for table in (self.response.values, self.response.variance)
        )
        count = int(pattern.sum())
        settings = InPlaceSettings(
            limits=Limits(self.friction, *self._force),
            stride=self._stride(values),
            detection=self._detection,
            largest=self._left(count, self._false_alarm),
            ambiguity=self._ambiguity,
            doubtful=self._left(count, max(_AGAIN, self._false_alarm)),
            vague=self.response.vague**2,
        )
        typical = np.array([self.response.load, 0.0, 0.0])
        noise = self.response.noise[pattern]
        assert self.response.correlation is not None
        together = self.response.correlation[np.ix_(pattern, pattern)]
        root = np.linalg.cholesky(together)
        mix = np.linalg.inv(root) / noise
        values = np.ascontiguousarray(np.einsum("ij,kljc->klic", mix, values, optimize=True))
        doubt = np.sqrt(variance).swapaxes(2, 3)[..., None, :] * mix  # (k, l, c, n, n)
        variance = np.ascontiguousarray((np.matmul(doubt, root) ** 2).sum(axis=-1).swapaxes(2, 3))
        common = mix @ np.asarray(self.response.common)[pattern]
        steps = (np.array([nodes[0], nodes[1] - nodes[0]]) for nodes in (y, z))
        model = InPlaceModel(common, values, variance, *steps)
        return sensor_rows(self.array.select(pattern)), mix, model, typical, settings

    def _nodes(self) -> tuple[FloatArray, FloatArray, tuple[slice, slice]]:
        """Nodes y and z within the search, and where they are among all."""
        parts = []
        for i, nodes in enumerate((self.response.y, self.response.z)):
            low, high = (nodes[0], nodes[-1]) if self.search is None else self.search[i]
            near = np.flatnonzero((nodes >= low) & (nodes <= high))
            if near.size < 4:
                seen, rule = f"search = {self.search!r}", "it has to hold four of the response's nodes each way"
                raise InvalidValueError(seen, rule, "the search in metres, within the touches")
            parts.append(slice(int(near[0]), int(near[-1]) + 1))
        rows, columns = parts
        return self.response.y[rows], self.response.z[columns], (rows, columns)

    @staticmethod
    def _stride(values: FloatArray) -> int:
        """Nodes between those of the scan: as many as change the strongest reading by no more than a third."""
        normal = values[..., 0]
        peak = np.abs(normal).max()
        for stride in range(1, min(normal.shape[:2]) // 3):
            steps = (np.abs(normal[stride:] - normal[:-stride]), np.abs(normal[:, stride:] - normal[:, :-stride]))
            if max(float(step.max()) for step in steps) > 0.35 * peak:
                return max(stride - 1, 1)
        return 1
