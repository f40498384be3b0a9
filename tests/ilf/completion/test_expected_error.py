"""The expected error: where it is, how it grows, and what nothing vouches for."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

import ilf
from ilf.completion.confidence.expected_error import _discs, depth_error, difficulty_samples, error_summary, summarised
from ilf.completion.confidence.fitted import MODELS
from ilf.completion.confidence.model import FEATURES, FLOOR, walk
from ilf.errors import InputError, ParameterError

from ..small_frames import QUICK, write_small_frame

ROWS, COLUMNS = np.mgrid[:96, :128].astype(np.float32)
PLANE = (2 + 0.002 * ROWS + 0.004 * COLUMNS).astype(np.float32)
HOLE = (ROWS - 48) ** 2 + (COLUMNS - 64) ** 2 < 30**2
COLOUR = np.zeros((*PLANE.shape, 3), np.uint8)


def error_of(depth, hole=HOLE, completed=None):
    frame = ilf.RGBDFrame(COLOUR, np.where(hole, np.nan, depth))
    return depth_error(frame, depth if completed is None else completed)


def test_there_is_one_wherever_depth_was_filled_and_nowhere_else():
    completed = PLANE.copy()
    completed[40:44, 60:70] = np.nan
    completed[44:48, 60:70] = 0
    error = error_of(PLANE, completed=completed)
    assert error.dtype == np.float32
    np.testing.assert_array_equal(np.isfinite(error), HOLE & (np.nan_to_num(completed) > 0))
    assert (error[np.isfinite(error)] > 0).all()
    assert not np.isfinite(error_of(PLANE, hole=np.zeros_like(HOLE))).any()


@pytest.mark.parametrize("model", MODELS)
def test_it_grows_with_the_distance_to_known_depth(model):
    frame = ilf.RGBDFrame(COLOUR, np.where(COLUMNS >= 32, np.nan, PLANE))
    error = depth_error(frame, PLANE, model)
    inner = error[48, 32:-1]
    assert (np.diff(inner) > -1e-6 * inner[:-1]).all()
    assert inner[-1] > 3 * inner[0]


def test_it_grows_with_depth_at_least_in_proportion_but_never_beyond_it():
    near, far = error_of(PLANE), error_of(3 * PLANE)
    assert (far[HOLE] > 2.99 * near[HOLE]).all()
    wild = np.where(HOLE, np.random.default_rng(0).uniform(0.2, 40, PLANE.shape), PLANE).astype(np.float32)
    error = error_of(PLANE, completed=wild)
    assert (error[HOLE] <= wild[HOLE]).all()
    assert (error[HOLE] >= 0.999 * FLOOR * wild[HOLE]).all()


def test_it_is_larger_beside_a_surface_that_bends():
    rippled = (PLANE + 0.02 * np.sin(COLUMNS / 3)).astype(np.float32)
    assert np.median(error_of(rippled)[HOLE]) > 2 * np.median(error_of(PLANE)[HOLE])


@pytest.mark.parametrize("shape", [(1, 9), (9, 1), (3, 3), (7, 33)])
def test_a_single_known_pixel_gives_finite_errors_that_are_no_certainty(shape):
    depth = np.full(shape, np.nan, np.float32)
    depth[0, 0] = 2.0
    frame = ilf.RGBDFrame(np.zeros((*shape, 3), np.uint8), depth)
    error = depth_error(frame, np.full(shape, 2.0, np.float32))
    assert np.isfinite(error).sum() == depth.size - 1
    assert np.nanmin(error) > 2 * FLOOR * 2.0


def test_each_block_of_a_completion_has_the_model_of_its_filter(tmp_path):
    frame = ilf.load_frame(*write_small_frame(tmp_path))
    labels = np.tile(np.where(np.arange(80) < 40, 1, 2).astype(np.int32), (60, 1))
    completion = ilf.complete(frame, labels, ilf.preset("paper", **QUICK, rgb_iterations=5))
    of_filter = {name: depth_error(frame, completion.depth, name) for name in MODELS}
    np.testing.assert_array_equal(ilf.expected_error(completion), of_filter["ideal"])
    second = replace(completion.results[2], parameters=ilf.Parameters(filter="edge-aware"))
    mixed = replace(completion, results={**completion.results, 2: second})
    expected = np.where(labels == 1, of_filter["ideal"], of_filter["edge-aware"])
    np.testing.assert_array_equal(ilf.expected_error(mixed), expected)
    np.testing.assert_array_equal(np.isfinite(expected), completion.filled)
    canny = ilf.BlockParameters(detector="canny")
    of_second = {**completion.results, 2: replace(second, edges=canny)}
    of_both = of_second | {1: replace(completion.results[1], edges=canny)}
    by_canny, both_by_canny = (ilf.expected_error(replace(completion, results=one)) for one in (of_second, of_both))
    assert not np.array_equal(by_canny, expected, equal_nan=True)
    np.testing.assert_array_equal(by_canny, both_by_canny)
    extrapolations = replace(completion, extrapolated=completion.filled & (labels == 2))
    np.testing.assert_array_equal(ilf.expected_error(extrapolations), expected)


def test_sparse_frames_have_a_model_of_their_own():
    kept = np.zeros_like(HOLE)
    kept[::16, ::16] = True  # 0.4 % of the pixels
    error = depth_error(frame := ilf.RGBDFrame(COLOUR, np.where(kept, PLANE, np.nan)), PLANE)
    np.testing.assert_array_equal(error, depth_error(frame, PLANE, "sparse"))
    dense = ilf.RGBDFrame(COLOUR, np.where(HOLE, np.nan, PLANE))
    assert not np.array_equal(depth_error(dense, PLANE), depth_error(dense, PLANE, "sparse"), equal_nan=True)


def test_a_completion_has_one_error_of_which_each_caller_has_a_copy(tmp_path, monkeypatch):
    completion = ilf.complete(ilf.load_frame(*write_small_frame(tmp_path)), preset=ilf.preset("paper", **QUICK))
    both = ilf.expected_error(completion), ilf.unsupported(completion)
    monkeypatch.setattr("ilf.completion.confidence.expected_error.walks_with_edges", None)
    again = ilf.expected_error(completion), ilf.unsupported(completion)
    for first, second in zip(both, again, strict=True):
        kept = second.copy()
        first[:] = 1
        np.testing.assert_array_equal(second, kept)


def test_figures_of_expected_errors_are_over_what_blocks_have_filled(tmp_path):
    frame = ilf.load_frame(*write_small_frame(tmp_path))
    labels = np.tile(np.where(np.arange(80) < 40, 1, 2).astype(np.int32), (60, 1))
    completion = ilf.complete(frame, labels, ilf.preset("paper", **QUICK, rgb_iterations=5))
    extrapolate = replace(completion, extrapolated=completion.filled & (labels == 2))
    error = ilf.expected_error(extrapolate)
    of_blocks = error[completion.filled & (labels == 1)].astype(np.float64)
    figures = error_summary(extrapolate)
    assert figures.rms == pytest.approx(np.sqrt(np.mean(of_blocks**2)))
    assert (figures.median, figures.p90) == pytest.approx((np.median(of_blocks), np.quantile(of_blocks, 0.9)))
    assert error_summary(completion).rms != figures.rms
    assert np.isnan(summarised(np.full(3, np.nan, np.float32))).all()


def test_what_does_not_fit_is_refused():
    frame = ilf.RGBDFrame(COLOUR, np.where(HOLE, np.nan, PLANE))
    with pytest.raises(InputError, match="but the frame is"):
        depth_error(frame, PLANE[1:])
    with pytest.raises(ParameterError, match="no error model 'wavelet'"):
        depth_error(frame, PLANE, "wavelet")


def test_walks_end_at_the_depth_that_they_come_upon_and_edges_turn_them_back():
    depth = np.full((64, 96), np.nan, np.float32)
    depth[:, :16], depth[:, -16:] = 1.0, 3.0
    open_, wall = np.zeros((2, *depth.shape), np.float32)
    wall[:, 64:72] = 1.0
    free, parted = walk(depth, open_), walk(depth, wall)
    middle = 32, 48
    assert free.depth[middle] == pytest.approx(np.log(3) / 2, abs=0.01)
    assert free.spread[middle] == pytest.approx(np.log(3) / 2, abs=0.01)
    assert free.aside[middle] < 2
    assert parted.depth[middle] == pytest.approx(0, abs=0.02)
    assert parted.spread[middle] < 0.15
    assert parted.aside[middle] > 30
    assert parted.steps[middle] > 1.5 * free.steps[middle]
    closed = np.zeros_like(open_)
    closed[24:40, 40:56] = 1.0
    assert walk(depth, closed).steps[middle] > 20 * free.steps[middle]


def test_nothing_vouches_for_guesses_for_what_edges_close_in_and_for_what_lies_outside_all_measured_depth():
    frame = ilf.RGBDFrame(COLOUR, np.where(HOLE, np.nan, PLANE))
    labels = np.where(np.hypot(ROWS - 48, COLUMNS - 64) < 16, 2, 1).astype(np.int32)
    completion = ilf.complete(frame, np.ones(PLANE.shape, np.int32), ilf.Parameters(max_iterations=3))
    assert not ilf.unsupported(completion).any()
    some = HOLE & (COLUMNS > 64)
    np.testing.assert_array_equal(ilf.unsupported(replace(completion, extrapolated=some)), some)
    for factor in (0.5, 2.0):
        depth = np.where(some, np.float32(factor) * completion.depth, completion.depth)
        np.testing.assert_array_equal(ilf.unsupported(replace(completion, depth=depth)), some)
    ring = np.abs(np.hypot(ROWS - 48, COLUMNS - 64) - 16) < 4
    parted = replace(completion, results={1: replace(completion.results[1], drawn=ring.ravel())})
    closed_in = ilf.unsupported(parted)
    assert closed_in[labels == 2].mean() > 0.5
    assert not closed_in[np.hypot(ROWS - 48, COLUMNS - 64) > 24].any()
    with pytest.raises(InputError, match="but the frame is"):
        ilf.unsupported(replace(completion, depth=completion.depth[1:]))


@pytest.mark.parametrize(
    ("steps", "freely", "closed"), [(20.5, 1, True), (20, 1, False), (24.5, 2, True), (24, 2, False)]
)
def test_depth_is_closed_off_beyond_20_steps_that_are_12_times_those_without_edges(monkeypatch, steps, freely, closed):
    frame = ilf.RGBDFrame(COLOUR, np.where(HOLE, np.nan, PLANE))
    completion = ilf.complete(frame, np.ones(PLANE.shape, np.int32), ilf.Parameters(max_iterations=1))
    for name, count in (("walks_with_edges", steps), ("_walks_without_edges", freely)):
        walks = SimpleNamespace(steps=np.full(PLANE.shape, count, np.float32))
        monkeypatch.setattr(f"ilf.completion.confidence.expected_error.{name}", lambda *_, walks=walks: walks)
    np.testing.assert_array_equal(ilf.unsupported(completion), HOLE & closed)


def test_a_frame_is_as_hard_as_its_own_hidden_depth_turns_out():
    smooth = ilf.RGBDFrame(COLOUR, PLANE)
    rough = ilf.RGBDFrame(COLOUR, PLANE + np.float32(0.3) * (np.sin(ROWS / 7) * np.sin(COLUMNS / 9)))
    easy, hard = (difficulty_samples(frame) for frame in (smooth, rough))
    assert easy[0].shape == (len(easy[1]), len(FEATURES))
    assert 0.2 < len(easy[1]) / PLANE.size < 0.35
    assert np.median(easy[1]) < np.median(hard[1])
    again = difficulty_samples(ilf.RGBDFrame(COLOUR, PLANE))
    np.testing.assert_array_equal(easy[1], again[1])
    assert difficulty_samples(ilf.RGBDFrame(COLOUR, np.where(ROWS < 80, np.nan, PLANE))) is None


def test_frames_with_sparse_depth_of_great_size_and_at_the_limits_of_depth_can_be_tested_too(monkeypatch):
    monkeypatch.setattr("ilf.completion.confidence.expected_error._MIN_SAMPLES", 10)
    sparse = np.random.default_rng(0).uniform(size=PLANE.shape) < 0.02
    features, _ = difficulty_samples(ilf.RGBDFrame(COLOUR, np.where(sparse, PLANE, np.nan)))
    assert 30 <= len(features) < 100
    near = np.where(_discs(PLANE.shape) | (COLUMNS < 60), 0.11, 0.099)  # what is left is too near for a frame
    assert difficulty_samples(ilf.RGBDFrame(COLOUR, near)) is not None
    assert np.isfinite(depth_error(ilf.RGBDFrame(COLOUR, np.where(HOLE, np.nan, near)), near)[HOLE]).all()
    monkeypatch.setattr("ilf.completion.confidence.expected_error._MAX_SIDE", 32)
    features, _ = difficulty_samples(ilf.RGBDFrame(COLOUR, PLANE))
    assert 0.2 < len(features) / (24 * 32) < 0.35
    monkeypatch.setattr("ilf.completion.confidence.expected_error._MAX_SAMPLES", 50)
    assert 40 < len(difficulty_samples(ilf.RGBDFrame(COLOUR, PLANE))[0]) <= 50


def test_pixels_of_large_frames_share_features(monkeypatch):
    frame = ilf.RGBDFrame(COLOUR[1:, 1:], np.where(HOLE, np.nan, PLANE)[1:, 1:])
    alone = depth_error(frame, PLANE[1:, 1:])
    monkeypatch.setattr("ilf.completion.confidence.model._MAX_PIXELS", frame.depth.size // 2)
    shared = depth_error(frame, PLANE[1:, 1:])
    np.testing.assert_array_equal(np.isfinite(shared), np.isfinite(alone))
    assert 0.7 < np.nanmedian(shared / alone) < 1.4


@pytest.mark.parametrize("shape", [(1000, 2), (1, 400)])
@pytest.mark.parametrize(
    "parameters", [ilf.preset(), ilf.preset("paper"), ilf.preset("released-code", max_iterations=9)]
)
def test_frames_as_thin_as_a_line_come_out_without_a_warning(shape, parameters):
    rng = np.random.default_rng(0)
    depth = np.linspace(2, 3, shape[0] * shape[1]).reshape(shape)
    depth[rng.random(shape) < 0.3] = np.nan
    frame = ilf.RGBDFrame(rng.integers(0, 255, (*shape, 3), np.uint8), depth, ground_truth=np.full(shape, 2.5))
    run = ilf.Run.of(frame, preset=parameters)
    completion = run.complete()
    assert np.isfinite(ilf.expected_error(completion)[completion.filled]).all()
    assert ilf.evaluate_hold_out(run, ilf.HoldOutTest("random", (0,))).whole.pixels
    assert difficulty_samples(frame) is None
