"""Refining borders inside a band, on frames whose true border is known."""

import numpy as np
import pytest
from skimage.measure import label as connected_regions

from ilf.data.frame import RGBDFrame
from ilf.segmentation.editing.painting import brush_stroke
from ilf.segmentation.editing.refining import refine_borders
from ilf.segmentation.editing.snapping import border_evidence

EDGE = 30
"""The column of the edge of `small_frame`."""


def _evidence(frame):
    return border_evidence(frame, np.zeros(frame.shape, np.float32))


def _band(shape, *points, radius=6):
    return brush_stroke(shape, points, radius)


@pytest.fixture
def shifted():
    """The border of `small_frame` is off by 4 px."""
    labels = np.ones((48, 64), np.int32)
    labels[:, EDGE + 4 :] = 2
    return labels


def _after(frame, labels, band, locked=()):
    after = labels.copy()
    patch = refine_borders(frame, _evidence(frame), labels, band, locked)
    if patch is not None:
        patch.apply(after)
    return after


def test_only_the_band_changes_and_its_border_is_at_the_edge(small_frame, shifted):
    band = _band(small_frame.shape, (33, 10), (33, 38))
    after = _after(small_frame, shifted, band)
    outside = np.ones(shifted.shape, bool)
    outside[band.box] = ~band.mask
    assert np.array_equal(after[outside], shifted[outside])
    assert (after[12:36, EDGE:] == 2).all(), "the border lies at the edge"
    assert (after[12:36, :EDGE] == 1).all()


def test_where_depth_is_missing_colour_decides_and_without_an_edge_the_border_stays(shifted):
    rgb = np.where(np.arange(64)[None, :, None] < EDGE, [200, 90, 40], [40, 110, 180]).astype(np.uint8)
    depth = np.full((48, 64), np.nan, np.float32)
    depth[:, :2] = 1.5
    frame = RGBDFrame(np.broadcast_to(rgb, (48, 64, 3)).copy(), depth)
    assert (_after(frame, shifted, _band((48, 64), (33, 10), (33, 38)))[12:36, EDGE:] == 2).all()
    flat = RGBDFrame(np.full((48, 64, 3), 90, np.uint8), np.full((48, 64), 1.5, np.float32))
    moved = _after(flat, shifted, _band((48, 64), (34, 10), (34, 38))) != shifted
    assert np.count_nonzero(moved[12:36]) <= 24, "at most a pixel per row"


def test_the_blocks_of_three_meet_at_their_edges(small_frame):
    rgb = small_frame.rgb.copy()
    rgb[24:, EDGE:] = (230, 220, 60)
    truth = np.ones((48, 64), np.int32)
    truth[:24, EDGE:], truth[24:, EDGE:] = 2, 3
    frame = RGBDFrame(rgb, small_frame.depth)
    labels = np.roll(truth, (3, 3), (0, 1))
    labels[:3], labels[:, :3] = labels[3], 1
    after = _after(frame, labels, _band(truth.shape, (32, 12), (32, 36)))
    beside = np.ones(truth.shape, bool)
    beside[:, EDGE - 1 : EDGE + 1] = False
    beside[22:26] = False
    wrong = [np.count_nonzero((found != truth)[14:34, 28:37] & beside[14:34, 28:37]) for found in (labels, after)]
    assert wrong[0] > 30
    assert wrong[1] == 0, "right to the pixel beside the edges"


def test_locked_blocks_and_bands_without_a_border_stay(small_frame, shifted):
    evidence, band = _evidence(small_frame), _band(small_frame.shape, (33, 10), (33, 38))
    assert refine_borders(small_frame, evidence, shifted, band, [2]) is None
    assert refine_borders(small_frame, evidence, shifted, _band(small_frame.shape, (10, 10), (10, 30))) is None
    three = shifted.copy()
    three[20:28] = 3
    after = _after(small_frame, three, band, locked=(3,))
    assert np.array_equal(after == 3, three == 3)
    assert (after[14:20, EDGE:] == 2).all()


def test_no_block_has_a_border_too_and_a_block_in_the_band_does_not_vanish(small_frame, shifted):
    band = _band(small_frame.shape, (33, 10), (33, 38))
    none = np.where(shifted == 1, 0, shifted).astype(np.int32)
    after = _after(small_frame, none, band)
    assert (after[12:36, EDGE:] == 2).all()
    assert (after[12:36, :EDGE] == 0).all()
    shifted[22:25, 32:35] = 7
    assert 7 in _after(small_frame, shifted, band)


def test_no_part_is_left_apart_from_its_block():
    rgb = np.full((40, 60, 3), 60, np.uint8)
    rgb[:, 28:] = 200
    rgb[16:24, 19:25] = 200  # like the right block, in the left one
    frame = RGBDFrame(rgb, np.where(rgb[..., 0] == 60, 1.5, 2.5))
    labels = np.ones((40, 60), np.int32)
    labels[:, 25:] = 2
    after = _after(frame, labels, _band((40, 60), (26, 6), (26, 34), radius=11))
    assert (after[18:22, 20:24] == 1).all()
    assert (after[10:14, 28:] == 2).all()
    assert connected_regions(after, connectivity=1).max() == 2
