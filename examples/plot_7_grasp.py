r"""
Holding what grows heavier
==========================

Two fingers hold a bottle between them while it is filled. Each carries half of the weight, by friction of which the
hand knows no more than a range. From the readings of one finger alone it estimates the load, and grips no harder than
keeps the probability of slip below one in a thousand: what the memo wanted the angle of force for.
"""

import numpy as np

import subskin as ss
from subskin.decide import Friction, least_force, slip
from subskin.plot.style import Ink, house_style, new_figure

rubber = ss.Material(young=0.4e6)
row = ss.SensorArray.line(count=8, pitch=1e-3, depth=2e-3, noise=1e-4)
finger = ss.Finger(ss.HalfPlane(rubber), row)
fitter = {"family": "hertz", "friction": 2.0, "half_width": (0.2e-3, 1.6e-3)}
BOUND = 1e-3

# %%
# The load
# --------
#
# Forces are per unit length, as everywhere here. Forty bottles, each with a friction and a filling of its own: a
# steady rise, two gushes, and a knock from outside. What a finger carries is half of the weight.

rng = np.random.default_rng(7)
bottles, rate = 40, 100  # -, Hz
t = np.arange(200) / rate
low, high = 0.4, 0.8
mu = rng.uniform(low, high, bottles)


def risen(start, duration):
    """A smooth step from 0 to 1."""
    share = np.clip((t - start[:, None]) / duration, 0, 1)
    return share**2 * (3 - 2 * share)


def anywhere(first, last):
    return rng.uniform(first, last, bottles)


load = 3 + rng.uniform(1, 3, (bottles, 1)) * t
for _ in range(2):
    load += rng.uniform(0.5, 2, (bottles, 1)) * risen(anywhere(0.2, 1.6), 0.25)
knock = anywhere(0.3, 1.6)
load += rng.uniform(1, 2, (bottles, 1)) * (risen(knock, 0.15) - risen(knock + 0.15, 0.15))
needed = load / mu[:, None]

# %%
# The hand
# --------
#
# The contact is a cylinder's, whose half width grows with the grip, and which sticks in its middle and slips at
# its edges (Cattaneo and Mindlin, as if pressed first and dragged after in each frame). A hundred times a second
# the hand reads its sensors, and closes by a quarter of the grip that is missing: it follows with a lag of 40 ms.
# A load that rises goes on rising in that time; the rate is the slope of the last 15 estimates. What may begin in
# that time is a standard deviation of 0.5 N/m.

share, lead, window = 0.25, 0.06, 15
arms = (np.arange(window) - 0.5 * (window - 1)) / rate
slope = arms / (arms**2).sum()


def readings(grip, drag, friction):
    """What the sensors read; a drag that friction does not hold slides, and is no larger than it holds."""
    carried = np.minimum(drag, friction * grip * (1 - 1e-9))
    touch = ss.PartialSlip.from_radius(
        np.hypot(grip, carried),
        8e-3,
        rubber,
        angle=np.arctan2(carried, grip),
        friction=friction,
    )
    return finger.read(touch, rng=rng)


def hold(belief):
    """Grips and stated probabilities of slip, (bottles, frames), from readings alone."""
    grip = np.full(bottles, 16.0)
    grips, risks, felt = [], [], []
    for k in range(t.size):
        found = finger.fit(readings(grip, load[:, k], mu), **fitter)
        risks.append(slip(found, belief).probability)
        felt.append(found.force * np.sin(found.angle))
        rise, error = np.zeros(bottles), np.full(bottles, 0.5)
        if k >= window:
            rise = lead * np.tensordot(slope, np.array(felt[-window:]), 1)
            noise = found.std[:, 2] * found.force
            error = np.hypot(0.5, lead * np.linalg.norm(slope) * noise)
        wanted = least_force(
            found,
            belief,
            BOUND,
            rise=np.nan_to_num(rise),
            rise_std=np.nan_to_num(error, nan=0.5),
        )
        grips.append(grip)
        missing = wanted - found.force * np.cos(found.angle)
        grip = np.maximum(grip + share * np.nan_to_num(missing), 6.0)
    return np.array(grips).T, np.array(risks).T


guessed = Friction.between(np.full(bottles, low), high, cells=24)
from_range, risk = hold(guessed)

# %%
# One slip seen
# -------------
#
# Friction can be learned. Before lifting, the hand grips the bottle on its table with 16 N/m and pulls, until it
# slides along the bottle; from then on the drag is that of friction, however the hand moves on. Twenty frames of
# that are slips at the estimated load.

sliding = np.stack(
    [readings(np.full(bottles, 16.0), np.full(bottles, 99.0), mu) for _ in range(20)], 1
)
learned = guessed.updated(slips=finger.fit(sliding, **fitter))
from_slip, risk_after = hold(learned)
error = np.sqrt(np.mean((learned.mean - mu) ** 2))
print(f"friction: {np.mean(learned.std):.3f} +- on average, {error:.3f} off")

# %%
# Beside others
# -------------
#
# A grip that stays, for the heaviest bottle and the least friction, or for what is usual; and a hand that is told
# the true load and the true friction, with the same lag and the same 0.5 N/m for what may begin, 3.1 times. A
# bottle is dropped where its load is more than friction holds, in any frame; of the others the grip beyond the least
# is summed over time, as wasted.

told = np.empty_like(load)
told[:, 0] = 16.0
coming = load + lead * np.gradient(load, 1 / rate, axis=1)
for k in range(t.size - 1):
    target = (coming[:, k] + 0.5 * 3.1) / mu
    told[:, k + 1] = told[:, k] + share * (target - told[:, k])

heaviest = load.max()
hands = {
    "fixed, for the worst": np.full_like(load, heaviest / low),
    "fixed, for the usual": np.full_like(load, load.max(axis=1).mean() / mu.mean()),
    "readings, friction 0.4 to 0.8": from_range,
    "readings, one slip seen": from_slip,
    "told load and friction": told,
}
for name, grip in hands.items():
    dropped = (needed > grip).any(axis=1)
    waste = (grip - needed)[~dropped].sum(axis=1) / rate
    print(
        f"{name:30} {dropped.sum():3d} of {bottles} dropped, {waste.mean():5.1f} N s/m wasted"
    )

# %%
# One bottle. The hand that knows friction as a range grips as if it were the least; the one that has felt a slip
# grips by what it felt. Neither was told where the knock would come.

one = int(np.argsort(mu)[bottles // 2])
with house_style():
    figure = new_figure(174, 112)
    above, below = figure.subplots(2, 1, sharex=True, height_ratios=(2.2, 1))
    styles = {
        "fixed, for the worst": (Ink.GREY, "-"),
        "fixed, for the usual": (Ink.GREY, ":"),
        "readings, friction 0.4 to 0.8": (Ink.BLUE, "-"),
        "readings, one slip seen": (Ink.GREEN, "-"),
        "told load and friction": (Ink.ORANGE, "-"),
    }
    for name, (colour, line) in styles.items():
        above.plot(t, hands[name][one], color=colour, ls=line, label=name)
    above.fill_between(t, needed[one], color=Ink.VERMILLION, alpha=0.15, lw=0)
    above.plot(
        t,
        needed[one],
        color=Ink.VERMILLION,
        label=f"least needed, friction {mu[one]:.2f}",
    )
    above.plot(t, load[one], color=Ink.BLACK, lw=0.9, label="load of a finger")
    above.set(ylabel="normal force [N/m]", ylim=(0, 1.05 * heaviest / low))
    above.legend(loc="upper left", bbox_to_anchor=(1.0, 1.0))
    above.set_title("grip")
    for values, colour in ((risk, Ink.BLUE), (risk_after, Ink.GREEN)):
        below.semilogy(t, values[one], ".", color=colour, ms=3.5, mew=0, alpha=0.8)
    below.axhline(BOUND, color=Ink.GREY, lw=0.8, ls="--")
    below.set(
        xlabel="time [s]",
        ylabel="probability of slip",
        ylim=(1e-9, 1),
        xlim=(0, 2),
        xticks=np.arange(0, 2.1, 0.5),
    )
    below.set_title("stated from each frame, and the bound")
