"""Flicker: the change of depth of a point, with a camera that stands still and with one that moves."""

import numpy as np

from ilf.evaluation.flicker import flicker, moved

from ..small_sequences import CAMERA, SHAPE, exact_view, pose_of


def test_of_a_camera_that_stands_still_it_is_the_difference():
    now, before = np.float32([[2.0, np.nan, 1.0]]), np.float32([[1.75, 1.0, np.nan]])
    assert np.array_equal(flicker(now, before), np.float32([[0.25, np.nan, np.nan]]), equal_nan=True)
    assert np.array_equal(flicker(now, before, CAMERA), flicker(now, before), equal_nan=True)


def test_along_the_motion_a_scene_that_stays_has_none_and_a_change_is_found():
    (_, before), (_, now) = (exact_view(pose_of(number)) for number in (0, 4))
    motion = np.linalg.inv(pose_of(0)) @ pose_of(4)
    still = flicker(now, before, CAMERA, motion)
    assert np.nanmedian(np.abs(flicker(now, before))) > 0.01
    assert np.nanmedian(np.abs(still)) < 0.001
    assert np.nanmax(np.abs(still)) < 0.01, "at most the slope of half a pixel"
    assert still.dtype == np.float32

    raised = before.copy()
    raised[20:30, 30:40] += np.float32(0.05)
    index, _ = moved(now, CAMERA, motion)
    rows, columns = np.divmod(index, SHAPE[1])
    hit = (index >= 0) & (rows >= 20) & (rows < 30) & (columns >= 30) & (columns < 40)
    assert hit.sum() > 80
    assert np.allclose((flicker(now, raised, CAMERA, motion) - still)[hit], -0.05, atol=1e-5)
    assert np.array_equal(flicker(now, raised, CAMERA, motion)[~hit], still[~hit], equal_nan=True)


def test_what_the_other_frame_does_not_show_is_unknown():
    (_, before), (_, now) = (exact_view(pose_of(number)) for number in (0, 12))
    motion = np.linalg.inv(pose_of(0)) @ pose_of(12)
    now[:5] = np.nan
    index, _ = moved(now, CAMERA, motion)
    change = flicker(now, before, CAMERA, motion)
    assert np.array_equal(np.isnan(change), index < 0)
    assert np.isnan(change[:5]).all()
    assert 0.03 < np.mean(index[5:] < 0) < 0.5, "the camera has turned away from one side"
