"""What a page shows of a finger: what its link holds."""

from __future__ import annotations

from typing import Annotated

from pydantic import BaseModel, ConfigDict, Field

from .touch import Touch

__all__ = ["FingerState"]


class FingerState(BaseModel):
    """All that a page shows of a finger: what its link holds."""

    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False)

    text: str = Field(max_length=100_000)
    touch: Touch | None = None
    show: str | None = Field(default=None, max_length=40)
    find: str = Field(default="locate", pattern="^(locate|fit)$")
    seed: Annotated[int, Field(ge=0, le=2**31)] | None = 0
