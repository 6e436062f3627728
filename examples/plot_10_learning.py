r"""
Learning through the model
==========================

The forward model is a pure function of JAX. So a finger can be trained like a network, a finger that was made can be
learned from touches, and a network can be taught by the model. At the end stands who locates better: the network, or
`locate`, which needs no training.
"""

from dataclasses import replace
from itertools import pairwise

import jax
import jax.numpy as jnp
import numpy as np

import subskin as ss
from subskin.plot.style import DOUBLE, Ink, house_style, new_figure

jax.config.update("jax_enable_x64", True)
skin = ss.HalfSpace(ss.Material(young=0.4e6, poisson=0.5))
drawn = ss.Finger(skin, ss.SensorArray.grid((4, 4), 3e-3, depth=3e-3, noise=4e-4))
read, noise = drawn.reader("jax"), 4e-4
rng = np.random.default_rng(0)


def touches(count, rng, half=4.5e-3):
    """Presses of 0.5 to 1.5 N anywhere on a square, with a drag of up to a third."""
    press = rng.uniform(0.5, 1.5, count)
    drag = press[:, None] * rng.uniform(-0.33, 0.33, (count, 2))
    return {
        "components": jnp.asarray(np.column_stack([press, drag])),
        "position": jnp.asarray(rng.uniform(-half, half, (count, 2))),
    }


# %%
# A finger is trained
# -------------------
#
# How deep should the sensors lie, and how far apart? The Cramer-Rao bound of a touch's position follows from the slopes
# of the readings, and the slopes of the bound by depth and pitch from JAX. Gradient descent goes to the best finger.

some = touches(300, rng)
unit = jnp.asarray(drawn.array.points) / 3e-3


def bound(design):
    """The mean logarithm of the bound of a position, over touches."""
    pitch, depth = jnp.exp(design)
    sensors = {
        "y": pitch * unit[:, 0],
        "z": pitch * unit[:, 1],
        "depth": jnp.full(16, depth),
    }

    def one(components, position):
        def readings(load):
            return read({"components": load[:3], "position": load[3:]}, sensors) / noise

        slopes = jax.jacfwd(readings)(jnp.concatenate([components, position]))
        return jnp.linalg.inv(slopes.T @ slopes)[3:, 3:].trace()

    return 0.5 * jnp.log(jax.vmap(one)(some["components"], some["position"])).mean()


descend = jax.jit(jax.value_and_grad(bound))
design, path = jnp.log(jnp.array([1.5e-3, 4.5e-3])), []
for _ in range(60):
    value, slope = descend(design)
    path.append([*np.exp(design), float(jnp.exp(value))])
    design -= 0.03 * slope
path = np.array(path)
print(f"from pitch {1e3 * path[0, 0]:.1f}, depth {1e3 * path[0, 1]:.1f} mm:", end=" ")
print(f"+- {1e3 * path[0, 2]:.3f} mm")
print(f"to   pitch {1e3 * path[-1, 0]:.1f}, depth {1e3 * path[-1, 1]:.1f} mm:", end=" ")
print(f"+- {1e3 * path[-1, 2]:.3f} mm")

# %%
# A finger that was made is learned
# ---------------------------------
#
# A finger is not its drawing. Of forty touches at known loads its gains and depths follow, by least squares through the
# model, with Gauss and Newton's steps.

told = ss.Tolerances(gain=0.05, depth=0.05)
made = ss.Finger(*told.draw(skin, drawn.array, np.random.default_rng(3)))
known = touches(40, rng)
contact = ss.PointLoad(**{name: np.asarray(values) for name, values in known.items()})
seen = jnp.asarray(made.read(contact, rng))


@jax.jit
def misfit(unknown):
    """What a finger with such gains and depths leaves, in noises; and how far it is off its drawing."""
    gain, depth = jnp.split(unknown, 2)
    left = (read(known, {"gain": gain, "depth": 3e-3 * depth}) - seen) / noise
    return jnp.concatenate([left.reshape(-1), (unknown - 1) / 0.05])


slopes_of = jax.jit(jax.jacfwd(misfit))
unknown = jnp.ones(32)
for _ in range(6):
    step = jnp.linalg.lstsq(slopes_of(unknown), misfit(unknown))[0]
    unknown -= step
gain, depth = jnp.split(unknown, 2)
true = np.asarray(made.array.gain), np.asarray(made.array.depth) / 3e-3
for name, found, real in (("gain", gain, true[0]), ("depth", depth, true[1])):
    before, after = (100 * np.std(np.asarray(v) - real) for v in (np.ones(16), found))
    print(f"{name}: off by {before:.1f} % as drawn, {after:.2f} % as learned")

# %%
# A network is taught
# -------------------
#
# A network with two layers of 128 learns positions from readings that the model makes, a new batch each step, of
# fingers whose gains err by 5 %.


def network(weights, readings):
    """Positions, in mm."""
    x = readings / 1e-2
    for w, b in weights[:-1]:
        x = jnp.tanh(x @ w + b)
    w, b = weights[-1]
    return x @ w + b


def taught(gain, steps=1500, batch=256):
    """Weights after so many steps of Adam."""
    sizes, start = (16, 128, 128, 2), np.random.default_rng(1)
    weights = [
        (
            jnp.asarray(start.normal(0, m**-0.5, (m, n)), jnp.float32),
            jnp.zeros(n, jnp.float32),
        )
        for m, n in pairwise(sizes)
    ]
    faults = ss.faults.SensorFaults(noise=noise)

    def loss(weights, loads, key):
        keys = jax.random.split(key)
        each = 1 + gain * jax.random.normal(keys[0], (batch, 16))
        readings = (each * read(loads, faults=faults, key=keys[1])).astype(jnp.float32)
        away = network(weights, readings) - 1e3 * loads["position"]
        return jnp.sqrt((away**2).sum(axis=-1)).mean()

    @jax.jit
    def step(state, key, rate):
        weights, first, second, k = state
        keys = jax.random.split(key, 3)
        press = jax.random.uniform(keys[0], (batch, 1), minval=0.5, maxval=1.5)
        lean = jax.random.uniform(keys[1], (batch, 2), minval=-0.33, maxval=0.33)
        at = jax.random.uniform(keys[2], (batch, 2), minval=-4.5e-3, maxval=4.5e-3)
        loads = {
            "components": jnp.concatenate([press, press * lean], axis=1),
            "position": at,
        }
        slope = jax.grad(loss)(weights, loads, key)
        first = jax.tree.map(lambda m, g: 0.9 * m + 0.1 * g, first, slope)
        second = jax.tree.map(lambda v, g: 0.99 * v + 0.01 * g * g, second, slope)
        grown = 1 - 0.9 ** (k + 1), 1 - 0.99 ** (k + 1)

        def moved(w, m, v):
            return (w - rate * (m / grown[0]) / (jnp.sqrt(v / grown[1]) + 1e-8)).astype(
                w.dtype
            )

        return jax.tree.map(moved, weights, first, second), first, second, k + 1

    state = (weights, *(jax.tree.map(jnp.zeros_like, weights) for _ in range(2)), 0)
    for k, key in enumerate(jax.random.split(jax.random.key(0), steps)):
        state = step(state, key, 3e-3 * 0.5 * (1 + np.cos(np.pi * k / steps)))
    return state[0]


weights = taught(0.05)
uncertain = replace(drawn, tolerances=ss.Tolerances(gain=0.05))
asked = touches(2000, np.random.default_rng(7))
at = 1e3 * np.asarray(asked["position"])
errors = {}
for case, gain in (("as drawn", 0.0), ("gains off by 5 %", 0.05)):
    fingers = np.random.default_rng(8)
    frames = np.asarray(read(asked)) * (1 + gain * fingers.standard_normal((2000, 16)))
    frames += noise * fingers.standard_normal(frames.shape)
    inside = {"network": np.asarray(network(weights, frames))}
    inside["locate"] = 1e3 * drawn.locate(frames).position
    inside["locate with tolerances"] = 1e3 * uncertain.locate(frames).position
    for name, found in inside.items():
        away = np.hypot(*(found - at).T)
        errors[case, name] = away[np.isfinite(away)]
        answered, median = np.isfinite(away).mean(), np.nanmedian(away)
        print(
            f"{case:16} {name:24} off by {median:.3f} mm, answers {100 * answered:.0f} %"
        )

# %%
# Both are near each other here, for the model taught the network and the noise is large. `locate` is ahead on fingers
# as drawn, and told of the gains on others too. It needed no training, and says how sure it is of each frame. Taken as
# exact it leaves some frames of fingers with wrong gains open: no touch explains them.

with house_style():
    figure = new_figure(DOUBLE, 62.0)
    left, right = figure.subplots(1, 2)
    left.plot(1e3 * path[:, 0], 1e3 * path[:, 1], "-", color=Ink.GREY)
    left.plot(*(1e3 * path[0, :2]), "o", color=Ink.VERMILLION)
    left.plot(*(1e3 * path[-1, :2]), "o", color=Ink.BLUE)
    for k, words, lower in ((0, "start", 4), (-1, "trained", -14)):
        text = f"{words}, +- {1e3 * path[k, 2]:.2f} mm"
        spot = 1e3 * path[k, :2]
        left.annotate(text, spot, xytext=(8, lower), textcoords="offset points")
    left.set(xlabel="pitch [mm]", ylabel="depth [mm]", title="a finger is trained")
    left.margins(0.35, 0.2)
    for name, colour, style in (
        ("network", Ink.VERMILLION, "-"),
        ("locate", Ink.SKY, "--"),
        ("locate with tolerances", Ink.BLUE, "-"),
    ):
        away = np.sort(errors["gains off by 5 %", name])
        share = np.arange(1, away.size + 1) / 2000
        right.plot(away, share, style, color=colour, label=name)
    right.set(xscale="log", xlim=(0.005, 0.4), xlabel="error of the position [mm]")
    right.set(ylabel="share of the touches", title="gains off by 5 %", ylim=(0, 1))
    right.legend(loc="upper left", fontsize="small")
