"""Readers of NumPy, JAX and PyTorch against `Finger.read`, each other, and differences."""

from __future__ import annotations

import subprocess
import sys
from dataclasses import replace

import numpy as np
import pytest

import subskin as ss
from subskin.errors import InvalidValueError
from subskin.faults import SensorFaults
from subskin.transducer import ShearStrain

COUNT = 40
RUBBER = ss.Material(0.4e6, 0.45)
PAD = ss.Finger(ss.HalfSpace(RUBBER), ss.SensorArray.grid((3, 4), 3e-3, 3e-3, gain=2.0, offset=0.1))
ROW = ss.Finger(ss.HalfPlane(RUBBER), ss.SensorArray.line(6, 1.5e-3, 2e-3, gain=2.0, offset=0.1))
LAYER = ss.Layered(ss.Layer(RUBBER, 6e-3))
LOCAL = {
    "point": (ss.PointLoad, ""), "patch": (ss.Patch, "half_widths"), "round_hertz": (ss.RoundHertz, "half_width"),
    "round_punch": (ss.RoundPunch, "half_width"), "cone": (ss.Cone, "half_width"),
}  # fmt: skip
LONG = {
    "line": (ss.LineLoad, ""), "hertz": (ss.Hertz, "half_width"), "strip": (ss.Strip, "half_width"),
    "punch": (ss.FlatPunch, "half_width"), "wedge": (ss.Wedge, "half_width"),
}  # fmt: skip
KINDS = (ss.NormalStrain(), ss.NormalStress(), ss.MeanPressure())


def loads_of(name, rng, far=20.0):
    """Loads as mappings of arrays, some far away, and the contacts that they are."""
    parts = rng.standard_normal((COUNT, 3)) + np.array([2.0, 0.0, 0.0])
    at, size = rng.uniform(-8e-3, 8e-3, (COUNT, 2)), rng.uniform(0.3e-3, 4e-3, (COUNT, 2))
    at[::8] *= far
    if name in LOCAL:
        kind, sizes = LOCAL[name]
        more = {sizes: size if name == "patch" else size[:, 0]} if sizes else {}
        return {"components": parts, "position": at, **more}, kind(components=parts, position=at, **more)
    kind, sizes = LONG[name]
    more = {sizes: size[:, 0]} if sizes else {}
    force, angle = np.hypot(parts[:, 0], parts[:, 1]), np.arctan2(parts[:, 1], parts[:, 0])
    contact = kind(force=force, angle=angle, position=at[:, 0], **more)
    return {"components": parts[:, :2], "position": at[:, 0], **more}, contact


def library(name):
    """How an array goes in, and how it comes out."""
    if name == "numpy":
        return np.asarray, np.asarray
    if name == "jax":
        jax = pytest.importorskip("jax")
        jax.config.update("jax_enable_x64", True)
        return jax.numpy.asarray, np.asarray
    torch = pytest.importorskip("torch")
    torch.set_default_dtype(torch.float64)
    return torch.tensor, lambda v: v.detach().numpy()


def finger_of(name, kind):
    drawn = PAD if name in LOCAL else ROW
    return replace(drawn, array=replace(drawn.array, transducer=kind))


@pytest.mark.parametrize("lib", ["numpy", "jax", "torch"])
@pytest.mark.parametrize("name", [*LOCAL, *LONG])
def test_readings_are_those_of_the_finger(name, lib):
    given, out = library(lib)
    loads, contact = loads_of(name, np.random.default_rng(1))
    for kind in KINDS:
        finger = finger_of(name, kind)
        wanted = finger.read(contact)
        found = out(finger.reader(lib, contact=name)({k: given(v) for k, v in loads.items()}))
        np.testing.assert_allclose(found, wanted, rtol=0, atol=1e-12 * np.abs(wanted - 0.1).max())


@pytest.mark.parametrize("name", ["patch", "round_hertz", "cone", "hertz", "strip"])
def test_far_loads_keep_their_digits(name):
    """Hundreds of half widths away, where closed forms cancel, to digits of their own small readings."""
    parts = np.array([1.0, 0.3, 0.2])
    sizes = {"half_widths": np.array([0.3e-3, 0.4e-3])} if name == "patch" else {"half_width": np.array(0.3e-3)}
    if name in LOCAL:
        loads = {"components": parts, "position": np.array([0.12, 0.05]), **sizes}
        contact = LOCAL[name][0](**loads)
    else:
        loads = {"components": parts[:2], "position": np.array(0.15), **sizes}
        force, angle = np.hypot(1.0, 0.3), np.arctan2(0.3, 1.0)
        contact = LONG[name][0](force=force, angle=angle, position=0.15, half_width=0.3e-3)
    finger = finger_of(name, ss.NormalStrain())
    finger = replace(finger, array=replace(finger.array, offset=0.0))
    np.testing.assert_allclose(finger.reader(contact=name)(loads), finger.read(contact), rtol=1e-10)


@pytest.mark.parametrize("lib", ["numpy", "jax", "torch"])
def test_tables_are_those_of_the_finger(lib):
    """Layers, sensors of shear, and a round finger: of point and of line loads."""
    given, out = library(lib)
    area = ss.Finger(LAYER, ss.SensorArray.grid((3, 3), 3e-3, 3e-3, transducer=ShearStrain("xz"), gain=2.0, offset=0.1))
    row = ss.Finger(LAYER, ss.SensorArray.line(6, 1.5e-3, 2e-3, gain=2.0, offset=0.1))
    about = ss.Finger(ss.Round(RUBBER, 5e-3, 2.5e-3), ss.SensorArray.line(6, 1.5e-3, 1.5e-3, gain=2.0, offset=0.1))
    for finger, name in ((area, "point"), (row, "line"), (about, "line")):
        loads, contact = loads_of(name, np.random.default_rng(2), far=1.0)
        read = finger.reader(lib, contact=name)
        assert read.skin == {}
        found = out(read({k: given(v) for k, v in loads.items()}))
        wanted = finger.read(contact)
        np.testing.assert_allclose(found, wanted, rtol=0, atol=1e-6 * np.abs(wanted - 0.1).max())


def gradients(lib, finger, name, loads, weights):
    """Of the weighed sum of readings by loads, sensors and skin."""
    given, out = library(lib)
    read, at = finger.reader(lib, contact=name), {k: given(v) for k, v in loads.items()}
    if lib == "jax":
        import jax

        def value(*parts):
            return (weights * read(*parts)).sum()

        found = jax.jit(jax.grad(value, argnums=(0, 1, 2)))(at, read.sensors, read.skin)
        return [{k: out(v) for k, v in part.items()} for part in found]
    parts = [{k: v.clone().requires_grad_() for k, v in part.items()} for part in (at, read.sensors, read.skin)]
    (given(weights) * read(*parts)).sum().backward()
    return [{k: v.grad.numpy() for k, v in part.items()} for part in parts]


@pytest.mark.parametrize("lib", ["jax", "torch"])
@pytest.mark.parametrize("name", [*LOCAL, *LONG])
def test_gradients_are_those_of_differences(name, lib):
    rng = np.random.default_rng(3)
    loads, _ = loads_of(name, rng)
    finger = finger_of(name, ss.NormalStrain())
    read = finger.reader(contact=name)
    weights = rng.standard_normal((COUNT, len(finger.array)))
    found = gradients(lib, finger, name, loads, weights)
    parts = [loads, read.sensors, read.skin]
    for index, part in enumerate(parts):
        for key, values in part.items():
            way = rng.standard_normal(np.shape(values))
            h = 1e-4 * float(np.abs(values).min() if np.ndim(values) else abs(values))
            h = max(h, 1e-8 if key != "components" else 1e-4)

            def at(t, index=index, key=key, values=values, way=way):
                moved = [dict(p) for p in parts]
                moved[index][key] = values + t * way
                return (weights * read(*moved)).sum()

            slope = (8 * (at(h) - at(-h)) - (at(2 * h) - at(-2 * h))) / (12 * h)
            size = np.abs(found[index][key] * way).sum()
            assert (found[index][key] * way).sum() == pytest.approx(slope, abs=1e-7 * size + 1e-9 * abs(slope))


@pytest.mark.parametrize("name", [*LOCAL, *LONG])
def test_gradients_of_both_libraries_are_the_same(name):
    pytest.importorskip("torch")
    rng = np.random.default_rng(4)
    loads, _ = loads_of(name, rng)
    finger = finger_of(name, ss.NormalStrain())
    weights = rng.standard_normal((COUNT, len(finger.array)))
    one, two = (gradients(lib, finger, name, loads, weights) for lib in ("jax", "torch"))
    for here, there in zip(one, two, strict=True):
        for key, values in here.items():
            np.testing.assert_allclose(values, there[key], rtol=0, atol=1e-12 * np.abs(values).max())


def test_sensors_of_several_kinds_and_a_thin_slice():
    array = replace(ROW.array, transducer=[KINDS[i % 3] for i in range(6)])
    finger = ss.Finger(ss.HalfPlane(RUBBER, plane="stress"), array)
    loads, contact = loads_of("hertz", np.random.default_rng(5))
    wanted = finger.read(contact)
    np.testing.assert_allclose(finger.reader(contact="hertz")(loads), wanted, rtol=1e-11)


@pytest.mark.parametrize("transducer", [ss.NormalStrain(), ss.MaxCompressiveStrain(), ss.EnergyDensity()])
def test_loads_that_press_at_once(transducer):
    """A batch summed over an axis is the sum of contacts, of sensors that are not linear too."""
    lift = 0.5 if transducer.linear else 0.0
    array = replace(PAD.array, transducer=transducer, lift=lift)
    finger, rng = replace(PAD, array=array), np.random.default_rng(6)
    parts, at = rng.standard_normal((4, 3, 3)) + np.array([2.0, 0.0, 0.0]), rng.uniform(-5e-3, 5e-3, (4, 3, 2))
    found = finger.read(ss.PointLoad(components=parts, position=at), sum_over=1)
    for frame, (some, there) in enumerate(zip(parts, at, strict=True)):
        points = [ss.PointLoad(components=c, position=p) for c, p in zip(some, there, strict=True)]
        np.testing.assert_allclose(found[frame], finger.read(points[0] + points[1] + points[2]), rtol=1e-12)
    np.testing.assert_array_equal(finger.read(ss.PointLoad(components=parts, position=at), sum_over=-1), found)
    if transducer.linear:
        plain = replace(finger, array=replace(array, lift=0.0))
        many = plain.reader()({"components": parts, "position": at}, sum_over=1)
        np.testing.assert_allclose(
            many, plain.read(ss.PointLoad(components=parts, position=at), sum_over=1), rtol=1e-12
        )


def test_a_sum_needs_an_axis():
    many = ss.PointLoad(components=[[1.0, 0.0, 0.0]], position=(0.0, 0.0))
    with pytest.raises(InvalidValueError, match="sum_over"):
        PAD.read(many, sum_over=1)
    with pytest.raises(ss.errors.GeometryError, match="single contact"):
        PAD.read(ss.PointLoad(force=1.0), sum_over=0)


@pytest.mark.parametrize("lib", ["numpy", "jax", "torch"])
def test_what_rubber_forgets_is_that_of_the_stream(lib):
    given, out = library(lib)
    t = np.sort(np.random.default_rng(7).uniform(0.0, 5.0, 30))
    loads = {"components": np.stack([40 * np.sin(t) ** 2, 0 * t], axis=-1), "position": 0.5e-3 + 0 * t}
    faults = SensorFaults(share=[0.1, 0.2], time=[0.5, 3.0])
    found = out(ROW.reader(lib)({k: given(v) for k, v in loads.items()}, faults=faults, times=given(t)))
    wanted = ss.Relaxation([0.1, 0.2], [0.5, 3.0], rest=0.1).apply(ROW.reader()(loads), t)
    np.testing.assert_allclose(found, wanted, rtol=1e-12)


def key_of(lib, seed):
    if lib == "numpy":
        return np.random.default_rng(seed)
    if lib == "jax":
        import jax

        return jax.random.key(seed)
    import torch

    return torch.Generator().manual_seed(seed)


@pytest.mark.parametrize("lib", ["numpy", "jax", "torch"])
def test_random_faults_have_their_sizes(lib):
    given, out = library(lib)
    read, still = PAD.reader(lib), {"components": given(np.zeros((400, 3))), "position": given(np.zeros((400, 2)))}
    loads = {"components": given(np.tile([2.0, 0.3, 0.0], (400, 1))), "position": given(np.zeros((400, 2)))}
    plain = out(read(loads))

    def spread(what, **faults):
        return np.stack([out(read(what, faults=SensorFaults(**faults), key=key_of(lib, k))) for k in range(60)])

    noise = spread(still, noise=1e-3)
    assert noise.std() == pytest.approx(1e-3, rel=0.02)
    assert np.abs(np.corrcoef(noise[0].T) - np.eye(12)).max() < 0.3
    gains = (spread(loads, gain=0.05)[:, 0] - 0.1) / (plain[0] - 0.1) - 1
    assert gains.std() == pytest.approx(0.05, rel=0.15)
    assert spread(still, offset=0.02)[:, 0].std() == pytest.approx(0.02, rel=0.15)
    dead = np.isclose(spread(loads, dead=0.2)[:, 0], 0.1, atol=1e-15)
    assert dead.mean() == pytest.approx(0.2, abs=0.05)
    times = given(np.linspace(0.0, 2.0, 400))
    drift = np.stack(
        [out(read(still, faults=SensorFaults(drift=0.01), key=key_of(lib, k), times=times)) for k in range(60)]
    )
    np.testing.assert_allclose(drift[:, -1] - 0.1, 2 * (drift[:, 200] - 0.1) / (400 / 399), rtol=0.01)
    assert (drift[:, -1] - 0.1).std() == pytest.approx(0.02, rel=0.15)
    rounded = out(read(loads, faults=SensorFaults(resolution=1e-3)))
    np.testing.assert_allclose(rounded, np.round(plain / 1e-3) * 1e-3, atol=1e-12)
    same = [out(read(loads, faults=SensorFaults(noise=1e-3), key=key_of(lib, 3))) for _ in range(2)]
    np.testing.assert_array_equal(*same)


def test_crosstalk_goes_to_neighbours_and_keeps_an_even_reading():
    found = PAD.reader()({"components": np.array([1.0, 0.0, 0.0]), "position": np.array([0.0, 0.0])})
    mixed = PAD.reader()(
        {"components": np.array([1.0, 0.0, 0.0]), "position": np.array([0.0, 0.0])}, faults=SensorFaults(crosstalk=0.1)
    )
    # the corner has two neighbours at a pitch
    assert mixed[0] == pytest.approx(0.9 * (found[0] - 0.1) + 0.05 * (found[1] + found[4] - 0.2) + 0.1)


def test_what_cannot_be_read_is_refused():
    rows = [
        (ROW, {"library": "cupy"}, "library"),
        (ROW, {"contact": "ball"}, "contact"),
        (ROW, {"contact": "point"}, "solved in a plane"),
        (PAD, {"contact": "line"}, "area"),
        (replace(ROW, array=replace(ROW.array, width=1e-3)), {}, "width"),
        (ss.Finger(LAYER, PAD.array), {"contact": "patch"}, "tables"),
    ]
    for finger, options, said in rows:
        with pytest.raises((InvalidValueError, ss.errors.GeometryError), match=said):
            finger.reader(**options)
    loads = {"components": np.array([40.0, 0.0]), "position": np.array(0.0)}
    for faults, said in ((SensorFaults(noise=1.0), "key"), (SensorFaults(share=[0.1], time=[1.0]), "times")):
        with pytest.raises(InvalidValueError, match=said):
            ROW.reader()(loads, faults=faults)
    with pytest.raises(InvalidValueError, match="one of each"):
        SensorFaults(share=[0.1])


def test_an_import_draws_in_no_library_to_learn_with():
    said = "import sys, subskin as ss; ss.Finger; assert not {'jax', 'torch', 'array_api_compat'} & set(sys.modules)"
    subprocess.run([sys.executable, "-c", said], check=True)


def test_a_library_that_is_not_there_is_named(monkeypatch):
    monkeypatch.setitem(sys.modules, "array_api_compat.torch", None)
    with pytest.raises(ModuleNotFoundError, match=r'pip install "subskin\[torch\]"'):
        ROW.reader("torch")
