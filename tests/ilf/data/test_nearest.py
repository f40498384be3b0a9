"""The nearest of some pixels: how far it is, and what is there."""

import numpy as np
import pytest

from ilf.data.pixel_grids import nearest_values


@pytest.mark.parametrize("mask_size", [3, 5])
def test_every_pixel_has_the_value_of_the_nearest(mask_size):
    values = np.full((7, 9), np.nan, np.float32)
    values[3, 1], values[3, 7] = 1.5, 4.0
    there = np.isfinite(values)
    distance, nearest = nearest_values(values, there, mask_size)
    columns = np.arange(9)
    assert (nearest[:, columns < 4] == 1.5).all()
    assert (nearest[:, columns > 4] == 4.0).all()
    assert (distance == 0).tolist() == there.tolist()
    assert distance[3, :4] == pytest.approx([1, 0, 1, 2], rel=0.05)
    assert distance.dtype == nearest.dtype == np.float32


def test_without_any_there_is_nothing_to_say():
    nearest = nearest_values(np.ones((4, 5), np.float32), np.zeros((4, 5), bool))[1]
    assert not nearest.any()
