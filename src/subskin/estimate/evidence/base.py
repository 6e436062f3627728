"""What the evidence of sensors in a row and of those on an area share: the kinds, and the table that is filled."""

from __future__ import annotations

from collections.abc import Sequence
from typing import ClassVar, NamedTuple

import numpy as np
import numpy.typing as npt

from ... import _check
from ..._check import FloatArray
from ...errors import InvalidValueError
from ...finger import Finger
from ..frames import Framewise
from .kind import NONE, PAIR, Kind

STATUS, KIND = 0, 1
LOG_EVIDENCE, CHI2, POSITION, NORMAL, TANGENTIAL, HALF_WIDTH, EACH = 0, 1, 2, 3, 4, 5, 6
"""Columns of the table, one row a frame: of the frame, then of each kind of long contact."""


class Columns(NamedTuple):
    """Where the columns of a kind begin, and what stands in which of them."""

    first: int
    each: int
    position: tuple[int, ...]
    components: tuple[int, ...]
    half_width: int
    edge: tuple[int, ...] = ()


LONG = Columns(KIND, EACH, (POSITION,), (NORMAL, TANGENTIAL), HALF_WIDTH)
LOCAL = Columns(KIND, 11, (2, 3), (4, 5, 6), 7, (8, 9, 10))
"""Of long contacts, and of contacts on an area; the log of the evidence and chi-square come first in both.

On an area half length, direction and its standard error of an edge come last.
"""


class Weighing(Framewise):
    """The log of the probability of frames of readings under each kind of contact; prepared once, called on many.

    Parameters
    ----------
    finger : Finger
        The forward model, with the sensors' noise.
    kinds : sequence of Kind
        At least one of a family; at most one "pair", at most one "none".
    friction, false_alarm : float
        As of `Evidence`.
    needed : int
        Least number of sensors without friction.

    Raises
    ------
    InvalidValueError
        Sensors without noise, kinds of one name, kinds that the sensors cannot tell.
    """

    _layout_of: ClassVar[Columns]
    _example: ClassVar[str]
    _misplaced: ClassVar[tuple[tuple[str, ...], str, str]]
    """Families that such sensors cannot tell, why, and what to weigh instead."""

    def __init__(
        self, finger: Finger, kinds: Sequence[Kind], *, friction: float, false_alarm: float, needed: tuple[int, int]
    ) -> None:
        self.kinds = tuple(kinds)
        names, families = [kind.name for kind in self.kinds], [kind.family for kind in self.kinds]
        if not names or len(set(names)) < len(names):
            raise InvalidValueError(f"kinds = {names}", "at least one, each of its own name, is needed", self._example)
        misplaced, rule, fix = self._misplaced
        for family in misplaced:
            if family in families:
                raise InvalidValueError(f'family = "{family}"', rule, fix)
        self._single = [i for i, family in enumerate(families) if family not in (PAIR, NONE)]
        self._two, self._none = (families.index(name) if name in families else -1 for name in (PAIR, NONE))
        if not self._single or max(families.count(PAIR), families.count(NONE)) > 1:
            rule = 'at least one kind of a family, and at most one "pair" and one "none", can be weighed'
            raise InvalidValueError(f"families = {families}", rule, "leave the others out")
        self.friction = _check.friction(friction)
        size = self._layout_of.first + self._layout_of.each * len(names)
        super().__init__(finger.array, needed=needed[self.friction > 0], columns=size, status=STATUS)
        self.allow_for(finger, self.friction)
        self._false_alarm = _check.scalar("false_alarm", false_alarm, above=0.0, at_most=0.5)
        self._shallowest = float(np.asarray(finger.array.depth).min())

    def __call__(self, readings: npt.ArrayLike) -> tuple[FloatArray, npt.NDArray[np.bool_]]:
        """Packed results, shape (..., columns), and the sensors used, shape (..., n).

        Parameters
        ----------
        readings : array_like, shape (..., n)
            As in `Locator`.
        """
        return self._frames(readings)

    def _kind(self, number: int) -> Kind:
        """One of those that are a contact."""
        return self.kinds[self._single[number]]

    def _slot(self, number: int) -> int:
        """Its first column."""
        return self._layout_of.first + self._layout_of.each * self._single[number]

    def _spare(self, sensors: int) -> npt.NDArray[np.intp]:
        """Readings beyond the unknowns of each."""
        return np.array([sensors - self.kinds[i].unknowns(self.friction) for i in self._single])

    def _shares(self) -> FloatArray:
        """What each has of the prior of all that are a contact."""
        priors = np.array([self.kinds[i].prior for i in self._single])
        return np.asarray(priors / priors.sum())
