"""The one fitting kernel, of one to three components and one to five unknowns, against differences and brute force."""

from __future__ import annotations

import os
import subprocess
import sys
from typing import NamedTuple

import numpy as np
import pytest
from scipy.optimize import minimize, nnls

from subskin.estimate import varpro
from subskin.estimate.varpro import Ending, Limits

SENSORS = 12
UNKNOWNS = [NamedTuple(f"Of{p}", [(name, float) for name in "yzqrs"[:p]]) for p in range(1, 6)]
SHAPES = [(f, p) for f in (1, 2, 3) for p in (1, 2, 3, 4, 5)]


class Model(NamedTuple):
    """Waves: component k at sensor i reads cos(phase + rate x); rows as a kernel wants them."""

    phase: np.ndarray
    rate: np.ndarray
    rows: np.ndarray
    free: bool = False


def waves(model, at):
    """Readings under each component, slopes, under a free one, its slopes, and second slopes."""
    f, rate, rows, row = len(model.phase) - 1, model.rate, model.rows, 0
    phase = model.phase + np.asarray(at) @ rate
    value, slope = np.cos(phase), -np.sin(phase)[:, None] * rate  # (f + 1, n), (f + 1, p, n)
    second = [-value[:f] * one * other for j, one in enumerate(rate) for other in rate[j:]]
    free = [value[f:], *slope[f:].swapaxes(0, 1)] if model.free else []
    for part in (value[:f], *slope[:f].swapaxes(0, 1), *free, *second):
        rows[row : row + len(part)] = part
        row += len(part)


@pytest.fixture
def made(monkeypatch):
    """Loops in plain Python, their model, a fit and a trial, random numbers, and the type of a point."""
    monkeypatch.setattr(varpro, "compiled", lambda **_: lambda function: function)

    def make(f, p, free="", **options):
        loops, rng = varpro.kernel(UNKNOWNS[p - 1], waves, f, free, **options), np.random.default_rng(10 * f + p)
        rows = np.zeros(((f + bool(free)) * (1 + p) + f * p * (p + 1) // 2, SENSORS))
        model = Model(rng.uniform(0, 6, (f + 1, SENSORS)), rng.uniform(-1, 1, (p, SENSORS)), rows, bool(free))
        return loops, model, *np.zeros(2, loops.fit).view(np.recarray), rng, UNKNOWNS[p - 1]

    return make


def components(fit):
    """Those of a fit, in order."""
    return np.array([fit[name] for name in ("n", "t", "ty", "tz") if name in fit.dtype.names])


def square(fit, prefix, names):
    """A symmetrical matrix of a fit's fields."""
    pick = [[f"{prefix}_{min(i, j, key=names.index)}_{max(i, j, key=names.index)}" for i in names] for j in names]
    return np.array([[fit[name] for name in row] for row in pick])


def rays(f, friction):
    """Forces that press within the cone are sums of these with shares >= 0."""
    if friction == np.inf:
        sides = np.eye(f)[1:]
        return np.concatenate([np.eye(f)[:1], sides, -sides])
    turn = [0, np.pi] if f < 3 else np.linspace(0, 2 * np.pi, 2000)
    return np.stack([np.ones(len(turn)), friction * np.cos(turn), friction * np.sin(turn)], axis=-1)[:, :f]


@pytest.mark.parametrize("friction", [0.0, 0.4, np.inf])
@pytest.mark.parametrize("f", [1, 2, 3])
def test_components_are_the_best_in_the_cone(f, friction, made):
    loops, model, fit, _, rng, at = made(f, 2)
    inside = set()
    for _ in range(40):
        w = rng.normal(size=SENSORS)
        loops.project(w, model, Limits(friction), at(*rng.uniform(-1, 1, 2)), fit)
        a, found = model.rows[:f].T, components(fit)
        left = nnls(a @ rays(f, friction).T, w)[1] ** 2
        assert w @ w - fit.explained == pytest.approx(left, rel=1e-5)
        assert ((w - a @ found) ** 2).sum() == pytest.approx(w @ w - fit.explained, rel=1e-9)
        assert found[0] >= 0
        assert f == 1 or friction == np.inf or np.linalg.norm(found[1:]) <= friction * found[0] * (1 + 1e-9)
        inside.add(fit.inside)
    assert inside == {0.0, 1.0} or (f == 3 and friction == 0.0)


@pytest.mark.parametrize("ends", [(0.5, np.inf), (0.0, 0.3), (0.2, 0.6), (0.4, 0.4)])
@pytest.mark.parametrize("f", [1, 2])
def test_a_force_between_its_ends(f, ends, made):
    loops, model, fit, _, rng, at = made(f, 2)
    low, high = ends[0], min(ends[1], 3.0)
    corners = np.array([[n, side * 0.5 * n][:f] for n in (low, high) for side in (-1, 1)])
    for _ in range(30):
        w = rng.normal(size=SENSORS)
        loops.project(w, model, Limits(0.5, *ends), at(*rng.uniform(-1, 1, 2)), fit)
        # of what these corners span, shares adding up to one: a heavy row says so
        a = np.vstack([model.rows[:f].T @ corners.T, np.full(4, 1e4)])
        shares, _ = nnls(a, np.append(w, 1e4))
        best = ((w - model.rows[:f].T @ corners.T @ shares) ** 2).sum()
        assert w @ w - fit.explained == pytest.approx(best, rel=1e-5)
        assert low <= fit.n <= ends[1]


@pytest.mark.parametrize("friction", [0.3, np.inf])
@pytest.mark.parametrize(("f", "p"), SHAPES)
def test_slopes_are_those_of_what_is_explained(f, p, friction, made):
    loops, model, fit, trial, rng, at = made(f, p, bent=True)
    cone, h = Limits(friction), 1e-4
    for _ in range(3):
        x, w = rng.uniform(-1, 1, p), rng.normal(size=SENSORS) + 2.0

        def explained(x, w=w):
            loops.project(w, model, cone, at(*x), trial)
            return 0.5 * trial.explained

        loops.project(w, model, cone, at(*x), fit)
        if f == 3 and not fit.inside:
            continue  # on a curved cone the second slopes are more than these
        loops.slopes(w, model, fit)
        told, names = loops.information(fit), list(at._fields)
        steps = h * np.eye(p)
        slope = [(explained(x + s) - explained(x - s)) / (2 * h) for s in steps]
        assert np.allclose([fit[f"by_{name}"] for name in names], slope, atol=1e-6)
        loops.project(w, model, cone, at(*x), fit)
        rows, value = model.rows.copy(), components(fit)
        slopes = np.array([value @ rows[f * (1 + j) : f * (2 + j)] for j in range(p)])
        assert np.allclose(square(fit, "u", names), slopes @ slopes.T)
        inverse = square(fit, "i", [n for n in ("n", "t", "ty", "tz") if n in fit.dtype.names])
        across = rows[:f] @ slopes.T
        assert np.allclose(loops_square(told, names), slopes @ slopes.T - across.T @ inverse @ across)
        second = [
            [
                (explained(x + s + t) - explained(x + s - t) - explained(x - s + t) + explained(x - s - t))
                / (4 * h * h)
                for s in steps
            ]
            for t in steps
        ]
        assert np.allclose(loops_square(told, names) + square(fit, "c", names), -np.array(second), atol=2e-5 * SENSORS)


def loops_square(told, names):
    """The information as a matrix."""
    return np.array([[getattr(told, "_".join(sorted((i, j), key=names.index))) for i in names] for j in names])


@pytest.mark.parametrize("free", ["", "m"])
@pytest.mark.parametrize(("f", "p"), SHAPES)
def test_a_climb_ends_at_the_top_within_the_box(f, p, free, made):
    loops, model, fit, trial, rng, at = made(f, p, free)
    truth = rng.uniform(-0.3, 0.3, p)
    waves(model, truth)
    force, cone = np.array([2.0, 0.3, -0.4])[:f], Limits(0.7)
    w = force @ model.rows[:f] + 0.02 * rng.normal(size=SENSORS)
    if free:
        w += 0.5 * model.rows[f * (1 + p)]

    def left(x):
        loops.project(w, model, cone, at(*x), trial)
        return w @ w - trial.explained

    for half in (1.0, 0.2):  # the second box holds some of the truth out
        ends = np.repeat([[-half, half]], p, axis=0)
        loops.climb(
            w, model, cone, ends.reshape(-1), at(*np.clip(truth + 0.05, -half, half)), Ending(1e-10), fit, trial
        )
        found = [fit[name] for name in at._fields]
        best = minimize(left, found, bounds=ends, method="L-BFGS-B", options={"ftol": 1e-15, "gtol": 1e-9})
        assert (np.abs(found) <= half).all()
        assert left(found) <= best.fun * (1 + 1e-6)
        assert fit.left == pytest.approx(left(found), rel=1e-5)


@pytest.mark.parametrize(("f", "p"), SHAPES)
def test_the_covariance_is_the_inverse_of_all_the_information(f, p, made):
    loops, model, fit, _, rng, at = made(f, p)
    loops.project(rng.normal(size=SENSORS), model, Limits(np.inf), at(*rng.uniform(-1, 1, p)), fit)
    for k, name in enumerate(("n", *(("t",) if f == 2 else ("ty", "tz")))[:f]):
        fit[name] = 1.0 + k
    loops.slopes(rng.normal(size=SENSORS), model, fit)
    jacobian = np.concatenate(
        [[components(fit) @ model.rows[f * (1 + j) : f * (2 + j)] for j in range(p)], model.rows[:f]]
    )
    wanted, size = np.linalg.inv(jacobian @ jacobian.T), f + p
    out, more = np.zeros(size * (size + 1) // 2), np.zeros(p * (p + 1) // 2)
    loops.covariance(fit, Limits(1.0), more, out)
    assert np.allclose(out, wanted[np.triu_indices(size)], rtol=1e-6)
    loops.covariance(fit, Limits(0.0), more, out)  # a drag that is known to be 0
    kept = np.arange(size) <= p
    wanted = np.zeros((size, size))
    wanted[np.ix_(kept, kept)] = np.linalg.inv(jacobian[kept] @ jacobian[kept].T)
    assert np.allclose(out, wanted[np.triu_indices(size)], rtol=1e-6)


CHILD = """
import {module} as kind
found, stats = kind.run(), kind.LOOPS.project.stats
print(found, sum(stats.cache_hits.values()), sum(stats.cache_misses.values()))
"""
MODULE = """
from typing import NamedTuple
import numpy as np
from subskin._compiled import compiled
from subskin.estimate import varpro

class At(NamedTuple):
    y: float

class Model(NamedTuple):
    rows: np.ndarray

@compiled()
def field(model, at):
    for i in range(model.rows.shape[1]):
        model.rows[0, i], model.rows[1, i] = np.cos(i * at.y), -i * np.sin(i * at.y)

LOOPS = varpro.kernel(At, field, 1)

def run():
    fits = np.zeros(1, LOOPS.fit)
    w, rows = 3.0 * np.cos(0.3 * np.arange(6.0)), np.zeros((2, 6))
    LOOPS.project(w, Model(rows), varpro.Limits(1.0), At(0.3), fits[0])
    return round(float(fits[0]["n"]), 6)
"""


def test_made_loops_are_kept_until_what_they_are_made_of_changes(tmp_path):
    """Compiled by one process, kept for the next; made anew when the field, or the template, is another one."""
    file = tmp_path / "kind_of_a_test.py"
    file.write_text(MODULE)
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join([str(tmp_path), *sys.path]), "NUMBA_CACHE_DIR": ""}
    environment["PYTHONDONTWRITEBYTECODE"] = "1"

    def told(before=""):
        code = before + CHILD.format(module=file.stem)
        run = subprocess.run([sys.executable, "-c", code], env=environment, capture_output=True, text=True, check=True)
        return run.stdout.split()

    assert told() == ["3.0", "0", "1"]
    assert told() == ["3.0", "1", "0"]
    change = "import subskin.estimate._template as v; v._TEMPLATE = v._TEMPLATE.replace('taken = 0.0', 'taken = 0.1');"
    assert told(change) == ["3.0", "0", "1"]
    file.write_text(MODULE.replace("np.cos(i * at.y), -i", "0.5 * np.cos(i * at.y), -0.5 * i"))
    assert told() == ["6.0", "0", "1"]
