"""Properties of block edits: what must hold for any label map and any edit."""

from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given as holds_for
from hypothesis import settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from scipy.ndimage import label as components

from ilf.data.blocks import Region, enclosed
from ilf.data.frame import RGBDFrame
from ilf.segmentation.editing.borders import redraw_border
from ilf.segmentation.editing.cleaning import (
    clean_up,
    count_slivers,
    delete,
    grow,
    merge,
    parts_touch,
    pixels_apart,
    shrink,
    smooth,
    tidied,
)
from ilf.segmentation.editing.cutting import cut_off, extend_to_boundary, split
from ilf.segmentation.editing.painting import assign_outline, brush_stroke, erase, give, paint
from ilf.segmentation.editing.patches import patch_between

SHAPE = (14, 17)
label_maps = arrays(np.int32, SHAPE, elements=st.integers(0, 4))
coordinates = st.tuples(st.floats(-4, 21), st.floats(-4, 18))
strokes = st.tuples(st.lists(coordinates, min_size=1, max_size=4), st.floats(0, 6))
locks = st.sets(st.integers(1, 4), max_size=2)


def _applied(labels, patch):
    """The map after the patch; checks that it can be taken back."""
    after = labels.copy()
    if patch is not None:
        patch.apply(after)
        back = after.copy()
        patch.revert(back)
        assert np.array_equal(back, labels)
        assert not np.array_equal(after, labels), "a patch that changes nothing should be None"
    return after


def _locked_unchanged(labels, after, locked):
    for label in locked:
        assert np.array_equal(labels == label, after == label)


@holds_for(label_maps, strokes, st.integers(1, 5), locks)
def test_painting_and_erasing_change_the_stroke_alone(labels, stroke, label, locked):
    swept = brush_stroke(SHAPE, *stroke)
    if swept is None:
        return
    inside = np.zeros(SHAPE, bool)
    inside[swept.box] = swept.mask
    free = inside & ~np.isin(labels, list(locked - {label}))
    painted = _applied(labels, paint(labels, swept, label, locked - {label}))
    assert np.array_equal(painted, np.where(free, label, labels))
    own = inside & (labels == label) & (label not in locked)
    assert np.array_equal(_applied(labels, erase(labels, swept, label, locked)), np.where(own, 0, labels))


@holds_for(label_maps, st.lists(st.integers(0, 5), max_size=4), locks)
def test_deleting_and_merging_move_whole_blocks(labels, chosen, locked):
    after = _applied(labels, delete(labels, chosen, locked))
    _locked_unchanged(labels, after, locked)
    doomed = set(chosen) - locked - {0}
    assert np.array_equal(after, np.where(np.isin(labels, list(doomed)), 0, labels))

    after = _applied(labels, merge(labels, chosen, locked))
    _locked_unchanged(labels, after, locked)
    assert np.array_equal(after == 0, labels == 0)


@holds_for(label_maps, st.integers(0, 4), st.lists(coordinates, min_size=2, max_size=3), locks)
def test_splitting_keeps_every_pixel_in_some_part(labels, label, points, locked):
    locked &= set(np.unique(labels).tolist())
    after = _applied(labels, split(labels, label, points, locked))
    _locked_unchanged(labels, after, locked)
    block = labels == label
    assert np.array_equal(after[~block], labels[~block])
    if label:
        assert (after[block] > 0).all()
        fresh = set(np.unique(after)) - set(np.unique(labels))
        assert all(number > labels.max() for number in fresh)
        for number in fresh:
            assert components(after == number)[1] == 1


@pytest.mark.parametrize("points", [[(5.0, 5.0), (15.0, 5.0)], [(40.0, 40.0), (50.0, 50.0)]])
def test_a_line_that_does_not_part_the_block_changes_nothing(points):
    assert split(np.ones((20, 30), np.int32), 1, points) is None


@holds_for(strokes)
def test_a_stroke_is_all_that_lies_near_the_line_or_under_its_points(stroke):
    """Against the distance of every pixel of the frame from every segment, but for those on the very rim."""
    points, radius = stroke
    centres = np.moveaxis(np.mgrid[: SHAPE[0], : SHAPE[1]][::-1] + 0.5, 0, -1)
    distance = np.full(SHAPE, np.inf)
    for start, end in zip(points, points[1:] or points, strict=False):
        along = np.subtract(end, start)
        share = np.clip((centres - start) @ along / max(along @ along, 1e-300), 0, 1)
        nearest = start + share[..., None] * along
        distance = np.minimum(distance, np.linalg.norm(centres - nearest, axis=-1))
    wanted = distance <= radius
    for x, y in points:
        if 0 <= x < SHAPE[1] and 0 <= y < SHAPE[0]:
            wanted[int(y), int(x)] = True
    swept = np.zeros(SHAPE, bool)
    if (found := brush_stroke(SHAPE, points, radius)) is not None:
        swept[found.box] = found.mask
        assert found.mask.any()
    sure = np.abs(distance - radius) > 1e-6
    assert np.array_equal(swept[sure], wanted[sure])


def test_the_largest_part_keeps_the_label_and_others_get_new_ones_by_size():
    labels = np.zeros((9, 20), np.int32)
    labels[1:8, 1:19] = 4
    labels[0] = 6
    cut = [(5.5, -1.0), (5.5, 9.0), (5.5, 3.5), (20.0, 3.5)]  # left; and right, above and below the line
    patch = split(labels, 4, cut)
    after = _applied(labels, patch)
    assert set(np.unique(after)) == {0, 4, 6, 7, 8}
    # 52, 28 and 26 pixels without the line's own
    assert (after[6, 10], after[4, 2], after[1, 10]) == (4, 7, 8)
    assert np.isin(after[1:8, 1:19], (4, 7, 8)).all()
    assert (after[0] == 6).all()
    numbered = _applied(labels, split(labels, 4, cut, first_new=30))
    assert np.array_equal(np.where(numbered >= 30, numbered - 23, numbered), after)


def test_only_the_piece_that_the_line_crosses_is_cut():
    labels = np.zeros((8, 20), np.int32)
    labels[:, :8] = labels[:, 12:] = 3
    after = _applied(labels, split(labels, 3, [(4.0, -1.0), (4.0, 9.0)]))
    assert (after[:, 12:] == 3).all()
    assert set(np.unique(after[:, :8])) == {3, 4}
    assert split(labels, 3, [(4.0, -1.0), (4.0, 9.0)], locked={3}) is None
    assert split(labels, 0, [(10.0, -1.0), (10.0, 9.0)]) is None
    assert split(labels, 9, [(4.0, -1.0), (4.0, 9.0)]) is None


FRAME = RGBDFrame(
    np.random.default_rng(0).integers(0, 255, (*SHAPE, 3), np.uint8),
    np.random.default_rng(1).choice([np.nan, 1.0, 1.5, 2.0], SHAPE),
)
"""Its colours and depths fit nothing."""

EDITS = {
    "paint": lambda labels, at, label, locked: None if label in locked else paint(labels, at.stroke, label, locked),
    "erase": lambda labels, at, label, locked: erase(labels, at.stroke, label, locked),
    "fit": lambda labels, at, label, locked: erase(labels, at.stroke, label, locked, frame=FRAME),
    "give": lambda labels, at, label, locked: give(labels, at.swept, label, locked),
    "outline": lambda labels, at, label, locked: assign_outline(labels, at.points, label, locked),
    "border": lambda labels, at, _, locked: redraw_border(labels, at.points, locked),
    "split": lambda labels, at, label, locked: split(labels, label, at.points, locked),
    "clean": lambda labels, at, _, locked: clean_up(labels, int(4 * at.size), locked),
    "grow": lambda labels, at, label, locked: grow(labels, label, at.size, locked),
    "shrink": lambda labels, at, label, locked: shrink(labels, label, at.size, locked),
    "smooth": lambda labels, at, label, locked: smooth(labels, label, at.size, locked),
    "merge": lambda labels, _, label, locked: merge(labels, [label, 1, 2], locked),
    "delete": lambda labels, _, label, locked: delete(labels, [label], locked),
}
"""What may be done at some place to a block, while others are locked."""
steps = st.tuples(
    st.sampled_from(sorted(EDITS)),
    st.lists(coordinates, min_size=2, max_size=5),
    st.integers(0, 5),
    st.floats(0.5, 6),
    locks,
)


def _edit(labels, kind, points, label, size, locked):
    stroke = brush_stroke(SHAPE, points, size) or Region((slice(0, 1), slice(0, 1)), np.zeros((1, 1), bool))
    swept = np.zeros(SHAPE, bool)
    swept[stroke.box] = stroke.mask
    return EDITS[kind](labels, SimpleNamespace(points=points, size=size, stroke=stroke, swept=swept), label, locked)


@settings(max_examples=50)
@holds_for(label_maps, st.lists(steps, min_size=3, max_size=12))
def test_any_edits_in_a_row_keep_a_partition_and_are_undone_and_redone(labels, sequence):
    labels[3:11, 2:12] = 3  # something that is no mere noise
    states, patches = [labels.copy()], []
    for kind, points, label, size, locked in sequence:
        before = labels.copy()
        # a new block may get a number that is locked but that no block has
        present = locked & set(np.unique(labels).tolist())
        patch = _edit(labels, kind, points, label, size, present)
        assert np.array_equal(labels, before), "an edit gives a patch and changes nothing itself"
        if patch is None:
            continue
        assert np.array_equal(patch.before, labels[patch.box])
        patch.apply(labels)
        assert (labels.dtype, labels.shape) == (np.int32, SHAPE)
        assert labels.min() >= 0
        _locked_unchanged(before, labels, present)
        if kind in ("split", "shrink", "smooth"):
            assert (labels == label).any(), "a block is not lost by the way"
        rows, columns = np.nonzero(labels != before)
        assert patch.box == (slice(rows.min(), rows.max() + 1), slice(columns.min(), columns.max() + 1)), (
            "the box is the smallest"
        )
        states.append(labels.copy())
        patches.append(patch)
    for patch, state in zip(reversed(patches), reversed(states[:-1]), strict=True):
        patch.revert(labels)
        assert np.array_equal(labels, state)
    for patch, state in zip(patches, states[1:], strict=True):
        patch.apply(labels)
        assert np.array_equal(labels, state)


def test_an_outline_takes_the_pixels_whose_centre_it_goes_around():
    labels = np.zeros((10, 12), np.int32)
    after = _applied(labels, assign_outline(labels, [(2.4, 3.4), (7.6, 3.4), (7.6, 6.6), (2.4, 6.6)], 7))
    wanted = np.zeros_like(labels)
    wanted[3:7, 2:8] = 7
    assert np.array_equal(after, wanted)
    bow_tie = enclosed([(0, 0), (10, 10), (10, 0), (0, 10)], (10, 10))
    assert (bow_tie.mask[5, 1], bow_tie.mask[5, 8], bow_tie.mask[1, 5]) == (True, True, False)
    for line in ([], [(2.0, 2.0), (8.0, 8.0)], [(20.0, 1.0), (30.0, 1.0), (25.0, 9.0)]):
        assert enclosed(line, (10, 10)) is None
    assert assign_outline(labels, [(0, 0), (9, 0), (9, 9)], 7, locked={7}) is None


def test_a_split_is_led_on_to_the_boundary_when_it_stops_just_short():
    labels = np.zeros((40, 60), np.int32)
    labels[5:35, 5:55] = 1
    for short in (0.0, 2.0, 4.0):
        after = _applied(labels, split(labels, 1, [(30.0, 5 + short), (30.0, 35 - short)]))
        assert set(np.unique(after)) == {0, 1, 2}
    assert split(labels, 1, [(30.0, 15.0), (30.0, 35.0)]) is None
    after = _applied(labels, split(labels, 1, [(5.0, 20.0), (20.0, 20.0), (30.0, 8.0), (40.0, 20.0), (55.0, 20.0)]))
    assert after[6, 30] != after[30, 30], "a bent line"


def test_a_block_gets_the_part_that_is_beside_it():
    labels = np.full((40, 60), 2, np.int32)
    labels[:, :10], labels[:20, 50:] = 1, 3
    line = [(40.5, -1.0), (40.5, 41.0)]
    after = _applied(labels, cut_off(labels, 2, line, 1))
    assert (after[:, 10:40] == 1).all(), "the larger part, as the smaller one is nowhere near"
    assert (after[20:, 42:] == 2).all()
    after = _applied(labels, cut_off(labels, 2, line, 3))
    assert (after[:, 42:] == 3).all()
    assert (after[:, 10:40] == 2).all()
    after = _applied(labels, cut_off(labels, 2, [(-1.0, 33.5), (61.0, 33.5)], 1))
    assert (after[35:, 10:] == 1).all(), "beside both parts, it gets the smaller one"
    assert (after[:33, 10:50] == 2).all()
    after = _applied(labels, cut_off(labels, 2, line, 7))
    assert (after[20:, 42:] == 7).all(), "all but the largest part, for a block that is nowhere"
    assert (after[:, 10:40] == 2).all()


def test_open_ends_run_on_through_what_the_block_goes_around():
    labels = np.zeros((40, 60), np.int32)
    labels[5:35, 5:55] = 1
    labels[25:30, 25:35] = 2
    line = [(30.0, 12.0), (30.0, 20.0)]
    assert split(labels, 1, line) is None
    whole = extend_to_boundary(labels, 1, line)
    assert whole[1:-1] == line
    (x0, y0), (x1, y1) = whole[0], whole[-1]
    assert (x0, x1) == (30, 30)
    assert y0 < 5
    assert y1 >= 35
    after = _applied(labels, split(labels, 1, whole))
    assert after[10, 10] != after[10, 50]
    assert (after[25:30, 25:35] == 2).all()
    assert extend_to_boundary(labels, 1, whole) == whole, "its ends are off the block"
    assert extend_to_boundary(labels, 9, line) == line
    near = [(50.0, 12.0), (50.0, 20.0)]
    assert extend_to_boundary(labels, 1, near, 6.0)[-1][0] > 55, "the boundary beside it is 5 px away, that ahead 15 px"
    assert extend_to_boundary(labels, 1, near, 3.0)[-1][1] >= 35


def test_pixels_that_touch_their_block_nowhere_or_at_a_point_lie_apart():
    labels = np.ones((40, 60), np.int32)
    labels[:, 30:] = 2
    for box, apart in ((np.s_[10:20, 25:30], 0), (np.s_[10:20, 5:15], 100), (np.s_[10:11, 29:30], 0)):
        after = labels.copy()
        after[box] = 2
        patch = patch_between(labels, after)
        assert pixels_apart(labels, patch, 2) == apart
        assert pixels_apart(labels, patch, 1) == 0
    diamond = np.abs(np.arange(40)[:, None] - 20) + np.abs(np.arange(60) - 19) <= 10
    assert pixels_apart(labels, patch_between(labels, np.where(diamond, 2, labels).astype(np.int32)), 2) == 221
    assert pixels_apart(labels, patch_between(labels, np.where(labels == 1, 5, labels)), 5) == 0, "a new block"
    assert pixels_apart(labels, None, 1) == 0


def test_islands_slivers_and_holes_go_where_they_belong():
    clean = np.ones((40, 60), np.int32)
    clean[:, 30:] = 2
    labels = clean.copy()
    labels[5:8, 5:8] = 2  # an island of a block
    labels[20:23, 10:14] = 0  # a hole
    labels[10:12, 30:38] = 1  # a sliver, stuck into the other block
    labels[30:32, 40:42] = 9  # a block that is too small
    assert count_slivers(labels, 20) == 4
    assert np.array_equal(_applied(labels, clean_up(labels, 20)), clean)
    assert count_slivers(labels, 5) == 1, "just the block of 4 pixels is as small as that"
    box = slice(35, 38), slice(2, 5)
    assert count_slivers(labels, 20, box) == 1, "in and around the box"


def test_cleaning_up_leaves_necks_large_things_and_locked_blocks():
    labels = np.ones((40, 60), np.int32)
    labels[5:15, 5:20] = labels[5:15, 30:45] = labels[9:11, 20:30] = 2  # two parts and what holds them together
    labels[25:35, 10:30] = 0
    assert clean_up(labels, 30) is None
    labels[20:22, 50:52] = 3
    assert clean_up(labels, 30, locked={3}) is None
    assert clean_up(labels, 30, locked={1}) is None
    assert clean_up(labels, 30) is not None


def test_growing_and_shrinking_move_an_outline_by_so_many_pixels():
    labels = np.ones((30, 50), np.int32)
    labels[10:20, 20:30] = 2
    labels[:, 45:] = 3
    grown = _applied(labels, grow(labels, 2, 3))
    assert (grown[15, 17:33] == 2).all()
    assert (grown[15, [16, 33]] == 1).all()
    shrunk = _applied(labels, shrink(labels, 3, 2))
    assert np.array_equal(shrunk[5], np.r_[np.ones(47), 3, 3, 3]), "it stays at the rim, and the neighbour follows"
    assert shrink(labels, 2, 5) is None, "nothing would be left"
    alone = np.where(labels == 2, labels, 0).astype(np.int32)
    assert np.count_nonzero(_applied(alone, shrink(alone, 2, 1))) == 64
    assert shrink(labels, 2, 1, locked={1}) is None


def test_smoothing_takes_what_is_fine_and_leaves_what_is_straight():
    rows, columns = np.mgrid[:60, :80] + 0.5
    straight = np.where(columns < 40, 1, 2).astype(np.int32)
    assert smooth(straight, 1, 4) is None
    jagged = np.where(columns < 40 + 2 * (rows % 6 < 3), 1, 2).astype(np.int32)
    after = _applied(jagged, smooth(jagged, 1, 4))
    assert len(np.unique((after[10:50] == 1).sum(axis=1))) == 1
    assert smooth(jagged, 1, 4, locked={2}) is None


def test_erased_pixels_go_to_the_neighbour_they_fit():
    rgb = np.zeros((30, 60, 3), np.uint8)
    rgb[:, 24:] = 180
    labels = np.full((30, 60), 1, np.int32)
    labels[:, 20:40] = 2
    labels[:, 40:] = 3
    frame = RGBDFrame(rgb, np.where(rgb[..., 0] > 0, 2.0, 1.0))
    stroke = Region((slice(8, 22), slice(20, 40)), np.ones((14, 20), bool))
    after = _applied(labels, erase(labels, stroke, 2, frame=frame))
    assert np.isin(after[8:22, 20:40], (1, 3)).all()
    assert (after[8:22, 20:23] == 1).all()
    assert (after[8:22, 25:40] == 3).all()
    hole = Region((slice(10, 14), slice(28, 32)), np.ones((4, 4), bool))
    assert (_applied(labels, erase(labels, hole, 2, frame=frame))[10:14, 28:32] == 0).all(), "no neighbour is near"


def test_parts_touch_where_they_share_a_side_of_a_pixel():
    labels = np.zeros((6, 9), np.int32)
    labels[:3, :3], labels[3:, 3:6], labels[:3, 3:6] = 1, 2, 3
    assert parts_touch(labels, [1, 3])
    assert not parts_touch(labels, [1, 2])
    assert parts_touch(labels, [1, 2, 3])


@holds_for(label_maps, steps, st.integers(1, 9), st.integers(0, 40), arrays(np.bool_, SHAPE))
def test_a_tidied_edit_leaves_no_block_that_cannot_be_completed_and_keeps_what_was_drawn(
    labels, step, smallest, smallest_block, known
):
    labels[3:11, 2:12] = 3  # something that is no mere noise
    kind, points, label, size, locked = step
    locked &= set(np.unique(labels).tolist())
    patch = _edit(labels, kind, points, label, size, locked)
    if patch is None:
        return
    before = labels.copy()
    whole = tidied(labels, patch, smallest, known=known, smallest_block=smallest_block, locked=locked)
    assert np.array_equal(labels, before), "it gives a patch and changes nothing itself"
    assert np.array_equal(patch.before, labels[patch.box])
    after = _applied(labels, whole)
    _locked_unchanged(labels, after, locked)
    assert set(np.unique(after)) <= {*np.unique(labels), *np.unique(patch.after)}, "it makes no block"
    if not locked and np.unique(after).size > 2:
        for one in np.unique([*patch.before.ravel(), *patch.after.ravel()]):
            block = after == one
            assert not one or not block.any() or block.sum() >= smallest_block or known[block].any()
    if kind in ("paint", "give", "outline") and label not in locked and label:
        target = tidied(labels, patch, smallest, known=known, smallest_block=smallest_block, label=label, locked=locked)
        edited = _applied(labels, patch)
        if (edited == label).any():
            assert (_applied(labels, target) == label).any(), "the block that was drawn stays"


WALL = np.ones((60, 80), np.int32)
WALL[:, 40:] = 2


def _change(labels, *changes):
    after = labels.copy()
    for rows, columns, label in changes:
        after[rows, columns] = label
    return patch_between(labels, after)


def test_what_an_edit_cuts_off_goes_with_it_and_what_was_there_before_stays():
    labels = WALL.copy()
    labels[50:52, 60:62] = 3  # an island that was there
    patch = _change(labels, (slice(10, 40), slice(41, 60), 4), (slice(5, 7), slice(70, 72), 4))
    assert count_slivers(_applied(labels, patch), 40) > count_slivers(labels, 40)
    after = _applied(labels, tidied(labels, patch, 40, label=4))
    assert (after[10:40, 40] != 2).all(), "the strip between two blocks"
    assert after[5, 70] == 2, "a speck beside the object"
    assert (after[50:52, 60:62] == 3).all()
    assert (after[10:40, 41:60] == 4).all()


def test_of_a_block_that_is_covered_the_rest_beside_goes_too():
    labels = WALL.copy()
    covered = _change(labels, (slice(0, 57), slice(40, 80), 4))
    assert set(np.unique(_applied(labels, tidied(labels, covered, 1, label=4)))) == {1, 4}
    labels[:9, :10] = 2  # a part of the block that is elsewhere
    covered = _change(labels, (slice(0, 60), slice(41, 80), 4))
    after = _applied(labels, tidied(labels, covered, 1, label=4))
    assert np.array_equal(after == 2, (labels == 2) & (np.arange(80) < 10))
    half = _change(WALL, (slice(0, 50), slice(40, 80), 4))
    assert (_applied(WALL, tidied(WALL, half, 1, label=4))[50:, 40:] == 2).all(), "a sixth is no rest"
