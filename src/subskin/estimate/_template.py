"""The text of the loops of a kind (`varpro.kernel`), and how it is written out for so many components and unknowns."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from functools import cache
from typing import Any

__all__ = ["written"]

_TEMPLATE = '''
def where(model, at):
    return 0


def read(model, here, i):
    rows = model.rows
    return (
        rows[{k.at}, i],  #: for k in F
        rows[{slope(k, p)}, i],  #: for p in P for k in F
        rows[{second(k, p, q)}, i],  #: for p, q in SECOND for k in F
    )


def project(w, model, cone, at, fit):
    field(model, at)  #: for _ in FIELD
    here = where(model, at)
    rows = model.rows  #: for t in T
    g_{k|l} = 0.0  #: for k, l in FF
    b_{k} = 0.0  #: for k in F
    for i in range(w.size):
        (
            v_{k},  #: for k in F
            d_{p}_{k},  #: for p in P for k in F
            r_{p|q}_{k},  #: for p, q in SECOND for k in F
        ) = read(model, here, i)
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
    at = At(
        fit.{p},  #: for p in P
    )
    here = where(model, at)
    rows = model.rows  #: for t in T
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
            r_{p|q}_{k},  #: for p, q in SECOND for k in F
        ) = read(model, here, i)
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
            bend += r_{p|q}_{k} * f_{k}  #: for k in F
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
    best, other, moved = trial, fit, True
    for turn in range(60):
        project(w, model, cone, to, other)
        if turn == 0 or other.explained > best.explained:
            slopes(w, model, other)
            best, other, moved = other, best, not moved
            told = information(best)
            damping = 0.1 * damping
        else:
            damping = max(10.0 * damping, again)
        if last:
            break
        move = step(best, {"curved(best, told)" if SECOND else "told"}, damping, box)
        gain, way, size = 0.0, 0.0, 0.0
        #: for p in P
            gain += abs(best.by_{p} * move.{p})  # cut short at a side of the box, a part may fall
            way += abs(move.{p})
            size += told.{p|p}
        if not gain >= max(ending.tolerance, ending.straight * math.sqrt(size)) or way < ending.smallest:
            #: for k in F
                v_{k} = best.{k}
                v_{k} -= told.f_{p}_{k} * move.{p}  #: for p in P
                v_{k} += best.i_{k|l} * best.e_{p}_{l} * move.{p}  #: for p in BENT for l in F
            if gain > 0.0 and best.inside > 0.0 and admissible(
                v_{k},  #: for k in F
                cone.{c},  #: for c in CONE
            ):  # carried along, without a look
                #: for t in T
                    change = 0.0
                    change += best.t_{p} * move.{p}  #: for p in P
                    change += best.t_{k} * (v_{k} - best.{k})  #: for k in F
                    best.{t} -= change / best.square_{t} if best.square_{t} > 0.0 else 0.0
                best.{k} = v_{k}  #: for k in F
                #: for p in P
                    best.{p} += move.{p}
                    best.by_{p} -= told.{p|q} * move.{q}  #: for q in P
                best.explained += gain
                best.left -= gain
                break
            if not {looks} or ending.tolerance > {ROUGH}:
                break
            last = True
        elif best.explained + 4.0 * gain < ending.needed:
            break
        to = At(
            best.{p} + move.{p},  #: for p in P
        )
    if moved:
        keep(best, fit)


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


def written(said: dict[str, Any]) -> Iterator[str]:
    """The lines of the loops; said: what its names stand for."""
    return _written(_TEMPLATE.strip().split("\n"), said)


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
