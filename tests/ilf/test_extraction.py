"""EBS stage by stage, and what its label map promises."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.ndimage import label as components

import ilf
from ilf.ebs import extract
from ilf.ebs.boundaries import contract, dilate, outlines, regions_between
from ilf.ebs.edges import canny_edges, colour_gradient, depth_edges, gradient_strength
from ilf.ebs.extraction import find_margins
from ilf.frame import RGBDFrame
from ilf.parameters import BlockParameters


@pytest.fixture
def frame() -> RGBDFrame:
    """120 x 160: a light square on a dark ground, and a depth jump that colour does not show."""
    rgb = np.full((120, 160, 3), 60, np.uint8)
    rgb[30:80, 20:70] = 200
    depth = np.full((120, 160), 2.0)
    depth[:, 110:] = 3.0
    depth[30:80, 20:70] = 1.5
    depth[40:60, 30:50] = np.nan
    return RGBDFrame(rgb, depth)


def test_every_stage_has_its_picture(frame: RGBDFrame) -> None:
    stages = extract(frame)
    for picture, kind in [
        (stages.strength, np.float32),
        (stages.edges, bool),
        (stages.dilated, bool),
        (stages.contracted, np.int32),
        (stages.blocks, np.int32),
    ]:
        assert picture.shape == frame.shape
        assert picture.dtype == kind
    assert 0 <= stages.strength.min() <= stages.strength.max() == 1
    assert (stages.dilated >= stages.edges).all()


def test_blocks_follow_colour_and_depth(frame: RGBDFrame) -> None:
    blocks = ilf.extract_blocks(frame)
    assert blocks.max() == 3
    square, ground, back = blocks[55, 45], blocks[100, 60], blocks[60, 140]
    assert len({int(square), int(ground), int(back)}) == 3
    assert (blocks[33:77, 23:67] == square).all()
    assert (blocks[:, 113:] == back).all()
    without_depth = ilf.extract_blocks(frame, BlockParameters(use_depth=False))
    assert without_depth[60, 140] == without_depth[100, 60]


def test_blocks_are_numbered_from_the_largest_and_cover_the_frame(frame: RGBDFrame) -> None:
    blocks = ilf.extract_blocks(frame)
    sizes = np.bincount(blocks.ravel())
    assert sizes[0] == 0
    assert (np.diff(sizes[1:]) <= 0).all()


@pytest.mark.parametrize("margin", [0, 9, 25])
def test_blocks_are_watertight(frame: RGBDFrame, margin: int) -> None:
    """Every block is one 4-connected piece, so there is no way from one into another but over a boundary."""
    blocks = ilf.extract_blocks(frame, BlockParameters(margin=margin))
    for number in range(1, blocks.max() + 1):
        assert components(blocks == number)[1] == 1


def test_small_regions_are_taken_in_by_neighbours(frame: RGBDFrame) -> None:
    blocks = ilf.extract_blocks(frame, BlockParameters(min_size=20.0))
    assert np.bincount(blocks.ravel())[1:].min() >= 0.2 * blocks.size
    assert (blocks > 0).all()


def test_regions_without_depth_are_taken_in_by_neighbours(frame: RGBDFrame) -> None:
    depth = frame.depth.copy()
    depth[28:82, 18:72] = np.nan
    dark = RGBDFrame(frame.rgb, depth)
    assert ilf.extract_blocks(dark)[55, 45] == ilf.extract_blocks(dark)[100, 60]
    own = ilf.extract_blocks(dark, BlockParameters(min_known_share=0.0))
    assert own[55, 45] != own[100, 60]


def test_margin_belongs_to_no_block(frame: RGBDFrame) -> None:
    blocks = ilf.extract_blocks(frame, BlockParameters(margin=7))
    assert not blocks[:7].any()
    assert not blocks[:, -7:].any()
    assert blocks[7:-7, 7:-7].all()


def test_white_border_is_found_and_bright_walls_are_not_one(frame: RGBDFrame) -> None:
    framed = frame.rgb.copy()
    framed[:6] = framed[-5:] = 255
    framed[:, :4] = framed[:, -8:] = 255
    assert find_margins(framed) == (6, 5, 4, 8)
    assert find_margins(frame.rgb) == (0, 0, 0, 0)
    assert find_margins(np.full((100, 100, 3), 255, np.uint8)) == (0, 0, 0, 0)
    ceiling = frame.rgb.copy()
    ceiling[:10] = 255
    assert find_margins(ceiling) == (0, 0, 0, 0)


def test_a_frame_without_any_edge_is_one_block() -> None:
    frame = RGBDFrame(np.full((40, 50, 3), 90, np.uint8), np.full((40, 50), 1.2))
    assert (ilf.extract_blocks(frame) == 1).all()


def test_one_pixel_frames_survive() -> None:
    frame = RGBDFrame(np.zeros((1, 1, 3), np.uint8), np.ones((1, 1)))
    assert ilf.extract_blocks(frame).shape == (1, 1)


def test_canny_finds_the_square_and_only_it(frame: RGBDFrame) -> None:
    gradient = colour_gradient(frame.rgb, 1.0)
    edges = canny_edges(*gradient, 0.0, 0.4)
    ring = np.zeros(frame.shape, bool)
    ring[27:83, 17:73] = True
    ring[33:77, 23:67] = False
    assert edges.any()
    assert not edges[~ring].any()
    assert gradient_strength(*gradient).max() == 1


def test_grey_image_has_no_colour_edges() -> None:
    gradient = colour_gradient(np.full((20, 20, 3), 77, np.uint8), 1.5)
    assert not canny_edges(*gradient, 0.0, 0.4).any()
    assert not gradient_strength(*gradient).any()


def test_depth_edges_need_known_depth_nearby() -> None:
    depth = np.full((40, 60), 1.0, np.float32)
    depth[:, 30:] = 2.0
    assert depth_edges(depth, 0.04, 0.04)[:, 28:31].any(axis=1).all()
    depth[:, 15:45] = np.nan
    assert not depth_edges(depth, 0.04, 0.04).any()


def test_depth_edges_scale_with_distance() -> None:
    depth = np.full((20, 40), 5.0, np.float32)
    depth[:, 20:] = 5.15
    assert not depth_edges(depth, 0.04, 0.04).any()
    assert depth_edges(depth, 0.04, 0.02).any()


def test_dilation_closes_gaps() -> None:
    edges = np.zeros((21, 21), bool)
    edges[10, :8] = edges[10, 12:] = True
    assert regions_between(dilate(edges, 0)).max() == 1
    assert regions_between(dilate(edges, 2)).max() == 2


def test_contraction_ends_on_the_strongest_line() -> None:
    strength = np.zeros((9, 21), np.float32)
    strength[:, 13] = 1.0
    regions = np.zeros((9, 21), np.int32)
    regions[:, 0], regions[:, 20] = 1, 2
    grown = contract(regions, strength)
    assert (grown[:, :13] == 1).all()
    assert (grown[:, 14:] == 2).all()
    assert not contract(np.zeros((4, 4), np.int32), strength[:4, :4]).any()


def test_outlines_are_between_labels() -> None:
    labels = np.ones((4, 6), np.int32)
    labels[:, 3:] = 2
    assert np.array_equal(np.flatnonzero(outlines(labels).any(axis=0)), [2])
