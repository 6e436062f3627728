"""What friction holds: of a drag and a moment about the normal together, and how much of a contact sticks below that.

On a round contact both, a drag and a moment, are held up to its limit surface.
A contact that is about to slip turns about a point at the distance c from its middle, in its own half widths; there it
slides everywhere, and friction mu p points against each point's own motion (Goyal, Ruina, Papadopoulos, Wear 143
(1991) 307). With the pressure p of unit load on the disc of radius 1, and K and E the complete elliptic integrals of
the parameter 4 r c / (r + c)^2,

    T / (mu N)   = (2 / c) integral from 0 to 1 of p r [(r + c) E - (r - c) K] dr
    M / (mu N a) =      2 integral from 0 to 1 of p r [(r + c) E + (r - c) K] dr

are the ends of what is held. All c make a curve; every drag and moment within it is held (docs/slip.md).
"""

from __future__ import annotations

from functools import lru_cache
from typing import Annotated, Any, NamedTuple, TypeAlias

import numpy as np
import numpy.typing as npt

from .. import _check
from .._check import FloatArray
from .._declared import Real, checked
from ..contact import families, family_of
from ..errors import GeometryError
from ..pressing import Indenter, LocalIndenter, LocalSolution, PressStatus, press
from ..skin import Skin

__all__ = [
    "checked_contact", "drag_held", "effective_drag", "friction_arm", "moment_held", "slipping_about",
    "stick_share", "stick_zone",
]  # fmt: skip

_Force: TypeAlias = Annotated[npt.ArrayLike, Real("N/m", finite=False)]

_NODES, _GRADE = 40, 3
"""Gauss and Legendre's nodes of a stretch, and the power by which they crowd to an end where a logarithm stands."""
_POINTS = 1500


class _Curve(NamedTuple):
    """The curve of one pressure; drag and moment in shares of what is held of each alone."""

    arm: float
    turn: FloatArray  # angle of (drag, moment), ascending, on [0, pi / 2]
    reach: FloatArray  # the distance from (0, 0) there
    drag: FloatArray  # over sqrt(1 - moment^2), at even steps of the moment
    moment: FloatArray  # over sqrt(1 - drag^2), at even steps of the drag


# of p r dr with r = sin u, the loads being 1: the rim's root goes with dr
_PRESSURES = {
    "hertz": lambda u: 1.5 / np.pi * np.sin(u) * np.cos(u) ** 2,
    "punch": lambda u: 0.5 / np.pi * np.sin(u),
    "wedge": lambda u: np.arccosh(1 / np.sin(u)) / np.pi * np.sin(u) * np.cos(u),
}
_ARMS = {"hertz": 3 * np.pi / 16, "punch": np.pi / 4, "wedge": np.pi / 6}


def friction_arm(contact: str = "hertz") -> float:
    """The largest moment that friction holds without a drag, over mu N a, a being the half width.

    Parameters
    ----------
    contact : {"hertz", "punch", "wedge"}, optional
        The pressure of a round body, of a flat disc, or of a cone.

    Examples
    --------
    >>> from subskin.decide import friction_arm
    >>> round(friction_arm("hertz"), 4), round(friction_arm("punch"), 4)
    (0.589, 0.7854)
    """
    _check.choice("contact", contact, _ARMS)  # of some width: a line holds no moment
    return float(_ARMS[contact])


@checked
def slipping_about(centre: Annotated[npt.ArrayLike, Real(above=0.0)], contact: str = "hertz") -> FloatArray:
    """Drag over mu N and moment over mu N a of a contact that slips while it turns about a point, shape (..., 2).

    Parameters
    ----------
    centre : array_like, shape (...)
        Distance of that point from the middle, in half widths [-], > 0.
    contact : {"hertz", "punch", "wedge"}, optional
        As in `friction_arm`.

    Examples
    --------
    >>> from subskin.decide import slipping_about
    >>> slipping_about(0.5).round(4).tolist()
    [0.5522, 0.4556]
    """
    from scipy.special import ellipe, ellipk

    friction_arm(contact)
    c = np.asarray(centre)[..., None]
    s, w = np.polynomial.legendre.leggauss(_NODES)
    s, w = 0.5 * (1 + s), 0.5 * w
    centre_at = np.arcsin(np.minimum(c, 1.0))
    near, share = s**_GRADE, _GRADE * w * s ** (_GRADE - 1)
    # stretches from the middle, where a cone's pressure is infinite, and to both sides of the centre
    half, rest = 0.5 * centre_at, np.pi / 2 - centre_at
    u = np.concatenate([half * near, centre_at - half * near, centre_at + rest * near], axis=-1)
    weight = np.concatenate([half * share, half * share, rest * share], axis=-1)
    r = np.sin(u)
    k = np.minimum(4 * r * c / (r + c) ** 2, 1 - 1e-16)
    first, second = (r + c) * ellipe(k), (r - c) * ellipk(k)
    load = 2 * _PRESSURES[contact](np.maximum(u, 1e-300)) * weight
    drag, moment = (load * (first - second)).sum(axis=-1) / c[..., 0], (load * (first + second)).sum(axis=-1)
    return _check.read_only(np.stack([drag, moment], axis=-1))


@lru_cache(maxsize=4)
def _curve(contact: str) -> _Curve:
    t = np.linspace(0.0, 1.0, _POINTS)[1:-1]
    ends = slipping_about((t / (1 - t)) ** 2, contact)
    x = np.concatenate([[0.0], np.minimum(ends[:, 0], 1.0), [1.0]])
    m = np.concatenate([[1.0], np.minimum(ends[:, 1] / _ARMS[contact], 1.0), [0.0]])
    even = np.linspace(0.0, 1.0, _POINTS)

    def over(at: FloatArray, values: FloatArray) -> FloatArray:
        """The ratio values / sqrt(1 - at^2), of ascending `at`, at even steps; at the end as just before it."""
        inside = at < 1 - 1e-9
        ratio = values[inside] / np.sqrt((1 - at[inside]) * (1 + at[inside]))
        return np.asarray(np.interp(even, at[inside], ratio))

    turn, reach = np.arctan2(m, x), np.hypot(x, m)
    return _Curve(_ARMS[contact], turn[::-1].copy(), reach[::-1].copy(), over(m[::-1], x[::-1]), over(x, m))


def effective_drag(tangential: FloatArray, turning: FloatArray, contact: str) -> FloatArray:
    """The drag alone that is as near to slipping: mu N reaches it where friction gives way.

    tangential: |T| [N]; turning: |M| / (arm a) [N].
    """
    curve = _curve(contact)
    size = np.hypot(tangential, turning)
    return np.asarray(size / np.interp(np.arctan2(turning, tangential), curve.turn, curve.reach))


def drag_held(hold: FloatArray, turning: FloatArray, contact: str) -> FloatArray:
    """The largest |T| [N] that is held beside a moment, |M| / (arm a) = `turning` [N], where `hold` is mu N."""
    return _held(hold, turning, _curve(contact).drag)


def moment_held(hold: FloatArray, tangential: FloatArray, contact: str) -> FloatArray:
    """The largest |M| / (arm a) [N] that is held beside a drag |T| = `tangential` [N], where `hold` is mu N."""
    return _held(hold, tangential, _curve(contact).moment)


def _held(hold: FloatArray, other: FloatArray, ratio: FloatArray) -> FloatArray:
    share = np.divide(
        other, hold, out=np.full(np.broadcast_shapes(np.shape(hold), np.shape(other)), 2.0), where=hold > 0
    )
    at = np.minimum(share, 1.0) * (_POINTS - 1)
    cell = np.minimum(at.astype(np.intp), _POINTS - 2)
    rise = ratio[cell] + (at - cell) * (ratio[cell + 1] - ratio[cell])
    return np.asarray(hold * rise * np.sqrt(np.maximum((1 - share) * (1 + share), 0.0)))


def checked_contact(contact: str) -> str:
    """The name of a contact whose stick zone is known in closed form."""
    return _known(contact) if isinstance(contact, str) else _known.__wrapped__(contact)


@lru_cache(maxsize=64)  # a name that is good stays so
def _known(contact: str) -> str:
    laws = [name for name, family in families().items() if family.GROWTH is not None]
    _check.choice("contact", contact, laws, "for other bodies give skin= and indenter=, and the solver finds the zone")
    return contact


def stick_share(contact: str, ratio: FloatArray, *, on_area: bool = False) -> FloatArray:
    """Stick zone c/a by |T| / (mu N): the contact zone of the normal force N - |T|/mu (Ciavarella 1998, Jaeger 1998).

    For a round body that of Cattaneo (1938) and Mindlin (1949). NaN for a line, which has no zone to speak of. On an
    area the force grows with one power of a more: as a^3 beneath a ball, as a^2 beneath a cone.
    """
    growth = family_of(checked_contact(contact)).GROWTH
    if growth is None or np.isnan(growth):
        return np.full_like(ratio, np.nan)
    growth = growth / (1 + growth) if on_area else growth
    return np.where(ratio < 1, np.maximum(1 - ratio, 0.0) ** growth, np.where(ratio >= 1, 0.0, np.nan))


@checked
def stick_zone(
    skin: Skin,
    indenter: Indenter | LocalIndenter,
    normal: _Force,
    tangential: _Force,
    friction: Annotated[npt.ArrayLike, Real(above=0.0)],
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
        Normal and tangential force [N/m]; of a body in space [N], where `tangential` is (..., 2), along y and z.
    friction : array_like, shape (...)
        Coefficient of friction [-], > 0.
    nodes, window, period, datum, tolerance, max_strain : optional
        As in `subskin.press`.

    Returns
    -------
    ndarray, shape (...)
        On an area the root of the part of the contact's area. 0 where all of it slides; NaN where the solver did not
        settle, and where a load is NaN or does not press.

    Raises
    ------
    InvalidValueError, GeometryError
        As `subskin.press`; a drag without two components, of a body in space.

    Examples
    --------
    Cattaneo and Mindlin: c / a = sqrt(1 - T / (mu N)).

    >>> import subskin as ss
    >>> skin = ss.HalfPlane(ss.Material(young=0.4e6))
    >>> share = ss.decide.stick_zone(skin, ss.pressing.Cylinder(radius=8e-3), 40.0, 10.0, friction=0.5)
    >>> round(float(share), 2), round(float(0.5**0.5), 2)
    (0.71, 0.71)
    """
    n, t, mu = np.asarray(normal), np.asarray(tangential), np.asarray(friction)
    if (local := isinstance(indenter, LocalIndenter)) and t.shape[-1:] != (2,):
        rule = "the drag of a body in space has two components, along y and z"
        raise GeometryError(f"tangential of shape {t.shape}", rule, "tangential=[0.1, 0.0]")
    shape = _check.broadcast(normal=n, tangential=t[..., 0] if local else t, friction=mu)
    drags = np.broadcast_to(t, (*shape, 2)).reshape(-1, 2) if local else np.broadcast_to(t, shape).reshape(-1)
    flat = [np.broadcast_to(v, shape).reshape(-1) for v in (n, mu)]
    options = {"nodes": nodes, "window": window, "period": period, "datum": datum}
    options |= {"tolerance": tolerance, "max_strain": max_strain}
    every = zip(*flat, drags, strict=True)
    shares = [_share(skin, indenter, float(v), float(m), drag, options) for v, m, drag in every]
    return _check.read_only(np.array(shares, dtype=np.float64).reshape(shape))


def _share(
    skin: Skin, indenter: Indenter | LocalIndenter, normal: float, mu: float, drag: FloatArray, options: dict[str, Any]
) -> float:
    size = float(np.hypot.reduce(np.atleast_1d(drag)))
    if not np.isfinite(normal + size) or not normal > 0:
        return np.nan
    if size >= mu * normal:
        return 0.0
    body: Any = indenter
    pressed: Any = press(skin, body, force=normal, friction=mu, **options)
    settled = (PressStatus.OK, PressStatus.SLIDES)
    if pressed.status not in settled:
        return np.nan
    along: Any = drag.tolist() if isinstance(indenter, LocalIndenter) else float(drag)
    dragged: Any = press(skin, body, force=normal, friction=mu, tangential=along, after=pressed)
    if dragged.status not in settled:
        return np.nan
    if isinstance(dragged, LocalSolution):
        return float(np.sqrt(np.count_nonzero(dragged.stick) / np.count_nonzero(dragged.pressure > 0)))
    return float(np.diff(dragged.stick).sum() / np.diff(dragged.edges).sum())
