"""Tensors whose components are worked out when asked for."""

from __future__ import annotations

from collections.abc import Callable
from functools import cached_property
from operator import attrgetter
from typing import Any

from .._check import FloatArray, read_only
from .._frozen import Frozen
from ..tensor import Strain, Stress

__all__ = ["DeferredStrain", "DeferredStress"]


class _Deferred(Frozen):
    """A tensor in space whose components are worked out when asked for: `xx` and the trace alone, or all of them."""

    def __init__(
        self, whole: Callable[[], Stress | Strain], xx: Callable[[], FloatArray], trace: Callable[[], FloatArray]
    ) -> None:
        self.__dict__.update(_made=whole, _xx=xx, _trace=trace)

    def _as_said(self) -> tuple[Any, ...]:
        """It travels as what it has to say: functions stay behind."""
        kind = Stress if isinstance(self, Stress) else Strain
        return kind, (self.xx, self.yy, self.zz, self.xy, self.xz, self.yz)

    @cached_property
    def _all(self) -> Stress | Strain:
        made: Stress | Strain = self.__dict__["_made"]()
        return made

    @cached_property
    def xx(self) -> FloatArray:
        return read_only(self.__dict__["_xx"]())

    @cached_property
    def trace(self) -> FloatArray:
        return read_only(self.__dict__["_trace"]())

    yy, zz, xy, xz, yz = (property(attrgetter(f"_all.{name}")) for name in ("yy", "zz", "xy", "xz", "yz"))

    @property
    def is_plane(self) -> bool:
        return False


class DeferredStress(_Deferred, Stress):
    """Stress whose components are worked out when asked for."""

    __reduce__ = _Deferred._as_said


class DeferredStrain(_Deferred, Strain):
    """Strain whose components are worked out when asked for."""

    __reduce__ = _Deferred._as_said
