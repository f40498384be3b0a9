"""Back-projection and axes."""

import numpy as np
import pytest

from ilf.data.camera import Camera
from ilf.data.points import FARTHEST, NEAREST, back_project, point_cloud
from ilf.errors import InputError

CAMERA = Camera(fx=100.0, fy=200.0, cx=2.0, cy=1.0)


def test_back_projection_by_hand():
    depth = np.full((3, 5), np.nan, np.float32)
    depth[1, 2], depth[0, 4], depth[2, 0] = 3.0, 2.0, 1.0
    depth[0, 0], depth[0, 1], depth[0, 2] = 0.0, -1.0, np.inf
    depth[1, 0], depth[1, 1] = NEAREST, FARTHEST
    rgb = np.arange(45, dtype=np.uint8).reshape(3, 5, 3)
    cloud = point_cloud(depth, rgb, CAMERA)
    expected = [[0.04, -0.01, 2.0], [0.0, 0.0, 3.0], [-0.02, 0.005, 1.0]]
    np.testing.assert_allclose(cloud.points, expected, rtol=1e-6)
    np.testing.assert_array_equal(cloud.colours, [rgb[0, 4], rgb[1, 2], rgb[2, 0]])
    assert (cloud.points.dtype, cloud.colours.dtype, len(cloud)) == (np.float32, np.uint8, 3)


def test_points_know_their_pixels_and_may_be_some_only():
    depth = np.array([[1.0, np.nan, 3.0], [4.0, 5.0, -1.0]], np.float32)
    only = np.array([[False, True, True], [True, False, True]])
    points, pixels = back_project(depth, CAMERA, only)
    assert pixels.tolist() == [2, 3]
    whole, everywhere = back_project(depth, CAMERA)
    assert everywhere.tolist() == [0, 2, 3, 4]
    np.testing.assert_array_equal(points, whole[[1, 2]])


def test_without_intrinsics_the_message_says_how_to_give_them():
    with pytest.raises(InputError, match=r"nyu-kinect-v1.*fx,fy,cx,cy.*file"):
        point_cloud(np.ones((2, 2)), np.zeros((2, 2, 3), np.uint8), None)


@pytest.mark.parametrize(
    ("depth", "rgb"),
    [
        (np.ones((2, 3)), np.zeros((2, 2, 3), np.uint8)),
        (np.ones((2, 2)), np.zeros((2, 2, 3))),
        (np.ones((2, 2, 1)), np.zeros((2, 2, 3), np.uint8)),
    ],
)
def test_shapes_that_do_not_fit(depth, rgb):
    with pytest.raises(InputError):
        point_cloud(depth, rgb, CAMERA)
