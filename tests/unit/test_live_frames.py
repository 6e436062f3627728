"""What a driver hands on: checked, closed to writing, complete."""

import numpy as np
import pytest

from subskin.errors import GeometryError
from subskin.live import DeviceFrames


def test_what_a_device_does_not_send_is_marked():
    frames = DeviceFrames(np.zeros((3, 2)))
    assert len(frames) == 3
    assert np.isnan(frames.device_time).all()
    assert frames.sequence.tolist() == [-1, -1, -1]
    assert (frames.lost, frames.bad) == (0, 0)


def test_values_are_closed_and_the_given_array_is_not():
    given = np.ones((2, 2))
    frames = DeviceFrames(given, device_time=[0.0, 0.1], sequence=[4, 5])
    with pytest.raises(ValueError, match="read-only"):
        frames.values[0, 0] = 2.0
    given[0, 0] = 3.0


@pytest.mark.parametrize(
    "bad",
    [{"values": [1.0, 2.0]}, {"values": [[1.0]], "device_time": [0.0, 1.0]}, {"values": [[1.0]], "sequence": [1, 2]}],
)
def test_other_shapes_are_refused(bad):
    with pytest.raises(GeometryError, match="needed"):
        DeviceFrames(**bad)
