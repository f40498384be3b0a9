"""What the network of BSDS500 learns from: boundaries that stay thin and in register, and images held out."""

import cv2
import numpy as np
import pytest
from recipes.bsds500_images import Example, boundary, consensus, random_sample


def disc() -> Example:
    """A bright disc on a dark ground, outlined by two annotators of three."""
    y, x = np.mgrid[:120, :160]
    inside = np.hypot(x - 80, y - 60) < 35
    rgb = np.where(inside[..., None], 230, 20).astype(np.uint8).repeat(3, axis=2)
    outlined = inside.astype(np.int16) + 1
    return Example("1", rgb, (outlined, outlined, np.ones_like(outlined)))


def test_a_boundary_is_one_pixel_wide():
    segmentation = np.ones((6, 8), np.int16)
    segmentation[:, 4:] = 2
    expected = np.zeros((6, 8), bool)
    expected[:, 3] = True
    np.testing.assert_array_equal(boundary(segmentation), expected)


def test_consensus_is_the_share_of_annotators():
    assert set(np.unique(consensus(disc().segmentations))) == {np.float32(0), np.float32(2 / 3)}


@pytest.mark.parametrize("seed", range(12))
def test_samples_keep_boundaries_thin_and_on_the_edge(seed):
    rgb, share = random_sample(disc(), 96, np.random.default_rng(seed))
    assert rgb.dtype == share.dtype == np.float32
    assert rgb.shape == (96, 96, 3)
    assert rgb.min() >= 0
    assert rgb.max() <= 1
    assert share.any()
    grey = cv2.GaussianBlur(rgb.mean(axis=2), (0, 0), 1)
    bright = (grey > (grey.min() + grey.max()) / 2).astype(np.uint8)
    edge = cv2.morphologyEx(bright, cv2.MORPH_GRADIENT, np.ones((3, 3), np.uint8))
    near = cv2.dilate(edge, np.ones((5, 5), np.uint8))
    # Where the outline runs along the border of the crop, the blurred picture cannot tell where it is.
    drawn, edge, near = share[4:-4, 4:-4] > 0, edge[4:-4, 4:-4], near[4:-4, 4:-4]
    assert near[drawn].all()
    # Half of the 2 px wide morphological outline, with room for its corners.
    assert 0.3 < drawn.sum() / edge.sum() < 0.85
