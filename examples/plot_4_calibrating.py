r"""
Calibrating on touches at known positions
=========================================

Four barometers are cast in rubber. Drawn at a depth of 5 mm they lie deeper, each has its own gain and
offset, one is dead, and nobody knows where the row lies on the axis of the motor that presses. Thirty
touches by a wire, a millimetre apart, tell all of it.
"""

import numpy as np

import subskin as ss
from subskin.plot import truth_against_estimate
from subskin.plot.style import Ink, house_style, new_figure

skin = ss.HalfPlane(ss.Material(young=0.4e6))
kind = ss.MeanPressure()
drawn = ss.Finger(
    skin, ss.SensorArray.line(count=4, pitch=6e-3, depth=5e-3, transducer=kind)
)

# What is really there; the touches are read from it, with noise.
real_array = ss.SensorArray.line(
    count=4,
    pitch=6e-3,
    depth=5.4e-3,
    transducer=kind,
    gain=[0.9, 1.25, 0.0, 1.1],
    offset=[101_300, 101_150, 101_420, 101_290],
    noise=8.0,
)
real = ss.Finger(skin, real_array)
rng = np.random.default_rng(0)
motor = np.arange(0, 30e-3, 1e-3)
touches = real.read(ss.LineLoad(force=40.0, position=motor - 14.2e-3), rng=rng)

# %%
# Every second touch calibrates, the others test.

calibration = ss.calibrate(drawn, touches[::2], motor[::2], force=40.0)
for parameter in calibration.parameters:
    sensor = "" if parameter.sensor is None else f" {parameter.sensor}"
    name, value = (
        f"{parameter.name}{sensor}",
        f"{parameter.value:12.6g} +- {parameter.std:.2g}",
    )
    print(f"{name:10s} {value} {parameter.unit}")
print("health:", ", ".join(h.name for h in calibration.health))

held_out = calibration.evaluate(touches[1::2], motor[1::2], force=40.0)
print(f"R^2 on the touches held out: {held_out.r2:.5f}")

# %%
# The readings, and the receptive fields fitted to half of them. The dead sensor says nothing, and is left
# out from here on.

fitted = calibration.finger
y = np.linspace(motor[0], motor[-1], 300)
model = fitted.read(ss.LineLoad(force=40.0, position=y - calibration.origin))
with house_style():
    figure = new_figure(174, 76)
    axes = figure.subplots()
    for i, colour in enumerate((Ink.BLUE, Ink.GREEN, Ink.ORANGE, Ink.VERMILLION)):
        dead = calibration.health[i] is ss.calibration.Health.DEAD
        offset = touches[:, i].mean() if dead else fitted.array.offset[i]
        if not dead:
            axes.plot(1e3 * y, 1e-3 * (model[:, i] - offset), color=colour, lw=1)
        above = 1e-3 * (touches[:, i] - offset)
        label = f"sensor {i}: {calibration.health[i].name.lower()}"
        axes.plot(1e3 * motor[::2], above[::2], "o", color=colour, ms=3.5, label=label)
        axes.plot(1e3 * motor[1::2], above[1::2], "o", color=colour, ms=3.5, mfc="white")
    axes.set(
        xlabel="position on the motor's axis [mm]", ylabel="reading less offset [kPa]"
    )
    axes.set_title("filled: used to calibrate, open: held out")
    figure.legend(*axes.get_legend_handles_labels(), loc="outside lower center", ncols=4)

# %%
# With three live barometers the other touches are located as normal loads. Where the dead one leaves a gap
# of more than two depths, and beyond the ends of the row, a second load would explain the three readings
# nearly as well, and the status says so.

found = fitted.locate(touches[1::2], friction=0, search=(-20e-3, 20e-3))
truth = motor[1::2] - calibration.origin
figure_truth = truth_against_estimate(truth, found)
