"""What the networks learn from: pictures whose lines stay where they are in a mirror, and fair scores."""

import numpy as np
import pytest
from recipes.lines import LineScore
from recipes.pictures import random_sample, read_picture, sample_of

from ilf.data.pixel_grids import different_labels, mark
from ilf.segmentation.edges.detectors import DEPTH_CHANNELS

from .tiny_data import write_picture


def test_a_mirrored_picture_has_the_lines_of_what_it_shows(tmp_path):
    mirrored = read_picture(write_picture(tmp_path, 0)).mirrored
    disc = np.asarray(mirrored.part == 3, np.int32)
    np.testing.assert_array_equal(mirrored.lines[..., 0] > 0, mark(different_labels(disc)))
    np.testing.assert_array_equal(
        mirrored.lines[..., 1] > 0, mark(different_labels(mirrored.part)) & ~mark(different_labels(disc))
    )
    np.testing.assert_array_equal(mirrored.mirrored.lines, read_picture(tmp_path / "000000.npz").lines)


def test_a_detail_has_the_lines_of_what_it_shows(tmp_path):
    picture = read_picture(write_picture(tmp_path, 0))
    detail = picture.detail(8, 10)
    np.testing.assert_array_equal(detail.part[::2, ::2], picture.part[8:40, 10:58])
    disc = mark(different_labels(np.asarray(detail.part == 3, np.int32)))
    np.testing.assert_array_equal(detail.lines[..., 0] > 0, disc)
    np.testing.assert_array_equal(detail.lines[..., 1] > 0, mark(different_labels(detail.part)) & ~disc)
    np.testing.assert_array_equal(detail.exact, np.where(detail.part == 3, np.float32(1.2), np.float32(2)))


def test_a_detail_of_a_slanted_surface_is_smooth_up_to_missing_depth(tmp_path):
    picture = read_picture(write_picture(tmp_path, 0))
    picture.measured[:] = 2 + 0.01 * np.arange(96, dtype=np.float32)
    picture.measured[:, 20] = np.nan
    measured = picture.detail(0, 0).measured
    np.testing.assert_array_equal(np.isnan(measured[0]).nonzero()[0], [40, 41])
    np.testing.assert_allclose(np.diff(measured[0, 1:38]), 0.005, atol=1e-5)


def test_samples_are_of_one_unit(tmp_path):
    picture = read_picture(write_picture(tmp_path, 0))
    for seed in range(6):
        image, features, lines, log_depth = random_sample(picture, np.random.default_rng(seed))
        assert image.dtype == features.dtype == lines.dtype == log_depth.dtype == np.float32
        assert 0 <= image.min() <= image.max() <= 1
        known = features[..., DEPTH_CHANNELS.index("known")] > 0
        # measured is 1 cm more than exact everywhere
        difference = features[..., DEPTH_CHANNELS.index("filled")] - log_depth[..., 0]
        assert 0.004 < difference[known].min() <= difference[known].max() < 0.009


def test_where_there_is_nothing_the_depth_to_learn_is_missing(tmp_path):
    picture = read_picture(write_picture(tmp_path, 0))
    picture.exact[:5] = np.nan
    log_depth = sample_of(picture, np.zeros((64, 96, 3), np.float32), picture.measured)[3]
    np.testing.assert_array_equal(np.isnan(log_depth[..., 0]), np.isnan(picture.exact))


@pytest.mark.parametrize(("shift", "precision", "recall"), [(0, 1, 1), (1, 1, 1), (2, 0, 0)])
def test_lines_may_be_a_pixel_off(shift, precision, recall):
    ground_truth, found = np.zeros((20, 30), bool), np.zeros((20, 30), np.float32)
    ground_truth[:, 10] = True
    found[:, 10 + shift] = 0.7
    score = LineScore(1)
    score.add(found, ground_truth, np.ones((20, 30), bool))
    at_half = np.array(score.precision_recall)[:, 16]
    np.testing.assert_array_equal(at_half, [precision, recall])
    assert score.average_precision == score.best_f == precision
