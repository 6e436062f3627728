r"""
How far apart should the sensors be?
====================================

For a given skin two things follow from the pitch of the sensors: how accurately a load is located, and
whether it is located at all, that is, whether no other load explains the readings as well. Lengths are in
depths and noise in parts of full scale, the strain beneath a normal load, so the answer holds for any
finger.
"""

import numpy as np

import subskin as ss
from subskin.plot import placement_figure, placement_study_figure

depth, young, force = 2e-3, 0.4e6, 40.0
skin = ss.HalfPlane(ss.Material(young))
noise = 2e-3 * 3 * force / (2 * np.pi * young * depth)  # of |strain| under a normal load
touches = ss.design.Touches(force, friction=0.84)  # up to 40 degrees
study = ss.design.placement_study(
    skin,
    ss.NormalStrain(),
    depth,
    depth * np.linspace(0.3, 2.5, 45),
    [3, 4, 6, 8],
    touches,
    noise=noise,
    samples=20_000,
)

# %%
# Three sensors do best at a pitch of one depth, where the false roots of the memo's eq. (13) are far away
# or known, but do not do well. A fourth sensor removes them over a wide range of pitches. Beyond one depth
# the worst touch gets worse fast: at some angle the gap between two sensors is felt by neither. Thick lines
# are within 10 % of the best of their number.

figure = placement_study_figure(study, measure="position_95")

# %%
# The best row of six, and how far its pitch may be missed.

best = ss.design.best_row(study, "position_95", counts=(6, 6))
low, high = best.pitches
print(f"{1e3 * best.pitch:.1f} mm, {1e3 * low:.1f} to {1e3 * high:.1f} within 10 %")

# %%
# Where each finger is strong. Two pitches of six sensors: in the second, touches between the outer sensors
# are hatched, for they are ambiguous, and every gap is dark.

close = placement_figure(ss.design.placement_quality(best.finger, touches))
wide = ss.Finger(skin, ss.SensorArray.line(6, 1.8 * depth, depth, noise=noise))
far = placement_figure(ss.design.placement_quality(wide, touches))
