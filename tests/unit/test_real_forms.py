"""Real forms of fields: pure functions that any array namespace can run, and nothing else worked out for a reading."""

import math
from types import SimpleNamespace

import numba as nb
import numpy as np
import pytest

import subskin as ss
from subskin._compiled import formula
from subskin.contact import kernels
from subskin.skin._riesz import DeferredStrain

SOFT = ss.Material(0.4e6, 0.4)
LOAD = {"components": (1.2, 0.3, -0.4), "position": (0.4e-3, -0.9e-3)}
SHAPES = {
    "point": ss.PointLoad(**LOAD),
    "patch": ss.Patch(**LOAD, half_widths=(1e-3, 0.4e-3)),
    "round hertz": ss.RoundHertz(**LOAD, half_width=1.2e-3),
    "round punch": ss.RoundPunch(**LOAD, half_width=1.2e-3),
    "cone": ss.Cone(**LOAD, half_width=1.2e-3),
}
FLOATS = SimpleNamespace(
    **{name: getattr(math, name) for name in ("sqrt", "atan2", "asinh", "log")},
    abs=abs,
    maximum=max,
    where=lambda this, then, other: then if this else other,
)
"""As much of an array namespace as the forms may use, of single numbers."""

Y, Z = (np.array(v) for v in ([-3e-3, 0.0, 0.5e-3, 31e-3, 45e-3], [1e-3, 0.0, -0.7e-3, -2e-3, 30e-3]))


@pytest.mark.parametrize("shape", SHAPES)
def test_forms_run_on_single_numbers(shape):
    """No namespace but the one they are given, and no arrays: what JAX traces and Numba compiles."""
    contact, x = SHAPES[shape], 2e-3
    form, load = contact.real_form(), contact.components
    sizes = [float(size) for size in form.sizes]
    at = (Y - contact.position[0])[:3], (Z - contact.position[1])[:3]  # far away they would cancel
    whole = form.parts(np, (0, 1), x, *at, *load[1:], *form.sizes)
    each = [form.parts(FLOATS, (0, 1), x, float(y), float(z), *map(float, load[1:]), *sizes) for y, z in zip(*at)]
    np.testing.assert_allclose(np.moveaxis(whole, -1, 0), each, rtol=1e-12)


@pytest.mark.parametrize("disc", [kernels.hertz_disc, kernels.punch_disc, kernels.cone_disc])
def test_numba_runs_the_same_lines(disc):
    inner = formula(disc)

    @nb.njit
    def both(x, r2):
        return inner(np, (0, 1), x, r2)

    for x, r2 in ((0.3, 0.2), (1.7, 0.4), (0.1, 2.3)):
        np.testing.assert_allclose(both(x, r2), disc(np, (0, 1), np.array(x), np.array(r2)), rtol=1e-12)


@pytest.mark.parametrize("shape", SHAPES)
def test_near_and_far_forms_meet(shape):
    contact = SHAPES[shape]
    form = contact.real_form()
    if form.parts_far is None:
        assert form.far is None
        return
    away = 1.01 * float(form.far)
    near, far = (
        np.array(parts(np, (0, 1), 0.5 * away, 0.8 * away, 0.3 * away, 0.3, -0.4, *form.sizes))
        for parts in (form.parts, form.parts_far)
    )
    np.testing.assert_allclose(near, far, rtol=1e-11)


@pytest.mark.parametrize("shape", SHAPES)
def test_a_component_alone_is_that_of_the_tensor(shape):
    felt = ss.HalfSpace(SOFT).state(SHAPES[shape], 2e-3, Y, Z)
    assert isinstance(felt.strain, DeferredStrain)
    alone = felt.strain.xx, felt.stress.xx, felt.stress.trace, felt.strain.trace
    assert "_all" not in vars(felt.strain)
    assert "_all" not in vars(felt.stress)
    strain, stress = felt.strain._all, felt.stress._all
    for one, other in zip(alone, (strain.xx, stress.xx, stress.trace, strain.trace), strict=True):
        np.testing.assert_allclose(one, other, rtol=1e-10, atol=1e-14 * np.abs(other).max())


@pytest.mark.parametrize("shape", ["patch", "round hertz", "round punch", "cone"])
@pytest.mark.parametrize("away", [(0.3, 0.2, 0.1), (1.0, 0.3, 0.2), (1.0, 1.9, -0.4), (3.0, 1.0, 1.0)])
def test_forms_are_sums_of_point_loads(shape, away):
    """The pressure alone says what they have to be: by quadrature of Boussinesq's and Cerruti's fields."""
    a = 1.2e-3
    contact = SHAPES[shape].altered(components=np.array([1.0, 0.3, -0.4]), position=np.zeros(2))
    u, weight = np.polynomial.legendre.leggauss(60)
    if shape == "patch":
        y, z = np.meshgrid(1e-3 * u, 0.4e-3 * u)
        area = np.outer(weight, weight) * 0.4e-6
    else:  # r = a sin(psi), crowded to the middle, takes the root at the rim and the logarithm at the tip
        v, turn = 0.5 * (1 + u), 2 * np.pi * np.arange(80) / 80
        psi = 0.5 * np.pi * v**3
        r, dr = a * np.sin(psi), a * np.cos(psi) * 1.5 * np.pi * v**2 * 0.5 * weight
        y, z = r[:, None] * np.cos(turn), r[:, None] * np.sin(turn)
        area = np.broadcast_to((r * dr)[:, None] * (2 * np.pi / 80), y.shape)
    share = (contact.pressure(y, z) * area).reshape(-1)
    points = ss.PointLoad(components=share[:, None] * contact.components, position=np.stack([y, z], -1).reshape(-1, 2))
    skin, at = ss.HalfSpace(SOFT), tuple(a * one for one in away)
    one, many = skin.state(contact, *at), skin.state(points, *at)
    for tensor in ("stress", "strain"):
        whole = getattr(many, tensor)
        size = float(np.abs(whole._all.matrix.sum(axis=0)).max())
        assert float(getattr(one, tensor).xx) == pytest.approx(whole.xx.sum(), abs=1e-7 * size)
        assert float(getattr(one, tensor).trace) == pytest.approx(whole.trace.sum(), abs=1e-7 * size)


def test_blocks_of_a_batch_are_the_batch():
    """A batch is worked out block by block; each contact reads what it reads alone."""
    finger = ss.Finger(ss.HalfSpace(SOFT), ss.SensorArray.grid(shape=(16, 16), pitch=2e-3, depth=2e-3))
    at = np.random.default_rng(0).uniform(-15e-3, 15e-3, (37, 2))
    wide = np.linspace(0.2e-3, 3e-3, 37)[:, None] * (1.0, 0.4)
    together = finger.read(ss.Patch(1.0, 0.4, 0.2, at, wide))
    for k in (0, 18, 36):
        np.testing.assert_array_equal(together[k], finger.read(ss.Patch(1.0, 0.4, 0.2, at[k], wide[k])))


def test_a_state_travels_with_its_components():
    import pickle

    felt = ss.HalfSpace(SOFT).state(SHAPES["patch"], 2e-3, Y, Z)
    back = pickle.loads(pickle.dumps(felt))
    np.testing.assert_array_equal(back.strain.matrix, felt.strain.matrix)
    assert not felt.strain.xx.flags.writeable
