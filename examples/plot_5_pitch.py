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
from subskin.design.placement import Channel, study_at_depth
from subskin.plot import placement_figure, placement_study_figure

depth, young, force = 2e-3, 0.4e6, 40.0
skin = ss.HalfPlane(ss.Material(young))
noise = 2e-3 * 3 * force / (2 * np.pi * young * depth)  # of |strain| under a normal load
touches = ss.design.Touches(force, friction=0.84)  # up to 40 degrees
pitches, counts = depth * np.linspace(0.3, 2.5, 45), [3, 4, 6, 8]
gauge = Channel(ss.NormalStrain(), noise)
study = study_at_depth(skin, gauge, depth, pitches, counts, touches, samples=20_000)

# %%
# Three sensors do best at a pitch of one depth, where the false roots of the memo's eq. (13) are far away
# or known, but do not do well. A fourth sensor removes them over a wide range of pitches. Beyond one depth
# the worst touch gets worse fast: at some angle the gap between two sensors is felt by neither. Thick lines
# are within 10 % of the best of their number.

figure = placement_study_figure(study, depth, pitches, counts, measure="position_95")

# %%
# The best row of six, and how far its pitch may be missed.

sure = study["ambiguous"][:, 2] <= 0.01
six = np.where(sure, study["position_95"][:, 2], np.inf)
best, near = pitches[six.argmin()], pitches[six <= 1.1 * six.min()]
print(
    f"{1e3 * best:.1f} mm, {1e3 * near.min():.1f} to {1e3 * near.max():.1f} within 10 %"
)

# %%
# Where each finger is strong. Two pitches of six sensors: in the second, touches between the outer sensors
# are hatched, for they are ambiguous, and every gap is dark.

close, wide = (
    ss.Finger(skin, ss.SensorArray.line(6, pitch, depth, noise=noise))
    for pitch in (best, 1.8 * depth)
)
near = placement_figure(ss.design.placement_quality(close, touches))
far = placement_figure(ss.design.placement_quality(wide, touches))
