"""The skin that answers local contacts as a skin solved in a plane would, if it knew them."""

from __future__ import annotations

from .. import _check
from .base import Skin
from .half_plane import HalfPlane
from .half_space import HalfSpace

__all__ = ["in_space"]


def in_space(skin: Skin) -> Skin | None:
    """The same skin for touches on a point or an area; None where nobody knows it.

    A half plane in plane strain is a half space under contacts that have no end; a slice and a round finger are solved
    in their plane alone.

    Parameters
    ----------
    skin : Skin
        Any skin.

    Examples
    --------
    >>> import subskin as ss
    >>> print(in_space(ss.HalfPlane(ss.Material(young=0.4e6))))
    a half space (0.4 MPa, nu 0.5)
    """
    _check.noun("skin", skin, Skin, "HalfPlane(Material(young=0.4e6))")
    if skin.takes_local:
        return skin
    return HalfSpace(skin.material) if isinstance(skin, HalfPlane) and skin.plane == "strain" else None
