"""Columns of the table that the evidence fills, one row a frame: of the frame, then of each kind of contact."""

STATUS, KIND = 0, 1
LOG_EVIDENCE, CHI2, POSITION, NORMAL, TANGENTIAL, HALF_WIDTH, EACH = 0, 1, 2, 3, 4, 5, 6
