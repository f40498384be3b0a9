"""EBS stage by stage, and what its label map promises."""

import numpy as np
import pytest
from scipy.ndimage import label as components

import ilf
from ilf.segmentation.edges.detectors import canny_edges, colour_gradient, gradient_strength, otsu_edges
from ilf.segmentation.edges.frame_edges import find_relief
from ilf.segmentation.extraction import find_margins, snap_to_jumps
from ilf.segmentation.merging import keep_existing

CANNY = ilf.BlockParameters(detector="canny")
"""For tests of what extraction makes of edges, whatever a network finds."""


@pytest.fixture
def frame():
    """120 x 160: a light square on a dark ground, and a depth jump that colour does not show."""
    rgb = np.full((120, 160, 3), 60, np.uint8)
    rgb[30:80, 20:70] = 200
    depth = np.full((120, 160), 2.0)
    depth[:, 110:] = 3.0
    depth[30:80, 20:70] = 1.5
    depth[40:60, 30:50] = np.nan
    return ilf.RGBDFrame(rgb, depth)


def test_blocks_follow_colour_and_depth(frame):
    blocks = ilf.extract_blocks(frame, CANNY)
    assert blocks.max() == 3
    square, ground, back = blocks[55, 45], blocks[100, 60], blocks[60, 140]
    assert len({int(square), int(ground), int(back)}) == 3
    assert (blocks[33:77, 23:67] == square).all()
    assert (blocks[:, 113:] == back).all()
    without_depth = ilf.extract_blocks(frame, CANNY.replace(use_depth=False))
    assert without_depth[60, 140] == without_depth[100, 60]


@pytest.mark.parametrize("margin", [0, 9, 25])
def test_blocks_are_watertight(frame, margin):
    """Every block is one 4-connected piece, so there is no way from one into another but over a boundary."""
    blocks = ilf.extract_blocks(frame, ilf.BlockParameters(margin=margin))
    for number in range(1, blocks.max() + 1):
        assert components(blocks == number)[1] == 1


def test_depth_that_goes_on_merges_what_colour_parts(frame):
    """A picture on a wall: one block where the depth is seen, two where colour alone counts."""
    flat = ilf.RGBDFrame(frame.rgb, np.full(frame.shape, 2.0))
    seen = ilf.extract_blocks(flat, CANNY)
    assert seen[55, 45] == seen[100, 60]
    colour = ilf.extract_blocks(flat, CANNY.replace(use_depth=False))
    assert colour[55, 45] != colour[100, 60]
    hidden = np.full(frame.shape, 2.0)
    hidden[22:88, 12:78] = np.nan
    hidden[40:70, 30:60] = 2.0
    one_plane = ilf.extract_blocks(ilf.RGBDFrame(frame.rgb, hidden))
    assert one_plane[55, 45] == one_plane[100, 60]
    hidden[40:70, 30:60] = 1.5
    two_planes = ilf.extract_blocks(ilf.RGBDFrame(frame.rgb, hidden))
    assert two_planes[55, 45] != two_planes[100, 60]


def test_a_crease_is_a_boundary_that_colour_does_not_show():
    rows = np.mgrid[:120, :160][0]
    depth = 1 / np.where(rows < 60, 0.5, 0.5 + 0.012 * (rows - 60))
    frame = ilf.RGBDFrame(np.full((120, 160, 3), 120, np.uint8), depth)
    blocks = ilf.extract_blocks(frame, ilf.BlockParameters(use_creases=True))
    assert blocks.max() == 2
    assert (blocks[:57, 12:-12] == blocks[0, 80]).all()
    assert (blocks[63:, 12:-12] == blocks[-1, 80]).all()
    assert ilf.extract_blocks(frame).max() == 1
    assert ilf.extract_blocks(frame, ilf.BlockParameters(use_creases=True, granularity=0.0)).max() == 1


def test_margin_belongs_to_no_block(frame):
    blocks = ilf.extract_blocks(frame, ilf.BlockParameters(margin=7))
    assert not blocks[:7].any()
    assert not blocks[:, -7:].any()
    assert blocks[7:-7, 7:-7].all()


def test_white_border_is_found_and_bright_walls_are_not_one(frame):
    framed = frame.rgb.copy()
    framed[:6] = framed[-5:] = 255
    framed[:, :4] = framed[:, -8:] = 255
    assert find_margins(framed) == (6, 5, 4, 8)
    assert find_margins(frame.rgb) == (0, 0, 0, 0)
    assert find_margins(np.full((100, 100, 3), 255, np.uint8)) == (0, 0, 0, 0)
    ceiling = frame.rgb.copy()
    ceiling[:10] = 255
    assert find_margins(ceiling) == (0, 0, 0, 0)


@pytest.mark.parametrize(("level", "dark", "expected"), [(240, 4, 3), (240, 5, 0), (239, 0, 0)])
def test_a_border_is_white_to_nine_tenths(level, dark, expected):
    """Lines of 40 pixels, of which 4 may be dark, and white from 240 on in all channels."""
    rgb = np.full((40, 40, 3), 100, np.uint8)
    for side in (rgb, rgb[::-1], rgb.swapaxes(0, 1), rgb[:, ::-1].swapaxes(0, 1)):
        side[:3] = 255
        side[:3, :, 1] = level
    for side in (rgb, rgb[::-1], rgb.swapaxes(0, 1), rgb[:, ::-1].swapaxes(0, 1)):
        side[:3, 18 : 18 + dark] = 0
    assert find_margins(rgb) == (expected,) * 4


@pytest.mark.parametrize(("width", "expected"), [(5, 5), (6, 0)])
def test_a_border_is_an_eighth_of_the_shorter_side_at_most(width, expected):
    rgb = np.full((40, 60, 3), 255, np.uint8)
    rgb[width:-width, width:-width] = 100
    assert find_margins(rgb) == (expected,) * 4


@pytest.mark.parametrize("shape", [(1, 1), (1, 2), (7, 1), (3, 3), (1, 50), (3, 40)])
def test_tiny_frames_have_blocks_all_over(shape):
    rgb = np.random.default_rng(3).integers(0, 255, (*shape, 3), dtype=np.uint8)
    frame = ilf.RGBDFrame(rgb, np.ones(shape))
    for detector in ("hed", "canny"):
        assert ilf.extract_blocks(frame, ilf.BlockParameters(detector=detector)).all()


def test_canny_finds_the_square_and_only_it(frame):
    gradient = colour_gradient(frame.rgb, 1.0)
    edges = canny_edges(*gradient, 0.0, 0.4)
    ring = np.zeros(frame.shape, bool)
    ring[27:83, 17:73] = True
    ring[33:77, 23:67] = False
    assert edges.any()
    assert not edges[~ring].any()
    assert gradient_strength(*gradient).max() == 1


def test_a_threshold_is_otsus_or_the_chosen_one():
    strength = np.zeros((10, 40), np.float32)
    strength[:, 10], strength[:, 20], strength[:, 30] = 0.2, 0.6, 0.9
    assert np.array_equal(np.flatnonzero(otsu_edges(strength, 0.7)[0]), [30])
    assert np.array_equal(np.flatnonzero(otsu_edges(strength, 0.1)[0]), [10, 20, 30])
    found = np.flatnonzero(otsu_edges(strength, 0.0)[0])
    assert {20, 30} <= set(found) <= {10, 20, 30}
    assert not otsu_edges(np.zeros((10, 40), np.float32), 0.0).any()


def test_no_depth_has_no_relief():
    relief = find_relief(np.full((20, 30), np.nan, np.float32), 0.04, 0.04)
    for picture in (relief.near, relief.edges, relief.evaluated, relief.bend):
        assert not picture.any()


def test_existence_rate_halves_blocks_and_drops_what_is_not_known():
    labels = np.ones((20, 80), np.int32)
    known = np.zeros((20, 80), bool)
    known[:, :30] = True
    assert np.array_equal(keep_existing(labels, known, 0.3, 1), labels)
    halved = keep_existing(labels, known, 0.52, 1)
    assert (halved[:, :38] == 2).all()
    assert not halved[:, 42:].any()
    twice = keep_existing(labels, known, 0.9, 1)
    assert (twice[:, :18] == 2).all()
    assert not twice[:, 22:].any()
    assert not keep_existing(labels, known, 0.9, 1000).any()
    assert not keep_existing(labels, np.zeros_like(known), 0.52, 1).any()


def test_boundaries_beside_a_jump_snap_to_it():
    """A boundary 4 px off a jump moves to it, and stays elsewhere; each region stays in one piece."""
    columns = np.mgrid[:40, :60][1]
    regions = np.where(columns < 30, 1, 2).astype(np.int32)
    right = np.zeros((40, 59), bool)
    right[:20, 33] = True
    nothing = np.zeros((39, 60), bool)
    snapped = snap_to_jumps(regions, (right, nothing))
    assert (snapped[:17, :34] == snapped[0, 0]).all()
    assert (snapped[:17, 34:] == snapped[0, 59]).all()
    assert (snapped[26:, :30] == snapped[0, 0]).all()
    assert (snapped[26:, 30:] == snapped[0, 59]).all()
    assert snapped.max() == 2
    assert np.array_equal(snap_to_jumps(regions, (np.zeros_like(right), nothing)), regions)
    far = np.zeros_like(right)
    far[:, 50] = True
    assert np.array_equal(snap_to_jumps(regions, (far, nothing)) == snapped[0, 0], regions == 1)
    assert not snap_to_jumps(np.zeros_like(regions), (right, nothing)).any()


@pytest.mark.parametrize("turns", range(4))
def test_a_jump_that_ends_inside_a_region_divides_it(turns):
    """A fold of cloth, without an edge of colour: at its end the two sides meet."""
    rows, columns = np.mgrid[:120, :160]
    depth = np.rot90(2.0 + np.where(columns < 80, 0.0, 0.01 * np.maximum(90 - rows, 0)), turns)
    frame = ilf.RGBDFrame(np.full((*depth.shape, 3), 120, np.uint8), depth)
    blocks = np.rot90(ilf.extract_blocks(frame), -turns)
    assert blocks.max() == 2
    assert (blocks[:75, :80] == blocks[0, 0]).all()
    assert (blocks[:75, 80:] == blocks[0, -1]).all()
    assert blocks[0, 0] != blocks[0, -1]
