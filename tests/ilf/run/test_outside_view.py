"""What lies outside the depth camera's view: left missing unless asked for, and counted apart everywhere."""

from dataclasses import replace

import cv2
import numpy as np
import pytest

import ilf
from ilf.data.results import Status
from ilf.errors import InputError
from ilf.evaluation.hold_out import frame_without
from ilf.project.frame_state import FrameState
from ilf.project.state_codec import Known, encode, load_state
from ilf.run.options import ExportOptions
from ilf.run.record import make_record, read_record, to_json

from ..project.test_codec import Held

SHAPE = H, W = 24, 40
OUTSIDE = np.zeros(SHAPE, bool)
OUTSIDE[:, 34:] = True
HOLE = np.zeros(SHAPE, bool)
HOLE[8:14, 10:20] = True
BLOCKS = np.ones(SHAPE, np.int32)
QUICK = ilf.preset(correction=False)


def made(**changes):
    depth = 2.0 + 0.01 * np.indices(SHAPE)[1]
    values = {"ground_truth": depth, "outside_view": OUTSIDE} | changes
    return ilf.RGBDFrame(np.full((*SHAPE, 3), 90, np.uint8), np.where(HOLE | OUTSIDE, np.nan, depth), **values)


@pytest.fixture
def frame():
    return made()


def test_only_missing_pixels_lie_outside(frame):
    np.testing.assert_array_equal(made(outside_view=np.ones(SHAPE, bool)).outside_view, OUTSIDE | HOLE)
    assert made(outside_view=~(OUTSIDE | HOLE)).outside_view is None
    np.testing.assert_array_equal(frame.missing, HOLE)
    assert frame.missing_share == pytest.approx(HOLE.mean())
    assert frame.outside_share == pytest.approx(OUTSIDE.mean())
    with pytest.raises(InputError, match="outside the view"):
        made(outside_view=np.ones((2, 2), bool))


def test_other_frames_made_of_it_keep_it(frame):
    wrong = np.zeros(SHAPE, bool)
    wrong[:, 5] = wrong[:, 36] = True
    with_invalid_mask = frame.with_invalid_mask(wrong)
    np.testing.assert_array_equal(with_invalid_mask.outside_view, OUTSIDE)
    np.testing.assert_array_equal(with_invalid_mask.missing, HOLE | (wrong & ~OUTSIDE))
    for other in (replace(frame, name="b"), frame.with_ground_truth(None), frame.with_guide(frame.ground_truth)):
        np.testing.assert_array_equal(other.outside_view, OUTSIDE)
    np.testing.assert_array_equal(frame_without(frame, "random").outside_view, OUTSIDE)


@pytest.mark.parametrize("parameters", [QUICK, ilf.preset("paper"), QUICK.replace(mode="fill+denoise"), ilf.preset()])
def test_it_stays_missing_unless_it_is_asked_for(frame, parameters):
    left = ilf.complete(frame, BLOCKS, parameters)
    asked = ilf.complete(frame, BLOCKS, parameters.replace(outside_view=True))
    assert np.isnan(left.depth[OUTSIDE]).all()
    assert np.isfinite(asked.depth).all()
    np.testing.assert_array_equal(left.depth[~OUTSIDE], asked.depth[~OUTSIDE])
    np.testing.assert_array_equal(left.filled, HOLE)
    for completion, words in ((left, "left missing"), (asked, "filled, although not measurable")):
        outcome = completion.outcomes[1]
        assert (outcome.recovered, outcome.outside) == (HOLE.sum(), OUTSIDE.sum())
        assert outcome.defect_rate == pytest.approx(HOLE.mean())
        assert f"outside the depth camera's view {words}" in outcome.message


def test_where_only_what_is_outside_is_missing_nothing_is_done(frame):
    blocks = np.where(np.indices(SHAPE)[1] > 24, 1, 0)
    assert ilf.complete(frame, blocks, QUICK).outcomes[1].status is Status.NOTHING_MISSING
    asked = ilf.complete(frame, blocks, QUICK.replace(outside_view=True))
    assert asked.outcomes[1].status is Status.COMPLETED
    assert asked.outcomes[1].recovered == 0


def test_guesses_leave_it_missing_too(frame):
    for outside_view, wanted in ((False, HOLE), (True, HOLE | OUTSIDE)):
        nothing = ilf.complete(frame, np.zeros(SHAPE, np.int32), outside_view=outside_view)
        np.testing.assert_array_equal(ilf.extrapolate(nothing).extrapolated, wanted)
    run = ilf.Run(frame, np.zeros(SHAPE, np.int32), QUICK, extrapolate=True)
    np.testing.assert_array_equal(run.complete().extrapolated, HOLE)
    asked = replace(run, parameters=QUICK.replace(outside_view=True))
    np.testing.assert_array_equal(asked.complete().extrapolated, HOLE | OUTSIDE)


def test_a_run_writes_the_mask_and_records_what_was_left(frame, tmp_path):
    run = ilf.Run(frame, BLOCKS, QUICK)
    completion = run.complete()
    written = completion.save(tmp_path / "out", cloud=None)
    assert (tmp_path / "out" / "outside_view.png") in written.files
    mask = cv2.imread(str(tmp_path / "out" / "outside_view.png"), cv2.IMREAD_UNCHANGED)
    np.testing.assert_array_equal(mask > 0, OUTSIDE)
    record = read_record(tmp_path / "out" / "run.json")
    assert record.blocks_outcome == tuple(completion.outcomes.values())
    assert record.blocks_outcome[0].outside == OUTSIDE.sum()
    plain = make_record(replace(completion, run=replace(run, frame=made(outside_view=None))), ExportOptions())
    assert b'"outside":' in to_json(record)
    assert b'"outside":' not in to_json(replace(plain, blocks_outcome=()))


@pytest.fixture
def opened_again(frame, tmp_path):
    """The folder of a run, opened as a frame; where the camera was, only its meta.json says."""
    pose = np.array([[0, -1, 0, 1], [1, 0, 0, 2], [0, 0, 1, 3], [0, 0, 0, 1]], float)
    cv2.imwrite(str(tmp_path / "rgb.png"), frame.rgb)
    cv2.imwrite(str(tmp_path / "depth.png"), np.nan_to_num(1000 * frame.depth).astype(np.uint16))
    files = ilf.load_frame(tmp_path / "rgb.png", tmp_path / "depth.png", depth_units=1000)
    run = ilf.Run(replace(files, outside_view=OUTSIDE, pose=pose), BLOCKS, QUICK)
    run.complete().save(tmp_path / "done", cloud=None)
    assert ilf.load_frame(tmp_path / "rgb.png", tmp_path / "depth.png", depth_units=1000).pose is None
    return ilf.load_frame(tmp_path / "done"), pose


def test_a_completed_folder_is_a_frame_with_it(opened_again, tmp_path):
    completed, pose = opened_again
    np.testing.assert_array_equal(completed.outside_view, OUTSIDE)
    np.testing.assert_array_equal(completed.pose, pose)
    run = ilf.Run(completed, BLOCKS, QUICK)
    run.complete().save(tmp_path / "again", cloud=None)
    again = ilf.replay(tmp_path / "again" / "run.json")
    np.testing.assert_array_equal(again.run.frame.outside_view, OUTSIDE)
    np.testing.assert_array_equal(again.run.frame.pose, pose)
    assert make_record(again.run.complete(), again.options).outside_view == again.record.outside_view
    (tmp_path / "again" / "outside_view.png").unlink()
    with pytest.raises(InputError, match="the outside view of this run"):
        ilf.replay(tmp_path / "again" / "run.json")


def test_a_project_keeps_it_and_the_pose_of_a_frame_with_files(opened_again):
    completed, pose = opened_again
    encoded, known = encode(FrameState("a" * 32, completed, ilf.Blocks(BLOCKS))), Known()
    found = load_state("a" * 32, Held().take(encoded, "a" * 32), known=known)
    assert found.problems == ()
    np.testing.assert_array_equal(found.state.frame.outside_view, OUTSIDE)
    np.testing.assert_array_equal(found.state.frame.pose, pose)
    assert not encode(found.state, known).made
