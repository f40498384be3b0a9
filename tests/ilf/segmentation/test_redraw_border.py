"""Borders drawn anew, against what can be drawn by hand."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.ndimage import label as components

from ilf.segmentation.editing.borders import redraw_border

Line = list[tuple[float, float]]


def _halves(column: int, shape: tuple[int, int] = (60, 80)) -> np.ndarray:
    labels = np.ones(shape, np.int32)
    labels[:, column:] = 2
    return labels


def _redrawn(labels: np.ndarray, points: Line, locked: tuple[int, ...] = ()) -> np.ndarray:
    after = labels.copy()
    patch = redraw_border(labels, points, locked)
    if patch is not None:
        patch.apply(after)
        changed = np.argwhere(after != labels)
        assert [(s.start, s.stop) for s in patch.box] == [
            (low, high + 1) for low, high in zip(changed.min(axis=0), changed.max(axis=0), strict=True)
        ]
    return after


@pytest.mark.parametrize("reach", [(-5.0, 65.0), (0.5, 59.5), (2.0, 57.0)], ids=["beyond", "at the rim", "just short"])
@pytest.mark.parametrize("column", [25, 37, 41, 60])
def test_a_straight_border_moves_to_the_pixel(column, reach):
    for ends in (reach, reach[::-1]):
        after = _redrawn(_halves(40), [(float(column), y) for y in ends])
        assert np.array_equal(after, _halves(column))


def test_only_the_drawn_stretch_moves():
    after = _redrawn(_halves(40), [(40.0, 10.0), (30.0, 10.0), (30.0, 50.0), (40.0, 50.0)])
    wanted = _halves(40)
    wanted[10:50, 30:40] = 2
    assert np.array_equal(after, wanted)


def test_a_line_that_crosses_the_old_border_sweeps_on_both_sides():
    rows, columns = np.mgrid[:60, :80] + 0.5
    wavy = np.where(columns < 40 + 5 * np.sin(rows / 4), 1, 2).astype(np.int32)
    assert np.array_equal(_redrawn(wavy, [(40.0, -1.0), (40.0, 61.0)]), _halves(40))
    part = _redrawn(wavy, [(38.0, 15.0), (40.0, 20.0), (40.0, 40.0), (41.0, 46.0)])
    assert np.array_equal(part[20:40], _halves(40)[20:40])
    assert np.array_equal(part[:13], wavy[:13])
    assert np.array_equal(part[48:], wavy[48:])


@pytest.mark.parametrize("start", [10.0, 19.0, 21.0, 23.0])
def test_a_line_begins_at_the_third_block_that_both_touch(start):
    labels, wanted = _halves(40), _halves(30)
    labels[:20] = wanted[:20] = 3
    assert np.array_equal(_redrawn(labels, [(30.0, start), (30.0, 61.0)]), wanted)


@pytest.mark.parametrize("gap", [0.0, 0.2])
def test_a_block_drawn_all_around(gap):
    rows, columns = np.mgrid[:60, :80] + 0.5
    before = np.where(np.hypot(rows - 30, columns - 40) < 14, 2, 1).astype(np.int32)
    wanted = np.where(np.hypot(rows - 30, columns - 41) < 17, 2, 1).astype(np.int32)
    turn = np.linspace(gap, 2 * np.pi - gap, 200)
    after = _redrawn(before, list(zip(41 + 17 * np.cos(turn), 30 + 17 * np.sin(turn), strict=True)))
    assert np.count_nonzero(after != wanted) <= 5


def test_no_block_may_be_a_neighbour_and_what_lies_between_stays():
    labels, wanted = _halves(40), _halves(30)
    for some in (labels, wanted):
        some[some == 2] = 0
        some[25:30, 36:44] = 3
    assert np.array_equal(_redrawn(labels, [(30.0, -1.0), (30.0, 61.0)]), wanted)


@pytest.mark.parametrize(
    "points",
    [
        [],
        [(40.0, 30.0)],
        [(40.0, 30.0), (40.0, 31.0)],
        [(15.0, 20.0), (15.0, 40.0)],
        [(-30.0, 20.0), (-20.0, 40.0)],
        [(40.0, -1.0), (40.0, 61.0)],
    ],
    ids=["none", "a point", "too short", "far from any border", "off the frame", "where it is"],
)
def test_lines_that_move_no_border(points):
    assert redraw_border(_halves(40), points) is None


def _on_a_table(start: int) -> np.ndarray:
    """A can (2), which reaches over half of the bowl below it (3), on a table (1)."""
    labels = np.ones((90, 100), np.int32)
    labels[10:start, 40:64] = 2
    labels[start:70, 40:64] = 3
    return labels


@pytest.mark.parametrize(
    ("row", "wanted"), [(46, 2), (49, 2), (56, 1), (64, 1)], ids=["near the can", "half", "nearer the table", "rim"]
)
def test_a_line_across_a_block_moves_the_border_that_is_nearer(row, wanted):
    before = _on_a_table(40)
    after = _redrawn(before, [(39.0, float(row)), (65.0, float(row))])
    moved = before.copy()
    moved[(slice(40, row) if wanted == 2 else slice(row, 70)), 40:64] = wanted
    assert np.array_equal(after, moved)


def test_a_line_through_a_block_cuts_its_lobe_although_a_smaller_change_is_near():
    before = np.ones((90, 110), np.int32)
    before[20:40, 10:60] = before[40:80, 40:60] = 2
    before[10:41, 60:95] = 3
    after = _redrawn(before, [(16, 40.5), (30, 40.5), (59.5, 40), (62, 38), (85, 38), (88, 36)])
    wanted = before.copy()
    wanted[40:80, 40:60] = 1
    assert np.array_equal(after, wanted)


def test_locked_blocks_keep_their_border():
    for locked in ((1,), (2,)):
        assert redraw_border(_halves(40), [(30.0, -1.0), (30.0, 61.0)], locked) is None


@settings(max_examples=50)
@given(st.lists(st.tuples(st.floats(-8, 8), st.floats(2, 12)), min_size=2, max_size=6), st.floats(-4, 30))
def test_two_blocks_at_most_change_and_both_stay_whole(moves, start):
    labels = _halves(40)
    labels[:15] = 3
    labels[45:, :20] = 0
    y, points = start, []
    for x, step in moves:
        points.append((40 + x, y))
        y += step
    after = _redrawn(labels, points)
    changed = after != labels
    assert len(set(labels[changed]) | set(after[changed])) in (0, 2)
    for label in range(4):
        assert components(after == label)[1] <= 1
