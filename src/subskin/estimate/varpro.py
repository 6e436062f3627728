"""The one fitting kernel: readings are F linear components times a field of P nonlinear unknowns, and noise.

Variable projection (Golub and Pereyra 1973; Kaufman 1975): at each trial of the unknowns the components are eliminated
exactly, within compression and the cone of friction (`cone.py`), and what remains is a climb to the top of S, the
chi-square that is explained. Steps are Gauss and Newton's on the projected residual, damped after Levenberg and
Marquardt, within a box; where a field gives its second slopes too, they are Newton's where S is curved as at a top.

Loops over F and P cost a factor of 4.5, so the loops of a kind are made of one template, in which they are written out.
A kind is its field and the names of its unknowns:

    class Point(NamedTuple):
        y: float
        z: float

    FIT, project, slopes, information, keep, climb, covariance = kernel(Point, point_field, components=3)

The field is compiled and fills rows of `model.rows` (rows, n) at a `Point`, with `field(model, at)`: first the whitened
readings under each component, then their slopes in each unknown in turn; then, where there are any, the readings under
each free component, each followed by its slopes; and the second slopes, by pairs of unknowns. A field that is short
need fill nothing: `read` gives the numbers of a sensor.
"""

from __future__ import annotations

import math
import sys
from collections import namedtuple
from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from .._compiled import compiled
from . import cone
from ._template import written

__all__ = ["THOROUGH", "Ending", "Kernel", "Limits", "kernel"]


class Limits(NamedTuple):
    """What the components keep to: |T| <= friction N, and of one or two of them the ends of N."""

    friction: float
    least: float = 0.0
    most: float = np.inf


class Ending(NamedTuple):
    """When a climb ends: with a step that raises S by less than `tolerance`, which is still made where nothing binds.

    Also with one that is shorter than `smallest`, or so short beside a hundredfold of `straight`, over which readings
    bend, that it leaves a hundredth of a standard deviation; and where not even four times what the next step gains
    leads to S = `needed`.
    """

    tolerance: float
    smallest: float = 0.0
    straight: float = 0.0
    needed: float = -np.inf


THOROUGH = 1.0
"""Gain below which a rough climb does not end: where one of its steps fails, the next is half as long at once."""


ROUGH = 1e-2
"""Gain above which a climb does not look where its last step ends."""


class Kernel(NamedTuple):
    """What is made for a kind.

    fit: the type of a fit, a structured array's. Its fields, of components k, l and unknowns p, q: each component and
    unknown by its name; `explained`, S; `left`, chi-square left; `inside`, 1 where nothing binds the components;
    g_k_l, A^T A; i_k_l, its inverse in what is left free; by_p, the gradient of S / 2; u_p_q, U^T U, U being the
    readings' slopes; a_p_k, U^T A. Of a free component t: its value, square_t, t^T t, and t_k and t_p, t^T A and t^T U;
    it is taken out of the others. Where there are second slopes, c_p_q, what the misfit adds to the information, and
    e_p_k, the slopes times the misfit.

    project(w, model, cone, at, fit): the best components of readings w (n,) at a point, as far as g, i and the values.
    slopes(w, model, fit): the rest.
    information(fit): named p_q, U^T U less what the components explain of it; and f_p_k, how they fall with p.
    keep(fit, other): copies a fit.
    climb(w, model, cone, box, start, ending, fit, trial): to the top within box (2 P,), low and high of each; into fit.
    covariance(fit, cone, more, out): upper triangle of that of all unknowns, then components; `more`, of the unknowns
    alone, upper triangle, is added. Infinite, or NaN, where the readings do not say.
    """

    fit: Any
    project: Any
    slopes: Any
    information: Any
    keep: Any
    climb: Any
    covariance: Any


_BY_COMPONENTS: tuple[Any, ...] = (
    (("n",), cone.eliminate_one, cone.admissible_one, ("least", "most")),
    (("n", "t"), cone.eliminate_two, cone.admissible_two, ("friction", "least", "most")),
    (("n", "ty", "tz"), cone.eliminate_three, cone.admissible_three, ("friction",)),
)
"""Of one to three components: their names, how they are eliminated, what is admissible, and what they keep to."""


class _Name:
    """A component, by the row of its readings, or an unknown, by its index."""

    def __init__(self, name: str, at: int) -> None:
        self.name, self.at = name, at

    def __str__(self) -> str:
        return self.name

    def __or__(self, other: _Name) -> str:
        """Both names, in order."""
        return f"{self}_{other}" if self.at <= other.at else f"{other}_{self}"


def _named(names: Sequence[str]) -> list[_Name]:
    return [_Name(name, at) for at, name in enumerate(names)]


def _pairs(names: Sequence[_Name]) -> list[tuple[_Name, _Name]]:
    return [(one, other) for one in names for other in names if one.at <= other.at]


def kernel(
    at: type,
    field: Any = None,
    components: int = 3,
    free: str = "",
    *,
    bent: bool = False,
    read: Any = None,
    where: Any = None,
    looks: bool = True,
    **longest: float,
) -> Kernel:
    """The loops of a kind, made of one template; compiled when they are first called, and kept beside its module.

    Parameters
    ----------
    at : type
        A named tuple of the unknowns, at the top of the module of the kind.
    field : callable, optional
        A compiled function `field(model, at)` that fills `model.rows`.
    components : int, optional
        F: 1 for N, 2 for (N, T), 3 for (N, Ty, Tz).
    free : str, optional
        Name of one more component, which nothing binds.
    bent : bool, optional
        Whether the field gives second slopes.
    read : callable, optional
        A compiled function `read(model, here, i)`, put in place of its calls, that gives the readings of sensor i
        under each component, their slopes and second slopes, in the order of the rows, where a field has these in fewer
        numbers or there is none.
    where : callable, optional
        A compiled function `where(model, at)`, put in place of its calls, that gives what is `here` for `read`.
    looks : bool, optional
        Whether a climb looks where its last step ends if something binds the components; else it stays where it is.
    longest : float, optional
        By the name of an unknown, the most that a step changes it.
    """
    names, eliminate, admissible, kept = _BY_COMPONENTS[components - 1]
    fields: tuple[str, ...] = at._fields  # type: ignore[attr-defined]
    f, p = _named(names), _named(fields)
    t = [_Name(free, components * (1 + len(p)))] if free else []
    ff, pp, every = _pairs(f), _pairs(p), [*p, *f]

    def slope(component: _Name, unknown: _Name) -> int:
        """The row of a component's slopes in an unknown."""
        return component.at + (1 if component in t else len(f)) * (1 + unknown.at)

    def second(component: _Name, one: _Name, other: _Name) -> int:
        """The row of its second slopes."""
        return (len(f) + len(t)) * (1 + len(p)) + len(f) * pp.index((one, other)) + component.at

    def entry(one: _Name, other: _Name) -> int:
        """Where a covariance stands, in the upper triangle of all."""
        i, j = sorted((every.index(one), every.index(other)))
        return i * (2 * len(every) - 1 - i) // 2 + j

    values = [*names, *fields, *(str(e) for e in t), "explained", "left", "inside"]
    values += [f"{s}_{j | k}" for s in "gi" for j, k in ff]
    values += [*(f"by_{u}" for u in p), *(f"u_{u | v}" for u, v in pp), *(f"a_{u}_{k}" for u in p for k in f)]
    values += [part for e in t for part in (f"square_{e}", *(f"t_{x}" for x in every))]
    values += [f"c_{u | v}" for u, v in pp if bent] + [f"e_{u}_{k}" for u in p for k in f if bent]
    home, name = sys.modules[at.__module__], at.__name__
    told = namedtuple(f"{name}Information", [*(f"{u | v}" for u, v in pp), *(f"f_{u}_{k}" for u in p for k in f)])  # type: ignore[misc]
    told.__module__ = home.__name__
    setattr(home, told.__name__, told)  # where what was compiled for it finds it again
    lines = written(
        {
            "F": f, "P": p, "T": t, "FF": ff, "PP": pp, "FIELD": [field] if field else [], "SECOND": pp if bent else [],
            "BENT": p if bent else [], "CONE": kept, "VALUES": values,
            "slope": slope, "second": second, "entry": entry, "longest": longest,
            "looks": looks, "THOROUGH": THOROUGH, "ROUGH": ROUGH,
        },
    )  # fmt: skip
    made: dict[str, Any] = {
        "math": math, "field": field, "eliminate": eliminate, "admissible": admissible, "At": at, "Information": told,
        "__name__": home.__name__,
    }  # fmt: skip
    exec(compile("\n".join(lines), str(home.__file__), "exec"), made)
    merged = () if field else ("project", "slopes")  # without rows to fill they are short
    for part in _PARTS:
        loop, inline = made[part], part in _INLINE
        loop.__qualname__ = f"{name}.{part}"  # by which Numba keeps it
        given = {"read": read, "where": where}.get(part)
        made[part] = given or compiled(inline=inline, borrows=not inline, merged=part in merged)(loop)
    fit = np.dtype((np.record, [(value, np.float64) for value in values]))  # whose parts plain Python reads by name too
    return Kernel(fit, *(made[part] for part in Kernel._fields[1:]))


_PARTS = ("where", "read", "project", "slopes", "information", "curved", "step", "keep", "climb", "covariance")
"""Each after those that it calls."""
_INLINE = {"where", "read", "project", "slopes", "information", "curved", "step", "keep"}
