"""What is known of blocks goes along when they are carried to another frame."""

from dataclasses import replace

import cv2
import numpy as np
import pytest

import ilf
from ilf.data.blocks import BlockInfo
from ilf.errors import InputError
from ilf.project.frame_state import FrameState
from ilf.project.propagation import propagate_state

WALL = BlockInfo("Wall", (1, 2, 3), locked=True)
GONE = BlockInfo("Gone", (4, 5, 6))
EXTRACTION = ilf.BlockParameters(granularity=0.3)


@pytest.fixture
def before(small_frame, small_labels):
    extracted = small_labels.copy()
    extracted[:, 28:30] = 2  # block 1 has gained these by hand
    drawn = np.zeros(small_labels.shape, bool)
    drawn[:, 29:31] = True
    blocks = ilf.Blocks(
        small_labels,
        {1: WALL, 7: GONE},
        {2: {"smoothness": 3.0}},
        drawn,
        extraction=EXTRACTION,
        network="net",
        extracted=extracted,
    )
    return FrameState("before", small_frame, blocks, ilf.Parameters(s_criteria=0.002), extrapolate=True, selected=(2,))


@pytest.fixture
def after(small_frame):
    frame = replace(small_frame, name="next")
    return FrameState("after", frame, ilf.Blocks(np.zeros(frame.shape, np.int32)), note="of the user")


def test_all_that_is_known_goes_along(before, after):
    propagated = propagate_state(before, after)
    state = propagated.state
    assert propagated.followed.how == "copied"
    assert np.array_equal(state.blocks.labels, before.blocks.labels)
    assert state.blocks.infos == {1: WALL, 7: GONE}
    assert state.blocks.own == {2: {"smoothness": 3.0}}
    assert np.array_equal(state.blocks.drawn, before.blocks.drawn)
    assert (state.blocks.extraction, state.blocks.network) == (EXTRACTION, "net")
    assert (state.common, state.extrapolate, state.selected) == (before.common, True, (2,))
    assert (state.id, state.note, state.frame) == ("after", "of the user", after.frame)
    assert state.blocks.propagated_from == "two-planes"
    # made by hand there is made by hand here: another extraction keeps it
    assert state.blocks.handmade == {1}
    assert state.blocks.propagated
    assert state.blocks.edited
    edited = state.blocks.labels.copy()
    edited[0, 0] = 2
    assert not replace(state.blocks, labels=edited).propagated


def test_locked_blocks_stay_unless_they_were_carried_there(before, after):
    mine = BlockInfo("Mine", (9, 9, 9), locked=True)
    labels = np.zeros(after.blocks.labels.shape, np.int32)
    labels[:10, :10] = 2
    own = {2: {"smoothness": 0.5}}
    state = propagate_state(before, replace(after, blocks=ilf.Blocks(labels, {2: mine}, own))).state
    assert (state.blocks.labels[:10, :10] == 2).all()
    other = int(state.blocks.labels[40, 60])  # block 2 of the frame before has another number
    assert other not in (1, 2, 7)
    assert (state.blocks.infos[2], state.blocks.own[2]) == (mine, own[2])
    assert state.blocks.own[other] == {"smoothness": 3.0}
    assert 2 in state.blocks.handmade

    # nor does it get the values of a block with its number that is gone
    gone = replace(before, blocks=replace(before.blocks, own={7: {"smoothness": 3.0}}))
    locked = replace(after, blocks=ilf.Blocks(np.where(labels == 2, 7, 0).astype(np.int32), {7: mine}))
    assert propagate_state(gone, locked).state.blocks.own == {}

    propagated = propagate_state(before, after).state
    moved = replace(
        before, blocks=replace(before.blocks, labels=np.where(before.blocks.labels == 1, 2, 1).astype(np.int32))
    )
    assert np.array_equal(
        propagate_state(moved, propagated).state.blocks.labels, moved.blocks.labels
    )  # block 1, locked, had come from there
    touched = propagated.blocks.labels.copy()
    touched[:, 30:32] = 1
    kept = propagate_state(moved, replace(propagated, blocks=replace(propagated.blocks, labels=touched))).state
    assert np.array_equal(kept.blocks.labels == 1, touched == 1)


def test_blocks_that_need_a_look_say_why(before, after):
    frame = replace(after.frame, rgb=np.full_like(after.frame.rgb, 90), depth=np.full(after.frame.shape, 4.0))
    state = propagate_state(before, replace(after, frame=frame), "flow").state
    assert state.to_check
    assert state.to_check <= set(np.unique(state.blocks.labels).tolist())
    assert state.blocks.reasons.keys() == state.to_check


def test_poses_beside_the_frames_are_gone_by(tmp_path):
    states = []
    for number in range(2):  # the camera moves to the left by what are three pixels on a wall at 2 m
        folder = tmp_path / str(number)
        folder.mkdir()
        left = np.arange(64) < 30 + 3 * number
        rgb = np.where(left[:, None], (200, 90, 40), (40, 110, 180)).astype(np.uint8)
        cv2.imwrite(str(folder / "rgb.png"), np.tile(rgb, (48, 1, 1)))
        cv2.imwrite(str(folder / "depth.png"), np.full((48, 64), 2000, np.uint16))
        pose = np.eye(4)
        pose[0, 3] = -0.1 * number
        np.savetxt(folder / "pose.txt", pose)
        frame = ilf.load_frame(folder / "rgb.png", folder / "depth.png", intrinsics=(60, 60, 31.5, 23.5))
        states.append(FrameState(str(number), frame, ilf.Blocks(np.zeros(frame.shape, np.int32))))
    labels = np.ones((48, 64), np.int32)
    labels[:, 30:] = 2
    propagated = propagate_state(replace(states[0], blocks=ilf.Blocks(labels)), states[1])
    assert propagated.followed.how == "pose"
    assert propagated.state.blocks.labels[24].tolist() == [1] * 33 + [2] * 31


def test_frames_of_another_size_are_refused(before, after):
    part = np.s_[:40, :50]
    frame = ilf.RGBDFrame(after.frame.rgb[part], after.frame.depth[part])
    with pytest.raises(InputError, match="same size"):
        propagate_state(before, FrameState("after", frame, ilf.Blocks(np.zeros(frame.shape, np.int32))))
