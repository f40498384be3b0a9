"""Whether an edit was for the better, on hidden depth."""

from dataclasses import replace

import numpy as np
import pytest

import ilf
from ilf.evaluation.edit_summary import EditSummary, summarise_edit
from ilf.segmentation.editing.patches import patch_between


@pytest.fixture
def moved(small_frame, small_labels):
    """The border of the two planes 6 pixels off, and put right."""
    wrong = np.where(np.arange(64) < 36, 1, 2) + np.zeros_like(small_labels)
    patch = patch_between(wrong, small_labels)
    drawn = np.zeros(small_labels.shape, bool)
    drawn[:, 29:31] = True
    grey = ilf.RGBDFrame(np.full_like(small_frame.rgb, 90), small_frame.depth)
    return (
        ilf.Run(grey, wrong, ilf.preset("paper")),
        ilf.Run(grey, ilf.Blocks(small_labels, drawn=drawn), ilf.preset("paper")),
        patch,
    )


def test_a_border_that_is_put_right_lowers_the_error_on_hidden_depth(moved):
    before, after, patch = moved
    effect = summarise_edit(before, after, patch)
    assert effect.moved == 48 * 6
    assert effect.expected is None, "nothing has been completed"
    assert effect.held_out[1] < 0.3 * effect.held_out[0]
    assert effect.held_out_differs
    assert 0 < effect.margin < effect.held_out[0] - effect.held_out[1]
    assert 20 < effect.hidden <= 48 * 16
    assert summarise_edit(before, after, patch) == effect, "always the same pixels are hidden"
    back = summarise_edit(after, before, patch)
    assert back.held_out == effect.held_out[::-1]


def test_a_frame_on_its_side_has_the_same_figures(moved):
    effect = summarise_edit(*moved)
    before, after = (
        ilf.Run(ilf.RGBDFrame(run.frame.rgb.swapaxes(0, 1), run.frame.depth.T), run.blocks.labels.T, run.parameters)
        for run in moved[:2]
    )
    turned = summarise_edit(before, after, patch_between(before.blocks.labels, after.blocks.labels))
    assert (turned.moved, turned.hidden) == (effect.moved, effect.hidden)
    figures = [(*one.held_out, one.margin) for one in (turned, effect)]
    np.testing.assert_allclose(*figures, rtol=0.01)


def test_the_hidden_depth_does_not_reach_the_filter(moved):
    before, after, patch = moved
    measured = after.frame.depth.copy()
    measured[10, 33] += 0.5
    other = ilf.RGBDFrame(after.frame.rgb, measured)
    runs = [ilf.Run(other, run.blocks, run.parameters) for run in (before, after)]
    one, two = summarise_edit(before, after, patch), summarise_edit(*runs, patch)
    # only the truth has changed, by half a metre at one pixel, which was filled as before
    squares = [np.square(effect.held_out) * effect.hidden for effect in (one, two)]
    assert np.abs(squares[1] - squares[0]).max() < 0.5**2 + 2 * 0.5 * 1.0
    assert two.held_out != one.held_out


def test_expected_errors_are_those_of_the_touched_blocks(moved):
    before, after, patch = moved
    done = before.complete(), after.complete()
    effect = summarise_edit(before, after, patch, done)
    error = ilf.expected_error(done[1])
    assert effect.expected[1] == pytest.approx(float(np.sqrt(np.nanmean(error[done[1].filled] ** 2))), rel=1e-5)


def test_where_too_little_is_known_nothing_is_said(small_labels):
    depth = np.full(small_labels.shape, np.nan)
    depth[:4] = 2.0
    frame = ilf.RGBDFrame(np.zeros((*small_labels.shape, 3), np.uint8), depth)
    after = small_labels.copy()
    after[30:34, 20:40] = 2
    patch = patch_between(small_labels, after)
    assert summarise_edit(ilf.Run(frame, small_labels), ilf.Run(frame, after), patch) == EditSummary(40)
    all_of_it = np.full_like(after, 3)
    patch = patch_between(small_labels, all_of_it)
    assert summarise_edit(ilf.Run(frame, small_labels), ilf.Run(frame, all_of_it), patch).moved == all_of_it.size


def test_a_completion_of_an_older_state_says_nothing_of_the_one_before_the_edit(moved):
    before, after, patch = moved
    older = np.where(np.arange(64) < 40, 1, 2) + np.zeros_like(after.blocks.labels)
    done = ilf.Run(before.frame, older, before.parameters).complete(), after.complete()
    assert summarise_edit(before, after, patch, done).expected is None


def test_expected_errors_are_compared_where_both_states_are_filled(small_frame):
    """A block without known depth takes its pixels out of what is filled, and says nothing of the error of the rest."""
    labels = np.ones(small_frame.shape, np.int32)
    alone = labels.copy()
    alone[12:20, 10:18] = 2
    patch = patch_between(labels, alone)
    before, after = ilf.Run(small_frame, labels), ilf.Run(small_frame, alone)
    done = before.complete(), after.complete()
    effect = summarise_edit(before, after, patch, done)
    assert effect.filled == (done[0].filled.sum(), done[0].filled.sum() - 64)
    both = done[0].filled & done[1].filled
    rms = [float(np.sqrt(np.nanmean(ilf.expected_error(one)[both] ** 2))) for one in done]
    assert effect.expected == pytest.approx(rms, rel=1e-5)


def test_an_edit_is_judged_by_the_truth_where_there_is_one(moved):
    before, after, patch = moved
    columns = np.arange(64) + np.zeros_like(after.blocks.labels)
    measured = np.where((columns > 26) & (columns < 33), np.nan, after.frame.depth)
    ground_truth = np.where(after.blocks.labels == 1, 1.5, 2.4).astype(np.float32) + 0.0 * columns
    frame = ilf.RGBDFrame(after.frame.rgb, measured).with_ground_truth(ground_truth)
    before, after = (replace(run, frame=frame) for run in (before, after))
    done = before.complete(), after.complete()
    effect = summarise_edit(before, after, patch, done)
    both = done[0].filled & done[1].filled
    squares = [np.square(one.depth - frame.ground_truth)[both].astype(float) for one in done]
    assert effect.by_ground_truth == pytest.approx([np.sqrt(np.mean(square)) for square in squares], rel=1e-5)
    assert summarise_edit(before, after, patch).by_ground_truth == pytest.approx(effect.by_ground_truth, rel=1e-5), (
        "completed for it"
    )
    none = summarise_edit(*(replace(run, frame=ilf.RGBDFrame(frame.rgb, measured)) for run in moved[:2]), patch)
    assert none.by_ground_truth is None
    little = np.full_like(ground_truth, np.nan)
    little[0] = ground_truth[0]
    rarely = [replace(run, frame=frame.with_ground_truth(little)) for run in (before, after)]
    assert summarise_edit(*rarely, patch, done).by_ground_truth is None, "known at too few of the pixels"
