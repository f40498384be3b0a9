"""Frames of the bench, their ground truth, and what its patterns hide."""

import json

import cv2
import numpy as np
import pytest

from ilf import RGBDFrame
from ilf.errors import InputError
from ilf.evaluation.bench.frames import BenchFrame, load_bench_frame, make_task

DEPTH = np.linspace(1, 3, 300 * 400).reshape(300, 400)
DEPTH[100:150, 100:180] = np.nan


def source_of(depth=DEPTH, name="wide"):
    return BenchFrame(RGBDFrame(np.zeros((*depth.shape, 3), np.uint8), depth, name=name), None)


@pytest.mark.parametrize(("pattern", "share"), [("random", 1 - 0.4277), ("areas", 0.25)])
def test_patterns_hide_their_share_and_follow_from_name_and_seed(pattern, share):
    task, known = make_task(source_of(), pattern), np.isfinite(DEPTH)
    assert task.scored.sum() == pytest.approx(share * known.sum(), abs=1)
    np.testing.assert_array_equal(task.frame.known, known & ~task.scored)
    np.testing.assert_array_equal(make_task(source_of(), pattern).scored, task.scored)
    assert (make_task(source_of(), pattern, seed=1).scored != task.scored).any()
    assert (make_task(source_of(name="other"), pattern).scored != task.scored).any()


def test_areas_are_ellipses_of_the_stated_size():
    scored = make_task(source_of(np.full(DEPTH.shape, 2.0)), "areas").scored
    reach = cv2.distanceTransform(np.pad(scored, 1).astype(np.uint8), cv2.DIST_L2, 5).max()
    assert 0.03 * 400 - 1 <= reach <= 2 * 0.12 * 400
    count, _ = cv2.connectedComponents(scored.astype(np.uint8))
    assert count - 1 <= 0.25 * scored.size / (np.pi * (0.03 * 400) ** 2) + 1


def test_the_ground_truth_scores_the_frames_own_holes(two_frames):
    source = load_bench_frame(two_frames / "second")
    task = make_task(source, "ground-truth")
    np.testing.assert_array_equal(task.scored, ~source.frame.known & np.isfinite(source.ground_truth))
    assert task.scored.any()
    with pytest.raises(InputError, match="no measured or exact ground truth"):
        make_task(load_bench_frame(two_frames / "first"), "ground-truth")


@pytest.mark.parametrize("worth", ["filled, 8-bit steps", "exact filled", "own hole filling, NOT measured GT", ""])
def test_filled_depth_is_no_ground_truth(two_frames, worth):
    folder = two_frames / "second"
    meta = {"depth_units_per_m": 1000, "gt": worth, "gt_units_per_m": 1000}
    (folder / "meta.json").write_text(json.dumps(meta))
    assert load_bench_frame(folder).ground_truth is None
    (folder / "depth.png").unlink()
    with pytest.raises(InputError, match="neither raw depth nor a measured or exact gt"):
        load_bench_frame(folder)


def test_ground_truth_with_a_mask_stands_in_for_depth(two_frames):
    folder = two_frames / "second"
    (folder / "depth.png").unlink()
    mask = np.zeros((60, 80), np.uint8)
    mask[5:20, 5:20] = 255
    cv2.imwrite(str(folder / "mask.png"), mask)
    source = load_bench_frame(folder)
    np.testing.assert_array_equal(source.frame.known, np.isfinite(source.ground_truth) & (mask == 0))
    np.testing.assert_array_equal(make_task(source, "ground-truth").scored, mask > 0)


@pytest.mark.parametrize("pattern", ["areas", "random", "points", "lines"])
def test_frames_that_leave_nothing_to_score_are_refused(pattern):
    one = np.full((40, 60), np.nan)
    one[3, 4] = 2.0
    with pytest.raises(InputError, match=r"hidden|held-out|no known depth"):
        make_task(source_of(one), pattern)
