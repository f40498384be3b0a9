"""Lines around blocks, drawn box by box, are those of the whole map; at every zoom, wherever the frame lies."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from gui.views.image_view import Sampling
from gui.views.shown_blocks import BlockLines
from ilf.data.blocks import whole

HEIGHT, WIDTH = 24, 30
COLOURS = np.array([[0, 0, 0, 0], [200, 0, 0, 255], [0, 200, 0, 255], [0, 0, 200, 0], [90, 90, 0, 255]], np.uint8)

samplings = st.builds(
    Sampling,
    scale=st.floats(0.3, 6.0),
    x=st.integers(-60, 30),
    y=st.integers(-60, 30),
    size=st.just((90, 70)),
    frame=st.just((WIDTH, HEIGHT)),
    ratio=st.sampled_from([1.0, 2.0]),
)
boxes = st.tuples(st.integers(0, HEIGHT - 1), st.integers(1, 9), st.integers(0, WIDTH - 1), st.integers(1, 9))
edits = st.lists(st.tuples(boxes, st.integers(0, 4)), min_size=1, max_size=6)


def drawn(lines: BlockLines, labels: np.ndarray, sampling: Sampling) -> np.ndarray:
    pixels = np.zeros(sampling.shape, np.uint32)
    lines.draw(sampling.sample(labels, whole(sampling.shape)), pixels, whole(sampling.shape), sampling)
    return pixels


@settings(max_examples=150)
@given(samplings, edits, st.sets(st.integers(1, 4)), st.sets(st.integers(1, 4)), st.booleans())
def test_what_is_drawn_box_by_box_is_what_the_whole_map_gives(sampling, edits, chosen, doubtful, in_colours):
    lines = BlockLines(COLOURS, sorted(chosen), sorted(doubtful), in_colours)
    labels = np.ones((HEIGHT, WIDTH), np.int32)
    here = sampling.sample(labels, whole(sampling.shape))
    pixels = drawn(lines, labels, sampling)
    for (top, height, left, width), label in edits:
        box = slice(top, min(top + height, HEIGHT)), slice(left, min(left + width, WIDTH))
        labels[box] = label
        part = sampling.box_of(box)
        if all(span.start < span.stop for span in part):
            here[part] = sampling.sample(labels, part)
            before = pixels.copy()
            around = lines.draw(here, pixels, part, sampling)
            outside = np.ones(pixels.shape, bool)
            outside[around] = False
            assert (before == pixels)[outside].all()
    np.testing.assert_array_equal(pixels, drawn(lines, labels, sampling))


def test_blocks_that_need_a_look_have_a_line_inside_unless_they_are_hidden_or_chosen():
    labels = np.ones((HEIGHT, WIDTH), np.int32)
    labels[4:20, 4:14], labels[4:20, 16:26] = 2, 3  # 3 is hidden
    sampling = Sampling(1.0, 0, 0, (WIDTH, HEIGHT), (WIDTH, HEIGHT))
    plain = drawn(BlockLines(COLOURS), labels, sampling)
    doubtful = BlockLines(COLOURS, to_check=[2, 3])
    assert not doubtful.looks_like(BlockLines(COLOURS))
    marked = drawn(doubtful, labels, sampling)
    colour = marked[5, 9]
    assert colour != plain[5, 9]
    assert (marked == colour)[labels == 2].any()
    assert not (marked == colour)[labels != 2].any()
    assert not (drawn(BlockLines(COLOURS, [2], [2, 3]), labels, sampling) == colour).any()


@given(samplings)
def test_a_device_pixel_shows_the_image_pixel_that_its_middle_lies_in(sampling):
    for shown, start, first in (
        (sampling.columns, sampling.x, sampling.left),
        (sampling.rows, sampling.y, sampling.top),
    ):
        for index in range(0, len(shown), 7):
            assert shown[index] == pytest.approx((first + index + 0.5 - start) / sampling.scale - 0.5, abs=0.5 + 1e-9)
    rows, columns = sampling.box_of((slice(5, 9), slice(3, 20)))
    assert set(sampling.rows[rows]) <= {5, 6, 7, 8}
    assert set(sampling.columns[columns]) <= set(range(3, 20))
