"""Key frames: they are the depth of that iteration, cost no more than the budget, and go in order."""

import numpy as np
import pytest

import ilf
from ilf.completion.block import block_depth
from ilf.run.key_frames import KeyFrames, depth_at_key_frames
from ilf.segmentation.editing.patches import border_pixels


def recorded(run, key_frames, threads=1):
    """Run it; the records of every block."""
    records = {}
    with run.steps(threads, key_frames.watch(run)) as steps:
        for progress in steps:
            if progress.record is not None:
                records.setdefault(progress.label, []).append(progress.record)
    return records


@pytest.mark.parametrize("name", ["best", "paper", "released-code"])
@pytest.mark.parametrize("mode", ["fill", "fill+denoise"])
@pytest.mark.parametrize("by_hand", [False, True])
def test_a_key_frame_is_the_depth_as_it_was_then(small_frame, small_labels, name, mode, by_hand):
    drawn = border_pixels(small_labels) if by_hand else None
    parameters = ilf.preset(name, max_iterations=30, mode=mode)
    key_frames = KeyFrames()
    blocks = ilf.Blocks(small_labels, drawn=drawn)
    records = recorded(ilf.Run(small_frame, blocks, parameters), key_frames)
    tracks = [track for track in map(key_frames.track, records.values()) if track is not None]
    steppers = [ilf.iterate(small_frame, blocks, track.block.label, parameters) for track in tracks]
    for i in range(1, 20):
        expected = small_frame.depth.copy()
        for track, stepper in zip(tracks, steppers, strict=True):
            next(stepper, None)
            depth = block_depth(small_frame, track.block, stepper.surface, parameters)
            expected[track.block.box][track.block.mask] = depth
        past = depth_at_key_frames(small_frame.depth, [(track, track.at(i)) for track in tracks])
        np.testing.assert_array_equal(past, expected)


def test_the_records_say_which_key_frames_are_theirs(small_frame, small_labels):
    key_frames = KeyFrames()
    run = ilf.Run(small_frame, small_labels, ilf.preset(max_iterations=5))
    first, second = recorded(run, key_frames, threads=2), recorded(run, key_frames)
    for records in (first, second):
        track = key_frames.track(records[1])
        assert track.kept == [1, 2, 3, 4, 5]
        assert track.at(3).record is records[1][2]
        assert track.at(99).record is records[1][-1]
        assert track.at(0).record is records[1][0]
    assert key_frames.track([]) is None
    assert key_frames.track(first[1][1:]) is None


def test_memory_stays_within_the_budget_thinned_evenly(small_frame, small_labels):
    run = ilf.Run(small_frame, small_labels, ilf.preset("paper", max_iterations=200, stop_when_steady=False))
    whole = KeyFrames()
    recorded(run, whole)
    key_frames = KeyFrames(whole.nbytes // 5)
    records = recorded(run, key_frames)
    assert 0 < key_frames.nbytes <= key_frames.budget
    for history in records.values():
        track = key_frames.track(history)
        assert 4 <= track.stride <= 32
        assert track.kept == list(range(1, history[-1].i + 1, track.stride))


def test_what_was_run_again_goes_first(small_frame, small_labels):
    run = ilf.Run(small_frame, small_labels, ilf.preset(max_iterations=20))
    once = KeyFrames()
    recorded(run, once)
    key_frames = KeyFrames(round(1.6 * once.nbytes))
    first, second = recorded(run, key_frames), recorded(run, key_frames)
    assert any(key_frames.track(history) is None for history in first.values())
    for history in second.values():
        track = key_frames.track(history)
        assert track.stride == 1


def test_nothing_is_kept_beyond_a_hopeless_budget(small_frame, small_labels):
    key_frames = KeyFrames(1)
    records = recorded(ilf.Run(small_frame, small_labels, ilf.preset(max_iterations=20)), key_frames, threads=2)
    left = [key_frames.track(history) for history in records.values()]
    kept = [track.kept for track in left if track is not None]
    assert len(kept) == 1
    assert len(kept[0]) == 1
