"""What the extraction takes from a frame's edges: strength, binarised edges and guide, against direct formulas."""

from typing import NamedTuple

import numpy as np
import pytest

from ilf.data.parameters import BlockParameters
from ilf.segmentation.edges.frame_edges import FrameEdges, Relief
from ilf.segmentation.extraction import edge_and_jump_strength, find_boundaries

SHAPE = (20, 30)


class Found(NamedTuple):
    """What boundaries are found from."""

    edges: FrameEdges
    lines: np.ndarray
    relief: Relief

    @property
    def detected(self) -> np.ndarray:
        """Strength by the detector."""
        return self.edges.detected


@pytest.fixture
def found():
    """Strengths at random, some lines of Canny, a long line of jumps and a short one, a crease and a bent pixel."""
    rng = np.random.default_rng(1)
    colour = rng.uniform(0, 1, (2, *SHAPE)).astype(np.float32)[0]
    lines = rng.random(SHAPE) < 0.2
    right = np.zeros((20, 29), bool)
    right[:, 8] = True
    long = right.copy()
    right[3:6, 20] = True
    below = np.zeros((19, 30), bool)
    bend = np.zeros(SHAPE, np.float32)
    bend[12:16, 10:25] = 3.0
    bend[2, 25] = 9.0
    bend[17, 3] = 0.9
    relief = Relief(
        np.ones(SHAPE, bool), (right, below), (long, below), np.ones(SHAPE, bool), bend, np.ones(SHAPE, np.float32)
    )
    return Found(FrameEdges(colour, colour, colour, "0" * 64), lines, relief)


def test_network_lines_of_canny_and_long_jumps_make_boundaries(found):
    edges, guide = find_boundaries(*found, BlockParameters(threshold=0.7))
    jumps = np.zeros(SHAPE, bool)
    jumps[:, 8] = True
    strength = edge_and_jump_strength(found.edges, found.relief, BlockParameters())
    np.testing.assert_array_equal(strength, np.where(jumps, 1, found.detected))
    np.testing.assert_array_equal(edges, (found.detected >= np.float32(0.7)) | jumps)
    raised = found.detected + np.float32(0.3) * found.lines.astype(np.float32)
    np.testing.assert_array_equal(guide, np.where(jumps, np.float32(1.5), raised))
    assert {strength.dtype, guide.dtype} == {np.dtype(np.float32)}


def test_creases_are_edges_but_not_single_pixels_and_stand_in_the_guide_by_their_sharpness(found):
    (usual, before), (edges, guide) = (
        find_boundaries(*found, BlockParameters(threshold=1.0, use_creases=on)) for on in (False, True)
    )
    crease = np.zeros(SHAPE, bool)
    crease[12:16, 10:25] = True
    np.testing.assert_array_equal(edges, usual | crease)
    bend = found.relief.bend
    np.testing.assert_allclose(
        guide, np.where(before == 1.5, 1.5, np.maximum(before, 0.9 * bend / (bend + 1.5))), rtol=1e-6
    )
    strengths = [
        edge_and_jump_strength(found.edges, found.relief, BlockParameters(use_creases=on)) for on in (False, True)
    ]
    np.testing.assert_array_equal(*strengths)
