r"""
Locating a touch
================

A roller presses on a finger of eight strain sensors and drags a little. The load is found again from one
frame of noisy readings, with its 95 % interval; then a thousand touches show that the intervals mean what
they say.
"""

import numpy as np

import subskin as ss
from subskin.plot import finger_section

skin = ss.HalfPlane(ss.Material(young=0.4e6))
array = ss.SensorArray.line(count=8, pitch=1.5e-3, depth=2e-3, noise=5e-4)
finger = ss.Finger(skin, array)

touch = ss.Hertz(force=40.0, angle=-0.35, position=-1.6e-3, half_width=0.4e-3)
readings = finger.read(touch, rng=np.random.default_rng(3))
found = finger.locate(readings)

figure = finger_section(finger, touch, found, readings=readings)

# %%
# The same frame with the fourth sensor lost: it is left out, and the interval grows.

worse = readings.copy()
worse[3] = np.nan
lost = finger.locate(worse)
print(f"all sensors:    {1e3 * found.position:.2f} +- {1e3 * 1.96 * found.std[0]:.2f} mm")
print(f"without no. 4:  {1e3 * lost.position:.2f} +- {1e3 * 1.96 * lost.std[0]:.2f} mm")

figure_without = finger_section(finger, touch, lost, readings=worse)

# %%
# A thousand touches by a wire, one frame each: how often does the interval hold the truth?

rng = np.random.default_rng(0)
many = ss.LineLoad(
    force=40.0,
    angle=rng.uniform(-0.6, 0.6, 1000),
    position=rng.uniform(-5e-3, 5e-3, 1000),
)
all_found = finger.locate(finger.read(many, rng=rng))
truth = np.stack([many.position, np.full(1000, 40.0), many.angle], axis=-1)
estimate = np.stack([all_found.position, all_found.force, all_found.angle], axis=-1)
inside = np.abs(estimate - truth) < 1.96 * all_found.std
for name, share in zip(("position", "force", "angle"), inside.mean(axis=0), strict=True):
    print(f"{name:8s} {share:.1%} within the 95 % interval")
status, count = np.unique(all_found.status, return_counts=True)
names = [f"{ss.Status(s).name} {n}" for s, n in zip(status, count, strict=True)]
print("status:", ", ".join(names))
