"""Blocks that stay when blocks are extracted again, and the new ones around them: what holds for any label maps."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from scipy.ndimage import binary_dilation
from scipy.ndimage import label as regions

from ilf.segmentation.reextraction import fill_around, made_by_hand, overlay_kept

_SHAPE = (9, 11)
_MAPS = arrays(np.int32, _SHAPE, elements=st.integers(0, 3))


@st.composite
def _blocky(draw: st.DrawFn) -> np.ndarray:
    """A label map of a few rectangles, as extractions give rather larger regions than noise does."""
    labels = np.full(_SHAPE, draw(st.integers(0, 1)), np.int32)
    for label in range(2, 2 + draw(st.integers(0, 4))):
        top, left = draw(st.integers(0, 8)), draw(st.integers(0, 10))
        labels[top : top + draw(st.integers(1, 9)), left : left + draw(st.integers(1, 11))] = label
    return labels


@given(
    present=_MAPS | _blocky(),
    kept=st.sets(st.integers(1, 4), max_size=3),
    fresh=_MAPS | _blocky(),
    smallest=st.integers(0, 20),
)
def test_what_stays_is_untouched_and_what_is_new_is_watertight(present, kept, fresh, smallest):
    result = fill_around(present, kept, fresh, smallest)
    if not kept:
        assert result is fresh
        return
    stays = np.isin(present, list(kept))
    for label in kept:
        np.testing.assert_array_equal(result == label, present == label)
    new = np.where(stays, 0, result)
    numbers = [int(number) for number in np.unique(new) if number > 0]
    sizes = [int((new == number).sum()) for number in numbers]
    assert sizes == sorted(sizes, reverse=True)
    cut = np.isin(fresh, np.unique(fresh[stays]))
    for number, size in zip(numbers, sizes, strict=True):
        assert regions(new == number)[1] == 1
        # one that is small without having been cut is left as it is, and may take slivers in
        assert size >= smallest or not cut[new == number].all(), "a sliver is no block of its own"
    assert not new[fresh == 0].any()
    lost = ~stays & (fresh > 0) & (new == 0)
    assert not (binary_dilation(lost) & (new > 0)).any(), "a sliver beside a new block goes to it"
    assert cut[lost].all()


def test_slivers_go_to_the_longest_border_also_through_other_slivers():
    fresh = np.array([[1, 1, 1, 1, 2, 2, 3, 3, 4, 4, 4, 4]] * 4, np.int32)
    present = np.zeros_like(fresh)
    present[:3, 4:8] = 7
    present[3, 7] = 7
    # what is left of 2 and of 3 lies in the last row: 2 beside 1, and 3 behind it
    result = fill_around(present, {7}, fresh, 5)
    assert result[3].tolist() == [1, 1, 1, 1, 1, 1, 1, 7, 2, 2, 2, 2]
    assert (result[present == 7] == 7).all()


def test_by_hand_is_what_the_extraction_did_not_give():
    extracted = np.repeat(np.int32([[1, 2, 3, 4, 5]]), 3, axis=0)
    present = extracted.copy()
    assert made_by_hand(present, extracted) == frozenset()
    present[0, 1] = 1
    assert made_by_hand(present, extracted) == {1}, "2 has only lost pixels to it"
    present[0, 3] = 9
    assert made_by_hand(present, extracted) == {1, 9}
    present[:, 2] = 0
    assert made_by_hand(present, extracted) == {1, 9}, "3 is gone"
    present[0, 4] = 0
    assert made_by_hand(present, extracted) == {1, 5, 9}
    assert made_by_hand(present, None) == {1, 2, 4, 5, 9}


def test_a_map_under_blocks_that_stay_leaves_their_numbers():
    present, labels = np.int32([[0, 0, 2, 2]]), np.int32([[1, 1, 2, 3]])
    assert overlay_kept(present, {2}, labels).tolist() == [[1, 1, 2, 2]]
    assert overlay_kept(present, {1}, labels).tolist() == [[2, 2, 3, 4]]
