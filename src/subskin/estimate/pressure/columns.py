"""Columns of the table that the compiled loop fills, one row a frame; the heights of the elements follow from `WIDTH`.

Along a row of sensors those of a second direction hold nothing.
"""

ANGLE, ANGLE_STD, CENTRE, CENTRE_STD, FORCES, FORCE_STD = 0, 1, 2, 3, 4, 6
WEIGHT, RESIDUAL, OPTIMALITY, LEAN, STATUS = 8, 9, 10, 11, 12
ACROSS, ACROSS_STD, CENTRE_Z, CENTRE_Z_STD, AZIMUTH_STD, MOMENT, MOMENT_STD, WIDTH = 13, 14, 15, 16, 17, 18, 19, 20
