"""How much of a contact sticks while it is dragged by less than friction holds."""

from __future__ import annotations

from functools import lru_cache
from typing import Any

import numpy as np
import numpy.typing as npt

from .. import _check
from .._check import FloatArray
from ..contact import families, family_of
from ..pressing import Indenter, PressStatus, press
from ..skin import Skin

__all__ = ["checked_contact", "stick_share", "stick_zone"]


def checked_contact(contact: str) -> str:
    """The name of a contact whose stick zone is known in closed form."""
    return _known(contact) if isinstance(contact, str) else _known.__wrapped__(contact)


@lru_cache(maxsize=64)  # a name that is good stays so
def _known(contact: str) -> str:
    laws = [name for name, family in families().items() if family.GROWTH is not None]
    _check.choice("contact", contact, laws, "for other bodies give skin= and indenter=, and the solver finds the zone")
    return contact


def stick_share(contact: str, ratio: FloatArray) -> FloatArray:
    """Stick zone c/a by |T| / (mu N): the contact zone of the normal force N - |T|/mu (Ciavarella 1998, Jaeger 1998).

    For a round body that of Cattaneo (1938) and Mindlin (1949). NaN for a line, which has no zone to speak of.
    """
    growth = family_of(checked_contact(contact)).GROWTH
    if growth is None or np.isnan(growth):
        return np.full_like(ratio, np.nan)
    return np.where(ratio < 1, np.maximum(1 - ratio, 0.0) ** growth, np.where(ratio >= 1, 0.0, np.nan))


def stick_zone(
    skin: Skin,
    indenter: Indenter,
    normal: npt.ArrayLike,
    tangential: npt.ArrayLike,
    friction: npt.ArrayLike,
    *,
    nodes: int | None = None,
    window: float | None = None,
    period: float | None = None,
    datum: float | None = None,
    tolerance: float = 1e-9,
    max_strain: float | None = 0.5,
) -> FloatArray:
    """The part of a contact's width that sticks, by the contact solver: any indenter on any skin.

    The body is pressed first and then dragged; other ways to the same load leave other zones (docs/pressing.md). About
    a twentieth of a second each.

    Parameters
    ----------
    skin, indenter
        As in `subskin.press`.
    normal, tangential : array_like, shape (...)
        Normal and tangential force [N/m].
    friction : array_like, shape (...)
        Coefficient of friction [-], > 0.
    nodes, window, period, datum, tolerance, max_strain : optional
        As in `subskin.press`.

    Returns
    -------
    ndarray, shape (...)
        0 where all of it slides; NaN where the solver did not settle, and where a load is NaN or does not press.

    Raises
    ------
    InvalidValueError, GeometryError
        As `subskin.press`.

    Examples
    --------
    Cattaneo and Mindlin: c / a = sqrt(1 - T / (mu N)).

    >>> import subskin as ss
    >>> skin = ss.HalfPlane(ss.Material(young=0.4e6))
    >>> share = ss.decide.stick_zone(skin, ss.pressing.Cylinder(radius=8e-3), 40.0, 10.0, friction=0.5)
    >>> round(float(share), 2), round(float(0.5**0.5), 2)
    (0.71, 0.71)
    """
    given = {"normal": normal, "tangential": tangential}
    wanted = [_check.real(name, value, unit="N/m", finite=False) for name, value in given.items()]
    mu = _check.real("friction", friction, above=0.0)
    shape = _check.broadcast(normal=wanted[0], tangential=wanted[1], friction=mu)
    flat = [np.broadcast_to(v, shape).reshape(-1) for v in (*wanted, mu)]
    options = {"nodes": nodes, "window": window, "period": period, "datum": datum}
    options |= {"tolerance": tolerance, "max_strain": max_strain}
    shares = [_share(skin, indenter, float(n), float(t), float(m), options) for n, t, m in zip(*flat, strict=True)]
    return _check.read_only(np.array(shares, dtype=np.float64).reshape(shape))


def _share(
    skin: Skin, indenter: Indenter, normal: float, tangential: float, mu: float, options: dict[str, Any]
) -> float:
    if not np.isfinite(normal + tangential) or not normal > 0:
        return np.nan
    if abs(tangential) >= mu * normal:
        return 0.0
    pressed = press(skin, indenter, force=normal, friction=mu, **options)
    settled = (PressStatus.OK, PressStatus.SLIDES)
    if pressed.status not in settled:
        return np.nan
    dragged = press(skin, indenter, force=normal, friction=mu, tangential=tangential, after=pressed)
    if dragged.status not in settled:
        return np.nan
    return float(np.diff(dragged.stick).sum() / np.diff(dragged.edges).sum())
