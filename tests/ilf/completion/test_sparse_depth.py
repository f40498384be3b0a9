"""Sparse depth: a few hundred points, or the lines of a lidar, are completed over the whole frame."""

import numpy as np

import ilf
from ilf.completion.block import required_known_pixels
from ilf.completion.interpolation import linear, nearest
from ilf.data.blocks import least_known_pixels
from ilf.data.results import Status
from ilf.evaluation.bench.frames import LINES, POINTS, BenchFrame, make_task

SHAPE = (240, 320)
ROWS, COLUMNS = np.indices(SHAPE, np.float32)
BOX = (abs(ROWS - 120) < 60) & (abs(COLUMNS - 160) < 70)
DEPTH = np.where(BOX, 1.2 + ROWS / 800, 3 + COLUMNS / 400).astype(np.float32)
RGB = np.where(BOX[..., None], (180, 60, 40), (90, 120, 150)).astype(np.uint8)


def sparse_frame(kept: int, seed: int = 0) -> ilf.RGBDFrame:
    """A box before a wall, of which so many pixels are known."""
    known = np.zeros(DEPTH.size, bool)
    known[np.random.default_rng(seed).permutation(DEPTH.size)[:kept]] = True
    return ilf.RGBDFrame(RGB, np.where(known.reshape(SHAPE), DEPTH, np.nan))


def error(depth: np.ndarray) -> float:
    return float(np.abs(depth - DEPTH).mean())


def test_points_complete_the_whole_frame_and_stop_at_the_contours_of_colour():
    frame = sparse_frame(120)
    blocks = ilf.extract_blocks(frame)
    assert blocks.max() == 2, "one block for each surface that colour shows"
    completion = ilf.complete(frame, blocks)
    assert np.isfinite(completion.depth).all()
    finished = {Status.COMPLETED, Status.ITERATION_LIMIT}
    assert {outcome.status for outcome in completion.outcomes.values()} <= finished
    assert error(completion.depth) < 0.3 * min(error(nearest(frame)), error(linear(frame)))


def test_three_points_are_enough_for_a_frame_and_two_are_not():
    completion = ilf.complete(sparse_frame(3))
    assert np.isfinite(completion.depth).all()
    assert (ilf.expected_error(completion)[completion.filled] > 0).all()
    assert {o.status for o in ilf.complete(sparse_frame(2)).outcomes.values()} == {Status.NOT_RECOVERABLE}


def test_surface_without_any_point_takes_its_depth_from_beyond_its_border():
    frame = sparse_frame(500)
    without = ilf.RGBDFrame(RGB, np.where(BOX, np.nan, frame.depth))
    assert np.isfinite(ilf.complete(without).depth).all()


def test_block_needs_half_of_a_sparse_frames_density():
    assert least_known_pixels([1000, 100_000], 0.02, 30, 0.002).tolist() == [3, 100]
    assert least_known_pixels([2], 0.02, 30, 0.002).tolist() == [2]
    assert least_known_pixels([1000, 100_000], 0.02, 30, 0.05).tolist() == [30, 2000], "this is not sparse"
    assert least_known_pixels([100_000], 0.0, 1, 0.002).tolist() == [1], "nor is more asked than of dense ones"


def test_pass_band_asks_for_as_much_depth_in_sparse_frames():
    assert required_known_pixels(1000, ilf.preset(), 0.002) == 3
    assert required_known_pixels(1000, ilf.preset("paper"), 0.002) == required_known_pixels(1000, ilf.preset("paper"))
    outcomes = ilf.complete(sparse_frame(100), np.ones(SHAPE, np.int32), preset="paper").outcomes
    assert outcomes[1].status is Status.NOT_RECOVERABLE


def test_bench_keeps_points_and_lines_of_a_frame_and_scores_the_rest():
    source = BenchFrame(ilf.RGBDFrame(RGB, DEPTH, name="box"), None)
    points, lines = make_task(source, "points"), make_task(source, "lines")
    assert np.count_nonzero(points.frame.known) == POINTS
    rows = np.flatnonzero(lines.frame.known.any(axis=1))
    assert len(rows) == LINES
    assert set(np.diff(rows)) == {SHAPE[0] // LINES}
    assert lines.frame.known[rows].all()
    for task in (points, lines):
        np.testing.assert_array_equal(task.scored, ~task.frame.known)
    np.testing.assert_array_equal(make_task(source, "points").scored, points.scored)
    assert (make_task(source, "points", 1).scored != points.scored).any()
