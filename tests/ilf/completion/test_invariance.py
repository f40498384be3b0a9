"""What must not change a result: labels of blocks, completing again, the frame's sides, the unit of length."""

from functools import cache

import numpy as np
import pytest
from numpy.typing import NDArray

from ilf import Camera, RGBDFrame, complete, preset

PRESETS = {name: preset(name, max_iterations=300) for name in ("best", "paper", "released-code")}
SHAPE = 40, 56
FLIPS = {"left and right": np.s_[:, ::-1], "top and bottom": np.s_[::-1]}


def _scene() -> tuple[RGBDFrame, NDArray[np.int32]]:
    """Three slanted planes in colours of their own with texture, noise of 2 mm, holes, and their label map."""
    random = np.random.default_rng(1)
    rows, columns = np.mgrid[: SHAPE[0], : SHAPE[1]]
    labels = (1 + (columns > 20 + rows // 4) + (rows > 24) * (columns > 20 + rows // 4)).astype(np.int32)
    slopes = random.uniform(-0.01, 0.01, (4, 2))[labels]
    depth = np.array([0, 1.4, 2.2, 3.1])[labels] + slopes[..., 0] * rows + slopes[..., 1] * columns
    depth += random.normal(0, 0.002, SHAPE)
    for _ in range(4):
        row, column = random.integers(0, SHAPE[0] - 10), random.integers(0, SHAPE[1] - 12)
        depth[row : row + 10, column : column + 12] = np.nan
    colours = random.integers(20, 220, (4, 3))[labels] + random.integers(0, 12, (*SHAPE, 1))
    return _frame(colours.astype(np.uint8), depth), labels


def _frame(rgb: NDArray[np.uint8], depth: NDArray[np.floating]) -> RGBDFrame:
    camera = Camera(60.0, 60.0, (SHAPE[1] - 1) / 2, (SHAPE[0] - 1) / 2)
    return RGBDFrame(np.ascontiguousarray(rgb), np.ascontiguousarray(depth, np.float32), camera)


@cache
def _completed(name: str) -> NDArray[np.float32]:
    """The depth of the scene by a preset."""
    depth = complete(*_scene(), PRESETS[name]).depth
    depth.flags.writeable = False
    return depth


def _difference(frame: RGBDFrame, depth: NDArray[np.float32], other: NDArray[np.float32]) -> float:
    """Difference of two results, as a share of depth: the 95th percentile of the pixels that were missing."""
    assert np.array_equal(np.isnan(depth), np.isnan(other))
    return float(np.percentile((np.abs(other - depth) / depth)[frame.missing & ~np.isnan(depth)], 95))


@pytest.mark.parametrize("name", PRESETS)
def test_other_labels_of_the_same_blocks_give_the_same_depth(name):
    frame, labels = _scene()
    others = np.array([0, 7, 2, 40], np.int32)[labels]
    np.testing.assert_array_equal(complete(frame, others, PRESETS[name]).depth, _completed(name))


@pytest.mark.parametrize("name", PRESETS)
def test_a_completed_frame_completed_again_stays_as_it_is(name):
    frame, labels = _scene()
    again = complete(_frame(frame.rgb, _completed(name)), labels, PRESETS[name])
    np.testing.assert_array_equal(again.depth, _completed(name))


@pytest.mark.parametrize("flip", FLIPS)
@pytest.mark.parametrize(("name", "bound"), [("released-code", 0.0), ("paper", 1e-4), ("best", 0.1)])
def test_a_mirrored_frame_gives_the_mirrored_depth(name, bound, flip):
    """The networks that correct the default's depth have learnt from frames that stand upright."""
    (frame, labels), sides = _scene(), FLIPS[flip]
    mirrored = complete(
        _frame(frame.rgb[sides], frame.depth[sides]), np.ascontiguousarray(labels[sides]), PRESETS[name]
    )
    assert _difference(frame, _completed(name), mirrored.depth[sides]) <= bound


@pytest.mark.parametrize("factor", [0.5, 2.0])
@pytest.mark.parametrize(("name", "bound"), [("released-code", 0.0), ("paper", 0.02), ("best", 0.02)])
def test_a_frame_of_another_size_gives_depth_of_that_size(name, bound, factor):
    """Noise and criteria of convergence are in metres: only the released code's way knows no unit."""
    frame, labels = _scene()
    scaled = complete(_frame(frame.rgb, frame.depth * np.float32(factor)), labels, PRESETS[name]).depth / factor
    assert _difference(frame, _completed(name), scaled.astype(np.float32)) <= bound
