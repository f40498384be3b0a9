"""What the contour network learns from: generated pictures with exact lines, and real frames with measured jumps."""

import cv2
import numpy as np
import pytest
from recipes.contour_samples import REAL, SIDES, SMOOTH_RADIUS, generated_sample, real_sample, sample_of
from recipes.pictures import read_picture

from ilf.data.frame import RGBDFrame

from .tiny_data import write_picture


def test_lines_between_objects_are_borders_and_those_within_are_not(tmp_path):
    picture = read_picture(write_picture(tmp_path, 0))
    picture.thing[:, 80:] = 2
    _, lines, none, thing = sample_of(picture, np.zeros((64, 96, 3), np.float32))
    jump, crease, border = (lines[..., k] > 0 for k in range(3))
    assert border[0, 79], "two objects at the same depth"
    assert crease[0, 19]
    assert not border[0, 19], "two surfaces of one object"
    assert (border[:, :78] == jump[:, :78]).all()
    np.testing.assert_array_equal(none[..., 0] > 0, ~(jump | crease | border))
    assert set(np.unique(thing)) == {0, 1, 2}


@pytest.mark.parametrize("seed", range(3))
def test_samples_of_pictures_keep_colour_in_range_and_lines_thin(tmp_path, seed):
    image, lines, *_ = generated_sample(write_picture(tmp_path, 0), np.random.default_rng(seed))
    assert image.dtype == lines.dtype == np.float32
    assert 0 <= image.min() <= image.max() <= 1
    assert set(np.unique(lines)) <= {0, 1}
    assert 0 < lines.mean() < 0.1


def frame_with_a_step() -> RGBDFrame:
    """A box at 1 m in the middle of a wall at 2 m; no depth on the left."""
    depth = np.full((300, 400), 2, np.float32)
    depth[80:200, 160:300] = 1
    depth[:, :40] = np.nan
    rgb = np.full((300, 400, 3), 90, np.uint8)
    rgb[80:200, 160:300] = 180
    return RGBDFrame(rgb, depth)


@pytest.mark.parametrize("seed", range(3))
def test_samples_of_real_frames_have_the_measured_jumps_and_none_on_surfaces(seed):
    image, lines, none, thing = real_sample(frame_with_a_step(), np.random.default_rng(seed))
    assert image.shape == (*SIDES, 3)
    assert (thing == REAL).all()
    jump = lines[..., 0] > 0
    assert jump.any()
    np.testing.assert_array_equal(lines[..., 2] > 0, jump)
    assert none.any()
    far = cv2.distanceTransform((~jump).astype(np.uint8), cv2.DIST_L2, 5)
    assert far[none[..., 0] > 0].min() >= SMOOTH_RADIUS
    grey = cv2.GaussianBlur(image.mean(axis=2), (0, 0), 2)
    inside = cv2.erode((grey > (grey.min() + grey.max()) / 2).astype(np.uint8), np.ones((7, 7), np.uint8)) > 0
    assert not jump[inside].any(), "lines are where colour and depth change, not elsewhere"
