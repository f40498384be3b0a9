"""The watershed that can be stopped: pixel by pixel that of scikit-image, with numba and without."""

import threading

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from skimage.segmentation import watershed

from ilf._runtime import compiling
from ilf._runtime.long_work import cancelled_by
from ilf.data import pixel_grids
from ilf.data.pixel_grids import flood
from ilf.errors import Cancelled

Landscape = tuple[np.ndarray, np.ndarray, np.ndarray]


def landscape(seed: int, height: int, width: int, marked: float, inside: float) -> Landscape:
    """Different heights, markers and a mask at random."""
    rng = np.random.default_rng(seed)
    heights = rng.permutation(height * width).reshape(height, width) * rng.random() - 3
    markers = np.where(rng.random((height, width)) < marked, rng.integers(1, 6, (height, width)), 0)
    return heights.astype(np.float32), markers.astype(np.int32), rng.random((height, width)) < inside


landscapes = st.builds(
    landscape, st.integers(0, 2**32), st.integers(1, 24), st.integers(1, 24), st.floats(0, 0.6), st.floats(0, 1)
)


def without_numba(patch: pytest.MonkeyPatch) -> None:
    for module in (compiling, pixel_grids):
        patch.setattr(module, "is_compiled", lambda: False)


@given(landscapes)
def test_compiled_or_not_it_gives_what_scikit_image_gives(case):
    heights, markers, mask = case
    expected = watershed(heights, markers, mask=mask)
    found = flood(*case)
    assert found.dtype == np.int32
    np.testing.assert_array_equal(found, expected)
    with pytest.MonkeyPatch.context() as patch:
        without_numba(patch)
        np.testing.assert_array_equal(flood(*case), expected)


@given(landscapes, st.integers(0, 3))
def test_where_heights_are_equal_regions_grow_side_by_side(case, levels):
    heights, markers, mask = case
    flat = np.float32(levels) * (heights > np.median(heights))
    found = flood(flat, markers, mask)
    np.testing.assert_array_equal(found > 0, watershed(flat, markers, mask=mask) > 0)
    np.testing.assert_array_equal(found[mask & (markers > 0)], markers[mask & (markers > 0)])
    if not flat.any() and found.any() and mask.all():  # the nearest marker by steps, whichever of several
        steps = np.abs(np.indices(mask.shape)[:, :, :, None] - np.argwhere(markers).T[:, None, None]).sum(axis=0)
        nearest = steps == steps.min(axis=2, keepdims=True)
        assert (nearest & (markers[markers > 0] == found[..., None])).any(axis=2).all()


def test_it_stops_when_nobody_wants_more(monkeypatch):
    heights, markers, mask = landscape(0, 20, 20, 0.1, 1)
    cancel_event, asked = threading.Event(), []

    def ask() -> None:
        asked.append(True)
        if len(asked) == 3:
            cancel_event.set()
        original()

    original = pixel_grids.check_cancelled
    monkeypatch.setattr(pixel_grids, "check_cancelled", ask)
    monkeypatch.setattr(pixel_grids, "_PIXELS_PER_CHECK", 50)
    with cancelled_by(cancel_event), pytest.raises(Cancelled):
        flood(heights, markers, mask)
    assert len(asked) == 3
