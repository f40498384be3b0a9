"""Blocks that follow to the next frame: what holds for any pictures, and what is exact."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import ilf
from ilf.data.blocks import labels_in
from ilf.errors import InputError
from ilf.segmentation.propagation.motion import parts_of
from ilf.segmentation.propagation.propagate import follow

_SHAPE = (96, 128)
_QUICK = ilf.BlockParameters(detector="canny", min_size=1.0)
_CAMERA = ilf.Camera(120.0, 114.0, 61.2, 49.1)


def _scene(height: int = 160, width: int = 200, seed: int = 3) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Colour with texture, depth and labels of four surfaces, one of them a bar in front."""
    rng = np.random.default_rng(seed)
    rows, columns = np.mgrid[:height, :width]
    labels = np.where(rows < height // 2, 1, 2) + np.where(columns > width // 2, 2, 0)
    labels[40:120, 60:80] = 7
    base = np.array(
        [[0, 0, 0], [60, 70, 160], [190, 170, 90], [80, 150, 80], [200, 90, 80], [0] * 3, [0] * 3, [240] * 3]
    )
    coarse = np.kron(rng.normal(0, 14, (height // 4, width // 4)), np.ones((4, 4)))
    rgb = np.clip(base[labels] + coarse[..., None], 0, 255).astype(np.uint8)
    depth = np.array([0, 2.0, 2.2, 2.4, 2.6, 0, 0, 1.2])[labels].astype(np.float32)
    return rgb, depth, labels.astype(np.int32)


def _view(top: int, left: int, **options: object) -> tuple[ilf.RGBDFrame, np.ndarray]:
    """A frame cut out of the scene, and its labels."""
    rgb, depth, labels = _scene()
    cut = slice(top, top + _SHAPE[0]), slice(left, left + _SHAPE[1])
    return ilf.RGBDFrame(rgb[cut], depth[cut], **options), labels[cut].copy()


def test_the_same_camera_position_copies_bit_for_bit_also_through_noise():
    before, labels = _view(30, 30)
    labels[5:7, 5:9] = 0
    drawn = np.zeros(_SHAPE, bool)
    drawn[20, 20:40] = True
    rng = np.random.default_rng(0)
    noisy = np.clip(before.rgb + rng.normal(0, 2, before.rgb.shape), 0, 255).astype(np.uint8)
    holes = np.where(rng.random(_SHAPE) < 0.1, np.nan, before.depth + rng.normal(0, 0.004, _SHAPE))
    found = follow(before, labels, ilf.RGBDFrame(noisy, holes), drawn=drawn, extraction=_QUICK)
    assert found.how == "copied"
    np.testing.assert_array_equal(found.labels, labels)
    np.testing.assert_array_equal(found.drawn, drawn)
    assert not found.reasons
    assert found.labels is not labels, "nobody shares what is edited"


@settings(max_examples=12, deadline=None)
@given(down=st.integers(-12, 12), right=st.integers(-12, 12))
def test_a_shift_carries_every_block_to_its_place(down, right):
    before, labels = _view(30, 30)
    after, ground_truth = _view(30 + down, 30 + right)
    found = follow(before, labels, after, how="flow", extraction=_QUICK)
    new = labels_in(found.labels) - labels_in(labels)
    assert new <= found.reasons.keys() <= labels_in(found.labels)
    assert all("not in the previous frame" in found.reasons[label] for label in new), "no labels out of nothing"
    inside = np.zeros(_SHAPE, bool)
    inside[max(0, -down) + 2 : _SHAPE[0] - max(0, down) - 2, max(0, -right) + 2 : _SHAPE[1] - max(0, right) - 2] = True
    wrong = (found.labels != ground_truth) & inside
    assert wrong.mean() <= 0.004, "the borders' pixels at most"


def test_a_pose_is_exact_on_planes_without_any_detail():
    grey = np.full((*_SHAPE, 3), 128, np.uint8)
    depth = np.full(_SHAPE, 2.0)
    depth[:, 70:] = 3.0
    labels = np.where(np.arange(128)[None] < 70, 5, 9) * np.ones(_SHAPE, np.int32)
    labels[30:60, 20:40] = 6
    # 0.1 m to the left: points move to the right, the nearer ones by 6 px, the others by 4; all 3 px down in the image
    lower = ilf.Camera(120.0, 114.0, 61.2, 52.1)
    pose = np.eye(4)
    pose[0, 3] = 0.1
    after = np.full(_SHAPE, 2.0)
    after[:, 76:] = 3.0
    frames = ilf.RGBDFrame(grey, depth, _CAMERA), ilf.RGBDFrame(grey, after, lower)
    found = follow(frames[0], labels.astype(np.int32), frames[1], pose=pose, extraction=_QUICK)
    assert found.how == "pose"
    ground_truth = np.where(np.arange(128)[None] < 76, 5, 9) * np.ones(_SHAPE, np.int32)
    ground_truth[33:63, 26:46] = 6
    np.testing.assert_array_equal(found.labels[3:, 6:], ground_truth[3:, 6:])
    assert follow(frames[0], labels.astype(np.int32), frames[1], how="flow", pose=pose, extraction=_QUICK).how == "flow"


def test_a_pose_that_the_pictures_contradict_is_left_aside():
    (before, labels), (after, ground_truth) = (_view(30, left, intrinsics=_CAMERA) for left in (30, 36))
    flat = np.full(_SHAPE, 2.0)
    frames = ilf.RGBDFrame(before.rgb, flat, _CAMERA), ilf.RGBDFrame(after.rgb, flat, _CAMERA)
    pose = np.eye(4)
    pose[0, 3] = -0.1
    right = follow(frames[0], labels, frames[1], pose=pose, extraction=_QUICK)
    assert (right.how, right.notes) == ("pose", ())
    for wrong in (np.linalg.inv(pose), np.diag([1.0, 1, 1, 1]) + 1000 * (pose - np.eye(4))):
        found = follow(frames[0], labels, frames[1], pose=wrong, extraction=_QUICK)
        assert found.how == "flow"
        assert "does not fit the images" in found.notes[0]
        assert (found.labels != ground_truth)[:, :-8].mean() < 0.01
        assert follow(frames[0], labels, frames[1], how="pose", pose=wrong, extraction=_QUICK).how == "pose"


def test_what_comes_into_the_picture_has_a_new_number_and_what_leaves_is_gone():
    rgb, depth, labels = (
        np.ascontiguousarray(np.pad(one[:96, :128], ((0, 0), (0, 40), (0, 0))[: one.ndim], "edge")) for one in _scene()
    )
    rng = np.random.default_rng(5)
    rgb[:, 128:] = np.clip(np.array([250, 250, 20]) + rng.normal(0, 3, (96, 40, 1)), 0, 255)
    depth[:, 128:] = 0.8
    labels[:, :6] = 11
    rgb[:, :6] = 0
    before = ilf.RGBDFrame(rgb[:, :128], depth[:, :128])
    after = ilf.RGBDFrame(rgb[:, 40:], depth[:, 40:])
    found = follow(before, labels[:, :128], after, how="flow", extraction=_QUICK, taken={30})
    (new,) = labels_in(found.labels) - labels_in(labels[:, :128])
    assert new == 31, "no number of a block that is gone or forgotten"
    assert (found.labels[:, 90:] == new).mean() > 0.95
    assert 11 not in labels_in(found.labels)
    assert "not in the previous frame" in found.reasons[new]
    # small blocks of the user stay, and what is no block stays none
    holed = labels[:, :128].copy()
    holed[60:66, 100:106] = 40
    holed[70:84, 100:114] = 0
    propagated = follow(before, holed, after, how="flow", extraction=_QUICK)
    assert (propagated.labels == 40).sum() >= 20
    assert (propagated.labels[72:82, 62:72] == 0).all()


def test_something_that_moves_before_a_still_camera_leaves_the_rest_as_it_is():
    rgb, depth, labels = _scene()
    labels[50:53, 120:123] = 12  # where no edge is
    moved, behind = rgb.copy(), depth.copy()
    bar = labels == 7
    moved[bar], behind[bar] = rgb[np.roll(bar, -30, 1)], 2.0
    now = np.roll(bar, -12, 1)
    moved[now], behind[now] = rgb[bar], 1.2
    found = follow(ilf.RGBDFrame(rgb, depth), labels, ilf.RGBDFrame(moved, behind), extraction=_QUICK)
    assert found.how == "flow"
    np.testing.assert_array_equal(found.labels[:, 80:], labels[:, 80:])
    assert (found.labels[now] == 7).mean() > 0.8


def test_drawn_borders_go_along():
    before, labels = _view(30, 30)
    labels[60:75, 80:110] = 20  # against all edges
    from ilf.segmentation.editing.patches import border_pixels

    drawn = border_pixels(labels) & (labels == 20)
    after, ground_truth = _view(25, 36)
    ground_truth[65:80, 74:104] = 20
    found = follow(before, labels, after, drawn=drawn, how="flow", extraction=_QUICK)
    assert ((found.labels == 20) ^ (ground_truth == 20)).sum() <= 12
    expected = border_pixels(found.labels)
    assert not (found.drawn & ~expected).any()
    assert (found.drawn & (found.labels == 20)).sum() >= 0.9 * (expected & (found.labels == 20)).sum()
    locked = follow(before, labels, after, locked={20}, how="flow", extraction=_QUICK)
    assert ((locked.labels == 20) ^ (ground_truth == 20)).sum() <= 12
    assert locked.drawn is None


def test_fifteen_steps_leave_no_crumbs_and_pictures_of_other_places_are_extracted_anew():
    before, labels = _view(30, 10)
    start = labels
    for step in range(1, 16):
        after, ground_truth = _view(30 + step % 3, 10 + 3 * step)
        found = follow(before, labels, after, how="flow", extraction=_QUICK, taken=set(range(20)))
        before, labels = after, found.labels
    assert (labels == ground_truth).mean() > 0.97
    assert np.bincount(parts_of(labels).map.ravel())[1:].min() >= 20
    rng = np.random.default_rng(1)
    other = ilf.RGBDFrame(rng.integers(0, 255, (*_SHAPE, 3)).astype(np.uint8), np.full(_SHAPE, 1.0))
    lost = follow(before, start, other, extraction=_QUICK)
    assert lost.reasons.keys() == set(np.unique(lost.labels).tolist()) - {0}
    assert "extracted again" in lost.notes[0]


def test_what_cannot_be_carried_is_said():
    before, labels = _view(30, 30)
    smaller = ilf.RGBDFrame(before.rgb[::2, ::2], before.depth[::2, ::2])
    for changes, message in (
        ({"after": smaller}, "is 128 x 96, but the other one is 64 x 48"),
        ({"how": "guess"}, "Select one of auto"),
        ({"how": "pose"}, "4 x 4"),
        ({"pose": np.diag([2.0, 2.0, 2.0, 1.0])}, "rotation"),
        ({"how": "pose", "pose": np.eye(4)}, "intrinsics of both"),
        ({"labels": labels[:5]}, "label map"),
    ):
        with pytest.raises(InputError, match=message):
            follow(**{"before": before, "labels": labels, "after": before} | changes)


def test_without_depth_in_common_and_in_tiny_pictures_blocks_follow_all_the_same():
    before, labels = _view(30, 30)
    after, ground_truth = _view(30, 34)
    bare = np.full(_SHAPE, np.nan)
    bare[0, 0] = 2.0
    found = follow(ilf.RGBDFrame(before.rgb, bare), labels, ilf.RGBDFrame(after.rgb, bare), extraction=_QUICK)
    assert (found.labels == ground_truth)[:, :-4].mean() > 0.99
    small = slice(40, 52), slice(20, 36)
    tiny = ilf.RGBDFrame(before.rgb[small], before.depth[small]), ilf.RGBDFrame(after.rgb[small], after.depth[small])
    assert follow(tiny[0], labels[small], tiny[1], extraction=_QUICK).labels.shape == (12, 16)
    empty = follow(before, np.zeros(_SHAPE, np.int32), after, how="flow", extraction=_QUICK)
    assert labels_in(empty.labels) <= empty.reasons.keys()
