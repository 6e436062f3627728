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
each free component, each followed by its slopes; and the second slopes, by pairs of unknowns.
"""

from __future__ import annotations

import math
import re
import sys
from collections import namedtuple
from collections.abc import Iterator, Sequence
from functools import cache
from typing import Any, NamedTuple

import numpy as np

from .._compiled import compiled
from . import cone

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


_TEMPLATE = '''
def read(model, i):
    rows = model.rows
    return (
        rows[{k.at}, i],  #: for k in F
        rows[{slope(k, p)}, i],  #: for p in P for k in F
    )


def project(w, model, cone, at, fit):
    field(model, at)
    rows = model.rows
    g_{k|l} = 0.0  #: for k, l in FF
    b_{k} = 0.0  #: for k in F
    for i in range(w.size):
        (
            v_{k},  #: for k in F
            d_{p}_{k},  #: for p in P for k in F
        ) = read(model, i)
        g_{k|l} += v_{k} * v_{l}  #: for k, l in FF
        b_{k} += v_{k} * w[i]  #: for k in F
    taken = 0.0
    #: for t in T
        square_{t}, along_{t} = 0.0, 0.0
        t_{k} = 0.0  #: for k in F
        for i in range(w.size):
            square_{t} += rows[{t.at}, i] * rows[{t.at}, i]
            along_{t} += rows[{t.at}, i] * w[i]
            t_{k} += rows[{t.at}, i] * rows[{k.at}, i]  #: for k in F
        over_{t} = 1.0 / square_{t} if square_{t} > 0.0 else 0.0
        g_{k|l} -= over_{t} * t_{k} * t_{l}  #: for k, l in FF
        b_{k} -= over_{t} * along_{t} * t_{k}  #: for k in F
        taken += over_{t} * along_{t} * along_{t}
        fit.square_{t} = square_{t}
        fit.t_{k} = t_{k}  #: for k in F
    found = eliminate(
        g_{k|l},  #: for k, l in FF
        b_{k},  #: for k in F
        cone.{c},  #: for c in CONE
    )
    (
        fit.{k},  #: for k in F
        explained,
        fit.i_{k|l},  #: for k, l in FF
        fit.inside,
    ) = found
    fit.explained = explained + taken
    fit.g_{k|l} = g_{k|l}  #: for k, l in FF
    fit.{p} = at.{p}  #: for p in P
    #: for t in T
        along_{t} -= t_{k} * fit.{k}  #: for k in F
        fit.{t} = over_{t} * along_{t}


def slopes(w, model, fit):
    rows = model.rows
    left = 0.0
    by_{p} = 0.0  #: for p in P
    u_{p|q} = 0.0  #: for p, q in PP
    a_{p}_{k} = 0.0  #: for p in P for k in F
    t_{p} = 0.0  #: for t in T for p in P
    c_{p|q} = 0.0  #: for p, q in SECOND
    e_{p}_{k} = 0.0  #: for p in BENT for k in F
    f_{k} = fit.{k}  #: for k in F + T
    for i in range(w.size):
        (
            v_{k},  #: for k in F
            d_{p}_{k},  #: for p in P for k in F
        ) = read(model, i)
        rho = w[i]
        rho -= v_{k} * f_{k}  #: for k in F
        rho -= rows[{k.at}, i] * f_{k}  #: for k in T
        #: for p in P
            s_{p} = 0.0
            s_{p} += d_{p}_{k} * f_{k}  #: for k in F
            s_{p} += rows[{slope(k, p)}, i] * f_{k}  #: for k in T
            by_{p} += rho * s_{p}
        left += rho * rho
        u_{p|q} += s_{p} * s_{q}  #: for p, q in PP
        a_{p}_{k} += v_{k} * s_{p}  #: for p in P for k in F
        t_{p} += rows[{t.at}, i] * s_{p}  #: for t in T for p in P
        #: for p, q in SECOND
            bend = 0.0
            bend += rows[{second(k, p, q)}, i] * f_{k}  #: for k in F
            c_{p|q} -= rho * bend
        e_{p}_{k} += d_{p}_{k} * rho  #: for p in BENT for k in F
    #: for t in T
        over = 1.0 / fit.square_{t} if fit.square_{t} > 0.0 else 0.0
        u_{p|q} -= over * t_{p} * t_{q}  #: for p, q in PP
        a_{p}_{k} -= over * t_{p} * fit.t_{k}  #: for p in P for k in F
        fit.t_{p} = t_{p}  #: for p in P
    #: for p, q in SECOND
        c_{p|q} -= fit.i_{k|l} * e_{p}_{k} * (e_{q}_{l} - a_{q}_{l})  #: for k in F for l in F
        c_{p|q} += fit.i_{k|l} * a_{p}_{k} * e_{q}_{l}  #: for k in F for l in F
        fit.c_{p|q} = c_{p|q}
    fit.e_{p}_{k} = e_{p}_{k}  #: for p in BENT for k in F
    fit.left = left
    fit.by_{p} = by_{p}  #: for p in P
    fit.u_{p|q} = u_{p|q}  #: for p, q in PP
    fit.a_{p}_{k} = a_{p}_{k}  #: for p in P for k in F


def information(fit):
    #: for p in P for k in F
        f_{p}_{k} = 0.0
        f_{p}_{k} += fit.i_{k|l} * fit.a_{p}_{l}  #: for l in F
    #: for p, q in PP
        h_{p|q} = fit.u_{p|q}
        h_{p|q} -= f_{p}_{k} * fit.a_{q}_{k}  #: for k in F
    return Information(
        h_{p|q},  #: for p, q in PP
        f_{p}_{k},  #: for p in P for k in F
    )


def curved(fit, told):
    #: for p, q in SECOND
        h_{p|q} = told.{p|q} + fit.c_{p|q}
        e_{p|q} = h_{p|q}
    top = True
    #: for p in P
        top &= e_{p|p} > 1e-3 * told.{p|p}
        over = 1.0 / e_{p|p}
        #: for q in P[p.at + 1 :]
            e_{q|r} -= over * e_{p|q} * e_{p|r}  #: for r in P[q.at :]
    if not top:
        return told
    return Information(
        h_{p|q},  #: for p, q in PP
        told.f_{p}_{k},  #: for p in P for k in F
    )


def step(fit, told, damping, box):
    """A damped step within the box: what would leave it ends at its side, and the others are asked again."""
    more = 1.0 + damping
    #: for p in P
        low_{p}, high_{p} = fit.{p} <= box[{2 * p.at}], fit.{p} >= box[{2 * p.at + 1}]
        fixed_{p}, m_{p} = (low_{p} and fit.by_{p} <= 0.0) or (high_{p} and fit.by_{p} >= 0.0), 0.0
    for _ in range({len(P)}):
        e_{p|q} = told.{p|q}  #: for p, q in PP
        #: for p in P
            e_{p|p}, r_{p} = e_{p|p} * more + 1e-12 * fit.u_{p|p} + 1e-300, fit.by_{p}
        #: for p in P
            if fixed_{p}:
                r_{q} -= e_{p|q} * m_{p}  #: for q in P if q != p
                e_{p|q} = 0.0  #: for q in P if q != p
                e_{p|p}, r_{p} = 1.0, m_{p}
        #: for p in P
            #: for q in P[p.at + 1 :]
                ratio = e_{p|q} / e_{p|p}
                e_{q|r} -= ratio * e_{p|r}  #: for r in P[q.at :]
                r_{q} -= ratio * r_{p}
        inside = True
        #: for p in P[::-1]
            r_{p} -= e_{p|q} * r_{q}  #: for q in P[p.at + 1 :]
            r_{p} /= e_{p|p}
        #: for p in P
            if not fixed_{p}:
                to = fit.{p} + r_{p}
                m_{p} = r_{p}
                if not box[{2 * p.at}] <= to <= box[{2 * p.at + 1}]:
                    m_{p} = min(max(to, box[{2 * p.at}]), box[{2 * p.at + 1}]) - fit.{p}
                    fixed_{p}, inside = True, False
        if inside:
            break
    m_{p} = min(max(m_{p}, -{longest[p.name]}), {longest[p.name]})  #: for p in P if p.name in longest
    return At(
        m_{p},  #: for p in P
    )


def keep(fit, other):
    other.{name} = fit.{name}  #: for name in VALUES


def climb(w, model, cone, box, start, ending, fit, trial):
    to = At(
        min(max(start.{p}, box[{2 * p.at}]), box[{2 * p.at + 1}]),  #: for p in P
    )
    damping, last, told = 1e-5, False, information(fit)
    again = 1.0 if ending.tolerance > {THOROUGH} else 1e-3
    for turn in range(60):
        project(w, model, cone, to, trial)
        if turn == 0 or trial.explained > fit.explained:
            slopes(w, model, trial)
            keep(trial, fit)
            told = information(fit)
            damping = 0.1 * damping
        else:
            damping = max(10.0 * damping, again)
        if last:
            return
        move = step(fit, {"curved(fit, told)" if SECOND else "told"}, damping, box)
        gain, way, size = 0.0, 0.0, 0.0
        #: for p in P
            gain += abs(fit.by_{p} * move.{p})  # cut short at a side of the box, a part may fall
            way += abs(move.{p})
            size += told.{p|p}
        if not gain >= max(ending.tolerance, ending.straight * math.sqrt(size)) or way < ending.smallest:
            #: for k in F
                v_{k} = fit.{k}
                v_{k} -= told.f_{p}_{k} * move.{p}  #: for p in P
                v_{k} += fit.i_{k|l} * fit.e_{p}_{l} * move.{p}  #: for p in BENT for l in F
            if gain > 0.0 and fit.inside > 0.0 and admissible(
                v_{k},  #: for k in F
                cone.{c},  #: for c in CONE
            ):  # carried along, without a look
                #: for t in T
                    change = 0.0
                    change += fit.t_{p} * move.{p}  #: for p in P
                    change += fit.t_{k} * (v_{k} - fit.{k})  #: for k in F
                    fit.{t} -= change / fit.square_{t} if fit.square_{t} > 0.0 else 0.0
                fit.{k} = v_{k}  #: for k in F
                #: for p in P
                    fit.{p} += move.{p}
                    fit.by_{p} -= told.{p|q} * move.{q}  #: for q in P
                fit.explained += gain
                fit.left -= gain
                return
            if not {looks}:
                return
            last = True
        elif fit.explained + 4.0 * gain < ending.needed:
            return
        to = At(
            fit.{p} + move.{p},  #: for p in P
        )


def covariance(fit, cone, more, out):
    g_{k|l} = fit.g_{k|l}  #: for k, l in FF
    a_{p}_{k} = fit.a_{p}_{k}  #: for p in P for k in F
    #: for k in F[1:]
        if cone.friction == 0.0:  # there is no drag, and that is known
            g_{k|l} = 0.0  #: for l in F
            g_{k|k} = math.inf
            a_{p}_{k} = 0.0  #: for p in P
    #: for k in F
        over = 1.0 / max(g_{k|k}, 0.0)
        g_{l|j} -= over * g_{k|l} * g_{k|j}  #: for l, j in FF if k not in (l, j)
        g_{k|l} *= over  #: for l in F if l != k
        g_{k|k} = -over
    g_{k|l} = -g_{k|l}  #: for k, l in FF
    #: for p in P for k in F
        f_{p}_{k} = 0.0
        f_{p}_{k} += g_{k|l} * a_{p}_{l}  #: for l in F
    #: for p, q in PP
        h_{p|q} = fit.u_{p|q}
        h_{p|q} -= f_{p}_{k} * a_{q}_{k}  #: for k in F
    #: for k in P
        over = 1.0 / max(h_{k|k}, 0.0)
        h_{l|j} -= over * h_{k|l} * h_{k|j}  #: for l, j in PP if k not in (l, j)
        h_{k|l} *= over  #: for l in P if l != k
        h_{k|k} = -over
    h_{k|l} = -h_{k|l}  #: for k, l in PP
    h_{p|q} += more[{PP.index((p, q))}]  #: for p, q in PP
    #: for p in P for k in F
        s_{p}_{k} = 0.0
        s_{p}_{k} -= h_{p|q} * f_{q}_{k}  #: for q in P
    g_{k|l} -= s_{p}_{k} * f_{p}_{l}  #: for k, l in FF for p in P
    out[{entry(p, q)}] = h_{p|q}  #: for p, q in PP
    out[{entry(p, k)}] = s_{p}_{k}  #: for p in P for k in F
    out[{entry(k, l)}] = g_{k|l}  #: for k, l in FF
'''

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
    field: Any,
    components: int = 3,
    free: str = "",
    *,
    bent: bool = False,
    read: Any = None,
    looks: bool = True,
    **longest: float,
) -> Kernel:
    """The loops of a kind, made of one template; compiled when they are first called, and kept beside its module.

    Parameters
    ----------
    at : type
        A named tuple of the unknowns, at the top of the module of the kind.
    field : callable
        A compiled function `field(model, at)` that fills `model.rows`.
    components : int, optional
        F: 1 for N, 2 for (N, T), 3 for (N, Ty, Tz).
    free : str, optional
        Name of one more component, which nothing binds.
    bent : bool, optional
        Whether the field gives second slopes.
    read : callable, optional
        A compiled function `read(model, i)`, put in place of its calls, that gives the readings of sensor i under each
        component and their slopes, in the order of the rows, where a field has these in fewer numbers.
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
    lines = _written(
        _TEMPLATE.strip().split("\n"),
        {
            "F": f, "P": p, "T": t, "FF": ff, "PP": pp, "SECOND": pp if bent else [], "BENT": p if bent else [],
            "CONE": kept, "VALUES": values, "slope": slope, "second": second, "entry": entry, "longest": longest,
            "looks": looks, "THOROUGH": THOROUGH,
        },
    )  # fmt: skip
    made: dict[str, Any] = {
        "math": math, "field": field, "eliminate": eliminate, "admissible": admissible, "At": at, "Information": told,
        "__name__": home.__name__,
    }  # fmt: skip
    exec(compile("\n".join(lines), str(home.__file__), "exec"), made)
    for part in _PARTS:
        loop, inline = made[part], part in _INLINE
        loop.__qualname__ = f"{name}.{part}"  # by which Numba keeps it
        made[part] = read if part == "read" and read else compiled(inline=inline, borrows=not inline)(loop)
    fit = np.dtype((np.record, [(value, np.float64) for value in values]))  # whose parts plain Python reads by name too
    return Kernel(fit, *(made[part] for part in Kernel._fields[1:]))


_PARTS = ("read", "project", "slopes", "information", "curved", "step", "keep", "climb", "covariance")
"""Each after those that it calls."""
_INLINE = {"read", "information", "curved", "step", "keep"}


def _written(lines: Sequence[str], said: dict[str, Any]) -> Iterator[str]:
    """The lines of a template, written out.

    A line that ends with `#: for ...` stands once for each, and so do the lines that are further in than one that is
    nothing else. What is in braces is reckoned out.
    """
    at = 0
    while at < len(lines):
        line, _, over = lines[at].partition("#: ")
        at += 1
        begin = at
        while over and not line.strip() and at < len(lines) and lines[at].startswith(" " * (len(line) + 4)):
            at += 1
        for each in _each(over, said) if over else ({},):
            known = {**said, **each}
            if at > begin:
                yield from _written([inner[4:] for inner in lines[begin:at]], known)
            else:
                yield _BRACED.sub(lambda found, known=known: str(_value(found[1], known)), line.rstrip())  # type: ignore[misc]


def _each(over: str, said: dict[str, Any]) -> list[dict[str, Any]]:
    """What the names of `for ... in ...` stand for, in turn."""
    names = [name.strip() for part in _NAMED.findall(over) for name in part.split(",")]
    return list(_value(f"[dict({', '.join(f'{name}={name}' for name in names)}) {over}]", said))


_BRACED, _NAMED = re.compile(r"\{([^{}]+)\}"), re.compile(r"for ([\w, ]+?) in ")
_compiled = cache(lambda expression: compile(expression, "<template>", "eval"))


def _value(expression: str, said: dict[str, Any]) -> Any:
    return eval(_compiled(expression), dict(said))
