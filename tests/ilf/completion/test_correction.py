"""The learned correction: its arithmetic against direct formulas, what it may touch, and what its result depends on."""

import threading
from dataclasses import replace

import numpy as np
import pytest
from scipy.sparse import coo_array, diags_array
from scipy.sparse.linalg import spsolve

import ilf
from ilf._runtime.installation import asset_path
from ilf._runtime.long_work import cancelled_by
from ilf._runtime.networks.models import CORRECTION
from ilf.completion.block import BlockTask, is_guided
from ilf.completion.correction import (
    CELL,
    CHANNELS,
    LARGEST,
    LEAK,
    Correction,
    CorrectionNetwork,
    _weighted,
    _weights_of,
    applied_change,
    correction_features,
    smoothed,
    spread,
)
from ilf.data.blocks import find_blocks
from ilf.errors import Cancelled, FormatError, InputError
from ilf.run.record import installed_sha256

RNG = np.random.default_rng(7)


def links_of(height, width):
    links = RNG.uniform(0.01, 1, (6, height, width)).astype(np.float32)
    links[2:4] = RNG.normal(0, 0.1, (2, height, width))
    links[5] = RNG.normal(0, 0.1, (height, width))
    return links


@pytest.mark.parametrize("shape", [(5, 7), (7, 5), (1, 4), (4, 1), (1, 1)])
def test_changes_spread_as_the_least_sum_says(shape):
    """Against the normal equations of the sum, written out cell by cell."""
    height, width = shape
    links = links_of(height, width)
    size = height * width
    matrix, load = np.zeros((size, size)), links[5].ravel().astype(float)
    matrix[np.diag_indices(size)] = links[4].ravel()
    for row in range(height):
        for column in range(width):
            for conductance, rise, below, right in ((0, 2, 0, 1), (1, 3, 1, 0)):
                if row + below >= height or column + right >= width:
                    continue
                one, other = row * width + column, (row + below) * width + column + right
                weight, up = links[conductance, row, column], links[rise, row, column]
                matrix[[one, other], [one, other]] += weight
                matrix[[one, other], [other, one]] -= weight
                load[[one, other]] += [-weight * up, weight * up]
    np.testing.assert_allclose(spread(links).ravel(), np.linalg.solve(matrix, load), rtol=1e-4, atol=1e-6)


def test_cells_that_hardly_anything_holds_are_where_exact_numbers_put_them():
    """The network holds every cell by e^-9 at least."""
    links = np.ones((6, 60, 80), np.float32)
    links[2:4] = RNG.normal(0, 0.01, (2, 60, 80))
    links[4], links[5] = np.exp(-9), 0
    links[5, 0, 0] = np.exp(-9)
    cells = np.arange(60 * 80).reshape(60, 80)
    ends = [(cells[:, :-1], cells[:, 1:]), (cells[:-1], cells[1:])]
    one, other = (np.concatenate([pair[end].ravel() for pair in ends]) for end in (0, 1))
    numbers, ones = np.arange(one.size), np.ones(one.size)
    shape = one.size, cells.size
    differences = coo_array((ones, (numbers, other)), shape) - coo_array((ones, (numbers, one)), shape)
    rises = np.concatenate([links[2, :, :-1].ravel(), links[3, :-1].ravel()]).astype(np.float64)
    held, pull = (values.ravel().astype(np.float64) for values in links[4:])
    matrix = (differences.T @ differences + diags_array(held + LEAK)).tocsc()
    exact = spsolve(matrix, pull + differences.T @ rises).reshape(60, 80)
    assert spread(links).dtype == np.float32
    np.testing.assert_allclose(spread(links), exact, atol=2e-5)


def test_a_pixel_takes_a_mean_of_the_cells_around_it():
    cells = RNG.normal(size=(3, 4)).astype(np.float32)
    logits = RNG.normal(0, 3, size=(36, 3 * CELL // 2, 4 * CELL // 2)).astype(np.float32)
    found = _weighted(cells, _weights_of(logits))
    assert found.shape == (3 * CELL, 4 * CELL)
    for row, column in ((0, 0), (5, 9), (11, 14)):
        around = np.pad(cells, 1, mode="edge")[row // CELL : row // CELL + 3, column // CELL : column // CELL + 3]
        weights = np.exp(logits[2 * (row % 2) + column % 2 :: 4, row // 2, column // 2])
        assert found[row, column] == pytest.approx(float((around.ravel() * weights).sum() / weights.sum()), rel=1e-4)
    huge = _weighted(cells, _weights_of(1e4 * logits))
    assert np.isfinite(huge).all()


def test_small_changes_specks_and_the_grid_of_cells_go_and_edges_stay():
    rows, columns = np.indices((60, 80))
    step = np.where(columns < 40, 0.3, 0).astype(np.float32)
    np.testing.assert_allclose(smoothed(step), step, atol=1e-4)
    grid = step + np.float32(0.01) * ((rows // 4 + columns // 4) % 2)
    assert np.abs(smoothed(grid)[10:-10, 10:30] - 0.305).max() < 0.004
    assert np.abs(smoothed(np.full_like(step, 0.001))).max() < 2e-5
    speck = np.zeros_like(step)
    speck[20:22, 20:22] = 0.5
    assert np.abs(smoothed(speck)).max() < 1e-6
    for huge in (np.float32(1e30), np.float32(np.inf)):
        np.testing.assert_allclose(smoothed(np.full_like(step, -huge)), -LARGEST)


def test_changes_near_known_depth_fade():
    change = np.array([[0, 0.1]], np.float32)
    everywhere = np.zeros((30, 2), np.float32) + change
    known = np.zeros(everywhere.shape, bool)
    known[0] = True
    found = applied_change(everywhere, known)
    assert np.all(found[:, 0] == 0)
    np.testing.assert_array_equal(found[:3], 0)
    np.testing.assert_allclose(found[3:5, 1], (0.1 / 3, 0.2 / 3), rtol=0.02)
    np.testing.assert_allclose(found[5:, 1], 0.1, rtol=1e-5)


def test_features_know_no_scale():
    depth = RNG.uniform(1, 3, (40, 50)).astype(np.float32)
    known = np.where(RNG.random(depth.shape) < 0.6, depth, np.float32(np.nan))
    contours = RNG.random(depth.shape).astype(np.float32)
    one, other = (correction_features(known * k, depth * k, contours) for k in (np.float32(1), np.float32(4)))
    assert one[0].shape == (len(CHANNELS), 40, 50)
    np.testing.assert_allclose(one[0], other[0], atol=1e-4)
    unfilled = correction_features(known, known, contours)
    assert np.isfinite(unfilled[0]).all(), "what has not been completed is filled from around"


def room_block():
    mask = np.ones((4, 5), bool)
    return find_blocks(mask.astype(np.int32))[1], mask


def test_a_block_takes_a_change_as_far_as_it_is_what_the_network_has_seen():
    block, mask = room_block()
    base_depth = np.full(mask.shape, 2, np.float32)
    correction = Correction(base_depth, np.full(mask.shape, 0.1, np.float32), ())
    depth = np.full(mask.size, 2, np.float32)
    raw = np.full(mask.size, np.nan, np.float32)
    raw[0] = 2
    depth[1], depth[2], depth[3] = 2.04, 3, np.nan
    found = correction.applied(block, raw, depth)
    assert found[0] == 2, "known depth stays"
    assert found[1] == pytest.approx(2.04 * np.exp(0.1 * np.exp(-(np.log(1.02) ** 2) / 0.02**2)))
    assert found[2] == 3, "another surface than the network has seen stays"
    assert np.isnan(found[3])
    np.testing.assert_allclose(found[4:], 2 * np.exp(0.1), rtol=1e-6)
    unseen = replace(correction, base_depth=np.full(mask.shape, np.nan, np.float32))
    np.testing.assert_array_equal(unseen.applied(block, raw, depth), depth)


@pytest.fixture(scope="module")
def frame():
    """A part of the sample room."""
    room = ilf.load_frame(asset_path("samples/room"))
    return ilf.RGBDFrame(room.rgb[140:300, 240:460], room.depth[140:300, 240:460])


@pytest.fixture(scope="module")
def blocks(frame):
    """As extracted, but for their numbers."""
    return 2 * ilf.extract_blocks(frame)


@pytest.fixture(scope="module")
def corrected(frame, blocks):
    return ilf.complete(frame, blocks)


def anew(frame):
    """The same frame, of which nothing is remembered."""
    return ilf.RGBDFrame(frame.rgb.copy(), frame.depth.copy())


def test_known_depth_stays_and_missing_depth_is_corrected(frame, blocks, corrected):
    plain = ilf.complete(frame, blocks, ilf.preset("best", correction=False))
    np.testing.assert_array_equal(corrected.depth[frame.known], frame.depth[frame.known])
    np.testing.assert_array_equal(np.isnan(corrected.depth), np.isnan(plain.depth))
    assert np.any(corrected.depth[corrected.filled] != plain.depth[corrected.filled])
    sha256 = installed_sha256(CORRECTION)
    assert {result.correction for result in corrected.results.values() if result.outcome.recovered} == {(sha256,)}
    assert {result.correction for result in plain.results.values()} == {()}


def test_a_block_run_alone_is_what_it_is_among_all(frame, blocks, corrected):
    """It depends on nothing but frame and block, whatever else is run, in how many threads, and what is remembered."""
    largest = max(corrected.results, key=lambda label: corrected.results[label].outcome.recovered)
    for threads in (1, 2):
        with ilf.Run(anew(frame), blocks, only={largest}).steps(threads) as run:
            list(run)
        assert not run.uncorrected
        np.testing.assert_array_equal(run.results[largest].depth, corrected.results[largest].depth)
    np.testing.assert_array_equal(ilf.complete(anew(frame), blocks, threads=2).depth, corrected.depth)


def test_blocks_that_are_as_extracted_are_iterated_on_only_once(frame, blocks, monkeypatch):
    made = []
    real = BlockTask.stepper
    monkeypatch.setattr(BlockTask, "stepper", lambda task, *args: made.append(task.block.label) or real(task, *args))
    ilf.complete(anew(frame), blocks)
    assert len(made) == len(set(made))
    other = blocks.copy()
    first, second = np.unique(blocks[blocks > 0])[:2]
    other[other == second] = first
    made.clear()
    ilf.complete(anew(frame), other)
    assert len(made) > len(np.unique(other[other > 0])), "the network sees them as extracted"


@pytest.mark.parametrize("moment", ["look", "handing over"])
def test_a_run_that_is_stopped_at_the_correction_keeps_every_block(moment, frame, blocks, corrected, monkeypatch):
    wish, fresh = threading.Event(), anew(frame)
    change, hand_over = CorrectionNetwork.change, Correction.applied

    def stopped_change(self, *known):
        wish.set()
        return change(self, *known)

    def stopped_hand_over(*known):
        wish.set()
        return hand_over(*known)

    with monkeypatch.context() as patch:
        if moment == "look":
            patch.setattr(CorrectionNetwork, "change", stopped_change)
        else:
            patch.setattr(Correction, "applied", stopped_hand_over)
        with ilf.Run(fresh, blocks).steps(1) as run, cancelled_by(wish), pytest.raises(Cancelled):
            list(run)
    monkeypatch.undo()
    assert set(run.results) | set(run.uncorrected) == set(run.blocks)
    assert not set(run.results) & set(run.uncorrected)
    assert run.uncorrected
    np.testing.assert_array_equal(ilf.complete(fresh, blocks).depth, corrected.depth)


def test_a_block_whose_border_was_drawn_is_what_the_user_has_made_it(frame, blocks, corrected):
    largest = max(corrected.results, key=lambda label: corrected.results[label].outcome.recovered)
    drawn = blocks == largest
    found, plain = (
        ilf.complete(frame, blocks, ilf.preset("best", correction=on), drawn=drawn).results[largest]
        for on in (True, False)
    )
    assert found.correction == ()
    np.testing.assert_array_equal(found.depth, plain.depth)


def test_no_hidden_depth_and_no_truth_gets_in(frame):
    hidden = frame.depth.copy()
    hidden[60:120, 80:200] = np.nan
    with_ground_truth = ilf.RGBDFrame(frame.rgb, hidden).with_ground_truth(frame.depth, None)
    never = ilf.RGBDFrame(frame.rgb, hidden)
    found = [ilf.complete(one, ilf.extract_blocks(one)).depth for one in (with_ground_truth, never)]
    np.testing.assert_array_equal(*found)


def test_a_frame_with_a_guide_that_is_followed_is_left_to_it(frame, blocks):
    guided = frame.with_guide(np.where(frame.known, frame.depth, ilf.complete(frame, blocks).depth))
    assert is_guided(guided)
    assert not is_guided(frame)
    results = ilf.complete(guided, blocks).results.values()
    assert {result.correction for result in results} == {()}


def test_without_its_network_depth_stays_as_the_filter_leaves_it(frame, blocks, monkeypatch):
    def missing():
        raise InputError("There is no correction network at here.")

    monkeypatch.setattr(CorrectionNetwork, "bundled", missing)
    fresh = anew(frame)
    found = ilf.complete(fresh, blocks)
    assert "Depth is not corrected: There is no correction network at here." in found.notes
    plain = ilf.complete(fresh, blocks, ilf.preset("best", correction=False))
    np.testing.assert_array_equal(found.depth, plain.depth)


def test_the_network_is_not_asked_where_all_missing_depth_is_near_known_depth(frame, blocks, corrected, monkeypatch):
    monkeypatch.setattr(CorrectionNetwork, "bundled", lambda: pytest.fail("the network is asked"))
    thin = corrected.depth.copy()
    thin[::3, ::3] = np.nan
    found = ilf.complete(ilf.RGBDFrame(frame.rgb, thin), blocks)
    assert found.filled.sum() > 1000
    assert {result.correction for result in found.results.values()} == {()}
    assert not found.notes


def test_a_file_of_another_kind_is_refused(tmp_path):
    with pytest.raises(FormatError, match="is not a correction network"):
        CorrectionNetwork.load(asset_path("models/depth-edges.onnx"))
    broken = tmp_path / "correction.onnx"
    broken.write_bytes(asset_path("models/correction.onnx").read_bytes()[:1000])
    with pytest.raises(FormatError, match="cannot be read"):
        CorrectionNetwork.load(broken)


def test_output_that_is_not_finite_is_not_applied(frame, blocks, monkeypatch):
    network = CorrectionNetwork.bundled()
    real = network._forward

    def results(inputs):
        found = real(inputs)
        found[0][..., 0] = np.inf
        return found

    monkeypatch.setattr(network, "_forward", results)
    notes = ilf.complete(anew(frame), blocks).notes
    assert "Depth is not corrected: correction.onnx returns values that are not finite for this frame." in notes
