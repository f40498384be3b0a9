"""Regions of equal values: numbered as scikit-image numbers them."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from skimage.measure import label

from ilf.data.pixel_grids import connected_regions


@pytest.mark.parametrize("diagonal", [False, True])
@pytest.mark.parametrize("background", [0, -1])
@given(st.integers(0, 2**32), st.integers(1, 24), st.integers(1, 24), st.integers(1, 5))
def test_regions_are_those_of_scikit_image(background, diagonal, seed, height, width, values):
    picture = np.random.default_rng(seed).integers(0, values, (height, width), np.int32)
    found = connected_regions(picture, background=background, diagonal=diagonal)
    assert found.dtype == np.int32
    np.testing.assert_array_equal(found, label(picture, background=background, connectivity=1 + diagonal))
