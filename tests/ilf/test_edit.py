"""Properties of block edits: what must hold for any label map and any edit."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from scipy.ndimage import label as components

from ilf.ebs.edit import LabelPatch, brush_stroke, delete, erase, merge, paint, patch_between, split

SHAPE = (14, 17)
label_maps = arrays(np.int32, SHAPE, elements=st.integers(0, 4))
coordinates = st.tuples(st.floats(-4, 21), st.floats(-4, 18))
strokes = st.tuples(st.lists(coordinates, min_size=1, max_size=4), st.floats(0, 6))
locks = st.sets(st.integers(1, 4), max_size=2)


def _applied(labels: np.ndarray, patch: LabelPatch | None) -> np.ndarray:
    """The map after the patch; checks that it can be taken back."""
    after = labels.copy()
    if patch is not None:
        patch.apply(after)
        back = after.copy()
        patch.revert(back)
        assert np.array_equal(back, labels)
        assert not np.array_equal(after, labels), "a patch that changes nothing should be None"
    return after


def _locked_unchanged(labels: np.ndarray, after: np.ndarray, locked: set[int]) -> None:
    for label in locked:
        assert np.array_equal(labels == label, after == label)


@given(label_maps, strokes, st.integers(0, 5), locks)
def test_painting_changes_only_the_stroke(
    labels: np.ndarray, stroke: tuple[list[tuple[float, float]], float], label: int, locked: set[int]
) -> None:
    swept = brush_stroke(SHAPE, *stroke)
    if swept is None:
        return
    locked -= {label}
    after = _applied(labels, paint(labels, swept, label, locked))
    _locked_unchanged(labels, after, locked)
    inside = np.zeros(SHAPE, bool)
    inside[swept.box] = swept.mask
    assert np.array_equal(after[~inside], labels[~inside])
    assert (after[inside & ~np.isin(labels, list(locked))] == label).all()


@given(label_maps, strokes, st.integers(1, 4), locks)
def test_erasing_takes_from_one_block_only(
    labels: np.ndarray, stroke: tuple[list[tuple[float, float]], float], label: int, locked: set[int]
) -> None:
    swept = brush_stroke(SHAPE, *stroke)
    if swept is None:
        return
    after = _applied(labels, erase(labels, swept, label, locked))
    _locked_unchanged(labels, after, locked)
    changed = labels != after
    assert (labels[changed] == label).all()
    assert (after[changed] == 0).all()


@given(label_maps, st.lists(st.integers(0, 5), max_size=4), locks)
def test_deleting_and_merging_move_whole_blocks(labels: np.ndarray, chosen: list[int], locked: set[int]) -> None:
    after = _applied(labels, delete(labels, chosen, locked))
    _locked_unchanged(labels, after, locked)
    doomed = set(chosen) - locked - {0}
    assert np.array_equal(after, np.where(np.isin(labels, list(doomed)), 0, labels))

    after = _applied(labels, merge(labels, chosen, locked))
    _locked_unchanged(labels, after, locked)
    assert np.array_equal(after == 0, labels == 0)


@given(label_maps, st.integers(0, 4), st.lists(coordinates, min_size=2, max_size=3), locks)
def test_splitting_keeps_every_pixel_in_some_part(
    labels: np.ndarray, label: int, points: list[tuple[float, float]], locked: set[int]
) -> None:
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


def test_split_parts_a_square_where_the_line_is() -> None:
    labels = np.ones((20, 30), np.int32)
    patch = split(labels, 1, [(10.0, -2.0), (10.0, 22.0)])
    assert patch is not None
    patch.apply(labels)
    assert set(np.unique(labels)) == {1, 2}
    assert (labels[:, 12:] == 1).all(), "the larger part keeps its number"
    assert (labels[:, :10] == 2).all()


@pytest.mark.parametrize("points", [[(5.0, 5.0), (15.0, 5.0)], [(40.0, 40.0), (50.0, 50.0)]])
def test_a_line_that_does_not_part_the_block_changes_nothing(points: list[tuple[float, float]]) -> None:
    assert split(np.ones((20, 30), np.int32), 1, points) is None


def test_brush_is_a_disc_around_the_pointer() -> None:
    stroke = brush_stroke((40, 40), [(20.5, 20.5)], 5.0)
    assert stroke is not None
    mask = np.zeros((40, 40), bool)
    mask[stroke.box] = stroke.mask
    rows, columns = np.mgrid[:40, :40]
    assert np.array_equal(mask, np.hypot(rows - 20, columns - 20) <= 5.0)


def test_tiny_brush_still_paints_the_pixel_under_the_pointer() -> None:
    stroke = brush_stroke((10, 10), [(3.95, 6.05)], 0.1)
    assert stroke is not None
    mask = np.zeros((10, 10), bool)
    mask[stroke.box] = stroke.mask
    assert np.argwhere(mask).tolist() == [[6, 3]]


@pytest.mark.parametrize("corner", [(0.02, 0.02), (9.98, 0.02), (0.02, 7.98), (9.98, 7.98)])
def test_tiny_brush_paints_the_corners_and_nothing_off_the_frame(corner: tuple[float, float]) -> None:
    stroke = brush_stroke((8, 10), [corner], 0.1)
    assert stroke is not None
    mask = np.zeros((8, 10), bool)
    mask[stroke.box] = stroke.mask
    assert np.argwhere(mask).tolist() == [[int(corner[1]), int(corner[0])]]
    assert brush_stroke((8, 10), [(corner[0] - 10 if corner[0] < 5 else corner[0] + 10, corner[1])], 0.1) is None
    assert brush_stroke((8, 10), [(corner[0], corner[1] - 0.5 if corner[1] < 5 else corner[1] + 0.5)], 0.1) is None


@given(strokes)
def test_a_stroke_is_all_that_lies_near_the_line_or_under_its_points(
    stroke: tuple[list[tuple[float, float]], float],
) -> None:
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


def test_the_largest_part_keeps_the_label_and_others_get_new_ones_by_size() -> None:
    labels = np.zeros((9, 20), np.int32)
    labels[1:8, 1:19] = 4
    labels[0] = 6
    cut = [(5.5, -1.0), (5.5, 9.0), (5.5, 3.5), (20.0, 3.5)]  # left; and right, above and below the line
    patch = split(labels, 4, cut)
    assert patch is not None
    after = _applied(labels, patch)
    assert set(np.unique(after)) == {0, 4, 6, 7, 8}
    # 52, 28 and 26 pixels without the line's own
    assert (after[6, 10], after[4, 2], after[1, 10]) == (4, 7, 8)
    assert np.isin(after[1:8, 1:19], (4, 7, 8)).all()
    assert (after[0] == 6).all()
    numbered = _applied(labels, split(labels, 4, cut, first_new=30))
    assert np.array_equal(np.where(numbered >= 30, numbered - 23, numbered), after)


def test_the_pixels_of_the_line_go_to_the_nearest_part() -> None:
    labels = np.ones((6, 9), np.int32)
    after = _applied(labels, split(labels, 1, [(5.5, 0.0), (5.5, 6.0)]))
    assert (after[:, :5] == 1).all()
    assert (after[:, 6:] == 2).all()
    assert set(np.unique(after[:, 5])) <= {1, 2}


def test_only_the_piece_that_the_line_crosses_is_cut() -> None:
    labels = np.zeros((8, 20), np.int32)
    labels[:, :8] = labels[:, 12:] = 3
    after = _applied(labels, split(labels, 3, [(4.0, -1.0), (4.0, 9.0)]))
    assert (after[:, 12:] == 3).all()
    assert set(np.unique(after[:, :8])) == {3, 4}
    assert split(labels, 3, [(4.0, -1.0), (4.0, 9.0)], locked={3}) is None
    assert split(labels, 0, [(10.0, -1.0), (10.0, 9.0)]) is None
    assert split(labels, 9, [(4.0, -1.0), (4.0, 9.0)]) is None


def test_strokes_off_the_frame_are_nothing() -> None:
    assert brush_stroke((10, 10), [(-50.0, -50.0), (-40.0, -60.0)], 4.0) is None


def test_equal_maps_need_no_patch() -> None:
    labels = np.ones((3, 3), np.int32)
    assert patch_between(labels, labels.copy()) is None
