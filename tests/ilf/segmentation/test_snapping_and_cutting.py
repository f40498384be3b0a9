"""Help for editing that looks at colour and depth: pieces, similar pixels, snapping, splits that are suggested."""

import numpy as np
import pytest

from ilf.data.frame import RGBDFrame
from ilf.segmentation.editing.cutting import piece_at, split, suggest_split
from ilf.segmentation.editing.snapping import border_evidence, similar_pixels, snap

SHAPE = (80, 120)
ROWS, COLUMNS = np.mgrid[:80, :120] + 0.5
WEAK = np.zeros(SHAPE, np.float32)
GREY = np.full((*SHAPE, 3), 120, np.uint8)


def _frame(depth: np.ndarray, rgb: np.ndarray = GREY) -> RGBDFrame:
    return RGBDFrame(rgb, depth)


def test_a_piece_is_the_connected_part_under_the_point():
    labels = np.array([[1, 1, 2, 1], [2, 1, 2, 1]], np.int32)
    assert piece_at(labels, 0.5, 0.5).tolist() == [[True, True, False, False], [False, True, False, False]]
    assert piece_at(labels, 3.9, 1.0).sum() == 2
    regions = np.array([[5, 5, 5, 5], [5, 6, 6, 0]], np.int32)
    assert piece_at(labels, 0.5, 0.5, regions).sum() == 2, "only as far as the region goes"
    assert piece_at(labels, 3.5, 1.5, regions).sum() == 2, "there is no region"
    for x, y in ((-0.1, 0.5), (4.0, 0.5), (0.5, 2.0)):
        assert not piece_at(labels, x, y).any()


def test_a_stroke_is_kept_from_other_colours_depths_and_beyond_edges():
    rgb = GREY.copy()
    rgb[:, 90:] = (200, 40, 40)
    edge = WEAK.copy()
    edge[:, 20:22] = 0.9
    frame = _frame(np.where(COLUMNS < 60, 1.0, 2.0), rgb)
    inside = np.flatnonzero(similar_pixels(frame, edge, 40.5, 40.5)[10:70].all(axis=0))
    assert 20 <= inside[0] <= 22
    assert inside[-1] == 59
    columns = np.flatnonzero(similar_pixels(frame, edge, 75.5, 40.5).any(axis=0))
    assert columns[0] in (60, 61)
    assert 85 <= columns[-1] <= 90
    assert similar_pixels(frame, edge, -5, 40.5).all()


@pytest.mark.parametrize("by", ["depth", "colour", "strength"])
def test_a_line_snaps_to_what_speaks_for_a_border(by):
    step = COLUMNS < 60
    strength = np.float32(0.8) * (np.abs(COLUMNS - 60) < 1) if by == "strength" else WEAK
    rgb = np.where(step[..., None], 60, 180).repeat(3, axis=2).astype(np.uint8) if by == "colour" else GREY
    depth = np.where(step, 1.0, 2.0) if by == "depth" else np.where(np.abs(COLUMNS - 60) < 25, np.nan, 1.0)
    evidence = border_evidence(_frame(depth, rgb), strength.astype(np.float32))
    drawn = [(56.0, 5.0), (62.0, 30.0), (57.0, 50.0), (63.0, 75.0)]
    snapped = np.array(snap(drawn, evidence, 8))
    assert np.abs(snapped[:, 0] - 60).max() < 1.2
    assert snap(drawn, evidence, 0) == drawn
    held = np.array(snap([(55.0, 5.0), (55.0, 75.0)], evidence, 2))
    assert np.abs(held[:, 0] - 55).max() <= 2


def test_depth_outweighs_a_colour_edge_on_a_surface():
    rgb = np.where((COLUMNS < 54)[..., None], 60, 180).repeat(3, axis=2).astype(np.uint8)
    evidence = border_evidence(_frame(np.where(COLUMNS < 60, 1.0, 2.0), rgb), WEAK)
    snapped = np.array(snap([(56.0, 5.0), (56.0, 75.0)], evidence, 8))
    assert np.abs(snapped[:, 0] - 60).max() < 1.2


@pytest.mark.parametrize("what", ["jump", "fold"])
def test_two_surfaces_in_a_block_are_parted_where_they_meet(what):
    right = COLUMNS > 70
    depth = np.where(right, 2.0, 1.2) if what == "jump" else 1 / (0.5 + 0.004 * np.abs(COLUMNS - 70))
    depth = depth + np.random.default_rng(0).normal(0, 0.002, SHAPE)
    depth[30:40, 50:90] = np.nan
    labels = np.zeros(SHAPE, np.int32)
    labels[5:75, 10:110] = 3
    points = suggest_split(_frame(depth), labels, 3, WEAK)
    patch = split(labels, 3, points)
    patch.apply(labels)
    assert set(np.unique(labels)) == {0, 3, 4}
    wrong = (labels > 0) & ((labels == 4) != (right == (labels[50, 100] == 4)))
    assert wrong.sum() / 70 < 3, "a line at most three pixels off"


@pytest.mark.parametrize("what", ["plane", "curved", "unknown"])
def test_one_surface_suggests_no_split(what):
    depth = 1 / (0.5 + 0.002 * COLUMNS + 0.001 * ROWS)
    if what == "curved":
        depth = 1.5 - 0.3 * np.sqrt(np.maximum(1 - ((COLUMNS - 60) / 80) ** 2, 0))
    depth = depth + np.random.default_rng(0).normal(0, 0.002, SHAPE)
    if what == "unknown":
        depth[3:] = np.nan
    labels = np.ones(SHAPE, np.int32)
    assert suggest_split(_frame(depth), labels, 1, WEAK) is None
    assert suggest_split(_frame(depth), labels, 7, WEAK) is None


def test_a_stroke_goes_no_farther_into_an_edge_than_to_the_jump_in_it():
    depth = np.full((20, 24), 1.0)
    depth[:, 11:] = 1.06
    frame = RGBDFrame(np.full((20, 24, 3), 90, np.uint8), depth)
    strength = np.zeros(depth.shape, np.float32)
    strength[:, 10:16] = 1
    mask = similar_pixels(frame, strength, 3.5, 10.5)
    assert mask[10, 10], "colour and depth are alike"
    assert not mask[:, 11:].any()
