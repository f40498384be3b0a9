"""`Stream`: the first frame as `ilf.complete`, the others carried, the same bits, new scenes, dropped frames."""

import threading
from dataclasses import replace

import cv2
import numpy as np
import pytest

import ilf
from ilf.stream.carrying import Offsets, carry_depth, drop_contradicted, reduced_grey
from ilf.stream.pacing import latest_of

SHAPE = (48, 80)
SHIFT = 2


def scene(seed):
    """A wide texture that the frames show parts of."""
    rng = np.random.default_rng(seed)
    return cv2.resize(rng.integers(0, 255, (16, 60, 3), dtype=np.uint8), (240, 64), interpolation=cv2.INTER_CUBIC)


def frame(number, seed=0):
    """The view after so many steps to the right along a slanted wall, with a hole that stays in its place."""
    left = SHIFT * number
    columns = np.arange(left, left + SHAPE[1], dtype=np.float32)
    depth = np.broadcast_to(2 + 0.005 * columns, SHAPE).copy()
    depth += np.random.default_rng([seed, number]).normal(0, 0.002, SHAPE).astype(np.float32)
    depth[15:35, 30:55] = np.nan
    return ilf.RGBDFrame(scene(seed)[: SHAPE[0], left : left + SHAPE[1]], depth, name=f"frame {number}")


@pytest.fixture(scope="module")
def streamed():
    with ilf.Stream() as stream:
        return [stream.complete(frame(number)) for number in range(10)], stream.statistics


def test_the_first_frame_is_completed_as_alone(streamed):
    assert np.array_equal(streamed[0][0].depth, ilf.complete(frame(0)).depth)


def test_later_frames_are_filled_as_accurately_as_alone(streamed):
    completions, statistics = streamed
    assert (statistics.frames, statistics.scenes, statistics.refreshes, statistics.dropped) == (10, 1, 2, 0)
    assert statistics.worst >= statistics.median > 0
    for number, completion in enumerate(completions):
        exact = 2 + 0.005 * (SHIFT * number + np.arange(SHAPE[1], dtype=np.float32))
        off = np.abs(completion.depth - exact)[completion.filled]
        assert completion.filled.sum() == 500
        assert np.mean(off) < 0.004
        assert np.array_equal(completion.depth[completion.frame.known], completion.frame.depth[completion.frame.known])


def test_the_same_frames_give_the_same_bits(streamed):
    with ilf.Stream(threads=1) as again:
        for number, completion in enumerate(streamed[0][:5]):
            assert np.array_equal(again.complete(frame(number)).depth, completion.depth)


def test_blocks_move_with_the_camera():
    """A step of depth in the world, seen ever farther to the left."""
    step, last = 50, 6

    def seen(number):
        columns = SHIFT * number + np.arange(SHAPE[1])
        depth = np.broadcast_to(np.where(columns < step, 1.5, 2.5), SHAPE).copy()
        depth[20:26, 5:10] = np.nan
        return ilf.RGBDFrame(frame(number).rgb, depth)

    with ilf.Stream(correction=False) as stream:
        labels = [stream.complete(seen(number)).run.blocks.labels for number in range(last + 1)]
    behind = np.unique(labels[0][:, step + 2 :])
    assert not np.isin(labels[0][:, : step - 2], behind).any()
    assert np.isin(labels[last][:, step - SHIFT * last + 2 :], behind).mean() > 0.95


def test_a_new_correction_fades_in(monkeypatch):
    monkeypatch.setattr("ilf.stream.stream._REFRESH", 2)
    shares = iter((0.1, 0.2, 0.4, 0.8))
    monkeypatch.setattr("ilf.stream.stream.change_of", lambda *_: (np.full(SHAPE, next(shares), np.float32), ()))
    changes = []
    monkeypatch.setattr("ilf.stream.stream.applied_change", lambda values, _: changes.append(values.mean()) or values)
    with ilf.Stream() as stream:
        for _ in range(8):
            stream.complete(frame(0))
    assert np.allclose(changes, [0.1, 0.1, 0.1, 0.15, 0.2, 0.3, 0.4, 0.6])  # new ones in frames 2, 4 and 6


def test_a_new_scene_starts_anew_and_says_so():
    with ilf.Stream() as stream:
        stream.complete(frame(0))
        stream.complete(frame(1))
        other = stream.complete(frame(0, seed=1))
        assert stream.statistics.scenes == 2
    assert other.notes == ("The scene has changed: the stream starts anew with frame 0.",)
    assert np.array_equal(other.depth, ilf.complete(frame(0, seed=1)).depth)


def test_a_block_whose_depth_is_lost_keeps_that_of_the_frame_before():
    before, after = frame(0), frame(1)
    lost = after.depth.copy()
    lost[:, 10:] = np.nan
    with ilf.Stream(min_known_share=0.5) as stream:
        stream.complete(before)
        completion = stream.complete(ilf.RGBDFrame(after.rgb, lost))
    exact = 2 + 0.005 * (SHIFT + np.arange(SHAPE[1], dtype=np.float32))
    assert np.isfinite(completion.depth[5:-5, 10:70]).all()
    assert np.abs(completion.depth - exact)[5:-5, 10:70].mean() < 0.02
    assert any("frame before" in outcome.message for outcome in completion.outcomes.values())
    assert np.isfinite(ilf.expected_error(completion)[completion.filled]).all()


def test_another_size_and_another_distance_are_new_scenes():
    first = frame(0)
    small = ilf.RGBDFrame(first.rgb[:40], first.depth[:40])
    far = np.where(np.arange(SHAPE[1]) % 20 < 10, 3 * first.depth, first.depth)
    with ilf.Stream() as stream:
        for one in (first, small, first, replace(first, depth=far)):
            stream.complete(one)
        assert stream.statistics.scenes == 4


def test_with_a_rate_blocks_are_found_in_the_thread():
    with ilf.Stream(rate=1000) as stream:
        depths = [stream.complete(frame(number % 3)).depth for number in range(30)]
        assert stream.statistics.refreshes >= 2
        assert stream.statistics.late > 0  # none takes less than a millisecond
    assert all(np.isfinite(depth).all() for depth in depths)
    with pytest.raises(ilf.IlfError, match="closed"):
        stream.complete(frame(0))


def test_other_presets_are_streamed_too():
    with ilf.Stream("paper", max_iterations=20) as stream:
        for number in range(2):
            assert np.isfinite(stream.complete(frame(number)).depth).all()
    with pytest.raises(ilf.IlfError, match="rate"):
        ilf.Stream(rate=0)
    with pytest.raises(ilf.IlfError, match="threads"):
        ilf.Stream(threads=0)


def test_only_the_latest_of_waiting_frames_is_taken():
    first_taken, all_given = threading.Event(), threading.Event()

    def frames():
        yield 0
        first_taken.wait()
        yield from (1, 2, 3)
        all_given.set()

    taken = latest_of(frames(), lambda: 1e9)
    assert next(taken) == (0, 0)
    first_taken.set()
    all_given.wait()
    assert list(taken) == [(3, 2)]


def test_an_error_of_the_source_reaches_the_consumer():
    def frames():
        yield frame(0)
        raise ilf.IlfError("The camera was unplugged.")

    with ilf.Stream(rate=1000) as stream:
        played = stream.play(frames())
        assert next(played).frame.name == "frame 0"
        with pytest.raises(ilf.IlfError, match="unplugged"):
            next(played)


def test_depth_is_carried_as_the_camera_moves_it():
    before = frame(0)
    moved = np.where(np.isfinite(frame(1).depth), frame(1).depth - 0.1, np.nan)  # 10 cm towards the wall
    moved[:10, :20] = 1.0  # something that came into view
    after = ilf.RGBDFrame(frame(1).rgb, moved)
    step = Offsets.between(reduced_grey(after), reduced_grey(before), SHAPE)
    exact = np.broadcast_to(2 + 0.005 * np.arange(SHAPE[1], dtype=np.float32), SHAPE)
    expected = carry_depth(exact.copy(), step, after)
    inner = np.s_[5:-5, 8:-8]
    off = expected[inner] - (exact[inner] + 0.005 * SHIFT - 0.1)
    assert np.nanmax(np.abs(off)) < 0.005
    assert np.isfinite(expected[inner]).mean() > 0.95


@pytest.mark.parametrize("noise", [0.0, 0.03])
def test_carried_depth_is_dropped_where_known_depth_nearby_contradicts_it(noise):
    rng = np.random.default_rng(1)
    carried = np.full((96, 160), 3.0, np.float32)
    depth = (3.0 * (1 + noise * rng.standard_normal(carried.shape))).astype(np.float32)
    depth[:, :60] *= 0.7  # something has come into view
    depth[40:56, 20:36] = depth[40:56, 110:126] = np.nan
    drop_contradicted(carried, depth)
    assert np.isnan(carried[40:56, 20:36]).all()
    assert np.isfinite(carried[:, 75:]).all()


def test_carried_depth_stays_where_nothing_nearby_is_known():
    carried, depth = (np.full((96, 160), 3.0, np.float32) for _ in range(2))
    depth[:, 20:] = np.nan
    drop_contradicted(carried, depth)
    assert np.isfinite(carried).all()


def test_a_sparse_frame_gets_both_corrections_as_alone():
    rng = np.random.default_rng(2)
    rgb = cv2.resize(scene(3)[:, :80], (160, 120), interpolation=cv2.INTER_LINEAR)
    depth = np.broadcast_to(np.linspace(1.5, 3.0, 160, dtype=np.float32), (120, 160)).copy()
    depth[rng.random(depth.shape) > 0.01] = np.nan
    sparse = ilf.RGBDFrame(rgb, depth)
    with ilf.Stream() as stream:
        assert np.allclose(stream.complete(sparse).depth, ilf.complete(sparse).depth, rtol=1e-5, equal_nan=True)
