"""What answers have in common: a status, and frames that are indexed, joined and shown."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from enum import IntEnum
from functools import cached_property
from typing import Any, Self

import numpy as np
import numpy.typing as npt

from .._check import FloatArray
from .._frozen import Frozen
from ..errors import GeometryError, InvalidValueError
from .shown import Shown, as_frame, in_html, in_words

__all__ = ["FrameTable", "OfReadings", "Status"]


class Status(IntEnum):
    """How far an answer can be trusted, frame by frame."""

    OK = 0
    """One load explains the readings, and no other comes near."""
    AMBIGUOUS = 1
    """Another load explains them nearly as well (`Estimate.second`), the best one lies at the search's edge, or a load
    explains any such readings (`Estimate.spare` is 0)."""
    NO_CONTACT = 2
    """Nothing beyond noise."""
    UNEXPLAINED = 3
    """No admissible load (pressing, within the friction cone) explains the readings."""
    INCOMPLETE = 4
    """Too few sensors could be used."""


_NAMES = {int(status): status.name for status in Status}


@dataclass(frozen=True, eq=False, repr=False)
class FrameTable(Frozen, ABC):
    """Answers frame by frame: indexed as arrays are, and joined. `table` and `used` are as in `Estimate`."""

    table: FloatArray
    used: npt.NDArray[np.bool_]

    @classmethod
    def join(cls, parts: Sequence[Self]) -> Self:
        """Answers of one kind one after the other, along the first axis of the batch.

        Parameters
        ----------
        parts : sequence of answers
            At least one.

        Raises
        ------
        GeometryError
            No part, or parts of different layouts.
        """
        if len({part.table.shape[-1] for part in parts}) != 1:
            raise GeometryError(
                f"{len(parts)} answers",
                "at least one is needed, all of one layout",
                "Estimate.join([found[:3], found[3:]])",
            )
        return parts[0]._with(np.concatenate([p.table for p in parts]), np.concatenate([p.used for p in parts]))

    def __getitem__(self, index: object) -> Self:
        """Some frames of the batch."""
        at = np.arange(int(np.prod(self.shape))).reshape(self.shape)[index]  # type: ignore[call-overload]
        return self._with(*(part.reshape(-1, part.shape[-1])[at] for part in (self.table, self.used)))

    def _with(self, table: FloatArray, used: npt.NDArray[np.bool_]) -> Self:
        table.flags.writeable = used.flags.writeable = False
        return replace(self, table=table, used=used)

    def __len__(self) -> int:
        """Number of frames along the first axis of the batch."""
        if not self.shape:
            raise TypeError("an answer for a single frame has no length")
        return len(self.table)

    def __iter__(self) -> Iterator[Self]:
        """The frames along the first axis of the batch."""
        return (self[i] for i in range(len(self)))

    def __repr__(self) -> str:
        return in_words(type(self).__name__, *self._said(), self._shown(), self._more())

    def _repr_html_(self) -> str:
        return in_html(type(self).__name__, *self._said(), self._shown())

    def _said(self) -> tuple[npt.NDArray[Any], Mapping[int, str]]:
        """What each frame is called: numbers, and the name of each number."""
        return self.status, _NAMES

    def _shown(self) -> list[Shown]:
        """What a person sees of it, in the units of people."""
        return []

    def _more(self) -> str:
        """What else a person sees of a single frame."""
        return ""

    @property
    def ok(self) -> npt.NDArray[np.bool_]:
        """Which frames are `OK`, shape (...): `found[found.ok]` are those."""
        return np.asarray(self.status == Status.OK)

    def to_dict(self) -> dict[str, Any]:
        """What was found in SI units, by the names of the command line's tables: arrays of the batch's shape.

        Of a single frame they are numbers.
        """
        columns = self._columns()
        return columns if self.shape else {name: np.asarray(value).item() for name, value in columns.items()}

    def _columns(self) -> dict[str, Any]:
        """The columns of `to_dict`, in SI."""
        return {"status": np.array([status.name.lower() for status in Status])[self.status]}

    def to_pandas(self) -> Any:
        """`to_dict` as a pandas DataFrame, one row a frame.

        Raises
        ------
        ModuleNotFoundError
            pandas is not installed.
        """
        return as_frame(self.to_dict(), self.shape)

    @property
    @abstractmethod
    def status(self) -> npt.NDArray[np.int8]:
        """`Status` of each frame, as integers."""

    @property
    def shape(self) -> tuple[int, ...]:
        """Shape of the batch."""
        return self.table.shape[:-1]


class OfReadings(FrameTable):
    """Answers that know of which readings they are, where a finger gave them: then their resultant can be asked for."""

    @cached_property
    def _origin(self) -> tuple[Any, FloatArray] | None:  # a cache: pickles go without
        return None

    def of(self, finger: Any, readings: npt.ArrayLike) -> Self:
        """The same answers, which know that they are those of a `finger` to `readings` (..., n)."""
        self.__dict__["_origin"] = finger, np.array(readings, dtype=np.float64)
        return self

    def __getitem__(self, index: object) -> Self:
        """Some frames of the batch."""
        some = super().__getitem__(index)
        if self._origin is not None:
            finger, readings = self._origin
            at = np.arange(int(np.prod(self.shape))).reshape(self.shape)[index]  # type: ignore[call-overload]
            some.of(finger, readings.reshape(-1, readings.shape[-1])[at])
        return some

    @cached_property
    def resultant(self) -> Any:
        """Force, drag, centre and moments of whatever presses, without its shape: `Finger.resultant` of the readings.

        Raises
        ------
        InvalidValueError
            An answer that was not given by `Finger.locate` or `Finger.fit`, or that was pickled or joined since.
        """
        if self._origin is None:
            rule = "it has to come from finger.locate(readings) or finger.fit(readings) itself"
            raise InvalidValueError("an answer that knows no readings", rule, "finger.resultant(readings)")
        finger, readings = self._origin
        return finger.resultant(readings)
