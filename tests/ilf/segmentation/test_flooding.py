"""The watershed that can be stopped: pixel by pixel that of scikit-image, with numba and without."""

import threading

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from skimage.segmentation import watershed

from ilf._runtime import compiling
from ilf._runtime.cancellation import cancelled_by
from ilf.errors import Cancelled
from ilf.segmentation import flooding
from ilf.segmentation.flooding import flood, flood_large

Landscape = tuple[np.ndarray, np.ndarray, np.ndarray]


def landscape(seed: int, height: int, width: int, levels: int, marked: float, inside: float) -> Landscape:
    """Heights of so many levels, markers and a mask at random."""
    rng = np.random.default_rng(seed)
    heights = rng.standard_normal(levels)[rng.integers(0, levels, (height, width))]
    markers = np.where(rng.random((height, width)) < marked, rng.integers(1, 6, (height, width)), 0)
    return heights.astype(np.float32), markers.astype(np.int32), rng.random((height, width)) < inside


landscapes = st.builds(
    landscape,
    st.integers(0, 2**32),
    st.integers(1, 24),
    st.integers(1, 24),
    st.integers(1, 6),
    st.floats(0, 0.6),
    st.floats(0.4, 1),
)


def without_numba(patch: pytest.MonkeyPatch) -> None:
    for module in (compiling, flooding):
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


@pytest.mark.parametrize("compiled", [True, False])
def test_heights_of_large_images_may_be_rounded(compiled, monkeypatch):
    if not compiled:
        without_numba(monkeypatch)
    monkeypatch.setattr(flooding, "_MAX_PIXELS", 2_000)
    monkeypatch.setattr(flooding, "_STEPS", 1 << 15)  # more than there are heights
    rng = np.random.default_rng(0)
    heights = rng.permutation(19_200).reshape(120, 160).astype(np.float32)
    markers = np.where(rng.random((120, 160)) < 0.02, rng.integers(1, 500, (120, 160)), 0).astype(np.int32)
    mask = rng.random((120, 160)) < 0.95
    np.testing.assert_array_equal(flood_large(heights, markers, mask), flood(heights, markers, mask))
    level = flood_large(np.zeros_like(heights), markers, mask)
    np.testing.assert_array_equal(level > 0, flood(heights, markers, mask) > 0)


def test_it_stops_when_nobody_wants_more(monkeypatch):
    heights, markers, mask = landscape(0, 20, 20, 3, 0.1, 1)
    cancel_event, asked = threading.Event(), []

    def ask() -> None:
        asked.append(True)
        if len(asked) == 3:
            cancel_event.set()
        original()

    original = flooding.check_cancelled
    monkeypatch.setattr(flooding, "check_cancelled", ask)
    monkeypatch.setattr(flooding, "_PIXELS_PER_CHECK", 50)
    with cancelled_by(cancel_event), pytest.raises(Cancelled):
        flood(heights, markers, mask)
    assert len(asked) == 3
