"""What simulated depth cameras make of a wall with a box before it."""

import numpy as np
import pytest
from scenes import depth_cameras, gaps, sensing
from scenes.view import SKY, View, facing

K = (290.0, 290.0, 159.5, 127.5)
SHAPE = (256, 320)


def view_of_box(flags: tuple[str, ...] = ()) -> View:
    """A box at 1.5 m before a wall at 3 m; the box has the flags."""
    box = np.zeros(SHAPE, bool)
    box[80:200, 100:180] = True
    depth = np.where(box, 1.5, 3.0).astype(np.float32)
    normals = np.broadcast_to(np.array([0, 0, -1], np.float32), (*SHAPE, 3))
    shade = np.where(box, 0.7, 0.4).astype(np.float32)
    marked = {name: box & (name in flags) for name in ("black", "glossy", "transparent", "emitting")}
    return View(depth, normals, facing(normals, K), shade, marked, np.roll(box, -10, axis=1) & ~box)


def sensed(view: View, seed: int) -> np.ndarray:
    rgb = np.repeat((255 * view.shade).astype(np.uint8)[..., None], 3, axis=2)
    exact = np.where(view.depth < SKY, view.depth, np.nan)
    rng = np.random.default_rng(seed)
    return sensing.sense(exact, view.normals, rgb, view.flags, exact + 1, view.unlit, K, rng)


def test_what_is_measured_is_near_the_truth_and_some_of_it_is_missing():
    view = view_of_box()
    for seed in range(12):
        measured = sensed(view, seed)
        assert measured.dtype == np.float32
        known = np.isfinite(measured)
        assert 0.5 < known.mean() < 1
        off = np.abs(measured - view.depth)[known] / view.depth[known]
        assert np.median(off) < 0.05
    assert np.array_equal(sensed(view, 3), sensed(view, 3), equal_nan=True)
    assert not np.array_equal(sensed(view, 3), sensed(view, 4), equal_nan=True)


def test_sensing_leaves_the_scene_as_it_is():
    view = view_of_box(("glossy", "transparent"))
    exact = np.where(view.unlit, np.nan, view.depth).astype(np.float32)
    rgb = np.repeat((255 * view.shade).astype(np.uint8)[..., None], 3, axis=2)
    behind = exact + 1
    given = [exact, view.normals, rgb, *view.flags.values(), behind, view.unlit]
    before = [array.copy() for array in given]
    for seed in range(8):
        sensing.sense(exact, view.normals, rgb, view.flags, behind, view.unlit, K, np.random.default_rng(seed))
    assert all(np.array_equal(a, b, equal_nan=a.dtype.kind == "f") for a, b in zip(given, before, strict=True))


def test_sky_is_never_measured():
    view = view_of_box()
    view.depth[:60] = SKY
    assert all(np.isnan(sensed(view, seed)[:50]).mean() > 0.97 for seed in range(8))


def test_glass_is_lost_or_looked_through():
    view = view_of_box(("transparent",))
    box = view.flags["transparent"]
    seen = [sensed(view, seed)[box] for seed in range(12)]
    assert any(np.isnan(one).mean() > 0.9 for one in seen)
    assert any(np.nanmedian(one) > 2 for one in seen if np.isfinite(one).any())


def test_structured_light_steps_grow_with_the_square_of_the_depth():
    view = view_of_box()
    depth, _ = depth_cameras.structured_light(view, np.random.default_rng(5))
    levels = np.unique(1 / depth)
    steps = np.diff(levels)
    assert np.allclose(steps / steps.min(), np.round(steps / steps.min()), atol=0.05)
    assert levels.size < 200


def test_the_colour_camera_sees_more_on_the_other_side_of_what_is_near():
    for seed in range(4):
        row = np.flatnonzero(gaps.parallax(view_of_box(), np.random.default_rng(seed))[140])
        beside = row[row < 300]
        assert beside.size == 0 or (beside.min() == 180 and beside.max() < 186)


@pytest.mark.parametrize(("shift", "columns"), [(30.0, range(91, 100)), (-30.0, range(180, 189))])
def test_the_second_camera_sees_less_beside_what_is_near(shift, columns):
    hidden = gaps.hidden_from_second(view_of_box(), shift)
    row = np.flatnonzero(hidden[140])
    strip = range(10) if shift > 0 else range(310, 320)
    assert row.tolist() == sorted([*strip, *columns])
    assert hidden.any(axis=1).all()
