"""The depth-edge network: what it is told of the known depth, any size of frame, and files that are none."""

import cv2
import numpy as np
import pytest

from ilf._runtime.installation import asset_path
from ilf.errors import FormatError, InputError
from ilf.segmentation.edges.detectors import (
    DEPTH_CHANNELS,
    DEPTH_SCALES,
    DepthEdgeNetwork,
    depth_features,
    filled_log_depth,
)

from ..tiny_onnx import node, write_network

JUMP = node("ReduceMean", ["image"], "jump", axes=[1], keepdims=1)
CREASE = [node("ReduceMean", ["depth"], "mean", axes=[1], keepdims=1), node("Sigmoid", ["mean"], "crease")]
COARSE = [
    node("MaxPool", ["jump"], "pooled", kernel_shape=[4, 4], strides=[4, 4]),
    node("Concat", ["pooled", "pooled"], "coarse", axis=1),
]
INPUTS = {"image": 3, "depth": len(DEPTH_CHANNELS)}
LINES = {"jump": 1, "crease": 1}


def two_walls(height=48, width=64):
    """A wall at 1.5 m on the left, one at 2.4 m on the right, and a gap across where they meet."""
    depth = np.where(np.arange(width) < width // 2, 1.5, 2.4).astype(np.float32) * np.ones((height, 1), np.float32)
    depth[10:30, width // 2 - 8 : width // 2 + 12] = np.nan
    return depth


def feature(depth, name):
    return depth_features(depth)[DEPTH_CHANNELS.index(name)]


def test_features_know_no_scale():
    np.testing.assert_allclose(depth_features(two_walls()), depth_features(4 * two_walls()), atol=1e-5)


def test_features_of_known_depth_are_what_it_is():
    depth = two_walls()
    known = np.isfinite(depth)
    np.testing.assert_array_equal(feature(depth, "known"), known)
    expected = np.log(depth[known] / np.median(depth[known]))
    np.testing.assert_allclose(feature(depth, "filled")[known], expected, atol=1e-5)
    assert not feature(depth, "distance")[known].any()
    assert not feature(depth, "nearest")[known].any()
    # 2 of 5 columns of the square around the last near pixel are far
    row, column = 40, 31
    step = np.log(2.4 / 1.5)
    assert feature(depth, "fine relief")[row, column] == pytest.approx(max(-20 * 0.4 * step, -4), rel=1e-3)
    assert feature(depth, "wide relief")[row, column] == pytest.approx(-4 * 16 / 33 * step, rel=0.1)


def test_gaps_are_filled_from_around():
    depth = two_walls()
    missing = np.isnan(depth)
    filled = np.exp(filled_log_depth(depth)[0])
    assert filled[missing].min() >= 1.5 - 1e-5
    assert filled[missing].max() <= 2.4 + 1e-5
    assert filled[20, 25] < filled[20, 30] < filled[20, 42]
    # 5 px from the upper end of the gap, which is the nearest known depth
    assert feature(depth, "distance")[14, 33] == pytest.approx(np.log1p(5) / 4, rel=0.02)
    nearest = np.exp(feature(depth, "nearest") / 4 + np.log(filled))
    np.testing.assert_allclose(nearest[20, [25, 42]], [1.5, 2.4], rtol=1e-4)


@pytest.mark.parametrize("shape", [(1, 1), (1, 9), (7, 1), (33, 50)])
def test_features_of_depth_of_which_little_or_nothing_is_known(shape):
    depth = np.full(shape, np.nan, np.float32)
    assert np.isfinite(depth_features(depth)).all()
    depth[0, -1] = 3
    np.testing.assert_allclose(filled_log_depth(depth)[0], np.log(3), rtol=1e-5)
    assert np.isfinite(depth_features(depth)).all()


@pytest.fixture
def tiny(tmp_path):
    """A network of which every output is known: means of the image and of the features, and their largest of 4 x 4."""
    path = write_network(tmp_path / "tiny.onnx", [JUMP, *CREASE, *COARSE], INPUTS, {**LINES, "coarse": 2})
    return DepthEdgeNetwork.load(path)


def noise(height, width):
    return np.random.default_rng(0).integers(0, 256, (height, width, 3), np.uint8)


def at_all_scales(lines, rgb, depth):
    """The mean of lines that are found in the picture and in smaller ones of it."""
    found = []
    for scale in DEPTH_SCALES:
        size = round(rgb.shape[1] * scale), round(rgb.shape[0] * scale)
        small = (
            cv2.resize(rgb, size, interpolation=cv2.INTER_AREA),
            cv2.resize(depth, size, interpolation=cv2.INTER_NEAREST),
        )
        found.append(cv2.resize(lines(*small).astype(np.float32), rgb.shape[1::-1]))
    return np.mean(found, axis=0)


@pytest.mark.parametrize("size", [(48, 64), (64, 96), (97, 33)])
def test_every_pixel_stays_in_its_place(tiny, size):
    rgb, depth = noise(*size), two_walls(*size)
    found = tiny.look(rgb, depth)
    jump = at_all_scales(lambda rgb, _: rgb.mean(axis=2) / 255, rgb, depth)
    crease = at_all_scales(lambda _, depth: 1 / (1 + np.exp(-depth_features(depth).mean(axis=0))), rgb, depth)
    np.testing.assert_allclose(found[0], jump, atol=1e-6)
    np.testing.assert_allclose(found[1], crease, atol=1e-6)


def test_large_frames_are_made_smaller_and_come_back(tiny):
    rgb = np.full((40, 2000, 3), 51, np.uint8)
    found = tiny.look(rgb, np.full((40, 2000), 2, np.float32))
    np.testing.assert_allclose(found[0], np.full((40, 2000), 0.2), atol=1e-6)


def test_without_known_depth_there_are_lines_too(tiny):
    found = tiny.look(noise(32, 40), np.full((32, 40), np.nan, np.float32))
    assert found[0].shape == found[1].shape == (32, 40)


def test_a_network_of_lines_alone_is_one_too(tmp_path, tiny):
    network = DepthEdgeNetwork.load(write_network(tmp_path / "lines.onnx", [JUMP, *CREASE], INPUTS, LINES))
    found, same = (one.look(noise(32, 40), two_walls(32, 40)) for one in (network, tiny))
    np.testing.assert_array_equal(found[0], same[0])


def test_depth_of_another_shape_is_refused(tiny):
    with pytest.raises(InputError, match="Depth is 41 x 32, but the image is 40 x 32"):
        tiny.look(noise(32, 40), two_walls(32, 41))


def test_networks_that_are_no_depth_edge_networks_are_refused(tmp_path):
    paths = (
        asset_path("models/edges.onnx"),
        write_network(tmp_path / "jump.onnx", [JUMP], INPUTS, {"jump": 1}),
        write_network(
            tmp_path / "low.onnx", [JUMP, node("Neg", ["jump"], "low"), *CREASE], INPUTS, {"low": 1, "crease": 1}
        ),
    )
    for path in paths:
        with pytest.raises(FormatError, match="is not a depth-edge network"):
            DepthEdgeNetwork.load(path)
