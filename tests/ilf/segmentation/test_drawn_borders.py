"""Drawn pixels: what edits make of them, pixel by pixel, and that it can be undone."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from ilf.segmentation.editing.patches import border_pixels, patch_between, redrawn

SHAPE = (9, 11)
label_maps = arrays(np.int32, SHAPE, elements=st.integers(0, 3))
masks = arrays(np.bool_, SHAPE)
boxes = st.tuples(*(st.tuples(*[st.integers(0, size)] * 2).map(lambda ends: slice(*sorted(ends))) for size in SHAPE))


def _links(labels: np.ndarray) -> set[frozenset[tuple[int, int]]]:
    """Pairs of neighbours with different labels, the slow way."""
    found = set()
    for row, column in np.ndindex(*labels.shape):
        for there in ((row + 1, column), (row, column + 1)):
            if there[0] < labels.shape[0] and there[1] < labels.shape[1] and labels[there] != labels[row, column]:
                found.add(frozenset([(row, column), there]))
    return found


def _mask(pixels: set[tuple[int, int]]) -> np.ndarray:
    result = np.zeros(SHAPE, bool)
    for pixel in pixels:
        result[pixel] = True
    return result


def _ends(links: set[frozenset[tuple[int, int]]]) -> np.ndarray:
    return _mask({pixel for link in links for pixel in link})


@given(label_maps)
def test_border_pixels_are_the_blocks_ends_of_border_links(labels):
    assert np.array_equal(border_pixels(labels), _ends(_links(labels)) & (labels > 0))


@given(label_maps, label_maps, masks, boxes)
def test_drawn_after_an_edit_are_the_ends_of_new_links_and_what_was_drawn_and_still_is_border(
    labels, others, drawn, swept
):
    after = labels.copy()
    after[swept] = others[swept]
    patch = patch_between(labels, after)
    if patch is None:
        return
    drawn &= border_pixels(labels)
    was, now = _links(labels), _links(after)
    expected = (_ends(now - was) | drawn & _ends(now)) & (after > 0)
    box, values = redrawn(drawn, labels, patch)
    result = drawn.copy()
    result[box] = values
    assert np.array_equal(result, expected)
    assert not (result & ~border_pixels(after)).any()
    assert np.array_equal(redrawn(drawn, after, patch)[1], values), "before the patch is applied, and after"
    assert np.array_equal(redrawn(None, labels, patch)[1], (_ends(now - was) & (after > 0))[box])
