"""Depth of neighbours in a frame's view: geometry, occlusion, what has moved, odometry."""

from dataclasses import replace

import numpy as np
import pytest

import ilf
from ilf.data.neighbours import AGREEMENT, NeighbourDepth
from ilf.errors import InputError
from ilf.sources.neighbours import odometry, seen_by

from ..small_sequences import CAMERA, SHAPE, exact_view, pose_of, sequence, write_sequence

HOLE = np.s_[26:38, 20:36]
"""The hole of frame 2."""


def test_projected_depth_is_that_of_a_plane_by_its_formula():
    rows, columns = np.indices(SHAPE)
    rays = CAMERA.points(columns, rows, np.ones(SHAPE))
    normal, offset = np.array([0.2, -0.1, 1.0]), 2.0  # n . p = d in the other camera
    grey = np.full((*SHAPE, 3), 120, np.uint8)
    other = ilf.RGBDFrame(grey, offset / (rays @ normal), CAMERA)
    motion = np.linalg.inv(pose_of(3)) @ pose_of(0)
    turned = motion[:3, :3] @ normal
    expected = (offset + turned @ motion[:3, 3]) / (rays @ turned)
    found = seen_by(other, other, motion)
    known = np.isfinite(found)
    assert known.mean() > 0.85
    # the sample nearest to a pixel's centre is up to half a pixel away
    step = max(np.abs(np.diff(expected, axis=axis)).max() for axis in (0, 1))
    assert np.abs(found - expected)[known].max() <= step
    assert abs(np.mean((found - expected)[known])) < 0.1 * step


def test_neighbours_err_as_far_as_they_differ_where_the_frame_has_measured_too():
    depth = np.full((20, 20), 2.0, np.float32)
    neighbours = NeighbourDepth(np.full((1, 20, 20), 2.01, np.float32), ())
    assert neighbours.relative_error(depth) == pytest.approx(0.005, rel=1e-3)
    depth.ravel()[99:] = np.nan
    assert neighbours.relative_error(depth) == AGREEMENT, "too few pixels to tell"


def test_neighbours_fill_a_hole_with_what_they_have_measured():
    frames = sequence()
    frame = ilf.with_neighbours(frames[2], frames[1::-1], frames[3:])
    _, exact = exact_view(pose_of(2))
    assert frame.from_neighbours is not None
    assert frame.from_neighbours[HOLE].mean() > 0.95
    assert not frame.from_neighbours.sum() > 12 * 16
    assert np.abs(frame.depth - exact)[frame.from_neighbours].max() < 0.02
    np.testing.assert_array_equal(frame.measured, frames[2].measured)
    np.testing.assert_array_equal(frame.own_depth, frames[2].depth)
    np.testing.assert_array_equal(frame.missing, frames[2].missing)
    assert frame.notes[-1].startswith("Depth of 4 neighbours is used at 1")
    assert frame.with_neighbours(None).from_neighbours is None


def test_completed_depth_follows_neighbours_but_they_do_not_count_as_measured():
    frames = sequence()
    _, exact = exact_view(pose_of(2))
    exact = exact + np.float32(0.15) * _bump()  # a bump in the hole, which the frame alone cannot know
    others = [_with_bump(frame, number) for number, frame in enumerate(frames)]
    frame = replace(others[2], depth=np.where(frames[2].known, others[2].depth, np.nan))
    blocks = np.ones(SHAPE, np.int32)
    alone = ilf.complete(frame, blocks)
    helped = ilf.complete(ilf.with_neighbours(frame, others[1:2], others[3:4]), blocks)
    errors = [np.abs(done.depth - exact)[HOLE].mean() for done in (alone, helped)]
    assert errors[1] < 0.3 * errors[0]
    np.testing.assert_array_equal(helped.filled, alone.filled)
    assert helped.from_neighbours.any()
    assert "measured by neighbours" in helped.summary()
    error = ilf.expected_error(helped)
    assert np.isfinite(error[helped.filled]).all()
    assert np.isnan(error[frame.known]).all()
    share = error[helped.from_neighbours] / helped.depth[helped.from_neighbours]
    np.testing.assert_allclose(share, share[0], rtol=1e-5)


def test_neighbours_that_contradict_each_other_or_the_depth_around_are_left_out():
    depth = np.full(SHAPE, 2.0, np.float32)
    depth[HOLE] = np.nan
    same, farther = np.full((2, *SHAPE), 2.0, np.float32)
    farther[HOLE] = 2.2
    assert np.isnan(NeighbourDepth(np.stack([same, farther]), ()).fused(depth)[HOLE]).all()
    shifted = np.full((1, *SHAPE), 2.1, np.float32)
    assert np.isnan(NeighbourDepth(shifted, ()).fused(depth)[32, 22])


def test_neighbours_do_not_bring_back_invalid_depth():
    frames, mask = sequence(), np.zeros(SHAPE, bool)
    mask[40:50, 60:70] = True
    frame = ilf.with_neighbours(frames[2].with_invalid_mask(mask), frames[1::-1], frames[3:])
    assert frame.from_neighbours[HOLE].any()
    assert not frame.from_neighbours[mask].any()
    wrong = frames[2].measured.copy()
    wrong[mask] = 1.2  # as of glare: the neighbours know better
    better = ilf.with_neighbours(replace(frames[2], depth=wrong).with_invalid_mask(mask), frames[1::-1], frames[3:])
    assert better.from_neighbours[mask].mean() > 0.9


def test_motion_without_poses_is_linked_by_odometry():
    frames = [replace(frame, pose=None) for frame in sequence()]
    frame = ilf.with_neighbours(frames[2], frames[1::-1], frames[3:], step=2)
    assert frame.neighbours is not None
    assert [one.name for one in frame.neighbours.neighbours] == ["frame 0", "frame 4"]
    true = np.linalg.inv(pose_of(2)) @ pose_of(4)
    assert np.abs(np.array(frame.neighbours.neighbours[1].motion) - true).max() < 0.02
    _, exact = exact_view(pose_of(2))
    assert np.abs(frame.depth - exact)[frame.from_neighbours].max() < 0.03


def test_odometry_between_frames_of_different_places_is_refused():
    rng = np.random.default_rng(0)
    rubbish = ilf.RGBDFrame(rng.integers(0, 255, (*SHAPE, 3), np.uint8), rng.uniform(1, 4, SHAPE), CAMERA, "rubbish")
    frame = replace(sequence(1)[0], pose=None)
    assert odometry(rubbish, frame) is None
    alone = ilf.with_neighbours(frame, [rubbish])
    assert alone.neighbours is None
    assert alone.notes[-1] == (
        "Depth of 0 neighbours is used at 0 pixels (0% of the missing ones). Left out, because depth does not agree or "
        "the camera's motion is not known: rubbish."
    )


def test_wrong_poses_and_damaged_files_are_refused_by_name(tmp_path):
    source = ilf.open_source(write_sequence(tmp_path), intrinsics=CAMERA)
    np.savetxt(tmp_path / "frame-000001.pose.txt", pose_of(20))
    (tmp_path / "frame-000003.depth.png").write_bytes(b"no image")
    frame = source.read(source.keys[2], neighbours=2)
    assert [one.name for one in frame.neighbours.neighbours] == ["frame-000000.color", "frame-000004.color"]
    assert frame.notes[-1].endswith("not known: frame-000001.color, frame-000003.color.")


def test_a_frame_without_intrinsics_cannot_have_neighbours():
    frames = [replace(frame, intrinsics=None) for frame in sequence(2)]
    with pytest.raises(InputError, match="intrinsics of frame 0 are not known"):
        ilf.with_neighbours(frames[0], [frames[1]])


def _bump() -> np.ndarray:
    rows, columns = np.indices(SHAPE)
    return np.exp(-((rows - 31.5) ** 2 + (columns - 27.5) ** 2) / 18).astype(np.float32)


def _with_bump(frame: ilf.RGBDFrame, number: int) -> ilf.RGBDFrame:
    """The frame with a bump at the place in the world that frame 2 has in the middle of its hole."""
    rows, columns = np.indices(SHAPE)
    _, exact = exact_view(pose_of(number))
    motion = np.linalg.inv(pose_of(2)) @ pose_of(number)
    points = CAMERA.points(columns, rows, exact) @ motion[:3, :3].T + motion[:3, 3]
    x, y = (CAMERA.fx * points[..., axis] / points[..., 2] + (CAMERA.cx, CAMERA.cy)[axis] for axis in (0, 1))
    bump = np.exp(-((y - 31.5) ** 2 + (x - 27.5) ** 2) / 18)
    return replace(frame, depth=exact + 0.15 * bump)
