"""The same on an area: touches simulated, a finger calibrated on every other one, the rest located, and a picture.

python examples/demo/area.py [folder for the results]
"""

import sys
from dataclasses import replace
from pathlib import Path

import numpy as np

import subskin as ss

here, out = Path(__file__).parent, Path(sys.argv[1] if len(sys.argv) > 1 else "out/demo")
out.mkdir(parents=True, exist_ok=True)
drawn = ss.load(here / "area.toml").finger

# The real finger: deeper sensors with gains of their own, turned by 5 degrees at (20, 12) mm on the motors' axes.
rng = np.random.default_rng(1)
gain = rng.uniform(0.8, 1.2, len(drawn.array))
real = replace(drawn, array=replace(drawn.array, depth=3.4e-3, gain=gain))
at = rng.uniform(-5.5e-3, 5.5e-3, (80, 2))
touch = ss.PointLoad(force=1.5, position=at)  # N
readings = real.read(touch, rng)
cos, sin = np.cos(np.deg2rad(5)), np.sin(np.deg2rad(5))
motors = np.array([20e-3, 12e-3]) + at @ np.array([[cos, sin], [-sin, cos]])

used = np.arange(len(at)) % 2 == 0
found = ss.calibrate(drawn, readings[used], motors[used], force=1.5)
print(found)
located = found.finger.locate(readings[~used])
truth = found.on_finger(motors[~used])
print(located)
error = 1e3 * np.linalg.norm(located.position - truth, axis=-1)[located.ok]
print(
    f"error of position: median {np.median(error):.3f} mm, worst {error.max():.3f} mm, of {located.ok.sum()} ok touches"
)
ss.plot.save(located.plot(found.finger, truth=truth), out / "area.png")
print(f"-> {out / 'area.png'}")
