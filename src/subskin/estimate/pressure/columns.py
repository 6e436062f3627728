"""Columns of the table that the compiled loop fills, one row a frame; those along the surface follow from `WIDTH`.

On an area more numbers come first, and what follows begins at `AREA_WIDTH`.
"""

ANGLE, ANGLE_STD, CENTRE, CENTRE_STD, FORCES, FORCE_STD = 0, 1, 2, 3, 4, 6
WEIGHT, RESIDUAL, OPTIMALITY, LEAN, STATUS, WIDTH = 8, 9, 10, 11, 12, 13
ACROSS, ACROSS_STD, CENTRE_Z, CENTRE_Z_STD, AZIMUTH_STD, MOMENT, MOMENT_STD, AREA_WIDTH = 13, 14, 15, 16, 17, 18, 19, 20
